use super::*;
use run::dialog::Roles;

/// The response of a second-order system with damping 0.5 and natural frequency 1 rad/s to a setpoint step at `at`.
fn second_order(count: usize, step: f64, at: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let times: Vec<f64> = (0..count).map(|call| call as f64 * step).collect();
    let setpoint = (0..count).map(|call| if call < at { 20.0 } else { 60.0 }).collect();
    let frequency = 0.75_f64.sqrt();
    let answer = |time: f64| {
        let swing = (frequency * time).cos() + 0.5 / frequency * (frequency * time).sin();
        1.0 - (-0.5 * time).exp() * swing
    };
    let value = times.iter().map(|time| 20.0 + 40.0 * answer((time - times[at]).max(0.0))).collect();
    (times, setpoint, value)
}

fn all<'a>(times: &'a [f64], setpoint: &'a [f64], process_value: &'a [f64]) -> Window<'a> {
    Window::measure(Signals { times, setpoint, process_value, ..Signals::default() }, &Span::default())
}

impl Window<'_> {
    fn get(&self, key: &str) -> Option<f64> {
        find(key).unwrap().value(self).ok()
    }

    fn all_remarks(&self) -> Vec<String> {
        self.remarks(&self.figures().collect::<Vec<_>>())
    }
}

#[test]
fn the_figures_of_a_short_step_can_be_checked_by_hand() {
    let times: Vec<f64> = (0..12).map(f64::from).collect();
    let setpoint: Vec<f64> = (0..12).map(|call| if call < 1 { 0.0 } else { 10.0 }).collect();
    let value = [0.0, 0.0, 2.0, 4.0, 6.0, 8.0, 11.0, 10.1, 10.0, 10.0, 10.0, 10.0];
    let figures = all(&times, &setpoint, &value);
    // 1 is reached at 1.5 s, 9 at 5 1/3 s; 11 at 6 s is outside 9.8 to 10.2; the step is at 1 s.
    let expected = [
        ("rise", 16.0 / 3.0 - 1.5),
        ("overshoot", 10.0),
        ("settling", 6.0),
        ("iae", 10.0 + 8.0 + 6.0 + 4.0 + 2.0 + 1.0 + 0.1),
        ("ise", 100.0 + 64.0 + 36.0 + 16.0 + 4.0 + 1.0 + 0.01),
        ("peak", 10.0),
    ];
    for (key, expected) in expected {
        let value = figures.get(key).unwrap();
        assert!((value - expected).abs() < 1e-9, "{key}: {value}");
    }
    assert_eq!(figures.figures().map(|figure| figure.key).collect::<Vec<_>>(), expected.map(|(key, _)| key));
    assert_eq!(figures.band(), Some(Band { times: (1.0, 11.0), low: 9.8, high: 10.2 }));
}

#[test]
fn rows_that_begin_with_the_step_say_from_where_to_where_it_goes() {
    let (times, value) = ([0.0, 1.0, 2.0, 3.0, 4.0], [20.0, 40.0, 60.0, 60.0, 60.0]);
    let signals = Signals { times: &times, setpoint: &[60.0; 5], process_value: &value, ..Signals::default() };
    let figures = Window::measure(signals, &Span { step: Some((20.0, 60.0)), ..Span::default() });
    // From 24 at 0.2 s to 56 at 1.8 s.
    assert!((figures.get("rise").unwrap() - 1.6).abs() < 1e-12);
    assert_eq!((figures.get("settling"), figures.get("iae")), (Some(2.0), Some(60.0)));
}

#[test]
fn a_second_order_answer_has_the_figures_of_the_textbook() {
    let (times, setpoint, value) = second_order(30_000, 0.001, 1000);
    let figures = all(&times, &setpoint, &value);
    assert_eq!(figures.times().unwrap(), (1.0, times[29_999]));
    // exp(-pi zeta / sqrt(1 - zeta^2)), and roots of the response, computed independently.
    assert!((figures.get("overshoot").unwrap() - 16.30335).abs() < 1e-4, "{figures:?}");
    assert!((figures.get("rise").unwrap() - 1.6376).abs() < 2e-4, "{figures:?}");
    assert!((figures.get("settling").unwrap() - 8.0764).abs() < 1.1e-3, "{figures:?}");
    assert_eq!(figures.all_remarks(), [""; 0]);
}

