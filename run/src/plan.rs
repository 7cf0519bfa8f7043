//! Resolves and checks the names in a system. The result contains, by position, everything that
//! [`run`](crate::master::run) needs in each step.

use crate::bail_at;
use crate::component::Type;
use crate::subject::Subject;
use crate::system::{Connection, EXACT, Exchange, FilePosition, Recorded, Setting, System, Value, own_name};
use anyhow::{Context, Result, bail};
use modeldescription::{Causality, Description, Variability, Variable};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// The tolerance for rounding, as a fraction of a step, by which the last step may exceed the end of the run, or the
/// time of a setting its communication point.
pub const ROUNDING: f64 = 1e-6;

/// The maximum number of decimals of start and step for which times are computed from integers.
const MOST_DECIMALS: i32 = 9;

/// Whether an FMU has Event Mode.
pub fn has_events(description: &Description) -> bool {
    description.co_simulation.as_ref().is_some_and(|support| support.can("hasEventMode"))
}

/// The plan of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The start in seconds.
    pub start: f64,
    /// The communication step in seconds.
    pub step: f64,
    /// The member that proposes the step; `None` if the system specifies it.
    pub step_proposed_by: Option<usize>,
    /// Start and step as integers; `None` if they have too many digits.
    pub scale: Option<Scaled>,
    /// The number of steps.
    pub steps: usize,
    /// The order in which values are exchanged.
    pub exchange: Exchange,
    /// The plan of each FMU, in the order of the system's members.
    pub members: Vec<MemberPlan>,
    /// The recorded columns.
    pub columns: Vec<Column>,
    /// Warnings for the user: values outside the range that an FMU declares.
    pub warnings: Vec<String>,
}

/// Start and step as integers, precomputed so that computing a time takes few instructions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled {
    /// The power of ten that converts them to integers.
    scale: f64,
    start: f64,
    step: f64,
}

/// The plan of one FMU.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemberPlan {
    /// Its name.
    pub name: String,
    /// Whether it is called in Event Mode.
    pub has_events: bool,
    /// Assignments before Initialization Mode.
    pub parameters: Vec<Assignment>,
    /// Assignments in Initialization Mode.
    pub inputs: Vec<Assignment>,
    /// Assignments at later times in seconds, in ascending order.
    pub events: Vec<(f64, Assignment)>,
    /// The connected inputs.
    pub connected: TypedBatch,
    /// The sources of these inputs: the member, and the position in its `observed`.
    pub sources: Vec<(usize, usize)>,
    /// The connected outputs.
    pub outputs: TypedBatch,
    /// The positions of these outputs in `observed`.
    pub output_places: Vec<usize>,
    /// The variables read after each step: connected outputs and recorded variables.
    pub observed: TypedBatch,
}

/// A variable and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assignment {
    /// The variable's type.
    pub kind: Type,
    /// The variable's value reference.
    pub reference: u32,
    /// The value; true is 1.
    pub value: f64,
}

/// Variables of one FMU grouped by type, so that one call reads or writes all of a type.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TypedBatch {
    /// The value references, grouped in the order of `Type::ALL`.
    pub references: Vec<u32>,
    /// The number of variables of each type.
    pub counts: [usize; Type::ALL.len()],
}

impl TypedBatch {
    /// Groups variables and removes duplicates.
    fn new(variables: impl IntoIterator<Item = (Type, u32)>) -> TypedBatch {
        let mut variables: Vec<_> = variables.into_iter().collect();
        variables.sort_unstable();
        variables.dedup();
        let count = |kind| variables.iter().filter(|(of, _)| *of == kind).count();
        TypedBatch {
            counts: Type::ALL.map(count),
            references: variables.iter().map(|(_, reference)| *reference).collect(),
        }
    }

    /// Iterates over the variables in order.
    fn variables(&self) -> impl Iterator<Item = (Type, u32)> {
        let kinds = Type::ALL.iter().zip(self.counts).flat_map(|(kind, count)| std::iter::repeat_n(*kind, count));
        kinds.zip(self.references.iter().copied())
    }

