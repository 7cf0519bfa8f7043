//! What a run comes to: rise time, overshoot, settling, integrals of the control deviation, travel, pulses.
//!
//! All figures refer to a window of the run, [`Figures::from`] to [`Figures::to`]. By default it begins with the last change of
//! the setpoint: the call in which the setpoint has the new value for the first time. A setpoint that changes in several calls
//! in a row, a ramp, changes in the first of them.
//!
//! The *step* goes from the process value in that call, which the new setpoint has not moved yet, to the last setpoint of the
//! window. *Rise*, *overshoot* and *settling* are told of it; *rise* interpolates between two calls. The integrals are sums over
//! the calls, each with the time to the next call.

use modeldescription::digits::short;
use serde::{Deserialize, Serialize};

/// Half of the band in which the process value counts as settled, as a part of the step.
const BAND: f64 = 0.02;
/// The process value has to stay in the band for at least this part of the time since the step: else it may only cross it.
const STAY: f64 = 0.1;
/// How many remarks name a quantity with a value that is not a number.
const NOT_FINITE: &str = "is not a number in some calls";

/// Of which part of which run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "FiguresRequest", optional_fields = nullable))]
pub struct Request {
    /// The run; the present one without it.
    pub run: Option<usize>,
    /// The beginning in seconds; the last change of the setpoint without it.
    pub from: Option<f64>,
    /// The end in seconds; the last call without it.
    pub to: Option<f64>,
}

/// What a run has recorded of a loop: a value of each signal for every call.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals<'a> {
    /// When the calls are, in seconds.
    pub times: &'a [f64],
    /// The setpoint.
    pub setpoint: &'a [f64],
    /// The process value in the setpoint's unit.
    pub process_value: &'a [f64],
    /// The manipulated value; empty if the controller has pulses only.
    pub manipulated_value: &'a [f64],
    /// The pulse outputs; may be empty.
    pub pulses: &'a [Vec<bool>],
    /// The unit of the process value.
    pub unit: Option<&'a str>,
    /// The unit of the manipulated value.
    pub travel_unit: Option<&'a str>,
}

/// The figures of a run. What cannot be said is absent, and `remarks` say why.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Figures {
    /// From where on, in seconds.
    pub from: f64,
    /// Up to where, in seconds.
    pub to: f64,
    /// From 10 % to 90 % of the step, in seconds.
    pub rise: Option<f64>,
    /// Beyond the setpoint, in percent of the step; 0 if the process value does not pass the setpoint.
    pub overshoot: Option<f64>,
    /// From which time on the process value stays within 2 % of the step around the setpoint, in seconds after the step.
    pub settled: Option<f64>,
    /// The integral of the deviation's amount, in the unit of the process value times seconds.
    pub iae: Option<f64>,
    /// The integral of the deviation's square.
    pub ise: Option<f64>,
    /// The largest amount of the deviation.
    pub peak: Option<f64>,
    /// How far the manipulated value moves, in its unit: the sum of the amounts of its changes.
    pub travel: Option<f64>,
    /// How many pulses begin, on all pulse outputs.
    pub pulses: Option<u64>,
    /// The unit of the process value.
    pub unit: Option<String>,
    /// The unit of the manipulated value.
    pub travel_unit: Option<String>,
    /// What could not be said, and why.
    pub remarks: Vec<String>,
}

/// The figures of a recorded loop; `request.run` has no effect here. Signals are compared up to the end of the shortest one.
pub fn of(signals: &Signals, request: &Request) -> Figures {
    let count = signals.times.len().min(signals.setpoint.len()).min(signals.process_value.len());
    let times = &signals.times[..count];
    let mut figures = Figures {
        unit: signals.unit.map(str::to_string),
        travel_unit: signals.travel_unit.map(str::to_string),
        ..Figures::default()
    };
    let end = request.to.map_or(count, |to| times.partition_point(|time| *time <= to));
    let changed = last_change(&signals.setpoint[..end]);
    let begin = request.from.map_or(changed.unwrap_or(0), |from| times.partition_point(|time| *time < from));
    if begin >= end {
        figures.from = request.from.unwrap_or_default();
        figures.to = request.to.unwrap_or(figures.from);
        figures.remarks.push("there is no call in this part of the run".into());
        return figures;
    }
    (figures.from, figures.to) = (times[begin], times[end - 1]);
    integrals(&mut figures, signals, begin, end);
    travel(&mut figures, signals, begin, end);
    match changed.filter(|changed| *changed >= begin) {
        Some(step) => step_figures(&mut figures, signals, step, end),
        None => figures.remarks.push(
            "no rise time, overshoot or settling time: the setpoint does not change in this part of the run".into(),
        ),
    }
    figures
}