#[test]
fn the_integrals_are_sums_over_the_calls() {
    let times = [0.0, 0.5, 1.0, 1.5];
    let figures = all(&times, &[0.0, 10.0, 10.0, 10.0], &[0.0, 0.0, 4.0, 12.0]);
    // 10, 6 and 2 for half a second each.
    assert_eq!((figures.get("iae"), figures.get("ise"), figures.get("peak")), (Some(9.0), Some(70.0), Some(10.0)));
    assert_eq!(figures.get("overshoot"), Some(20.0));
}

#[test]
fn travel_and_pulses_count_from_the_call_of_the_change_on() {
    let pulses = [vec![true, false, true, true], vec![false, true, false, true]];
    let signals = Signals {
        times: &[0.0, 1.0, 2.0, 3.0],
        setpoint: &[0.0, 0.0, 5.0, 5.0],
        process_value: &[0.0; 4],
        manipulated_value: &[7.0, 10.0, 30.0, 25.0],
        pulses: &pulses,
        travel_unit: Some("%"),
        ..Signals::default()
    };
    let figures = Window::measure(signals, &Span::default());
    assert_eq!((figures.get("travel"), figures.get("pulses")), (Some(25.0), Some(2.0)));
    let figures = Window::measure(signals, &Span { from: Some(0.0), ..Span::default() });
    assert_eq!((figures.get("travel"), figures.get("pulses")), (Some(28.0), Some(4.0)));
    let window = Span { from: Some(0.5), to: Some(1.5), ..Span::default() };
    let figures = Window::measure(signals, &window);
    assert_eq!(
        (figures.times(), figures.get("travel"), figures.get("pulses")),
        (Some((1.0, 1.0)), Some(3.0), Some(1.0))
    );
}

#[test]
fn a_step_down_has_the_same_figures_as_a_step_up() {
    let (times, setpoint, value) = second_order(3000, 0.01, 100);
    let of = |window: Window| FIGURES.map(|figure| figure.value(&window).ok());
    let up = of(all(&times, &setpoint, &value));
    let mirrored = |values: &[f64]| values.iter().map(|value| -value).collect::<Vec<_>>();
    let down = of(all(&times, &mirrored(&setpoint), &mirrored(&value)));
    assert_eq!(up, down);
}

#[test]
fn without_a_change_of_the_setpoint_there_are_integrals_only() {
    let figures = all(&[0.0, 1.0, 2.0], &[5.0; 3], &[5.0, 4.0, 4.0]);
    assert_eq!(
        (figures.get("iae"), figures.get("rise"), figures.get("overshoot"), figures.get("settling")),
        (Some(2.0), None, None, None)
    );
    assert!(figures.all_remarks()[0].ends_with("the setpoint does not change in this part of the run"));
}

#[test]
fn a_setpoint_that_never_changes_is_a_step_from_the_first_call_on() {
    // From 20 to 60, with a peak of 64: 4 of 40 beyond.
    let (times, setpoint) = ([0.0, 1.0, 2.0, 3.0, 4.0], [60.0; 5]);
    let signals = |process_value| Signals { times: &times, setpoint: &setpoint, process_value, ..Signals::default() };
    let rising = [20.0, 40.0, 64.0, 60.0, 60.0];
    let figures = Window::measure(signals(&rising), &Span::default());
    // 24 at 0.2 s and 56 at 1.667 s; within 0.8 of 60 from 3 s on.
    assert_eq!((figures.get("overshoot"), figures.get("settling")), (Some(10.0), Some(3.0)));
    assert!((figures.get("rise").unwrap() - (1.0 + 16.0 / 24.0 - 0.2)).abs() < 1e-12);
    let happened =
        Happened { cause: Cause::Start, from: 20.0, to: 60.0, start: 0.0, duration: 4.0, band: Some(0.8), by: vec![] };
    assert_eq!(figures.step_happened(), Some(happened));
    // The same where members run in parallel: the first row holds the outputs before the first call.
    let late = [0.0, 20.0, 40.0, 64.0, 60.0];
    let figures = Window::measure(Signals { first: 1, ..signals(&late) }, &Span::default());
    assert_eq!((figures.get("overshoot"), figures.get("peak")), (Some(10.0), Some(40.0)));
    // At rest, 1 below, and disturbed by 10; at rest but for the resolution of a word, and disturbed by 10 at 2 s.
    assert_eq!(Window::measure(signals(&[59.0, 59.0, 49.0, 55.0, 60.0]), &Span::default()).get("rise"), None);
    let all = Signals { disturbances: &[set(2.0)], ..signals(&[59.99, 59.99, 60.0, 50.0, 60.0]) };
    assert_eq!(Window::measure(all, &Span::default()).step_happened(), None);
}

