//! Figures of a loop, such as settling time, overshoot and travel. [`FIGURES`] defines each of them once, for the
//! parameter tool, its report, studies, the command and Python.
//!
//! A figure describes one event of a run: a setpoint step or a disturbance. The *window* of an event ends at the next
//! setpoint change, disturbance, or change between manual and automatic mode. A step begins in the
//! first call with the new setpoint; a ramp, in which the setpoint changes in several consecutive calls, counts from
//! the first of them. A run that begins far from its setpoint begins with a step, in the first call with a process
//! value computed by the plant.
//!
//! The *step* goes from the process value in the first call of the window, which the new setpoint has not affected yet,
//! to the last setpoint of the window. *Rise*, *overshoot* and *settling* refer to it; *rise* interpolates between two
//! calls. The integrals are sums over the calls, each weighted with the time to the next call; for the last call of a
//! run, the time since the previous one is used.

mod events;

pub use events::{Cause, Set, Wiring};

use events::Event;
use modeldescription::digits::short;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Half the width of the band in which the process value counts as settled, relative to the step; after a disturbance,
/// relative to the last step before the disturbance.
pub const BAND: f64 = 0.02;
/// The minimum time that the process value must stay in the band, relative to the time since the step; otherwise, it
/// may just be crossing the band.
const STAY: f64 = 0.1;
/// The end of a reason for a missing figure, after the name of the signal.
const NOT_FINITE: &str = "is NaN in some calls";

/// The reason given if the setpoint does not change.
const NO_CHANGE: &str = "the setpoint does not change in this part of the run";

/// A figure of a loop. A lower value is better.
#[derive(Debug)]
pub struct Figure {
    /// The identifier in files and commands, such as `settling`.
    pub key: &'static str,
    /// The title, such as `Settling time`.
    pub title: &'static str,
    /// A short definition.
    pub meaning: &'static str,
    /// The unit of the value.
    pub unit: Unit,
    /// The usual reason why a run lacks the figure.
    pub absent: &'static str,
    /// The signals required in addition to setpoint and process value.
    pub needs: Needs,
    of: fn(&Window) -> Result<f64, String>,
}

/// A figure's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// No unit: a count.
    One,
    /// Seconds.
    Seconds,
    /// Percent of the step.
    Percent,
    /// The unit of the process value.
    ProcessValue,
    /// The unit of the process value times seconds.
    ProcessValueSeconds,
    /// The squared unit of the process value times seconds.
    SquareSeconds,
    /// The unit of the manipulated value.
    ManipulatedValue,
}

/// The signals that a figure requires in addition to setpoint and process value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No other signal.
    Nothing,
    /// The manipulated value.
    ManipulatedValue,
    /// Pulse outputs.
    Pulses,
    /// A disturbance.
    Disturbance,
}

