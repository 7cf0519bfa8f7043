//! `plcfmu run`: runs FMUs together and records them.

mod chart;
mod kept;

use super::{ensure_standard_output, replacing, system, time_limit, told_once};
use crate::exit::Unreadable;
use crate::interruption;
use crate::progress::Progress;
use crate::tell;
use ::program::survey::counted;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use control::figures::{Cause, Happened};
use host::child::run::Finished;
use host::child::{self, Starter};
use host::instance::Type;
use host::package::{Package, temporary};
use kept::{Figures, Kept, Recorder, Told};
use modeldescription::digits::{rounded, short};
use modeldescription::units;
use run::file;
use run::master::write_header;
use run::plan::Plan;
use run::system::System;
use serde_json::{Map, Value, json};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use study::Interrupted;

/// The maximum number of messages shown for each FMU.
const MOST_MESSAGES: usize = 10;

/// Run FMUs together, record and plot them
///
/// Runs any FMI 2.0 or 3.0 FMUs for co-simulation. A variable is named FMU.VARIABLE, such as PID.GAIN; `plcfmu info`
/// lists the variables of an FMU. The native code of the FMUs is executed: use FMUs that you trust.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = SHORT_HELP, after_long_help = LONG_HELP)]
pub struct Options {
    #[command(flatten)]
    system: system::Arguments,
    /// Write the recording as CSV; - is standard output
    #[arg(short, long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Interval between recorded rows, in seconds; the last row is always recorded; by default, one row per step
    #[arg(long, value_name = "SECONDS")]
    every: Option<f64>,
    /// Plot the recording: setpoint and process value, manipulated value, other variables; --record selects them
    #[arg(short, long, value_name = "FILE.png|FILE.svg")]
    plot: Option<PathBuf>,
    /// Write the loop as a description, to be run again with `plcfmu run FILE.toml`
    #[arg(long, value_name = "FILE.toml")]
    save: Option<PathBuf>,
    /// Print a summary of the run with its figures as JSON, for scripts
    #[arg(long)]
    json: bool,
    /// Time limit for each FMU call, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = time_limit)]
    time_limit: f64,
}

const SHORT_HELP: &str = "\
Example, a furnace with its controller:
  plcfmu run PID.fmu FURNACE.fmu \\
    --connect PID.OUT=FURNACE.POWER --connect FURNACE.TEMP=PID.PV \\
    --set PID.GAIN=2 --set PID.SP=60 --set PID.SP=80@300 \\
    --stop 600 --out result.csv --plot result.png

'plcfmu run --help' explains when values are exchanged and what a row of the recording contains.";

const LONG_HELP: &str = "\
Example, a furnace with its controller:
  plcfmu run PID.fmu FURNACE.fmu \\
    --connect PID.OUT=FURNACE.POWER --connect FURNACE.TEMP=PID.PV \\
    --set PID.GAIN=2 --set PID.SP=60 --set PID.SP=80@300 \\
    --stop 600 --out result.csv --plot result.png

Order of a step from t to t + h:
  The FMUs are stepped in the order given. Each FMU first gets the values set at t, then its connected \
   inputs, and then steps to t + h. It therefore sees what the FMUs before it computed in this step, and what the FMUs \
   after it computed in the previous step. With the controller first, its call at t uses the process value at t, and \
   the plant runs from t to t + h with the manipulated value from that call. In the reverse order, the loop has one \
   more step of dead time. With --parallel, all FMUs get their inputs before any of them steps: every connection adds \
   a delay of one step. Step k begins at start + k * step, so rounding errors do not accumulate.

Event Mode (FMI 3.0):
  FMUs with Event Mode exchange their values at t, before any FMU steps, regardless of their order: a controller \
   called at t uses the process value at t, and the plant runs from t to t + h with the manipulated value from that \
   call. With --no-events, they are stepped like the others.

Initialization:
  Each FMU gets its parameters, enters Initialization Mode and gets its inputs. The connected values then \
   propagate from outputs to inputs, in the order of the FMUs, until none changes, but in at most one pass per FMU, \
   and in a single pass with --parallel. Then each FMU leaves Initialization Mode.

Rows of the recording:
  A row belongs to a time: the beginning of each step, and the end of the run. An input has the value that its FMU \
   gets for the step beginning at that time. An output has the value that the connected FMUs read in that step. A \
   controller's row therefore shows what it read and returned in its call at that time, and a plant connected back to \
   the controller shows its state at that time. An output that no FMU reads is recorded like the other outputs of its \
   FMU; if none of them is read, all have their values at that time, before the step. No step is made at the end: the \
   last row has the values last returned by the FMUs. Numbers in the CSV read back bit-identical; Booleans are 1 and 0.

