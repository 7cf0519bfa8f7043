//! The cost of a step of a closed loop: CONT_C with HEATER as two FMUs (LMN to POWER, TEMP to PV_IN; set, doStep and
//! get on both; setpoint, process value and LMN recorded), by the code that `plcfmu study` uses for its runs.
//!
//! Measured alternately in the same run: the bare blocks in one loop; FMPy, Ecos and libcosim with the same files,
//! driven by `masters.py`. Then whole studies by the command: their duration in seconds with one process and with two.
//!
//! `cargo bench --profile command --package tests --bench study`: built like the command that users get. The FMUs are
//! those of `target/fmu` (or of the folder `PLCFMU_FMUS`), the command is `target/command/plcfmu` (or
//! `PLCFMU_COMMAND`), Python that of `target/venv`. `PLCFMU_BENCH_MEASUREMENTS` is the number of measurements from
//! which the median is taken, `PLCFMU_BENCH_STUDIES` the number of times each study runs.

use anyhow::Context;
use blocks::{ContC, Law, Time};
use host::fmu::Fmu;
use host::instance::Instance;
use modeldescription::Description;
use plants::Heater;
use plcfmu::linked;
use plcfmu::package::ssp;
use run::component::Reset;
use run::master::Run;
use run::plan::Plan;
use run::system::{Connection, Exchange, Member, Recorded, Setting, System};
use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Instant;
use study::experiment::{Executor, Experiment, Gives};
use study::worker;
use study::{Along, Axis, Job, Study};
use tests::setting;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The control cycle and communication step of the comparison, in seconds.
const STEP: f64 = 0.1;

/// Steps in one measurement: few, so that other processes rarely interrupt it.
const STEPS: usize = 3000;

/// How many runs are computed side by side, as in a worker of a study.
const ABREAST: usize = worker::ABREAST;

/// The loop with a control cycle of this many seconds.
fn system(folder: &Path, step: f64, steps: usize) -> Result<System> {
    let settings = [
        "CONT_C.MAN_ON=0".into(),
        "CONT_C.SP_INT=200".into(),
        "CONT_C.GAIN=1.4".into(),
        "CONT_C.TI=80".into(),
        format!("CONT_C.CYCLE={step}"),
        format!("HEATER.CYCLE={step}"),
    ];
    let connections = ["CONT_C.LMN=HEATER.POWER", "HEATER.TEMP=CONT_C.PV_IN"];
    let member = |name: &str| Member { name: name.into(), path: folder.join(format!("{name}.fmu")) };
    Ok(System {
        members: ["CONT_C", "HEATER"].map(member).into(),
        connections: connections
            .iter()
            .map(|text| text.parse::<Connection>())
            .collect::<std::result::Result<_, _>>()?,
        settings: settings.iter().map(|text| text.parse::<Setting>()).collect::<std::result::Result<_, _>>()?,
        record: ["CONT_C.SP_INT", "CONT_C.PV", "CONT_C.LMN"].map(Recorded::from).into(),
        step: Some(step),
        stop: Some(steps as f64 * step),
        exchange: Exchange::Sequential,
        ..System::default()
    })
}

/// The FMUs of the loop.
struct Fmus(Vec<Fmu>);

impl Fmus {
    fn open(folder: &Path) -> Result<Fmus> {
        let open = |name: &str| Ok(Fmu::open(&folder.join(format!("{name}.fmu")))?);
        Ok(Fmus(["CONT_C", "HEATER"].into_iter().map(open).collect::<Result<_>>()?))
    }

    fn descriptions(&self) -> Vec<&Description> {
        self.0.iter().map(|fmu| &fmu.description).collect()
    }

    fn instantiate(&self, member: usize) -> anyhow::Result<Instance> {
        self.0[member].instantiate("bench", false)
    }

    /// The same without the C interface, as in a study.
    fn linked(&self, member: usize) -> anyhow::Result<Box<dyn Reset>> {
        let linked =
            linked::find(&self.0[member].description).context("the FMU is of another version: pack it again")?;
        (linked.instantiate)("bench")
    }

