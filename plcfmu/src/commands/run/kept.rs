//! What `plcfmu run` does with the rows of a run: it writes them, keeps what is drawn within bounds, and the signals of the figures.

use anyhow::{Context, Result};
use control::figures::{Signals, Span, Window};
use host::child::run::Rows;
use run::dialog::Roles;
use run::master::write_row;
use run::plan::Plan;
use run::trace::Trace;
use serde::Serialize;
use std::io::{ErrorKind, Write};

/// The figures of longer runs are those of a study: here they would fill the memory.
const MOST_CALLS: usize = 2_000_000;

/// A drawing has at most this many points: each two of them are the extremes of a part of the run.
const POINTS: usize = 8192;

/// Writes the recording while the run goes on, and keeps what is needed at its end.
pub struct Recorder<'a, 'w> {
    kept: Kept<'a>,
    /// The recording as CSV, if it is wanted.
    csv: Option<&'w mut dyn Write>,
    /// Whether nobody reads the CSV any more.
    is_closed: bool,
}

/// What is kept of the rows.
pub struct Kept<'a> {
    plan: &'a Plan,
    /// Of this many rows one is recorded.
    every: usize,
    /// The recorded rows, for a drawing.
    drawn: Option<Trace>,
    /// What the variables of the first FMU are in a loop.
    pub roles: Roles,
    /// Where the signals of the figures are: setpoint, process value, manipulated value.
    signals: Option<[Option<usize>; 3]>,
    times: Vec<f64>,
    values: [Vec<f64>; 3],
    pulses: Vec<(usize, Vec<bool>)>,
    /// How many rows there were.
    pub rows: usize,
    /// How many were recorded.
    pub recorded: usize,
    /// The last row.
    pub last: Vec<f64>,
}

/// A figure, as `--json` prints it.
#[derive(Debug, Serialize)]
pub struct Told {
    /// Its key.
    pub key: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Its value; without one, `why` says why.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
    /// Why it has no value.
    pub why: Option<String>,
}

impl<'a, 'w> Recorder<'a, 'w> {
    /// For the rows of a plan: one of `every` rows is written to `csv` and drawn.
    pub fn new(plan: &'a Plan, csv: Option<&'w mut dyn Write>, every: usize, is_drawn: bool) -> Recorder<'a, 'w> {
        let kept = Kept {
            plan,
            every,
            drawn: is_drawn.then(|| Trace::new(plan.columns.len())),
            roles: Roles::default(),
            signals: None,
            times: Vec::new(),
            values: Default::default(),
            pulses: Vec::new(),
            rows: 0,
            recorded: 0,
            last: Vec::new(),
        };
        Recorder { kept, csv, is_closed: false }
    }

    /// After the last row. A run that an FMU has ended may end between two rows that are recorded.
    ///
    /// # Errors
    /// The row of the end cannot be written.
    pub fn finish(mut self) -> Result<Kept<'a>> {
        let Kept { plan, rows, every, .. } = self.kept;
        if rows > 0 && !(rows - 1).is_multiple_of(every) && rows <= plan.steps {
            let row = self.kept.last.clone();
            self.record(plan.time(rows - 1), &row)?;
        }
        Ok(self.kept)
    }

    /// Writes a row, and keeps it for a drawing.
    fn record(&mut self, time: f64, row: &[f64]) -> Result<()> {
        self.kept.recorded += 1;
        if let Some(trace) = &mut self.kept.drawn {
            trace.push(row);
        }
        let Some(csv) = self.csv.as_mut().filter(|_| !self.is_closed) else { return Ok(()) };
        match write_row(*csv, self.kept.plan.columns.iter(), time, row.iter().copied()) {
            // Whoever reads may stop when it has enough, as `head` does.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => self.is_closed = true,
            written => written.context("the recording")?,
        }
        Ok(())
    }
}

