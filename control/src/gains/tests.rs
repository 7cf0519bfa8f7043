use super::*;
use proptest::prelude::*;

fn controller(form: Form, numbers: &[(&str, f64)]) -> Result<Controller, String> {
    let values: Vec<_> = numbers.iter().map(|(name, value)| (name.to_string(), *value)).collect();
    Controller::new(form, &values)
}

/// Returns the settings of the block as numbers.
fn settings(form: Form, numbers: &[(&str, f64)]) -> Vec<(&'static str, f64)> {
    let (settings, _) = controller(form, numbers).and_then(|controller| controller.settings()).unwrap();
    settings.values().into_iter().map(|(name, value)| (name, number(value))).collect()
}

/// Returns the numbers in another form, without the round-off of the computation.
fn converted(from: Form, numbers: &[(&str, f64)], to: Form) -> Result<Vec<(&'static str, f64)>, String> {
    let numbers = controller(from, numbers)?.numbers(to)?;
    Ok(numbers.into_iter().map(|(name, value)| (name, shown(value))).collect())
}

fn refusal<T: std::fmt::Debug>(result: Result<T, String>) -> String {
    result.unwrap_err()
}

const ON: [(&str, f64); 3] = [("P_SEL", 1.0), ("I_SEL", 1.0), ("D_SEL", 1.0)];

#[test]
fn each_form_of_one_controller_gives_the_same_settings() {
    let mut expected = vec![("GAIN", 2.0), ("TI", 20.0), ("TD", 2.0), ("TM_LAG", 0.2)];
    expected.extend(ON);
    let forms: [(Form, &[(&str, f64)]); 7] = [
        // TI = 2 / 0.1, TD = 4 / 2, TM_LAG = TD / 10
        (Form::Parallel, &[("Kp", 2.0), ("Ki", 0.1), ("Kd", 4.0), ("N", 10.0)]),
        (Form::Parallel, &[("Kp", 2.0), ("Ki", 0.1), ("Kd", 4.0), ("Tf", 0.2)]),
        (Form::Ideal, &[("Kp", 2.0), ("Ti", 20.0), ("Td", 2.0), ("N", 10.0)]),
        // TM_LAG = 1 / 5 s: here N is in 1/s
        (Form::Simulink, &[("P", 2.0), ("I", 0.1), ("D", 4.0), ("N", 5.0)]),
        (Form::SimulinkIdeal, &[("P", 2.0), ("I", 0.05), ("D", 2.0), ("N", 5.0)]),
        (Form::TwinCat, &[("fKp", 2.0), ("tTn", 20.0), ("tTv", 2.0), ("tTd", 0.2)]),
        (Form::Plc, &[("GAIN", 2.0), ("TI", 20.0), ("TD", 2.0), ("TM_LAG", 0.2)]),
    ];
    for (form, numbers) in forms {
        assert_eq!(settings(form, numbers), expected, "{numbers:?}");
    }
}

#[test]
fn a_series_form_has_the_sum_of_its_times_as_ti() {
    // (1 + 1 / (10 s)) (1 + 10 s) = 2 + 1 / (10 s) + 10 s = 2 (1 + 1 / (20 s) + 5 s)
    let mut expected = vec![("GAIN", 4.0), ("TI", 20.0), ("TD", 5.0), ("TM_LAG", 0.0)];
    expected.extend(ON);
    assert_eq!(settings(Form::Series, &[("Kp", 2.0), ("Ti", 10.0), ("Td", 10.0)]), expected);
    // With a filter of 8 / 8 = 1 s: TI = 12 + 8, TD = 8 (12 - 1) / 20, GAIN = 3 (1 + 8 / 12)
    let mut expected = vec![("GAIN", 5.0), ("TI", 20.0), ("TD", 4.4), ("TM_LAG", 1.0)];
    expected.extend(ON);
    assert_eq!(settings(Form::Series, &[("Kp", 3.0), ("Ti", 12.0), ("Td", 8.0), ("N", 8.0)]), expected);
}