/// All figures, in display order.
pub static FIGURES: [&Figure; 11] = [
    &Figure {
        key: "rise",
        title: "Rise time",
        meaning: "From 10 % to 90 % of the step",
        unit: Unit::Seconds,
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
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.iae),
    },
    &Figure {
        key: "ise",
        title: "ISE",
        meaning: "Integral of the squared deviation",
        unit: Unit::SquareSeconds,
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.ise),
    },
    &Figure {
        key: "peak",
        title: "Largest deviation",
        meaning: "Largest absolute deviation",
        unit: Unit::ProcessValue,
        absent: NO_DEVIATION,
        needs: Needs::Nothing,
        of: |window| Ok(window.deviation()?.peak),
    },
    &Figure {
        key: "travel",
        title: "Travel",
        meaning: "Total movement of the manipulated value",
        unit: Unit::ManipulatedValue,
        absent: "the manipulated value is NaN in some calls",
        needs: Needs::ManipulatedValue,
        of: |window| window.travel(),
    },
    &Figure {
        key: "pulses",
        title: "Pulses",
        meaning: "Number of pulses started, on all pulse outputs",
        unit: Unit::One,
        absent: "there are no pulses",
        needs: Needs::Pulses,
        of: |window| window.pulses(),
    },
    &Figure {
        key: "recovery",
        title: "Recovery time",
        meaning: "From a disturbance until the process value stays in a band of ±2 % of the last step around the setpoint",
        unit: Unit::Seconds,
        absent: "the process value does not return to the setpoint",
        needs: Needs::Disturbance,
        of: |window| window.disturbed()?.recovery.clone(),
    },
    &Figure {
        key: "disturbed_peak",
        title: "Deviation after disturbance",
        meaning: "Largest absolute deviation after a disturbance",
        unit: Unit::ProcessValue,
        absent: NO_DISTURBANCE,
        needs: Needs::Disturbance,
        of: |window| Ok(window.disturbed()?.deviation.clone()?.peak),
    },
    &Figure {
        key: "disturbed_iae",
        title: "IAE after disturbance",
        meaning: "Integral of the absolute deviation after a disturbance",
        unit: Unit::ProcessValueSeconds,
        absent: NO_DISTURBANCE,
        needs: Needs::Disturbance,
        of: |window| Ok(window.disturbed()?.deviation.clone()?.iae),
    },
];

/// The overshoot, also reported by predictions.
pub static OVERSHOOT: Figure = Figure {
    key: "overshoot",
    title: "Overshoot",
    meaning: "Peak beyond the setpoint, in percent of the step",
    unit: Unit::Percent,
    absent: "the process value does not reach the setpoint",
    needs: Needs::Nothing,
    of: |window| window.step()?.overshoot(),
};

/// The settling time, also reported by predictions.
pub static SETTLING: Figure = Figure {
    key: "settling",
    title: "Settling time",
    meaning: "From the step until the process value stays in a band of ±2 % of the step around the setpoint",
    unit: Unit::Seconds,
    absent: "the process value does not settle",
    needs: Needs::Nothing,
    of: |window| window.settling(),
};

/// The reason given if no disturbance occurs.
const NO_DISTURBANCE: &str = "nothing disturbs the loop in this part of the run";

const NO_CALL: &str = "this part of the run contains no calls";
const NO_DEVIATION: &str = "the setpoint or the process value is NaN in some calls";

/// Returns the figure with this key.
pub fn find(key: &str) -> Option<&'static Figure> {
    FIGURES.into_iter().find(|figure| figure.key == key)
}

impl Figure {
    /// Computes the figure.
    ///
    /// # Errors
    /// The figure cannot be computed for this window; the error is the reason, without an initial capital or a period.
    pub fn value(&self, window: &Window) -> Result<f64, String> {
        if window.calls.is_empty() { Err(NO_CALL.into()) } else { (self.of)(window) }
    }
}

impl Unit {
    /// Formats the unit, given the units of the process value and the manipulated value. Temperature differences in
    /// degC are in K. An integral over values without a unit has no unit.
    pub fn text(self, process_value: Option<&str>, manipulated_value: Option<&str>) -> Option<String> {
        let process_value =
            process_value.map(|unit| if unit == "degC" { "K" } else { unit }).filter(|unit| *unit != "1");
        match self {
            Unit::One => None,
            Unit::Seconds => Some("s".into()),
            Unit::Percent => Some("%".into()),
            Unit::ProcessValue => process_value.map(str::to_string),
            Unit::ProcessValueSeconds => process_value.map(|unit| format!("{unit} s")),
            Unit::SquareSeconds => process_value.map(|unit| format!("{} s", squared(unit))),
            Unit::ManipulatedValue => manipulated_value.map(str::to_string),
        }
    }
}

/// Returns the square of a unit.
fn squared(unit: &str) -> String {
    let is_simple = unit.chars().all(|character| character.is_alphabetic() || character == '%');
    if is_simple { format!("{unit}^2") } else { format!("({unit})^2") }
}

