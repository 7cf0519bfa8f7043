//! `plcfmu info`: shows an FMU's kind, requirements and variables.

use super::check::kinds;
use super::{LONGEST_NAME, functions, print, refuse_folders, shown};
use crate::package::preset;
use crate::tell::plain;
use anyhow::{Context, Result, bail};
use blocks::table::start::Start;
use host::package::Package;
use host::package::binary::Binary;
use modeldescription::{DefaultExperiment, Description, Support, Type, Variable};
use serde_json::{Map, Value, json};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Describe FMUs: platforms, capabilities, variables with unit, range and start value
///
/// Reads any FMI 2.0 or 3.0 FMU. Its code is not run.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// The FMUs
    #[arg(value_name = "FILE.fmu", required = true)]
    pub files: Vec<PathBuf>,
    /// Print a JSON list with an object for each FMU, for scripts
    #[arg(long)]
    pub json: bool,
}

/// The width of the text, in characters.
const WIDTH: usize = 100;

/// The width of the labels before the variables, in characters.
const LABELS: usize = 14;

/// The minimum width of the last column, in characters. Lines exceed [`WIDTH`] if necessary.
const NARROWEST: usize = 24;

/// The maximum length of a printed description from a foreign FMU, in characters.
const LONGEST_TEXT: usize = 1000;

/// Prints descriptions of FMUs.
///
/// # Errors
/// A file cannot be read; the other descriptions are printed.
pub fn run(options: &Options) -> Result<()> {
    refuse_folders(&options.files)?;
    let mut objects = Vec::new();
    let mut unreadable = Vec::new();
    for (place, file) in options.files.iter().enumerate() {
        match read(file) {
            Ok(fmu) if options.json => objects.push(fmu.json(file)),
            Ok(fmu) => {
                let gap = if place > 0 { "\n" } else { "" };
                print(&plain(&format!("{gap}{}\n{}", file.display(), fmu.text())))?;
            }
            Err(error) => unreadable.push(format!("{}: {error:#}", file.display())),
        }
    }
    if options.json {
        print(&format!("{:#}\n", Value::from(objects)))?;
    }
    if unreadable.is_empty() { Ok(()) } else { bail!(unreadable.join("\n       ")) }
}

/// The printed information about an FMU.
#[derive(Debug)]
struct Fmu {
    description: Description,
    /// For a preset: its block and the GUID of the original FMU, or why its start values cannot be read.
    preset: Option<Result<Start>>,
    libraries: Vec<Library>,
}

/// A library in an FMU.
#[derive(Debug)]
struct Library {
    platform: String,
    path: String,
    /// In bytes, unpacked.
    size: usize,
    /// Its exports and requirements, or why they cannot be read.
    binary: Result<Binary>,
}

fn read(file: &Path) -> Result<Fmu> {
    let mut package = Package::open(file)?;
    let libraries = libraries(&mut package)?;
    // FMUs from other tools may contain a file with the same name as a preset's start values.
    let is_ours = libraries.iter().any(|library| library.binary.as_ref().is_ok_and(|binary| binary.has_table));
    let preset = if is_ours { preset::start(&mut package).transpose() } else { None };
    Ok(Fmu { description: package.xml.description(), preset, libraries })
}

fn libraries<R: Read + Seek>(package: &mut Package<R>) -> Result<Vec<Library>> {
    let mut libraries = Vec::new();
    for file in package.libraries.clone() {
        let bytes = package.library(&file).with_context(|| file.path.clone())?;
        let binary = Binary::read(&bytes);
        libraries.push(Library { platform: file.platform, path: file.path, size: bytes.len(), binary });
    }
    Ok(libraries)
}

/// The origin of a preset.
fn preset_text(preset: &Result<Start>) -> String {
    match preset {
        Ok(start) => format!("of {}, {}", shown(&start.block, LONGEST_NAME), shown(&start.library, LONGEST_NAME)),
        Err(error) => format!("damaged: {}", shown(&format!("{error:#}"), LONGEST_TEXT)),
    }
}

fn preset_json(preset: &Result<Start>) -> Value {
    match preset {
        Ok(start) => json!({"block": start.block, "guid": start.library}),
        Err(error) => json!({"error": format!("{error:#}")}),
    }
}

/// A capability of an FMU: the attribute's name in FMI, whether it is set, and its meaning.
type Capability = (&'static str, bool, &'static str);

