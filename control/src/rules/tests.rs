use super::*;

fn lag(gain: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain, time_constant, dead_time, ..Model::default() }
}

fn integrating(gain: f64, dead_time: f64) -> Model {
    Model { gain, dead_time, is_integrating: true, ..Model::default() }
}

/// Returns GAIN, TI and TD; 0 for an action that is off.
fn numbers(rule: Rule, structure: Structure, model: &Model) -> [f64; 3] {
    let settings = settings(rule, structure, model, None, None).unwrap();
    [settings.gain, settings.ti.unwrap_or_default(), settings.td.unwrap_or_default()]
}

fn assert_close(is: [f64; 3], expected: [f64; 3], what: &str) {
    for (is, expected) in is.into_iter().zip(expected) {
        assert!((is - expected).abs() <= 5.1e-6 * expected.abs().max(1.0), "{what}: {is} instead of {expected}");
    }
}

fn error(rule: Rule, structure: Structure, model: &Model) -> String {
    format!("{:#}", settings(rule, structure, model, None, None).unwrap_err())
}

#[test]
fn lambda_makes_the_closed_loop_as_fast_as_is_asked() {
    let with = |model: &Model, closed_loop| {
        let settings = settings(Rule::Lambda, Structure::Pi, model, closed_loop, None).unwrap();
        (settings.gain, settings.ti)
    };
    // 8 / (2 (3 + 1)); the default lambda is T, or three dead times.
    assert_eq!(with(&lag(2.0, 8.0, 1.0), Some(3.0)), (1.0, Some(8.0)));
    assert_eq!(with(&lag(2.0, 8.0, 2.0), None), (0.4, Some(8.0)));
    assert_eq!(with(&lag(1.0, 2.0, 2.0), None), (0.25, Some(2.0)));
    // (2 * 4 + 2) / (0.1 * 36)
    let (gain, ti) = with(&integrating(0.1, 2.0), Some(4.0));
    assert!((gain - 10.0 / 3.6).abs() < 1e-12 && ti == Some(10.0));
    assert!(error(Rule::Lambda, Structure::Pid, &lag(1.0, 2.0, 2.0)).starts_with("lambda is a rule for PI"));
}

#[test]
fn the_scale_goes_from_the_speed_of_the_plant_to_one_dead_time() {
    let model = lag(1.0, 16.0, 1.0);
    assert_eq!([0.0, 0.5, 1.0].map(|pace| paced(pace, &model)), [16.0, 4.0, 1.0]);
    assert_eq!(paced(0.0, &lag(1.0, 1.0, 1.0)), 4.0);
}

#[test]
fn each_rule_gives_the_numbers_of_the_table_for_gain_1_lag_10_and_dead_time_1() {
    use Structure::{P, Pi, Pid};
    let model = lag(1.0, 10.0, 1.0);
    for (rule, p, pi, pid) in [
        (Rule::ZieglerNicholsStep, 10.0, [9.0, 10.0 / 3.0, 0.0], [12.0, 2.0, 0.5]),
        (Rule::ChrSetpoint0, 3.0, [3.5, 12.0, 0.0], [6.0, 10.0, 0.5]),
        (Rule::ChrSetpoint20, 7.0, [6.0, 10.0, 0.0], [9.5, 13.5, 0.47]),
        (Rule::ChrDisturbance0, 3.0, [6.0, 4.0, 0.0], [9.5, 2.4, 0.42]),
        (Rule::ChrDisturbance20, 7.0, [7.0, 2.3, 0.0], [12.0, 2.0, 0.42]),
    ] {
        assert_close(numbers(rule, P, &model), [p, 0.0, 0.0], name(rule));
        assert_close(numbers(rule, Pi, &model), pi, name(rule));
        assert_close(numbers(rule, Pid, &model), pid, name(rule));
    }
    let (ku, tu) = (16.35055, 3.85);
    let ultimate = Rule::ZieglerNicholsUltimate;
    assert_close(numbers(ultimate, P, &model), [0.5 * ku, 0.0, 0.0], "P");
    assert_close(numbers(ultimate, Pi, &model), [0.45 * ku, tu / 1.2, 0.0], "PI");
    assert_close(numbers(ultimate, Pid, &model), [0.6 * ku, tu / 2.0, tu / 8.0], "PID");
    assert_close(numbers(Rule::Simc, Pi, &model), [5.0, 8.0, 0.0], "SIMC");
    assert_close(numbers(Rule::Simc, Pi, &lag(1.0, 5.0, 1.0)), [2.5, 5.0, 0.0], "SIMC");
    assert_close(numbers(Rule::Amigo, Pi, &model), [2.82355, 6.07687, 0.0], "AMIGO PI");
    assert_close(numbers(Rule::Amigo, Pi, &lag(1.0, 1.0, 1.0)), [0.25, 1.0, 0.0], "AMIGO PI");
    assert_close(numbers(Rule::Amigo, Pid, &model), [4.7, 4.2, 0.48544], "AMIGO PID");
    assert_close(numbers(Rule::Amigo, Pid, &lag(1.0, 1.0, 1.0)), [0.65, 1.09091, 0.38462], "AMIGO PID");
}

