use super::*;

/// A record of a step at 20 s, sampled every `interval` seconds, for `duration` seconds after the step.
struct Record {
    times: Vec<f64>,
    input: Vec<f64>,
    output: Vec<f64>,
}

const STEP_AT: f64 = 20.0;

impl Record {
    /// Creates a record in which the manipulated value goes from 40 to 40 + `height`, and the process value starts at
    /// 25.
    fn new(model: Model, height: f64, interval: f64, duration: f64) -> Record {
        let mut process = Process::at_rest(model, 0.0);
        Record::by(interval, duration, height, |time| {
            if time >= STEP_AT {
                process.put(STEP_AT, height);
            }
            25.0 + process.output_at(time)
        })
    }

    /// Creates a record whose process value is a function of time.
    fn by(interval: f64, duration: f64, height: f64, mut output: impl FnMut(f64) -> f64) -> Record {
        let before = (STEP_AT / interval).round();
        let times: Vec<f64> = (0..=((STEP_AT + duration) / interval).round() as usize)
            .map(|at| STEP_AT + (at as f64 - before) * interval)
            .collect();
        let input = times.iter().map(|time| if *time < STEP_AT { 40.0 } else { 40.0 + height }).collect();
        let output = times.iter().map(|time| output(*time)).collect();
        Record { times, input, output }
    }

    /// The response of `2 / (s + 1)^order` to a step by 10.
    fn of_order(order: i32) -> Record {
        Record::by(0.01, 40.0, 10.0, |time| {
            let time = (time - STEP_AT).max(0.0);
            let mut term = 1.0;
            let sum: f64 = (0..order)
                .map(|power| {
                    if power > 0 {
                        term *= time / f64::from(power);
                    }
                    term
                })
                .sum();
            25.0 + 20.0 * (1.0 - sum * (-time).exp())
        })
    }

    fn with(mut self, mut change: impl FnMut(f64, f64) -> f64) -> Record {
        for (time, value) in self.times.iter().zip(&mut self.output) {
            *value = change(*time, *value);
        }
        self
    }

    fn with_noise(self, deviation: f64) -> Record {
        let mut random = Random(1);
        self.with(|_, value| value + deviation * random.normal())
    }

    fn identify(&self, method: Method, is_integrating: bool) -> Result<Identified> {
        let Record { times, input, output } = self;
        identify(&Recorded { times, input, output }, method, is_integrating)
    }

    fn error(&self, method: Method) -> String {
        format!("{:#}", self.identify(method, false).unwrap_err())
    }
}

/// A deterministic pseudorandom number generator.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number with mean 0 and standard deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

const METHODS: [Method; 4] = [Method::Tangent, Method::TwoPoints, Method::Area, Method::LeastSquares];

fn lag(gain: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain, time_constant, dead_time, ..Model::default() }
}

/// Asserts gain, time constant and dead time to a relative tolerance; that of the dead time is relative to the time
/// constant.
fn assert_found(identified: &Identified, expected: &Model, part: f64, what: &str) {
    let is = &identified.model;
    let errors = [
        (is.gain - expected.gain) / expected.gain,
        (is.time_constant - expected.time_constant) / expected.time_constant,
        (is.dead_time - expected.dead_time) / expected.time_constant.max(expected.dead_time),
    ];
    assert!(errors.iter().all(|error| error.abs() <= part), "{what}: {is:?} instead of {expected:?}: {errors:?}");
}

#[test]
fn exact_steps_of_known_plants_are_identified_to_1_percent_by_every_method() {
    for model in [lag(2.0, 10.0, 2.0), lag(0.5, 10.0, 0.0), lag(-3.0, 10.0, 20.05), lag(1e-4, 10.0, 0.5)] {
        for height in [10.0, -25.0, 0.5] {
            let record = Record::new(model, height, 0.1, 100.0);
            for method in METHODS {
                let identified = record.identify(method, false).unwrap();
                assert_found(&identified, &model, 0.01, &format!("{method:?} {height}"));
                assert!(identified.fit > 98.0, "{method:?}: {}", identified.fit);
            }
        }
    }
}

