use super::*;
use crate::{Along, Axis, Limit, Sampling, Study, Take, Taken};
use anyhow::bail;
use blocks::Block;
use control::figures;
use doubles::{Lag, Linked, Pid, TestHome};
use modeldescription::Table;
use run::component::{Component, Type};
use run::dialog;
use run::fmus::Fmus;
use run::system::{Member, Value};
use std::cell::Cell;
use std::rc::Rc;

/// A controller C and a plant P in a loop of 60 s, with a setpoint step at 5 s.
fn job(axes: Vec<Axis>) -> Job {
    let system = System {
        members: ["C", "P"].map(|name| Member { name: name.into(), path: format!("{name}.fmu").into() }).into(),
        connections: ["C.OUT=P.POWER", "P.TEMP=C.PV_IN"].map(|text| text.parse().unwrap()).into(),
        settings: ["C.GAIN=0.5", "C.TI=10", "C.SP=40@5"].map(|text| text.parse().unwrap()).into(),
        stop: Some(60.0),
        step: Some(0.5),
        ..System::default()
    };
    Job { system, study: Study { axes, ..Study::default() } }
}

fn axis(variable: &str, along: Along) -> Axis {
    Axis { variables: vec![variable.into()], along, ..Axis::default() }
}

fn values(values: &[f64]) -> Along {
    Along::Values(values.iter().map(|value| Value::Number(*value)).collect())
}

fn resolved(job: &Job) -> Result<Experiment> {
    let home = TestHome::default();
    let descriptions = [home.description("PID").unwrap(), home.description("LAG").unwrap()];
    let (roles, _) = dialog::read(&Table::from(Pid::TABLE)).unwrap();
    Experiment::new(job, &descriptions.each_ref().map(|description| &**description), Some(&roles))
}

fn experiment(axes: Vec<Axis>) -> Experiment {
    resolved(&job(axes)).unwrap()
}

fn error(job: &Job) -> String {
    format!("{:#}", resolved(job).unwrap_err())
}

type Made = Result<Box<dyn Reset>>;

fn instantiate(member: usize) -> Made {
    Ok(if member == 0 { Box::new(Linked::<Pid>::reliable()) } else { Box::new(Linked::<Lag>::reliable()) })
}

fn points(experiment: &Experiment) -> Vec<Vec<f64>> {
    (0..experiment.count()).map(|run| experiment.point(run)).collect()
}

fn bits(row: &RunResult) -> Vec<u64> {
    row.figures.iter().map(|figure| figure.to_bits()).collect()
}

#[test]
fn axes_of_a_group_go_together_and_the_others_span_a_grid_with_them() {
    let grouped = |variable: &str, list: &[f64]| Axis { group: Some("loops".into()), ..axis(variable, values(list)) };
    let axes =
        vec![grouped("C.GAIN", &[1.0, 2.0]), axis("C.TI", values(&[7.0, 8.0, 9.0])), grouped("C.SP", &[5.0, 6.0])];
    let experiment = experiment(axes.clone());
    assert_eq!(experiment.count(), 6);
    let expected =
        [[1.0, 7.0, 5.0], [1.0, 8.0, 5.0], [1.0, 9.0, 5.0], [2.0, 7.0, 6.0], [2.0, 8.0, 6.0], [2.0, 9.0, 6.0]];
    assert_eq!(points(&experiment), expected);
    let study = |axes| Study { axes, ..Study::default() };
    let error = |axes| format!("{:#}", study(axes).check().unwrap_err());
    let uneven = vec![axes[0].clone(), grouped("C.SP", &[5.0])];
    assert!(
        error(uneven)
            .contains("it has 1 value, but axis 1 (C.GAIN) in the same group has 2: both must have the same number")
    );
    let uniform = || Along::Uniform { min: 1.0, max: 2.0 };
    let drawn = Axis { group: Some("x".into()), ..axis("C.SP", uniform()) };
    assert!(error(vec![drawn]).contains("remove `group`"));
    assert!(error(vec![Axis { whole: true, ..axes[1].clone() }]).contains("`whole` applies only to distributions"));
    let named = |axis: &Axis, names: [&str; 2]| Axis { names: names.map(String::from).to_vec(), ..axis.clone() };
    let swapped = error(vec![named(&axes[0], ["TIC1", "TIC2"]), named(&axes[2], ["TIC2", "TIC1"])]);
    assert!(
        swapped.contains("row 1 belongs to TIC2, but row 1 of axis 1 (C.GAIN), in the same group, belongs to TIC1"),
        "{swapped}"
    );
    let apart = Axis { group: None, ..named(&axes[2], ["TIC1", "TIC2"]) };
    assert!(error(vec![named(&axes[0], ["TIC1", "TIC2"]), apart]).contains("put both in the same group"));
    // Three runs of each loop, one after the other.
    let loops = self::experiment(vec![named(&axes[0], ["TIC1", "TIC2"]), axes[1].clone()]).loops.unwrap();
    assert_eq!([0, 2, 3, 5].map(|run| loops.name(run)), ["TIC1", "TIC1", "TIC2", "TIC2"]);
}

