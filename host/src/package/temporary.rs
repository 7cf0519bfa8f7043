//! Temporary files and folders, made beside what they become. They are removed when the command ends; those that an
//! interrupted command has left are recognized by their names.

use anyhow::{Context, Result, bail, ensure};
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
#[cfg(unix)]
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::{TempDir, TempPath};

/// What their names begin and end with.
const NAME: (&str, &str) = (".plcfmu-", ".tmp");

/// In a [`Folder`], locked by the process that uses it.
const LOCK: &str = ".lock";

/// Nothing takes as long.
const A_DAY: Duration = Duration::from_secs(86_400);

/// Makes temporary files and folders with these names.
pub fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(NAME.0).suffix(NAME.1);
    builder
}

/// Writes a file beside its place, checks it there, and renames it: at every moment there is the old file or the new one, which
/// has the old one's mode and owner. Symbolic links are followed. A device, a FIFO or a socket is written into when the file
/// is checked.
///
/// # Errors
/// The file cannot be written, or `write` or `check` fails.
pub fn place(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
    check: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    Pending::write(path, write, check)?.finish()
}

/// A file that is written and checked, and lies beside its place. Dropped, it is removed. Of several files, all can be written
/// before the first one gets its name, so that a full disk leaves none of them.
#[derive(Debug)]
pub struct Pending {
    beside: TempPath,
    path: PathBuf,
    /// What is there is no regular file: it is written into.
    is_stream: bool,
}