impl Kept<'_> {
    /// The column of a variable of the first FMU, if it is recorded.
    pub fn column(&self, variable: Option<&String>) -> Option<usize> {
        let name = format!("{}.{}", self.plan.members[0].name, variable?);
        self.plan.columns.iter().position(|column| column.name == name)
    }

    /// The process value that is compared with the setpoint.
    pub fn process_value(&self) -> Option<usize> {
        self.column(self.roles.shown_process_value.as_ref()).or_else(|| self.column(self.roles.process_value.as_ref()))
    }

    /// The times and the curves of all columns that are drawn.
    pub fn curves(&self) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let trace = self.drawn.as_ref()?;
        // The last row is that of the end.
        let time = |call: usize| self.plan.time((call * self.every).min(self.rows - 1));
        let columns: Vec<usize> = (0..self.plan.columns.len()).collect();
        let curves = trace.curves(&columns, 0..trace.calls(), POINTS);
        Some((curves.calls.into_iter().map(time).collect(), curves.values))
    }

    /// The figures of the loop; the reason in a sentence if there are none.
    pub fn figures(&self) -> Result<Vec<Told>, String> {
        let Some([_, process_value, manipulated_value]) = self.signals else {
            return Err("no figures: setpoint and process value of the first FMU are not recorded".into());
        };
        if self.rows > MOST_CALLS {
            return Err(format!("no figures: the run has more than {MOST_CALLS} steps, plcfmu study has them"));
        }
        let unit = |column: Option<usize>| column.and_then(|at| self.plan.columns[at].unit.as_deref());
        // At the end there is no call.
        let calls = self.times.len().saturating_sub(1);
        let pulses: Vec<Vec<bool>> = self.pulses.iter().map(|(_, values)| values[..calls].to_vec()).collect();
        let [setpoint, value, output] = self.values.each_ref().map(|values| &values[..calls.min(values.len())]);
        let signals = Signals {
            times: &self.times[..calls],
            setpoint,
            process_value: value,
            manipulated_value: output,
            pulses: &pulses,
            travel_unit: unit(manipulated_value),
            ..Signals::default()
        };
        let window = Window::of(signals, &Span::default());
        let told = window.figures().map(|figure| {
            let value = figure.value(&window);
            Told {
                key: figure.key,
                title: figure.title,
                unit: figure.unit.text(unit(process_value), unit(manipulated_value)),
                value: value.as_ref().ok().copied(),
                why: value.err(),
            }
        });
        Ok(told.collect())
    }
}

impl Rows for Recorder<'_, '_> {
    fn are_wanted(&self) -> bool {
        // Without outputs, the signals of the figures alone are kept.
        self.csv.is_some() || self.kept.drawn.is_some() || self.kept.plan.steps <= MOST_CALLS
    }

    fn begin(&mut self, roles: Option<Roles>) {
        let kept = &mut self.kept;
        kept.roles = roles.unwrap_or_default();
        let setpoint = kept.column(kept.roles.setpoint.as_ref());
        let process_value = kept.process_value();
        if setpoint.is_some() && process_value.is_some() && kept.plan.steps <= MOST_CALLS {
            kept.signals = Some([setpoint, process_value, kept.column(kept.roles.manipulated_value.as_ref())]);
            let pulses = kept.roles.pulses.iter().filter_map(|name| kept.column(Some(name)));
            kept.pulses = pulses.map(|column| (column, Vec::new())).collect();
        }
    }

    fn take(&mut self, time: f64, row: &[f64]) -> Result<()> {
        let kept = &mut self.kept;
        if let Some(signals) = &kept.signals {
            kept.times.push(time);
            for (values, column) in kept.values.iter_mut().zip(signals) {
                values.extend(column.map(|column| row[column]));
            }
            for (column, values) in &mut kept.pulses {
                values.push(row[*column] != 0.0);
            }
        }
        kept.last.clear();
        kept.last.extend_from_slice(row);
        kept.rows += 1;
        if (kept.rows - 1).is_multiple_of(kept.every) || kept.rows > kept.plan.steps {
            self.record(time, row)?;
        }
        Ok(())
    }
}
