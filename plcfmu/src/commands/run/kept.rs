//! Processes the rows of a `plcfmu run`: writes them, and keeps a bounded number for plotting and the signals for the
//! figures.

use anyhow::{Context, Result};
use control::figures::{Figure, Happened, Set, Signals, Span, Window, Wiring};
use host::child::run::Rows;
use host::package::Package;
use modeldescription::Variable;
use run::dialog::Roles;
use run::fmus::number_of;
use run::master::write_cells;
use run::plan::Plan;
use run::system::{Exchange, Member, System, own_name};
use run::trace::Trace;
use serde::Serialize;
use std::io::{ErrorKind, Write};

/// The maximum number of steps for which figures are computed: the signals of longer runs would exhaust memory.
const MOST_CALLS: usize = 2_000_000;

/// The maximum number of points in a drawing: each pair of points holds the extremes of a part of the run.
const POINTS: usize = 8192;

/// Writes the recording during the run, and keeps the data needed at the end.
pub(super) struct Recorder<'a, 'w> {
    kept: Kept<'a>,
    /// The recording as CSV, if requested.
    csv: Option<&'w mut dyn Write>,
    /// Whether the CSV reader has closed the pipe.
    is_closed: bool,
}

/// The data kept from the rows.
pub(super) struct Kept<'a> {
    plan: &'a Plan,
    system: &'a System,
    /// The settings made during the run.
    set: Vec<Set>,
    /// The disturbances of the loop.
    disturbances: Vec<Set>,
    /// The unit of the process value.
    pub unit: Option<String>,
    /// The unit of the manipulated value.
    pub travel_unit: Option<String>,
    /// Record one row in this many.
    every: usize,
    /// The recorded rows, for a drawing.
    drawn: Option<Trace>,
    /// The roles of the first FMU's variables in a loop.
    pub roles: Roles,
    /// The columns of the figures' signals: setpoint, process value, manipulated value.
    signals: Option<[Option<usize>; 3]>,
    times: Vec<f64>,
    values: [Vec<f64>; 3],
    pulses: Vec<(usize, Vec<bool>)>,
    /// The switch to manual mode, if it is recorded: its column, and its value in each row.
    manual: Option<(usize, Vec<bool>)>,
    /// The switch's start value and settings with their times, used if it is not recorded; empty if it is connected.
    switched: Vec<(f64, bool)>,
    /// The number of rows.
    pub rows: usize,
    /// The number of recorded rows.
    pub recorded: usize,
    /// The last row, as returned by the FMUs and written to the CSV.
    cells: Vec<f64>,
    /// The last row, converted to numbers.
    pub last: Vec<f64>,
}

/// The figures of a run.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    /// The figures of the last step and of the last disturbance.
    pub last: Vec<Told>,
    /// Each step and each disturbance with its figures.
    pub events: Vec<Of>,
}

/// The figures of a step or a disturbance, as printed by `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Of {
    /// The event to which the figures belong.
    #[serde(flatten)]
    pub happened: Happened,
    pub figures: Vec<Told>,
}

/// A figure, as printed by `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Told {
    /// The key by which scripts find it, such as `iae`.
    pub key: &'static str,
    pub title: &'static str,
    /// Its value; if missing, `why` states the reason.
    pub value: Option<f64>,
    pub unit: Option<String>,
    /// Why it has no value.
    pub why: Option<String>,
}

impl<'a, 'w> Recorder<'a, 'w> {
    /// Creates a recorder for the rows of a plan: one in `every` rows is written to `csv` and drawn.
    pub(super) fn new(
        system: &'a System,
        plan: &'a Plan,
        csv: Option<&'w mut dyn Write>,
        every: usize,
        is_drawn: bool,
    ) -> Recorder<'a, 'w> {
        let kept = Kept {
            plan,
            system,
            set: Set::of_settings(&system.settings),
            disturbances: Vec::new(),
            unit: None,
            travel_unit: None,
            every,
            drawn: is_drawn.then(|| Trace::new(plan.columns.len())),
            roles: Roles::default(),
            signals: None,
            times: Vec::new(),
            values: Default::default(),
            pulses: Vec::new(),
            manual: None,
            switched: Vec::new(),
            rows: 0,
            recorded: 0,
            last: Vec::new(),
            cells: Vec::new(),
        };
        Recorder { kept, csv, is_closed: false }
    }

