//! Temporary files and folders, created next to their destination. They are accessible only to their owner, regardless
//! of the umask, and are removed when the command ends, even by a signal. Each is locked while in use: leftovers of a
//! killed command are recognized by their name and released lock, and are removed by the next command.

use crate::machine::Fault;
use anyhow::{Context, Result, bail, ensure};
use std::collections::BTreeSet;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, BufWriter, Write};
#[cfg(unix)]
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::{TempDir, TempPath};

/// The prefix and the usual suffix of the names of temporary files and folders.
const NAME: (&str, &str) = (".plcfmu-", ".tmp");

/// The lock file in a [`Folder`], locked by the process that uses it.
const LOCK: &str = ".lock";

/// The age after which a leftover whose lock cannot be tested counts as abandoned.
const A_DAY: Duration = Duration::from_secs(86_400);

/// The temporary files and folders that currently belong to this process.
static PRESENT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn present_ones() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PRESENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and folders of this process. To be called just before it ends: it can no longer create
/// any.
pub fn remove_all() {
    let present = present_ones();
    present.iter().for_each(|path| remove(path));
    // Never unlocked: other threads that create or remove one block until the process ends.
    std::mem::forget(present);
}

/// An entry of [`PRESENT`], removed from it when dropped.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        present_ones().remove(&self.0);
    }
}

/// Creates a file or folder and adds it to [`PRESENT`]; [`remove_all`] cannot run in between.
fn listed<T>(make: impl FnOnce() -> io::Result<T>, path: impl FnOnce(&T) -> &Path) -> io::Result<(T, Listed)> {
    let mut present = present_ones();
    let made = make()?;
    let path = path(&made).to_path_buf();
    present.insert(path.clone());
    Ok((made, Listed(path)))
}

/// Creates a temporary file with this mode, masked by the umask, if the system has modes.
fn new_file(folder: &Path, suffix: &str, mode: u32) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(NAME.0).suffix(suffix);
    #[cfg(unix)]
    builder.permissions(Permissions::from_mode(mode));
    #[cfg(not(unix))]
    let _ = mode;
    builder.tempfile_in(folder)
}

/// Options for opening a file in a temporary folder; if it is created, only its owner can access it.
pub fn options() -> OpenOptions {
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}

/// Creates a folder and its parents in a temporary folder; only their owner can access them.
///
/// # Errors
/// It cannot be created.
pub fn make_folder(path: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(path)
}

/// The permissions of a new file in this folder according to the user's umask.
fn usual_permissions(folder: &Path) -> io::Result<Permissions> {
    Ok(new_file(folder, NAME.1, 0o666)?.as_file().metadata()?.permissions())
}

/// Writes a file next to its destination, checks it there, and renames it: at any moment, either the old or the new
/// file exists. The new file keeps the old one's mode and, if permitted, owner. Symbolic links are followed. A device,
/// FIFO or socket is written to after the check.
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

/// A file that has been written and checked next to its destination. It is removed when dropped. Several files can be
/// written before the first one is renamed, so that none is replaced if the disk is full.
#[derive(Debug)]
pub struct Pending {
    // Kept open, and thus locked, until it is renamed.
    _file: File,
    beside: TempPath,
    _listed: Listed,
    path: PathBuf,
    /// Whether the destination is a device, FIFO or socket, which is written to rather than replaced.
    is_stream: bool,
}

impl Pending {
    /// Writes a file as [`place`] does, to be renamed by [`finish`](Pending::finish).
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
        remove_forgotten_in(&folder);
        let make = || locked(|| new_file(&folder, NAME.1, 0o600));
        let (file, _listed) = listed(make, tempfile::NamedTempFile::path).map_err(|error| unwritable(&path, error))?;
        let (file, beside) = file.into_parts();
        let mut writer = BufWriter::new(&file);
        write(&mut writer).with_context(failed)?;
        writer.flush().with_context(failed)?;
        drop(writer);
        if !is_stream {
            // Flush to disk before it is renamed.
            file.sync_all().with_context(failed)?;
        }
        check(&beside)?;
        if !is_stream {
            let permissions = match present {
                Some(present) => {
                    // May fail: only the superuser can change the owner of a file.
                    #[cfg(unix)]
                    let _ = std::os::unix::fs::fchown(&file, Some(present.uid()), Some(present.gid()));
                    present.permissions()
                }
                None => usual_permissions(&folder).with_context(failed)?,
            };
            file.set_permissions(permissions).with_context(failed)?;
        }
        Ok(Pending { _file: file, beside, _listed, path, is_stream })
    }

    /// Renames the file to its destination, or writes its contents to the device there.
    ///
    /// # Errors
    /// The file cannot be renamed, or the device cannot be written to.
    pub fn finish(self) -> Result<()> {
        let failed = || format!("{} cannot be written", self.path.display());
        if self.is_stream {
            let mut stream = OpenOptions::new().write(true).open(&self.path).with_context(failed)?;
            return io::copy(&mut File::open(&self.beside).with_context(failed)?, &mut stream)
                .map(drop)
                .with_context(failed);
        }
        let Pending { beside, path, _listed, .. } = self;
        beside.persist(&path).with_context(|| format!("{} cannot be written", path.display()))
    }
}