    /// The type of the variable at a position.
    pub fn kind(&self, place: usize) -> Type {
        self.groups().find(|(_, range)| range.contains(&place)).map_or(Type::Real, |(kind, _)| kind)
    }

    /// The position of a variable, which must exist.
    fn place(&self, variable: (Type, u32)) -> usize {
        self.variables().take_while(|other| *other != variable).count()
    }

    /// The types in use, each with the range of its variables.
    #[inline]
    pub fn groups(&self) -> impl Iterator<Item = (Type, std::ops::Range<usize>)> {
        let mut end = 0;
        let ranges = Type::ALL.iter().zip(&self.counts).map(move |(kind, count)| {
            end += count;
            (*kind, end - count..end)
        });
        ranges.filter(|(_, range)| !range.is_empty())
    }
}

/// A recorded variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Column {
    /// `FMU.VARIABLE`
    pub name: String,
    /// The unit of its values, if the FMU declares one.
    pub unit: Option<String>,
    /// The type that determines how its values are written.
    pub kind: Type,
    /// Whether it is an input.
    pub is_input: bool,
    /// The member, and the position in its `observed`.
    pub source: (usize, usize),
    /// Whether its value from before the step is recorded, since the FMUs that read it receive that value.
    pub is_before_step: bool,
    /// Whether it is computed by an FMU without connected outputs and without Event Mode. A row that shows a call then
    /// has the value produced by the call, and a row that shows a point in time has the value at that time.
    pub is_unread: bool,
}

/// A connection with resolved ends: member and variable.
pub struct Wire<'a> {
    /// The output.
    pub from: Reference<'a>,
    /// The input.
    pub to: Reference<'a>,
}

/// A variable of a member.
#[derive(Clone, Copy)]
pub struct Reference<'a> {
    /// The index of the member.
    pub member: usize,
    /// Its variable.
    pub variable: &'a Variable,
    /// The type by which it is read and written.
    pub kind: Type,
}

impl Wire<'_> {
    /// Whether it ends at this variable. Two names with the same value reference are the same input.
    pub fn is_to(&self, reference: &Reference) -> bool {
        self.to.member == reference.member && self.to.key() == reference.key()
    }
}

impl Reference<'_> {
    fn key(&self) -> (Type, u32) {
        (self.kind, self.variable.value_reference)
    }

    fn is(&self, other: &Reference) -> bool {
        self.member == other.member && self.variable.name == other.variable.name
    }
}

impl Plan {
    /// Resolves the names of a system; `descriptions` describes its members, in order.
    ///
    /// # Errors
    /// A name, value, connection or time is wrong; the message states the remedy.
    pub fn new(system: &System, descriptions: &[&Description]) -> Result<Plan> {
        let names = Names::new(system, descriptions)?;
        let wires = wires(&names, &system.connections)?;
        let effective = effective(&names, &system.settings, &wires)?;
        let (start, (step, step_proposed_by), steps) = times(system, descriptions, &effective)?;
        let mut plan = Plan {
            start,
            step,
            step_proposed_by,
            scale: scale(start, step),
            steps,
            exchange: system.exchange,
            members: system
                .members
                .iter()
                .zip(descriptions)
                .map(|(of, description)| {
                    let has_events = !system.no_events && has_events(description);
                    MemberPlan { name: of.name.clone(), has_events, ..Default::default() }
                })
                .collect(),
            columns: Vec::new(),
            warnings: Vec::new(),
        };
        let set = plan.set(&names, &effective, &wires)?;
        let recorded = recorded(&names, &system.record, &wires, &set)?;
        for (member, of) in plan.members.iter_mut().enumerate() {
            let from = wires.iter().filter(|wire| wire.from.member == member).map(|wire| wire.from.key());
            let shown = recorded.iter().filter(|reference| reference.member == member).map(Reference::key);
            of.observed = TypedBatch::new(from.clone().chain(shown));
            of.outputs = TypedBatch::new(from);
            of.output_places = of.outputs.variables().map(|output| of.observed.place(output)).collect();
            of.connected =
                TypedBatch::new(wires.iter().filter(|wire| wire.to.member == member).map(|wire| wire.to.key()));
        }
        plan.connect(&wires)?;
        plan.columns = recorded.iter().map(|reference| plan.column(&names, reference, &wires)).collect();
        Ok(plan)
    }