#[test]
fn settings_become_a_series_form_if_there_is_one() {
    // 4 TD = TI: two equal zeros
    let plc = [("GAIN", 4.0), ("TI", 20.0), ("TD", 5.0)];
    assert_eq!(converted(Form::Plc, &plc, Form::Series), Ok(vec![("Kp", 2.0), ("Ti", 10.0), ("Td", 10.0)]));
    let plc = [("GAIN", 5.0), ("TI", 20.0), ("TD", 4.4), ("TM_LAG", 1.0)];
    assert_eq!(converted(Form::Plc, &plc, Form::Series), Ok(vec![("Kp", 3.0), ("Ti", 12.0), ("Td", 8.0), ("N", 8.0)]));
    // Td (TI - Td) = TI TD: a short Td keeps its digits, Td = TD (1 + TD / TI).
    let short = converted(Form::Plc, &[("GAIN", 1.0), ("TI", 20_000.0), ("TD", 1e-5)], Form::Series).unwrap();
    assert!(short[2].0 == "Td" && (short[2].1 / (1e-5 * (1.0 + 1e-5 / 20_000.0)) - 1.0).abs() < 1e-14, "{short:?}");
    assert_eq!(
        refusal(converted(Form::Plc, &[("GAIN", 4.0), ("TI", 20.0), ("TD", 6.0)], Form::Series)),
        "no series form has this response: it would need TI >= 4 TD, but TI = 20 s and TD = 6 s; a series form has \
         real zeros only"
    );
    let slow_filter = [("GAIN", 4.0), ("TI", 1.0), ("TD", 1.0), ("TM_LAG", 9.0)];
    assert!(refusal(converted(Form::Plc, &slow_filter, Form::Series)).contains("TM_LAG = 9 s below TI"));
}

#[test]
fn settings_become_the_numbers_of_each_other_form() {
    let plc = [("GAIN", 2.0), ("TI", 20.0), ("TD", 2.0), ("TM_LAG", 0.2)];
    let forms = [
        (Form::Parallel, vec![("Kp", 2.0), ("Ki", 0.1), ("Kd", 4.0), ("N", 10.0)]),
        (Form::Ideal, vec![("Kp", 2.0), ("Ti", 20.0), ("Td", 2.0), ("N", 10.0)]),
        (Form::Simulink, vec![("P", 2.0), ("I", 0.1), ("D", 4.0), ("N", 5.0)]),
        (Form::SimulinkIdeal, vec![("P", 2.0), ("I", 0.05), ("D", 2.0), ("N", 5.0)]),
        (Form::TwinCat, vec![("fKp", 2.0), ("tTn", 20.0), ("tTv", 2.0), ("tTd", 0.2)]),
    ];
    for (form, numbers) in forms {
        assert_eq!(converted(Form::Plc, &plc, form), Ok(numbers));
    }
    assert_eq!(
        converted(Form::Plc, &plc[..3], Form::Codesys),
        Ok(vec![("KP", 2.0), ("TN", 20.0), ("TV", 2.0)]),
        "CODESYS has no filter"
    );
    assert!(refusal(converted(Form::Plc, &plc, Form::Codesys)).contains("filter of 0.2 s"));
    assert!(refusal(converted(Form::Plc, &plc[..3], Form::Simulink)).contains("Simulink's always has one"));
}

#[test]
fn an_action_without_gain_is_switched_off() {
    let off = |actions: &[&str], numbers: &[(&str, f64)]| {
        let values = settings(Form::Parallel, numbers);
        for (name, value) in &values {
            if name.ends_with("_SEL") {
                assert_eq!(*value == 0.0, actions.contains(name), "{name} of {numbers:?}");
            }
        }
        values
    };
    let pi = off(&["D_SEL"], &[("Kp", 2.0), ("Ki", 0.1), ("Kd", 0.0)]);
    assert!(!pi.iter().any(|(name, _)| ["TD", "TM_LAG"].contains(name)));
    let pd = off(&["I_SEL"], &[("Kp", 2.0), ("Ki", 0.0), ("Kd", 1.0)]);
    assert!(!pd.iter().any(|(name, _)| *name == "TI"));
    // -1 / (5 s) = -0.2 / s
    let i = off(&["P_SEL", "D_SEL"], &[("Ki", -0.2)]);
    assert_eq!(i[..2], [("GAIN", -1.0), ("TI", 5.0)]);
}

