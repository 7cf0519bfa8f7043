//! Figures of a loop: how fast, how far, how much. [`FIGURES`] defines each of them once, for the parameter tool, its report,
//! studies, the command and Python.
//!
//! All figures refer to a window of a run. By default it begins with the last change of the setpoint: the call in which the
//! setpoint has the new value for the first time. A setpoint that changes in several calls in a row, a ramp, changes in the
//! first of them.
//!
//! The *step* goes from the process value in that call, which the new setpoint has not moved yet, to the last setpoint of the
//! window. *Rise*, *overshoot* and *settling* refer to it; *rise* interpolates between two calls. The integrals are sums over
//! the calls, each with the time to the next call; the last call of a run takes as long as the one before it.

use modeldescription::digits::short;
use std::ops::Range;

/// Half of the band in which the process value counts as settled, as a part of the step.
const BAND: f64 = 0.02;
/// The process value has to stay in the band for at least this part of the time since the step: else it may only cross it.
const STAY: f64 = 0.1;
/// Ends the reason why a figure is absent.
const NOT_FINITE: &str = "is not a number in some calls";

/// Why there is no step.
const NO_CHANGE: &str = "the setpoint does not change in this part of the run";

/// A figure of a loop.
#[derive(Debug)]
pub struct Figure {
    /// Its name, everywhere: `settling`.
    pub key: &'static str,
    /// Its title, `Settling time`.
    pub title: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Whether the lowest value is the best.
    pub is_lower_better: bool,
    /// Why a run does not have it, usually.
    pub absent: &'static str,
    /// What it needs besides setpoint and process value.
    pub needs: Needs,
    of: fn(&Window) -> Result<f64, String>,
}

/// A figure's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// None: a number of events.
    One,
    /// Seconds.
    Seconds,
    /// Percent of the step.
    Percent,
    /// That of the process value.
    ProcessValue,
    /// That of the process value times seconds.
    ProcessValueSeconds,
    /// The square of the process value's times seconds.
    SquareSeconds,
    /// That of the manipulated value.
    ManipulatedValue,
}

/// What a figure needs besides setpoint and process value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// The manipulated value.
    ManipulatedValue,
    /// Pulse outputs.
    Pulses,
}

/// All figures, in the order in which they are shown.
pub static FIGURES: [&Figure; 8] = [
    &Figure {
        key: "rise",
        title: "Rise time",
        meaning: "From 10 % to 90 % of the step",
        unit: Unit::Seconds,
        is_lower_better: true,
        absent: "the process value does not reach 90 % of the step",
        needs: Needs::Nothing,
        of: |window| window.step()?.rise(),
    },
    &OVERSHOOT,
    &SETTLING,
    &Figure {
        key: "iae",
        title: "IAE",
        meaning: "Integral of the absolute deviation",
        unit: Unit::ProcessValueSeconds,
        is_lower_better: true,
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.iae),
    },
    &Figure {
        key: "ise",
        title: "ISE",
        meaning: "Integral of the squared deviation",
        unit: Unit::SquareSeconds,
        is_lower_better: true,
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.ise),
    },
    &Figure {
        key: "peak",
        title: "Largest deviation",
        meaning: "Largest absolute deviation",
        unit: Unit::ProcessValue,
        is_lower_better: true,
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.peak),
    },
    &Figure {
        key: "travel",
        title: "Travel",
        meaning: "How far the manipulated value moves in all",
        unit: Unit::ManipulatedValue,
        is_lower_better: true,
        absent: "the manipulated value is not a number in some calls",
        needs: Needs::ManipulatedValue,
        of: |window| window.travel(),
    },
    &Figure {
        key: "pulses",
        title: "Pulses",
        meaning: "How many pulses begin, on all pulse outputs",
        unit: Unit::One,
        is_lower_better: true,
        absent: "there are no pulses",
        needs: Needs::Pulses,
        of: |window| window.pulses(),
    },
];