#[test]
fn an_integrating_plant_has_rules_of_its_own() {
    use Structure::{P, Pi, Pid};
    let model = integrating(0.1, 2.0);
    assert_close(numbers(Rule::Simc, Pi, &model), [2.5, 16.0, 0.0], "SIMC");
    assert_close(numbers(Rule::Amigo, Pi, &model), [1.75, 26.7, 0.0], "AMIGO PI");
    assert_close(numbers(Rule::Amigo, Pid, &model), [2.25, 16.0, 1.0], "AMIGO PID");
    // These rules need only the slope and the dead time.
    assert_close(numbers(Rule::ZieglerNicholsStep, P, &model), [5.0, 0.0, 0.0], "ZN");
    assert_close(numbers(Rule::ChrDisturbance0, Pi, &model), [3.0, 8.0, 0.0], "CHR");
    // AMIGO and SIMC for a very slow lag equal those for an integrator.
    let slow = lag(1e6, 1e7, 2.0);
    for structure in [Pi, Pid] {
        let (lag, integrator) = (numbers(Rule::Amigo, structure, &slow), numbers(Rule::Amigo, structure, &model));
        for (a, b) in lag.into_iter().zip(integrator) {
            assert!((a - b).abs() <= 1e-4 * b, "{lag:?} {integrator:?}");
        }
    }
}

#[test]
fn a_plant_that_falls_when_the_manipulated_value_rises_needs_a_negative_gain() {
    for rule in [Rule::ZieglerNicholsStep, Rule::ZieglerNicholsUltimate, Rule::ChrSetpoint0, Rule::Simc, Rule::Amigo] {
        let up = numbers(rule, Structure::Pi, &lag(2.0, 10.0, 1.0));
        let down = numbers(rule, Structure::Pi, &lag(-2.0, 10.0, 1.0));
        assert_eq!(down, [-up[0], up[1], 0.0], "{rule:?}");
    }
}

#[test]
fn simc_takes_the_time_constant_that_is_chosen_for_the_closed_loop() {
    let of = |closed_loop| settings(Rule::Simc, Structure::Pi, &lag(2.0, 10.0, 1.0), Some(closed_loop), None);
    assert_eq!(of(4.0).unwrap(), Settings { gain: 1.0, ti: Some(10.0), td: None, tm_lag: 0.0 });
    assert!(format!("{:#}", of(-1.0).unwrap_err()).contains("it must be above 0"));
}