#[test]
fn an_output_before_the_first_call_of_its_block_is_no_process_value() {
    // The block is first called at 2 s, and then every 2 s: the step goes from 20 to 50, not from 0.
    let value = [0.0, 0.0, 30.0, 30.0, 31.0, 31.0, 42.0, 42.0, 48.0, 48.0, 50.0, 50.0, 50.0, 50.0];
    let times: Vec<f64> = (0..14).map(f64::from).collect();
    let figures = all(&times, &[50.0; 14], &value);
    assert_eq!((figures.times(), figures.get("peak")), (Some((2.0, 13.0)), Some(20.0)));
    assert_eq!(figures.get("settling"), Some(8.0));
    // A plant that begins at 0 and has a dead time does not jump.
    let value = [0.0, 0.0, 0.0, 5.0, 10.0, 14.0, 17.0, 18.0, 19.0, 20.0, 20.0, 20.0, 20.0, 20.0];
    assert_eq!(all(&times, &[20.0; 14], &value).times(), Some((0.0, 13.0)));
}

/// A step from 0 to 10 at 1 s, a disturbance at 6 s by which the process value falls to 7 and is back at 9 s.
const STEP: [f64; 12] = [0.0, 0.0, 5.0, 11.0, 10.0, 10.0, 10.0, 8.0, 7.0, 10.1, 10.0, 10.0];

fn disturbed<'a>(times: &'a [f64], setpoint: &'a [f64], by: &'a [Set]) -> Signals<'a> {
    Signals { times, setpoint, process_value: &STEP, disturbances: by, ..Signals::default() }
}

fn set(time: f64) -> Set {
    Set { time, variable: "TANK.DRAIN".into(), value: Some(1.0), before: None }
}

#[test]
fn the_window_of_a_step_ends_at_the_disturbance_which_has_figures_of_its_own() {
    let by = [set(6.0)];
    let times: Vec<f64> = (0..12).map(f64::from).collect();
    let setpoint: Vec<f64> = (0..12).map(|call| if call < 1 { 0.0 } else { 10.0 }).collect();
    let figures = Window::measure(disturbed(&times, &setpoint, &by), &Span::default());
    assert_eq!(figures.times(), Some((1.0, 5.0)));
    // Within 9.8 to 10.2 from 4 s on; from 6 s on it deviates by 2, 3 and 0.1, and is back in the band at 9 s.
    let expected = [("settling", 3.0), ("overshoot", 10.0), ("iae", 10.0 + 5.0 + 1.0), ("peak", 10.0)];
    let after = [("recovery", 3.0), ("disturbed_peak", 3.0), ("disturbed_iae", 5.1)];
    for (key, expected) in expected.into_iter().chain(after) {
        let value = figures.get(key).unwrap();
        assert!((value - expected).abs() < 1e-12, "{key}: {value}");
    }
    assert_eq!(figures.all_remarks(), [""; 0]);
    let (start, band) = (1.0, Some(0.2));
    let step = Happened { cause: Cause::Setpoint, from: 0.0, to: 10.0, start, duration: 4.0, band, by: vec![] };
    let disturbance = Happened {
        cause: Cause::Disturbance,
        from: 10.0,
        to: 10.0,
        start: 6.0,
        duration: 5.0,
        band,
        by: vec![set(6.0)],
    };
    assert_eq!((figures.step_happened(), figures.disturbance_happened()), (Some(step), Some(disturbance)));
    // One after the other, each with only its own figures.
    let each = Window::of_events(disturbed(&times, &setpoint, &by));
    let keys = |window: &Window| window.figures().map(|figure| figure.key).collect::<Vec<_>>();
    assert_eq!(
        each.iter().map(keys).collect::<Vec<_>>(),
        [
            vec!["rise", "overshoot", "settling", "iae", "ise", "peak"],
            vec!["recovery", "disturbed_peak", "disturbed_iae"]
        ]
    );
    assert_eq!((each[0].get("settling"), each[1].get("recovery")), (Some(3.0), Some(3.0)));
    // Rows that begin with the step have its values given, and the disturbance ends it all the same.
    let span = Span { step: Some((0.0, 10.0)), ..Span::default() };
    let figures = Window::measure(disturbed(&times, &[10.0; 12], &by), &span);
    assert_eq!((figures.get("settling"), figures.get("recovery")), (Some(4.0), Some(3.0)));
    // A window that ends in the first call of a disturbance has no figures of it.
    let figures = Window::measure(disturbed(&times, &setpoint, &by), &Span { to: Some(6.0), ..Span::default() });
    assert_eq!(
        (figures.get("settling"), figures.get("recovery"), figures.get("disturbed_peak")),
        (Some(3.0), None, None)
    );
}

