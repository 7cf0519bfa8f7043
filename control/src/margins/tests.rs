use super::*;
use crate::rules::settings;
use crate::rules::{Rule, Structure};

fn lag(time_constant: f64, dead_time: f64) -> Model {
    Model { gain: 1.0, time_constant, dead_time, ..Model::default() }
}

fn integrating(gain: f64, dead_time: f64) -> Model {
    Model { gain, dead_time, is_integrating: true, ..Model::default() }
}

/// Asserts Ms, gain margin and phase margin of a continuous loop to the given digits, using a sampled loop whose calls
/// are so fast that the sampling costs only half a call.
fn assert_margins(rule: Rule, structure: Structure, model: Model, expected: (f64, f64, f64)) {
    let settings = settings(rule, structure, &model, None, None).unwrap();
    let cycle = model.dead_time / 200.0;
    let fast = Model { dead_time: model.dead_time - cycle / 2.0, ..model };
    let margins = compute(&Plant::of_model(&fast, cycle), &Law { settings, cycle, calls: 1 }, 0.0);
    let (ms, gain, phase) = (margins.sensitivity.unwrap(), margins.gain_margin.unwrap(), margins.phase_margin.unwrap());
    assert!((ms / expected.0 - 1.0).abs() < 0.001, "{rule:?} {structure:?} {model:?}: Ms {ms}");
    assert!((gain / expected.1 - 1.0).abs() < 0.001, "{rule:?} {structure:?} {model:?}: gain margin {gain}");
    assert!((phase - expected.2).abs() < 0.02, "{rule:?} {structure:?} {model:?}: phase margin {phase}");
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
    // Other units of time and gain, and a gain with the opposite sign.
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
    // k' e^(-Ls) / s: the dead time is a quarter of the period.
    let (gain, period) = ultimate(&integrating(0.5, 2.0)).unwrap();
    assert!((gain - PI / 2.0).abs() < 1e-9 && (period - 8.0).abs() < 1e-9, "{gain} {period}");
}

/// Returns the margins of a loop with calls one second apart.
fn sampled(model: &Model, settings: Settings) -> Margins {
    compute(&Plant::of_model(model, 1.0), &Law { settings, cycle: 1.0, calls: 1 }, 0.0)
}

const P: Settings = Settings { gain: 1.0, ti: None, td: None, tm_lag: 0.0 };

#[test]
fn a_sampled_lag_has_the_margins_that_one_can_compute_by_hand() {
    // P(z) = (1 - a) / (z - a) with a = 1/2: at z = -1 it is -1/3, where its magnitude is smallest.
    let lag = lag(1.0 / std::f64::consts::LN_2, 0.0);
    let margins = sampled(&lag, P);
    assert!((margins.gain_margin.unwrap() - 3.0).abs() < 1e-9 && margins.phase_margin.is_none(), "{margins:?}");
    assert!((margins.sensitivity.unwrap() - 1.5).abs() < 1e-9, "{margins:?}");
    assert!(sampled(&lag, Settings { gain: 2.99, ..P }).is_stable());
    assert!(!sampled(&lag, Settings { gain: 3.01, ..P }).is_stable());
    // A dead time of a whole call and no lag: P(z) = z^-2, which is -1 where z = i.
    let margins = sampled(&self::lag(0.0, 1.0), Settings { gain: 0.5, ..P });
    assert!((margins.gain_margin.unwrap() - 2.0).abs() < 1e-3, "{margins:?}");
    assert!((margins.sensitivity.unwrap() - 2.0).abs() < 1e-3, "{margins:?}");
}

#[test]
fn an_integrator_with_p_action_ends_where_a_call_makes_up_for_twice_the_error() {
    let margins = |gain: f64| sampled(&integrating(0.5, 0.0), Settings { gain, ..P });
    assert!((margins(2.0).gain_margin.unwrap() - 2.0).abs() < 1e-9);
    assert!(margins(3.99).is_stable() && !margins(4.01).is_stable());
    // The loop may be much slower than the plant.
    assert!((margins(1e-4).sensitivity.unwrap() - 1.0).abs() < 1e-3);
}

