use super::*;
use crate::{Along, Axis};
use blocks::Block;
use doubles::{Lag, Pid, TestHome};
use run::component::Component;
use run::fmus::Fmus;
use run::master;
use run::plan::Plan;
use run::system::{Connection, System};

fn value(variable: &str, value: f64, time: Option<f64>) -> Setting {
    Setting { variable: variable.into(), value: Value::Number(value), time, is_preliminary: false, place: None }
}

fn switch(variable: &str, value: bool) -> Setting {
    Setting { value: Value::Boolean(value), ..self::value(variable, 0.0, None) }
}

/// A loop of a PI controller and a lag, with a study of it.
fn job(settings: Vec<Setting>) -> Job {
    let member = |name: &str, fmu: &str| system::Member { name: name.into(), path: format!("{fmu}.fmu").into() };
    let connection = |from: &str, to: &str| Connection { from: from.into(), to: to.into(), place: None };
    Job {
        system: System {
            members: vec![member("C", "PID"), member("P", "LAG")],
            connections: vec![connection("C.OUT", "P.POWER"), connection("P.TEMP", "C.PV_IN")],
            settings: [vec![value("C.CYCLE", 0.1, None), value("C.SP", 60.0, Some(1.0))], settings].concat(),
            start: Some(0.0),
            stop: Some(100.0),
            step: Some(0.1),
            ..System::default()
        },
        ..Job::default()
    }
}

fn linear(job: &Job) -> Result<Linear> {
    Linear::new(job, &Arc::new(Table::from(Pid::TABLE)))
}

fn error<T>(result: Result<T>) -> String {
    format!("{:#}", result.err().unwrap())
}

fn recorded(job: &Job) -> Recording {
    let home = TestHome::default();
    let descriptions = ["PID", "LAG"].map(|fmu| home.description(fmu).unwrap());
    let plan = Plan::new(&job.system, &descriptions.each_ref().map(|of| &**of)).unwrap();
    let mut components: Vec<Box<dyn Component>> =
        vec![home.instantiate("PID", "C").unwrap(), home.instantiate("LAG", "P").unwrap()];
    master::run(&plan, &mut components, |_| {}).unwrap()
}

/// Returns Ms of a loop with the plant identified from a step in the manual value, and that plant.
fn recorded_sensitivity(job: &Job, settings: &Values) -> (f64, Identified) {
    let linear = linear(job).unwrap();
    let identification = linear.identification(job, &Step::default(), 0.0, 100.0).unwrap();
    let identified = linear.identified(&identification, &recorded(&identification.job), settings).unwrap();
    (linear.sensitivity(&identified.plant, settings).unwrap(), identified)
}

#[test]
fn the_plant_is_that_of_a_step_of_the_manual_value_without_the_events_of_the_loop() {
    let own = vec![value("P.K", 1.8, None), switch("C.MAN_ON", false), value("P.LOAD", 30.0, Some(50.0))];
    let job = job([own, vec![value("C.GAIN", 5.0, None), value("C.TI", 8.0, None)]].concat());
    let (ms, identified) = recorded_sensitivity(&job, &Values::new());
    assert_eq!(identified.fit, None);
    // The lag of the plant, with the one step of delay until the controller reads it.
    let model = Model { gain: 1.8, time_constant: 10.0, ..Model::default() };
    let expected = linear(&job).unwrap().sensitivity(&Plant::of_model(&model, 0.1), &Values::new()).unwrap();
    assert!((ms / expected - 1.0).abs() < 0.002, "{ms} {expected}");
}

#[test]
fn a_noisy_process_value_gives_a_lag_with_dead_time() {
    let job = job(vec![value("P.K", 1.8, None)]);
    let linear = linear(&job).unwrap();
    let of = linear.identification(&job, &Step::default(), 0.0, 100.0).unwrap();
    let recording = recorded(&of.job);
    // Noise of half a unit in both directions, on a response of 36.
    let mut noisy = Recording::empty(recording.columns.clone());
    for (number, (time, row)) in recording.rows().enumerate() {
        noisy.push(time, &[row[0], row[1] + if number % 3 == 0 { 0.5 } else { -0.25 }]);
    }
    let identified = linear.identified(&of, &noisy, &Values::new()).unwrap();
    assert!(identified.fit.unwrap() > 90.0, "{:?}", identified.fit);
}

