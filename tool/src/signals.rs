//! The signals of a recorded loop, for figures and identification. They are found by the roles of the first member's
//! variables.

use crate::describe::describe;
use crate::home::Home;
use crate::message::{Act, Figure, Figures, FiguresRequest, Member, Tried, Values, View};
use crate::session::{Done, Record, Session};
use crate::travel;
use anyhow::{Context, Result};
use control::figures::{self, Set, Span, Window, Wiring};
use control::identify::{self, Data, Identified};
use run::dialog::Roles;
use run::system::Exchange;

/// The signals of a loop, for the calls that are stored individually.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// The times of the calls, in seconds.
    pub times: Vec<f64>,
    /// The setpoint.
    pub setpoint: Vec<f64>,
    /// The process value in the setpoint's unit.
    pub process_value: Vec<f64>,
    /// The manipulated value; empty if the controller has none, only pulses.
    pub manipulated_value: Vec<f64>,
    /// The pulse outputs; may be empty.
    pub pulses: Vec<Vec<bool>>,
    /// Whether the controller is in manual mode; empty if it has no manual mode.
    pub manual: Vec<bool>,
    /// The disturbances of the loop.
    pub disturbances: Vec<Set>,
    /// The index of the first row whose outputs were computed by a call.
    pub first: usize,
    /// Whether earlier calls are no longer stored individually.
    pub is_cut: bool,
    /// The unit of the process value, if known.
    pub unit: Option<String>,
    /// The unit of the manipulated value, if known.
    pub travel_unit: Option<String>,
    /// Remarks for the user, a sentence each.
    pub remarks: Vec<String>,
}

impl Signals {
    /// The signals of a run between two times, both in seconds; by default of all calls.
    ///
    /// # Errors
    /// The first member's FMU does not specify its setpoint or its process value.
    pub fn new(home: &dyn Home, record: &Record, from: Option<f64>, to: Option<f64>) -> Result<Signals> {
        let controller = record.setup().members.first().context("no controller")?;
        let roles = describe(home, &controller.fmu)?.roles;
        let wanted = record.calls_between(from, to);
        let exact = record.trace().exact();
        let calls = wanted.start.max(exact.start)..wanted.end.max(exact.start);
        let column = |name: &String| record.column(&format!("{}.{name}", controller.name));
        let values = |column: usize| record.trace().column(column, calls.clone()).collect::<Vec<_>>();
        let unit = |column: usize| record.columns()[column].unit.clone();
        let needed = |role: Option<&String>, what: &str| {
            let missing = || format!("{} does not specify which variable is its {what}", controller.fmu);
            column(role.with_context(missing)?)
        };
        let setpoint = needed(roles.setpoint.as_ref(), "setpoint")?;
        let process_value = needed(roles.compared_process_value(), "process value")?;
        let manipulated_value = roles.manipulated_value.as_ref().map(column).transpose()?;
        let pulses = roles.pulses.iter().map(column).collect::<Result<Vec<_>>>()?;
        let manual = roles.manual_mode().map(column).transpose()?;
        let switched = |column: usize| values(column).into_iter().map(|value| value == 1.0).collect::<Vec<_>>();
        let wiring =
            wiring(home, record, format!("{}.{}", controller.name, roles.setpoint.as_deref().unwrap_or_default()))?;
        let name_unit = |name: &str| record.column(name).ok().and_then(unit);
        let mut remarks = Vec::new();
        if wanted.start < calls.start {
            let (first, count) = (record.time(calls.start), calls.len());
            remarks.push(format!(
                "only the last {count} calls, from {first:?} s onward, are used: earlier calls are not stored \
                 individually"
            ));
        }
        Ok(Signals {
            times: calls.clone().map(|call| record.time(call)).collect(),
            setpoint: values(setpoint),
            process_value: values(process_value),
            manipulated_value: manipulated_value.map_or_else(Vec::new, values),
            pulses: pulses.into_iter().map(switched).collect(),
            manual: manual.map_or_else(Vec::new, switched),
            disturbances: disturbances(record, &wiring),
            // In a parallel exchange, the first row contains the outputs before the first call.
            first: usize::from(record.setup().exchange == Exchange::Parallel && calls.start == 0),
            is_cut: exact.start > 0,
            unit: wiring.unit_of_process_value(name_unit),
            travel_unit: wiring.unit_of_manipulated_value(name_unit),
            remarks,
        })
    }

    /// The last period, in seconds, in which the controller was in manual mode while its actuator moved.
    fn last_manual(&self) -> Option<(f64, f64)> {
        let moved = |at: usize| match self.manipulated_value.is_empty() {
            true => self.pulses.iter().any(|pulse| pulse[at]),
            false => self.manipulated_value[at] != self.manipulated_value[at - 1],
        };
        let mut last = None;
        let mut end = 0;
        for stretch in self.manual.chunk_by(|one, other| one == other) {
            let start = end;
            end += stretch.len();
            if stretch[0] && (start + 1..end).any(moved) {
                last = Some((self.times[start], self.times[end - 1]));
            }
        }
        last
    }