    /// Records the last row if an FMU has ended the run between two recorded rows.
    ///
    /// # Errors
    /// The last row cannot be written.
    pub(super) fn finish(mut self) -> Result<Kept<'a>> {
        let Kept { plan, rows, every, .. } = self.kept;
        if rows > 0 && !(rows - 1).is_multiple_of(every) && rows <= plan.steps {
            let cells = self.kept.cells.clone();
            self.record(plan.time(rows - 1), &cells)?;
        }
        Ok(self.kept)
    }

    /// Writes a row, and keeps it for a drawing.
    fn record(&mut self, time: f64, cells: &[f64]) -> Result<()> {
        self.kept.recorded += 1;
        if let Some(trace) = &mut self.kept.drawn {
            trace.push(&self.kept.last);
        }
        let Some(csv) = self.csv.as_mut().filter(|_| !self.is_closed) else { return Ok(()) };
        match write_cells(*csv, &self.kept.plan.columns, time, cells) {
            // The reader may stop early, as `head` does.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => self.is_closed = true,
            written => written.context("the recording")?,
        }
        Ok(())
    }
}

impl Kept<'_> {
    /// The column of a variable of the first FMU, if it is recorded.
    pub(super) fn column(&self, variable: Option<&String>) -> Option<usize> {
        let name = format!("{}.{}", self.plan.members[0].name, variable?);
        self.plan.columns.iter().position(|column| column.name == name)
    }

    /// The column of the process value that is compared with the setpoint. An analog word, an integer, cannot be.
    pub(super) fn process_value(&self) -> Option<usize> {
        let input = || self.column(self.roles.process_value.as_ref());
        let is_word = |at: &usize| !self.plan.columns[*at].kind.is_floating();
        self.column(self.roles.shown_process_value.as_ref()).or_else(|| input().filter(|at| !is_word(at)))
    }

    /// Why no figures are available.
    fn why_none(&self) -> String {
        let Some(([setpoint, Some(process_value), _], first)) =
            Some(self.roles.signals()).zip(self.plan.members.first()).filter(|([setpoint, ..], _)| setpoint.is_some())
        else {
            return "no figures: setpoint and process value of the first FMU are not recorded".into();
        };
        let missing = [setpoint, Some(process_value)].into_iter().flatten();
        let missing =
            missing.filter(|name| self.column(Some(name)).is_none()).map(|name| format!("{}.{name}", first.name));
        let missing: Vec<String> = missing.collect();
        format!("no figures: the recording lacks {}, see --record", missing.join(" and "))
    }

    /// The times and curves of all columns, if the run is plotted.
    pub(super) fn curves(&self) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let trace = self.drawn.as_ref()?;
        // The last row is at the end of the run, even if this is not a multiple of the interval.
        let time = |call: usize| self.plan.time((call * self.every).min(self.rows - 1));
        let columns: Vec<usize> = (0..self.plan.columns.len()).collect();
        let curves = trace.curves(&columns, 0..trace.calls(), POINTS);
        Some((curves.calls.into_iter().map(time).collect(), curves.values))
    }

    /// The values of a controller's switch with their times: its start value and later settings, in chronological
    /// order. Empty for a connected switch.
    fn settings_of(&self, switch: &Variable) -> Vec<(f64, bool)> {
        let name = format!("{}.{}", self.plan.members[0].name, switch.name);
        if self.system.connections.iter().any(|of| of.to == name) {
            return Vec::new();
        }
        let start = switch.start.map(|start| (f64::NEG_INFINITY, start != 0.0));
        let settings = self.system.settings.iter().filter(|of| of.variable == name);
        let set = settings.map(|of| (of.time.unwrap_or(f64::NEG_INFINITY), number_of(of.value) != 0.0));
        let mut all: Vec<_> = start.into_iter().chain(set).collect();
        all.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        all
    }

    /// Whether the controller is in manual mode in each of these calls; unknown counts as automatic.
    fn manual(&self, calls: usize) -> Vec<bool> {
        if let Some((_, values)) = &self.manual {
            return values[..calls].to_vec();
        }
        // Call times have rounding errors.
        let slack = self.times.windows(2).next().map_or(0.0, |pair| 1e-6 * (pair[1] - pair[0]));
        let at = |time: &f64| self.switched.iter().rev().find(|(since, _)| *since <= time + slack);
        self.times[..calls].iter().map(|time| at(time).is_some_and(|(_, is_manual)| *is_manual)).collect()
    }

    /// The figures of the loop, or why none are available.
    pub(super) fn figures(&self) -> Result<Figures, String> {
        if self.signals.is_none() {
            return Err(self.why_none());
        }
        if self.rows > MOST_CALLS {
            return Err(format!("no figures: the run has more than {MOST_CALLS} steps; use plcfmu study"));
        }
        let travel_unit = self.travel_unit.as_deref();
        // The last row, at the end of the run, belongs to no call.
        let calls = self.times.len().saturating_sub(1);
        let pulses: Vec<Vec<bool>> = self.pulses.iter().map(|(_, values)| values[..calls].to_vec()).collect();
        let [setpoint, value, output] = self.values.each_ref().map(|values| &values[..calls.min(values.len())]);
        let signals = Signals {
            times: &self.times[..calls],
            setpoint,
            process_value: value,
            // The mean of pulses has no travel.
            manipulated_value: if pulses.is_empty() { output } else { &[] },
            pulses: &pulses,
            manual: &self.manual(calls),
            disturbances: &self.disturbances,
            // With parallel exchange, the first row has the outputs before the first call.
            first: usize::from(self.plan.exchange == Exchange::Parallel),
            is_cut: false,
            travel_unit,
        };
        let told = |window: &Window, figure: &'static Figure| {
            let value = figure.value(window);
            Told {
                key: figure.key,
                title: figure.title,
                unit: figure.unit.text(self.unit.as_deref(), travel_unit),
                value: value.as_ref().ok().copied(),
                why: value.err(),
            }
        };
        let all = |window: &Window| window.figures().map(|figure| told(window, figure)).collect();
        let of_event = |window: Window| {
            let happened = window.step_happened().or_else(|| window.disturbance_happened())?;
            Some(Of { happened, figures: all(&window) })
        };
        let events = Window::of_events(signals).into_iter().filter_map(of_event).collect();
        Ok(Figures { last: all(&Window::measure(signals, &Span::default())), events })
    }
}

