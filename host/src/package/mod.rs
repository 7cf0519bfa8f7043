//! Opens FMU files: archives with a model description and matching libraries.

pub mod archive;
pub mod binary;
pub mod temporary;

use anyhow::{Context, Result, bail};
use archive::Archive;
use modeldescription::{Description, ModelDescription, shortened};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// The maximum size of modelDescription.xml, in bytes.
const LONGEST_DESCRIPTION: u64 = 1 << 26;

/// The maximum size of a library, in bytes.
const LARGEST_LIBRARY: u64 = 1 << 28;

/// The name of the model description file in every FMU.
pub const DESCRIPTION: &str = "modelDescription.xml";

/// The folder in an FMU for the source code of its library, which hosts may compile.
const SOURCES: &str = "sources/";

/// An FMU file that has been opened and checked.
#[derive(Debug)]
pub struct Package<R> {
    /// Its files.
    pub archive: Archive<R>,
    /// Its modelDescription.xml.
    pub xml: ModelDescription,
    /// The description of the FMU derived from that file, with array elements as variables.
    pub description: Description,
    /// Its libraries, one for each platform; empty if it contains only sources.
    pub libraries: Vec<LibraryFile>,
}

/// A library in an FMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LibraryFile {
    /// FMI's name of the platform, such as `linux64`.
    pub platform: String,
    /// The path of the file in the archive.
    pub path: String,
}

impl Package<BufReader<File>> {
    /// Opens the FMU at `path` and checks its packaging.
    ///
    /// # Errors
    /// The FMU is faulty; the error is one sentence.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).context("it cannot be opened")?;
        Package::read(BufReader::new(file))
    }
}

impl<R: Read + Seek> Package<R> {
    /// Reads an FMU and checks its packaging.
    ///
    /// # Errors
    /// The FMU is faulty; the error is one sentence.
    pub fn read(reader: R) -> Result<Package<R>> {
        let mut archive = Archive::open(reader)?;
        let xml = archive.read(DESCRIPTION, LONGEST_DESCRIPTION)?;
        let xml = ModelDescription::read(&xml).context(DESCRIPTION)?;
        let description = xml.description().expanded();
        let identifier = description
            .model_identifier()
            .with_context(|| format!("{DESCRIPTION} is neither for co-simulation nor for model exchange"))?;
        let names = archive.entries().iter().map(|entry| entry.name.as_str());
        let libraries: Vec<LibraryFile> = names.filter_map(|name| library(name, identifier)).collect();
        let has_sources = archive.entries().iter().any(|entry| entry.name.starts_with(SOURCES));
        if libraries.is_empty() && !has_sources {
            let identifier = shortened(identifier);
            bail!(
                "it has neither sources nor a library: FMI requires {:?}, {:?} or the like",
                format!("binaries/linux64/{identifier}.so"),
                format!("binaries/win64/{identifier}.dll")
            );
        }
        Ok(Package { archive, xml, description, libraries })
    }

    /// Reads one of the libraries.
    ///
    /// # Errors
    /// The library is too large or damaged.
    pub fn library(&mut self, file: &LibraryFile) -> Result<Vec<u8>> {
        self.archive.read(&file.path, LARGEST_LIBRARY)
    }

    /// The platforms of the libraries, separated by commas.
    pub fn platforms(&self) -> String {
        let platforms: Vec<_> = self.libraries.iter().map(|library| library.platform.as_str()).collect();
        platforms.join(", ")
    }
}

/// The library at a path in the archive, if there is one: `binaries/PLATFORM/IDENTIFIER.EXTENSION`.
fn library(path: &str, identifier: &str) -> Option<LibraryFile> {
    let (platform, file) = path.strip_prefix("binaries/")?.split_once('/')?;
    let extension = file.strip_prefix(identifier)?;
    [".so", ".dll", ".dylib"]
        .contains(&extension)
        .then(|| LibraryFile { platform: platform.to_string(), path: path.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use modeldescription::v2::{self, CoSimulation};
    use std::collections::BTreeMap;
    use std::io::Cursor;

    /// The files of a small FMU.
    fn files() -> BTreeMap<String, Vec<u8>> {
        let co_simulation = CoSimulation { model_identifier: "PUMP".into(), ..CoSimulation::default() };
        let description = v2::ModelDescription {
            model_name: "PUMP".into(),
            guid: "{1}".into(),
            co_simulation: Some(co_simulation),
            ..v2::ModelDescription::default()
        };
        [
            (DESCRIPTION, v2::write(&description)),
            ("binaries/linux64/PUMP.so", vec![1]),
            ("binaries/linux64/libother.so", vec![2]),
            ("binaries/win64/PUMP.dll", vec![3]),
            ("binaries/win64/PUMP.pdb", vec![4]),
            ("resources/PUMP.so", vec![5]),
        ]
        .map(|(name, content)| (name.to_string(), content))
        .into()
    }

    fn read(files: &BTreeMap<String, Vec<u8>>) -> Result<Package<Cursor<Vec<u8>>>> {
        Package::read(Cursor::new(archive::write(files).unwrap()))
    }

    /// The sentence that a user reads.
    fn sentence<T>(result: Result<T>) -> String {
        format!("{:#}", result.map(|_| ()).unwrap_err())
    }

    #[test]
    fn the_libraries_are_found_by_the_model_identifier() {
        let package = read(&files()).unwrap();
        assert_eq!(package.description.model_name, "PUMP");
        assert_eq!(package.platforms(), "linux64, win64");
        assert_eq!(package.libraries[1].path, "binaries/win64/PUMP.dll");
    }

    #[test]
    fn an_fmu_without_a_model_description_is_refused() {
        let mut files = files();
        files.remove(DESCRIPTION);
        assert_eq!(sentence(read(&files)), "modelDescription.xml is missing");
    }

    #[test]
    fn an_fmu_without_a_library_is_refused() {
        let mut files = files();
        files.retain(|name, _| !name.contains("64/PUMP."));
        assert_eq!(
            sentence(read(&files)),
            "it has neither sources nor a library: FMI requires \"binaries/linux64/PUMP.so\", \"binaries/win64/PUMP.dll\" or the like"
        );
    }

    #[test]
    fn an_fmu_may_have_sources_only() {
        let mut files = files();
        files.retain(|name, _| !name.contains("64/PUMP."));
        files.insert("sources/pump.c".into(), b"int pump;".to_vec());
        assert_eq!(read(&files).unwrap().libraries, []);
    }

    #[test]
    fn wrong_xml_is_refused_by_the_name_of_its_file() {
        for xml in ["", "hello", "<fmiModelDescription", "<other/>", "<fmiModelDescription fmiVersion=\"2.0\"/>"] {
            let mut files = files();
            files.insert(DESCRIPTION.into(), xml.into());
            let error = sentence(read(&files));
            assert!(error.starts_with("modelDescription.xml: ") && !error.contains('\n'), "{xml}: {error}");
        }
    }

    #[test]
    fn a_description_for_nothing_is_refused() {
        let mut files = files();
        let nothing =
            v2::ModelDescription { model_name: "PUMP".into(), guid: "{1}".into(), ..v2::ModelDescription::default() };
        files.insert(DESCRIPTION.into(), v2::write(&nothing));
        assert!(sentence(read(&files)).starts_with("modelDescription.xml"));
    }

    #[test]
    fn a_missing_file_is_told() {
        let error = sentence(Package::open(Path::new("/no/such/file.fmu")));
        assert!(error.starts_with("it cannot be opened: "), "{error}");
    }
}