/// The part of a run to evaluate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// The beginning of the part in seconds; by default, that of the last step's window.
    pub from: Option<f64>,
    /// The end of the part in seconds; by default, that of the last step's window, or the last call if `from` is given.
    pub to: Option<f64>,
    /// The process value before the step and the setpoint after it, if they are known: the step then begins with the
    /// first call.
    pub step: Option<(f64, f64)>,
}

/// The recorded signals of a loop, each with a value for every call.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals<'a> {
    /// The times of the calls in seconds.
    pub times: &'a [f64],
    /// The setpoint in each call.
    pub setpoint: &'a [f64],
    /// The process value in each call, in the setpoint's unit.
    pub process_value: &'a [f64],
    /// The manipulated value; empty if the controller drives the plant by pulses, because the travel of the pulses'
    /// mean is meaningless.
    pub manipulated_value: &'a [f64],
    /// One signal per pulse output; empty if there are none.
    pub pulses: &'a [Vec<bool>],
    /// Whether the controller is in manual mode in each call; empty if it never is. A setpoint changed in manual mode
    /// becomes a step when automatic mode begins.
    pub manual: &'a [bool],
    /// The disturbances, with their times.
    pub disturbances: &'a [Set],
    /// The first row that holds outputs of a call: 1 if the members run in parallel, because the first row then holds
    /// their outputs before the first call.
    pub first: usize,
    /// Whether the beginning of the run is not recorded.
    pub is_cut: bool,
    /// The unit of the manipulated value, for messages.
    pub travel_unit: Option<&'a str>,
}

/// A part of a run. Signals are evaluated up to the end of the shortest of times, setpoint and process value.
#[derive(Debug)]
pub struct Window<'a> {
    signals: Signals<'a>,
    /// The calls in the window.
    calls: Range<usize>,
    step: Result<Step<'a>, String>,
    deviation: Result<Deviation, String>,
    /// The response to the disturbance, if there is one.
    disturbed: Option<Disturbed>,
    /// Whether the figures other than those of the disturbance apply.
    has_step: bool,
}

/// The event that begins a window.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Happened {
    /// Its cause.
    pub cause: Cause,
    /// The process value in its first call.
    pub from: f64,
    /// The setpoint in its last call.
    pub to: f64,
    /// When it began, in seconds.
    pub start: f64,
    /// The length of its window, in seconds.
    pub duration: f64,
    /// Half the width of the band around the setpoint in which the process value counts as settled or recovered, in the
    /// unit of the process value; absent for a disturbance with no step before it.
    pub band: Option<f64>,
    /// The variables that disturbed the loop, each with its last value.
    pub by: Vec<Set>,
}

/// A range of values during a time interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The start and end of the interval in seconds.
    pub times: (f64, f64),
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
}

/// The integrals and the peak of the deviation.
#[derive(Clone, Copy, Debug)]
struct Deviation {
    iae: f64,
    ise: f64,
    peak: f64,
}

/// The response to a disturbance.
#[derive(Debug)]
struct Disturbed {
    calls: Range<usize>,
    /// Half the width of the band in which the loop counts as recovered; `None` if unknown.
    half: Option<f64>,
    deviation: Result<Deviation, String>,
    recovery: Result<f64, String>,
}

/// A setpoint step with the response of the process value.
#[derive(Debug)]
struct Step<'a> {
    cause: Cause,
    times: &'a [f64],
    /// The process value when the step begins.
    start: f64,
    /// The setpoint after the step.
    setpoint: f64,
    /// The signed height of the step.
    height: f64,
    /// The completed fraction of the step in each call: 0 at the start, 1 at the setpoint.
    done: Vec<f64>,
    /// The overshoot as a fraction of the step.
    beyond: f64,
    is_ramp: bool,
}