#[test]
fn least_squares_finds_the_model_of_exact_data_to_many_digits() {
    let model = lag(2.0, 10.0, 2.037);
    let identified = Record::new(model, 10.0, 0.1, 100.0).identify(Method::LeastSquares, false).unwrap();
    assert_found(&identified, &model, 1e-5, "whole");
    assert!(identified.fit > 99.999, "{}", identified.fit);
    assert_eq!(identified.remarks, [""; 0]);
    // A record of one and a half time constants is sufficient, with a remark.
    let identified = Record::new(model, 10.0, 0.1, 17.0).identify(Method::LeastSquares, false).unwrap();
    assert_found(&identified, &model, 1e-4, "half");
    assert!(identified.remarks[0].starts_with("The record shows only 78 %"), "{:?}", identified.remarks);
}

/// A model with two lags: gain, both time constants, dead time.
fn two_lags(gain: f64, time_constant: f64, second_time_constant: f64, dead_time: f64) -> Model {
    Model { second_time_constant, ..lag(gain, time_constant, dead_time) }
}

/// Returns the relative errors of gain, both time constants and the dead time.
fn parts_off(is: &Model, expected: &Model) -> [f64; 4] {
    let off = |is: f64, expected: f64| (is / expected - 1.0).abs();
    [
        off(is.gain, expected.gain),
        off(is.time_constant, expected.time_constant),
        off(is.second_time_constant, expected.second_time_constant),
        off(is.dead_time, expected.dead_time),
    ]
}

/// Models from a furnace with its sensor to two nearly equal lags.
const TWO_LAGS: [(f64, f64, f64, f64); 5] = [
    (3.0, 120.0, 20.0, 5.0),
    (2.0, 10.0, 3.0, 3.0),
    (-0.5, 40.0, 30.0, 10.0),
    (1.0, 10.0, 1.0, 2.0),
    (1e-3, 8.0, 7.0, 4.0),
];

#[test]
fn two_lags_are_found_within_1_percent_exact_noisy_and_as_words_of_an_analog_input() {
    for (gain, one, two, dead_time) in TWO_LAGS {
        let model = two_lags(gain, one, two, dead_time);
        for height in [10.0, -25.0] {
            let record = |interval: f64| Record::new(model, height, interval, 8.0 * one);
            let answer = (gain * height).abs();
            let found = |record: Record| record.identify(Method::LeastSquares, false).unwrap();
            let exact = found(record(one / 100.0));
            let parts = parts_off(&exact.model, &model);
            assert!(parts.iter().all(|part| *part < 1e-4), "{model:?}: {parts:?}");
            assert!(exact.fit > 99.99 && exact.remarks.is_empty(), "{} {:?}", exact.fit, exact.remarks);
            if height < 0.0 {
                continue;
            }
            // A quarter of the range: 6912 counts. 500 readings in the time of the lag, as of an input that is read every 100 ms.
            let count = 4.0 * answer / 27_648.0;
            let words = found(record(one / 500.0).with(|_, value| (value / count).round() * count));
            // Two nearly equal lags are found as two equal ones, as far as noise permits.
            if one / two < 1.3 {
                let sum = |model: &Model| model.time_constant + model.second_time_constant;
                let off = sum(&words.model) / sum(&model) - 1.0;
                assert!(
                    off.abs() < 0.01 && words.model.second_time_constant > 0.8 * two,
                    "{model:?}: {:?}",
                    words.model
                );
                continue;
            }
            let noisy = found(record(one / 500.0).with_noise(0.0004 * answer));
            for identified in [words, noisy] {
                let parts = parts_off(&identified.model, &model);
                assert!(parts.iter().all(|part| *part < 0.01), "{model:?}: {parts:?} {:?}", identified.model);
            }
        }
    }
}