/// The only capability that is a number.
const OUTPUT_DERIVATIVES: &str = "maxOutputDerivativeOrder";

/// The meanings of the flags, for co-simulation and model exchange.
const MEANINGS: [(&str, &str); 20] = [
    ("needsExecutionTool", "needs its tool installed to run"),
    ("canHandleVariableCommunicationStepSize", "steps may differ in size"),
    ("canInterpolateInputs", "accepts derivatives of inputs"),
    ("canRunAsynchronuously", "may compute a step in the background"),
    ("completedIntegratorStepNotNeeded", "need not be notified of completed integrator steps"),
    ("canBeInstantiatedOnlyOncePerProcess", "one instance per process"),
    ("canNotUseMemoryManagementFunctions", "allocates its own memory"),
    ("canGetAndSetFMUstate", "its state can be saved and restored"),
    ("canSerializeFMUstate", "a saved state can be stored as bytes"),
    ("providesDirectionalDerivative", "provides partial derivatives"),
    // FMI 3.0 flags.
    ("hasEventMode", "has Event Mode: a call and its results share one instant"),
    ("mightReturnEarlyFromDoStep", "may end a step at an event"),
    ("canGetAndSetFMUState", "its state can be saved and restored"),
    ("canSerializeFMUState", "a saved state can be stored as bytes"),
    ("providesDirectionalDerivatives", "provides partial derivatives"),
    ("providesAdjointDerivatives", "provides adjoint (reverse) derivatives"),
    ("providesPerElementDependencies", "declares dependencies for each array element"),
    ("providesIntermediateUpdate", "exchanges values within a step"),
    ("canReturnEarlyAfterIntermediateUpdate", "can end a step early on request"),
    ("providesEvaluateDiscreteStates", "evaluates discrete states without updating them"),
];

/// The capabilities that are flags.
fn flags(support: &Support) -> Vec<Capability> {
    let flag = |(name, value): &(&'static str, String)| {
        let (_, meaning) = MEANINGS.iter().find(|(flag, _)| flag == name)?;
        Some((*name, value == "true", *meaning))
    };
    support.capabilities.iter().filter_map(flag).collect()
}

/// The highest order of the output derivatives that the FMU provides, 0 if none.
fn output_derivatives(support: &Support) -> u32 {
    let mut capabilities = support.capabilities.iter();
    let order = capabilities.find(|(name, _)| *name == OUTPUT_DERIVATIVES);
    order.and_then(|(_, order)| order.parse().ok()).unwrap_or(0)
}

/// A number in human-readable form.
fn number_text(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").unwrap_or(&text).to_string()
}

/// A variable's value in human-readable form.
fn value_text(variable: &Variable, value: f64) -> String {
    if variable.kind == Some(Type::Boolean) { Type::Boolean.text(value) } else { number_text(value) }
}

/// A variable's value as JSON. JSON has no infinite numbers: they become strings.
fn value_json(variable: &Variable, value: f64) -> Value {
    match variable.kind {
        Some(Type::Boolean) => json!(value != 0.0),
        Some(kind) if kind.whole().is_some() => whole_json(value as i128),
        _ if value.is_finite() => json!(value),
        _ => json!(value.to_string()),
    }
}

/// An integer of at most 64 bits as JSON.
fn whole_json(whole: i128) -> Value {
    i64::try_from(whole).map_or_else(|_| json!(u64::try_from(whole).unwrap_or(u64::MAX)), |whole| json!(whole))
}

