//! The arguments of `plcfmu run` and `plcfmu ssp` that specify what to run or pack: FMUs, a description, or the loops
//! of a parameter file, and options that override them.

use crate::exit::Unreadable;
use crate::package::program::Options as Program;
use crate::package::version::Version;
use crate::program::{has_code, is_part, is_source};
use crate::{package, parameter_file};
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use host::package::temporary;
use parameters::{Format, Source};
use run::file;
use run::system::{Connection, Exchange, FilePosition, Member, Recorded, Setting, System, Value};
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What to run or pack.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// FMUs in the order in which they are stepped, a controller before its plant; or a loop description
    ///
    /// An FMU is named after its file; NAME= renames it, which is needed to use the same file twice. A description
    /// (.toml, or - for standard input) lists FMUs, connections, values and times; options extend or override it. A PLC
    /// parameter file (.awl, .scl, .db, .xml, .json) adds one FMU per loop, with the loop's name and values;
    /// --fmus names the folder of the FMUs. The sources of a PLC program (.scl, .udt, .db, .s7dcl, .xml, .awl), its tag
    /// tables, or the folder of both add the FMU that `plcfmu build` makes from them together, named after the first
    /// file.
    #[arg(value_name = "[NAME=]FILE.fmu|FILE.toml|FILE.scl|FOLDER", required = true)]
    files: Vec<String>,
    /// The folder of the FMUs named by a description or a parameter file; by default, the description's own folder
    #[arg(long, value_name = "FOLDER")]
    fmus: Option<PathBuf>,
    /// The block of a parameter file's loops, if the file does not specify it: its name, or a number such as FB 41
    #[arg(long, value_name = "BLOCK")]
    block: Option<String>,
    /// Connect an output to an input
    ///
    /// The types must match; an Integer output can also feed a Real input. If both have a unit, the units must match:
    /// values are not converted.
    #[arg(short, long, value_name = "FMU.OUTPUT=FMU.INPUT", value_parser = parse::<Connection>)]
    connect: Vec<Connection>,
    /// Set an input or a parameter before initialization, or at a time in seconds: PID.SP=60@120
    ///
    /// A Boolean is true or false, or 1 or 0. With a time, the value is set at the first communication point at or
    /// after it. Values outside the range declared by the FMU are set, with a warning.
    #[arg(short, long, value_name = "FMU.VARIABLE=VALUE[@TIME]", value_parser = parse::<Setting>, allow_hyphen_values = true)]
    set: Vec<Setting>,
    /// Set inputs and tunable parameters over time from a CSV file: time,FMU.VARIABLE,... as written by --out
    ///
    /// The time is in seconds. A value holds until the next row; the first row is set before initialization.
    #[arg(long, value_name = "FILE.csv")]
    signals: Option<PathBuf>,
    /// Record this variable; by default, all outputs and the inputs that are connected or set
    ///
    /// The columns follow the order of these options.
    #[arg(short, long, value_name = "FMU.VARIABLE")]
    record: Vec<String>,
    /// Start time in seconds; by default, the earliest proposed by an FMU, or 0
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in seconds; by default, the latest proposed by an FMU
    ///
    /// The run ends with the last whole step that does not exceed it.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Communication step in seconds; by default, the smallest proposed by an FMU
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    step: Option<f64>,
    /// Exchange all values before any FMU steps (Jacobi)
    ///
    /// By default, an FMU gets the values computed by the FMUs before it in the same step (Gauss-Seidel).
    #[arg(long)]
    parallel: bool,
    /// Step FMUs with Event Mode (FMI 3.0) like those without it
    ///
    /// By default, a call of such an FMU and its results share one instant, regardless of the order of the FMUs.
    #[arg(long)]
    no_events: bool,
    #[command(flatten, next_help_heading = "Programs in SCL")]
    program: Program,
}

impl Arguments {
    /// Whether the options specify what to record.
    pub fn has_record(&self) -> bool {
        !self.record.is_empty()
    }

