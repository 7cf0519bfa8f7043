//! Temporary files and folders, made beside what they become. They are removed when the command ends; those that an
//! interrupted command has left are recognized by their names.

use std::fs;
use std::io;
use std::path::Path;

/// What their names begin and end with.
const NAME: (&str, &str) = (".plcfmu-", ".tmp");

/// Makes temporary files and folders with these names.
pub fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(NAME.0).suffix(NAME.1);
    builder
}

/// Removes temporary files and folders that were left in `folder`.
///
/// # Errors
/// The folder cannot be read, or one of them cannot be removed.
pub fn remove_left(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !(name.starts_with(NAME.0) && name.ends_with(NAME.1)) {
            continue;
        }
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}
