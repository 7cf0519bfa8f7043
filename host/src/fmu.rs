//! An .fmu file, unpacked and loaded.

use crate::instance::{Instance, Start};
use crate::library::{Library, Opened, v3};
use crate::machine;
use crate::package::binary::Binary;
use crate::package::temporary::{self, Folder};
use crate::package::{LibraryFile, Package};
use anyhow::{Context, Error, Result, bail};
use modeldescription::{Array, Description, Interface, Table, Variable, shortened};
use std::env::consts::{ARCH, OS};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// An FMU for co-simulation with its library for this platform loaded. The folder to which it was unpacked is removed
/// when this value and the last instance have been dropped.
#[derive(Debug)]
pub struct Fmu {
    /// Its model description, with each array expanded to its elements.
    pub description: Description,
    /// Its loaded library.
    pub library: Opened,
    /// The location of its resources in the form that its FMI version requires: a URI in FMI 2.0, a path in FMI 3.0.
    resources: String,
}

impl Fmu {
    /// Unpacks and loads the FMU at `path`. This runs code from the FMU.
    ///
    /// # Errors
    /// The file is damaged, its library cannot be loaded, or [`library()`] fails.
    pub fn open(path: &Path) -> Result<Fmu> {
        let load = || Fmu::load(&mut Package::open(path)?, &std::env::temp_dir());
        load().with_context(|| path.display().to_string())
    }

    /// Loads the FMU in an open package, unpacking it to a temporary folder in `place`.
    ///
    /// # Errors
    /// As [`Fmu::open`].
    pub fn load<R: Read + Seek>(package: &mut Package<R>, place: &Path) -> Result<Fmu> {
        Unpacked::new(package, place)?.load()
    }

    /// Creates an instance, which uses Event Mode if `has_events` is set.
    ///
    /// # Errors
    /// The FMU refuses the call (the error contains its messages), or has no Event Mode.
    pub fn instantiate(&self, name: &str, has_events: bool) -> Result<Instance> {
        self.instantiate_with(name, &self.description.guid, has_events)
    }

    /// Creates an instance with a GUID or instantiation token other than the FMU's.
    ///
    /// # Errors
    /// As [`Fmu::instantiate`].
    pub fn instantiate_with(&self, name: &str, guid: &str, has_events: bool) -> Result<Instance> {
        let elements = |array: &Array| {
            let elements = &self.description.variables[array.first..array.first + array.count];
            let start = |of: &Variable| of.start_cell().unwrap_or(0.0);
            (array.clone(), elements.iter().map(start).collect())
        };
        let arrays: Vec<(Array, Vec<f64>)> = self.description.arrays.iter().map(elements).collect();
        let resources = Some(self.resources.as_str());
        Instance::start(&self.library, &Start { name, guid, resources, arrays: &arrays, has_events })
    }

    /// The table of the block in an FMU built with `fmu::export!`.
    ///
    /// # Errors
    /// The FMU was not built that way, or its table is damaged.
    pub fn table(&self) -> Result<Table> {
        Ok(Interface::parse(&self.library.interface()?)?.table)
    }

    /// Whether the FMU declares a capability for co-simulation, such as `canBeInstantiatedOnlyOncePerProcess`.
    pub fn can(&self, capability: &str) -> bool {
        self.description.co_simulation.as_ref().is_some_and(|support| support.can(capability))
    }
}

/// An FMU for co-simulation, unpacked to a temporary folder. None of its code has been run.
#[derive(Debug)]
pub struct Unpacked {
    description: Description,
    folder: Folder,
    library: LibraryFile,
}

impl Unpacked {
    /// Unpacks an FMU to a temporary folder in `place`.
    ///
    /// # Errors
    /// As [`library()`], the file is damaged, or `place` cannot be written to, which is a [`machine::Fault`].
    pub fn new<R: Read + Seek>(package: &mut Package<R>, place: &Path) -> Result<Unpacked> {
        let library = library(package)?.clone();
        let folder = Folder::new_in(place).map_err(Error::new);
        let folder = folder.with_context(|| format!("cannot create a folder in {}", place.display()));
        let unpacked = folder.and_then(|folder| package.archive.unpack(&Unpacked::path(&folder)).map(|()| folder));
        Ok(Unpacked { description: package.description.clone(), folder: machine::unpacking(unpacked, place)?, library })
    }

