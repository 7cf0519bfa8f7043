use super::*;
use crate::rules::settings;
use crate::tune::{Rule, Structure};

fn lag(time_constant: f64, dead_time: f64) -> Model {
    Model { gain: 1.0, time_constant, dead_time, ..Model::default() }
}

fn integrating(gain: f64, dead_time: f64) -> Model {
    Model { gain, dead_time, is_integrating: true, ..Model::default() }
}

/// Ms, gain margin and phase margin to the digits given.
fn assert_margins(rule: Rule, structure: Structure, model: Model, expected: (f64, f64, f64)) {
    let settings = settings(rule, structure, &model, None, None).unwrap();
    let margins = of(&model, &settings);
    let (ms, gain, phase) = (margins.sensitivity.unwrap(), margins.gain_margin.unwrap(), margins.phase_margin.unwrap());
    assert!((ms - expected.0).abs() < 0.00051, "{rule:?} {structure:?} {model:?}: Ms {ms}");
    assert!((gain - expected.1).abs() < 0.00051, "{rule:?} {structure:?} {model:?}: gain margin {gain}");
    assert!((phase - expected.2).abs() < 0.0051, "{rule:?} {structure:?} {model:?}: phase margin {phase}");
}

#[test]
fn the_margins_are_those_of_an_independent_frequency_scan() {
    use Structure::{Pi, Pid};
    assert_margins(Rule::Simc, Pi, lag(8.0, 1.0), (1.590, PI, 61.352));
    assert_margins(Rule::Simc, Pi, lag(1.0, 1.0), (1.590, PI, 90.0 - 0.5_f64.to_degrees()));
    assert_margins(Rule::Simc, Pi, integrating(0.3, 2.0), (1.704, 2.963, 46.86));
    assert_margins(Rule::Amigo, Pi, lag(1.0, 1.0), (1.249, 2.0 * PI, 75.68));
    assert_margins(Rule::Amigo, Pi, lag(10.0, 1.0), (1.317, 5.395, 62.33));
    assert_margins(Rule::Amigo, Pid, lag(10.0, 1.0), (1.447, 3.283, 59.60));
    assert_margins(Rule::Amigo, Pid, lag(1.0, 1.0), (1.436, 3.320, 64.16));
    assert_margins(Rule::ChrSetpoint0, Pi, lag(10.0, 1.0), (1.363, 4.521, 72.76));
    assert_margins(Rule::ChrSetpoint20, Pi, lag(10.0, 1.0), (1.773, 2.618, 55.62));
    assert_margins(Rule::ChrDisturbance0, Pi, lag(10.0, 1.0), (1.974, 2.421, 41.01));
    assert_margins(Rule::ZieglerNicholsStep, Pi, lag(10.0, 1.0), (3.405, 1.564, 24.54));
}

#[test]
fn margins_do_not_depend_on_units() {
    // Times in other units, a gain in others and its sign.
    let model = Model { gain: -0.004, time_constant: 36_000.0, dead_time: 3600.0, ..Model::default() };
    assert_margins(Rule::Amigo, Structure::Pid, model, (1.447, 3.283, 59.60));
}

#[test]
fn ultimate_gain_and_period_follow_from_the_phase() {
    let (gain, period) = ultimate(&lag(10.0, 1.0)).unwrap();
    assert!((gain - 16.35055).abs() < 5.1e-6 && (period - 3.85000).abs() < 5.1e-6, "{gain} {period}");
    // 1 / (s + 1)^3
    let three_lags = |frequency: f64| (hypot(1.0, frequency).powi(-3), -3.0 * frequency.atan());
    let (gain, period) = ultimate_of(10.0, three_lags).unwrap();
    assert!((gain - 8.0).abs() < 1e-9 && (period - 2.0 * PI / 3.0_f64.sqrt()).abs() < 1e-9, "{gain} {period}");
    // k' e^(-Ls) / s: a quarter of the period is the dead time.
    let (gain, period) = ultimate(&integrating(0.5, 2.0)).unwrap();
    assert!((gain - PI / 2.0).abs() < 1e-9 && (period - 8.0).abs() < 1e-9, "{gain} {period}");
}

#[test]
fn what_never_oscillates_has_no_ultimate_gain_and_infinite_margins() {
    assert_eq!(ultimate(&lag(10.0, 0.0)), None);
    let p = Settings { gain: 5.0, ti: None, td: None, tm_lag: 0.0 };
    let margins = of(&lag(10.0, 0.0), &p);
    assert_eq!(margins.gain_margin, None);
    assert!(margins.is_stable());
    // A loop gain below 1 at all frequencies: no phase is too much.
    let margins = of(&lag(10.0, 1.0), &Settings { gain: 0.5, ..p });
    assert_eq!(margins.phase_margin, None);
    assert!((margins.gain_margin.unwrap() - 16.35055 / 0.5).abs() < 1e-4);
}

#[test]
fn an_unstable_loop_has_no_sensitivity() {
    let p = |gain| Settings { gain, ti: None, td: None, tm_lag: 0.0 };
    assert!(of(&lag(10.0, 1.0), &p(16.3)).is_stable());
    let margins = of(&lag(10.0, 1.0), &p(16.4));
    assert_eq!(margins.sensitivity, None);
    assert!(margins.gain_margin.unwrap() < 1.0 && margins.phase_margin.unwrap() < 0.0, "{margins:?}");
    // An integrating plant with a TI below the dead time.
    let pi = Settings { gain: 0.1, ti: Some(0.5), td: None, tm_lag: 0.0 };
    assert!(!of(&integrating(1.0, 1.0), &pi).is_stable());
}
