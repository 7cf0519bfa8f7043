//! Presets: FMUs with the library of a block's FMU, but their own start values.
//!
//! The values are in modelDescription.xml, where hosts read them, and in `resources/start.txt`, where the library reads
//! them. The preset's GUID is the fingerprint of that file, so that the library accepts only the declared values.

use crate::package::check;
use anyhow::{Result, anyhow, bail, ensure};
use blocks::table::start::{self, Start};
use host::package::{DESCRIPTION, Package};
use modeldescription::{Causality, Description, Variable, shortened};
use parameters::Loop;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;
use tool::preset::{PAGE, guid_of};
pub use tool::preset::{identifier, path};

/// The maximum size of a documentation page, in bytes.
const LARGEST_PAGE: u64 = 1 << 26;

/// The start values of a preset, without checking that they belong to it; `None` if there are none.
///
/// # Errors
/// They are damaged.
fn read<R: Read + Seek>(package: &mut Package<R>) -> Result<Option<(String, Start)>> {
    let path = path();
    if package.archive.find(&path).is_none() {
        return Ok(None);
    }
    let text =
        String::from_utf8(package.archive.read(&path, start::LARGEST)?).map_err(|_| anyhow!("{path} is not UTF-8"))?;
    let start = Start::parse(&text).map_err(|error| anyhow!("{path}: {error}"))?;
    Ok(Some((text, start)))
}

/// The start values of a preset, checked against its GUID and its modelDescription.xml; `None` if it has none.
///
/// # Errors
/// They are damaged, or belong to another FMU.
pub fn start<R: Read + Seek>(package: &mut Package<R>) -> Result<Option<Start>> {
    let Some((text, start)) = read(package)? else { return Ok(None) };
    let (path, guid) = (path(), &package.description.guid);
    let fingerprint = guid_of(&text);
    ensure!(
        fingerprint == *guid,
        "{path} has the start values of {:?} {fingerprint}, but {DESCRIPTION} has the GUID {:?}: one of them was changed or replaced",
        shortened(&start.preset),
        shortened(guid)
    );
    let description = &package.description;
    let places = description.places(start.values.iter().map(|(name, _)| (name.as_str(), ())));
    let mut missing: BTreeSet<usize> = settings(description).collect();
    for ((name, value), place) in start.values.iter().zip(places) {
        let Some(place) = place.filter(|place| missing.remove(place)) else {
            bail!("{path} has a value for {:?}, which is not a setting in {DESCRIPTION}", shortened(name));
        };
        let variable = &description.variables[place];
        ensure!(
            is_declared(variable, value),
            "{name} is {value} in {path}, but {} in {DESCRIPTION}: one of them was changed",
            declared(variable)
        );
    }
    if let Some(missing) = missing.first() {
        bail!("{path} has no value for {:?}", shortened(&description.variables[*missing].name));
    }
    Ok(Some(start))
}

/// The indices of all numeric inputs and parameters.
fn settings(description: &Description) -> impl Iterator<Item = usize> {
    let is_setting =
        |of: &Variable| of.kind.is_some() && matches!(of.causality, Causality::Input | Causality::Parameter);
    description.variables.iter().enumerate().filter(move |(_, of)| is_setting(of)).map(|(place, _)| place)
}

/// The start value that the model description declares for a variable, as text; empty if there is none.
fn declared(variable: &Variable) -> String {
    let exact = variable.exact.first().map(i128::to_string);
    let number = || Some(variable.kind?.text(variable.start?));
    exact.or_else(number).unwrap_or_default()
}