impl Fmu {
    /// The JSON output: all information, with FMI's names as keys.
    fn json(&self, file: &Path) -> Value {
        let description = &self.description;
        let mut capabilities = Map::new();
        let object = |support| -> Map<String, Value> {
            flags(support).into_iter().map(|(name, is_set, _)| (name.to_string(), json!(is_set))).collect()
        };
        if let Some(support) = &description.co_simulation {
            let mut flags = object(support);
            flags.insert(OUTPUT_DERIVATIVES.into(), json!(output_derivatives(support)));
            capabilities.insert("CoSimulation".into(), flags.into());
        }
        if let Some(support) = &description.model_exchange {
            capabilities.insert("ModelExchange".into(), object(support).into());
        }
        let libraries: Vec<Value> = self.libraries.iter().map(Library::json).collect();
        let categories = description.log_categories.iter();
        let categories: Vec<Value> =
            categories.map(|category| json!({"name": category.name, "description": category.description})).collect();
        let experiment = description.default_experiment.map(|experiment| {
            json!({
                "startTime": experiment.start_time,
                "stopTime": experiment.stop_time,
                "tolerance": experiment.tolerance,
                "stepSize": experiment.step_size,
            })
        });
        let variables: Vec<Value> = description.variables.iter().map(variable_json).collect();
        json!({
            "file": file.display().to_string(),
            "fmiVersion": description.fmi_version,
            "kinds": kinds(description),
            "modelName": description.model_name,
            "modelIdentifier": description.model_identifier(),
            "description": description.description,
            "guid": description.guid,
            "preset": self.preset.as_ref().map(preset_json),
            "author": description.author,
            "version": description.version,
            "copyright": description.copyright,
            "license": description.license,
            "generationTool": description.generation_tool,
            "generationDateAndTime": description.generation_date_and_time,
            "libraries": libraries,
            "capabilities": capabilities,
            "defaultExperiment": experiment,
            "logCategories": categories,
            "variables": variables,
        })
    }

    /// The text output: a two-column header, and a table of the variables.
    fn text(&self) -> String {
        let description = &self.description;
        let optional =
            |text: &Option<String>| -> Vec<String> { text.iter().map(|text| shown(text, LONGEST_TEXT)).collect() };
        let made = [&description.generation_tool, &description.generation_date_and_time];
        let made: Vec<String> = made.into_iter().flatten().map(|text| shown(text, LONGEST_TEXT)).collect();
        let fields = [
            ("Model", vec![shown(&description.model_name, LONGEST_NAME)]),
            ("Description", optional(&description.description)),
            ("Kind", vec![format!("FMI {} for {}", description.fmi_version, kinds(description).join(" and "))]),
            (if description.is_fmi_3() { "Token" } else { "GUID" }, vec![shown(&description.guid, LONGEST_NAME)]),
            ("Preset", self.preset.iter().map(preset_text).collect()),
            ("Made by", if made.is_empty() { Vec::new() } else { vec![made.join(", ")] }),
            ("Author", optional(&description.author)),
            ("Version", optional(&description.version)),
            ("Copyright", optional(&description.copyright)),
            ("License", optional(&description.license)),
            ("Libraries", self.libraries.iter().map(|library| library.text(description)).collect()),
            ("Capabilities", capabilities(description)),
            ("Experiment", description.default_experiment.iter().filter_map(experiment).collect()),
            ("Log categories", categories(description)),
        ];
        let mut text = String::new();
        for (label, values) in fields {
            for (place, value) in values.iter().enumerate() {
                let label = if place == 0 { label } else { "" };
                text.push_str(&columns(&[label.to_string(), value.clone()], &[LABELS]));
            }
        }
        text.push_str(&table(description));
        text
    }
}

impl Library {
    fn json(&self) -> Value {
        let mut object = json!({"platform": self.platform, "path": self.path, "size": self.size});
        let further = match &self.binary {
            Ok(binary) => json!({
                "architectures": binary.architectures,
                "functions": binary.functions,
                "glibc": binary.glibc,
                "needed": binary.needed,
                "installNames": binary.install_names,
            }),
            Err(error) => json!({"error": format!("{error:#}")}),
        };
        if let (Value::Object(object), Value::Object(further)) = (&mut object, further) {
            object.extend(further);
        }
        object
    }

    fn text(&self, description: &Description) -> String {
        let size = self.size.div_ceil(1000);
        let start = format!("{}: {size} kB", shown(&self.platform, LONGEST_NAME));
        let binary = match &self.binary {
            Ok(binary) => binary,
            Err(error) => return format!("{start}; {error:#}"),
        };
        let mut parts = vec![start, binary.architectures.join(" and ")];
        parts.push(functions(binary, description));
        if let Some(glibc) = &binary.glibc {
            parts.push(format!("needs glibc {} or newer", shown(glibc, LONGEST_NAME)));
        }
        if !binary.needed.is_empty() {
            let needed: Vec<String> = binary.needed.iter().map(|name| shown(name, LONGEST_NAME)).collect();
            parts.push(format!("loads {}", shown(&needed.join(" "), LONGEST_TEXT)));
        }
        for name in &binary.install_names {
            parts.push(format!("install name {}", shown(name, LONGEST_NAME)));
        }
        parts.join(", ")
    }
}