#[test]
fn a_plant_with_one_lag_gets_no_second_one() {
    for (gain, time_constant, dead_time) in [(2.0, 10.0, 2.0), (0.5, 10.0, 0.0), (-3.0, 10.0, 20.05), (1e-3, 25.0, 0.5)]
    {
        let model = lag(gain, time_constant, dead_time);
        let answer = (gain * 10.0).abs();
        let record = |interval: f64| Record::new(model, 10.0, interval, 100.0);
        let second = |record: Record, what: &str| {
            let found = record.identify(Method::LeastSquares, false).unwrap().model;
            assert_eq!(found.second_time_constant, 0.0, "{model:?} {what}: {found:?}");
        };
        for interval in [0.5, 0.1] {
            second(record(interval), "exact");
            second(record(interval).with(|_, value| f64::from(value as f32)), "REAL");
            for part in [0.01, 0.25, 1.0] {
                let count = answer / part / 27_648.0;
                second(record(interval).with(|_, value| (value / count).round() * count), "word");
            }
            for seed in 1..=9 {
                let mut random = Random(seed);
                let deviation = answer * [0.0005, 0.005, 0.02][seed as usize % 3];
                second(record(interval).with(|_, value| value + deviation * random.normal()), "noise");
                // Noise that is correlated over ten samples, as that of a slow sensor.
                let mut last = 0.0;
                let slow = record(interval).with(|_, value| {
                    last = 0.9 * last + 0.2 * deviation * random.normal();
                    value + last
                });
                second(slow, "slow noise");
            }
        }
    }
}

#[test]
fn two_lags_without_dead_time_and_two_equal_ones_are_found() {
    let model = two_lags(2.0, 10.0, 4.0, 0.0);
    for record in [Record::new(model, 10.0, 0.1, 100.0), Record::new(model, 10.0, 0.1, 100.0).with_noise(0.02)] {
        let found = record.identify(Method::LeastSquares, false).unwrap().model;
        let off = [found.gain / 2.0 - 1.0, found.time_constant / 10.0 - 1.0, found.second_time_constant / 4.0 - 1.0];
        assert!(off.iter().all(|part| part.abs() < 0.03) && found.dead_time < 0.05, "{found:?}");
    }
    let equal = Record::of_order(2).identify(Method::LeastSquares, false).unwrap().model;
    let off = [equal.time_constant, equal.second_time_constant].map(|lag| (lag - 1.0).abs());
    assert!(off.iter().all(|off| *off < 0.01) && equal.dead_time < 0.01, "{equal:?}");
}

#[test]
fn plants_of_higher_order_become_a_lag_with_dead_time_as_the_tables_say() {
    // The tangent's dead time and time constant for 1/(s+1)^n are in every textbook.
    for (order, dead_time, time_constant) in [(2, 0.282, std::f64::consts::E), (3, 0.805, 3.695), (4, 1.425, 4.463)] {
        let identified = Record::of_order(order).identify(Method::Tangent, false).unwrap();
        assert_found(&identified, &lag(2.0, time_constant, dead_time), 0.005, "tangent");
        // The sum of lags and dead time is the mean residence time, which equals the order, or the time of 63 %.
        let time_of_63 = [2.1462, 3.2583, 4.3520][order as usize - 2];
        let expected = [f64::from(order), time_of_63, f64::from(order)];
        for ((method, sum), part) in
            [Method::Area, Method::TwoPoints, Method::LeastSquares].iter().zip(expected).zip([0.02, 0.001, 0.02])
        {
            let identified = Record::of_order(order).identify(*method, false).unwrap();
            let Model { gain, time_constant, second_time_constant, dead_time, .. } = identified.model;
            assert!((gain - 2.0).abs() < 0.01 * 2.0, "{method:?} {gain}");
            let is = time_constant + second_time_constant + dead_time;
            assert!((is - sum).abs() < part * sum, "{method:?} of order {order}: {is}");
            assert!(identified.fit > 90.0, "{method:?} of order {order}: {}", identified.fit);
        }
    }
}

#[test]
fn least_squares_fits_better_than_any_other_method() {
    for order in 2..=6 {
        let record = Record::of_order(order);
        let best = record.identify(Method::LeastSquares, false).unwrap().fit;
        for method in METHODS {
            // The tangent method may reject a plant of high order.
            let fit = record.identify(method, false).map_or(0.0, |identified| identified.fit);
            assert!(fit <= best, "{method:?}: {fit} and {best}");
        }
    }
}

