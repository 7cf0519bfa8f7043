use super::*;
use crate::component::{Component, Type};
use crate::dialog;
use crate::home::Home;
use crate::study::{Along, Axis, Limit, Sampling, Study, Take, Taken};
use crate::system::{Member, Value};
use crate::test_home::{Lag, Linked, Pid, TestHome, table};
use anyhow::bail;
use std::cell::Cell;

/// The controller C and the plant P in a loop of 60 s, with a setpoint step at 5 s.
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
    Axis { variables: vec![variable.into()], time: None, relative: false, along }
}

fn values(values: &[f64]) -> Along {
    Along::Values(values.iter().map(|value| Value::Number(*value)).collect())
}

fn resolved(job: &Job) -> Result<Experiment> {
    let home = TestHome::default();
    let descriptions = [home.description("PID").unwrap(), home.description("LAG").unwrap()];
    let (roles, _) = dialog::of(&table::<Pid>()).unwrap();
    Experiment::of(job, &descriptions.each_ref().map(|description| &**description), Some(&roles))
}

fn experiment(axes: Vec<Axis>) -> Experiment {
    resolved(&job(axes)).unwrap()
}

fn error(job: &Job) -> String {
    format!("{:#}", resolved(job).unwrap_err())
}

fn instantiate(member: usize) -> Result<Box<dyn Reset>> {
    Ok(if member == 0 { Box::new(Linked::<Pid>::new()) } else { Box::new(Linked::<Lag>::new()) })
}

fn points(experiment: &Experiment) -> Vec<Vec<f64>> {
    (0..experiment.count()).map(|run| experiment.point(run)).collect()
}

fn bits(row: &Row) -> Vec<u64> {
    row.figures.iter().map(|figure| figure.to_bits()).collect()
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
    let experiment = experiment(vec![Axis { variables, time: None, relative: false, along: rows }]);
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
    let expected = [
        ("rise", "s"),
        ("overshoot", "%"),
        ("settling", "s"),
        ("iae", "degC s"),
        ("ise", "degC^2 s"),
        ("peak", "degC"),
        ("travel", "%"),
        ("pulses", "-"),
        ("P.TEMP.max", "degC"),
        ("P.TEMP.last", "degC"),
        ("C.OUT.violation", "s"),
    ];
    assert_eq!(names, expected);
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
        assert_eq!(row.figures[8..], point);
    }
}