#[test]
fn the_plc_rounds_gains_to_reals_and_times_to_milliseconds() {
    let (settings, remarks) = controller(Form::Ideal, &[("Kp", 1.0 / 3.0), ("Ti", 20.0004), ("Td", 0.1), ("Tf", 0.01)])
        .unwrap()
        .settings()
        .unwrap();
    assert_eq!(settings.gain, 1.0f32 / 3.0);
    assert_eq!(settings.ti, Some(Time::ms(20_000)));
    assert_eq!(
        remarks,
        [
            "GAIN = 0.333333333333 becomes the REAL 0.33333334",
            "TI = 20.0004 s becomes 20 s: a TIME is a whole number of milliseconds"
        ]
    );
    let exact = controller(Form::Series, &[("Kp", 2.0), ("Ti", 10.0), ("Td", 1.0), ("Tf", 0.0)]).unwrap();
    let (_, remarks) = exact.settings().unwrap();
    // TD = 10 / 11
    assert_eq!(
        remarks,
        [
            "TD = 0.909090909091 s becomes 0.909 s: a TIME is a whole number of milliseconds",
            "the D action has no filter: TM_LAG = 0 s is below CYCLE / 2, so the block uses CYCLE / 2"
        ]
    );
}

#[test]
fn numbers_that_a_plc_cannot_hold_are_refused() {
    let refused = |numbers: &[(&str, f64)]| refusal(controller(Form::Ideal, numbers).unwrap().settings());
    assert_eq!(
        refused(&[("Kp", 1e39)]),
        "GAIN = 1000000000000000000000000000000000000000: a REAL accepts finite numbers with \
                                          a magnitude of at most 3.4028235e38"
    );
    assert_eq!(refused(&[("Kp", 1.0), ("Ti", 1e7)]), "TI = 10000000 s: a TIME accepts 0 ... 2147483.647 s");
    assert_eq!(refused(&[("Kp", 1e-60)]), "GAIN = 1e-60 is too small for a REAL: it would become 0");
}

#[test]
fn the_block_raises_times_below_what_its_cycle_allows() {
    let numbers = [("Kp", 2.0), ("Ti", 0.04), ("Td", 0.05), ("N", 10.0)];
    let (settings, _) = controller(Form::Ideal, &numbers).unwrap().settings().unwrap();
    let (computed, remarks) = settings.computed(0.1);
    assert_eq!(computed, Controller { proportional: 2.0, integral: 40.0, derivative: 0.2, lag: 0.05 });
    assert_eq!(
        remarks,
        [
            "TI = 0.04 s is below CYCLE / 2: the block uses 0.05 s",
            "TD = 0.05 s is below CYCLE: the block uses 0.1 s",
            "TM_LAG = 0.005 s is below CYCLE / 2: the block uses 0.05 s"
        ]
    );
    let (computed, remarks) = settings.computed(0.01);
    assert_eq!(computed, Controller { proportional: 2.0, integral: 50.0, derivative: 0.1, lag: 0.005 });
    assert_eq!(remarks, Vec::<String>::new());
}