#[test]
fn the_next_step_and_the_change_of_the_mode_end_a_window_too() {
    let by = [set(6.0)];
    let times: Vec<f64> = (0..12).map(f64::from).collect();
    let mut setpoint: Vec<f64> = (0..12).map(|call| if call < 1 { 0.0 } else { 10.0 }).collect();
    let mut manual = [false; 12];
    manual[9] = true;
    let window = Window::measure(Signals { manual: &manual, ..disturbed(&times, &setpoint, &by) }, &Span::default());
    // When manual mode begins at 9 s, the loop has not recovered yet.
    assert_eq!(window.disturbance_happened().unwrap().duration, 2.0);
    let remarks = window.all_remarks();
    assert_eq!(remarks, ["no recovery time: the process value is 3 away from the setpoint at 8 s"]);
    setpoint[5..].fill(11.0);
    let windows = Window::of_events(disturbed(&times, &setpoint, &by));
    let times =
        |window: &Window| window.step_happened().or(window.disturbance_happened()).map(|of| (of.start, of.duration));
    assert_eq!(windows.iter().map(times).collect::<Vec<_>>(), [Some((1.0, 3.0)), Some((5.0, 0.0)), Some((6.0, 5.0))]);
}

#[test]
fn what_belongs_to_another_member_disturbs_and_what_gives_the_setpoint_does_not() {
    let roles = Roles { disturbances: vec!["DISV".into()], ..Roles::default() };
    let wiring = Wiring {
        setpoint: "C.SP".into(),
        members: vec!["C", "TANK", "RAMP"],
        roles: vec![Some(roles)],
        connections: vec![("C.LMN", "TANK.VALVE"), ("RAMP.OUT", "C.SP")],
    };
    let is = |variable: &str| wiring.is_disturbance(variable);
    assert_eq!(["TANK.DRAIN", "C.DISV", "C.GAIN", "C.SP", "RAMP.TARGET"].map(is), [true, true, false, false, false]);
    // Setting a value that is already present is not a disturbance.
    let set = |value: f64, before| Set { value: Some(value), before, ..set(5.0) };
    let found = wiring.disturbances([set(1.0, Some(1.0)), set(2.0, Some(1.0)), set(2.0, None)]);
    assert_eq!(found, [set(2.0, Some(1.0)), set(2.0, None)]);
}

#[test]
fn an_integral_has_the_unit_of_its_values_or_none() {
    let text = |unit: Unit, of: Option<&str>| unit.text(of, None);
    assert_eq!(text(Unit::ProcessValueSeconds, Some("degC")).as_deref(), Some("K s"));
    assert_eq!(text(Unit::SquareSeconds, Some("%")).as_deref(), Some("%^2 s"));
    assert_eq!([Unit::ProcessValueSeconds, Unit::SquareSeconds].map(|unit| text(unit, None)), [None, None]);
}

#[test]
fn a_setpoint_that_is_changed_in_manual_mode_is_a_step_when_automatic_mode_begins() {
    let times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let setpoint = [0.0, 10.0, 10.0, 10.0, 10.0, 10.0];
    // In manual mode it drifts from 0 to 2: the step is one of 8, with 2 beyond.
    let process_value = [0.0, 1.0, 2.0, 12.0, 10.0, 10.0];
    let manual = [true, true, false, false, false, false];
    let all = Signals { times: &times, setpoint: &setpoint, process_value: &process_value, ..Signals::default() };
    let figures = Window::measure(Signals { manual: &manual, ..all }, &Span::default());
    assert_eq!(
        (figures.times(), figures.get("overshoot"), figures.get("settling")),
        (Some((2.0, 5.0)), Some(25.0), Some(2.0))
    );
    let figures = Window::measure(Signals { manual: &[true; 6], ..all }, &Span::default());
    assert!(figures.all_remarks()[0].ends_with("the controller is in manual mode"), "{:?}", figures.all_remarks());
}