impl<'a> Window<'a> {
    /// Returns the window of the given part of a recorded loop, by default that of its last step. Its figures include
    /// those of the last disturbance.
    pub fn measure(signals: Signals<'a>, span: &Span) -> Window<'a> {
        let count = signals.count();
        let times = &signals.times[..count];
        let end = span.to.map_or(count, |to| times.partition_point(|time| *time <= to));
        let mut events = signals.events(end);
        if span.step.is_some() {
            // The rows begin with the given step, which replaces all others: only a disturbance ends its window.
            events.retain(|event| !event.is_step());
            let until = events.first().map_or(end, |event| event.calls.start);
            events.insert(0, Event { cause: Cause::Setpoint, calls: 0..until });
        }
        let begin = span.from.map(|from| times.partition_point(|time| *time < from));
        let is_inside = |event: &&Event| event.calls.start >= begin.unwrap_or(0);
        let step = events.iter().rev().filter(|event| event.is_step()).find(is_inside);
        let calls = match (begin, step) {
            (Some(begin), _) => begin..end.max(begin),
            (None, Some(step)) => step.calls.clone(),
            (None, None) => signals.first_call(end)..end,
        };
        // A disturbance has no effect yet in its first call.
        let has_effect = |event: &Event| !event.is_step() && is_inside(&event) && event.calls.len() > 1;
        let disturbance = events.iter().rposition(has_effect);
        Window::new(signals, calls, step, disturbance.map(|at| events.split_at(at)), span.step)
    }

    /// Returns the windows of all steps and disturbances in chronological order, each with only the figures of its own
    /// event.
    pub fn of_events(signals: Signals<'a>) -> Vec<Window<'a>> {
        let events = signals.events(signals.count());
        let window = |(at, event): (usize, &Event)| {
            let calls = event.calls.clone();
            match event.is_step() {
                true => Window::new(signals, calls, Some(event), None, None),
                false => {
                    Window { has_step: false, ..Window::new(signals, calls, None, Some(events.split_at(at)), None) }
                }
            }
        };
        events.iter().enumerate().map(window).collect()
    }

    /// Returns the window of a disturbance that begins in the call `from`, up to the end of the run. `half` is half the
    /// width of the band in which the loop counts as recovered, in the unit of the process value.
    pub fn of_disturbance(signals: Signals<'a>, from: usize, half: f64) -> Window<'a> {
        let calls = from..signals.count();
        let disturbed = Disturbed::new(&signals, calls.clone(), Ok(half));
        Window { has_step: false, disturbed: Some(disturbed), ..Window::new(signals, calls, None, None, None) }
    }

    /// `disturbance` holds the events before the disturbance, and the disturbance with all later events.
    fn new(
        signals: Signals<'a>,
        calls: Range<usize>,
        step: Option<&Event>,
        disturbance: Option<(&[Event], &[Event])>,
        given: Option<(f64, f64)>,
    ) -> Window<'a> {
        let is_manual = |call: usize| signals.manual.get(call).copied().unwrap_or(false);
        let step = match step {
            Some(event) => Step::new(&signals, event, given),
            None if !calls.is_empty() && is_manual(calls.end - 1) => Err("the controller is in manual mode".into()),
            None => Err(NO_CHANGE.into()),
        };
        let disturbed = disturbance.map(|(before, from)| {
            let before = before.iter().rev().find(|event| event.is_step());
            let before = before.ok_or("the width of the band is unknown, since no step precedes the disturbance");
            let half = before.map_err(str::to_string).and_then(|event| Step::new(&signals, event, given));
            Disturbed::new(&signals, from[0].calls.clone(), half.map(|step| BAND * step.height.abs()))
        });
        let deviation = Deviation::new(&signals, calls.clone());
        Window { signals, calls, step, deviation, disturbed, has_step: true }
    }

    /// Returns the times of the first and the last call in seconds; `None` for an empty window.
    pub fn times(&self) -> Option<(f64, f64)> {
        self.times_of(&self.calls)
    }

    fn times_of(&self, calls: &Range<usize>) -> Option<(f64, f64)> {
        let times = self.signals.times.get(calls.clone())?;
        Some((*times.first()?, *times.last()?))
    }

    /// Returns the step that the figures refer to.
    pub fn step_happened(&self) -> Option<Happened> {
        let Step { cause, start: from, setpoint: to, times, height, .. } = self.step.as_ref().ok()?;
        let (start, end) = (times[0], times[times.len() - 1]);
        let band = Some(BAND * height.abs());
        Some(Happened { cause: *cause, from: *from, to: *to, start, duration: end - start, band, by: Vec::new() })
    }

    /// Returns the disturbance that the figures refer to.
    pub fn disturbance_happened(&self) -> Option<Happened> {
        let Disturbed { calls, half, .. } = self.disturbed.as_ref()?;
        let (start, end) = self.times_of(calls)?;
        let (from, to) = (self.signals.process_value[calls.start], self.signals.setpoint[calls.end - 1]);
        let by = self.signals.disturbances_in(calls);
        Some(Happened { cause: Cause::Disturbance, from, to, start, duration: end - start, band: *half, by })
    }

    /// Returns the band in which the process value counts as settled; `None` without a step.
    pub fn band(&self) -> Option<Band> {
        let step = self.step.as_ref().ok()?;
        let half = BAND * step.height.abs();
        let times = (*step.times.first()?, *step.times.last()?);
        Some(Band { times, low: step.setpoint - half, high: step.setpoint + half })
    }

    /// Returns the figures that apply to the window's event and signals.
    pub fn figures(&self) -> impl Iterator<Item = &'static Figure> {
        let has_step = self.has_step;
        let given = LoopSignals {
            manipulated_value: !self.signals.manipulated_value.is_empty(),
            pulses: !self.signals.pulses.is_empty(),
            disturbance: self.disturbed.is_some(),
        };
        applicable(given).filter(move |figure| has_step || figure.needs == Needs::Disturbance)
    }

    /// Returns remarks on these figures, one sentence each: whether the setpoint is a ramp, and which figures are
    /// missing and why.
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
            ramp.then(|| "the setpoint is a ramp: its duration is included in the rise and settling times".to_string());
        let absent = reasons.into_iter().map(|(reason, names)| match names.split_last() {
            Some((last, rest)) if !rest.is_empty() => format!("no {} or {last}: {reason}", rest.join(", ")),
            _ => format!("no {}: {reason}", names.concat()),
        });
        ramp.into_iter().chain(absent).collect()
    }

