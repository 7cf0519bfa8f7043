//! Where an FMU has its reference results: the files of the layered standard fmi-ls-ref.

/// Where the layered standard has its files.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// The file that says what the reference experiment is.
pub const DESCRIPTION: &str = "documentation/fmi-ls-ref.txt";

/// Whether the file with this path in an FMU tells of the reference experiment.
pub fn is_file(path: &str) -> bool {
    path == DESCRIPTION || path.strip_prefix(FOLDER).is_some_and(|rest| rest.starts_with('/'))
}