#[test]
fn lists_and_ranges_span_a_grid_with_the_first_axis_slowest() {
    let range = Along::Range { from: 10.0, to: 20.0, count: 3, logarithmic: false };
    let experiment = experiment(vec![axis("C.GAIN", values(&[1.0, 2.0])), axis("C.TI", range)]);
    let expected = [[1.0, 10.0], [1.0, 15.0], [1.0, 20.0], [2.0, 10.0], [2.0, 15.0], [2.0, 20.0]];
    assert_eq!(points(&experiment), expected);
    let names: Vec<_> = experiment.coordinates.iter().map(|of| (of.name.as_str(), of.unit.as_deref())).collect();
    assert_eq!(names, [("C.GAIN", None), ("C.TI", Some("s"))]);
}

#[test]
fn at_each_point_of_the_grid_the_samples_are_the_same() {
    let uniform = Along::Uniform { min: 5.0, max: 15.0 };
    let mut job = job(vec![axis("P.T", uniform), axis("C.GAIN", values(&[1.0, 2.0]))]);
    job.study.samples = 3;
    let points = points(&resolved(&job).unwrap());
    assert_eq!(points.iter().map(|point| point[1]).collect::<Vec<_>>(), [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let samples: Vec<f64> = points.iter().map(|point| point[0]).collect();
    assert_eq!(samples[..3], samples[3..]);
    assert!(samples[0] != samples[1] && samples.iter().all(|value| (5.0..15.0).contains(value)), "{samples:?}");
}

#[test]
fn the_rows_of_an_axis_give_each_variable_its_own_value() {
    let rows =
        Along::Rows(vec![vec![Value::Number(1.0), Value::Number(5.0)], vec![Value::Number(2.0), Value::Number(9.0)]]);
    let variables = vec!["C.GAIN".to_string(), "C.TI".into()];
    let experiment = experiment(vec![Axis { variables, along: rows, ..Axis::default() }]);
    assert_eq!(points(&experiment), [[1.0, 5.0], [2.0, 9.0]]);
}

#[test]
fn relative_values_are_factors_of_what_the_loop_sets_or_of_the_start_value() {
    let factors = || values(&[0.5, 2.0]);
    let relative = |variable, time| Axis { relative: true, time, ..axis(variable, factors()) };
    let axes = vec![
        relative("C.GAIN", None),
        relative("P.T", None),
        relative("C.SP", Some(5.0)),
        relative("C.SP", Some(30.0)),
    ];
    let experiment = experiment(axes);
    assert_eq!(experiment.point(0), [0.25, 5.0, 20.0, 20.0]);
    assert_eq!(experiment.point(15), [1.0, 20.0, 80.0, 80.0]);
    let names: Vec<_> = experiment.coordinates.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["C.GAIN", "P.T", "C.SP@5", "C.SP@30"]);
}

#[test]
fn the_figures_are_those_of_the_signals_that_the_first_fmu_tells_and_of_single_variables() {
    let mut job = job(vec![axis("C.GAIN", values(&[0.5]))]);
    job.study.values = vec![Taken { variable: "P.TEMP".into(), take: vec![Take::Max, Take::Last] }];
    job.study.limits = vec![Limit { variable: "C.OUT".into(), min: None, max: Some(50.0) }];
    let figures = resolved(&job).unwrap().figures;
    let names: Vec<_> = figures.iter().map(|of| (of.name.as_str(), of.unit.as_deref().unwrap_or("-"))).collect();
    let of_variables = [("P.TEMP.max", "degC"), ("P.TEMP.last", "degC"), ("C.OUT.violation", "s")];
    let of_step = [
        ("rise", "s"),
        ("overshoot", "%"),
        ("settling", "s"),
        ("iae", "K s"),
        ("ise", "K^2 s"),
        ("peak", "K"),
        ("pulses", "-"),
    ];
    assert_eq!(names, [&of_step[..], &of_variables].concat());
    // The mean of pulses has no travel figure unless the user names it; what is set in the plant disturbs the loop.
    job.study.signals.manipulated_value = Some("C.OUT".into());
    job.study.axes.push(Axis { time: Some(40.0), ..axis("P.LOAD", values(&[5.0])) });
    let figures = resolved(&job).unwrap().figures;
    let more = figures.iter().filter(|of| !names.iter().any(|(name, _)| *name == of.name));
    let more: Vec<_> = more.map(|of| (of.name.as_str(), of.unit.as_deref())).collect();
    let expected =
        [("travel", Some("%")), ("recovery", Some("s")), ("disturbed_peak", Some("K")), ("disturbed_iae", Some("K s"))];
    assert_eq!(more, expected);
}

#[test]
fn a_reset_instance_makes_the_same_bits_as_a_new_one() {
    let experiment = experiment(vec![axis("C.GAIN", values(&[0.1, 0.5, 2.0])), axis("P.T", values(&[3.0, 10.0]))]);
    let mut reused = Executor::new(experiment.clone());
    let mut instances = 0;
    for run in 0..experiment.count() {
        let point = experiment.point(run);
        let row = reused.row(&point, |member| {
            instances += 1;
            instantiate(member)
        });
        assert_eq!(row.error, None);
        let mut anew = Executor::new(experiment.clone());
        assert_eq!(bits(&row), bits(&anew.row(&point, instantiate)), "run {run}");
    }
    assert_eq!(instances, 2);
    assert_eq!(reused.check_reset(instantiate), None);
}

#[test]
fn the_values_of_a_point_are_what_the_fmus_get() {
    let mut job =
        job(vec![axis("C.GAIN", values(&[0.5, 3.0])), Axis { time: Some(5.0), ..axis("C.SP", values(&[40.0])) }]);
    let take = |variable: &str| Taken { variable: variable.into(), take: vec![Take::Last] };
    job.study.values = vec![take("C.GAIN"), take("C.SP")];
    let experiment = resolved(&job).unwrap();
    let mut executor = Executor::new(experiment.clone());
    for point in [vec![3.0, 60.0], vec![0.25, -20.0]] {
        let row = executor.row(&point, instantiate);
        assert_eq!(row.figures[7..], point);
    }
}

#[test]
fn an_axis_replaces_what_the_loop_sets_for_its_variable_then() {
    // The loop sets SP at 5 s and GAIN at the start; SP at the start is a different setting.
    let sp = |time| Axis { time, ..axis("C.SP", values(&[10.0])) };
    let experiment = experiment(vec![axis("C.GAIN", values(&[1.0])), sp(Some(5.0)), sp(None)]);
    let controller = &experiment.plan.members[0];
    assert_eq!(controller.events.len(), 1);
    assert_eq!(controller.inputs.iter().map(|of| of.value).collect::<Vec<_>>(), [10.0]);
    assert_eq!(controller.parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [10.0, 1.0], "TI and GAIN");
    // What the loop sets at other times is kept.
    let events = self::experiment(vec![sp(None)]).plan.members[0].events.clone();
    assert_eq!(events.iter().map(|(time, of)| (*time, of.value)).collect::<Vec<_>>(), [(5.0, 40.0)]);
}

#[test]
fn a_wrong_axis_is_named_with_what_is_wrong_and_what_to_do() {
    let normal = |mean, deviation, min, max| Along::Normal { mean, deviation, min, max };
    let range = |from, to, count, logarithmic| Along::Range { from, to, count, logarithmic };
    let wrong = [
        (values(&[]), "`values` is empty: specify at least one value"),
        (values(&[f64::NAN]), "`values` contains NaN: use finite numbers"),
        (Along::Rows(vec![]), "`values` is empty: specify at least one row"),
        (
            Along::Rows(vec![vec![Value::Number(1.0); 2]]),
            "row 1 of `values` has 2 values for 1 variable: each variable needs one",
        ),
        (
            range(1.0, 2.0, 1, false),
            "range: count = 1: a range has at least 2 values; for a single one write values = [1.0]",
        ),
        (range(1.0, 1.0, 3, false), "range: from and to are both 1.0: use different ends, or write values = [1.0]"),
        (
            range(0.0, 1.0, 3, true),
            "range: from = 0.0, to = 1.0: both ends of a logarithmic range must be above 0; correct them, or omit \
             `logarithmic`",
        ),
        (range(1.0, f64::INFINITY, 3, false), "range: to = inf: use a finite number"),
        (Along::Uniform { min: 2.0, max: 1.0 }, "uniform: min = 2.0 is above max = 1.0: swap them"),
        (
            Along::Uniform { min: 2.0, max: 2.0 },
            "uniform: min and max are both 2.0: use different bounds, or write values = [2.0]",
        ),
        (
            Along::Uniform { min: -1e308, max: 1e308 },
            "uniform: -1e308 and 1e308 are too far apart: use bounds whose difference is below 1.8e308",
        ),
        (normal(1.0, 0.0, None, None), "normal: deviation = 0.0: it must be above 0"),
        (normal(1.0, 0.1, Some(2.0), Some(1.0)), "normal: min = 2.0 is above max = 1.0: swap them"),
        (
            normal(1.0, 0.1, Some(9.0), None),
            "normal: practically no values are within the bounds, since the mean is 1.0 and the deviation 0.1: use \
             bounds closer to the mean",
        ),
        (Along::LogNormal { median: -1.0, deviation: 0.1 }, "log_normal: median = -1.0: it must be above 0"),
        (
            Along::LogNormal { median: 1.0, deviation: 200.0 },
            "the distribution is too wide: C.GAIN = inf: use values and factors whose products are finite",
        ),
        (Along::LogNormal { median: 1.0, deviation: -0.1 }, "log_normal: deviation = -0.1: it must be above 0"),
        (
            Along::Triangular { min: 0.0, mode: 3.0, max: 2.0 },
            "triangular: mode = 3.0 is not between min = 0.0 and max = 2.0: correct one of them",
        ),
    ];
    for (along, expected) in wrong {
        let job = job(vec![axis("P.T", values(&[5.0])), axis("C.GAIN", along)]);
        assert_eq!(error(&job), format!("axis 2 (C.GAIN): {expected}"));
    }
}

#[test]
fn a_variable_that_cannot_be_varied_says_why() {
    let one = || values(&[1.0]);
    let at = |variable, time| Axis { time: Some(time), ..axis(variable, one()) };
    let relative = |variable| Axis { relative: true, ..axis(variable, one()) };
    let distributed = |variable| axis(variable, Along::Uniform { min: 0.0, max: 1.0 });
    let range = |variable, to| axis(variable, Along::Range { from: 0.0, to, count: 3, logarithmic: false });
    let wrong = [
        (axis("C.GAIM", one()), "axis 1 (C.GAIM): C has no variable GAIM; did you mean C.GAIN?"),
        (
            axis("C.OUT", one()),
            "axis 1 (C.OUT): C.OUT cannot be set: its causality is output; only inputs and parameters can be set",
        ),
        (axis("C.PV_IN", one()), "axis 1 (C.PV_IN): C.PV_IN cannot be set: it is connected to P.TEMP"),
        (
            at("C.BITS", 5.0),
            "axis 1 (C.BITS): C.BITS cannot be set at 5.0 s: it is a fixed parameter; during a run, only inputs and \
             tunable parameters can be set",
        ),
        (
            at("C.SP", 99.0),
            "axis 1 (C.SP): C.SP cannot be set at 99.0 s: the first step begins at 0.0 s, the last at 59.5 s",
        ),
        (at("C.SP", f64::NAN), "axis 1 (C.SP): time = NaN: specify a time in seconds"),
        (axis("C.BITS", values(&[1.5])), "axis 1 (C.BITS): C.BITS = 1.5: it is Integer; 1.5 is not a 32-bit integer"),
        (
            axis("C.MAN_ON", values(&[2.0])),
            "axis 1 (C.MAN_ON): C.MAN_ON = 2.0: it is Boolean; 2.0 is neither true (1) nor false (0)",
        ),
        (
            axis("C.GAIN", Along::Values(vec![Value::Boolean(true)])),
            "axis 1 (C.GAIN): C.GAIN: it is Real; true is not a number",
        ),
        (
            distributed("C.BITS"),
            "axis 1 (C.BITS): C.BITS is Integer, and distributions yield fractions: add whole = true, or write its values as a list, values = [...]",
        ),
        (
            range("C.BITS", 3.0),
            "axis 1 (C.BITS): range: write the values as a list, values = [...]: C.BITS = 1.5: it is Integer; 1.5 is not a \
             32-bit integer",
        ),
        (
            relative("C.MAN_ON"),
            "axis 1 (C.MAN_ON): C.MAN_ON is Boolean, which has no factors: omit `relative` and write values = [false, \
             true]",
        ),
        (
            relative("C.MAN"),
            "axis 1 (C.MAN): C.MAN is 0 in the loop, so any factor leaves it 0: omit `relative`, or set another value \
             in the loop",
        ),
        (
            Axis { variables: vec![], ..axis("", one()) },
            "axis 1 (): it has no variable: write variable = \"FMU.VARIABLE\"",
        ),
        (
            Axis { variables: vec!["C.GAIN".into(), "C.GAIN".into()], ..axis("", one()) },
            "axis 1 (C.GAIN, C.GAIN): C.GAIN is named twice: remove one of the two",
        ),
    ];
    for (axis, expected) in wrong {
        assert_eq!(error(&job(vec![axis])), expected);
    }
    let twice = job(vec![axis("C.GAIN", one()), axis("C.TI", one()), axis("C.GAIN", one())]);
    assert_eq!(error(&twice), "axis 3 (C.GAIN): C.GAIN is also varied by axis 1 (C.GAIN): keep it in only one of them");
}

#[test]
fn an_integer_range_of_whole_numbers_and_a_list_of_switches_are_fine() {
    let range = Along::Range { from: 2.0, to: 6.0, count: 3, logarithmic: false };
    let switch = Along::Values(vec![Value::Boolean(false), Value::Boolean(true)]);
    let experiment = experiment(vec![axis("C.BITS", range), axis("C.P_SEL", switch)]);
    assert_eq!(points(&experiment)[..3], [[2.0, 0.0], [2.0, 1.0], [4.0, 0.0]]);
}

#[test]
fn samples_and_runs_have_bounds() {
    let uniform = || axis("C.GAIN", Along::Uniform { min: 1.0, max: 2.0 });
    let mut job = job(vec![uniform()]);
    job.study.samples = 0;
    assert_eq!(error(&job), "samples = 0: the distributions need at least 1 sample");
    job.study = Study { samples: 70_000, sampling: Sampling::Sobol, ..job.study };
    assert_eq!(
        error(&job),
        "samples = 70000: a Sobol sequence has at most 65536 samples; use fewer, or set sampling = \"latin_hypercube\""
    );
    let range = Along::Range { from: 1.0, to: 2.0, count: 20_000, logarithmic: false };
    job.study = Study { sampling: Sampling::Random, axes: vec![uniform(), axis("C.TI", range)], ..job.study };
    assert_eq!(
        error(&job),
        "the axes span 20000 x 70000 runs, but a study has at most 1000000000: use fewer values or samples"
    );
    job.study.axes = vec![axis("C.GAIN", values(&[1.0]))];
    assert_eq!(
        error(&job),
        "samples = 70000, but no axis has a distribution: omit `samples`, or give an axis a distribution: uniform, \
         normal, log_normal or triangular"
    );
}

#[test]
fn ranges_keep_their_ends_and_their_ratios() {
    let range = Along::Range { from: 0.1, to: 10.0, count: 3, logarithmic: true };
    let points = points(&experiment(vec![axis("C.GAIN", range)]));
    assert_eq!((points[0][0], points[2][0]), (0.1, 10.0));
    assert_eq!(points[1][0], 1.0);
    let range = Along::Range { from: 1e-300, to: 1e300, count: 3, logarithmic: true };
    assert_eq!(self::points(&experiment(vec![axis("C.GAIN", range)]))[1], [1.0]);
    let range = Along::Range { from: 1.0, to: 0.0, count: 11, logarithmic: false };
    let points = self::points(&experiment(vec![axis("C.GAIN", range)]));
    assert!(points.iter().enumerate().all(|(place, point)| (point[0] - (1.0 - place as f64 * 0.1)).abs() < 1e-15));
}

#[test]
fn values_outside_of_the_declared_range_are_a_warning_for_each_axis() {
    let mut job = job(vec![
        Axis { time: Some(5.0), ..axis("C.SP", values(&[150.0, 50.0, 160.0])) },
        axis("C.CYCLE", values(&[0.5])),
    ]);
    let warning = "axis 1 (C.SP): values such as C.SP = 160 are outside the range declared by the FMU, -100.0 to 100.0";
    assert_eq!(resolved(&job).unwrap().warnings, [warning]);
    // Settings that the axis replaces are ignored; other settings of the loop are not.
    job.system.settings.push("C.SP=-500@30".parse().unwrap());
    job.study.axes.remove(0);
    let warning = "C.SP = -500.0 is outside the range declared by the FMU, -100.0 to 100.0";
    assert_eq!(resolved(&job).unwrap().warnings, [warning]);
    job.study.axes.push(Axis { time: Some(30.0), ..axis("C.SP", values(&[0.0])) });
    assert_eq!(resolved(&job).unwrap().warnings, [""; 0]);
}

#[test]
fn a_number_of_samples_that_is_probably_not_meant_is_a_warning() {
    let mut job = job(vec![axis("C.GAIN", Along::Uniform { min: 1.0, max: 2.0 })]);
    let single = "samples = 1: each distribution yields a single value; use more samples";
    assert_eq!(resolved(&job).unwrap().warnings, [single]);
    job.study = Study { samples: 1000, sampling: Sampling::Sobol, ..job.study };
    let uneven = "samples = 1000: a Sobol sequence is most even if the number of samples is a power of 2, such as 1024";
    assert_eq!(resolved(&job).unwrap().warnings, [uneven]);
    job.study.samples = 1024;
    assert_eq!(resolved(&job).unwrap().warnings, [""; 0]);
}

#[test]
fn a_mistake_of_the_loop_is_not_said_to_be_one_of_an_axis() {
    let mut job = job(vec![axis("C.GAIN", values(&[1.0]))]);
    job.system.settings.push("C.TIM=1".parse().unwrap());
    assert_eq!(error(&job), "C has no variable TIM; did you mean C.TI?");
}

/// A controller with a fault.
struct Faulty {
    inner: Linked<Pid>,
    /// The TI that was set; below 1 s, the controller refuses to step from 10 s on.
    ti: f64,
    fault: Fault,
    /// The residue of the previous run, which is added to the manipulated value.
    residue: f64,
    instances: Rc<Cell<usize>>,
    /// The value references of OUT and TI.
    references: [u32; 2],
}

#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    ResetKeepsState,
    ResetRefused,
    /// Only one instance can exist at a time.
    OneInstance,
}