#[test]
fn a_process_value_that_is_still_on_its_way_has_neither_settled_nor_overshot() {
    let (times, setpoint, value) = second_order(200, 0.01, 100);
    let figures = all(&times, &setpoint, &value);
    assert_eq!((figures.get("rise"), figures.get("overshoot"), figures.get("settling")), (None, None, None));
    assert!(
        figures.all_remarks()[0].starts_with("no rise time: the process value has completed 3"),
        "{:?}",
        figures.all_remarks()
    );
    assert!(figures.all_remarks()[1].ends_with("has not reached the setpoint yet"));
    assert!(figures.all_remarks()[2].contains("% of the step away from the setpoint at the end"));
}

#[test]
fn a_process_value_that_crosses_the_setpoint_at_the_end_has_not_settled() {
    // The response crosses the setpoint at 2.418 s.
    let (times, setpoint, value) = second_order(343, 0.01, 100);
    let figures = all(&times, &setpoint, &value);
    assert_eq!(figures.get("settling"), None);
    assert!(figures.all_remarks().last().unwrap().ends_with("may leave it again"), "{:?}", figures.all_remarks());
}

#[test]
fn a_manipulated_value_at_its_limit_is_named_as_the_reason() {
    let count = 100;
    let times: Vec<f64> = (0..count).map(f64::from).collect();
    let setpoint: Vec<f64> = (0..count).map(|call| if call < 10 { 0.0 } else { 100.0 }).collect();
    let value: Vec<f64> = (0..count).map(|call| f64::from((call - 10).max(0)).min(50.0)).collect();
    let manipulated: Vec<f64> = (0..count).map(|call| f64::from((call - 10).clamp(0, 20)) * 5.0).collect();
    let signals = Signals {
        times: &times,
        setpoint: &setpoint,
        process_value: &value,
        manipulated_value: &manipulated,
        travel_unit: Some("%"),
        ..Signals::default()
    };
    let figures = Window::measure(signals, &Span::default());
    assert_eq!(figures.get("settling"), None);
    let remark = figures.all_remarks().pop().unwrap();
    assert!(
        remark.contains(
            "been 100 % since 30 s: it is at a limit, the controller is in manual \
                 mode, or the deviation is within the dead band"
        ),
        "{remark}"
    );
}

#[test]
fn a_ramp_begins_where_the_setpoint_begins_to_move() {
    let setpoint = [0.0, 0.0, 2.0, 4.0, 6.0, 6.0, 6.0];
    let times: Vec<f64> = (0..7).map(f64::from).collect();
    let figures = all(&times, &setpoint, &[0.0, 0.0, 0.0, 3.0, 6.0, 6.0, 6.0]);
    assert_eq!((figures.times(), figures.get("settling")), (Some((2.0, 6.0)), Some(2.0)));
    assert!(figures.all_remarks()[0].starts_with("the setpoint is a ramp"));
}

#[test]
fn values_that_are_no_numbers_leave_figures_out_with_a_reason() {
    let figures = all(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0], &[0.0, f64::NAN, 0.0]);
    assert_eq!((figures.get("iae"), figures.get("peak"), figures.get("rise")), (None, None, None));
    let all = "no rise time, overshoot, settling time, IAE, ISE or largest deviation";
    assert_eq!(figures.all_remarks(), [format!("{all}: {NO_DEVIATION}")]);
}

#[test]
fn the_guide_has_a_line_for_each_figure() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/studies.md")).unwrap();
    for Figure { key, meaning, .. } in FIGURES {
        let is_line_of =
            |line: &str| line.starts_with(&format!("| `{key}` | ")) && line.ends_with(&format!(" | {meaning} |"));
        assert!(guide.lines().any(is_line_of), "write in docs/studies.md: | `{key}` | unit | {meaning} |");
    }
}

#[test]
fn an_empty_run_has_no_figures() {
    let figures = all(&[], &[], &[]);
    assert_eq!(figures.all_remarks(), ["this part of the run contains no calls"]);
}