/// Whether a variable's declared start value equals a value in the file. An FMI integer may hold the bits of the PLC's
/// integer, or a duration in milliseconds or nanoseconds. In the file, durations are in seconds, with a decimal point,
/// which integers do not have.
fn is_declared(variable: &Variable, value: &str) -> bool {
    let Some(kind) = variable.kind.filter(|_| !variable.is_enumeration()) else { return false };
    let whole = declared(variable).parse::<i128>().ok().filter(|_| kind.whole().is_some());
    match (whole, value.parse::<i128>(), value.parse::<f64>()) {
        (Some(whole), Ok(value), _) => (whole - value) % (1 << kind.bits()) == 0,
        (Some(whole), _, Ok(seconds)) => {
            let scale = if kind.bits() == 64 { 1e9 } else { 1e3 };
            (seconds * scale).round() as i128 == whole
        }
        (None, _, Ok(number)) => variable.start == Some(number),
        _ => declared(variable) == value,
    }
}

/// An FMU from which presets are made.
#[derive(Debug)]
pub struct Original<R> {
    package: Package<R>,
    /// The block's name.
    pub block: String,
    /// The GUID of the block's own FMU.
    library: String,
    /// Whether this FMU is itself a preset.
    pub is_preset: bool,
    is_checked: bool,
}

/// An FMU with its own start values.
#[derive(Clone, Debug)]
pub struct Preset {
    /// Its name, which is an identifier.
    pub name: String,
    /// Its GUID.
    pub guid: String,
    /// The content of its file.
    pub bytes: Vec<u8>,
}

impl Original<BufReader<File>> {
    /// Opens an FMU.
    ///
    /// # Errors
    /// It is damaged.
    pub fn open(path: &Path) -> Result<Self> {
        Original::from_package(Package::open(path)?)
    }
}

impl<R: Read + Seek> Original<R> {
    /// Prepares an open package for making presets.
    ///
    /// # Errors
    /// Its start values are damaged.
    pub fn from_package(mut package: Package<R>) -> Result<Self> {
        let block = package.description.model_identifier().unwrap_or_default().to_string();
        let start = read(&mut package)?.map(|(_, start)| start);
        let is_preset = start.is_some();
        let library = start.map_or_else(|| package.description.guid.clone(), |start| start.library);
        Ok(Original { package, block, library, is_preset, is_checked: false })
    }

    /// Rejects an FMU that is damaged or from another tool.
    fn check(&mut self) -> Result<()> {
        if !self.is_checked {
            // The program library has no table: it reads one from the resources. A library compiled for a single
            // program contains its start values.
            let is_program = self.package.archive.find(&format!("resources/{}", manifest::FILE)).is_some();
            let report = check::check(&mut self.package);
            let has_table = report.libraries.iter().any(|(_, binary)| binary.has_table);
            ensure!(
                !(is_program && has_table),
                "its library was compiled for this program only and accepts no other start values: build it without --native"
            );
            ensure!(
                is_program || has_table,
                "it was not made by plcfmu: its library would ignore the start values of a preset"
            );
            ensure!(report.errors.is_empty(), report.errors.join("; "));
            self.is_checked = true;
        }
        Ok(())
    }