FMUs are foreign code: they run in a separate process. An FMU that crashes or does not return ends the run with an \
   error that names it. What FMUs print goes to standard error. An FMU may end the run (discard with terminated): the \
   rows up to that point are written.";

/// Runs FMUs.
///
/// # Errors
/// An argument or an FMU is unsuitable, or an FMU fails: the error then states the call, the time and the FMU's
/// messages, and no file is written.
pub fn run(options: &Options) -> Result<()> {
    let is_svg = options.plot.as_deref().map(is_svg).transpose()?;
    let to_stdout = options.out.as_deref() == Some(Path::new("-"));
    ensure!(!(to_stdout && options.json), "--out - and --json both write to standard output: specify a file for --out");
    if to_stdout {
        ensure_standard_output()?;
    }
    let system = options.system.system()?;
    let outputs = options.out.iter().filter(|_| !to_stdout).chain(&options.plot).chain(&options.save);
    temporary::check_outputs(outputs.clone().map(PathBuf::as_path), system.inputs())?;
    for file in outputs {
        let folder = temporary::folder(file);
        ensure!(folder.is_dir(), "{} cannot be written: {} is not a folder", file.display(), folder.display());
    }
    let (run, _folder) = system::packed(&system)?;
    let plan = child::run::plan(&run).map_err(|error| unreadable(&run, error))?;
    let every = options.every.map_or(Ok(1), |seconds| every(seconds, &plan))?;
    for remark in &run.remarks {
        tell::remark(remark);
    }
    for warning in &plan.warnings {
        tell::warning(warning);
    }

    let is_drawn = options.plot.is_some();
    let simulated = match options.out.as_deref() {
        Some(_) if to_stdout => {
            let mut stdout = BufWriter::new(io::stdout().lock());
            let simulated = simulate(options, &run, &plan, Some(&mut stdout), every, is_drawn)?;
            match stdout.flush() {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).context("standard output")?,
                _ => simulated,
            }
        }
        Some(file) => {
            let mut simulated = None;
            let record = |to: &mut BufWriter<&File>| {
                let done = simulated.insert(simulate(options, &run, &plan, Some(to), every, is_drawn));
                ensure!(done.is_ok(), "the run failed");
                Ok(())
            };
            let placed = replacing(file, || temporary::place(file, record, |_| Ok(())));
            // The run's own error is more informative than the error about the missing file.
            match simulated {
                Some(Err(error)) => return Err(error),
                Some(Ok(simulated)) => placed.map(|()| simulated)?,
                None => bail!(placed.err().unwrap_or_else(|| anyhow!("nothing was run"))),
            }
        }
        None => simulate(options, &run, &plan, None, every, is_drawn)?,
    };
    let Simulated { kept, steps, ended, took } = simulated;
    let mut lines: Vec<String> = ended.iter().cloned().collect();
    let mut written = Vec::new();
    lines.push(summary(&plan, steps, took));
    if let Some(file) = options.out.as_ref().filter(|_| !to_stdout) {
        let (rows, columns) = (kept.recorded, plan.columns.len());
        let plural = if columns == 1 { "" } else { "s" };
        lines.push(format!("{}: {rows} rows with the time and {columns} variable{plural}", file.display()));
        written.push(file);
    }
    let figures = kept.figures();
    if let (Some(file), Some(is_svg)) = (&options.plot, is_svg) {
        let title = title(&system, figures.as_ref().ok(), kept.unit.as_deref());
        let picture = chart::draw(&kept, &plan, title, !system.record.is_empty(), is_svg)?;
        replacing(file, || temporary::place(file, |to| Ok(to.write_all(&picture.bytes)?), |_| Ok(())))?;
        let left_out = match picture.left_out {
            0 => String::new(),
            count => format!(" (variables that do not fit: {count}; --record selects the variables to plot)"),
        };
        lines.push(format!("{}{left_out}", file.display()));
        written.push(file);
    }
    if let Some(path) = &options.save {
        let text = file::write(&system.as_in(temporary::folder(path)))?;
        replacing(path, || temporary::place(path, |to| Ok(to.write_all(text.as_bytes())?), |_| Ok(())))?;
        lines.push(path.display().to_string());
        written.push(path);
    }
    if options.json {
        return print(&as_json(&kept, &plan, steps, ended.as_deref(), &figures, &written)?);
    }
    lines.extend(figure_lines(&figures, plan.step));
    if !system.record.is_empty() {
        lines.push("last row:".into());
        lines.extend(last_row(&kept, &plan));
    }
    let text = format!("{}\n", lines.join("\n"));
    if to_stdout {
        tell::raw(&text);
        return Ok(());
    }
    print(&text)
}