    /// The system described by the files and the options together.
    ///
    /// # Errors
    /// A file cannot be read, or is faulty; the message includes line and column.
    pub fn system(&self) -> Result<System> {
        let mut system = System::default();
        let mut has_description = false;
        // With --fmus and without --cycle, source files are parameter files, even if they also contain code of blocks.
        let are_parameters = self.fmus.is_some() && self.program.cycles.is_empty();
        let is_program = !are_parameters && self.files.iter().any(|file| has_code(path_of(file)));
        let mut own: Option<String> = None;
        for file in &self.files {
            let path = Path::new(file);
            if is_program && is_part(path_of(file)) {
                let name = own.get_or_insert(member(file)?.name).clone();
                if system.members.iter().all(|of| of.name != name) {
                    system.members.push(member(file)?);
                }
                system.programs.entry(name).or_default().sources.push(path_of(file).to_path_buf());
                continue;
            }
            let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
            if extension.is_some_and(|extension| extension == "toml") || file == Source::STANDARD_INPUT {
                if has_description {
                    bail!("{file} is a second description: specify only one description, and any FMUs to add to it");
                }
                has_description = true;
                let members = std::mem::take(&mut system.members);
                let settings = std::mem::take(&mut system.settings);
                let sources = std::mem::take(&mut system.sources);
                let programs = std::mem::take(&mut system.programs);
                system = file::read(path, self.fmus.as_deref(), parameter_file::read_any).map_err(Unreadable)?;
                system.members.splice(0..0, members);
                system.settings.splice(0..0, settings);
                system.sources.extend(sources);
                system.programs.extend(programs);
            } else if Format::of_file(file).is_some() {
                self.add_loops(path, &mut system)?;
            } else {
                let member = member(file)?;
                ensure_fmu(&member.path)?;
                system.members.push(member);
            }
        }
        self.add_options(&mut system)?;
        system.connections.extend(self.connect.iter().cloned());
        if let Some(input) = &self.signals {
            let shown = input.display().to_string();
            let text =
                fs::read_to_string(input).with_context(|| format!("{shown} cannot be read")).map_err(Unreadable)?;
            system.settings.extend(signals(&shown, &text)?);
            system.sources.push(input.clone());
        }
        for setting in &self.set {
            let is_replaced = |other: &Setting| {
                other.place.is_some() && other.variable == setting.variable && other.time == setting.time
            };
            system.settings.retain(|other| other.is_preliminary || !is_replaced(other));
        }
        system.settings.extend(self.set.iter().cloned());
        if !self.record.is_empty() {
            system.record = self.record.iter().map(|name| Recorded::from(name.as_str())).collect();
        }
        system.start = self.start.or(system.start);
        system.stop = self.stop.or(system.stop);
        system.step = self.step.or(system.step);
        if self.parallel {
            system.exchange = Exchange::Parallel;
        }
        system.no_events |= self.no_events;
        Ok(system)
    }

    /// Applies the program options to the programs for which the description specifies no options.
    fn add_options(&self, system: &mut System) -> Result<()> {
        for member in system.members.iter().filter(|member| is_source(&member.path) || member.path.is_dir()) {
            let program = system.programs.entry(member.name.clone()).or_default();
            if program.sources.is_empty() {
                program.sources.push(member.path.clone());
            }
        }
        let mut bare = system.programs.values_mut().filter(|program| program.is_bare()).peekable();
        if bare.peek().is_none() {
            return self.program.refuse();
        }
        for program in bare {
            *program = self.program.manifest(&program.sources)?;
        }
        Ok(())
    }

    /// Adds an FMU for each loop of a parameter file.
    fn add_loops(&self, path: &Path, system: &mut System) -> Result<()> {
        let shown = path.display();
        let folder = self.fmus.as_deref().with_context(|| {
            format!("{shown} is a parameter file: specify the folder with the FMUs of its blocks with --fmus FOLDER")
        })?;
        let options = parameters::Options { block: self.block.clone(), ..Default::default() };
        let reading = parameter_file::read_any(&shown.to_string(), &options)?;
        system.remarks.extend(file::remarks(&reading));
        system.sources.push(path.to_path_buf());
        for of in &reading.loops {
            let fmu = folder.join(format!("{}.fmu", of.block.name));
            if !fmu.is_file() {
                bail!("{}, a {} in {shown}, needs {}, which does not exist", of.name, of.block.name, fmu.display());
            }
            system.settings.extend(Setting::of_loop(of, &of.name, None));
            system.members.push(Member { name: of.name.clone(), path: fmu });
        }
        Ok(())
    }
}

/// The system with each program replaced by an FMU, in a temporary folder that is deleted when dropped.
///
/// # Errors
/// A program is faulty; the message includes file, line and column.
pub fn packed(system: &System) -> Result<(System, Option<temporary::Folder>)> {
    let mut packed = system.clone();
    if system.programs.is_empty() {
        return Ok((packed, None));
    }
    let folder = temporary::Folder::new()?;
    for (number, member) in packed.members.iter_mut().enumerate() {
        let Some(program) = system.programs.get(&member.name) else { continue };
        let (name, folder) = (&member.name, folder.path().join(number.to_string()));
        let (path, warnings) = package::program::pack(program, Version::default(), false, &folder)
            .with_context(|| format!("the program {name}"))?;
        member.path = path;
        if !warnings.is_empty() {
            let sources: Vec<String> = program.sources.iter().map(|path| path.display().to_string()).collect();
            packed.remarks.push(format!("{name} has warnings; to show them, run plcfmu check {}", sources.join(" ")));
        }
    }
    Ok((packed, Some(folder)))
}

/// The file of an argument that may begin with NAME=.
fn path_of(argument: &str) -> &Path {
    match argument.split_once('=') {
        Some((_, path)) if !Path::new(argument).exists() => Path::new(path),
        _ => Path::new(argument),
    }
}