    fn step(&self) -> Result<&Step<'a>, String> {
        self.step.as_ref().map_err(Clone::clone)
    }

    fn disturbed(&self) -> Result<&Disturbed, String> {
        self.disturbed.as_ref().ok_or_else(|| NO_DISTURBANCE.into())
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
                    "{why}; the manipulated value has been {value}{unit} since {since} s: it is at a limit, the \
                     controller is in manual mode, or the deviation is within the dead band"
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
        // Pulse outputs are FALSE before the first call of a run.
        let begins = |pulse: &Vec<bool>| {
            let calls = self.calls.start..self.calls.end.min(pulse.len());
            calls.filter(|call| pulse[*call] && !(*call > 0 && pulse[call - 1])).count() as f64
        };
        Ok(self.signals.pulses.iter().map(begins).sum())
    }

    /// Returns the last manipulated value and the time since when it has been constant, if that is at least the last
    /// tenth of the response.
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

/// The signals of a loop other than setpoint and process value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopSignals {
    /// Whether there is a manipulated value and it is not just the mean of pulses.
    pub manipulated_value: bool,
    /// Whether there are pulse outputs.
    pub pulses: bool,
    /// Whether there is a disturbance.
    pub disturbance: bool,
}

/// Returns the figures that can be computed from the given signals.
pub fn applicable(given: LoopSignals) -> impl Iterator<Item = &'static Figure> {
    FIGURES.into_iter().filter(move |figure| match figure.needs {
        Needs::Nothing => true,
        Needs::ManipulatedValue => given.manipulated_value,
        Needs::Pulses => given.pulses,
        Needs::Disturbance => given.disturbance,
    })
}

