//! The variables that a study records in each run, and the figures computed from them.

use crate::experiment::traced;
use crate::results::{Aspect, Quantity};
use crate::{Limit, Signals, Study, Take, Taken};
use anyhow::{Context, Result, bail};
use control::figures::{self, Figure, LoopSignals, Set, Span, Window, Wiring};
use run::component::Type;
use run::dialog::Roles;
use run::plan::{Names, Plan, Reference};
use run::subject::About;
use run::system::{Exchange, System};

/// The figures of a study, and the variables from which they are computed.
#[derive(Clone, Debug)]
pub(super) struct Measures {
    /// The variables to record, `FMU.VARIABLE`, without duplicates, in the order of the columns.
    pub columns: Vec<String>,
    /// The figures in a row.
    pub figures: Vec<Quantity>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// The names of the loop's signals, if it has a setpoint and a process value.
    pub signals: Signals,
    /// The disturbances of the loop.
    pub disturbances: Vec<Set>,
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
    /// The column of the switch to manual mode, if the switch is connected or set during a run.
    manual: Option<usize>,
    /// The first step whose row contains the outputs of a call.
    first: usize,
}

/// The recording of a run, reused from run to run.
#[derive(Clone, Debug, Default)]
pub(super) struct Traces {
    /// The start times of the steps in seconds; after a shorter run, also those of the longest run so far.
    times: Vec<f64>,
    /// The recorded values, by column.
    pub columns: Vec<Vec<f64>>,
}

/// A buffer for the steps of several runs side by side: for each column, step by step, one value per run.
#[derive(Clone, Debug, Default)]
pub(super) struct Abreast(Vec<Vec<f64>>);

impl Abreast {
    /// Stores the values of one step in a column.
    #[inline]
    pub(crate) fn push(&mut self, column: usize, values: &[f64], traces: &mut [Traces]) {
        self.0[column].extend_from_slice(values);
        // Keep the buffer small enough for the processor's cache.
        if self.0[column].len() >= 512 {
            self.give(column, traces);
        }
    }

    /// Moves the buffered values of a column to the traces.
    fn give(&mut self, column: usize, traces: &mut [Traces]) {
        let count = traces.len();
        for (number, of) in traces.iter_mut().enumerate() {
            of.columns[column].extend(self.0[column].iter().skip(number).step_by(count));
        }
        self.0[column].clear();
    }

    /// Moves all buffered values to the traces.
    pub(crate) fn finish(&mut self, traces: &mut [Traces]) {
        (0..self.0.len()).for_each(|column| self.give(column, traces));
    }
}

impl Traces {
    /// Stores the values of one step.
    #[inline(always)]
    pub(crate) fn push(&mut self, row: &[f64]) {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value);
        }
    }
}

impl Take {
    /// The suffix of a figure's name.
    fn name(self) -> &'static str {
        match self {
            Take::Min => "min",
            Take::Max => "max",
            Take::Mean => "mean",
            Take::Last => "last",
        }
    }

    /// Computes this value from a variable's recorded values.
    fn apply(self, values: &[f64]) -> f64 {
        match self {
            Take::Min => extreme(values, f64::INFINITY, |value, least| value < least),
            Take::Max => extreme(values, f64::NEG_INFINITY, |value, greatest| value > greatest),
            Take::Mean => values.iter().fold(0.0, |sum, value| sum + value) / values.len() as f64,
            Take::Last => values.last().copied().unwrap_or(f64::NAN),
        }
    }
}

/// The value furthest in the direction of `is_beyond`; NaN if any value is NaN, `none` if there are no values.
fn extreme(values: &[f64], none: f64, is_beyond: impl Fn(f64, f64) -> bool) -> f64 {
    let further = |extreme, value| if is_beyond(value, extreme) || value.is_nan() { value } else { extreme };
    values.iter().copied().fold(none, further)
}