/// A completed run.
struct Simulated<'a> {
    kept: Kept<'a>,
    /// The number of completed steps.
    steps: usize,
    /// The FMU that ended the run early, and when.
    ended: Option<String>,
    /// The elapsed real time, in seconds.
    took: f64,
}

/// Runs the FMUs, writing the recording as they run.
fn simulate<'a>(
    options: &Options,
    system: &'a System,
    plan: &'a Plan,
    mut csv: Option<&mut dyn Write>,
    every: usize,
    is_drawn: bool,
) -> Result<Simulated<'a>> {
    if let Some(csv) = &mut csv {
        write_header(*csv, plan.columns.iter()).or_else(|error| match error.kind() {
            io::ErrorKind::BrokenPipe => Ok(()),
            _ => Err(error),
        })?;
    }
    let limit = Duration::from_secs_f64(options.time_limit);
    let starter = Starter { limit, interrupted: interruption::flag(), ..Starter::new()? };
    let progress = Progress::steps(plan.steps);
    let began = Instant::now();
    let mut recorder = Recorder::new(system, plan, csv, every, is_drawn);
    let finished = child::run::run(&starter, system, plan, &mut recorder, |done| progress.set(done));
    let took = began.elapsed().as_secs_f64();
    drop(progress);
    if starter.interrupted.load(Ordering::Relaxed) {
        bail!(Interrupted("nothing was written".into()));
    }
    let Finished { messages, steps, ended } = finished?;
    show_messages(plan, &messages);
    let ended = ended?;
    Ok(Simulated { kept: recorder.finish()?, steps, ended, took })
}

/// Converts a recording interval in seconds to a number of steps: one row in this many is recorded.
fn every(seconds: f64, plan: &Plan) -> Result<usize> {
    let steps = seconds / plan.step;
    ensure!(
        steps >= 0.5 && (steps - steps.round()).abs() <= 1e-6 * steps && steps < 1e12,
        "--every {seconds}: the interval must be a whole number of steps of {} s",
        plan.step
    );
    Ok(steps.round() as usize)
}

/// The error for a system that cannot be planned, wrapped in [`Unreadable`] if one of its FMUs cannot be read.
fn unreadable(system: &System, error: Error) -> Error {
    let can_be_read = system.members.iter().all(|member| Package::open(&member.path).is_ok());
    if can_be_read { error } else { Unreadable(error).into() }
}

fn as_json(
    kept: &Kept,
    plan: &Plan,
    steps: usize,
    ended: Option<&str>,
    figures: &Result<Figures, String>,
    written: &[&PathBuf],
) -> Result<String> {
    let last = |(column, value): (&run::plan::Column, &f64)| {
        let value = match (column.kind, value) {
            (Type::Boolean, value) => json!(*value != 0.0),
            (_, value) if value.is_finite() => json!(value),
            (_, value) => json!(value.to_string()),
        };
        (column.name.clone(), value)
    };
    let last: Map<String, Value> = plan.columns.iter().zip(&kept.last).map(last).collect();
    let told = json!({
        "start": plan.start,
        "stop": plan.time(steps),
        "step": plan.step,
        "steps": steps,
        "ended": ended,
        "warnings": plan.warnings,
        "figures": figures.as_ref().map_or(&[][..], |figures| &figures.last),
        "events": figures.as_ref().map_or(&[][..], |figures| &figures.events),
        "last": last,
        "written": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
    });
    Ok(format!("{}\n", serde_json::to_string_pretty(&told)?))
}

/// Writes to standard output. The reader may stop early, as `head` does.
fn print(text: &str) -> Result<()> {
    super::print(text)
}

/// Prints messages logged by the FMUs of a completed run to standard error, at most [`MOST_MESSAGES`] for each FMU.
fn show_messages(plan: &Plan, messages: &[(String, String)]) {
    let mut shown = Vec::new();
    for member in &plan.members {
        let own: Vec<_> = messages.iter().filter(|(name, _)| *name == member.name).cloned().collect();
        let more = own.len().saturating_sub(MOST_MESSAGES);
        shown.extend(own.into_iter().take(MOST_MESSAGES));
        if more > 0 {
            shown.push((member.name.clone(), format!("more messages, not shown: {more}")));
        }
    }
    for line in told_once(shown) {
        tell::text(&line);
    }
}