    /// The columns whose cells ([`Type::cell`]) are not numbers, with their types.
    pub(crate) fn wide(&self) -> Vec<(usize, Type)> {
        self.columns.iter().map(|column| column.kind).enumerate().filter(|(_, kind)| kind.is_wide()).collect()
    }

    /// Converts a row from the cells defined by [`Type::cell`] to numbers.
    pub fn to_numbers(&self, row: &mut [f64]) {
        for (value, column) in row.iter_mut().zip(&self.columns) {
            *value = column.kind.number(*value);
        }
    }

    /// The time of a communication point in seconds, computed without accumulating errors. Unless start or step have
    /// too many digits, it is the double nearest to the decimal value: 599.8 for 2999 steps of 0.2.
    #[inline]
    pub fn time(&self, step: usize) -> f64 {
        scaled_time(self.start, self.step, self.scale, step)
    }

    /// The source of a column's value, if the column is a connected input: the member, and the position in its
    /// `observed`.
    pub fn source_of(&self, column: &Column) -> Option<(usize, usize)> {
        let own = &self.members[column.source.0];
        let input = own.observed.variables().nth(column.source.1).filter(|_| column.is_input)?;
        own.connected.variables().zip(&own.sources).find(|(to, _)| *to == input).map(|(_, from)| *from)
    }

    /// Adds the settings to the members' plans, by time, and returns the inputs set by the user.
    fn set<'a>(
        &mut self,
        names: &Names<'a>,
        effective: &[(&Setting, Reference<'a>)],
        wires: &[Wire],
    ) -> Result<Vec<Reference<'a>>> {
        let mut inputs = Vec::new();
        let mut set_before = HashSet::with_capacity(effective.len());
        for (setting, reference) in effective {
            // Adding 0 turns -0 into 0, which is the same time.
            let time = setting.time.map(|time| (time + 0.0).to_bits());
            let is_first = set_before.insert((reference.member, reference.variable.name.as_str(), time));
            let mut set = || {
                if !is_first {
                    bail!("{} is set twice at the same time: remove one of the settings", setting.variable);
                }
                self.set_one(names, setting, reference, wires)
            };
            located(setting.place.as_ref(), set())?;
            if reference.variable.causality == Causality::Input && !setting.is_preliminary {
                inputs.push(*reference);
            }
        }
        for member in &mut self.members {
            member.events.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        }
        Ok(inputs)
    }

    fn set_one(&mut self, names: &Names, setting: &Setting, reference: &Reference, wires: &[Wire]) -> Result<()> {
        let (name, variable) = (&setting.variable, reference.variable);
        let (assignment, warning) = assignment(names, name, setting.value, reference, wires)?;
        self.warnings.extend(warning);
        let is_input = variable.causality == Causality::Input;
        let member = &mut self.members[reference.member];
        match setting.time {
            None if is_input => member.inputs.push(assignment),
            None => member.parameters.push(assignment),
            Some(time) => {
                if !is_input && variable.variability != Variability::Tunable {
                    bail_at!(
                        "time",
                        "{name} cannot be set at {time:?} s: it is a {} parameter; during a run, only inputs and \
                         tunable parameters can be set",
                        variable.variability
                    );
                }
                let last = self.start + (self.steps - 1) as f64 * self.step;
                if time < self.start || time > last + ROUNDING * self.step {
                    bail_at!(
                        "time",
                        "{name} cannot be set at {time:?} s: the first step begins at {:?} s, the last at {last:?} s",
                        self.start
                    );
                }
                member.events.push((time, assignment));
            }
        }
        Ok(())
    }