#[test]
fn noise_of_2_percent_costs_least_squares_2_percent_and_the_others_more() {
    // The standard deviation of a parameter is about noise / sqrt(samples in a time constant) = 0.2 % for least
    // squares, and noise / slope = 2 % / 0.37 for a time read off at a point. A slope known to 5 % needs 27 samples
    // here, over which it falls by a quarter: its mean is an eighth too low.
    let model = lag(2.0, 10.0, 3.0);
    let record = Record::new(model, 10.0, 0.1, 100.0).with_noise(0.4);
    for (method, part) in
        [(Method::LeastSquares, 0.02), (Method::TwoPoints, 0.1), (Method::Area, 0.1), (Method::Tangent, 0.2)]
    {
        let identified = record.identify(method, false).unwrap();
        assert_found(&identified, &model, part, &format!("{method:?}"));
        assert!(identified.fit > 80.0, "{}", identified.fit);
    }
}

#[test]
fn quantisation_by_an_analog_input_does_no_harm() {
    // A range of 0 ... 400, of which the response covers 5 %: 1382 counts.
    let count = 400.0 / 27648.0;
    let model = lag(2.0, 10.0, 3.0);
    let record = Record::new(model, 10.0, 0.1, 100.0).with(|_, value| (value / count).round() * count);
    for method in METHODS {
        assert_found(&record.identify(method, false).unwrap(), &model, 0.02, &format!("{method:?}"));
    }
}

#[test]
fn a_drift_that_goes_on_is_taken_off_with_a_remark() {
    let model = lag(2.0, 10.0, 3.0);
    let record = Record::new(model, 10.0, 0.1, 100.0).with(|time, value| value + 0.03 * time);
    for method in METHODS {
        let identified = record.identify(method, false).unwrap();
        assert_found(&identified, &model, 0.02, &format!("{method:?}"));
        assert!(identified.remarks[0].contains("drifts by 0.0300 per second"), "{:?}", identified.remarks);
        // The drawn values are the measured ones.
        assert!((identified.measured[0] - record.output[200]).abs() < 1e-9);
    }
    let record = Record::new(model, 10.0, 0.1, 100.0).with(|time, value| value + 0.4 * time);
    assert!(record.error(Method::LeastSquares).contains("drifts by 0.4000 per second"));
}

#[test]
fn a_process_value_that_was_not_at_rest_is_refused() {
    // A remainder of 5 from an earlier movement is left at the step.
    let record = Record::new(lag(2.0, 10.0, 3.0), 10.0, 0.1, 100.0)
        .with(|time, value| value + 5.0 * (-(time - STEP_AT) / 10.0).exp());
    for method in METHODS {
        let error = record.error(method);
        assert!(error.starts_with("the process value was not steady before the step: it moved by -"), "{error}");
    }
}

#[test]
fn a_step_in_a_record_of_two_is_found() {
    let model = lag(2.0, 5.0, 1.0);
    let mut process = Process::at_rest(model, 0.0);
    let mut record = Record::by(0.1, 80.0, 10.0, |_| 0.0);
    for (at, time) in record.times.iter().enumerate() {
        // An earlier step at 0 s has settled: 13 time constants.
        let input = if *time < 0.5 {
            0.0
        } else if *time < 60.0 {
            30.0
        } else {
            12.0
        };
        process.put(*time, input);
        (record.input[at], record.output[at]) = (input, process.output_at(*time));
    }
    for method in METHODS {
        let identified = record.identify(method, false).unwrap();
        assert_found(&identified, &model, 0.015, &format!("{method:?}"));
        assert_eq!(identified.times[0].round(), 60.0);
    }
}