    /// Loads the library. This runs code from the FMU.
    ///
    /// # Errors
    /// The library cannot be loaded, which may be a [`machine::Fault`], or lacks a function.
    pub fn load(self) -> Result<Fmu> {
        let unpacked = Unpacked::path(&self.folder);
        let place = temporary::folder(self.folder.path()).to_path_buf();
        let (file, resources) = (unpacked.join(&self.library.path), unpacked.join("resources"));
        let (library, resources) = if self.description.is_fmi_3() {
            (v3::Library::open_in(self.folder, &file).map(Opened::V3), path(&resources))
        } else {
            (Library::open_in(self.folder, &file).map(Opened::V2), uri(&resources))
        };
        // If loading failed, the folder has been removed, but its parent still exists.
        let library = machine::loading(library, &place)?;
        Ok(Fmu { description: self.description, library, resources })
    }

    /// The subfolder that contains the FMU's files.
    fn path(folder: &Folder) -> PathBuf {
        folder.path().join("fmu")
    }
}

/// The FMU's library for this platform. Runs none of its code.
///
/// # Errors
/// [`ensure_runs`] fails, or the FMU has no library for this platform.
pub fn library<R: Read + Seek>(package: &Package<R>) -> Result<&LibraryFile> {
    ensure_runs(&package.description)?;
    if package.libraries.is_empty() {
        bail!("the FMU contains only sources: run it in a tool that compiles them");
    }
    let platforms = if package.description.is_fmi_3() { platforms_v3(OS, ARCH) } else { platforms(OS, ARCH) };
    let file = platforms.iter().find_map(|name| package.libraries.iter().find(|file| file.platform == *name));
    file.with_context(|| {
        format!(
            "the FMU has no library for this platform ({}), only for {}: get or build one for {0}",
            platforms.first().map_or_else(|| format!("{OS} on {ARCH}"), ToString::to_string),
            package.platforms()
        )
    })
}

/// Checks that this program supports the kind of FMU described.
///
/// # Errors
/// It is not for co-simulation, or has Clocks.
pub fn ensure_runs(description: &Description) -> Result<()> {
    if description.co_simulation.is_none() {
        if description.model_exchange.is_none() {
            bail!("the FMU is for scheduled execution only: export it for co-simulation");
        }
        bail!("the FMU is for model exchange only: run it in a simulator with a solver");
    }
    let clocks = || description.variables.iter().filter(|variable| variable.type_name == CLOCK);
    if clocks().next().is_some() {
        let names: Vec<_> = clocks().take(MOST_CLOCKS).map(|clock| shortened(&clock.name)).collect();
        let more = if clocks().count() > MOST_CLOCKS { ", ..." } else { "" };
        bail!(
            "the FMU has Clocks ({}{more}), which this program does not support: export it without Clocks, or run it in \
             a tool that supports them",
            names.join(", ")
        );
    }
    Ok(())
}

/// The FMI 3.0 type of Clocks, as named in model descriptions.
const CLOCK: &str = "Clock";

/// The maximum number of Clocks named in a message.
const MOST_CLOCKS: usize = 3;

/// Whether the library for this platform contains a block's table, like those built with `fmu::export!`. Runs none of
/// its code.
///
/// # Errors
/// The FMU is damaged, or as [`library`].
pub fn has_table<R: Read + Seek>(package: &mut Package<R>) -> Result<bool> {
    let file = library(package)?.clone();
    let bytes = package.library(&file)?;
    Ok(Binary::read(&bytes).with_context(|| file.path.clone())?.has_table)
}

/// Whether `text` occurs in the library file for this platform or, if there is none, in every library file of the FMU
/// (at least one). Runs none of their code.
///
/// # Errors
/// The FMU is damaged.
pub fn has_text<R: Read + Seek>(package: &mut Package<R>, text: &str) -> Result<bool> {
    let files = library(package).map_or_else(|_| package.libraries.clone(), |file| vec![file.clone()]);
    for file in &files {
        if memchr::memmem::find(&package.library(file)?, text.as_bytes()).is_none() {
            return Ok(false);
        }
    }
    Ok(!files.is_empty())
}

/// The folders for a platform in FMI 2.0, best first. The standard defines none for Linux on ARM; both listed here are
/// in use.
pub fn platforms(os: &str, arch: &str) -> &'static [&'static str] {
    match (os, arch) {
        ("linux", "x86_64") => &["linux64"],
        ("linux", "x86") => &["linux32"],
        ("linux", "aarch64") => &["aarch64-linux", "linux64"],
        ("windows", "x86_64") => &["win64"],
        ("windows", "x86") => &["win32"],
        ("macos", _) => &["darwin64"],
        _ => &[],
    }
}