    /// Resolves the source of each connected input.
    fn connect(&mut self, wires: &[Wire]) -> Result<()> {
        for member in 0..self.members.len() {
            let inputs: Vec<_> = self.members[member].connected.variables().collect();
            for input in inputs {
                let wire = wires.iter().find(|wire| wire.to.member == member && wire.to.key() == input);
                let from = wire.context("a connected input has a connection")?.from;
                let place = self.members[from.member].observed.place(from.key());
                self.members[member].sources.push((from.member, place));
            }
        }
        Ok(())
    }

    fn column(&self, names: &Names, reference: &Reference, wires: &[Wire]) -> Column {
        let causality = reference.variable.causality;
        let is_shown_before = |wire: &Wire| self.exchange == Exchange::Parallel || wire.to.member <= wire.from.member;
        let own: Vec<&Wire> = wires.iter().filter(|wire| wire.from.is(reference)).collect();
        let all: Vec<&Wire> = wires.iter().filter(|wire| wire.from.member == reference.member).collect();
        let readers = if own.is_empty() { all } else { own };
        let is_set = matches!(causality, Causality::Input | Causality::Parameter);
        // In Event Mode, values are exchanged at the communication point, regardless of which FMU reads them.
        let has_events = self.members[reference.member].has_events;
        let is_unread = !is_set && !has_events && readers.is_empty();
        Column {
            name: names.full(reference),
            unit: reference.variable.unit.clone(),
            kind: reference.kind,
            is_input: causality == Causality::Input,
            source: (reference.member, self.members[reference.member].observed.place(reference.key())),
            is_before_step: !is_set && !is_unread && (has_events || readers.into_iter().all(is_shown_before)),
            is_unread,
        }
    }
}

/// The start, the communication step and the member that proposes it, and the number of steps.
fn times(
    system: &System,
    descriptions: &[&Description],
    settings: &[(&Setting, Reference)],
) -> Result<(f64, (f64, Option<usize>), usize)> {
    let experiments = || descriptions.iter().filter_map(|description| description.default_experiment);
    let start = system.start.or_else(|| experiments().filter_map(|of| of.start_time).reduce(f64::min)).unwrap_or(0.0);
    let steps = descriptions.iter().enumerate().map(|(member, of)| {
        let cycle = of.cycle().and_then(|cycle| {
            let is_it = |other: &Reference| other.member == member && other.variable.name == cycle.name;
            settings.iter().rfind(|(setting, other)| setting.time.is_none() && is_it(other))
        });
        match cycle.map(|(setting, _)| setting.value) {
            Some(Value::Number(cycle)) if cycle > 0.0 => Some(cycle),
            _ => of.default_experiment.and_then(|experiment| experiment.step_size),
        }
    });
    let proposed = steps.enumerate().filter_map(|(member, step)| Some((step?, Some(member))));
    let proposed = proposed.min_by(|(a, _), (b, _)| a.total_cmp(b));
    let step = system.step.map(|step| (step, None)).or(proposed);
    let (step, proposed_by) = step.context("no FMU proposes a communication step: specify one, such as step = 0.1")?;
    let stop = system.stop.or_else(|| experiments().filter_map(|of| of.stop_time).reduce(f64::max));
    let stop = stop.context("no FMU proposes a stop time: specify one, such as stop = 60")?;
    if !(step > 0.0 && step.is_finite()) {
        bail_at!("step", "the communication step is {step:?} s: it must be positive and finite");
    }
    if !start.is_finite() || !stop.is_finite() {
        bail!("start {start:?} s, stop {stop:?} s: both must be finite");
    }
    let steps = ((stop - start) / step + ROUNDING).floor();
    if steps < 1.0 {
        bail_at!(
            if system.stop.is_some() { "stop" } else { "start" },
            "the run from {start:?} s to {stop:?} s is shorter than one communication step of {step:?} s"
        );
    }
    if steps > 1e12 || start + step == start || stop - step == stop {
        bail_at!("step", "a communication step of {step:?} s is too small for a run from {start:?} s to {stop:?} s");
    }
    Ok((start, (step, proposed_by), steps as usize))
}