/// Overshoot, which a prediction tells too.
pub static OVERSHOOT: Figure = Figure {
    key: "overshoot",
    title: "Overshoot",
    meaning: "Beyond the setpoint, in percent of the step",
    unit: Unit::Percent,
    is_lower_better: true,
    absent: "the process value does not reach the setpoint",
    needs: Needs::Nothing,
    of: |window| window.step()?.overshoot(),
};

/// Settling time, which a prediction tells too.
pub static SETTLING: Figure = Figure {
    key: "settling",
    title: "Settling time",
    meaning: "From the step until the process value stays within 2 % of the step around the setpoint",
    unit: Unit::Seconds,
    is_lower_better: true,
    absent: "the process value does not settle",
    needs: Needs::Nothing,
    of: |window| window.settling(),
};

const NO_CALL: &str = "there is no call in this part of the run";
const NO_DEVIATION: &str = "the setpoint or the process value is not a number in some calls";

/// The figure of this name.
pub fn find(key: &str) -> Option<&'static Figure> {
    FIGURES.into_iter().find(|figure| figure.key == key)
}

impl Figure {
    /// Its value, or why it has none.
    ///
    /// # Errors
    /// Why a run has no such figure, as the end of a sentence.
    pub fn value(&self, window: &Window) -> Result<f64, String> {
        if window.calls.is_empty() { Err(NO_CALL.into()) } else { (self.of)(window) }
    }
}

impl Unit {
    /// Its text, with the units of the process value and of the manipulated value. Differences of degC are in K.
    pub fn text(self, process_value: Option<&str>, manipulated_value: Option<&str>) -> Option<String> {
        let process_value = process_value.map(|unit| if unit == "degC" { "K" } else { unit });
        let seconds = |unit: Option<String>| unit.map_or_else(|| "s".into(), |unit| format!("{unit} s"));
        match self {
            Unit::One => None,
            Unit::Seconds => Some("s".into()),
            Unit::Percent => Some("%".into()),
            Unit::ProcessValue => process_value.map(str::to_string),
            Unit::ProcessValueSeconds => Some(seconds(process_value.map(str::to_string))),
            Unit::SquareSeconds => Some(seconds(process_value.map(squared))),
            Unit::ManipulatedValue => manipulated_value.map(str::to_string),
        }
    }
}

/// The square of a unit.
fn squared(unit: &str) -> String {
    let is_simple = unit.chars().all(|character| character.is_alphabetic() || character == '%');
    if is_simple { format!("{unit}^2") } else { format!("({unit})^2") }
}

/// Of which part of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// The beginning in seconds; the last change of the setpoint without it.
    pub from: Option<f64>,
    /// The end in seconds; the last call without it.
    pub to: Option<f64>,
    /// From which to which value the step goes, if it is known: then it begins with the first call.
    pub step: Option<(f64, f64)>,
    /// The first call with a process value, if a setpoint that never changes is a step from there. It counts if it is at least half of
    /// what the process value moves: else the loop was at rest.
    pub start: Option<usize>,
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
    /// Whether the controller is in manual mode; empty: never. A setpoint that is changed in manual mode is a step when automatic
    /// mode begins.
    pub manual: &'a [bool],
    /// The unit of the manipulated value, for a reason.
    pub travel_unit: Option<&'a str>,
}

/// A part of a run. Signals are compared up to the end of the shortest one.
#[derive(Debug)]
pub struct Window<'a> {
    signals: Signals<'a>,
    /// Which calls it has.
    calls: Range<usize>,
    step: Result<Step<'a>, String>,
    deviation: Result<Deviation, String>,
}

/// A range of values in a part of the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// From when to when, in seconds.
    pub times: (f64, f64),
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// Integrals and extremes of the deviation.
#[derive(Clone, Copy, Debug)]
struct Deviation {
    iae: f64,
    ise: f64,
    peak: f64,
}

