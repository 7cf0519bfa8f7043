//! What a study records of a run, and the figures that come of it.

use crate::experiment::traced;
use crate::results::Quantity;
use crate::{Limit, Signals, Study, Take};
use anyhow::{Context, Result, bail};
use control::figures::{self, Figure, Span, Window};
use run::component::Type;
use run::dialog::Roles;
use run::plan::{Names, Reference};
use run::system::System;

/// The figures of a study, and which variables they are of.
#[derive(Clone, Debug)]
pub(super) struct Measures {
    /// The variables, `FMU.VARIABLE`, each once: what a run has to record, in this order.
    pub columns: Vec<String>,
    /// What a row consists of.
    pub figures: Vec<Quantity>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// The names of the loop's signals, if it has a setpoint and a process value.
    pub signals: Signals,
    loop_signals: Option<Loop>,
    span: Span,
    values: Vec<(usize, Vec<Take>)>,
    limits: Vec<(usize, Limit)>,
}

/// The columns of a loop's signals.
#[derive(Clone, Debug)]
struct Loop {
    figures: Vec<&'static Figure>,
    setpoint: usize,
    process_value: usize,
    manipulated_value: Option<usize>,
    pulses: Vec<usize>,
}

/// What is kept of a run while it goes on. It is used for one run after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Traces {
    times: Vec<f64>,
    setpoint: Vec<f64>,
    process_value: Vec<f64>,
    manipulated_value: Vec<f64>,
    pulses: Vec<Vec<bool>>,
    values: Vec<Running>,
    /// How many steps each limit was violated in.
    violations: Vec<u64>,
    steps: u64,
}

impl Traces {
    /// The process value at the steps of a trace.
    pub fn process_values(&self) -> Vec<f64> {
        traced(self.process_value.len()).map(|step| self.process_value[step]).collect()
    }
}

/// Minimum, maximum and mean of a variable so far. Once one of them is not a number, nothing is.
#[derive(Clone, Copy, Debug)]
struct Running {
    min: f64,
    max: f64,
    sum: f64,
    last: f64,
}

impl Running {
    const NONE: Running = Running { min: f64::INFINITY, max: f64::NEG_INFINITY, sum: 0.0, last: f64::NAN };

    #[inline]
    fn push(&mut self, value: f64) {
        self.min = if value < self.min || value.is_nan() { value } else { self.min };
        self.max = if value > self.max || value.is_nan() { value } else { self.max };
        self.sum += value;
        self.last = value;
    }
}

impl Take {
    /// How a figure's name ends.
    fn name(self) -> &'static str {
        match self {
            Take::Min => "min",
            Take::Max => "max",
            Take::Mean => "mean",
            Take::Last => "last",
        }
    }
}

/// Adds variables to the columns, each once.
struct Columns<'a> {
    names: &'a Names<'a>,
    columns: Vec<String>,
}

impl<'a> Columns<'a> {
    fn add(&mut self, name: &str) -> Result<(usize, Reference<'a>)> {
        let reference = self.names.find(name)?;
        let name = self.names.full(&reference);
        let place = self.columns.iter().position(|other| *other == name).unwrap_or_else(|| {
            self.columns.push(name);
            self.columns.len() - 1
        });
        Ok((place, reference))
    }

    fn unit(&self, reference: &Reference<'a>) -> Option<String> {
        reference.variable.unit.clone()
    }
}

impl Measures {
    /// Resolves the figures of a study. `roles` are those of the first member, if it has any.
    ///
    /// # Errors
    /// Which signal, value or limit is wrong, and what to do; there is no figure at all.
    pub fn of(study: &Study, system: &System, names: &Names, roles: Option<&Roles>) -> Result<Measures> {
        let mut columns = Columns { names, columns: Vec::new() };
        let mut measures = Measures {
            columns: Vec::new(),
            figures: Vec::new(),
            warnings: Vec::new(),
            signals: Signals::default(),
            loop_signals: None,
            span: Span { from: study.window.from, to: study.window.to, ..Span::default() },
            values: Vec::new(),
            limits: Vec::new(),
        };
        measures.add_loop(study, system, &mut columns, roles).context("signals")?;
        measures.add_values(study, &mut columns).context("values")?;
        measures.add_limits(study, &mut columns).context("limits")?;
        if measures.figures.is_empty() {
            bail!(
                "there is no figure: name the loop's signals ([signals] with setpoint = \"FMU.VARIABLE\" and process_value = \
                 \"FMU.VARIABLE\"), or single variables ([[values]] with variable = \"FMU.VARIABLE\", take = [\"max\"])"
            );
        }
        measures.columns = columns.columns;
        Ok(measures)
    }