/// The call in which the last change of the setpoint, or the last ramp, begins.
fn last_change(setpoint: &[f64]) -> Option<usize> {
    let changes = |call: &usize| setpoint[*call] != setpoint[call - 1];
    let last = (1..setpoint.len()).rev().find(changes)?;
    let before = (1..last).rev().find(|call| !changes(call));
    Some(before.map_or(1, |call| call + 1))
}

fn integrals(figures: &mut Figures, signals: &Signals, begin: usize, end: usize) {
    let (mut iae, mut ise, mut peak) = (0.0, 0.0, 0.0_f64);
    for call in begin..end {
        let deviation = (signals.setpoint[call] - signals.process_value[call]).abs();
        let step = duration(signals.times, call);
        iae += deviation * step;
        ise += deviation * deviation * step;
        peak = if deviation.is_nan() { deviation } else { peak.max(deviation) };
    }
    if iae.is_finite() && ise.is_finite() && peak.is_finite() {
        (figures.iae, figures.ise, figures.peak) = (Some(iae), Some(ise), Some(peak));
    } else {
        figures
            .remarks
            .push(format!("no IAE, ISE or largest deviation: the setpoint or the process value {NOT_FINITE}"));
    }
}

/// The time from a call to the next one; the last call takes as long as the one before it.
fn duration(times: &[f64], call: usize) -> f64 {
    match (times.get(call + 1), call.checked_sub(1)) {
        (Some(next), _) => next - times[call],
        (None, Some(previous)) => times[call] - times[previous],
        (None, None) => 0.0,
    }
}

fn travel(figures: &mut Figures, signals: &Signals, begin: usize, end: usize) {
    if signals.manipulated_value.len() >= end {
        let values = &signals.manipulated_value[begin.saturating_sub(1)..end];
        let travel: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        if travel.is_finite() {
            figures.travel = Some(travel);
        } else {
            figures.remarks.push(format!("no travel: the manipulated value {NOT_FINITE}"));
        }
    }
    if !signals.pulses.is_empty() {
        // Before the first call of a run the outputs are FALSE.
        let begins = |pulse: &Vec<bool>| {
            let end = end.min(pulse.len());
            (begin..end).filter(|call| pulse[*call] && !(*call > 0 && pulse[call - 1])).count() as u64
        };
        figures.pulses = Some(signals.pulses.iter().map(begins).sum());
    }
}

/// Rise, overshoot and settling after the setpoint's change in the call `step`.
fn step_figures(figures: &mut Figures, signals: &Signals, step: usize, end: usize) {
    let (times, setpoints) = (&signals.times[step..end], &signals.setpoint[step..end]);
    let values = &signals.process_value[step..end];
    let (start, setpoint) = (values[0], setpoints[setpoints.len() - 1]);
    let height = setpoint - start;
    if values.iter().chain(setpoints).any(|value| !value.is_finite()) {
        let remark = format!("no rise time, overshoot or settling time: setpoint or process value {NOT_FINITE}");
        return figures.remarks.push(remark);
    }
    if height.abs() <= 1e-9 * setpoint.abs().max(start.abs()) {
        let remark = "no rise time, overshoot or settling time: the process value is at the new setpoint already";
        return figures.remarks.push(remark.into());
    }
    if setpoints.windows(2).any(|pair| pair[0] != pair[1]) {
        figures.remarks.push("the setpoint is a ramp: its duration is part of the rise and settling time".into());
    }
    // How much of the step is done: from 0 to 1.
    let done: Vec<f64> = values.iter().map(|value| (value - start) / height).collect();
    let crossing = |level: f64| {
        let call = done.iter().position(|done| *done >= level)?;
        let (before, after) = (done[call.checked_sub(1)?], done[call]);
        Some(times[call - 1] + (times[call] - times[call - 1]) * (level - before) / (after - before))
    };
    let beyond = values.iter().map(|value| (value - setpoint) / height).fold(0.0, f64::max);
    match (crossing(0.1), crossing(0.9)) {
        (Some(low), Some(high)) => figures.rise = Some(high - low),
        _ => {
            let highest = done.iter().copied().fold(f64::MIN, f64::max);
            let so_far = (highest * 100.0).max(0.0);
            figures.remarks.push(format!("no rise time: the process value has done {so_far:.0} % of the step so far"));
        }
    }
    let settled = settled(times, &done);
    if beyond > 0.0 || settled.is_ok() {
        figures.overshoot = Some(beyond * 100.0);
    } else {
        figures.remarks.push("no overshoot: the process value has not reached the setpoint yet".into());
    }
    match settled {
        Ok(time) => figures.settled = Some(time),
        Err(why) => {
            let stuck = standstill(signals, step, end).map_or_else(String::new, |(value, since)| {
                let unit = signals.travel_unit.map_or_else(String::new, |unit| format!(" {unit}"));
                format!(
                    "; the manipulated value has stood at {}{unit} since {} s: it is at a limit, in manual mode, or the \
                     deviation is within the dead band",
                    short(value),
                    short(since)
                )
            });
            figures.remarks.push(format!("no settling time: {why}{stuck}"));
        }
    }
}