/// A step of the setpoint with the answer of the process value.
#[derive(Debug)]
struct Step<'a> {
    times: &'a [f64],
    /// Where it goes.
    setpoint: f64,
    /// How far, with its sign.
    height: f64,
    /// How much of the step is done, from 0 to 1.
    done: Vec<f64>,
    /// How far the process value goes beyond the setpoint, as a part of the step.
    beyond: f64,
    is_ramp: bool,
}

impl<'a> Window<'a> {
    /// The part of a recorded loop.
    pub fn of(signals: Signals<'a>, span: &Span) -> Window<'a> {
        let count = signals.times.len().min(signals.setpoint.len()).min(signals.process_value.len());
        let times = &signals.times[..count];
        let end = span.to.map_or(count, |to| times.partition_point(|time| *time <= to));
        let (first, is_step) = match span.step {
            Some(_) => (0, Ok(())),
            None => signals.beginning(end, span.start),
        };
        let begin = span.from.map_or(first, |from| times.partition_point(|time| *time < from));
        let calls = begin..end.max(begin);
        let is_inside = first >= begin && !calls.is_empty();
        let step = is_step.and(if is_inside { Ok(()) } else { Err(NO_CHANGE.into()) });
        let step = step.and_then(|()| Step::of(&signals, first..end, span.step));
        let deviation = Deviation::of(&signals, calls.clone());
        Window { signals, calls, step, deviation }
    }

    /// The times of its first and its last call in seconds, unless it has none.
    pub fn times(&self) -> Option<(f64, f64)> {
        Some((self.signals.times[*self.calls.clone().next().as_ref()?], self.signals.times[self.calls.end - 1]))
    }

    /// The band in which the process value counts as settled; none without a step.
    pub fn band(&self) -> Option<Band> {
        let step = self.step.as_ref().ok()?;
        let half = BAND * step.height.abs();
        let times = (*step.times.first()?, *step.times.last()?);
        Some(Band { times, low: step.setpoint - half, high: step.setpoint + half })
    }

    /// The figures that its signals allow.
    pub fn figures(&self) -> impl Iterator<Item = &'static Figure> {
        let (has_travel, has_pulses) = (!self.signals.manipulated_value.is_empty(), !self.signals.pulses.is_empty());
        applicable(has_travel, has_pulses)
    }

    /// What is to be said of figures, a sentence each: which of them are absent and why.
    pub fn remarks(&self, figures: &[&Figure]) -> Vec<String> {
        if self.calls.is_empty() {
            return vec![NO_CALL.into()];
        }
        let mut reasons: Vec<(String, Vec<String>)> = Vec::new();
        for figure in figures {
            let Err(reason) = figure.value(self) else { continue };
            match reasons.iter_mut().find(|(other, _)| *other == reason) {
                Some((_, names)) => names.push(in_sentence(figure.title)),
                None => reasons.push((reason, vec![in_sentence(figure.title)])),
            }
        }
        let ramp = self.step.as_ref().is_ok_and(|step| step.is_ramp);
        let ramp =
            ramp.then(|| "the setpoint is a ramp: its duration is part of the rise and settling time".to_string());
        let absent = reasons.into_iter().map(|(reason, names)| match names.split_last() {
            Some((last, rest)) if !rest.is_empty() => format!("no {} or {last}: {reason}", rest.join(", ")),
            _ => format!("no {}: {reason}", names.concat()),
        });
        ramp.into_iter().chain(absent).collect()
    }