/// The time after a number of steps, in seconds, as in [`Plan::time`].
pub fn time(start: f64, step: f64, steps: usize) -> f64 {
    scaled_time(start, step, scale(start, step), steps)
}

#[inline]
fn scaled_time(start: f64, step: f64, scale: Option<Scaled>, steps: usize) -> f64 {
    match scale {
        Some(Scaled { scale, start, step }) => (start + steps as f64 * step) / scale,
        None => start + steps as f64 * step,
    }
}

/// Scales both values by the smallest power of ten that converts them to integers.
fn scale(start: f64, step: f64) -> Option<Scaled> {
    let is_exact = |value: f64, scale: f64| (value * scale).round() / scale == value && (value * scale).abs() < 1e15;
    (0..=MOST_DECIMALS)
        .map(|decimals| 10f64.powi(decimals))
        .find(|scale| is_exact(start, *scale) && is_exact(step, *scale))
        .map(|scale| Scaled { scale, start: (start * scale).round(), step: (step * scale).round() })
}

/// The settings that apply, with their variables. A preliminary setting does not apply if its variable is connected or
/// has another setting for the start.
pub fn effective<'a, 's>(
    names: &Names<'a>,
    settings: &'s [Setting],
    wires: &[Wire],
) -> Result<Vec<(&'s Setting, Reference<'a>)>> {
    let mut effective = Vec::with_capacity(settings.len());
    for setting in settings {
        let found = located(setting.place.as_ref(), names.find_all(&setting.variable))?;
        effective.extend(found.into_iter().map(|reference| (setting, reference)));
    }
    let firm: Vec<_> = effective.iter().filter(|(of, _)| !of.is_preliminary && of.time.is_none()).copied().collect();
    effective.retain(|(setting, reference)| {
        let is_overridden = || firm.iter().any(|(_, other)| other.is(reference));
        !setting.is_preliminary || !(is_overridden() || wires.iter().any(|wire| wire.is_to(reference)))
    });
    Ok(effective)
}

/// Adds the location in a file to an error.
fn located<T>(place: Option<&FilePosition>, result: Result<T>) -> Result<T> {
    match place {
        Some(place) => result.map_err(|error| Subject::Outside.attach(error.context(place.to_string()))),
        None => result,
    }
}

/// Resolves the ends of connections.
///
/// # Errors
/// An end does not exist or does not match the other.
pub fn wires<'a>(names: &Names<'a>, connections: &[Connection]) -> Result<Vec<Wire<'a>>> {
    let mut wires: Vec<Wire> = Vec::new();
    for connection in connections {
        let mut add = || {
            let both = ends(names, connection)
                .with_context(|| format!("{} cannot be connected to {}", connection.from, connection.to))?;
            for wire in both {
                if let Some(other) = wires.iter().find(|other| other.is_to(&wire.to)) {
                    let (to, from) = (names.full(&wire.to), names.full(&other.from));
                    if other.from.is(&wire.from) {
                        bail!("{from} and {to} are connected twice: remove one of the connections");
                    }
                    bail!("{to} has two sources, {from} and {}: remove one of the connections", connection.from);
                }
                wires.push(wire);
            }
            Ok(())
        };
        located(connection.place.as_ref(), add())?;
    }
    Ok(wires)
}

/// The ends of a connection: two variables, or the elements of two arrays.
fn ends<'a>(names: &Names<'a>, connection: &Connection) -> Result<Vec<Wire<'a>>> {
    let (from, to) = (names.find_all(&connection.from)?, names.find_all(&connection.to)?);
    if from.len() != to.len() {
        let size = |count: usize| if count == 1 { "a single value".into() } else { format!("{count} values") };
        bail!("it has {}, but the input has {}: connect elements, such as {}[1]", size(from.len()), size(to.len()), {
            if from.len() > 1 { &connection.from } else { &connection.to }
        });
    }
    from.into_iter().zip(to).map(|(from, to)| wire(names, connection, from, to)).collect()
}