#[test]
fn the_step_begins_where_the_loop_has_its_manual_value() {
    let job = job(vec![value("C.MAN", 35.0, None)]);
    let linear = linear(&job).unwrap();
    let manual = |step: &Step| {
        let identification = linear.identification(&job, step, 0.0, 100.0).unwrap();
        let settings = identification.job.system.settings.into_iter();
        settings.filter(|of| of.variable == "C.MAN").map(|of| (of.time, of.value)).collect::<Vec<_>>()
    };
    let expected = |from: f64, to: f64, time: f64| vec![(None, Value::Number(from)), (Some(time), Value::Number(to))];
    assert_eq!(manual(&Step::default()), expected(35.0, 55.0, 10.0));
    let step = Step { from: Some(50.0), to: Some(40.0), time: Some(30.0), ..Step::default() };
    assert_eq!(manual(&step), expected(50.0, 40.0, 30.0));
}

#[test]
fn a_step_that_tells_nothing_is_refused() {
    let job = job(Vec::new());
    let linear = linear(&job).unwrap();
    let refused = |step: &Step| error(linear.identification(&job, step, 0.0, 100.0));
    assert_eq!(
        refused(&Step { from: Some(5.0), to: Some(5.0), ..Step::default() }),
        "the manual value steps from 5 to 5: they must be two different finite numbers"
    );
    assert_eq!(
        refused(&Step { time: Some(100.0), ..Step::default() }),
        "the step in the manual value is at 100 s: it must be between 0 and 100 s"
    );
}

#[test]
fn axes_that_act_during_the_run_have_no_coordinate_in_the_identification() {
    let axis = |variable: &str, time: Option<f64>| Axis {
        variables: vec![variable.into()],
        time,
        along: Along::Values(vec![Value::Number(1.0)]),
        ..Axis::default()
    };
    let mut job = job(Vec::new());
    job.study.axes = vec![axis("P.K", None), axis("P.LOAD", Some(5.0)), axis("P.T", None)];
    assert_eq!(Identification::is_in_point(&job), [true, false, true]);
    let identification = linear(&job).unwrap().identification(&job, &Step::default(), 0.0, 100.0).unwrap();
    let axes: Vec<_> = identification.job.study.axes.iter().map(|axis| axis.variables[0].as_str()).collect();
    assert_eq!(axes, ["P.K", "P.T"]);
}

#[test]
fn ms_is_that_of_the_law_with_the_settings_of_a_candidate() {
    let job = job(vec![value("C.GAIN", 2.0, None), value("C.TI", 8.0, None)]);
    let linear = linear(&job).unwrap();
    let model = Model { gain: 1.5, time_constant: 10.0, dead_time: 1.0, ..Model::default() };
    let plant = linear.modelled(&model);
    assert_eq!(plant, Plant::of_model(&model, 0.1));
    let expected = |gain: f64, ti: f64, cycle: f64, calls: u32| {
        let settings = Settings { gain, ti: Some(ti), td: None, tm_lag: 0.0 };
        margins::compute(&plant, &Law { settings, cycle, calls }, 0.0).sensitivity.unwrap()
    };
    let with = |given: &[(&str, f64)]| {
        let values = given.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect();
        linear.sensitivity(&plant, &values).unwrap()
    };
    assert_eq!(with(&[]), expected(2.0, 8.0, 0.1, 1));
    assert_eq!(with(&[("GAIN", 3.0), ("TI", 6.0)]), expected(3.0, 6.0, 0.1, 1));
    assert_eq!(with(&[("CYCLE", 0.5)]), expected(2.0, 8.0, 0.5, 1));
    // Two calls per exchange of values.
    assert_eq!(with(&[("CYCLE", 0.05)]), expected(2.0, 8.0, 0.05, 2));
    // The block raises TI to half of CYCLE.
    assert_eq!(with(&[("GAIN", 0.01), ("TI", 0.01)]), expected(0.01, 0.05, 0.1, 1));
    assert_eq!(with(&[("GAIN", 100.0)]), f64::INFINITY, "an unstable loop");
}

#[test]
fn a_controller_without_p_action_has_no_ideal_form() {
    let error = error(linear(&job(vec![switch("C.P_SEL", false)])));
    assert_eq!(error, "the P action of PID is off: Ms cannot be computed for it; constrain overshoot instead of ms");
}

#[test]
fn an_fmu_that_does_not_control_is_refused() {
    let mut job = job(Vec::new());
    job.system.members.swap(0, 1);
    let refused = Linear::new(&job, &Arc::new(Table::from(Lag::TABLE)));
    assert!(error(refused).starts_with("LAG is not a controller with a GAIN"), "a plant is first");
}