    fn step(&self) -> Result<&Step<'a>, String> {
        self.step.as_ref().map_err(Clone::clone)
    }

    fn deviation(&self) -> Result<Deviation, String> {
        self.deviation.clone()
    }

    fn settling(&self) -> Result<f64, String> {
        let step = self.step()?;
        step.settling().map_err(|why| match self.standstill(step.times[0]) {
            None => why,
            Some((value, since)) => {
                let unit = self.signals.travel_unit.map_or_else(String::new, |unit| format!(" {unit}"));
                let (value, since) = (short(value), short(since));
                format!(
                    "{why}; the manipulated value has been {value}{unit} since {since} s: it is at a limit, in manual mode, \
                     or the deviation is within the dead band"
                )
            }
        })
    }

    fn travel(&self) -> Result<f64, String> {
        let values = self.signals.manipulated_value.get(self.calls.start.saturating_sub(1)..self.calls.end);
        let values = values.ok_or("the manipulated value is not recorded in all calls")?;
        let travel: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        if travel.is_finite() { Ok(travel) } else { Err(format!("the manipulated value {NOT_FINITE}")) }
    }

    fn pulses(&self) -> Result<f64, String> {
        // Before the first call of a run the outputs are FALSE.
        let begins = |pulse: &Vec<bool>| {
            let calls = self.calls.start..self.calls.end.min(pulse.len());
            calls.filter(|call| pulse[*call] && !(*call > 0 && pulse[call - 1])).count() as f64
        };
        Ok(self.signals.pulses.iter().map(begins).sum())
    }

    /// The manipulated value and since when, if it has not moved in the last tenth of the time since the step.
    fn standstill(&self, step: f64) -> Option<(f64, f64)> {
        let first = self.signals.times.partition_point(|time| *time < step);
        let values = self.signals.manipulated_value.get(first..self.calls.end)?;
        let last = *values.last()?;
        let first_of_last = values.iter().rposition(|value| *value != last).map_or(0, |other| other + 1);
        let times = &self.signals.times[first..self.calls.end];
        let (begin, stop) = (times[0], times[times.len() - 1]);
        let since = times[first_of_last];
        (values.len() > 1 && stop - since >= STAY * (stop - begin)).then_some((last, since))
    }
}

/// The figures of a loop with or without a manipulated value and pulses.
pub fn applicable(has_manipulated_value: bool, has_pulses: bool) -> impl Iterator<Item = &'static Figure> {
    FIGURES.into_iter().filter(move |figure| match figure.needs {
        Needs::Nothing => true,
        Needs::ManipulatedValue => has_manipulated_value,
        Needs::Pulses => has_pulses,
    })
}

/// A title inside a sentence; an abbreviation stays as it is.
fn in_sentence(title: &str) -> String {
    let is_abbreviation = title.chars().all(|letter| letter.is_ascii_uppercase());
    if is_abbreviation { title.into() } else { title.to_lowercase() }
}

/// The call in which the last change of the setpoint, or the last ramp, begins.
fn last_change(setpoint: &[f64]) -> Option<usize> {
    let changes = |call: &usize| setpoint[*call] != setpoint[call - 1];
    let last = (1..setpoint.len()).rev().find(changes)?;
    let before = (1..last).rev().find(|call| !changes(call));
    Some(before.map_or(1, |call| call + 1))
}

impl Signals<'_> {
    /// The call before `end` in which the last step begins, or the last change of the setpoint and why that is no step.
    fn beginning(&self, end: usize, start: Option<usize>) -> (usize, Result<(), String>) {
        let changed = last_change(&self.setpoint[..end]);
        let Some(first) = changed.or(start.filter(|start| *start < end)) else { return (0, Err(NO_CHANGE.into())) };
        let is_manual = |call: usize| self.manual.get(call).copied().unwrap_or(false);
        let Some(call) = (first..end).find(|call| !is_manual(*call)) else {
            return (first, Err("the controller is in manual mode".into()));
        };
        let values = &self.process_value[call..end];
        let is_far = || {
            let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), of| (low.min(*of), high.max(*of)));
            (self.setpoint[call] - values[0]).abs() >= (high - low) / 2.0
        };
        if changed.is_some() || is_far() { (call, Ok(())) } else { (0, Err(NO_CHANGE.into())) }
    }
}