impl Faulty {
    fn new(fault: Fault, instances: &Rc<Cell<usize>>) -> Faulty {
        instances.set(instances.get() + 1);
        let table = Table::from(Pid::TABLE);
        let references = ["OUT", "TI"].map(|name| table.find(name).unwrap() as u32);
        Faulty { inner: Linked::reliable(), ti: 0.0, fault, residue: 0.0, instances: Rc::clone(instances), references }
    }
}

impl Component for Faulty {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.inner.setup(start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.inner.enter_initialization()
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.inner.exit_initialization()
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.inner.read(kind, references, values)?;
        for (value, _) in values.iter_mut().zip(references).filter(|(_, of)| **of == self.references[0]) {
            *value += self.residue;
        }
        Ok(())
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        if references[0] == self.references[1] {
            self.ti = values[0];
        }
        self.inner.write(kind, references, values)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        if self.ti < 1.0 && time >= 10.0 {
            bail!("the step returned an error:\n TI is too short\n in instance {}", self.instances.get());
        }
        self.inner.step(time, size)
    }

    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}

impl Reset for Faulty {
    fn reset(&mut self) -> Result<()> {
        match self.fault {
            Fault::None | Fault::OneInstance => {}
            Fault::ResetKeepsState => self.residue = 1e-9,
            Fault::ResetRefused => bail!("the reset returned an error"),
        }
        self.inner.reset()
    }
}