fn wire<'a>(names: &Names<'a>, connection: &Connection, from: Reference<'a>, to: Reference<'a>) -> Result<Wire<'a>> {
    for (name, end, wanted) in [(&connection.from, &from, Causality::Output), (&connection.to, &to, Causality::Input)] {
        let is = end.variable.causality;
        if is != wanted {
            bail!("the causality of {name} is {is}; a connection must go from an output to an input");
        }
    }
    let (from_type, to_type) = (from.variable.type_name, to.variable.type_name);
    match (from.kind, to.kind) {
        (from, to) if from == to => {}
        // A value out of the range of an integer type is an error at run time; a REAL is rounded as in the PLC.
        (from, to) if from.whole().is_some() && to.whole().is_some() => {}
        (from, to) if from.is_floating() && to.is_floating() => {}
        // Every 32-bit integer fits into a Real, and every 16-bit one into a Float32.
        (from, to) if to.is_floating() && from.whole().is_some() && from.bits() < to.bits() => {}
        (Type::Boolean, to_kind) if to_kind.is_floating() => {
            let reals = [Type::Real, Type::Float32].map(|kind| names.outputs(from.member, kind)).concat();
            bail!(
                "it is {from_type}, but the input is {to_type}: connect a Real output of the same FMU, such as a mean \
                 over the step (available: {})",
                if reals.is_empty() { "none".into() } else { reals.join(", ") }
            );
        }
        _ => bail!("it is {from_type}, but the input is {to_type}"),
    }
    if let (Some(from_unit), Some(to_unit)) = (&from.variable.unit, &to.variable.unit)
        && from_unit != to_unit
    {
        bail!("it is in {from_unit}, but the input is in {to_unit}: values are not converted");
    }
    Ok(Wire { from, to })
}

/// The variables to record, without duplicates.
fn recorded<'a>(
    names: &Names<'a>,
    wanted: &[Recorded],
    wires: &[Wire],
    set: &[Reference],
) -> Result<Vec<Reference<'a>>> {
    let mut recorded: Vec<Reference> = Vec::new();
    for Recorded { variable, place } in wanted {
        for reference in located(place.as_ref(), names.find_all(variable))? {
            if !recorded.iter().any(|other| other.is(&reference)) {
                recorded.push(reference);
            }
        }
    }
    if wanted.is_empty() {
        for member in 0..names.descriptions.len() {
            recorded.extend(names.all(member).filter(|reference| match reference.variable.causality {
                Causality::Output => true,
                Causality::Input => {
                    wires.iter().any(|wire| wire.to.is(reference)) || set.iter().any(|other| other.is(reference))
                }
                _ => false,
            }));
        }
    }
    Ok(recorded)
}

/// The assignment of a value to a variable, and a warning if the value is outside the range declared by the FMU.
///
/// # Errors
/// The variable is connected or cannot be set, or the value has the wrong type.
pub fn assignment(
    names: &Names,
    name: &str,
    given: Value,
    reference: &Reference,
    wires: &[Wire],
) -> Result<(Assignment, Option<String>)> {
    let variable = reference.variable;
    if let Some(wire) = wires.iter().find(|wire| wire.is_to(reference)) {
        bail!("{name} cannot be set: it is connected to {}", names.full(&wire.from));
    }
    if variable.is_structural {
        bail!("{name} cannot be set: array sizes depend on it and are fixed by its start value");
    }
    if !variable.is_settable() {
        let what = variable.causality;
        bail!("{name} cannot be set: its causality is {what}; only inputs and parameters can be set");
    }
    let (value, cell) = value_and_cell(reference.kind, given).with_context(|| format!("{name} cannot be set"))?;
    let warning = variable
        .is_outside(value)
        .then(|| format!("{name} = {value:?} is outside the range declared by the FMU, {}", variable.range()));
    Ok((Assignment { kind: reference.kind, reference: variable.value_reference, value: cell }, warning))
}