    /// Returns the executor of a study of the loop, with the time constant of the furnace as its coordinate.
    fn executor<C: Reset>(&self, folder: &Path, step: f64, steps: usize) -> Result<Executor<C>> {
        let axis = Axis {
            variables: vec!["HEATER.FURN_TM".into()],
            time: None,
            relative: false,
            whole: false,
            group: None,
            names: Vec::new(),
            along: Along::Uniform { min: 100.0, max: 140.0 },
        };
        let system = System { record: Vec::new(), ..system(folder, step, steps)? };
        let job = Job { system, study: Study { axes: vec![axis], samples: 1_000_000, ..Study::default() } };
        let table = worker::table(&self.0[0].library.interface()?)?;
        let experiment: Experiment = worker::experiment(&job, &self.descriptions(), Some(&table))?;
        Ok(Executor::new(experiment))
    }
}

/// Returns the nanoseconds for one of `count`.
fn time(count: usize, body: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    body();
    begin.elapsed().as_nanos() as f64 / count as f64
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn fastest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Runs the bare blocks in one loop and records their signals.
fn bare(rows: &mut Vec<f64>) {
    let cycle = Time::ms((STEP * 1000.0).round() as i32);
    let mut controller =
        ContC { man_on: false, sp_int: 200.0, gain: 1.4, ti: Time::ms(80_000), cycle, ..ContC::default() };
    let mut plant = Heater { cycle, ..Heater::default() };
    controller.restart();
    plant.restart();
    rows.clear();
    for _ in 0..STEPS {
        controller.pv_in = plant.temp as f32;
        black_box(&mut controller).call();
        plant.power = f64::from(controller.lmn);
        black_box(&mut plant).call();
        rows.extend([controller.sp_int, controller.pv, controller.lmn].map(f64::from));
    }
}

/// Another master, in a Python process.
struct Master {
    name: &'static str,
    process: Child,
    answers: BufReader<ChildStdout>,
    /// Steps in one measurement.
    steps: usize,
}

impl Master {
    fn start(name: &'static str, steps: usize, python: &Path, folder: &Path, ssp: &Path) -> Result<Master> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/masters.py");
        let mut process = Command::new(python)
            .arg(script)
            .arg(name.to_lowercase())
            .arg(folder)
            .arg(ssp)
            .arg(STEP.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let answers = BufReader::new(process.stdout.take().ok_or("it has no output")?);
        let mut master = Master { name, process, answers, steps };
        // Native libraries may print as they start.
        while master.answer()? != "ready" {}
        Ok(master)
    }

    fn answer(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            return Err("it has ended".into());
        }
        Ok(line.trim().into())
    }

    /// Returns the nanoseconds for one step.
    fn measure(&mut self) -> Result<f64> {
        let steps = self.steps;
        writeln!(self.process.stdin.as_mut().ok_or("it has no input")?, "{steps}")?;
        Ok(self.answer()?.parse()?)
    }
}

impl Drop for Master {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn masters(folder: &Path, temporary: &Path) -> Result<Vec<Master>> {
    let python = target().join("venv").join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !python.is_file() {
        println!("left out: FMPy, Ecos and libcosim, since there is no target/venv ('cargo xtask test' makes it)");
        return Ok(Vec::new());
    }
    // The masters exchange all values between the steps and do their own recording.
    let system = System { exchange: Exchange::Parallel, record: Vec::new(), ..system(folder, STEP, 1_000_000)? };
    let file = temporary.join("loop.ssp");
    fs::write(&file, ssp::write(&system, "loop", ssp::Options::default())?.bytes)?;
    let all = [("FMPy", 100), ("Ecos", 1000), ("libcosim", 100)];
    let start = |(name, steps)| match Master::start(name, steps, &python, folder, &file) {
        Ok(master) => Some(master),
        Err(error) => {
            println!("left out: {name}, which does not start here: {error} (tests/requirements.txt)");
            None
        }
    };
    Ok(all.into_iter().filter_map(start).collect())
}

/// The bits of values.
fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Returns the nanoseconds for one step of a loop, and records its rows.
fn steps<C: Reset>(run: &mut Run<C>, plan: &Plan, rows: &mut Vec<f64>) -> Result<f64> {
    run.restart(plan, Some(STEPS as f64 * STEP))?;
    rows.clear();
    Ok(time(STEPS, || {
        for _ in 0..STEPS {
            run.step(plan).unwrap_or_else(|error| panic!("{error:#}"));
            rows.extend_from_slice(run.row());
        }
    }))
}

/// Measures one step of the loop in each way, alternately.
fn compare(folder: &Path, fmus: &Fmus, temporary: &Path) -> Result<()> {
    let measurements = setting("PLCFMU_BENCH_MEASUREMENTS", 301);
    let plan = Plan::new(&system(folder, STEP, STEPS)?, &fmus.descriptions())?;
    let instances = (0..2).map(|member| fmus.instantiate(member)).collect::<anyhow::Result<_>>()?;
    let stop = Some(STEPS as f64 * STEP);
    let mut run = Run::begin(&plan, instances, stop)?;
    let linked = (0..2).map(|member| fmus.linked(member)).collect::<anyhow::Result<_>>()?;
    let mut linked_run = Run::begin(&plan, linked, stop)?;
    let mut executor = fmus.executor(folder, STEP, STEPS)?;
    let mut linked_executor = fmus.executor(folder, STEP, STEPS)?;
    let mut masters = masters(folder, temporary)?;

    let (mut rows, mut bare_rows) = (Vec::with_capacity(3 * STEPS), Vec::with_capacity(3 * STEPS));
    let mut linked_rows = rows.clone();
    let (mut by_run, mut by_study, mut alone) = (Vec::new(), Vec::new(), Vec::new());
    let (mut by_linked_run, mut by_linked_study, mut abreast) = (Vec::new(), Vec::new(), Vec::new());
    let mut by_masters = vec![Vec::new(); masters.len()];
    for number in 0..measurements {
        by_run.push(steps(&mut run, &plan, &mut rows)?);
        by_linked_run.push(steps(&mut linked_run, &plan, &mut linked_rows)?);
        alone.push(time(STEPS, || bare(&mut bare_rows)));
        let point = [100.0 + 40.0 * number as f64 / measurements as f64];
        let mut row = None;
        by_study.push(time(STEPS, || row = Some(executor.row(&point, |member| fmus.instantiate(member)))));
        let mut linked_row = None;
        by_linked_study
            .push(time(STEPS, || linked_row = Some(linked_executor.row(&point, |member| fmus.linked(member)))));
        let points: Vec<_> = (0..ABREAST).map(|run| vec![point[0] + run as f64]).collect();
        let mut rows_abreast = Vec::new();
        abreast.push(time(STEPS * ABREAST, || {
            rows_abreast = linked_executor.rows(&points, Gives::Figures, |member| fmus.linked(member));
        }));
        assert!(linked_row.as_ref().is_some_and(|row| bits(&row.figures) == bits(&rows_abreast[0].figures)));
        let [row, linked_row] = [row, linked_row].map(|row| row.expect("it was made"));
        assert!(row.error.is_none() && bits(&row.figures) == bits(&linked_row.figures), "both compute the same");
        for (master, times) in masters.iter_mut().zip(&mut by_masters) {
            times.push(master.measure()?);
        }
    }
    assert!([&rows, &linked_rows].iter().all(|rows| bits(rows) == bits(&bare_rows)), "all compute the same");

    println!(
        "one step of CONT_C with HEATER at CYCLE {STEP} s; {measurements} measurements of {STEPS} steps, in turns"
    );
    println!("                                        median    fastest  ratio to bare  ratio to the loop");
    let mut all = vec![("bare blocks in one loop", &alone), ("the loop through its FMUs", &by_run)];
    all.push(("a run of a study, with reset and figures", &by_study));
    all.push(("the loop with linked blocks", &by_linked_run));
    all.push(("a run of a study with linked blocks", &by_linked_study));
    all.push(("each of 16 runs side by side", &abreast));
    all.extend(masters.iter().zip(&by_masters).map(|(master, times)| (master.name, times)));
    for (name, times) in all {
        let ratio = |to: &[f64]| median(&times.iter().zip(to).map(|(time, to)| time / to).collect::<Vec<_>>());
        let (median, fastest) = (median(times), fastest(times));
        println!("{name:41}{median:8.1} ns{fastest:8.1} ns{:12.2}{:16.2}", ratio(&alone), ratio(&by_run));
    }
    Ok(())
}

/// Returns the resident memory of this process in kB, which Linux reports.
fn resident() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?.split_whitespace().next()?.parse().ok()
}

/// Shows that the runs of a study leave nothing behind in memory.
fn memory(folder: &Path, fmus: &Fmus) -> Result<()> {
    let mut executor = fmus.executor::<Instance>(folder, 1.0, 60)?;
    let mut after = Vec::new();
    for number in 0..100_000_u64 {
        let point = executor.experiment().point(number);
        black_box(executor.row(&point, |member| fmus.instantiate(member)));
        if [999, 99_999].contains(&number) {
            after.extend(resident().map(|kilobytes| format!("{kilobytes} kB after {} runs", number + 1)));
        }
    }
    println!("memory of a process that makes runs: {}", after.join(", "));
    Ok(())
}

/// Runs a study with the command; returns its duration in seconds.
fn study(command: &Path, file: &Path, folder: &Path, temporary: &Path, jobs: usize) -> Result<f64> {
    let out = temporary.join("results");
    let begin = Instant::now();
    let made = Command::new(command)
        .arg("study")
        .arg(file)
        .arg("--fmus")
        .arg(folder)
        .arg("--out")
        .arg(&out)
        .args(["--format", "csv", "--jobs", &jobs.to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()?;
    let seconds = begin.elapsed().as_secs_f64();
    if !made.status.success() {
        return Err(String::from_utf8_lossy(&made.stderr).into_owned().into());
    }
    fs::remove_dir_all(out)?;
    Ok(seconds)
}

/// Measures whole studies run with the command.
fn studies(folder: &Path, temporary: &Path) -> Result<()> {
    let command = std::env::var_os("PLCFMU_COMMAND").map_or_else(
        || target().join("command").join(format!("plcfmu{}", std::env::consts::EXE_SUFFIX)),
        PathBuf::from,
    );
    if !command.is_file() {
        println!(
            "left out: whole studies, since there is no target/command/plcfmu ('cargo build --profile command -p plcfmu')"
        );
        return Ok(());
    }
    fs::write(
        temporary.join("loop.toml"),
        "[fmus]\nCONT_C = \"CONT_C.fmu\"\nHEATER = \"HEATER.fmu\"\n\
         [connections]\nCONT_C.LMN = \"HEATER.POWER\"\nHEATER.TEMP = \"CONT_C.PV_IN\"\n\
         [settings]\nCONT_C = { MAN_ON = false, SP_INT = 200.0, GAIN = 1.4, TI = 80.0 }\n",
    )?;
    let repeated = setting("PLCFMU_BENCH_STUDIES", 3).max(1);
    for (runs, step, stop) in [(100_000, 0.01, 10), (10_000, 1.0, 3600)] {
        let file = temporary.join("study.toml");
        fs::write(
            &file,
            format!(
                "loop = \"loop.toml\"\nsamples = {runs}\nstep = {step}\nstop = {stop}.0\n\
                 [settings]\nCONT_C.CYCLE = {step:?}\nHEATER.CYCLE = {step:?}\n\
                 [[axes]]\nvariable = \"HEATER.FURN_TM\"\nuniform = {{ min = 100.0, max = 140.0 }}\n"
            ),
        )?;
        let (mut one, mut two) = (Vec::new(), Vec::new());
        for _ in 0..repeated {
            one.push(study(&command, &file, folder, temporary, 1)?);
            two.push(study(&command, &file, folder, temporary, 2)?);
        }
        let ratios: Vec<f64> = one.iter().zip(&two).map(|(one, two)| one / two).collect();
        let steps = f64::from(runs) * f64::from(stop) / step;
        println!(
            "plcfmu study, {runs} runs of {stop} s at {step} s, {steps:.1e} cycles: {:.2} s with one process ({:.1} ns a cycle), \
             {:.2} s with two, ratio {:.2}; medians of {repeated}",
            median(&one),
            median(&one) / steps * 1e9,
            median(&two),
            median(&ratios)
        );
    }
    Ok(())
}

/// The folder `target` of the workspace.
fn target() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target")
}

fn main() -> Result<()> {
    let folder = std::env::var_os("PLCFMU_FMUS").map_or_else(|| target().join("fmu"), PathBuf::from);
    if !folder.join("CONT_C.fmu").is_file() || !folder.join("HEATER.fmu").is_file() {
        println!(
            "left out: everything, since {} has no CONT_C.fmu and HEATER.fmu ('cargo xtask fmu')",
            folder.display()
        );
        return Ok(());
    }
    let folder = folder.canonicalize()?;
    let fmus = Fmus::open(&folder)?;
    let temporary = tempfile::tempdir()?;
    compare(&folder, &fmus, temporary.path())?;
    memory(&folder, &fmus)?;
    studies(&folder, temporary.path())
}