impl Deviation {
    fn of(signals: &Signals, calls: Range<usize>) -> Result<Deviation, String> {
        let (mut iae, mut ise, mut peak) = (0.0, 0.0, 0.0_f64);
        for call in calls {
            let deviation = (signals.setpoint[call] - signals.process_value[call]).abs();
            let step = duration(signals.times, call);
            iae += deviation * step;
            ise += deviation * deviation * step;
            peak = if deviation.is_nan() { deviation } else { peak.max(deviation) };
        }
        let is_finite = iae.is_finite() && ise.is_finite() && peak.is_finite();
        if is_finite { Ok(Deviation { iae, ise, peak }) } else { Err(NO_DEVIATION.into()) }
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

impl<'a> Step<'a> {
    /// The step that begins in the first of these calls, from and to the values that are given.
    fn of(signals: &Signals<'a>, calls: Range<usize>, given: Option<(f64, f64)>) -> Result<Step<'a>, String> {
        let (times, setpoints) = (&signals.times[calls.clone()], &signals.setpoint[calls.clone()]);
        let values = &signals.process_value[calls];
        let (start, setpoint) = given.unwrap_or((values[0], setpoints[setpoints.len() - 1]));
        let height = setpoint - start;
        if values.iter().chain(setpoints).chain([&height]).any(|value| !value.is_finite()) {
            return Err(NO_DEVIATION.into());
        }
        if height.abs() <= 1e-9 * setpoint.abs().max(start.abs()) {
            return Err("the process value is at the new setpoint already".into());
        }
        Ok(Step {
            times,
            setpoint,
            height,
            done: values.iter().map(|value| (value - start) / height).collect(),
            beyond: values.iter().map(|value| (value - setpoint) / height).fold(0.0, f64::max),
            is_ramp: setpoints.windows(2).any(|pair| pair[0] != pair[1]),
        })
    }

    fn rise(&self) -> Result<f64, String> {
        let crossing = |level: f64| {
            let call = self.done.iter().position(|done| *done >= level)?;
            let (before, after) = (self.done[call.checked_sub(1)?], self.done[call]);
            let (first, second) = (self.times[call - 1], self.times[call]);
            Some(first + (second - first) * (level - before) / (after - before))
        };
        match (crossing(0.1), crossing(0.9)) {
            (Some(low), Some(high)) => Ok(high - low),
            _ => {
                let highest = self.done.iter().copied().fold(f64::MIN, f64::max);
                let so_far = (highest * 100.0).max(0.0);
                Err(format!("the process value has done {so_far:.0} % of the step so far"))
            }
        }
    }

    fn overshoot(&self) -> Result<f64, String> {
        if self.beyond > 0.0 || self.settling().is_ok() {
            Ok(self.beyond * 100.0)
        } else {
            Err("the process value has not reached the setpoint yet".into())
        }
    }

    /// When the step is done to within the band for good, in seconds after the step, or why it is not.
    fn settling(&self) -> Result<f64, String> {
        let (times, done) = (self.times, &self.done);
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

    fn all<'a>(times: &'a [f64], setpoint: &'a [f64], process_value: &'a [f64]) -> Window<'a> {
        Window::of(Signals { times, setpoint, process_value, ..Signals::default() }, &Span::default())
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
        // 1 is reached at 1.5 s, 9 at 5 1/3 s; 11 at 6 s is outside of 9.8 to 10.2; the step is at 1 s.
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
        assert_eq!(Window::of(signals, &Span::default()).get("rise"), None);
        let figures = Window::of(signals, &Span { step: Some((20.0, 60.0)), ..Span::default() });
        // From 24 at 0.2 s to 56 at 1.8 s.
        assert!((figures.get("rise").unwrap() - 1.6).abs() < 1e-12);
        assert_eq!((figures.get("settling"), figures.get("iae")), (Some(2.0), Some(60.0)));
    }

    #[test]
    fn a_second_order_answer_has_the_figures_of_the_textbook() {
        let (times, setpoint, value) = second_order(30_000, 0.001, 1000);
        let figures = all(&times, &setpoint, &value);
        assert_eq!(figures.times().unwrap(), (1.0, times[29_999]));
        // exp(-pi zeta / sqrt(1 - zeta^2)), and roots of the answer, computed independently.
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
        let figures = Window::of(signals, &Span::default());
        assert_eq!((figures.get("travel"), figures.get("pulses")), (Some(25.0), Some(2.0)));
        let figures = Window::of(signals, &Span { from: Some(0.0), ..Span::default() });
        assert_eq!((figures.get("travel"), figures.get("pulses")), (Some(28.0), Some(4.0)));
        let window = Span { from: Some(0.5), to: Some(1.5), ..Span::default() };
        let figures = Window::of(signals, &window);
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
        let figures = all(&[0.0, 1.0], &[5.0, 5.0], &[4.0, 4.0]);
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
        let signals =
            |process_value| Signals { times: &times, setpoint: &setpoint, process_value, ..Signals::default() };
        let span = Span { start: Some(0), ..Span::default() };
        let rising = [20.0, 40.0, 64.0, 60.0, 60.0];
        let figures = Window::of(signals(&rising), &span);
        // 24 at 0.2 s and 56 at 1.667 s; within 0.8 of 60 from 3 s on.
        assert_eq!((figures.get("overshoot"), figures.get("settling")), (Some(10.0), Some(3.0)));
        assert!((figures.get("rise").unwrap() - (1.0 + 16.0 / 24.0 - 0.2)).abs() < 1e-12);
        // The same where the first row has the outputs before the first call.
        let late = [0.0, 20.0, 40.0, 64.0, 60.0];
        let figures = Window::of(signals(&late), &Span { start: Some(1), ..Span::default() });
        assert_eq!((figures.get("overshoot"), figures.get("peak")), (Some(10.0), Some(40.0)));
        // At rest, 1 below, and disturbed by 10.
        assert_eq!(Window::of(signals(&[59.0, 59.0, 49.0, 55.0, 60.0]), &span).get("rise"), None);
    }

    #[test]
    fn a_setpoint_that_is_changed_in_manual_mode_is_a_step_when_automatic_mode_begins() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let setpoint = [0.0, 10.0, 10.0, 10.0, 10.0, 10.0];
        // In manual mode it drifts from 0 to 2: the step is one of 8, with 2 beyond.
        let process_value = [0.0, 1.0, 2.0, 12.0, 10.0, 10.0];
        let manual = [true, true, false, false, false, false];
        let all = Signals { times: &times, setpoint: &setpoint, process_value: &process_value, ..Signals::default() };
        let figures = Window::of(Signals { manual: &manual, ..all }, &Span::default());
        assert_eq!(
            (figures.times(), figures.get("overshoot"), figures.get("settling")),
            (Some((2.0, 5.0)), Some(25.0), Some(2.0))
        );
        let figures = Window::of(Signals { manual: &[true; 6], ..all }, &Span::default());
        assert!(figures.all_remarks()[0].ends_with("the controller is in manual mode"), "{:?}", figures.all_remarks());
    }

    #[test]
    fn a_process_value_that_is_still_on_its_way_has_neither_settled_nor_overshot() {
        let (times, setpoint, value) = second_order(200, 0.01, 100);
        let figures = all(&times, &setpoint, &value);
        assert_eq!((figures.get("rise"), figures.get("overshoot"), figures.get("settling")), (None, None, None));
        assert!(
            figures.all_remarks()[0].starts_with("no rise time: the process value has done 3"),
            "{:?}",
            figures.all_remarks()
        );
        assert!(figures.all_remarks()[1].ends_with("has not reached the setpoint yet"));
        assert!(figures.all_remarks()[2].contains("% of the step away from the setpoint at the end"));
    }

    #[test]
    fn a_process_value_that_crosses_the_setpoint_at_the_end_has_not_settled() {
        // The answer passes the setpoint at 2.418 s.
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
        let figures = Window::of(signals, &Span::default());
        assert_eq!(figures.get("settling"), None);
        let remark = figures.all_remarks().pop().unwrap();
        assert!(
            remark.contains(
                "been 100 % since 30 s: it is at a limit, in manual mode, or the \
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
        assert_eq!(figures.all_remarks(), ["there is no call in this part of the run"]);
    }
}