    /// Rise, overshoot and so on, as far as the loop has the signals.
    fn add_loop(&mut self, study: &Study, system: &System, columns: &mut Columns, roles: Option<&Roles>) -> Result<()> {
        let first = system.members.first().map_or("", |member| member.name.as_str());
        let signals = signals(&study.signals, first, roles);
        let (Some(setpoint), Some(process_value)) = (&signals.setpoint, &signals.process_value) else {
            let missing = if signals.setpoint.is_none() { "setpoint" } else { "process_value" };
            if study.signals != Signals::default() {
                bail!("{missing} is missing, and {first} does not say what it is: write {missing} = \"FMU.VARIABLE\"");
            }
            if !(study.values.is_empty() && study.limits.is_empty()) {
                self.warnings.push(format!(
                    "{first} does not name its {missing}, so there are no figures such as overshoot: name the loop's signals in \
                     [signals] for them"
                ));
            }
            return Ok(());
        };
        let (setpoint_column, setpoint_reference) = columns.add(setpoint).context("setpoint")?;
        let (process_column, process_reference) = columns.add(process_value).context("process_value")?;
        let unit = columns.unit(&process_reference);
        if let (Some(one), Some(other)) = (columns.unit(&setpoint_reference), &unit)
            && one != *other
        {
            self.warnings.push(format!(
                "signals: the setpoint {setpoint} is in {one}, the process value {process_value} in {other}: their numbers are \
                 compared as they are"
            ));
        }
        let manipulated_value = signals.manipulated_value.as_ref();
        let manipulated = manipulated_value.map(|name| columns.add(name).context("manipulated_value")).transpose()?;
        let travel_unit = manipulated.and_then(|(_, reference)| columns.unit(&reference));
        let pulse = |name: &String| {
            let (column, reference) = columns.add(name).context("pulses")?;
            if reference.kind != Type::Boolean {
                bail!("pulses: {name} is {}: name Boolean variables", reference.kind.name());
            }
            Ok(column)
        };
        let pulses = signals.pulses.iter().flatten().map(pulse).collect::<Result<Vec<_>>>()?;
        let figures: Vec<_> = figures::applicable(manipulated.is_some(), !pulses.is_empty()).collect();
        for figure in &figures {
            self.add_figure(figure.key, figure.unit.text(unit.as_deref(), travel_unit.as_deref()))?;
        }
        self.loop_signals = Some(Loop {
            figures,
            setpoint: setpoint_column,
            process_value: process_column,
            manipulated_value: manipulated.map(|(column, _)| column),
            pulses,
        });
        self.signals = signals;
        Ok(())
    }

    fn add_values(&mut self, study: &Study, columns: &mut Columns) -> Result<()> {
        for taken in &study.values {
            let (column, reference) = columns.add(&taken.variable)?;
            if taken.take.is_empty() {
                bail!("{}: take is empty: name some of min, max, mean and last", taken.variable);
            }
            for take in &taken.take {
                let unit = columns.unit(&reference);
                self.add_figure(&format!("{}.{}", columns.columns[column], take.name()), unit)?;
            }
            self.values.push((column, taken.take.clone()));
        }
        Ok(())
    }

    fn add_limits(&mut self, study: &Study, columns: &mut Columns) -> Result<()> {
        for limit in &study.limits {
            let (column, _) = columns.add(&limit.variable)?;
            self.add_figure(&format!("{}.violation", columns.columns[column]), Some("s".into()))?;
            self.limits.push((column, limit.clone()));
        }
        Ok(())
    }