/// Returns a factory of controllers with a fault, and the number of instances that it has made.
fn faulty(fault: Fault) -> (Rc<Cell<usize>>, impl FnMut(usize) -> Made) {
    let instances = Rc::new(Cell::new(0));
    let count = Rc::clone(&instances);
    let make = move |member| {
        // The test and this closure hold the other two references.
        if fault == Fault::OneInstance && member == 0 && Rc::strong_count(&count) > 2 {
            bail!("there is an instance already");
        }
        if member == 0 { Ok(Box::new(Faulty::new(fault, &count)) as Box<dyn Reset>) } else { instantiate(member) }
    };
    (instances, make)
}

#[test]
fn a_run_that_an_fmu_refuses_is_a_row_with_its_reason_and_the_next_run_is_not_harmed() {
    let experiment = experiment(vec![axis("C.TI", values(&[10.0, 0.5, 20.0]))]);
    let (instances, mut make) = faulty(Fault::None);
    let mut executor = Executor::new(experiment.clone());
    let mut rows = points(&experiment).into_iter().map(|point| executor.row(&point, &mut make)).collect::<Vec<_>>();
    // One for the first run, one for the failed run, to find out whether resetting the instance caused the failure, and
    // one for the third.
    assert_eq!(instances.get(), 3);
    assert_eq!(rows[1].error.as_deref(), Some("C: the step returned an error: TI is too short in instance 2"));
    assert!(rows[1].figures.iter().all(|figure| figure.is_nan()) && rows[1].figures.len() == experiment.figures.len());
    let (_, make) = faulty(Fault::None);
    assert_eq!(bits(&rows.remove(2)), bits(&Executor::new(experiment.clone()).row(&experiment.point(2), make)));
}