/// A value converted to the variable's type, and its cell.
fn value_and_cell(kind: Type, given: Value) -> Result<(f64, f64)> {
    if let Value::Whole(whole) = given
        && let Some(cell) = kind.whole_cell(whole).filter(|_| kind.is_wide())
    {
        return Ok((whole as f64, cell));
    }
    value(kind, given).map(|value| (value, kind.cell(value)))
}

/// Converts a value to the variable's type.
///
/// # Errors
/// The type does not allow the value, or a double cannot hold it exactly.
pub fn value(kind: Type, value: Value) -> Result<f64> {
    match (kind, value) {
        (kind, Value::Whole(value)) => match kind.whole() {
            None if value as f64 as i128 == value => self::value(kind, Value::Number(value as f64)),
            None => {
                bail!("it is {}, which cannot represent {value}; the nearest number is {}", kind.name(), value as f64)
            }
            Some((low, high)) if (low..=high).contains(&value) => {
                bail!("it is {}; {value} has more digits than can be represented", kind.name())
            }
            Some((low, high)) => bail!("it is {}; {value} is not a whole number from {low} to {high}", kind.name()),
        },
        (Type::Boolean, Value::Boolean(value)) => Ok(f64::from(u8::from(value))),
        (Type::Boolean, Value::Number(value)) if value == 0.0 || value == 1.0 => Ok(value),
        (Type::Boolean, Value::Number(value)) => bail!("it is Boolean; {value:?} is neither true (1) nor false (0)"),
        (_, Value::Boolean(value)) => bail!("it is {}; {value} is not a number", kind.name()),
        (Type::Real, Value::Number(value)) => Ok(value),
        (Type::Float32, Value::Number(value)) if !value.is_finite() || value.abs() <= f64::from(f32::MAX) => Ok(value),
        (Type::Float32, Value::Number(value)) => bail!("it is Float32, and {value:?} exceeds its range"),
        (Type::Integer, Value::Number(value)) if f64::from(value as i32) == value => Ok(value),
        (Type::Integer, Value::Number(value)) => bail!("it is Integer; {value:?} is not a 32-bit integer"),
        (kind, Value::Number(value)) => {
            let whole = (value == value.trunc() && value.abs() <= EXACT as f64).then_some(value as i128);
            let (low, high) = kind.whole().unwrap_or_default();
            if whole.and_then(|whole| kind.whole_cell(whole)).is_none() {
                let (low, high) = (low.max(-EXACT), high.min(EXACT));
                bail!("it is {}; {value:?} is not a whole number from {low} to {high}", kind.name());
            }
            Ok(value)
        }
    }
}

/// The names of a system.
pub struct Names<'a> {
    /// The members' names.
    members: Vec<&'a str>,
    descriptions: &'a [&'a Description],
}