#[test]
fn what_no_block_computes_is_refused_with_its_reason() {
    let refused = |form, numbers: &[(&str, f64)]| refusal(controller(form, numbers));
    let signs = refused(Form::Parallel, &[("Kp", 2.0), ("Ki", -0.1)]);
    assert!(signs.starts_with("the gains 2, -0.1 and 0 of P, I and D have different signs"), "{signs}");
    let signs = refused(Form::Parallel, &[("Kp", -2.0), ("Kd", 4.0), ("N", 10.0)]);
    assert!(signs.contains("different signs"), "{signs}");
    assert_eq!(refused(Form::Ideal, &[("Ti", 20.0)]), "Kp is missing: the form ideal requires it");
    assert_eq!(
        refused(Form::TwinCat, &[("fKp", 0.0), ("tTn", 20.0)]),
        "fKp = 0 switches off P, I and D together: specify another gain"
    );
    assert_eq!(
        refused(Form::Ideal, &[("Kp", 2.0), ("Ti", 0.0)]),
        "Ti = 0 is not above 0 s: omit Ti if there is no I action"
    );
    assert_eq!(refused(Form::Ideal, &[("Kp", 1.0), ("Td", -1.0)]), "Td = -1 is negative: a time must be 0 s or longer");
    assert_eq!(refused(Form::Ideal, &[("K", 1.0)]), "the form ideal has no K: its parameters are Kp, Ti, Td, N, Tf");
    assert_eq!(refused(Form::Ideal, &[("Kp", 1.0), ("KP", 1.0)]), "KP is given twice: remove one of the values");
    assert_eq!(refused(Form::Ideal, &[("Kp", f64::NAN)]), "Kp = NaN is not a finite number");
    assert_eq!(refused(Form::Ideal, &[("Kp", 1.0), ("Td", 1.0), ("N", 0.0)]), "N = 0: it must be above 0");
    assert_eq!(
        refused(Form::Ideal, &[("Kp", 1.0), ("Td", 1.0), ("N", 5.0), ("Tf", 0.2)]),
        "N and Tf are alternatives: specify only one of them"
    );
    assert!(refused(Form::Parallel, &[("Kd", 1.0), ("N", 5.0)]).starts_with("N is relative to Kd / Kp, but Kp is 0"));
    assert!(refused(Form::Simulink, &[("P", 1.0), ("D", 1.0)]).starts_with("N is missing"));
    let series = refused(Form::Series, &[("Kp", 1.0), ("Ti", 1.0), ("Td", 4.0), ("N", 2.0)]);
    assert!(series.starts_with("the filter of 2 s is not faster than Ti = 1 s"), "{series}");
    assert_eq!(refused(Form::Plc, &[("GAIN", 1.0), ("I_SEL", 1.0)]), "I_SEL is TRUE, but TI is missing");
    assert_eq!(refused(Form::Plc, &[("GAIN", 1.0), ("P_SEL", 0.5)]), "P_SEL = 0.5 is neither FALSE nor TRUE");
}

/// A complex number.
#[derive(Clone, Copy, Debug)]
struct Complex(f64, f64);

impl Complex {
    fn plus(self, other: Complex) -> Complex {
        Complex(self.0 + other.0, self.1 + other.1)
    }