#[test]
fn instances_that_cannot_be_reset_are_replaced_by_new_ones_for_each_run() {
    for fault in [Fault::ResetKeepsState, Fault::ResetRefused] {
        let experiment = experiment(vec![axis("C.GAIN", values(&[0.5, 2.0, 4.0]))]);
        let (_, mut sound) = faulty(Fault::None);
        let (instances, mut make) = faulty(fault);
        let mut executor = Executor::new(experiment.clone());
        let warning = "an FMU's results after a reset differ from those of a new instance: each run gets new \
             instances, which takes longer; report this to the FMU's vendor";
        assert_eq!(executor.check_reset(&mut make).as_deref(), Some(warning));
        let before = instances.get();
        for point in points(&experiment) {
            let expected = Executor::new(experiment.clone()).row(&point, &mut sound);
            assert_eq!(bits(&executor.row(&point, &mut make)), bits(&expected));
        }
        assert_eq!(instances.get() - before, 3);
    }
}

#[test]
fn a_trace_has_the_figures_of_new_instances_and_the_process_value_behind_them() {
    let experiment = experiment(vec![axis("C.GAIN", values(&[0.5, 2.0, 4.0]))]);
    let (_, mut sound) = faulty(Fault::None);
    let (instances, mut make) = faulty(Fault::ResetKeepsState);
    let mut executor = Executor::new(experiment.clone());
    for point in points(&experiment) {
        let expected = Executor::new(experiment.clone()).row(&point, &mut sound);
        let row = executor.rows(&[point], Gives::Trace, &mut make).remove(0);
        let (figures, trace) = row.figures.split_at(experiment.figures.len());
        assert_eq!(bits(&RunResult { figures: figures.into(), error: None }), bits(&expected));
        assert_eq!(trace.len(), experiment.trace_times().len());
    }
    assert_eq!(instances.get(), 3);
}