#[test]
fn simc_cancels_a_second_lag_by_the_d_action_of_the_series_form() {
    // Series: K' = 10 / (2 * 2) = 2.5, TI' = 8, TD' = 2; F = 1.25.
    let model = Model { second_time_constant: 2.0, ..lag(2.0, 10.0, 1.0) };
    assert_close(numbers(Rule::Simc, Structure::Pid, &model), [3.125, 10.0, 1.6], "SIMC");
    let swapped = Model { time_constant: 2.0, second_time_constant: 10.0, ..model };
    assert_eq!(numbers(Rule::Simc, Structure::Pid, &swapped), numbers(Rule::Simc, Structure::Pid, &model));
    // By the half rule PI sees T = 11 and L = 2.
    assert_close(numbers(Rule::Simc, Structure::Pi, &model), [11.0 / 8.0, 11.0, 0.0], "SIMC");
    // Integrating: K' = 1/(0.1 * 4), TI' = 16, TD' = 4.
    let integrating = Model { second_time_constant: 4.0, ..integrating(0.1, 2.0) };
    assert_close(numbers(Rule::Simc, Structure::Pid, &integrating), [3.125, 20.0, 3.2], "SIMC");
}

#[test]
fn the_lag_of_the_d_action_is_a_tenth_of_td() {
    let settings = settings(Rule::Amigo, Structure::Pid, &lag(1.0, 10.0, 1.0), None, None).unwrap();
    assert_eq!(settings.tm_lag, settings.td.unwrap() / 10.0);
}

#[test]
fn a_rule_without_a_formula_names_one_that_has() {
    use Structure::{P, Pi, Pid};
    let (first_order, integrator) = (lag(1.0, 10.0, 1.0), integrating(0.1, 2.0));
    for (rule, structure, model, expected) in [
        (
            Rule::ChrSetpoint0,
            Pi,
            &integrator,
            "CHR (setpoint, 0 %) needs a time constant, but the plant is integrating: use SIMC or AMIGO",
        ),
        (Rule::Simc, P, &first_order, "SIMC has no rule for P: use Ziegler-Nichols (step) or CHR, or SIMC with PI"),
        (Rule::Amigo, P, &first_order, "AMIGO has no rule for P: use Ziegler-Nichols (step) or CHR, or AMIGO with PI"),
        (
            Rule::Simc,
            Pid,
            &first_order,
            "SIMC uses D action only for a second lag, but the model has none: use SIMC with PI, or AMIGO with PID",
        ),
        (
            Rule::ZieglerNicholsStep,
            Pi,
            &lag(1.0, 10.0, 0.0),
            "Ziegler-Nichols (step) divides by the dead time, which is 0: use SIMC and choose the closed-loop time \
             constant",
        ),
        (
            Rule::ZieglerNicholsUltimate,
            Pi,
            &lag(1.0, 10.0, 0.0),
            "the plant has no ultimate gain, since it has no dead time: use SIMC",
        ),
        (
            Rule::ChrSetpoint20,
            Pi,
            &lag(1.0, 0.0, 1.0),
            "CHR (setpoint, 20 %) divides by the time constant, which is 0: use AMIGO with PI",
        ),
        (
            Rule::Simc,
            Pi,
            &lag(1.0, 10.0, 0.0),
            "SIMC divides by the dead time, which is 0: choose the closed-loop time constant",
        ),
    ] {
        assert_eq!(error(rule, structure, model), expected);
    }
    assert!(numbers(Rule::Amigo, Pi, &lag(1.0, 0.0, 1.0))[0] > 0.0);
}

#[test]
fn a_model_that_is_no_plant_is_refused() {
    for (model, expected) in [
        (lag(0.0, 1.0, 1.0), "the plant's gain is 0: it must be a number other than 0"),
        (lag(f64::NAN, 1.0, 1.0), "the plant's gain is NaN"),
        (lag(1.0, -1.0, 1.0), "the plant's time constant is -1 s"),
        (lag(1.0, 1.0, f64::INFINITY), "the plant's dead time is inf s"),
        (Model { is_integrating: true, ..lag(1.0, 1.0, 1.0) }, "enter it as the second time constant"),
    ] {
        assert!(error(Rule::Simc, Structure::Pi, &model).contains(expected), "{model:?}");
    }
}