    /// The same signals, borrowed for computing figures.
    pub fn borrowed(&self) -> figures::Signals<'_> {
        figures::Signals {
            times: &self.times,
            setpoint: &self.setpoint,
            process_value: &self.process_value,
            // The travel figure must not be computed from the mean of pulses.
            manipulated_value: if self.pulses.is_empty() { &self.manipulated_value } else { &[] },
            pulses: &self.pulses,
            manual: &self.manual,
            disturbances: &self.disturbances,
            first: self.first,
            is_cut: self.is_cut,
            travel_unit: self.travel_unit.as_deref(),
        }
    }
}

/// The members and connections at the end of a run, with the members' roles.
fn wiring<'a>(home: &dyn Home, record: &'a Record, setpoint: String) -> Result<Wiring<'a>> {
    let roles = |member: &Member| -> Result<Option<Roles>> { Ok(Some(describe(home, &member.fmu)?.roles)) };
    Ok(Wiring {
        setpoint,
        members: record.members().map(|member| member.name.as_str()).collect(),
        roles: record.members().map(roles).collect::<Result<_>>()?,
        connections: record.connections().iter().map(|(from, to)| (from.as_str(), to.as_str())).collect(),
    })
}

/// The disturbances of a run: variables set, and members replaced.
fn disturbances(record: &Record, wiring: &Wiring) -> Vec<Set> {
    let set = |done: &Done| {
        let before =
            done.call.checked_sub(1).and_then(|call| record.trace().column(done.column, call..done.call).next());
        let (time, variable) = (record.time(done.call), record.columns()[done.column].name.clone());
        Set { time, variable, value: Some(done.value), before }
    };
    let mut all = wiring.disturbances(record.done().iter().filter(|done| done.act == Act::Set).map(set));
    all.extend(record.exchanges().iter().map(|exchange| {
        let names: Vec<&str> = exchange.members.iter().map(|member| member.name.as_str()).collect();
        Set { time: record.time(exchange.call), variable: names.join(", "), ..Set::default() }
    }));
    all
}

/// The figures of a run.
///
/// # Errors
/// No such run; as for [`Signals::new`].
pub fn figures(home: &dyn Home, session: &Session, request: &FiguresRequest) -> Result<Figures> {
    // The whole run is needed: the last setpoint change may be before the window.
    let record = session.record(request.run)?;
    let mut signals = Signals::new(home, record, None, None)?;
    signals.unit = signals.unit.or_else(|| request.unit.clone());
    signals.travel_unit = signals.travel_unit.or_else(|| request.travel_unit.clone());
    let span = Span { from: request.from, to: request.to, ..Span::default() };
    let window = Window::measure(signals.borrowed(), &span);
    let begin = request.from.unwrap_or_default();
    let (from, to) = window.times().unwrap_or((begin, request.to.unwrap_or(begin)));
    let all: Vec<_> = window.figures().collect();
    let mut remarks = window.remarks(&all);
    if signals.times.first().is_some_and(|first| from <= *first) {
        remarks.extend(signals.remarks.iter().cloned());
    }
    let figure = |of: &figures::Figure| Figure {
        key: of.key.into(),
        title: of.title.into(),
        meaning: of.meaning.into(),
        value: of.value(&window).ok(),
        unit: of.unit.text(signals.unit.as_deref(), signals.travel_unit.as_deref()),
    };
    let (step, disturbance) = (window.step_happened(), window.disturbance_happened());
    Ok(Figures { from, to, step, disturbance, figures: all.into_iter().map(figure).collect(), remarks })
}

/// Curves and figures of the current run's test, repeated with other settings.
///
/// # Errors
/// As for [`Session::tried`] and [`Session::view`].
pub fn tried(
    home: &dyn Home,
    session: &Session,
    values: &Values,
    view: View,
    request: FiguresRequest,
) -> Result<Tried> {
    let beside = session.tried(home, values)?;
    let curves = beside.view(&View { run: None, ..view })?;
    // A loop without a setpoint has curves but no figures.
    let figures = figures(home, &beside, &FiguresRequest { run: None, ..request }).ok();
    Ok(Tried { curves, figures })
}