#[test]
fn an_unstable_loop_has_no_sensitivity() {
    let p = |gain| Settings { gain, ..P };
    let continuous = |gain| {
        let fast = Model { dead_time: 1.0 - 0.005, ..lag(10.0, 1.0) };
        compute(&Plant::of_model(&fast, 0.01), &Law { settings: p(gain), cycle: 0.01, calls: 1 }, 0.0)
    };
    // Ku is 16.35.
    assert!(continuous(16.3).is_stable());
    let margins = continuous(16.4);
    assert_eq!(margins.sensitivity, None);
    assert!(margins.gain_margin.unwrap() < 1.0 && margins.phase_margin.unwrap() < 0.0, "{margins:?}");
    // An integrating plant with a TI below the dead time.
    let pi = Settings { gain: 0.1, ti: Some(0.5), ..P };
    assert!(!sampled(&integrating(1.0, 1.0), pi).is_stable());
}

#[test]
fn a_cycle_other_than_that_of_the_record_counts_by_half_of_the_difference() {
    let settings = Settings { gain: 5.0, ti: Some(10.0), td: Some(0.5), tm_lag: 0.2 };
    let law = |cycle| Law { settings, cycle, calls: 1 };
    let (fast, slow) = (Plant::of_model(&lag(10.0, 1.0), 0.1), Plant::of_model(&lag(10.0, 1.0), 0.2));
    let expected = compute(&slow, &law(0.2), 0.0).sensitivity.unwrap();
    let taken = compute(&fast, &law(0.2), 0.0).sensitivity.unwrap();
    assert!((taken / expected - 1.0).abs() < 0.01, "{taken} {expected}");
    assert!((compute(&fast, &law(0.1), 0.0).sensitivity.unwrap() / expected - 1.0).abs() > 0.02, "it matters");
}

#[test]
fn calls_between_two_process_values_count_each() {
    // Three calls of 0.1 s, made one by one, with the plant's response to every third manipulated value.
    let settings = Settings { gain: 3.0, ti: Some(4.0), td: Some(1.0), tm_lag: 0.2 };
    let law = Law { settings, cycle: 0.1, calls: 3 };
    let frequency = 0.7;
    let (mut i, mut w, mut before) = (0.0, 0.0, 0.0);
    let back = Complex::turned(-frequency * law.sampling());
    let (mut sine, mut cosine) = (0.0, 0.0);
    for sample in 0..40_000 {
        let p = 3.0 * cos(frequency * law.sampling() * f64::from(sample));
        let mut value = 0.0;
        for _ in 0..3 {
            i += 0.1 / 4.0 * (p + before) / 2.0;
            before = p;
            let d = 1.0 / (0.2 + 0.05) * (p - w);
            w += 0.1 * d;
            value = p + i + d;
        }
        let angle = frequency * law.sampling() * f64::from(sample);
        cosine += value * cos(angle) / 20_000.0;
        sine -= value * sin(angle) / 20_000.0;
    }
    let response = law.response(back);
    let is = Complex { real: cosine, imaginary: sine };
    assert!((is - response).amount() < 0.002 * response.amount(), "{is:?} {response:?}");
}

/// A plant given by the terms of its response to a unit step: a level, a slope, and decaying terms.
struct Exact {
    level: f64,
    slope: f64,
    parts: Vec<(f64, f64)>,
    dead_time: f64,
}

impl Exact {
    fn of(model: &Model) -> Exact {
        let Model { gain, time_constant: one, second_time_constant: two, dead_time, is_integrating } = *model;
        let (level, slope, parts) = match is_integrating {
            true => (-gain * two, gain, vec![(gain * two, two)]),
            false if two == 0.0 => (gain, 0.0, vec![(-gain, one)]),
            false => (gain, 0.0, vec![(-gain * one / (one - two), one), (gain * two / (one - two), two)]),
        };
        Exact { level, slope, parts: parts.into_iter().filter(|(_, lag)| *lag > 0.0).collect(), dead_time }
    }