fn summary(plan: &Plan, steps: usize, took: f64) -> String {
    let step = plan.step;
    let proposed =
        plan.step_proposed_by.map_or_else(String::new, |member| format!(", as {} proposes", plan.members[member].name));
    format!(
        "{} of {step} s{proposed}, from {} s to {} s, in {took:.3} s ({:.0} steps/s)",
        counted(steps, "step", "steps"),
        plan.start,
        plan.time(steps),
        steps as f64 / took.max(1e-9)
    )
}

/// The figures as lines of text: a heading and the figures of each step and each disturbance, or the figures of the
/// whole run if there are none. If there are no figures, a line stating why.
fn figure_lines(figures: &Result<Figures, String>, cycle: f64) -> Vec<String> {
    let figures = match figures {
        Ok(figures) => figures,
        Err(why) => return vec![why.clone()],
    };
    let all = figures.events.iter().flat_map(|of| &of.figures).chain(&figures.last);
    let width = all.map(|figure| figure.title.chars().count()).max().unwrap_or(0);
    let lines = |of: &[Told]| -> Vec<String> {
        let line = |figure: &Told| {
            let unit = figure.unit.as_deref().map_or_else(String::new, |unit| format!(" {}", units::product(unit)));
            let text = match (figure.value, &figure.why) {
                (Some(value), _) => {
                    let least = if figure.unit.as_deref() == Some("s") { cycle / 10.0 } else { 0.0 };
                    format!("{}{unit}", rounded(value, least))
                }
                (None, why) => format!("none: {}", why.as_deref().unwrap_or_default()),
            };
            format!("  {:width$}  {text}", figure.title)
        };
        of.iter().map(line).collect()
    };
    if !figures.events.is_empty() {
        let of_event = |of: &kept::Of| [vec![heading(&of.happened)], lines(&of.figures)].concat();
        return figures.events.iter().flat_map(of_event).collect();
    }
    if figures.last.iter().any(|figure| figure.value.is_some()) {
        return [vec!["figures:".into()], lines(&figures.last)].concat();
    }
    let why = figures.last.iter().find_map(|figure| figure.why.as_ref());
    why.map(|why| format!("no figures: {why}")).into_iter().collect()
}

/// The title of a picture: the controller, the other FMUs, and the first event.
fn title(system: &System, figures: Option<&Figures>, unit: Option<&str>) -> String {
    let names: Vec<&str> = system.members.iter().map(|fmu| fmu.name.as_str()).collect();
    let loop_name = match names.as_slice() {
        [first, others @ ..] if !others.is_empty() => format!("{first} with {}", others.join(", ")),
        _ => names.concat(),
    };
    let [first, others @ ..] = figures.map_or(&[][..], |figures| &figures.events) else { return loop_name };
    let more = if others.is_empty() { "" } else { ", and more" };
    let unit = unit.map_or_else(String::new, |unit| format!(" {}", units::shown(unit)));
    format!("{loop_name}: {}{more}", event(&first.happened, &unit))
}

/// A description of the event, in one line.
fn heading(happened: &Happened) -> String {
    format!("{}:", event(happened, ""))
}

fn event(Happened { cause, from, to, start, by, .. }: &Happened, unit: &str) -> String {
    let step = format!("from {} to {}{unit}", rounded(*from, 0.0), short(*to));
    match cause {
        Cause::Start => format!("step at the start, {step}"),
        Cause::Setpoint => format!("setpoint step at {} s, {step}", short(*start)),
        Cause::Automatic => format!("step at the start of automatic mode at {} s, {step}", short(*start)),
        Cause::Disturbance => {
            let set = by.iter().filter_map(|set| Some(format!("{} = {}", set.variable, short(set.value?))));
            format!("disturbance at {} s, {}", short(*start), set.collect::<Vec<_>>().join(", "))
        }
    }
}

fn last_row(kept: &Kept, plan: &Plan) -> Vec<String> {
    let width = plan.columns.iter().map(|column| column.name.chars().count()).max().unwrap_or(0);
    let line = |(column, value): (&run::plan::Column, &f64)| {
        let value = match (column.kind, *value) {
            (Type::Boolean, 0.0) => "false".into(),
            (Type::Boolean, _) => "true".into(),
            (_, value) => short(value),
        };
        let unit = column.unit.as_deref().unwrap_or_default();
        tell::plain(format!("  {:width$}  {value} {unit}", column.name).trim_end())
    };
    plan.columns.iter().zip(&kept.last).map(line).collect()
}

fn is_svg(file: &Path) -> Result<bool> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => Ok(true),
        Some("png") => Ok(false),
        _ => bail!("{}: the file name of a plot must end in .png or .svg", file.display()),
    }
}