/// The capabilities of an FMU, one per line.
fn capabilities(description: &Description) -> Vec<String> {
    let mut all = Vec::new();
    for capability in description.co_simulation.iter().chain(&description.model_exchange).flat_map(flags) {
        if !all.contains(&capability) {
            all.push(capability);
        }
    }
    let mut lines: Vec<String> = all
        .into_iter()
        .filter(|(_, is_set, _)| *is_set)
        .map(|(name, _, meaning)| format!("{name}: {meaning}"))
        .collect();
    match description.co_simulation.as_ref().map_or(0, output_derivatives) {
        0 => {}
        order => lines.push(format!("{OUTPUT_DERIVATIVES} = {order}: provides derivatives of outputs")),
    }
    lines
}

/// The suggested simulation settings, in one line.
fn experiment(experiment: &DefaultExperiment) -> Option<String> {
    let fields = [
        ("start", experiment.start_time, " s"),
        ("stop", experiment.stop_time, " s"),
        ("step", experiment.step_size, " s"),
        ("tolerance", experiment.tolerance, ""),
    ];
    let fields: Vec<String> = fields
        .into_iter()
        .filter_map(|(name, value, unit)| Some(format!("{name} {}{unit}", number_text(value?))))
        .collect();
    (!fields.is_empty()).then(|| fields.join(", "))
}

fn categories(description: &Description) -> Vec<String> {
    let line = |(name, text): (&String, &Option<String>)| match text {
        Some(text) => format!("{}: {}", shown(name, LONGEST_NAME), shown(text, LONGEST_TEXT)),
        None => shown(name, LONGEST_NAME),
    };
    description.log_categories.iter().map(|category| line((&category.name, &category.description))).collect()
}

fn variable_json(variable: &Variable) -> Value {
    let json = |value: Option<f64>| value.map(|value| value_json(variable, value));
    let whole = || variable.exact.iter().copied().map(whole_json);
    let start = || whole().next().or(json(variable.start)).or(variable.start_text.as_ref().map(|text| json!(text)));
    // An array may declare a single start value for all its elements.
    let starts = || match variable.exact.is_empty() {
        false => whole().cycle().take(variable.starts.len()).collect(),
        true => variable.starts.iter().map(|value| value_json(variable, *value)).collect(),
    };
    let start = if variable.starts.is_empty() { start() } else { Some(Value::Array(starts())) };
    let mut all = json!({
        "name": variable.name,
        "valueReference": variable.value_reference,
        "causality": variable.causality.word(),
        "variability": variable.variability.word(),
        "initial": variable.initial.map(|initial| initial.word()),
        "type": variable.type_name,
        "unit": variable.unit,
        "min": json(variable.min),
        "max": json(variable.max),
        "start": start,
        "description": variable.description,
    });
    if !variable.dimensions.is_empty() {
        all["dimensions"] = json!(variable.dimensions);
    }
    all
}

/// A variable's type, followed by the dimensions if it is an array, such as `Float64[2,3]`.
fn type_text(variable: &Variable) -> String {
    let sizes: Vec<String> = variable.dimensions.iter().map(u64::to_string).collect();
    if sizes.is_empty() {
        variable.type_name.to_string()
    } else {
        format!("{}[{}]", variable.type_name, sizes.join(","))
    }
}