#[test]
fn a_step_that_the_actuator_spreads_over_some_samples_is_still_a_step() {
    let model = lag(2.0, 10.0, 3.0);
    let mut process = Process::at_rest(model, 0.0);
    let mut record = Record::by(0.1, 100.0, 10.0, |_| 0.0);
    for (at, time) in record.times.iter().enumerate() {
        let input = 40.0 + 10.0 * ((time - STEP_AT) / 2.0).clamp(0.0, 1.0);
        process.put(*time, input - 40.0);
        (record.input[at], record.output[at]) = (input, process.output_at(*time));
    }
    for method in METHODS {
        // The slope is steepest at the end of the step, when a lag of 10 s has covered a tenth of its distance.
        let part = match method {
            Method::LeastSquares => 0.005,
            Method::Tangent => 0.11,
            _ => 0.03,
        };
        assert_found(&record.identify(method, false).unwrap(), &model, part, &format!("{method:?}"));
    }
}

#[test]
fn samples_need_not_be_evenly_spaced() {
    let model = lag(2.0, 10.0, 3.0);
    let mut process = Process::at_rest(model, 0.0);
    let mut record = Record::by(0.1, 100.0, 10.0, |_| 0.0);
    let mut random = Random(7);
    for (at, time) in record.times.iter_mut().enumerate() {
        if record.input[at] == record.input[at.saturating_sub(1)] {
            *time += 0.08 * random.uniform();
        } else {
            process.put(*time, 10.0);
        }
        record.output[at] = process.output_at(*time);
    }
    for method in METHODS {
        assert_found(&record.identify(method, false).unwrap(), &model, 0.015, &format!("{method:?}"));
    }
}

#[test]
fn an_integrating_plant_has_a_slope_and_a_dead_time() {
    for (gain, dead_time) in [(0.05, 4.0), (-0.2, 0.0), (0.01, 7.33)] {
        let model = Model { gain, dead_time, is_integrating: true, ..Model::default() };
        for height in [10.0, -3.0] {
            let record = Record::new(model, height, 0.1, 60.0);
            // The level may already rise before the step; its slope is subtracted.
            let rising = Record::new(model, height, 0.1, 60.0).with(|time, value| value + 0.02 * time);
            for method in [Method::LeastSquares, Method::Tangent] {
                for record in [&record, &rising] {
                    let found = record.identify(method, true).unwrap().model;
                    assert!((found.gain / gain - 1.0).abs() < 0.01, "{method:?} {found:?} {model:?}");
                    assert!((found.dead_time - dead_time).abs() < 0.1, "{method:?} {found:?} {model:?}");
                    assert!(found.is_integrating && found.time_constant == 0.0);
                }
            }
        }
    }
    let model = Model { gain: 0.05, dead_time: 4.0, is_integrating: true, ..Model::default() };
    let noisy = Record::new(model, 10.0, 0.1, 60.0).with_noise(0.3);
    let found = noisy.identify(Method::LeastSquares, true).unwrap().model;
    assert!((found.gain / 0.05 - 1.0).abs() < 0.02 && (found.dead_time - 4.0).abs() < 0.5, "{found:?}");
    let error = format!("{:#}", noisy.identify(Method::TwoPoints, true).unwrap_err());
    assert!(error.ends_with("use least squares"), "{error}");
}

#[test]
fn the_lag_behind_an_integrator_is_told_from_its_dead_time_and_noise_makes_none() {
    for (second_time_constant, dead_time) in [(6.0, 2.0), (3.0, 0.0), (1.0, 5.0)] {
        let model = Model { gain: 0.05, second_time_constant, dead_time, is_integrating: true, ..Model::default() };
        for deviation in [0.0, 0.01] {
            let record = Record::new(model, 10.0, 0.1, 60.0).with_noise(deviation);
            let found = record.identify(Method::LeastSquares, true).unwrap().model;
            let most = if deviation == 0.0 { 0.02 } else { 0.2 };
            assert!((found.gain / 0.05 - 1.0).abs() < 0.01 && found.is_integrating, "{found:?}");
            assert!((found.second_time_constant - second_time_constant).abs() < most, "{found:?} {model:?}");
            assert!((found.dead_time - dead_time).abs() < most, "{found:?} {model:?}");
        }
    }
    let model = Model { gain: 0.05, dead_time: 4.0, is_integrating: true, ..Model::default() };
    for deviation in [0.0, 0.01, 0.3] {
        let record = Record::new(model, 10.0, 0.1, 60.0).with_noise(deviation);
        assert_eq!(record.identify(Method::LeastSquares, true).unwrap().model.second_time_constant, 0.0);
    }
}