/// The settings from the text of a CSV file of signals: one for each value that differs from the row before.
fn signals(file: &str, text: &str) -> Result<Vec<Setting>> {
    let at = |line: usize| FilePosition { file: file.into(), line, column: 1 };
    let mut lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let (header, _) =
        lines.next().with_context(|| format!("{file} is empty: its first line must be time,FMU.VARIABLE,..."))?;
    let names: Vec<&str> =
        header.trim_start_matches('\u{feff}').split(',').map(|name| name.trim().trim_matches('"')).collect();
    ensure!(names.len() > 1 && names[0] == "time", "{}: expected time,FMU.VARIABLE,..., found {header:?}", at(1));
    let mut settings: Vec<Setting> = Vec::new();
    let mut last: Vec<Option<Value>> = vec![None; names.len()];
    let mut before = f64::NEG_INFINITY;
    for (line, number) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        ensure!(cells.len() == names.len(), "{}: expected {} values, found {}", at(number), names.len(), cells.len());
        let time = cells[0].parse().ok().filter(|time: &f64| time.is_finite());
        let time = time.with_context(|| format!("{}: the time {:?} is not a number", at(number), cells[0]))?;
        ensure!(time > before, "{}: the time {time} s is not after {before} s", at(number));
        let is_first = before == f64::NEG_INFINITY;
        before = time;
        for ((cell, name), last) in cells.iter().zip(&names).zip(&mut last).skip(1) {
            let value: Value = cell.parse().with_context(|| format!("{}: {name}", at(number)))?;
            if last.replace(value) != Some(value) {
                settings.push(Setting {
                    variable: (*name).into(),
                    value,
                    time: (!is_first).then_some(time),
                    is_preliminary: false,
                    place: Some(at(number)),
                });
            }
        }
    }
    Ok(settings)
}

/// Parses an argument for clap, with all causes of an error in its message.
fn parse<T: FromStr<Err = Error>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error| format!("{error:#}"))
}

/// Rejects a file that cannot be run, judging by its name and contents. Problems of an FMU are reported when it is
/// opened.
fn ensure_fmu(path: &Path) -> Result<()> {
    let is_named = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu"));
    let mut start = [0; 2];
    if is_named || !path.is_file() {
        return Ok(());
    }
    let is_read = File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok();
    if is_read && start == *b"PK" {
        return Ok(());
    }
    let why = "is neither an FMU (.fmu), a loop (.toml), a parameter file (.awl, .db, .xml, ...) nor a program (.scl)";
    Err(Unreadable(anyhow!("{} {why}", path.display())).into())
}

/// The FMU in an argument: `NAME=FILE.fmu`, or `FILE.fmu` for an FMU named after its file.
fn member(text: &str) -> Result<Member> {
    let (name, path) = match text.split_once('=') {
        // A file's name may contain "=".
        Some((name, path)) if !Path::new(text).exists() => (name.to_string(), PathBuf::from(path)),
        _ => {
            let path = PathBuf::from(text);
            let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            (name, path)
        }
    };
    if name.is_empty() || path.as_os_str().is_empty() {
        bail!("{text:?} does not name an FMU: write FILE.fmu or NAME=FILE.fmu");
    }
    Ok(Member { name, path })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_are_settings_where_they_change() {
        let text = "time,A.SP,A.ON\n0,1,0\n0.5,1,1\n1.0,2.5,1\n";
        let shown: Vec<_> =
            signals("s.csv", text).unwrap().iter().map(|of| (of.variable.clone(), of.time, of.value)).collect();
        let number = Value::Number;
        assert_eq!(
            shown,
            [
                ("A.SP".to_string(), None, number(1.0)),
                ("A.ON".to_string(), None, number(0.0)),
                ("A.ON".to_string(), Some(0.5), number(1.0)),
                ("A.SP".to_string(), Some(1.0), number(2.5)),
            ]
        );
        for (text, expected) in [
            ("", "s.csv is empty"),
            ("t,A.SP\n", "s.csv:1:1: expected time,FMU.VARIABLE,..., found \"t,A.SP\""),
            ("time,A.SP\n0\n", "s.csv:2:1: expected 2 values, found 1"),
            ("time,A.SP\n1,2\n1,3\n", "s.csv:3:1: the time 1 s is not after 1 s"),
            ("time,A.SP\n0,x\n", "s.csv:2:1: A.SP"),
        ] {
            let error = format!("{:#}", signals("s.csv", text).unwrap_err());
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn an_fmu_is_named_as_its_file_or_explicitly() {
        let named = |name: &str, path: &str| Member { name: name.into(), path: path.into() };
        assert_eq!(member("some/PID.fmu").unwrap(), named("PID", "some/PID.fmu"));
        assert_eq!(member("inner=some/PID.fmu").unwrap(), named("inner", "some/PID.fmu"));
        for text in ["", "A=", "=a.fmu"] {
            assert!(member(text).unwrap_err().to_string().contains("write FILE.fmu or NAME=FILE.fmu"), "{text}");
        }
    }
}