    fn add_figure(&mut self, name: &str, unit: Option<String>) -> Result<()> {
        if self.figures.iter().any(|other| other.name == name) {
            bail!("the figure {name} occurs twice: remove one");
        }
        self.figures.push(Quantity { name: name.into(), unit });
        Ok(())
    }

    /// Begins a run.
    pub fn begin(&self, traces: &mut Traces) {
        for signal in
            [&mut traces.times, &mut traces.setpoint, &mut traces.process_value, &mut traces.manipulated_value]
        {
            signal.clear();
        }
        let pulses = self.loop_signals.as_ref().map_or(0, |signals| signals.pulses.len());
        traces.pulses.resize_with(pulses, Vec::new);
        traces.pulses.iter_mut().for_each(Vec::clear);
        traces.values.clear();
        traces.values.resize(self.values.len(), Running::NONE);
        traces.violations.clear();
        traces.violations.resize(self.limits.len(), 0);
        traces.steps = 0;
    }

    /// Takes in a step: when it began, and what it recorded.
    #[inline(always)]
    pub fn step(&self, traces: &mut Traces, time: f64, row: &[f64]) {
        if let Some(signals) = &self.loop_signals {
            traces.times.push(time);
            traces.setpoint.push(row[signals.setpoint]);
            traces.process_value.push(row[signals.process_value]);
            traces.manipulated_value.extend(signals.manipulated_value.map(|column| row[column]));
            for (pulse, column) in traces.pulses.iter_mut().zip(&signals.pulses) {
                pulse.push(row[*column] == 1.0);
            }
        }
        for (running, (column, _)) in traces.values.iter_mut().zip(&self.values) {
            running.push(row[*column]);
        }
        for (count, (column, limit)) in traces.violations.iter_mut().zip(&self.limits) {
            let value = row[*column];
            // What is not a number is not within limits.
            let is_within =
                !value.is_nan() && limit.min.is_none_or(|min| value >= min) && limit.max.is_none_or(|max| value <= max);
            *count += u64::from(!is_within);
        }
        traces.steps += 1;
    }

    /// The figures of a run whose steps took this many seconds each.
    pub fn end(&self, traces: &Traces, step: f64) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.figures.len());
        if let Some(signals) = &self.loop_signals {
            let borrowed = figures::Signals {
                times: &traces.times,
                setpoint: &traces.setpoint,
                process_value: &traces.process_value,
                manipulated_value: &traces.manipulated_value,
                pulses: &traces.pulses,
                ..figures::Signals::default()
            };
            let window = Window::of(borrowed, &self.span);
            all.extend(signals.figures.iter().map(|figure| figure.value(&window).unwrap_or(f64::NAN)));
        }
        for (running, (_, take)) in traces.values.iter().zip(&self.values) {
            all.extend(take.iter().map(|take| match take {
                Take::Min => running.min,
                Take::Max => running.max,
                Take::Mean => running.sum / traces.steps as f64,
                Take::Last => running.last,
            }));
        }
        all.extend(traces.violations.iter().map(|steps| *steps as f64 * step));
        // Platforms differ in the bits of what is not a number.
        all.iter_mut().filter(|figure| figure.is_nan()).for_each(|figure| *figure = f64::NAN);
        all
    }
}

/// The loop's signals: those that are given, else what the variables of the first member are.
fn signals(given: &Signals, first: &str, roles: Option<&Roles>) -> Signals {
    // The roles of a plant name what it takes and gives, not the signals of a loop.
    let Some(roles) = roles.filter(|roles| roles.setpoint.is_some()) else { return given.clone() };
    let full = |name: &String| format!("{first}.{name}");
    let either = |given: &Option<String>, role: &Option<String>| given.clone().or_else(|| role.as_ref().map(full));
    let process_value = roles.shown_process_value.clone().or_else(|| roles.process_value.clone());
    let pulses = || (!roles.pulses.is_empty()).then(|| roles.pulses.iter().map(full).collect());
    Signals {
        setpoint: either(&given.setpoint, &roles.setpoint),
        process_value: either(&given.process_value, &process_value),
        manipulated_value: either(&given.manipulated_value, &roles.manipulated_value),
        pulses: given.pulses.clone().or_else(pulses),
    }
}