/// Collects the variables to record, without duplicates.
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
    /// Resolves the figures of a study. `roles` are the first member's roles, if it has any.
    ///
    /// # Errors
    /// A signal, value or limit is wrong, or there are no figures at all; the message names the remedy.
    pub(crate) fn new(study: &Study, system: &System, names: &Names, roles: Option<&Roles>) -> Result<Measures> {
        let mut columns = Columns { names, columns: Vec::new() };
        let mut measures = Measures {
            columns: Vec::new(),
            figures: Vec::new(),
            warnings: Vec::new(),
            signals: Signals::default(),
            disturbances: Vec::new(),
            loop_signals: None,
            span: Span { from: study.window.from, to: study.window.to, ..Span::default() },
            values: Vec::new(),
            limits: Vec::new(),
        };
        measures.add_loop(study, system, &mut columns, roles).context("signals").at("signals")?;
        for (number, taken) in study.values.iter().enumerate() {
            measures.add_value(taken, &mut columns).context("values").at(number).at("values")?;
        }
        for (number, limit) in study.limits.iter().enumerate() {
            measures.add_limit(limit, &mut columns).context("limits").at(number).at("limits")?;
        }
        if measures.figures.is_empty() {
            bail!(
                "the study has no figures: specify the loop's signals ([signals] with setpoint = \"FMU.VARIABLE\" and process_value = \
                 \"FMU.VARIABLE\"), or individual variables ([[values]] with variable = \"FMU.VARIABLE\", take = [\"max\"])"
            );
        }
        measures.columns = columns.columns;
        Ok(measures)
    }

    /// Adds the loop's figures, such as rise time and overshoot, if its setpoint and process value are known.
    fn add_loop(&mut self, study: &Study, system: &System, columns: &mut Columns, roles: Option<&Roles>) -> Result<()> {
        let first = system.members.first().map_or("", |member| member.name.as_str());
        let signals = signals(&study.signals, first, roles);
        let (Some(setpoint), Some(process_value)) = (&signals.setpoint, &signals.process_value) else {
            let missing = if signals.setpoint.is_none() { "setpoint" } else { "process_value" };
            if study.signals != Signals::default() {
                bail!("{missing} is missing, and {first} does not declare it: write {missing} = \"FMU.VARIABLE\"");
            }
            if !(study.values.is_empty() && study.limits.is_empty()) {
                self.warnings.push(format!(
                    "{first} does not name its {missing}, so there are no figures such as overshoot: to get them, name the \
                     loop's signals in [signals]"
                ));
            }
            return Ok(());
        };
        let (setpoint_column, setpoint_reference) = columns.add(setpoint).context("setpoint")?;
        let (process_column, process_reference) = columns.add(process_value).context("process_value")?;
        let wiring = Wiring {
            setpoint: setpoint.clone(),
            members: system.members.iter().map(|member| member.name.as_str()).collect(),
            roles: vec![roles.cloned()],
            connections: system.connections.iter().map(|of| (of.from.as_str(), of.to.as_str())).collect(),
        };
        let known = |name: &str| columns.names.find(name).ok()?.variable.unit.clone();
        let unit = columns.unit(&process_reference);
        if let (Some(one), Some(other)) = (columns.unit(&setpoint_reference), &unit)
            && one != *other
        {
            self.warnings.push(format!(
                "signals: the setpoint {setpoint} is in {one}, the process value {process_value} in {other}: their \
                 numbers are compared without conversion"
            ));
        }
        let unit = unit.or_else(|| wiring.unit_of_process_value(known));
        let at_times = study.axes.iter().filter_map(|axis| Some((axis.time?, &axis.variables)));
        let varied = at_times.flat_map(|(time, variables)| {
            variables.iter().map(move |variable| Set { time, variable: variable.clone(), ..Set::default() })
        });
        let set: Vec<Set> = Set::of_settings(&system.settings).into_iter().chain(varied).collect();
        let switch = roles.and_then(|roles| Some(format!("{first}.{}", roles.manual.as_ref()?.0)));
        let is_connected = |name: &String| wiring.connections.iter().any(|(_, to)| to == name);
        let switch = switch.filter(|name| set.iter().any(|of| of.variable == *name) || is_connected(name));
        self.disturbances = wiring.disturbances(set);
        let manual = switch.map(|name| columns.add(&name)).transpose()?;
        let manipulated_value = signals.manipulated_value.as_ref();
        let manipulated = manipulated_value.map(|name| columns.add(name).context("manipulated_value")).transpose()?;
        let travel_unit = manipulated.and_then(|(_, reference)| columns.unit(&reference));
        let pulse = |name: &String| {
            let (column, reference) = columns.add(name).context("pulses")?;
            if reference.kind != Type::Boolean {
                bail!("pulses: {name} is {}: only Boolean variables can be pulses", reference.kind.name());
            }
            Ok(column)
        };
        let pulses = signals.pulses.iter().flatten().map(pulse).collect::<Result<Vec<_>>>()?;
        let figures: Vec<_> = figures::applicable(LoopSignals {
            // With pulses, the manipulated value is their mean, which counts as travel only if the user named it.
            manipulated_value: manipulated.is_some()
                && (pulses.is_empty() || study.signals.manipulated_value.is_some()),
            pulses: !pulses.is_empty(),
            disturbance: !self.disturbances.is_empty(),
        })
        .collect();
        for figure in &figures {
            let unit = figure.unit.text(unit.as_deref(), travel_unit.as_deref());
            self.add_figure(Quantity { name: figure.key.into(), unit, of: None })?;
        }
        self.loop_signals = Some(Loop {
            figures,
            setpoint: setpoint_column,
            process_value: process_column,
            manipulated_value: manipulated.map(|(column, _)| column),
            pulses,
            manual: manual.map(|(column, _)| column),
            // With parallel exchange, the first row contains the outputs before the first call.
            first: usize::from(system.exchange == Exchange::Parallel),
        });
        self.signals = signals;
        Ok(())
    }

    fn add_value(&mut self, taken: &Taken, columns: &mut Columns) -> Result<()> {
        let (column, reference) = columns.add(&taken.variable)?;
        if taken.take.is_empty() {
            bail!("{}: `take` is empty: list one or more of min, max, mean and last", taken.variable);
        }
        for take in &taken.take {
            let (variable, unit) = (columns.columns[column].clone(), columns.unit(&reference));
            let name = format!("{variable}.{}", take.name());
            self.add_figure(Quantity { name, unit, of: Some((variable, Aspect::Taken(*take))) })?;
        }
        self.values.push((column, taken.take.clone()));
        Ok(())
    }

    fn add_limit(&mut self, limit: &Limit, columns: &mut Columns) -> Result<()> {
        let (column, _) = columns.add(&limit.variable)?;
        let variable = columns.columns[column].clone();
        let name = format!("{variable}.violation");
        self.add_figure(Quantity { name, unit: Some("s".into()), of: Some((variable, Aspect::Violation)) })?;
        self.limits.push((column, limit.clone()));
        Ok(())
    }

    fn add_figure(&mut self, figure: Quantity) -> Result<()> {
        if self.figures.iter().any(|other| other.name == figure.name) {
            bail!("the figure {} occurs twice: remove one", figure.name);
        }
        self.figures.push(figure);
        Ok(())
    }

    /// A buffer for runs side by side.
    pub(crate) fn abreast(&self) -> Abreast {
        Abreast(vec![Vec::new(); self.columns.len()])
    }

    /// Empties the traces before a run.
    pub(crate) fn begin(&self, traces: &mut Traces) {
        traces.columns.resize_with(self.columns.len(), Vec::new);
        traces.columns.iter_mut().for_each(Vec::clear);
    }

    /// The process value of a run at the steps of a trace.
    pub(crate) fn process_values(&self, traces: &Traces) -> Vec<f64> {
        let column = self.loop_signals.as_ref().map(|signals| &traces.columns[signals.process_value]);
        traced(column.map_or(0, Vec::len)).filter_map(|step| Some(column?[step])).collect()
    }

    /// Computes the figures of a run with this plan.
    pub(crate) fn end(&self, traces: &mut Traces, plan: &Plan) -> Vec<f64> {
        let Traces { times, columns } = traces;
        let steps = columns.first().map_or(0, Vec::len);
        times.extend((times.len()..steps).map(|step| plan.time(step)));
        let mut all = Vec::with_capacity(self.figures.len());
        if let Some(signals) = &self.loop_signals {
            let switched = |column: &usize| columns[*column].iter().map(|value| *value == 1.0).collect();
            let pulses: Vec<Vec<bool>> = signals.pulses.iter().map(switched).collect();
            let manual: Vec<bool> = signals.manual.as_ref().map_or_else(Vec::new, switched);
            let borrowed = figures::Signals {
                times: &times[..steps],
                setpoint: &columns[signals.setpoint],
                process_value: &columns[signals.process_value],
                manipulated_value: signals.manipulated_value.map_or(&[], |column| &columns[column]),
                pulses: &pulses,
                manual: &manual,
                disturbances: &self.disturbances,
                first: signals.first,
                ..figures::Signals::default()
            };
            let window = Window::measure(borrowed, &self.span);
            all.extend(signals.figures.iter().map(|figure| figure.value(&window).unwrap_or(f64::NAN)));
        }
        for (column, take) in &self.values {
            all.extend(take.iter().map(|take| take.apply(&columns[*column])));
        }
        for (column, limit) in &self.limits {
            // NaN is not within limits.
            let within = limit.min.unwrap_or(f64::NEG_INFINITY)..=limit.max.unwrap_or(f64::INFINITY);
            let outside = columns[*column].iter().filter(|value| !within.contains(value)).count();
            all.push(outside as f64 * plan.step);
        }
        // Platforms differ in the bits of a computed NaN.
        all.iter_mut().filter(|figure| figure.is_nan()).for_each(|figure| *figure = f64::NAN);
        all
    }
}

/// The loop's signals: those given, else those according to the first member's roles.
fn signals(given: &Signals, first: &str, roles: Option<&Roles>) -> Signals {
    // Without a setpoint, the first member is a plant, whose roles are not the signals of a loop.
    let Some(roles) = roles.filter(|roles| roles.setpoint.is_some()) else { return given.clone() };
    let full = |name: &String| format!("{first}.{name}");
    let either = |given: &Option<String>, role: Option<&String>| given.clone().or_else(|| role.map(full));
    let [setpoint, process_value, manipulated_value] = roles.signals();
    let pulses = || (!roles.pulses.is_empty()).then(|| roles.pulses.iter().map(full).collect());
    Signals {
        setpoint: either(&given.setpoint, setpoint),
        process_value: either(&given.process_value, process_value),
        manipulated_value: either(&given.manipulated_value, manipulated_value),
        pulses: given.pulses.clone().or_else(pulses),
    }
}