    fn at(&self, time: f64) -> f64 {
        let time = time - self.dead_time;
        let part = |(amount, lag): &(f64, f64)| amount * exp(-time / lag);
        if time <= 0.0 { 0.0 } else { self.level + self.slope * time + self.parts.iter().map(part).sum::<f64>() }
    }

    /// The z-transform of the samples, times `1 - z^-1`, in closed form.
    fn response(&self, back: Complex, cycle: f64) -> Complex {
        let late = (self.dead_time / cycle).floor();
        let first = (late + 1.0) * cycle - self.dead_time;
        let one = Complex::ONE - back;
        let mut sum =
            Complex::ONE * (self.level + self.slope * first) / one + back * (self.slope * cycle) / (one * one);
        for (amount, lag) in &self.parts {
            sum = sum + Complex::ONE * (amount * exp(-first / lag)) / (Complex::ONE - back * exp(-cycle / lag));
        }
        (0..=late as usize).fold(sum * one, |product, _| product * back)
    }
}

/// The controller with s replaced by 2/CYCLE (z - 1)/(z + 1), to which its law is equivalent.
fn tustin(settings: &Settings, cycle: f64, back: Complex) -> Complex {
    let s = (Complex::ONE - back) * (2.0 / cycle) / (Complex::ONE + back);
    let mut sum = Complex::ONE;
    sum = settings.ti.map_or(sum, |ti| sum + Complex::ONE / (s * ti));
    sum = settings.td.map_or(sum, |td| sum + s * td / (Complex::ONE + s * settings.tm_lag));
    sum * settings.gain
}

/// Whether the oscillation grows in a simulation call by call.
fn swings_up(exact: &Exact, settings: &Settings, cycle: f64, calls: usize) -> bool {
    let steps: Vec<f64> =
        (0..calls).map(|call| exact.at((call + 1) as f64 * cycle) - exact.at(call as f64 * cycle)).collect();
    let (mut values, mut i, mut w, mut before) = (Vec::<f64>::new(), 0.0, 0.0, 0.0);
    let mut outputs = Vec::new();
    for call in 0..calls {
        let output: f64 = (0..call).map(|past| steps[call - 1 - past] * values[past]).sum();
        let p = settings.gain * (1.0 - output);
        let d = settings.td.map_or(0.0, |td| td / (settings.tm_lag + cycle / 2.0) * (p - w));
        w += settings.td.map_or(0.0, |td| cycle / td * d);
        i += settings.ti.map_or(0.0, |ti| cycle / ti * (p + before) / 2.0);
        before = p;
        values.push(p + i + d);
        outputs.push(output);
    }
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, value| most.max((value - 1.0).abs()));
    // A growing oscillation eventually exceeds all finite numbers.
    !outputs[calls - 1].is_finite() || largest(&outputs[calls * 3 / 4..]) > largest(&outputs[calls / 4..calls / 2])
}