impl Pending {
    /// Writes a file as [`place`] does, which gets its name by [`finish`](Pending::finish).
    ///
    /// # Errors
    /// The file cannot be written, or `write` or `check` fails.
    pub fn write(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
        check: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<Pending> {
        let failed = || format!("{} cannot be written", path.display());
        let present = present(path).with_context(failed)?;
        let is_stream = present.as_ref().is_some_and(|of| !of.is_file());
        let path = if is_stream { path.to_path_buf() } else { linked(path) };
        let folder = if is_stream { std::env::temp_dir() } else { folder(&path).to_path_buf() };
        fs::create_dir_all(&folder).with_context(failed)?;
        #[cfg_attr(not(unix), expect(unused_mut))]
        let mut builder = builder();
        // As other files: the temporary ones of this crate are their owner's alone.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let (file, beside) = builder.tempfile_in(&folder).with_context(failed)?.into_parts();
        let mut writer = BufWriter::new(&file);
        write(&mut writer).with_context(failed)?;
        writer.flush().with_context(failed)?;
        drop(writer);
        if !is_stream {
            // On the disk before it gets its name.
            file.sync_all().with_context(failed)?;
        }
        check(&beside)?;
        if let Some(present) = present.filter(|_| !is_stream) {
            // Only the superuser can give a file to somebody else.
            #[cfg(unix)]
            let _ = std::os::unix::fs::fchown(&file, Some(present.uid()), Some(present.gid()));
            file.set_permissions(present.permissions()).with_context(failed)?;
        }
        Ok(Pending { beside, path, is_stream })
    }

    /// Gives the file its name, or writes what is in it into the device that has this name.
    ///
    /// # Errors
    /// The file cannot be renamed, or the device cannot be written.
    pub fn finish(self) -> Result<()> {
        let failed = || format!("{} cannot be written", self.path.display());
        if self.is_stream {
            let mut stream = OpenOptions::new().write(true).open(&self.path).with_context(failed)?;
            return io::copy(&mut File::open(&self.beside).with_context(failed)?, &mut stream)
                .map(drop)
                .with_context(failed);
        }
        let Pending { beside, path, .. } = self;
        beside.persist(&path).with_context(|| format!("{} cannot be written", path.display()))
    }
}

/// What is at `path`, or where its symbolic links lead to, if there is anything.
fn present(path: &Path) -> Result<Option<Metadata>> {
    match fs::metadata(path) {
        Ok(of) if of.is_dir() => bail!("it is a folder: name a file in it"),
        Ok(of) => Ok(Some(of)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Where the symbolic links of a path lead to, even if there is nothing yet. They form no circle: [`present`] has seen to that.
fn linked(path: &Path) -> PathBuf {
    match fs::read_link(path) {
        Ok(target) => linked(&folder(path).join(target)),
        Err(_) => path.to_path_buf(),
    }
}

/// Checks the files that a command writes, before it begins: no output is a folder, is one of the inputs, or is named twice.
/// Devices and the like may be named twice.
///
/// # Errors
/// Which output it is, and what to do.
pub fn check_outputs<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    let inputs: Vec<PathBuf> = inputs.into_iter().filter_map(|input| input.canonicalize().ok()).collect();
    let mut seen: Vec<PathBuf> = Vec::new();
    for output in outputs {
        let failed = || format!("{} cannot be written", output.display());
        if present(output).with_context(failed)?.is_some_and(|of| !of.is_file()) {
            continue;
        }
        let file = linked(output);
        let folder =
            folder(&file).canonicalize().or_else(|_| std::path::absolute(folder(&file))).with_context(failed)?;
        let file = folder.join(file.file_name().unwrap_or_default());
        // On a file system that ignores case, the name that the file has.
        let file = file.canonicalize().unwrap_or(file);
        ensure!(!inputs.contains(&file), "{} is read by this command: write to another file", output.display());
        ensure!(!seen.contains(&file), "{} is named for two outputs: name a file for each", output.display());
        seen.push(file);
    }
    Ok(())
}

/// The folder that a file lies in.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A folder for what is unpacked, removed when this is dropped.
#[derive(Debug)]
pub struct Folder {
    // Windows removes no file that is open: this goes first.
    _lock: File,
    folder: TempDir,
}

impl Folder {
    /// In the folder for temporary files of the system.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new() -> Result<Folder> {
        let make = || {
            let folder = builder().tempdir()?;
            let lock = File::create(folder.path().join(LOCK))?;
            lock.lock()?;
            io::Result::Ok(Folder { _lock: lock, folder })
        };
        make().context("there is no folder for temporary files")
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes from the system's folder for temporary files what killed commands have left: the folders whose process is gone, and
/// what is older than a day. What cannot be removed, such as that of other users, stays.
pub fn remove_forgotten() {
    remove_forgotten_in(&std::env::temp_dir());
}

fn remove_forgotten_in(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        if !is_ours(&name.to_string_lossy()) {
            continue;
        }
        let is_old = || {
            let age = entry.metadata().ok().and_then(|of| of.modified().ok()).and_then(|time| time.elapsed().ok());
            age.is_some_and(|age| age > A_DAY)
        };
        let is_forgotten = match File::open(path.join(LOCK)) {
            Ok(lock) => lock.try_lock().is_ok(),
            Err(_) => is_old(),
        };
        if is_forgotten {
            let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

/// Whether a file or folder of this name is a temporary one of this program.
fn is_ours(name: &str) -> bool {
    name.starts_with(NAME.0) && name.ends_with(NAME.1)
}

/// Removes temporary files and folders that were left in `folder`.
///
/// # Errors
/// The folder cannot be read, or one of them cannot be removed.
pub fn remove_left(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !is_ours(&name) {
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

    #[test]
    fn of_several_files_none_is_there_if_one_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let write = |number: usize| {
            let path = folder.path().join(format!("{number}.fmu"));
            // What a full disk says at the seventh file.
            Pending::write(
                &path,
                |file| match number {
                    7 => Err(io::Error::from(io::ErrorKind::StorageFull).into()),
                    _ => Ok(file.write_all(b"preset")?),
                },
                |_| Ok(()),
            )
        };
        let error = (1..=9).map(write).collect::<Result<Vec<_>>>().unwrap_err();
        assert!(error.to_string().ends_with("7.fmu cannot be written"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let pending = [1, 2].map(|number| write(number).unwrap());
        assert!(!folder.path().join("1.fmu").exists());
        pending.into_iter().for_each(|file| file.finish().unwrap());
        assert_eq!(fs::read(folder.path().join("2.fmu")).unwrap(), b"preset");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    fn put(path: &Path, content: &str) -> Result<()> {
        place(path, |file| Ok(file.write_all(content.as_bytes())?), |_| Ok(()))
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_file_keeps_its_mode() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [link, file] = ["link.csv", "data.csv"].map(|name| folder.path().join(name));
        symlink("data.csv", &link).unwrap();
        put(&link, "first").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        put(&link, "second").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "second");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let error = format!("{:#}", put(folder.path(), "text").unwrap_err());
        assert!(error.ends_with(" cannot be written: it is a folder: name a file in it"), "{error}");
    }

    #[test]
    fn an_output_is_neither_an_input_nor_another_output() {
        let folder = tempfile::tempdir().unwrap();
        let [read, written] = ["read.fmu", "written.csv"].map(|name| folder.path().join(name));
        fs::write(&read, "").unwrap();
        let check = |outputs: &[&Path]| check_outputs(outputs.iter().copied(), [&*read]);
        check(&[&written]).unwrap();
        let roundabout = folder.path().join(".").join("read.fmu");
        let error = check(&[&written, &roundabout]).unwrap_err().to_string();
        assert!(error.ends_with("read.fmu is read by this command: write to another file"), "{error}");
        let error = check(&[&written, &folder.path().join("./written.csv")]).unwrap_err().to_string();
        assert!(error.ends_with("written.csv is named for two outputs: name a file for each"), "{error}");
        check(&[&folder.path().join("missing/a.csv")]).unwrap();
    }

    #[test]
    fn what_a_killed_command_has_left_is_removed_and_nothing_else() {
        let temporary = tempfile::tempdir().unwrap();
        let made = |name: &str| {
            let path = temporary.path().join(name);
            fs::create_dir(&path).unwrap();
            path
        };
        let [left, used, new, other] = [".plcfmu-a.tmp", ".plcfmu-b.tmp", ".plcfmu-c.tmp", ".other-a.tmp"].map(made);
        fs::write(left.join(LOCK), "").unwrap();
        let lock = File::create(used.join(LOCK)).unwrap();
        lock.lock().unwrap();
        remove_forgotten_in(temporary.path());
        assert_eq!([&left, &used, &new, &other].map(|path| path.exists()), [false, true, true, true]);
    }
}