impl<'a> Names<'a> {
    /// The names of a system whose members have these descriptions.
    ///
    /// # Errors
    /// There are no members, or two have the same name.
    pub fn new(system: &'a System, descriptions: &'a [&'a Description]) -> Result<Names<'a>> {
        let members: Vec<&str> = system.members.iter().map(|member| member.name.as_str()).collect();
        assert_eq!(members.len(), descriptions.len(), "each member has a description");
        if members.is_empty() {
            bail!("no FMU to run");
        }
        for (number, name) in members.iter().enumerate() {
            if members[..number].contains(name) {
                bail!("two FMUs are named {name}: rename one with NAME={}", system.members[number].path.display());
            }
        }
        Ok(Names { members, descriptions })
    }

    /// Splits a name `FMU.VARIABLE` into the member and the variable's name.
    fn split<'n>(&self, name: &'n str) -> Result<(usize, &'n str)> {
        // Both parts may contain dots; the longest matching FMU name wins.
        let rest = |member: usize| own_name(name, self.members[member]);
        let member = (0..self.members.len())
            .filter(|member| rest(*member).is_some())
            .max_by_key(|member| self.members[*member].len());
        let Some(member) = member else {
            let first = name.split('.').next().unwrap_or(name);
            let known = self.members.join(", ");
            if let Some(member) = self.with_variable(name) {
                bail!("{name} does not name its FMU: write {member}.{name}");
            }
            let hint = suggestion(first, self.members.iter().copied());
            bail!("{name} does not name an FMU of this run: write FMU.VARIABLE, where FMU is one of {known}{hint}");
        };
        Ok((member, rest(member).unwrap_or_default()))
    }

    /// The elements of the array with this name, or the single variable.
    pub fn find_all(&self, name: &str) -> Result<Vec<Reference<'a>>> {
        let (member, variable) = self.split(name)?;
        match self.descriptions[member].array(variable) {
            Some(elements) => {
                let reference = |variable: &'a Variable| Some(Reference { member, variable, kind: variable.kind? });
                Ok(elements.iter().filter_map(reference).collect())
            }
            None => Ok(vec![self.find(name)?]),
        }
    }

    /// The variable with the name `FMU.VARIABLE`.
    pub fn find(&self, name: &str) -> Result<Reference<'a>> {
        let (member, variable) = self.split(name)?;
        let Some(found) = self.descriptions[member].variable(variable) else {
            if let Some(elements) = self.descriptions[member].array(variable) {
                let count = elements.len();
                bail!("{name} is an array of {count} values: use one of them, such as {name}[1]");
            }
            let near = near(variable, self.descriptions[member].variables.iter().map(|of| of.name.as_str()));
            let member = self.members[member];
            let hint = near.map_or_else(
                || "plcfmu info lists its variables".into(),
                |near| format!("did you mean {member}.{near}?"),
            );
            bail!("{member} has no variable {variable}; {hint}");
        };
        let kind = found.kind.with_context(|| match found.dimensions.as_slice() {
            [] => format!("{name} is a {}, which cannot be set or recorded", found.type_name),
            sizes => format!("{name} is a {}{sizes:?} array, which cannot be set or recorded", found.type_name),
        })?;
        Ok(Reference { member, variable: found, kind })
    }

    /// The first member that has a variable of this name.
    fn with_variable(&self, name: &str) -> Option<&'a str> {
        let member = self.descriptions.iter().position(|description| description.variable(name).is_some())?;
        Some(self.members[member])
    }

    /// All Boolean and numeric variables of a member.
    fn all(&self, member: usize) -> impl Iterator<Item = Reference<'a>> {
        let variables = self.descriptions[member].variables.iter();
        variables.filter_map(move |variable| Some(Reference { member, variable, kind: variable.kind? }))
    }

    /// The names of a member's first few outputs of one type.
    fn outputs(&self, member: usize, kind: Type) -> Vec<String> {
        let of_type = |output: &Reference| output.kind == kind && output.variable.causality == Causality::Output;
        self.all(member).filter(of_type).take(6).map(|output| output.variable.name.clone()).collect()
    }

    /// The full name, `MEMBER.VARIABLE`.
    pub fn full(&self, reference: &Reference) -> String {
        format!("{}.{}", self.members[reference.member], reference.variable.name)
    }
}

/// The end of a message about a wrong name: suggests the most similar name, if any is similar enough.
pub fn suggestion<'a>(wrong: &str, names: impl Iterator<Item = &'a str>) -> String {
    near(wrong, names).map_or_else(String::new, |near| format!("; did you mean {near}?"))
}

/// The name most similar to a wrong one, ignoring case, if any is similar enough.
pub fn near<'a>(wrong: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let likeness = |name: &str| strsim::normalized_damerau_levenshtein(&wrong, &name.to_lowercase());
    let rated = names.map(|name| (likeness(name), name)).filter(|(likeness, _)| *likeness >= 0.5);
    rated.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, name)| name)
}

#[cfg(test)]
mod tests;