/// The folders for a platform in FMI 3.0, best first.
pub fn platforms_v3(os: &str, arch: &str) -> &'static [&'static str] {
    match (os, arch) {
        ("linux", "x86_64") => &["x86_64-linux"],
        ("linux", "x86") => &["x86-linux"],
        ("linux", "aarch64") => &["aarch64-linux"],
        ("windows", "x86_64") => &["x86_64-windows"],
        ("windows", "x86") => &["x86-windows"],
        ("windows", "aarch64") => &["aarch64-windows"],
        ("macos", "x86_64") => &["x86_64-darwin"],
        ("macos", "aarch64") => &["aarch64-darwin"],
        _ => &[],
    }
}

/// A folder as a path that ends with a separator, as FMI 3.0 requires.
fn path(folder: &Path) -> String {
    format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR)
}

/// A folder as a URI (RFC 8089).
fn uri(folder: &Path) -> String {
    let path = folder.display().to_string().replace('\\', "/");
    let mut uri = String::from("file:");
    if !path.starts_with("//") {
        // A path that starts with // contains its own host: a network share on Windows.
        uri.push_str(if path.starts_with('/') { "//" } else { "///" });
    }
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"/:-._~".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::{DESCRIPTION, archive};
    use modeldescription::v2::{self, CoSimulation, ModelDescription, ModelExchange};
    use std::io::Cursor;

    /// Returns the error for an FMU with this description and this file as its library.
    fn error(description: &ModelDescription, library: &str) -> String {
        let files =
            [(DESCRIPTION.to_string(), v2::write(description)), (library.to_string(), b"not a library".to_vec())];
        let mut package = Package::read(Cursor::new(archive::write(&files.into()).unwrap())).unwrap();
        let place = tempfile::tempdir().unwrap();
        let error = Fmu::load(&mut package, place.path()).unwrap_err();
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0, "the temporary folder is still there");
        format!("{error:#}")
    }

    fn pump() -> ModelDescription {
        let co_simulation = CoSimulation { model_identifier: "PUMP".into(), ..CoSimulation::default() };
        ModelDescription {
            model_name: "PUMP".into(),
            guid: "{1}".into(),
            co_simulation: Some(co_simulation),
            ..ModelDescription::default()
        }
    }

    #[test]
    fn an_fmu_without_a_library_for_this_platform_names_those_it_has() {
        let error = error(&pump(), "binaries/plan9/PUMP.so");
        let here = platforms(OS, ARCH)[0];
        assert_eq!(
            error,
            format!("the FMU has no library for this platform ({here}), only for plan9: get or build one for {here}")
        );
    }

    #[test]
    fn an_fmu_for_model_exchange_is_refused() {
        let model_exchange = ModelExchange { model_identifier: "PUMP".into(), ..ModelExchange::default() };
        let description = ModelDescription { co_simulation: None, model_exchange: Some(model_exchange), ..pump() };
        assert!(error(&description, "binaries/linux64/PUMP.so").contains("model exchange only"));
    }

    #[test]
    fn a_file_that_is_not_a_library_leaves_no_temporary_folder() {
        let path = format!("binaries/{}/PUMP.so", platforms(OS, ARCH)[0]);
        let error = error(&pump(), &path);
        assert!(error.contains("PUMP.so cannot be loaded: "), "{error}");
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = format!("{:#}", Fmu::open(Path::new("no/such.fmu")).unwrap_err());
        assert!(error.starts_with("no/such.fmu: "), "{error}");
    }

    #[test]
    fn a_folder_is_named_as_a_uri() {
        assert_eq!(uri(Path::new("/tmp/a b/50%/ä#?")), "file:///tmp/a%20b/50%25/%C3%A4%23%3F");
        assert_eq!(uri(Path::new("C:\\x y\\resources")), "file:///C:/x%20y/resources");
        assert_eq!(uri(Path::new("\\\\server\\share\\x")), "file://server/share/x");
    }

    #[test]
    fn linux_on_arm_prefers_the_folder_that_says_so() {
        assert_eq!(platforms("linux", "aarch64"), ["aarch64-linux", "linux64"]);
        assert_eq!(platforms("macos", "aarch64"), ["darwin64"]);
    }
}