/// When the step is done to within the band for good, in seconds after the step, or why that cannot be said.
fn settled(times: &[f64], done: &[f64]) -> Result<f64, String> {
    let percent = BAND * 100.0;
    let is_outside = |done: &f64| (done - 1.0).abs() > BAND;
    let first = done.iter().rposition(is_outside).map_or(0, |last| last + 1);
    let (begin, end) = (times[0], times[times.len() - 1]);
    let Some(since) = times.get(first) else {
        let off = (done[done.len() - 1] - 1.0).abs() * 100.0;
        return Err(format!("the process value is {off:.1} % of the step away from the setpoint at the end"));
    };
    if end - since < STAY * (end - begin) {
        let stayed = end - since;
        return Err(format!(
            "the process value has been within {percent:.0} % of the step for {} s only and may leave it again",
            short(stayed)
        ));
    }
    Ok(since - begin)
}

/// The manipulated value and since when, if it has not moved in the last tenth of the time since the step.
fn standstill(signals: &Signals, step: usize, end: usize) -> Option<(f64, f64)> {
    let values = signals.manipulated_value.get(step..end)?;
    let last = *values.last()?;
    let first = values.iter().rposition(|value| *value != last).map_or(0, |other| other + 1);
    let times = &signals.times[step..end];
    let (begin, stop) = (times[0], times[times.len() - 1]);
    (values.len() > 1 && stop - times[first] >= STAY * (stop - begin)).then(|| (last, times[first]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The answer of a second-order system with damping 0.5 and natural frequency 1 rad/s to a setpoint step at `at`.
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

    fn all(times: &[f64], setpoint: &[f64], process_value: &[f64]) -> Figures {
        of(&Signals { times, setpoint, process_value, ..Signals::default() }, &Request::default())
    }

    #[test]
    fn a_second_order_answer_has_the_figures_of_the_textbook() {
        let (times, setpoint, value) = second_order(30_000, 0.001, 1000);
        let figures = all(&times, &setpoint, &value);
        assert_eq!((figures.from, figures.to), (1.0, times[29_999]));
        // exp(-pi zeta / sqrt(1 - zeta^2)), and roots of the answer, computed independently.
        assert!((figures.overshoot.unwrap() - 16.30335).abs() < 1e-4, "{figures:?}");
        assert!((figures.rise.unwrap() - 1.6376).abs() < 2e-4, "{figures:?}");
        assert!((figures.settled.unwrap() - 8.0764).abs() < 1.1e-3, "{figures:?}");
        assert_eq!(figures.remarks, [""; 0]);
    }

    #[test]
    fn the_integrals_are_sums_over_the_calls() {
        let times = [0.0, 0.5, 1.0, 1.5];
        let figures = all(&times, &[0.0, 10.0, 10.0, 10.0], &[0.0, 0.0, 4.0, 12.0]);
        // 10, 6 and 2 for half a second each.
        assert_eq!((figures.iae, figures.ise, figures.peak), (Some(9.0), Some(70.0), Some(10.0)));
        assert_eq!(figures.overshoot, Some(20.0));
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
            unit: Some("degC"),
            travel_unit: Some("%"),
        };
        let figures = of(&signals, &Request::default());
        assert_eq!((figures.travel, figures.pulses), (Some(25.0), Some(2)));
        assert_eq!((figures.unit.as_deref(), figures.travel_unit.as_deref()), (Some("degC"), Some("%")));
        let figures = of(&signals, &Request { from: Some(0.0), ..Request::default() });
        assert_eq!((figures.travel, figures.pulses), (Some(28.0), Some(4)));
        let window = Request { from: Some(0.5), to: Some(1.5), ..Request::default() };
        let figures = of(&signals, &window);
        assert_eq!((figures.from, figures.to, figures.travel, figures.pulses), (1.0, 1.0, Some(3.0), Some(1)));
    }

    #[test]
    fn a_step_down_has_the_same_figures_as_a_step_up() {
        let (times, setpoint, value) = second_order(3000, 0.01, 100);
        let up = all(&times, &setpoint, &value);
        let mirrored = |values: &[f64]| values.iter().map(|value| -value).collect::<Vec<_>>();
        let down = all(&times, &mirrored(&setpoint), &mirrored(&value));
        assert_eq!(up, down);
    }

    #[test]
    fn without_a_change_of_the_setpoint_there_are_integrals_only() {
        let figures = all(&[0.0, 1.0], &[5.0, 5.0], &[4.0, 4.0]);
        assert_eq!((figures.iae, figures.rise, figures.overshoot, figures.settled), (Some(2.0), None, None, None));
        assert!(figures.remarks[0].ends_with("the setpoint does not change in this part of the run"));
    }

    #[test]
    fn a_process_value_that_is_still_on_its_way_has_neither_settled_nor_overshot() {
        let (times, setpoint, value) = second_order(200, 0.01, 100);
        let figures = all(&times, &setpoint, &value);
        assert_eq!((figures.rise, figures.overshoot, figures.settled), (None, None, None));
        assert!(figures.remarks[0].starts_with("no rise time: the process value has done 3"), "{:?}", figures.remarks);
        assert!(figures.remarks[1].ends_with("has not reached the setpoint yet"));
        assert!(figures.remarks[2].contains("% of the step away from the setpoint at the end"));
    }

    #[test]
    fn a_process_value_that_crosses_the_setpoint_at_the_end_has_not_settled() {
        // The answer passes the setpoint at 2.418 s.
        let (times, setpoint, value) = second_order(343, 0.01, 100);
        let figures = all(&times, &setpoint, &value);
        assert_eq!(figures.settled, None);
        assert!(figures.remarks.last().unwrap().ends_with("may leave it again"), "{:?}", figures.remarks);
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
        let figures = of(&signals, &Request::default());
        assert_eq!(figures.settled, None);
        let remark = figures.remarks.last().unwrap();
        assert!(
            remark.contains(
                "stood at 100 % since 30 s: it is at a limit, in manual mode, or the \
                     deviation is within the dead band"
            ),
            "{remark}"
        );
    }

    #[test]
    fn a_ramp_begins_where_the_setpoint_begins_to_move() {
        let setpoint = [0.0, 0.0, 2.0, 4.0, 6.0, 6.0, 6.0];
        let times: Vec<f64> = (0..7).map(f64::from).collect();
        let figures = all(&times, &setpoint, &[0.0, 0.0, 0.0, 3.0, 6.0, 6.0, 6.0]);
        assert_eq!((figures.from, figures.settled), (2.0, Some(2.0)));
        assert!(figures.remarks[0].starts_with("the setpoint is a ramp"));
    }

    #[test]
    fn values_that_are_no_numbers_leave_figures_out_with_a_reason() {
        let figures = all(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0], &[0.0, f64::NAN, 0.0]);
        assert_eq!((figures.iae, figures.peak, figures.rise), (None, None, None));
        assert_eq!(figures.remarks.len(), 2);
        assert!(figures.remarks.iter().all(|remark| remark.ends_with(NOT_FINITE)), "{:?}", figures.remarks);
    }

    #[test]
    fn an_empty_run_has_no_figures() {
        let figures = all(&[], &[], &[]);
        assert_eq!(figures.remarks, ["there is no call in this part of the run"]);
    }
}