/// Identifies a plant's model from a step in a run or in a file.
///
/// # Errors
/// No such run, or it does not reveal the plant; a problem with the file.
pub fn identify(home: &dyn Home, session: &Session, request: &identify::IdentifyRequest) -> Result<Identified> {
    let Data::Run { run, from, to } = request.data else { return identify::of_csv(request) };
    let record = session.record(run)?;
    let mut signals = Signals::new(home, record, from, to)?;
    if let (None, None, Some((from, to))) = (from, to, signals.last_manual()) {
        signals = Signals::new(home, record, Some(from), Some(to))?;
    }
    let mut identified = if signals.manipulated_value.is_empty() && !signals.times.is_empty() {
        travel::identify(home, record, &signals, request)?
    } else {
        // In the rows before the first computed output, the plant is assumed to be at its first computed value.
        let first = signals.first.min(signals.process_value.len());
        let (before, given) = signals.process_value.split_at_mut(first);
        before.fill(given.first().copied().unwrap_or(f64::NAN));
        let (times, input) = (&signals.times, &signals.manipulated_value);
        let recorded = identify::Recorded { times, input, output: &signals.process_value };
        identify::identify(&recorded, request.method, request.is_integrating)?
    };
    identified.remarks.extend(signals.remarks);
    Ok(identified)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{Setup, Values};
    use crate::test_home::TestHome;
    use control::figures::Cause;
    use run::system::Value;

    fn session(home: &TestHome, is_manual: bool) -> Session {
        let values = |given: &[(&str, f64)]| -> Values {
            given.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect()
        };
        let member = |name: &str, fmu: &str, given: &[(&str, f64)]| Member {
            name: name.into(),
            fmu: fmu.into(),
            values: values(given),
        };
        let manual = f64::from(u8::from(is_manual));
        let controller = member("C", "PID", &[("GAIN", 1.0), ("TI", 8.0), ("MAN_ON", manual), ("CYCLE", 0.1)]);
        let connections = [("C.OUT", "P.POWER"), ("P.TEMP", "C.PV_IN")];
        let setup = Setup {
            members: vec![controller, member("P", "LAG", &[("CYCLE", 0.1)])],
            connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
            ..Setup::default()
        };
        let mut session = Session::default();
        session.start(home, setup).unwrap();
        session.run(50).unwrap();
        session.send(&values(&[("C.SP", 60.0), ("C.MAN", 40.0)])).unwrap();
        session.run(1000).unwrap();
        session
    }

    #[test]
    fn the_figures_are_those_of_the_setpoint_step_of_the_run() {
        let home = TestHome::default();
        let figures = figures(&home, &session(&home, false), &FiguresRequest::default()).unwrap();
        assert_eq!(figures.from, 5.0);
        let find = |key: &str| figures.figures.iter().find(|figure| figure.key == key).unwrap();
        for (key, unit) in [("settling", "s"), ("ise", "K^2 s")] {
            assert_eq!(find(key).unit.as_deref(), Some(unit));
        }
        let step = figures.step.as_ref().unwrap();
        assert_eq!((step.cause, step.from, step.to, step.start), (Cause::Setpoint, 0.0, 60.0, 5.0));
        assert!(figures.figures.iter().all(|figure| figure.value.is_some()), "{figures:?}");
        // UP and DOWN are its pulses: UP comes with the step, which is above 50 %, and DOWN later.
        assert!(find("pulses").value >= Some(2.0) && find("pulses").unit.is_none(), "{figures:?}");
    }

    #[test]
    fn a_plant_is_identified_from_a_manual_step_of_the_run() {
        let home = TestHome::default();
        let data = Data::Run { run: None, from: None, to: None };
        let request = identify::IdentifyRequest { data, method: identify::Method::LeastSquares, is_integrating: false };
        let model = identify(&home, &session(&home, true), &request).unwrap().model;
        assert!((model.gain / 1.5 - 1.0).abs() < 0.01 && (model.time_constant / 10.0 - 1.0).abs() < 0.02, "{model:?}");
    }

    #[test]
    fn a_manual_step_between_two_times_in_automatic_mode_is_found() {
        let home = TestHome::default();
        let mut session = session(&home, true);
        for (is_manual, setpoint) in [(false, 50.0), (true, 50.0), (false, 90.0)] {
            let sent = [("C.MAN_ON", Value::Boolean(is_manual)), ("C.SP", Value::Number(setpoint))];
            session.send(&sent.map(|(name, value)| (name.to_string(), value)).into()).unwrap();
            session.run(300).unwrap();
        }
        let data = Data::Run { run: None, from: None, to: None };
        let request = identify::IdentifyRequest { data, method: identify::Method::LeastSquares, is_integrating: false };
        let model = identify(&home, &session, &request).unwrap().model;
        assert!((model.gain / 1.5 - 1.0).abs() < 0.01 && (model.time_constant / 10.0 - 1.0).abs() < 0.02, "{model:?}");
    }

    #[test]
    fn a_foreign_controller_tells_no_setpoint() {
        let home = TestHome::default();
        let mut session = Session::default();
        let member = Member { name: "F".into(), fmu: "FOREIGN".into(), values: Values::new() };
        session.start(&home, Setup { members: vec![member], step: Some(0.1), ..Setup::default() }).unwrap();
        let error = figures(&home, &session, &FiguresRequest::default()).unwrap_err();
        assert_eq!(error.to_string(), "FOREIGN does not specify which variable is its setpoint");
    }
}
