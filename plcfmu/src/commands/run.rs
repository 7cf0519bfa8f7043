//! `plcfmu run`: runs FMUs together and records them.

use super::study::interruption;
use super::{system, time_limit};
use crate::progress::Progress;
use anyhow::{Context, Result, bail, ensure};
use draw::picture;
use draw::plot::{self, Chart, Curve, Panel};
use host::child::run::Finished;
use host::child::{self, Starter};
use host::instance::Type;
use host::package::temporary;
use run::file;
use run::master::Recording;
use run::plan::Plan;
use std::io::{self, BufWriter, StdoutLock, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use study::Interrupted;

/// So many messages of each FMU are shown.
const MOST_MESSAGES: usize = 10;

/// Run FMUs together, record them, draw them
///
/// Runs any FMUs of FMI 2.0 for co-simulation. A variable is named FMU.VARIABLE, such as PID.GAIN; `plcfmu info` lists the
/// variables of an FMU.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = SHORT_HELP, after_long_help = LONG_HELP)]
pub struct Options {
    #[command(flatten)]
    system: system::Arguments,
    /// Write the recording as CSV; - is standard output
    #[arg(short, long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Draw the recording
    #[arg(short, long, value_name = "FILE.png|FILE.svg")]
    plot: Option<PathBuf>,
    /// Write what is run as a description that `plcfmu run FILE.toml` runs again
    #[arg(long, value_name = "FILE.toml")]
    save: Option<PathBuf>,
    /// How long one call of an FMU may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = time_limit)]
    time_limit: f64,
}

const SHORT_HELP: &str = "\
Example, a furnace with its controller:
  plcfmu run PID.fmu FURNACE.fmu \\
    --connect PID.OUT=FURNACE.POWER --connect FURNACE.TEMP=PID.PV \\
    --set PID.GAIN=2 --set PID.SP=60 --set PID.SP=80@300 \\
    --stop 600 --out result.csv --plot result.png

'plcfmu run --help' says when values are exchanged and what a row of the recording holds.";

const LONG_HELP: &str = "\
Example, a furnace with its controller:
  plcfmu run PID.fmu FURNACE.fmu \\
    --connect PID.OUT=FURNACE.POWER --connect FURNACE.TEMP=PID.PV \\
    --set PID.GAIN=2 --set PID.SP=60 --set PID.SP=80@300 \\
    --stop 600 --out result.csv --plot result.png

Order of a step from t to t + h:
  The FMUs are stepped in the order given. Each FMU first gets the values that are set at t, then its connected inputs,
  and then steps to t + h. So it sees what the FMUs before it computed in this step, and what those after it computed in
  the previous one. With the controller first, its call at t uses the process value of t, and the plant runs from t to
  t + h with the manipulated value of that call. In the other order the loop has one more step of dead time.
  With --parallel, all FMUs get their inputs before any of them steps: every connection delays by one step.
  Step k begins at start + k * step: rounding errors do not add up.

Initialization:
  Each FMU gets its parameters, enters Initialization Mode and gets its inputs. The connected values then go once from
  output to input, in the order of the FMUs. Then each FMU leaves Initialization Mode.

Rows of the recording:
  A row belongs to a time: the beginning of each step, and the end. An input has the value that its FMU gets for the step
  that begins then. An output has the value that the connected FMUs read in that step. So a controller's row is what it saw
  and gave in its call at that time, and a plant that is connected back to the controller shows what it is at that time. An
  output that no FMU reads is recorded as the other outputs of its FMU; if none of them is read, all have the values of that
  time, before the step. At the end no step is made: the last row has what the FMUs gave last.
  Numbers in the CSV read back bit-equal; Booleans are 1 and 0.

FMUs are foreign code: they run in a process of their own. One that crashes or does not return ends the run with an error that
names it. What they print goes to standard error. An FMU may end the run (discard with terminated): the rows up to then
are written.";

/// Runs FMUs.
///
/// # Errors
/// What is wrong and what to do; which FMU refused what, when, and its messages. Nothing is written then.
pub fn run(options: &Options) -> Result<()> {
    let is_svg = options.plot.as_deref().map(is_svg).transpose()?;
    let to_stdout = options.out.as_deref() == Some(Path::new("-"));
    let system = options.system.system()?;
    let outputs = options.out.iter().filter(|_| !to_stdout).chain(&options.plot).chain(&options.save);
    temporary::check_outputs(outputs.clone().map(PathBuf::as_path), system.inputs())?;
    for file in outputs {
        let folder = temporary::folder(file);
        ensure!(folder.is_dir(), "{} cannot be written: {} is not a folder", file.display(), folder.display());
    }
    let (run, _folder) = system::packed(&system)?;
    let plan = child::run::plan(&run)?;
    for remark in &run.remarks {
        eprintln!("remark: {remark}");
    }
    for warning in &plan.warnings {
        eprintln!("warning: {warning}");
    }

    let limit = Duration::from_secs_f64(options.time_limit);
    let starter = Starter { limit, interrupted: interruption()?, ..Starter::new()? };
    let progress = Progress::steps(plan.steps);
    let began = Instant::now();
    let finished = child::run::run(&starter, &run, &plan, |done| progress.set(done));
    let took = began.elapsed().as_secs_f64();
    drop(progress);
    if starter.interrupted.load(Ordering::Relaxed) {
        bail!(Interrupted("nothing was written".into()));
    }
    let Finished { messages, recording } = finished?;
    show_messages(&plan, &messages);
    let recording = recording?;

    let mut lines: Vec<String> = recording.ended.iter().cloned().collect();
    lines.push(summary(&plan, recording.times.len() - 1, took));
    if to_stdout {
        print(|to| recording.write_csv(to))?;
    } else if let Some(file) = &options.out {
        temporary::place(file, |to| Ok(recording.write_csv(to)?), |_| Ok(()))?;
        let (rows, columns) = (recording.times.len(), recording.columns.len());
        lines.push(format!("{}: {rows} rows of the time and {columns} variables", file.display()));
    }
    if let (Some(file), Some(is_svg)) = (&options.plot, is_svg) {
        let names: Vec<_> = system.members.iter().map(|fmu| fmu.name.as_str()).collect();
        let picture = draw(&recording, names.join(", "), is_svg)?;
        temporary::place(file, |to| Ok(to.write_all(&picture)?), |_| Ok(()))?;
        lines.push(file.display().to_string());
    }
    if let Some(path) = &options.save {
        let text = file::write(&system.as_in(temporary::folder(path)))?;
        temporary::place(path, |to| Ok(to.write_all(text.as_bytes())?), |_| Ok(()))?;
        lines.push(path.display().to_string());
    }
    lines.push("last row:".into());
    lines.extend(last_row(&recording));
    let text = lines.join("\n");
    if to_stdout {
        eprintln!("{text}");
        return Ok(());
    }
    print(|to| writeln!(to, "{text}"))
}

/// Writes to standard output. Whoever reads may stop when it has enough, as `head` does.
fn print(content: impl FnOnce(&mut BufWriter<StdoutLock>) -> io::Result<()>) -> Result<()> {
    let mut stdout = BufWriter::new(io::stdout().lock());
    match content(&mut stdout).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.context("standard output"),
    }
}