#[test]
fn a_plant_of_the_wrong_kind_is_refused_with_the_fit() {
    let integrating = Model { gain: 0.05, dead_time: 1.0, is_integrating: true, ..Model::default() };
    let error = Record::new(integrating, 10.0, 0.1, 60.0).error(Method::TwoPoints);
    assert!(
        error.contains("still moving at the end of the record") && error.ends_with("an integrating plant"),
        "{error}"
    );
    let error = Record::new(integrating, 10.0, 0.1, 60.0).error(Method::LeastSquares);
    assert!(error.contains("integrat"), "{error}");
    let record = Record::new(lag(2.0, 3.0, 0.0), 10.0, 0.1, 100.0);
    let error = format!("{:#}", record.identify(Method::LeastSquares, true).unwrap_err());
    assert!(error.contains("%; at least 60 % is required") && error.contains("may not be integrating"), "{error}");
}

#[test]
fn a_process_value_at_the_end_of_its_range_is_refused() {
    let record = Record::new(lag(2.0, 10.0, 3.0), 10.0, 0.1, 100.0).with(|_, value| value.min(37.0));
    for method in METHODS {
        let error = record.error(method);
        assert!(error.starts_with("the process value stops at 37 after 12.2 s"), "{error}");
    }
}

#[test]
fn a_record_without_a_step_says_what_is_there_instead() {
    let mut record = Record::new(lag(2.0, 10.0, 3.0), 10.0, 0.1, 100.0);
    record.input.fill(40.0);
    assert!(record.error(Method::Area).starts_with("no step found: the manipulated value is constant at 40"));
    let count = record.input.len() as f64;
    record.input = (0..record.input.len()).map(|at| 50.0 * at as f64 / count).collect();
    assert!(record.error(Method::Area).contains("never by more than"), "{}", record.error(Method::Area));
    // A closed loop: a jump, followed by further movement.
    record.input = record
        .times
        .iter()
        .map(|time| if *time < STEP_AT { 40.0 } else { 50.0 + 20.0 * (-(time - STEP_AT) / 30.0).exp() })
        .collect();
    let error = record.error(Method::Area);
    assert!(error.starts_with("the manipulated value is not constant after the step at 20 s"), "{error}");
    record.input = record.times.iter().map(|time| 40.0 + 10.0 * (time / 3.0).sin()).collect();
    assert!(record.error(Method::Area).contains("manual mode"), "{}", record.error(Method::Area));
}

#[test]
fn pulses_count_by_their_means() {
    // Periods of 1 s in 50 samples, 20 % on until the step at 20 s, then 60 %; and from a pause, and to one.
    let model = lag(2.0, 10.0, 3.0);
    for (before, after) in [(20, 60), (0, 40), (60, 0), (30, 100)] {
        let mut process = Process::at_rest(model, -200.0);
        let pulse = |at: i32, percent: i32| if (at.rem_euclid(50)) * 2 < percent { 100.0 } else { 0.0 };
        for at in -10_000..0 {
            process.put(f64::from(at) * 0.02, pulse(at, before));
        }
        let mut record = Record::by(0.02, 100.0, 10.0, |_| 0.0);
        for at in 0..record.times.len() {
            let time = record.times[at];
            record.input[at] = pulse(at as i32, if time < STEP_AT - 1e-9 { before } else { after });
            process.put(time, record.input[at]);
            record.output[at] = process.output_at(time);
        }
        let identified = record.identify(Method::LeastSquares, false).unwrap();
        // A pulse is at the beginning of its period: it acts up to half a period earlier than its mean.
        assert_found(&identified, &model, 0.05, &format!("{before} {after}"));
        assert_eq!(identified.remarks, ["The manipulated value consists of pulses: its means over 1 s are used."]);
    }
}