/// The metadata of whatever exists at `path`, following symbolic links.
fn present(path: &Path) -> Result<Option<Metadata>> {
    match fs::metadata(path) {
        Ok(of) if of.is_dir() => bail!("it is a folder: name a file in it"),
        Ok(of) => Ok(Some(of)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// The path after following symbolic links, even if nothing exists there. The links form no cycle, as [`present`] has
/// verified.
fn linked(path: &Path) -> PathBuf {
    match fs::read_link(path) {
        Ok(target) => linked(&folder(path).join(target)),
        Err(_) => path.to_path_buf(),
    }
}

/// Checks the files that a command is going to write: no output may be a folder, be one of the inputs, or be
/// specified twice. Devices, FIFOs and sockets may be specified twice.
///
/// # Errors
/// An output fails the check; the message states the remedy.
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
        // On a case-insensitive file system, the actual name of the file.
        let file = file.canonicalize().unwrap_or(file);
        ensure!(!inputs.contains(&file), "{} is read by this command: write to another file", output.display());
        ensure!(!seen.contains(&file), "{} is given for two outputs: give each its own file", output.display());
        seen.push(file);
    }
    Ok(())
}

/// The folder that contains a file, `.` if the path has none.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error for a file that cannot be created, with the path given by the user.
fn unwritable(path: &Path, error: io::Error) -> anyhow::Error {
    let folder = folder(path).display();
    match error.kind() {
        io::ErrorKind::PermissionDenied => {
            anyhow::anyhow!(
                "{} cannot be written: you do not have permission to write to the folder {folder}",
                path.display()
            )
        }
        // The original error names a temporary file that the user does not know.
        kind => anyhow::Error::new(error.raw_os_error().map_or_else(|| kind.into(), io::Error::from_raw_os_error))
            .context(format!("{} cannot be written", path.display())),
    }
}

/// Creates a file and locks it, except on Windows, where a lock would prevent others from reading it. Between the two
/// steps, another command may mistake the file for an abandoned one and remove it; a new one is then created.
fn locked(mut create: impl FnMut() -> io::Result<tempfile::NamedTempFile>) -> io::Result<tempfile::NamedTempFile> {
    loop {
        let file = create()?;
        if !cfg!(unix) {
            return Ok(file);
        }
        file.as_file().lock()?;
        if file.path().exists() {
            return Ok(file);
        }
    }
}

/// A temporary folder, removed when dropped.
#[derive(Debug)]
pub struct Folder {
    // Windows cannot remove an open file: this must be dropped first.
    _lock: File,
    folder: TempDir,
    _listed: Listed,
}

impl Folder {
    /// Creates a folder in the system's folder for temporary files.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn new() -> Result<Folder> {
        let place = std::env::temp_dir();
        Folder::new_in(&place)
            .with_context(|| format!("cannot create a folder in {}: {}", place.display(), Fault::remedy()))
    }

    /// Creates a folder in `place`, for example next to the destination.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn new_in(place: &Path) -> io::Result<Folder> {
        let make = || {
            let mut builder = tempfile::Builder::new();
            builder.prefix(NAME.0).suffix(NAME.1);
            #[cfg(unix)]
            builder.permissions(Permissions::from_mode(0o700));
            let folder = builder.tempdir_in(place)?;
            // Locked before it gets its final name: an unlocked one would count as abandoned.
            let path = folder.path().join("lock");
            let lock = options().write(true).create_new(true).open(&path)?;
            lock.lock()?;
            fs::rename(&path, folder.path().join(LOCK))?;
            Ok((lock, folder))
        };
        let ((lock, folder), listed) = listed(make, |(_, folder)| folder.path())?;
        Ok(Folder { _lock: lock, folder, _listed: listed })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// A complete temporary file, removed when dropped.
#[derive(Debug)]
pub struct Document {
    file: tempfile::NamedTempFile,
    _listed: Listed,
}

impl Document {
    /// Creates a file in the system's folder for temporary files; its name ends with `suffix`, if that matters to the
    /// program that opens it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(suffix: Option<&str>, content: &[u8]) -> Result<Document> {
        let make = || {
            let mut file = locked(|| new_file(&std::env::temp_dir(), suffix.unwrap_or(NAME.1), 0o600))?;
            file.write_all(content)?;
            Ok(file)
        };
        let (file, _listed) = listed(make, tempfile::NamedTempFile::path)
            .with_context(|| format!("cannot create a temporary file: {}", Fault::remedy()))?;
        Ok(Document { file, _listed })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.file.path()
    }
}