    /// Makes an FMU with the values of a loop as its start values.
    ///
    /// # Errors
    /// The original was not made by `plcfmu`, is not for the loop's block, or does not accept a value.
    pub fn preset(&mut self, values: &Loop) -> Result<Preset> {
        self.check()?;
        let page = match self.package.archive.find(PAGE) {
            Some(_) => Some(self.package.archive.read(PAGE, LARGEST_PAGE)?),
            None => None,
        };
        let page = page.as_deref().map(String::from_utf8_lossy);
        let original = tool::preset::Original {
            xml: &self.package.xml,
            description: &self.package.description,
            library: &self.library,
            page: page.as_deref(),
        };
        let preset = original.preset(values)?;
        let files = preset.files.into_iter().map(|(path, text)| (path, text.into_bytes())).collect();
        let is_left_out =
            |path: &str| preset.left_out.iter().any(|out| path == out || out.ends_with('/') && path.starts_with(out));
        let bytes = self.package.archive.with(&files, |path| !is_left_out(path))?;
        Ok(Preset { name: preset.name, guid: preset.guid, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Role, Row, Time, Value};
    use doubles::macos;
    use host::library::FUNCTIONS;
    use host::package::archive;
    use modeldescription::{Interface, ModelDescription};
    use parameters::{BlockType, Origin};
    use std::collections::BTreeMap;
    use std::io::Cursor;
    use std::sync::Arc;

    /// The description of a small block by its library.
    const TABLE: &str = r#"{"table":{"name":"PUMP","docs":"Pumps.","cycle":1,"variables":[
        {"name":"FLOW","description":"x","kind":"REAL","role":"input","start":1.0,"min":0.0,"max":2.0,"unit":null},
        {"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null}],
        "responses":[{"title":"x","calls":3,"set":[],"show":[]}]},
        "interface":{"version":"2.0","guid":"{1}","capabilities":{},"log_categories":[]}}"#;

    type Files = BTreeMap<String, Vec<u8>>;

    fn files(has_table: bool) -> Files {
        let xml = ModelDescription::from_interface(&Interface::parse(TABLE).unwrap()).unwrap();
        let functions: Vec<&str> = FUNCTIONS.iter().copied().chain(has_table.then_some("plcfmu_interface")).collect();
        let mut library = macos(object::Architecture::X86_64, &functions);
        library.extend(b"{1}");
        [
            (DESCRIPTION, xml.write()),
            ("binaries/darwin64/PUMP.dylib", library),
            ("extra/org.fmi-standard.fmi-ls-ref/PUMP_out.csv", b"time".to_vec()),
            ("documentation/fmi-ls-ref.txt", b"About it".to_vec()),
            ("documentation/licenses/NOTICE", b"Notice".to_vec()),
        ]
        .map(|(name, content)| (name.to_string(), content))
        .into()
    }

    fn package(files: &Files) -> Package<Cursor<Vec<u8>>> {
        Package::read(Cursor::new(archive::write(files).unwrap())).unwrap()
    }

    fn values(flow: f32, cycle: i32) -> Loop {
        let members = vec![
            Row::new("FLOW", Role::Input, Value::Real(1.0)),
            Row::new("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        ];
        let mut values = Loop::new("P 1", Arc::new(BlockType::new("PUMP".into(), Vec::new(), members)));
        values.set(0, Value::Real(flow), Origin::Default);
        values.set(1, Value::Time(Time::ms(cycle)), Origin::Default);
        values
    }

    fn preset(flow: f32, cycle: i32) -> Result<Preset> {
        Original::from_package(package(&files(true)))?.preset(&values(flow, cycle))
    }

    /// The files of a preset.
    fn unpacked(preset: &Preset) -> Files {
        let mut package = Package::read(Cursor::new(preset.bytes.clone())).unwrap();
        let names: Vec<String> = package.archive.entries().iter().map(|entry| entry.name.clone()).collect();
        names.into_iter().map(|name| (name.clone(), package.archive.read(&name, 1 << 20).unwrap())).collect()
    }

    #[test]
    fn a_preset_declares_its_values_and_proposes_a_step_of_its_cycle() {
        let preset = preset(0.1, 20).unwrap();
        assert_eq!(preset.name, "P_1");
        let package = Package::read(Cursor::new(preset.bytes.clone())).unwrap();
        let description = &package.description;
        assert_eq!((description.model_name.as_str(), &description.guid), ("P_1", &preset.guid));
        assert_eq!(description.model_identifier(), Some("PUMP"));
        let variables = settings(description).map(|place| &description.variables[place]);
        let all: Vec<String> = variables.map(|of| format!("{} = {}", of.name, declared(of))).collect();
        assert_eq!(all, ["FLOW = 0.10000000149011612", "CYCLE = 0.02"]);
        let experiment = description.default_experiment.unwrap();
        assert_eq!((experiment.step_size, experiment.stop_time), (Some(0.02), Some(0.06)));
    }

    #[test]
    fn a_preset_has_all_files_but_the_recorded_results() {
        let names: Vec<String> = unpacked(&preset(0.1, 20).unwrap()).into_keys().collect();
        assert_eq!(
            names,
            ["binaries/darwin64/PUMP.dylib", "documentation/licenses/NOTICE", DESCRIPTION, "resources/start.txt"]
        );
    }

    #[test]
    fn a_preset_passes_its_check_without_a_remark() {
        for flow in [0.1, 7.0, -7.0] {
            let bytes = preset(flow, 20).unwrap().bytes;
            let report = check::check(&mut Package::read(Cursor::new(bytes)).unwrap());
            assert_eq!((report.errors, report.remarks), (vec![], vec![]), "FLOW = {flow}");
        }
    }

    #[test]
    fn a_preset_whose_files_do_not_belong_together_is_wrong() {
        let errors = |change: &dyn Fn(&mut Files)| {
            let mut files = unpacked(&preset(0.1, 20).unwrap());
            change(&mut files);
            check::check(&mut package(&files)).errors.join("; ")
        };
        assert_eq!(errors(&|_| ()), "");
        let replace = |files: &mut Files, name: &str, from: &str, to: &str| {
            let text = String::from_utf8(files[name].clone()).unwrap();
            assert!(text.contains(from), "{text}");
            files.insert(name.into(), text.replace(from, to).into_bytes());
        };
        let changed = errors(&|files| replace(files, "resources/start.txt", "0.02", "0.03"));
        assert!(changed.contains("has the start values of \"P_1\" {"), "{changed}");
        let declared = errors(&|files| replace(files, DESCRIPTION, "start=\"0.02\"", "start=\"0.03\""));
        assert!(declared.ends_with(
            "CYCLE is 0.02 in resources/start.txt, but 0.03 in modelDescription.xml: one of them was changed"
        ));
        let missing = errors(&|files| drop(files.remove("resources/start.txt")));
        assert!(missing.ends_with("or resources/start.txt was removed"), "{missing}");
        let exchanged = errors(&|files| {
            files.insert(
                "binaries/darwin64/PUMP.dylib".into(),
                self::files(true)["binaries/darwin64/PUMP.dylib"][1..].into(),
            );
        });
        assert!(!exchanged.is_empty());
    }

    #[test]
    fn the_same_preset_has_the_same_bytes_and_one_with_another_name_another_guid() {
        assert_eq!(preset(0.1, 20).unwrap().bytes, preset(0.1, 20).unwrap().bytes);
        let other = Loop { name: "P2".into(), ..values(0.1, 20) };
        let other = Original::from_package(package(&files(true))).unwrap().preset(&other).unwrap();
        assert_ne!(other.guid, preset(0.1, 20).unwrap().guid);
    }

    #[test]
    fn what_an_fmu_would_refuse_is_no_preset() {
        let refusal = |result: Result<Preset>| format!("{:#}", result.map(|_| ()).unwrap_err());
        assert_eq!(
            refusal(preset(f32::NAN, 20)),
            "FLOW = NaN: a REAL accepts finite numbers with a magnitude of at most 3.4028235e38"
        );
        assert_eq!(refusal(preset(1.0, -1)), "CYCLE = -0.001: a TIME accepts 0 ... 2147483.647 s");
        assert_eq!(refusal(preset(1.0, 0)), "the time between two calls is 0 s: it must be at least 0.001 s");
        let foreign = Original::from_package(package(&files(false))).unwrap().preset(&values(1.0, 20));
        assert_eq!(
            refusal(foreign),
            "it was not made by plcfmu: its library would ignore the start values of a preset"
        );
        let fan = Loop::new("F", Arc::new(BlockType::new("FAN".into(), Vec::new(), Vec::new())));
        let other = Original::from_package(package(&files(true))).unwrap().preset(&fan);
        assert_eq!(refusal(other), "it is an FMU for PUMP, not for FAN");
    }
}