/// What the FMUs have logged, on standard error; the errors among it are part of the error already.
fn show_messages(plan: &Plan, messages: &[(String, String)]) {
    for member in &plan.members {
        let own: Vec<_> = messages.iter().filter(|(name, _)| *name == member.name).collect();
        for (name, message) in own.iter().take(MOST_MESSAGES) {
            eprintln!("{name}: {message}");
        }
        if own.len() > MOST_MESSAGES {
            eprintln!("{}: {} more messages", member.name, own.len() - MOST_MESSAGES);
        }
    }
}

fn summary(plan: &Plan, steps: usize, took: f64) -> String {
    let step = plan.step;
    let proposed =
        plan.step_proposed_by.map_or_else(String::new, |member| format!(", as {} proposes", plan.members[member].name));
    format!(
        "{steps} steps of {step} s{proposed}, from {} s to {} s, in {took:.3} s ({:.0} steps/s)",
        shown(plan.start),
        shown(plan.time(steps)),
        steps as f64 / took.max(1e-9)
    )
}

/// A time or value for people: without the digits that a double adds to it.
fn shown(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn last_row(recording: &Recording) -> Vec<String> {
    let width = recording.columns.iter().map(|column| column.name.chars().count()).max().unwrap_or(0);
    let Some((_, row)) = recording.rows().last() else { return Vec::new() };
    let line = |(column, value): (&run::plan::Column, &f64)| {
        let value = match (column.kind, *value) {
            (Type::Boolean, 0.0) => "false".into(),
            (Type::Boolean, _) => "true".into(),
            (_, value) => shown(value),
        };
        format!("  {:width$}  {value} {}", column.name, column.unit.as_deref().unwrap_or_default())
            .trim_end()
            .to_string()
    };
    recording.columns.iter().zip(row).map(line).collect()
}

fn is_svg(file: &Path) -> Result<bool> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => Ok(true),
        Some("png") => Ok(false),
        _ => bail!("{} is neither .png nor .svg: the plot is one of them", file.display()),
    }
}

/// Draws the recording: Reals of one unit share a panel, as do Integers; a Boolean has a lane.
fn draw(recording: &Recording, title: String, is_svg: bool) -> Result<Vec<u8>> {
    let mut panels: Vec<((Type, Option<&str>), Panel)> = Vec::new();
    let mut lanes = Vec::new();
    for (place, column) in recording.columns.iter().enumerate() {
        let values: Vec<f64> = recording.column(place).collect();
        let curve = Curve { name: column.name.clone(), values, is_input: column.is_input, color: None };
        if column.kind == Type::Boolean {
            lanes.push(curve);
            continue;
        }
        let key = (column.kind, column.unit.as_deref());
        let label = match column.kind {
            Type::Real => column.unit.clone().unwrap_or_default(),
            other => other.name().into(),
        };
        match panels.iter_mut().find(|(of, _)| *of == key) {
            Some((_, panel)) => panel.curves.push(curve),
            None => panels.push((key, Panel { label, curves: vec![curve] })),
        }
    }
    let panels = panels.into_iter().map(|(_, panel)| panel).collect();
    let chart = Chart { title, time: recording.times.clone(), over: None, panels, lanes };
    let svg = plot::svg(&chart)?;
    if is_svg { Ok(svg.into_bytes()) } else { picture::png(&svg) }
}