#[test]
fn a_record_that_is_too_short_says_by_how_much() {
    let model = lag(2.0, 10.0, 3.0);
    let error = Record::new(model, 10.0, 0.1, 2.5).error(Method::LeastSquares);
    assert!(error.starts_with("the process value has not moved in the 2.5"), "{error}");
    let error = Record::new(model, 10.0, 0.1, 25.0).error(Method::Area);
    assert!(error.contains("% of its response in the last fifth"), "{error}");
    let error = Record::new(model, 10.0, 0.1, 5.0).error(Method::LeastSquares);
    assert!(error.starts_with("the record is too short: it shows 18 % of the response"), "{error}");
    let error = Record::new(model, 10.0, 0.1, 0.5).error(Method::LeastSquares);
    assert!(error.starts_with("only 6 samples follow the step"), "{error}");
}

#[test]
fn an_answer_that_drowns_in_noise_or_counts_is_refused() {
    let model = lag(2.0, 10.0, 3.0);
    let error = Record::new(model, 1.0, 0.1, 100.0).with_noise(0.5).error(Method::LeastSquares);
    assert!(error.contains("times its noise of 0.") && error.contains("make a larger step"), "{error}");
    let error = Record::new(model, 1.0, 0.1, 100.0).with(|_, value| (value / 0.25).round() * 0.25).error(Method::Area);
    assert!(
        error.contains("only 8 times its smallest change of 0.2500: make a step at least 3 times as large"),
        "{error}"
    );
}

#[test]
fn values_that_make_no_record_are_refused() {
    let times: Vec<f64> = (0..30).map(f64::from).collect();
    let values = vec![0.0; 30];
    let error = |times: &[f64], output: &[f64]| {
        format!("{:#}", identify(&Recorded { times, input: &values, output }, Method::Area, false).unwrap_err())
    };
    assert!(error(&times[..29], &values).starts_with("29 times, 30 manipulated values and 30 process values"));
    let mut gap = values.clone();
    gap[7] = f64::NAN;
    assert!(error(&times, &gap).starts_with("sample 7 at 7 s has a value that is not a number"));
    let mut back = times.clone();
    back[5] = 4.0;
    assert!(error(&back, &values).starts_with("the time goes from 4 s to 4 s"));
}

#[test]
fn a_long_record_is_drawn_with_few_points() {
    let model = lag(2.0, 10.0, 3.0);
    let identified = Record::new(model, 10.0, 0.004, 100.0).identify(Method::LeastSquares, false).unwrap();
    assert_found(&identified, &model, 1e-4, "long");
    assert!(identified.times.len() <= MOST_POINTS && identified.times.len() > MOST_POINTS / 2);
}

#[test]
fn a_noisy_record_of_100_000_samples_is_identified_by_every_method() {
    let model = lag(2.0, 10.0, 3.0);
    let record = Record::new(model, 10.0, 0.001, 100.0).with_noise(0.2);
    for method in METHODS {
        assert_found(&record.identify(method, false).unwrap(), &model, 0.1, &format!("{method:?}"));
    }
}

