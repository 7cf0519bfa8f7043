//! Temporary files and folders, made beside what they become. They are removed when the command ends; those that an
//! interrupted command has left are recognized by their names.

use anyhow::{Context, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// What their names begin and end with.
const NAME: (&str, &str) = (".plcfmu-", ".tmp");

/// Makes temporary files and folders with these names.
pub fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(NAME.0).suffix(NAME.1);
    builder
}

/// Writes a file beside its place, checks it there, and renames it: at every moment there is the old file or the new one.
///
/// # Errors
/// The file cannot be written, or `write` or `check` fails.
pub fn place(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
    check: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    let failed = || format!("{} cannot be written", path.display());
    let folder = folder(path);
    fs::create_dir_all(folder).with_context(failed)?;
    #[cfg_attr(not(unix), expect(unused_mut))]
    let mut builder = builder();
    // As other files: the temporary ones of this crate are their owner's alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let beside = builder.tempfile_in(folder).with_context(failed)?;
    let mut writer = BufWriter::new(beside.as_file());
    write(&mut writer).with_context(failed)?;
    writer.flush().with_context(failed)?;
    drop(writer);
    // On the disk before it gets its name.
    beside.as_file().sync_all().with_context(failed)?;
    check(beside.path())?;
    beside.persist(path).with_context(failed)?;
    Ok(())
}

/// The folder that a file lies in.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_fails_its_check_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        place(&path, |file| Ok(file.write_all(b"old")?), |_| Ok(())).unwrap();
        let error = place(
            &path,
            |file| Ok(file.write_all(b"new")?),
            |beside| {
                assert_eq!(fs::read(beside).unwrap(), b"new");
                assert_eq!(fs::read(&path).unwrap(), b"old");
                anyhow::bail!("it does not load")
            },
        );
        assert_eq!(error.unwrap_err().to_string(), "it does not load");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        place(&path, |file| Ok(file.write_all(b"new")?), |_| Ok(())).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