/// The variables, one per line.
fn table(description: &Description) -> String {
    let head = ["Name", "Causality", "Variability", "Type", "Unit", "Range", "Start", "Description"];
    let mut rows = vec![head.map(str::to_string)];
    for variable in &description.variables {
        let text = |value: Option<f64>| value.map(|value| value_text(variable, value));
        let start_text = variable.start_text.as_ref().map(|text| format!("\"{}\"", shown(text, LONGEST_NAME)));
        let exact = variable.exact.first().map(i128::to_string);
        let start = exact.or(text(variable.start)).or(start_text);
        let (min, max) = (text(variable.min), text(variable.max));
        let range = match (min, max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            (Some(min), None) => format!(">= {min}"),
            (None, Some(max)) => format!("<= {max}"),
            (None, None) => String::new(),
        };
        rows.push([
            shown(&variable.name, LONGEST_NAME),
            variable.causality.word().to_string(),
            variable.variability.word().to_string(),
            type_text(variable),
            variable.unit.as_deref().map_or(String::new(), |unit| shown(unit, LONGEST_NAME)),
            range,
            start.unwrap_or_default(),
            shown(variable.description.as_deref().unwrap_or_default(), LONGEST_TEXT),
        ]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len() - 1).map(width).collect();
    let lines: String = rows.iter().map(|row| columns(row, &widths)).collect();
    format!("\n  {} variables\n\n{lines}", description.variables.len())
}

/// A row with aligned cells; the last one is wrapped. `widths` are the widths of the other columns.
fn columns(cells: &[String], widths: &[usize]) -> String {
    let mut line = String::from(" ");
    for (cell, width) in cells.iter().zip(widths) {
        // An empty column takes no space.
        if *width > 0 {
            line.push_str(&format!(" {cell:width$} "));
        }
    }
    line.push(' ');
    let start = line.chars().count();
    let last = cells.last().map_or("", String::as_str);
    let mut text = String::new();
    for (place, part) in wrapped(last, WIDTH.saturating_sub(start).max(NARROWEST)).into_iter().enumerate() {
        let front = if place == 0 { line.clone() } else { " ".repeat(start) };
        text.push_str(format!("{front}{part}").trim_end());
        text.push('\n');
    }
    text
}

/// Wraps text between words into lines of at most `width` characters. A longer word gets its own line.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        if let Some(line) = lines.last_mut() {
            if line.is_empty() {
                line.push_str(word);
                continue;
            }
            if line.chars().count() + 1 + word.chars().count() <= width {
                line.push(' ');
                line.push_str(word);
                continue;
            }
        }
        lines.push(word.to_string());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::library::FUNCTIONS;

    const XML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Pump&#10;  Kind" guid="{12}" generationTool="Tool 1">
  <ModelExchange modelIdentifier="pump"/>
  <CoSimulation modelIdentifier="pump" maxOutputDerivativeOrder="2" canInterpolateInputs="true"/>
  <UnitDefinitions><Unit name="bar"/></UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Pressure"><Real unit="bar" min="0.5" max="1e300"/></SimpleType>
    <SimpleType name="Mode"><Enumeration><Item name="off" value="1"/><Item name="on" value="2"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logAll"/></LogCategories>
  <DefaultExperiment startTime="0.0" stopTime="1.5"/>
  <ModelVariables>
    <ScalarVariable name="p" valueReference="1" causality="input" description="Pressure at the outlet, as it is measured by the sensor behind the valve">
      <Real declaredType="Pressure" start="1" min="1"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="2" causality="parameter" variability="fixed">
      <Enumeration declaredType="Mode" start="2"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="3" causality="parameter" variability="fixed">
      <Integer min="1" start="3"/></ScalarVariable>
    <ScalarVariable name="file" valueReference="4" causality="parameter" variability="tunable">
      <String start="a b"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="5" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="x" valueReference="6" causality="parameter" variability="tunable"><Real start="INF" max="INF"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="5"/></Outputs><InitialUnknowns><Unknown index="5"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>"#;

    fn fmu() -> Fmu {
        let library = |platform: &str, binary| Library {
            platform: platform.into(),
            path: format!("binaries/{platform}/pump"),
            size: 1001,
            binary,
        };
        let linux = Binary {
            architectures: vec!["x86_64".into()],
            functions: vec![FUNCTIONS[0].into(), "fmi3DoStep".into()],
            glibc: Some("2.17".into()),
            needed: vec!["libc.so.6".into(), "libm.so.6".into()],
            ..Binary::default()
        };
        let macos = Binary {
            architectures: vec!["x86_64".into(), "aarch64".into()],
            install_names: vec!["@rpath/pump.dylib".into()],
            ..Binary::default()
        };
        let damaged = Err(anyhow::anyhow!("it is damaged"));
        Fmu {
            preset: None,
            description: modeldescription::ModelDescription::read(XML.as_bytes()).unwrap().description(),
            libraries: vec![library("linux64", Ok(linux)), library("darwin64", Ok(macos)), library("win64", damaged)],
        }
    }

    #[test]
    fn the_text_says_what_the_fmu_is_and_lists_its_variables_in_columns() {
        let expected = r#"  Model           Pump\n  Kind
  Kind            FMI 2.0 for co-simulation and model exchange
  GUID            {12}
  Made by         Tool 1
  Libraries       linux64: 2 kB, x86_64, 1 FMI 2.0 functions, needs glibc 2.17 or newer, loads
                  libc.so.6 libm.so.6
                  darwin64: 2 kB, x86_64 and aarch64, 0 FMI 2.0 functions, install name
                  @rpath/pump.dylib
                  win64: 2 kB; it is damaged
  Capabilities    canInterpolateInputs: accepts derivatives of inputs
                  maxOutputDerivativeOrder = 2: provides derivatives of outputs
  Experiment      start 0 s, stop 1.5 s
  Log categories  logAll

  6 variables

  Name  Causality  Variability  Type         Unit  Range       Start  Description
  p     input      continuous   Real         bar   1 to 1e300  1      Pressure at the outlet, as it
                                                                      is measured by the sensor
                                                                      behind the valve
  mode  parameter  fixed        Enumeration                    2
  n     parameter  fixed        Integer            >= 1        3
  file  parameter  tunable      String                         "a b"
  on    output     discrete     Boolean
  x     parameter  tunable      Real               <= inf      inf
"#;
        assert_eq!(fmu().text(), expected);
    }

    #[test]
    fn a_preset_is_told_with_its_block() {
        let start = Start { preset: "P1".into(), block: "PUMP".into(), library: "{7}".into(), values: Vec::new() };
        let preset = Fmu { preset: Some(Ok(start)), ..fmu() };
        assert!(
            preset.text().contains("\n  GUID            {12}\n  Preset          of PUMP, {7}\n"),
            "{}",
            preset.text()
        );
        assert_eq!(preset.json(Path::new("p.fmu"))["preset"], json!({"block": "PUMP", "guid": "{7}"}));
        let damaged = Fmu { preset: Some(Err(anyhow::anyhow!("it is changed"))), ..fmu() };
        assert!(damaged.text().contains("\n  Preset          damaged: it is changed\n"), "{}", damaged.text());
    }

    #[test]
    fn the_json_has_everything_by_the_names_of_fmi() {
        let json = fmu().json(Path::new("pump.fmu"));
        assert_eq!(json["file"], "pump.fmu");
        assert_eq!(json["modelName"], "Pump\n  Kind");
        assert_eq!(json["kinds"], json!(["co-simulation", "model exchange"]));
        assert_eq!(json["capabilities"]["CoSimulation"]["canInterpolateInputs"], true);
        assert_eq!(json["capabilities"]["CoSimulation"]["maxOutputDerivativeOrder"], 2);
        assert_eq!(json["capabilities"]["ModelExchange"]["canGetAndSetFMUstate"], false);
        assert_eq!(json["libraries"][0]["glibc"], "2.17");
        assert_eq!(json["libraries"][2]["error"], "it is damaged");
        assert_eq!(
            json["variables"][0],
            json!({
                "name": "p", "valueReference": 1, "causality": "input", "variability": "continuous", "initial": null,
                "type": "Real", "unit": "bar", "min": 1.0, "max": 1e300, "start": 1.0,
                "description": "Pressure at the outlet, as it is measured by the sensor behind the valve",
            })
        );
        assert_eq!(json["variables"][5]["start"], "inf");
    }

    #[test]
    fn a_start_value_of_64_bits_is_told_exactly() {
        for (exact, json) in [
            (u64::MAX.into(), json!(u64::MAX)),
            (i64::MIN.into(), json!(i64::MIN)),
            (1 << 53 | 1, json!(1_i64 << 53 | 1)),
        ] {
            let start = Some(exact as f64);
            let variable = Variable { kind: Some(Type::Integer), start, exact: vec![exact], ..Variable::default() };
            assert_eq!(variable_json(&variable)["start"], json);
            let several = Variable { starts: vec![0.0; 2], exact: vec![0, exact], ..variable };
            assert_eq!(variable_json(&several)["start"], json!([0, json]));
        }
    }

    #[test]
    fn a_long_text_is_broken_between_words_and_a_long_word_is_not() {
        assert_eq!(wrapped("a bc def", 4), ["a bc", "def"]);
        assert_eq!(wrapped("abcdef g", 4), ["abcdef", "g"]);
        assert_eq!(wrapped("", 4), [""]);
    }
}
