//! Finds the files of a program, in particular those below a folder.

use super::workbook;
use ::program::LARGEST;
use ::program::project::{self, Kind, SOURCES, TABLES};
use anyhow::{Context, Result, bail, ensure};
use parameters::Source;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The maximum nesting depth of the folders searched.
const DEEPEST: usize = 32;

/// The maximum number of files and folders searched: a project has hundreds.
const MOST: usize = 100_000;

/// The files of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Files {
    /// The sources, in the order of their paths.
    pub sources: Vec<PathBuf>,
    /// The tag tables, in the order of their paths.
    pub tables: Vec<PathBuf>,
}

/// A file's extension in lower case.
pub(super) fn ending(file: &Path) -> String {
    file.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// The kind of a file, by its extension and its content.
fn kind(file: &Path) -> Kind {
    let content = || {
        let mut bytes = Vec::new();
        File::open(file).and_then(|file| file.take(LARGEST).read_to_end(&mut bytes)).ok()?;
        Some(bytes)
    };
    if ending(file) == "xlsx" && !content().is_some_and(|bytes| workbook::is_table(&bytes)) {
        return Kind::Other;
    }
    project::kind(&file.to_string_lossy(), || content().map(|bytes| Source::new("", bytes).text))
}

/// Whether a file is a tag table.
pub(super) fn is_table(file: &Path) -> bool {
    kind(file) == Kind::Table
}

/// Whether a file is a program source, judging by its extension; an XML file is one unless it is a tag table.
pub fn is_source(file: &Path) -> bool {
    SOURCES.contains(&ending(file).as_str()) && !is_table(file)
}

impl Files {
    /// The named files, and the program files below the named folders.
    ///
    /// # Errors
    /// A folder cannot be read, or has no program source.
    pub(super) fn new(named: &[PathBuf]) -> Result<Files> {
        let mut files = Files::default();
        for path in named {
            if !path.is_dir() {
                let list = if is_source(path) { &mut files.sources } else { &mut files.tables };
                list.push(path.clone());
                continue;
            }
            let mut found = Vec::new();
            collect(path, 0, &[&SOURCES[..], &TABLES].concat(), &mut found)?;
            found.sort();
            let found: Vec<(Kind, PathBuf)> = found.into_iter().map(|file| (kind(&file), file)).collect();
            let of = |wanted: Kind| found.iter().filter(move |(kind, _)| *kind == wanted).map(|(_, file)| file.clone());
            let sources: Vec<PathBuf> = of(Kind::Source).collect();
            ensure!(
                !sources.is_empty(),
                "{} has no program source: export one there, as .scl, .udt, .db, .s7dcl, .xml or .awl",
                path.display()
            );
            files.sources.extend(sources);
            files.tables.extend(of(Kind::Table));
        }
        Ok(files)
    }
}

/// The files with test cases below a folder.
///
/// # Errors
/// The folder cannot be read, or contains none.
pub fn test_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    collect(folder, 0, &["toml"], &mut found)?;
    found.sort();
    let has_cases = |file: &PathBuf| fs::read_to_string(file).is_ok_and(|text| text.contains("[[case]]"));
    found.retain(has_cases);
    ensure!(!found.is_empty(), "{} has no test file: a .toml with [[case]]", folder.display());
    Ok(found)
}

/// All files below a folder with one of these extensions, except links and hidden files and folders.
fn collect(folder: &Path, depth: usize, endings: &[&str], found: &mut Vec<PathBuf>) -> Result<()> {
    ensure!(depth < DEEPEST, "{} is more than {DEEPEST} folders deep", folder.display());
    let unreadable = || format!("{} cannot be read", folder.display());
    for (number, entry) in fs::read_dir(folder).with_context(unreadable)?.enumerate() {
        if number + found.len() > MOST {
            bail!("{} has more than {MOST} files: specify the folder of the program alone", folder.display());
        }
        let entry = entry.with_context(unreadable)?;
        let kind = entry.file_type().with_context(unreadable)?;
        let path = entry.path();
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        if kind.is_dir() {
            collect(&path, depth + 1, endings, found)?;
        } else if kind.is_file() && endings.contains(&ending(&path).as_str()) {
            found.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_and_tables_of_all_folders_are_found_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        for (path, text) in [
            ("b/Motor.SCL", "FUNCTION"),
            ("a/types.udt", "TYPE"),
            ("tags/PLC.xml", "<Document><SW.Tags.PlcTagTable/></Document>"),
            ("tags/other.xml", "<Document/>"),
            ("tags/list.xlsx", "no workbook"),
            ("tags/PLC.sdf", ""),
            ("readme.txt", ""),
            (".git/x.scl", "FUNCTION"),
        ] {
            write(path, text);
        }
        let files = Files::new(&[folder.path().into()]).unwrap();
        let names = |files: &[PathBuf]| -> Vec<String> {
            let relative = |file: &PathBuf| file.strip_prefix(folder.path()).unwrap().display().to_string();
            files.iter().map(|file| relative(file).replace('\\', "/")).collect()
        };
        assert_eq!(names(&files.sources), ["a/types.udt", "b/Motor.SCL"]);
        assert_eq!(names(&files.tables), ["tags/PLC.sdf", "tags/PLC.xml"]);
        let empty = folder.path().join("tags");
        assert!(Files::new(&[empty]).unwrap_err().to_string().contains("has no program source"));
    }
}