    fn times(self, other: Complex) -> Complex {
        Complex(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }

    fn over(self, other: Complex) -> Complex {
        let square = other.0 * other.0 + other.1 * other.1;
        let Complex(real, imaginary) = self.times(Complex(other.0, -other.1));
        Complex(real / square, imaginary / square)
    }
}

/// Computes the frequency response directly from the formula of the form.
fn response(form: Form, numbers: &[(&str, f64)], frequency: f64) -> Complex {
    let find = |name: &str| numbers.iter().find(|(own, _)| *own == name).map(|(_, value)| Complex(*value, 0.0));
    let (zero, one, s) = (Complex(0.0, 0.0), Complex(1.0, 0.0), Complex(0.0, frequency));
    let get = |name: &str| find(name).unwrap_or(zero);
    let reset = |name: &str| find(name).map_or(zero, |ti| one.over(ti.times(s)));
    let rate = |td: Complex, lag: Complex| td.times(s).over(one.plus(lag.times(s)));
    let relative = |td: Complex| find("N").map_or(get("Tf"), |n| td.over(n));
    let coefficient = || match find("N") {
        Some(n) => n.over(one.plus(n.over(s))),
        None => zero,
    };
    match form {
        Form::Plc => {
            let actions = if get("I_SEL").0 == 1.0 { reset("TI") } else { zero };
            let rate = if get("D_SEL").0 == 1.0 { rate(get("TD"), get("TM_LAG")) } else { zero };
            get("GAIN").times(get("P_SEL").plus(actions).plus(rate))
        }
        Form::Parallel => {
            let lag = if find("N").is_some() { relative(get("Kd").over(get("Kp"))) } else { get("Tf") };
            get("Kp").plus(get("Ki").over(s)).plus(rate(get("Kd"), lag))
        }
        Form::Ideal => get("Kp").times(one.plus(reset("Ti")).plus(rate(get("Td"), relative(get("Td"))))),
        Form::Series => get("Kp").times(one.plus(reset("Ti"))).times(one.plus(rate(get("Td"), relative(get("Td"))))),
        Form::Simulink => get("P").plus(get("I").over(s)).plus(get("D").times(coefficient())),
        Form::SimulinkIdeal => get("P").times(one.plus(get("I").over(s)).plus(get("D").times(coefficient()))),
        Form::TwinCat => get("fKp").times(one.plus(reset("tTn")).plus(rate(get("tTv"), get("tTd")))),
        Form::Codesys => get("KP").times(one.plus(reset("TN")).plus(get("TV").times(s))),
    }
}

/// Numbers of a form, some of them missing.
fn numbers() -> impl Strategy<Value = (Form, Vec<(&'static str, f64)>)> {
    let positive = || (-3.0..3.0f64).prop_map(|exponent| 10f64.powf(exponent));
    let number = (any::<bool>(), positive());
    (prop::sample::select(Form::ALL.to_vec()), any::<bool>(), positive(), prop::collection::vec(number, 3)).prop_map(
        |(form, is_negative, gain, others)| {
            let sign = if is_negative { -1.0 } else { 1.0 };
            let mut numbers = vec![(form.names()[0], sign * gain)];
            for (name, (is_there, value)) in form.names()[1..].iter().zip(others) {
                let is_gain = ["Ki", "Kd", "I", "D"].contains(name) && form != Form::SimulinkIdeal;
                if is_there || *name == "N" {
                    numbers.push((name, if is_gain { sign * value } else { value }));
                }
            }
            (form, numbers)
        },
    )
}

proptest! {
    #[test]
    fn a_converted_controller_has_the_same_frequency_response((from, numbers) in numbers(), to in prop::sample::select(Form::ALL.to_vec())) {
        // A series form with a slow filter, for which no controller exists.
        let Ok(controller) = controller(from, &numbers) else { return Ok(()) };
        let mut numbers = numbers;
        if from == Form::Plc {
            let has = |name| numbers.iter().any(|(own, _)| *own == name);
            let switches = [("P_SEL", 1.0), ("I_SEL", f64::from(u8::from(has("TI")))), ("D_SEL", f64::from(u8::from(has("TD"))))];
            numbers.extend(switches);
        }
        let Ok(converted) = controller.numbers(to) else { return Ok(()) };
        for exponent in -4..=4 {
            let frequency = 10f64.powi(exponent);
            let (expected, is) = (response(from, &numbers, frequency), response(to, &converted, frequency));
            let size = expected.0.hypot(expected.1);
            let difference = (is.0 - expected.0).hypot(is.1 - expected.1);
            prop_assert!(difference <= 1e-9 * size, "{to:?} {converted:?} at {frequency}: {is:?} is not {expected:?}");
        }
    }

    #[test]
    fn whatever_becomes_a_series_form_comes_back(
        gain in 0.01..100.0f64, ti in 0.01..1000.0f64, td in 0.01..1000.0f64, lag in 0.0..1.0f64
    ) {
        let numbers = [("Kp", gain), ("Ti", ti), ("Td", td), ("Tf", lag * ti * 0.9)];
        let once = controller(Form::Series, &numbers).unwrap();
        let series = once.numbers(Form::Series).unwrap();
        let twice = controller(Form::Series, &series).unwrap();
        for (is, expected) in [
            (twice.proportional, once.proportional), (twice.integral, once.integral),
            (twice.derivative, once.derivative), (twice.lag, once.lag),
        ] {
            prop_assert!((is - expected).abs() <= 1e-6 * expected.abs(), "{is} is not {expected}");
        }
    }
}