#[test]
fn ms_from_a_recorded_step_is_that_of_the_exact_sampled_loop_for_200_random_plants() {
    let mut state = 24_u64;
    let mut random = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low * pow(high / low, (state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let (mut compared, mut unstable) = (0, 0);
    for number in 0..200 {
        let (first, second, dead_time) = (random(1.0, 20.0), random(0.1, 20.0), random(0.05, 20.0));
        let model = match number % 4 {
            0 => Model { second_time_constant: 0.0, ..lag(first, dead_time) },
            1 => Model { second_time_constant: second, ..lag(first, dead_time) },
            2 => integrating(random(0.01, 1.0), dead_time),
            _ => Model { second_time_constant: second, ..integrating(random(0.01, 1.0), dead_time) },
        };
        let cycle = random(0.05, 0.5) * (dead_time + second).min(first);
        let structure = if number % 8 < 4 { Structure::Pi } else { Structure::Pid };
        let whole = Model { dead_time: dead_time + cycle / 2.0, ..model };
        let mut settings = settings(Rule::Simc, structure, &whole.without_second_lag(), None, None)
            .or_else(|_| settings(Rule::Amigo, structure, &whole.without_second_lag(), None, None))
            .unwrap();
        settings.gain *= random(0.3, 8.0);
        settings.ti = settings.ti.map(|ti| ti.max(cycle / 2.0));
        settings.td = settings.td.map(|td| td.max(cycle));
        settings.tm_lag = settings.td.map_or(0.0, |_| settings.tm_lag.max(cycle / 2.0));

        let exact = Exact::of(&model);
        let lags = if model.is_integrating { second } else { first + model.second_time_constant };
        let calls = ((dead_time + 5.0 * lags) / cycle).ceil() as usize + 20;
        let values: Vec<f64> = (0..calls).map(|call| exact.at(call as f64 * cycle)).collect();
        let plant = Plant::of_step(&values, cycle, model.is_integrating, 0.0);
        let margins = compute(&plant, &Law { settings, cycle, calls: 1 }, 0.0);
        let Some(ms) = margins.sensitivity else {
            unstable += 1;
            assert!(swings_up(&exact, &settings, cycle, 8 * calls), "{model:?} {settings:?} {cycle}");
            continue;
        };
        let sensitivity = |point: usize| {
            let back = Complex::turned(-PI * pow(1e-4, 1.0 - point as f64 / 8000.0));
            let open = tustin(&settings, cycle, back) * exact.response(back, cycle);
            1.0 / (Complex::ONE + open).amount()
        };
        let expected = (0..8000).map(sensitivity).fold(0.0, f64::max);
        assert!((ms / expected - 1.0).abs() < 0.01, "{ms} {expected}: {model:?} {settings:?} {cycle}");
        let of_model = compute(&Plant::of_model(&model, cycle), &Law { settings, cycle, calls: 1 }, 0.0);
        let of_model = of_model.sensitivity.unwrap();
        assert!((of_model / expected - 1.0).abs() < 0.01, "{of_model} {expected}: {model:?} {settings:?} {cycle}");
        compared += 1;
    }
    assert!(compared >= 120 && unstable >= 20, "{compared} {unstable}");
}

#[test]
fn the_resolution_of_an_analog_input_does_not_count_as_the_plant() {
    // A step so small that the loop would appear unstable: two lags with a step of 3 % and 4 K for 276.48 counts, and a
    // D action that amplifies fast signals by thirteen.
    let model =
        Model { gain: 3.6, time_constant: 120.0, second_time_constant: 20.0, dead_time: 9.0, is_integrating: false };
    let law = Law {
        settings: Settings { gain: 1.621, ti: Some(150.964), td: Some(10.452), tm_lag: 1.0 },
        cycle: 1.0,
        calls: 1,
    };
    let exact = Exact::of(&model);
    let times: Vec<f64> = (0..600).map(f64::from).collect();
    let input: Vec<f64> = times.iter().map(|time| if *time < 60.0 { 0.0 } else { 3.0 }).collect();
    let count = 400.0 / 27648.0;
    let output = times.iter().map(|time| (3.0 * exact.at(time - 60.0) / count).round() * count);
    let output: Vec<f64> = output.collect();
    let recorded = crate::identify::Recorded { times: &times, input: &input, output: &output };
    let answer = crate::identify::Answer::new(&recorded, false).unwrap();
    let ms = |values: &[f64]| {
        compute(&Plant::of_step(values, 1.0, false, 0.0), &law, 0.0).sensitivity.unwrap_or(f64::INFINITY)
    };
    let expected = compute(&Plant::of_model(&model, 1.0), &law, 0.0).sensitivity.unwrap();
    let is = ms(&answer.values);
    let rough: Vec<f64> = output[60..].iter().map(|value| value / 3.0).collect();
    let rough = ms(&rough);
    assert!((is / expected - 1.0).abs() < 0.1 && rough == f64::INFINITY, "{is} {rough} {expected}");
}