#[test]
fn there_are_never_two_instances_of_an_fmu() {
    let experiment = experiment(vec![axis("C.TI", values(&[10.0, 0.5, 20.0]))]);
    let (_instances, mut make) = faulty(Fault::OneInstance);
    let mut executor = Executor::new(experiment.clone());
    assert_eq!(executor.check_reset(&mut make), None);
    let errors = points(&experiment).into_iter().map(|point| executor.row(&point, &mut make).error);
    assert_eq!(errors.map(|error| error.is_some()).collect::<Vec<_>>(), [false, true, false]);
    executor.recording(&[10.0], Detail::All, &mut make, |_| Ok(())).unwrap();
    executor.renew();
    for _ in 0..2 {
        assert_eq!(executor.row(&[10.0], &mut make).error, None);
    }
}

/// Runs with new instances, and returns the recording in one piece and the figures.
fn recorded_run(executor: &mut Executor<Box<dyn Reset>>, point: &[f64]) -> (Recording, Option<Vec<f64>>) {
    let mut pieces = Vec::new();
    let piece = |recording| {
        pieces.push(recording);
        Ok(())
    };
    let figures = executor.recording(point, Detail::All, instantiate, piece).unwrap();
    let joined = |mut all: Recording, next| {
        all.append(next);
        all
    };
    (pieces.into_iter().reduce(joined).unwrap(), figures)
}

#[test]
fn a_long_recording_comes_in_pieces_or_with_its_extremes_alone() {
    let mut job = job(vec![axis("C.GAIN", values(&[0.5]))]);
    // More values than fit into a piece, and more rows than a picture needs.
    (job.system.step, job.system.stop) = (Some(0.5), Some(100_000.0));
    let mut executor = Executor::new(resolved(&job).unwrap());
    let mut received = |detail| {
        let mut pieces = Vec::new();
        let piece = |recording: Recording| {
            pieces.push(recording.times.len());
            Ok(())
        };
        executor.recording(&[0.5], detail, instantiate, piece).unwrap();
        pieces
    };
    let all = received(Detail::All);
    assert_eq!(all.iter().sum::<usize>(), 200_001);
    assert!(all.len() > 1 && all.iter().all(|rows| *rows <= PIECE), "{all:?}");
    // Two of every 21 rows: 2 * ceil(200 001 / 21).
    assert_eq!(received(Detail::Drawn), [19_048]);
}