impl Rows for Recorder<'_, '_> {
    fn are_wanted(&self) -> bool {
        // Without a CSV file and a plot, rows are needed only for the figures.
        self.csv.is_some() || self.kept.drawn.is_some() || self.kept.plan.steps <= MOST_CALLS
    }

    fn begin(&mut self, roles: Vec<Option<Roles>>) {
        let kept = &mut self.kept;
        kept.roles = roles.first().cloned().flatten().unwrap_or_default();
        let members = kept.system.members.iter().map(|member| member.name.as_str()).collect();
        if let Some(wiring) = Wiring::new(members, roles, &kept.system.connections) {
            let of = |member: &Member| Some((member.name.clone(), Package::open(&member.path).ok()?.description));
            let described: Vec<_> = kept.system.members.iter().filter_map(of).collect();
            let unit = |name: &str| {
                described.iter().find_map(|(member, description)| {
                    let own = own_name(name, member)?;
                    description.variables.iter().find(|variable| variable.name == own)?.unit.clone()
                })
            };
            kept.unit = wiring.unit_of_process_value(unit);
            let variables = described.first().map(|(_, description)| &description.variables);
            let of_switch = |of: &&Variable| kept.roles.manual_switch().is_some_and(|switch| *switch == of.name);
            kept.switched = match variables.and_then(|variables| variables.iter().find(of_switch)) {
                Some(switch) => kept.settings_of(switch),
                None => Vec::new(),
            };
            kept.travel_unit = wiring.unit_of_manipulated_value(unit);
            kept.disturbances = wiring.disturbances(std::mem::take(&mut kept.set));
        }
        let setpoint = kept.column(kept.roles.setpoint.as_ref());
        let process_value = kept.process_value();
        if setpoint.is_some() && process_value.is_some() && kept.plan.steps <= MOST_CALLS {
            kept.signals = Some([setpoint, process_value, kept.column(kept.roles.manipulated_value.as_ref())]);
            let pulses = kept.roles.pulses.iter().filter_map(|name| kept.column(Some(name)));
            kept.pulses = pulses.map(|column| (column, Vec::new())).collect();
            kept.manual = kept.column(kept.roles.manual_mode()).map(|column| (column, Vec::new()));
        }
    }

    fn take(&mut self, time: f64, cells: &[f64]) -> Result<()> {
        let kept = &mut self.kept;
        kept.cells.clear();
        kept.cells.extend_from_slice(cells);
        kept.last.clear();
        kept.last.extend_from_slice(cells);
        kept.plan.to_numbers(&mut kept.last);
        let row = &kept.last;
        if let Some(signals) = &kept.signals {
            kept.times.push(time);
            for (values, column) in kept.values.iter_mut().zip(signals) {
                values.extend(column.map(|column| row[column]));
            }
            for (column, values) in kept.pulses.iter_mut().chain(&mut kept.manual) {
                values.push(row[*column] != 0.0);
            }
        }
        kept.rows += 1;
        if (kept.rows - 1).is_multiple_of(kept.every) || kept.rows > kept.plan.steps {
            self.record(time, cells)?;
        }
        Ok(())
    }
}