#[test]
fn a_csv_file_of_the_plant_is_read_by_its_columns() {
    let record = Record::new(lag(2.0, 10.0, 3.0), 10.0, 0.5, 80.0);
    let mut text = String::from("Zeit [s];Ventil [%];Temperatur [degC]\n");
    for ((time, input), output) in record.times.iter().zip(&record.input).zip(&record.output) {
        text += &format!("{time:.3};{input:.3};{output:.6}\n").replace('.', ",");
    }
    let data = |input: Option<&str>, to| Data::Csv {
        text: text.clone(),
        time: None,
        input: input.map(str::to_string),
        output: Some("Temperatur".into()),
        from: None,
        to,
    };
    let request = |data| IdentifyRequest { data, method: Method::LeastSquares, is_integrating: false };
    let identified = of_csv(&request(data(Some("Ventil"), None))).unwrap();
    assert_found(&identified, &lag(2.0, 10.0, 3.0), 0.001, "CSV");
    let error = |data| format!("{:#}", of_csv(&request(data)).unwrap_err());
    // Line 1 is the header.
    let mut lines: Vec<&str> = text.lines().collect();
    let (begin, _) = lines[10].rsplit_once(';').unwrap();
    let empty = format!("{begin};");
    lines[10] = &empty;
    let holed = Data::Csv {
        text: lines.join("\n"),
        time: None,
        input: Some("Ventil".into()),
        output: Some("Temperatur".into()),
        from: None,
        to: None,
    };
    let identified = of_csv(&request(holed)).unwrap();
    assert_found(&identified, &lag(2.0, 10.0, 3.0), 0.01, "a CSV with a hole");
    assert_eq!(
        identified.remarks[1],
        "Line 11, column Temperatur: no value; rows without a value are ignored. Complete the file if the step occurs \
         there."
    );
    let message = error(data(None, None));
    assert!(
        message.starts_with(
            "choose the manipulated value column: none of Zeit [s], Ventil [%], Temperatur [degC] has a recognized \
             name (LMN, MV"
        ),
        "{message}"
    );
    assert!(error(data(Some("Ventill"), None)).contains("did you mean Ventil?"));
    assert!(error(data(Some("Ventil"), Some(10.0))).starts_with("no step found"));
}

#[test]
fn columns_of_a_csv_file_are_found_by_their_usual_names_or_as_the_header_writes_them() {
    let record = Record::new(lag(2.0, 10.0, 3.0), 10.0, 0.5, 80.0);
    let mut text = String::from("Export of the recorder\nZeit [s];Sollwert [°C];Istwert [°C];TIC1.Stellwert [%]\n");
    for ((time, input), output) in record.times.iter().zip(&record.input).zip(&record.output) {
        text += &format!("{time:.3};50;{output:.6};{input:.3}\n").replace('.', ",");
    }
    let headers = crate::csv::CsvTable::read(&text).unwrap().headers();
    assert_eq!(headers, ["Zeit [s]", "Sollwert [°C]", "Istwert [°C]", "TIC1.Stellwert [%]"]);
    let column = |at: usize| Some(headers[at].clone());
    for (time, input, output) in [(None, None, None), (column(0), column(3), column(2))] {
        let data = Data::Csv { text: text.clone(), time, input, output, from: None, to: None };
        let request = IdentifyRequest { data, method: Method::LeastSquares, is_integrating: false };
        let identified = of_csv(&request).unwrap();
        assert_found(&identified, &lag(2.0, 10.0, 3.0), 0.001, "CSV");
        assert_eq!(
            identified.remarks[0],
            "The manipulated value is TIC1.Stellwert [%], the process value Istwert [°C]."
        );
    }
}

#[test]
fn a_movement_that_has_died_away_before_the_step_does_not_count() {
    // The first manual value moves the process value, which is at rest again ten time constants later.
    for noise in [0.0, 0.02] {
        let model = lag(2.0, 10.0, 3.0);
        let mut process = Process::at_rest(model, 0.0);
        process.put(0.0, 30.0);
        process.put(110.0, 40.0);
        let times: Vec<f64> = (0..=620).map(|at| f64::from(at) * 0.5).collect();
        let input: Vec<f64> = times.iter().map(|time| if *time < 110.0 { 30.0 } else { 40.0 }).collect();
        let swing = |at: usize| noise * (at as f64 * 12.9898).sin();
        let output: Vec<f64> =
            times.iter().enumerate().map(|(at, time)| process.output_at(*time) + swing(at)).collect();
        let recorded = Recorded { times: &times, input: &input, output: &output };
        for method in [Method::LeastSquares, Method::TwoPoints, Method::Area] {
            let identified = identify(&recorded, method, false).unwrap();
            assert_found(&identified, &model, 0.02, &format!("{method:?}, noise {noise}"));
            assert!(!identified.remarks.iter().any(|remark| remark.contains("at rest")), "{:?}", identified.remarks);
        }
    }
}