#[test]
fn a_recording_is_the_run_that_the_row_is_of() {
    let mut job =
        job(vec![axis("C.GAIN", values(&[0.5, 2.0])), Axis { time: Some(5.0), ..axis("C.SP", values(&[30.0])) }]);
    job.study.values = vec![Taken { variable: "P.TEMP".into(), take: vec![Take::Last] }];
    let mut executor = Executor::new(resolved(&job).unwrap());
    for point in [[0.5, 30.0], [2.0, 60.0]] {
        let row = executor.row(&point, instantiate);
        let (recording, figures) = recorded_run(&mut executor, &point);
        assert_eq!(figures.map(|anew| bits(&RunResult { figures: anew, error: None })), Some(bits(&row)));
        let temperature = recording.columns.iter().position(|column| column.name == "P.TEMP").unwrap();
        // The row of the last step is the one before that of the end.
        let steps = recording.times.len() - 1;
        assert_eq!(recording.column(temperature).nth(steps - 1), Some(row.figures[7]), "{point:?}");
    }
}

#[test]
fn an_fmu_that_cannot_be_instantiated_is_a_row_with_its_reason() {
    let experiment = experiment(vec![]);
    assert_eq!((experiment.count(), experiment.point(0)), (1, vec![]));
    let row = Executor::<Box<dyn Reset>>::new(experiment).row(&[], |_| bail!("no library for this platform"));
    assert_eq!(row.error.as_deref(), Some("no library for this platform"));
}

#[test]
fn values_and_violations_are_those_of_the_steps_of_the_whole_run() {
    let mut job = job(vec![]);
    job.study.values =
        vec![Taken { variable: "P.TEMP".into(), take: vec![Take::Last, Take::Mean, Take::Max, Take::Min] }];
    let limit = |variable: &str, min, max| Limit { variable: variable.into(), min, max };
    job.study.limits = vec![limit("P.TEMP", Some(5.0), Some(41.0)), limit("C.SP", None, Some(39.0))];
    let experiment = resolved(&job).unwrap();
    let mut executor = Executor::new(experiment.clone());
    let row = executor.row(&[], instantiate);
    let (recording, _) = recorded_run(&mut executor, &[]);
    let column = recording.columns.iter().position(|column| column.name == "P.TEMP").unwrap();
    // One row for each step, and one for the end.
    assert_eq!(recording.times.len(), 121);
    let temperatures: Vec<f64> = recording.column(column).take(120).collect();
    let violated = temperatures.iter().filter(|value| **value < 5.0 || **value > 41.0).count() as f64 * 0.5;
    assert!(violated > 5.0, "at the start at least");
    let max = temperatures.iter().copied().fold(f64::MIN, f64::max);
    let mean = temperatures.iter().sum::<f64>() / 120.0;
    // SP is 40 from 5 s on.
    assert_eq!(row.figures[7..], [temperatures[119], mean, max, 0.0, violated, 55.0]);
}

#[test]
fn a_recording_has_what_the_system_records_and_what_figures_are_of() {
    let mut job = job(vec![axis("C.GAIN", values(&[0.5]))]);
    job.study.values = vec![Taken { variable: "P.T".into(), take: vec![Take::Last] }];
    job.system.record = vec![Recorded::from("P.POWER")];
    let names = |job: &Job| {
        let (recording, _) = recorded_run(&mut Executor::new(resolved(job).unwrap()), &[0.5]);
        recording.columns.into_iter().map(|column| column.name).collect::<Vec<_>>()
    };
    assert_eq!(names(&job), ["P.POWER", "C.SP", "C.PV", "C.OUT", "C.UP", "C.DOWN", "P.T"]);
    job.system.record.clear();
    let expected = ["C.SP", "C.PV_IN", "C.OUT", "C.PV", "C.UP", "C.DOWN", "P.POWER", "P.TEMP", "P.AT_TOP", "P.T"];
    assert_eq!(names(&job), expected);
}

#[test]
fn a_value_that_is_not_a_number_makes_its_figures_so_and_violates_limits() {
    let mut job = job(vec![]);
    job.study.values = vec![Taken { variable: "C.OUT".into(), take: vec![Take::Min, Take::Max, Take::Mean] }];
    job.study.limits = vec![Limit { variable: "C.OUT".into(), min: Some(0.0), max: None }];
    let Experiment { measures, plan, .. } = resolved(&job).unwrap();
    let mut traces = Traces::default();
    measures.begin(&mut traces);
    let out = measures.columns.iter().position(|name| name == "C.OUT").unwrap();
    for value in [1.0, f64::NAN, 2.0] {
        let mut row = vec![0.0; measures.columns.len()];
        row[out] = value;
        traces.push(&row);
    }
    let figures = measures.end(&mut traces, &plan);
    assert!(figures[7..10].iter().all(|figure| figure.is_nan()), "{figures:?}");
    assert_eq!(figures[10], 0.5);
}