/// Converts a title for use inside a sentence; abbreviations stay in upper case.
pub fn in_sentence(title: &str) -> String {
    let is_abbreviation = |word: &str| word.chars().all(|letter| letter.is_ascii_uppercase());
    let word = |word: &str| if is_abbreviation(word) { word.to_string() } else { word.to_lowercase() };
    title.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

impl Signals<'_> {
    /// Returns the number of calls.
    fn count(&self) -> usize {
        self.times.len().min(self.setpoint.len()).min(self.process_value.len())
    }
}

impl Disturbed {
    /// Evaluates the response in these calls; the loop has recovered once the process value stays within `half` of the
    /// setpoint.
    fn new(signals: &Signals, calls: Range<usize>, half: Result<f64, String>) -> Disturbed {
        let recovery = half.clone().and_then(|half| Disturbed::recovery(signals, &calls, half));
        Disturbed { deviation: Deviation::new(signals, calls.clone()), recovery, half: half.ok(), calls }
    }

    fn recovery(signals: &Signals, calls: &Range<usize>, half: f64) -> Result<f64, String> {
        let deviation = |call: usize| (signals.setpoint[call] - signals.process_value[call]).abs();
        let times = &signals.times[calls.clone()];
        let (begin, end) = (times[0], times[times.len() - 1]);
        // NaN counts as outside the band.
        let outside = calls.clone().rev().find(|call| !deviation(*call).le(&half));
        let since = outside.map_or(calls.start, |call| call + 1);
        if since >= calls.end {
            let off = short(deviation(calls.end - 1));
            return Err(format!("the process value is {off} away from the setpoint at {} s", short(end)));
        }
        let since = signals.times[since];
        if outside.is_some() && end - since < STAY * (end - begin) {
            let stayed = short(end - since);
            return Err(format!("the process value has been in the band for only {stayed} s and may leave it again"));
        }
        Ok(since - begin)
    }
}

impl Deviation {
    fn new(signals: &Signals, calls: Range<usize>) -> Result<Deviation, String> {
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

/// Returns the time from a call to the next one; for the last call, the time since the previous one.
fn duration(times: &[f64], call: usize) -> f64 {
    match (times.get(call + 1), call.checked_sub(1)) {
        (Some(next), _) => next - times[call],
        (None, Some(previous)) => times[call] - times[previous],
        (None, None) => 0.0,
    }
}

impl<'a> Step<'a> {
    /// Returns the step of an event; `given` replaces the process value before the step and the setpoint after it.
    fn new(signals: &Signals<'a>, event: &Event, given: Option<(f64, f64)>) -> Result<Step<'a>, String> {
        let Event { cause, calls } = event.clone();
        if calls.is_empty() {
            return Err(NO_CALL.into());
        }
        let (times, setpoints) = (&signals.times[calls.clone()], &signals.setpoint[calls.clone()]);
        let values = &signals.process_value[calls];
        let (start, setpoint) = given.unwrap_or((values[0], setpoints[setpoints.len() - 1]));
        let height = setpoint - start;
        if values.iter().chain(setpoints).chain([&height]).any(|value| !value.is_finite()) {
            return Err(NO_DEVIATION.into());
        }
        if height.abs() <= 1e-9 * setpoint.abs().max(start.abs()) {
            return Err("the process value is already at the new setpoint".into());
        }
        Ok(Step {
            cause,
            times,
            start,
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
                Err(format!("the process value has completed {so_far:.0} % of the step so far"))
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

    /// Returns the time in seconds from the step until the process value stays in the band, or the reason why it does
    /// not.
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
                "the process value has been within {percent:.0} % of the step for only {} s and may leave it again",
                short(stayed)
            ));
        }
        Ok(since - begin)
    }
}

#[cfg(test)]
mod tests;