/// Removes leftovers of this user's killed commands from the system's folder for temporary files: those that are
/// unlocked, or whose lock cannot be tested and that are older than a day.
pub fn remove_forgotten() {
    remove_forgotten_in(&std::env::temp_dir());
}

/// As [`remove_forgotten`], for any folder.
fn remove_forgotten_in(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut left = entries.filter(|entry| is_ours(&entry.file_name().to_string_lossy())).peekable();
    if left.peek().is_none() {
        return;
    }
    #[cfg(unix)]
    let user = new_file(folder, NAME.1, 0o600).and_then(|file| Ok(file.as_file().metadata()?.uid())).ok();
    for entry in left {
        let (Ok(of), path) = (entry.metadata(), entry.path()) else { continue };
        if !of.is_file() && !of.is_dir() {
            continue;
        }
        #[cfg(unix)]
        if Some(of.uid()) != user {
            continue;
        }
        let is_old = || of.modified().ok().and_then(|time| time.elapsed().ok()).is_some_and(|age| age > A_DAY);
        // On Windows, files are not locked.
        let lock = File::open(if of.is_dir() { path.join(LOCK) } else { path.clone() });
        let lock = lock.ok().filter(|_| of.is_dir() || cfg!(unix));
        let is_forgotten = lock.as_ref().map_or_else(is_old, |lock| lock.try_lock().is_ok());
        // Keep a file locked while removing it: a process that has just created it waits for the lock, then creates
        // another (see `locked`). Unlock a folder: Windows cannot remove the open lock file, and a folder that is about
        // to be used never has an unlocked one.
        let _lock = lock.filter(|_| of.is_file());
        if is_forgotten {
            remove(&path);
        }
    }
}

/// Removes a file, or a folder with its contents. Failures are ignored.
fn remove(path: &Path) {
    let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
}

/// Whether this is the name of a temporary file or folder of this program.
fn is_ours(name: &str) -> bool {
    name.starts_with(NAME.0) && (name.ends_with(NAME.1) || name.ends_with(".html"))
}

/// Removes leftover temporary files and folders in `folder`.
///
/// # Errors
/// The folder cannot be read, or a leftover cannot be removed.
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
    fn a_file_that_cannot_be_made_is_told_by_the_name_that_the_user_gave() {
        let told = |kind: io::ErrorKind| {
            format!("{:#}", unwritable(Path::new("ro/a.csv"), io::Error::new(kind, ".plcfmu-x.tmp")))
        };
        let expected = "ro/a.csv cannot be written: you do not have permission to write to the folder ro";
        assert_eq!(told(io::ErrorKind::PermissionDenied), expected);
        let full = told(io::ErrorKind::StorageFull);
        assert!(full.starts_with("ro/a.csv cannot be written: ") && !full.contains(".plcfmu"), "{full}");
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
        assert!(error.ends_with("written.csv is given for two outputs: give each its own file"), "{error}");
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

    #[test]
    fn a_new_file_that_another_command_takes_for_a_forgotten_one_is_created_again() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            let others = scope.spawn(|| (0..2000).for_each(|_| remove_forgotten_in(folder.path())));
            let mut lost = 0;
            while !others.is_finished() {
                let file = locked(|| new_file(folder.path(), NAME.1, 0o600)).unwrap();
                lost += u32::from(!file.path().exists());
            }
            assert_eq!(lost, 0);
        });
    }
}