#[test]
fn the_window_is_where_the_figures_of_the_loop_are_taken() {
    let mut job = job(vec![]);
    let figures = |job: &Job| Executor::new(resolved(job).unwrap()).row(&[], instantiate).figures;
    let whole = figures(&job);
    assert!(whole[0].is_finite(), "{whole:?}");
    job.study.window.from = Some(20.0);
    let late = figures(&job);
    assert!(late[0].is_nan() && late[3] < whole[3], "no rise after the step, and less IAE: {late:?}");
    job.study.window.to = Some(20.0);
    assert_eq!(error(&job), "window: from = 20.0 is not before to = 20.0: correct one of them");
}

#[test]
fn a_loop_whose_figures_cannot_be_said_in_any_run_is_a_warning() {
    let mut job = job(vec![axis("C.GAIN", values(&[0.5]))]);
    job.study.window.from = Some(1e4);
    let warning = "window: from = 10000.0 s is not before the end of the run at 60 s, so the loop has no figures: \
                   use an earlier time";
    assert_eq!(resolved(&job).unwrap().warnings, [warning]);
    job.study.window.from = None;
    job.system.settings.retain(|of| of.time.is_none());
    let warning = "C.SP does not change during a run: rise, overshoot and settling describe the approach to \
                   the setpoint from the start values; to step the setpoint, write [[events]] with time = SECONDS and \
                   set = { C.SP = VALUE }";
    assert_eq!(resolved(&job).unwrap().warnings, [warning]);
    job.study.axes.push(Axis { time: Some(5.0), ..axis("C.SP", values(&[20.0])) });
    assert_eq!(resolved(&job).unwrap().warnings, [""; 0]);
}

#[test]
fn signals_can_be_named_and_have_to_be_where_no_fmu_tells_them() {
    let mut job = job(vec![]);
    let none = |job: &Job| {
        let home = TestHome::default();
        let descriptions = [home.description("PID").unwrap(), home.description("LAG").unwrap()];
        Experiment::new(job, &descriptions.each_ref().map(|description| &**description), None)
    };
    let message = |job: &Job| format!("{:#}", none(job).unwrap_err());
    assert!(message(&job).starts_with("the study has no figures: specify the loop's signals"), "{}", message(&job));
    job.study.values = vec![Taken { variable: "P.TEMP".into(), take: vec![Take::Max] }];
    let experiment = none(&job).unwrap();
    assert_eq!(experiment.figures.len(), 1);
    let warning = "C does not name its setpoint, so there are no figures such as overshoot: to get them, name the \
                   loop's signals in [signals]";
    assert_eq!((experiment.warnings, experiment.signals), (vec![warning.to_string()], Signals::default()));
    job.study.signals.process_value = Some("P.TEMP".into());
    let expected = "signals: setpoint is missing, and C does not declare it: write setpoint = \"FMU.VARIABLE\"";
    assert_eq!(message(&job), expected);
    job.study.signals.setpoint = Some("C.SP".into());
    let figures = none(&job).unwrap().figures;
    let names: Vec<_> = figures.iter().map(|of| of.name.as_str()).collect();
    let of_loop = figures::applicable(figures::LoopSignals::default()).map(|figure| figure.key);
    assert_eq!(names, of_loop.chain(["P.TEMP.max"]).collect::<Vec<_>>());
    job.study.signals.pulses = Some(vec!["C.OUT".into()]);
    assert_eq!(message(&job), "signals: pulses: C.OUT is Real: only Boolean variables can be pulses");
    // Named signals take precedence over the table, which supplies the rest.
    job.study.signals.pulses = None;
    let signals = resolved(&job).unwrap().signals;
    assert_eq!(signals.process_value.as_deref(), Some("P.TEMP"));
    assert_eq!(signals.manipulated_value.as_deref(), Some("C.OUT"));
    assert_eq!(signals.pulses, Some(vec!["C.UP".to_string(), "C.DOWN".into()]));
}

#[test]
fn a_wrong_value_or_limit_says_what_to_do() {
    let taken = |variable: &str, take: &[Take]| Taken { variable: variable.into(), take: take.into() };
    let limit = |min, max| Limit { variable: "C.OUT".into(), min, max };
    let wrong = [
        (
            vec![taken("P.TEMP", &[])],
            vec![],
            "values: P.TEMP: `take` is empty: list one or more of min, max, mean and last",
        ),
        (
            vec![taken("P.TEMP", &[Take::Max]), taken("P.TEMP", &[Take::Min, Take::Max])],
            vec![],
            "values: the figure P.TEMP.max occurs twice: remove one",
        ),
        (vec![taken("P.TEMPP", &[Take::Max])], vec![], "values: P has no variable TEMPP; did you mean P.TEMP?"),
        (vec![], vec![limit(None, None)], "limits: C.OUT has no limit: specify `min`, `max` or both"),
        (vec![], vec![limit(Some(2.0), Some(1.0))], "limits: C.OUT: min = 2.0 is above max = 1.0: swap them"),
        (
            vec![],
            vec![limit(None, Some(f64::NAN))],
            "limits: C.OUT: max is not a finite number: omit it if there is no such limit",
        ),
    ];
    for (values, limits, expected) in wrong {
        let mut job = job(vec![]);
        (job.study.values, job.study.limits) = (values, limits);
        assert_eq!(error(&job), expected);
    }
}
