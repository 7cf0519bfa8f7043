//! Proposes how to connect a controller and a plant, with the reason for each connection.
//!
//! A known loop of the same two FMUs is used unchanged, unless the controller's settings leave its inputs without
//! effect. Otherwise, variables are matched by their roles in a loop, then by equal names, then by a unit that only one
//! output and one input have.

use crate::describe::describe;
use crate::home::Home;
use crate::message::{Description, KnownLoop, LoopRole, Member, Open, Proposal, Values, Variable, Wire};
use anyhow::{Result, bail};
use modeldescription::units;
use run::fmus::number_of;
use run::system::{Value, own_name};
use std::ops::{Deref, DerefMut};

/// The maximum number of possible connections listed in addition to the proposed ones.
const MOST_OTHERS: usize = 2000;

/// One of the two FMUs in the proposal.
struct End<'a> {
    member: &'a Member,
    description: Description,
}

impl<'m> End<'m> {
    fn new(home: &dyn Home, member: &'m Member) -> Result<End<'m>> {
        Ok(End { member, description: describe(home, &member.fmu)? })
    }

    fn full(&self, name: &str) -> String {
        format!("{}.{name}", self.member.name)
    }

    fn variable(&self, name: &str) -> Option<&Variable> {
        self.description.variables.iter().find(|of| of.name == name)
    }

    fn of_role<'a>(&'a self, role: &'a str) -> impl Iterator<Item = &'a Variable> {
        self.description.variables.iter().filter(move |of| of.role == role)
    }

    /// The value that the user has set for a variable, or else its start value; true is 1.
    fn value(&self, name: &str) -> f64 {
        let start = || self.variable(name).map(|of| of.start);
        self.member.values.get(name).copied().or_else(start).map_or(0.0, number_of)
    }

    /// Whether an input has an effect with the current settings.
    fn is_used(&self, name: &str) -> bool {
        let mut fields = self.description.groups.iter().flat_map(|group| &group.fields);
        fields.find(|field| field.name == name).is_none_or(|field| field.is_used(|name| self.value(name) != 0.0))
    }

    /// The inputs that a controller can drive: manipulated value and pulses.
    fn driven(&self) -> Vec<&String> {
        self.description.roles.driving().filter(|name| self.has_input(name)).collect()
    }

    /// Whether the pulses move an actuator between two stops. Without stops, the manipulated value is the pulse width.
    fn has_stops(&self) -> bool {
        self.description.roles.stops().next().is_some()
    }

    fn has_input(&self, name: &str) -> bool {
        self.variable(name).is_some_and(|of| of.role == "input")
    }

    fn has_output(&self, name: &str) -> bool {
        self.variable(name).is_some_and(|of| of.role == "output")
    }
}

/// The FMI type by which a variable is read and written.
fn type_of(variable: &Variable) -> &str {
    match variable.kind.as_str() {
        "REAL" | "LREAL" | "TIME" => "Real",
        "WORD" | "INT" => "Integer",
        "BOOL" => "Boolean",
        other => other,
    }
}

/// Whether the types and units of two variables allow a connection.
fn fits(from: &Variable, to: &Variable) -> bool {
    let types = (type_of(from), type_of(to));
    let is_unit_equal = match (&from.unit, &to.unit) {
        (Some(from), Some(to)) => from == to,
        _ => true,
    };
    (types.0 == types.1 || types == ("Integer", "Real")) && is_unit_equal
}

/// Proposes connections.
///
/// # Errors
/// An FMU does not exist, or both have the same name.
pub fn propose(home: &dyn Home, controller: &Member, plant: &Member) -> Result<Proposal> {
    if controller.name == plant.name {
        bail!("two members are named {}: rename one", plant.name);
    }
    let (controller, plant) = (&End::new(home, controller)?, &End::new(home, plant)?);
    let mut proposal = draft(home, controller, plant);
    if let (Some(own), Some(of_plant)) = (&controller.description.cycle, &plant.description.cycle) {
        proposal.values.insert(plant.full(of_plant), Value::Number(controller.value(own)));
    }
    remarks(home, controller, plant, &mut proposal);
    others(controller, plant, &mut proposal);
    Ok(proposal.proposal)
}

/// The proposed connections.
fn draft(home: &dyn Home, controller: &End, plant: &End) -> Draft {
    let mut proposal = Draft::default();
    match known(home, controller, plant) {
        Some(of) => take_known(&of, controller, plant, &mut proposal),
        None => {
            by_roles(controller, plant, &mut proposal);
            by_names(controller, plant, &mut proposal);
            by_units(controller, plant, &mut proposal);
        }
    }
    proposal
}

/// The plants of the catalogue that the controller can drive through proposed connections.
fn fitting_plants(home: &dyn Home, controller: &End) -> Vec<String> {
    let is_fitting = |name: &String| {
        let member =
            Member { name: format!("{}_PLANT", controller.member.name), fmu: name.clone(), ..Member::default() };
        End::new(home, &member).is_ok_and(|plant| {
            let is_driven = draft(home, controller, &plant).goes_from(controller);
            is_driven && !plant.driven().is_empty()
        })
    };
    let plants = home.entries().into_iter().filter(|entry| entry.part == LoopRole::Plant && !entry.is_foreign);
    plants.map(|entry| entry.name).filter(is_fitting).collect()
}

/// A proposal under construction.
#[derive(Default)]
struct Draft {
    proposal: Proposal,
    /// Inputs whose matching output has an incompatible type or unit, with the message to show if nothing else is
    /// connected to them.
    misfits: Vec<Open>,
}

impl Draft {
    /// Whether a proposed connection starts at an output of this FMU.
    fn goes_from(&self, end: &End) -> bool {
        self.connections.iter().any(|wire| own_name(&wire.from, &end.member.name).is_some())
    }
}

impl Deref for Draft {
    type Target = Proposal;

    fn deref(&self) -> &Proposal {
        &self.proposal
    }
}

impl DerefMut for Draft {
    fn deref_mut(&mut self) -> &mut Proposal {
        &mut self.proposal
    }
}

/// A known loop, with the indices of its controller and its plant among its members.
struct Known {
    of: KnownLoop,
    controller: usize,
    plant: usize,
}

/// The known loop of these two FMUs; if there are several, preferably one whose communication step is its controller's
/// cycle.
fn known(home: &dyn Home, controller: &End, plant: &End) -> Option<Known> {
    let is = |end: &End, fmu: &str| end.member.fmu == fmu || end.description.block == fmu;
    let mut all = Vec::new();
    for of in home.known_loops() {
        let [first, second] = of.setup.members.as_slice() else { continue };
        let (own, other) = if is(controller, &first.fmu) && is(plant, &second.fmu) {
            (0, 1)
        } else if is(controller, &second.fmu) && is(plant, &first.fmu) {
            (1, 0)
        } else {
            continue;
        };
        let known = Known { of, controller: own, plant: other };
        let wires = known.wires(controller, plant);
        let all_there = wires.iter().all(|(from, output, to, input)| from.has_output(output) && to.has_input(input));
        let all_used = wires.iter().all(|(_, _, to, input)| to.is_used(input));
        if !wires.is_empty() && all_there && all_used {
            all.push(known);
        }
    }
    let is_each_call = |known: &Known| {
        let values = &known.of.setup.members[known.controller].values;
        let cycle = controller.description.cycle.as_ref();
        let start = || cycle.and_then(|name| controller.variable(name)).map(|of| of.start);
        let cycle = cycle.and_then(|name| values.get(name).copied()).or_else(start).map(number_of);
        known.of.setup.step.is_none() || known.of.setup.step == cycle
    };
    let place = all.iter().position(is_each_call).unwrap_or(0);
    (!all.is_empty()).then(|| all.swap_remove(place))
}

impl Known {
    /// The loop's connections: the FMU and name of the output, then the FMU and name of the input.
    fn wires<'a>(
        &self,
        controller: &'a End<'a>,
        plant: &'a End<'a>,
    ) -> Vec<(&'a End<'a>, String, &'a End<'a>, String)> {
        let members = &self.of.setup.members;
        let end = |name: &str| {
            let of = |place: usize| Some(own_name(name, &members[place].name)?.to_string());
            let own = of(self.controller).map(|variable| (controller, variable));
            own.or_else(|| of(self.plant).map(|variable| (plant, variable)))
        };
        let wire = |(from, to): &(String, String)| {
            let ((from, output), (to, input)) = (end(from)?, end(to)?);
            Some((from, output, to, input))
        };
        self.of.setup.connections.iter().filter_map(wire).collect()
    }
}

fn take_known(known: &Known, controller: &End, plant: &End, proposal: &mut Draft) {
    for (from, output, to, input) in known.wires(controller, plant) {
        let reason = format!("as in the known loop \"{}\"", known.of.title);
        proposal.connections.push(Wire { from: from.full(&output), to: to.full(&input), reason });
    }
    let values = &known.of.setup.members[known.plant].values;
    let of_plant = values.iter().filter(|(name, _)| plant.variable(name).is_some());
    proposal.values = of_plant.map(|(name, value)| (plant.full(name), *value)).collect::<Values>();
    proposal.step = known.of.setup.step;
    proposal.exchange = known.of.setup.exchange;
    if let (Some(step), Some(cycle)) = (proposal.step, &controller.description.cycle)
        && step == number_or(&known.of.setup.members[known.controller].values, cycle, controller)
    {
        // One call in each step, even if the controller's cycle has changed.
        proposal.step = None;
    }
}

/// A member's value in a known loop, or else the variable's start value; true is 1.
fn number_or(values: &Values, name: &str, end: &End) -> f64 {
    values.get(name).copied().or_else(|| end.variable(name).map(|of| of.start)).map_or(0.0, number_of)
}

/// Adds a connection if both variables exist and fit, and the input has an effect and is not connected yet.
fn connect(from: &End, output: &str, to: &End, input: &str, reason: &str, proposal: &mut Draft) {
    let (Some(output), Some(input)) = (from.variable(output), to.variable(input)) else { return };
    let full = to.full(&input.name);
    let is_free = !proposal.connections.iter().any(|wire| wire.to == full);
    if output.role != "output" || input.role != "input" || !is_free || !to.is_used(&input.name) {
        return;
    }
    if !fits(output, input) {
        let shown = |of: &Variable| of.unit.as_deref().map_or_else(|| type_of(of).to_lowercase(), units::shown);
        let (output, from_unit, to_unit) = (from.full(&output.name), shown(output), shown(input));
        let text = format!(
            "{output} ({from_unit}) cannot be connected to {full} ({to_unit}), although {reason}: values are not \
             converted"
        );
        proposal.misfits.push(Open { input: full, text });
        return;
    }
    let unit = match &output.unit {
        Some(unit) if input.unit.is_some() => format!(", both in {}", units::shown(unit)),
        _ => String::new(),
    };
    proposal.connections.push(Wire { from: from.full(&output.name), to: full, reason: format!("{reason}{unit}") });
}

fn by_roles(controller: &End, plant: &End, proposal: &mut Draft) {
    let (own, of_plant) = (&controller.description.roles, &plant.description.roles);
    // Connecting both the manipulated value and the pulses would drive the plant twice.
    if own.pulses.is_empty() || of_plant.pulses.is_empty() {
        if let (Some(output), Some(input)) = (&own.manipulated_value, &of_plant.manipulated_value) {
            connect(controller, output, plant, input, "both are the manipulated value", proposal);
        }
    } else if controller.has_stops() == plant.has_stops() {
        for (output, input) in own.pulses.iter().zip(&of_plant.pulses) {
            connect(controller, output, plant, input, "both are pulses of the manipulated value", proposal);
        }
    } else {
        let act = |end: &End, pulses: &[String]| {
            let how = if end.has_stops() { "move an actuator between its stops" } else { "act only while they are on" };
            format!("{} of {} {how}", pulses.join(" and "), end.member.name)
        };
        let (from, to) = (act(controller, &own.pulses), act(plant, &of_plant.pulses));
        let text = format!("{from}, but {to}: these pulses are not compatible, so they are not connected");
        proposal.misfits.push(Open { input: plant.full(&of_plant.pulses[0]), text });
    }
    if let (Some(output), Some(input)) = (&of_plant.process_value, &own.process_value) {
        connect(plant, output, controller, input, "both are the process value", proposal);
    }
    for (meaning, name) in &own.signals {
        for (_, other) in of_plant.signals.iter().filter(|(of, _)| of == meaning) {
            let reason = format!("both are the {meaning}");
            connect(plant, other, controller, name, &reason, proposal);
            connect(controller, name, plant, other, &reason, proposal);
        }
    }
}

fn by_names(controller: &End, plant: &End, proposal: &mut Draft) {
    for (from, to) in [(controller, plant), (plant, controller)] {
        for output in from.of_role("output").filter(|of| to.has_input(&of.name)) {
            connect(from, &output.name, to, &output.name, "they have the same name", proposal);
        }
    }
}

/// For each direction without a proposed connection: connects an output to an input with the same unit if only one such
/// pair exists.
fn by_units(controller: &End, plant: &End, proposal: &mut Draft) {
    for (from, to) in [(controller, plant), (plant, controller)] {
        if proposal.goes_from(from) {
            continue;
        }
        let mut pairs = Vec::new();
        for output in from.of_role("output").filter(|of| of.unit.is_some()) {
            let inputs = to.of_role("input").filter(|of| of.unit == output.unit && fits(output, of));
            let inputs = inputs.filter(|of| to.is_used(&of.name));
            pairs.extend(inputs.map(|input| (output, input)));
        }
        if let [(output, input)] = pairs.as_slice() {
            let reason = format!("same unit, {}", units::shown(output.unit.as_deref().unwrap_or_default()));
            let wire = Wire { from: from.full(&output.name), to: to.full(&input.name), reason };
            proposal.connections.push(wire);
        }
    }
}

/// Adds the inputs that should be connected but are not, and remarks on the choice of plant.
fn remarks(home: &dyn Home, controller: &End, plant: &End, proposal: &mut Draft) {
    let is_connected = |full: &str| proposal.connections.iter().any(|wire| wire.to == full);
    let mut open: Vec<String> = Vec::new();
    let own = &controller.description.roles;
    if let Some(input) = own.process_value.as_deref().filter(|name| controller.has_input(name))
        && !proposal.goes_from(plant)
    {
        open.push(controller.full(input));
    }
    if let Some(input) = plant.driven().first().filter(|_| !proposal.goes_from(controller)) {
        open.push(plant.full(input));
    }
    let signals =
        own.signals.iter().map(|(_, name)| name).filter(|name| controller.has_input(name) && controller.is_used(name));
    open.extend(signals.map(|name| controller.full(name)).filter(|full| !is_connected(full)));
    open.sort_unstable();
    open.dedup();
    let nothing = open.into_iter().map(|input| Open { text: format!("nothing is connected to {input}"), input });
    // Another input of the controller, such as an analog word, may receive the process value.
    let from_other = |full: &str| own_name(full, &controller.member.name).is_some() && proposal.goes_from(plant);
    let misfits = proposal.misfits.iter().filter(|Open { input, .. }| !is_connected(input) && !from_other(input));
    proposal.open = misfits.cloned().chain(nothing).collect();
    if !plant.driven().is_empty() && !proposal.goes_from(controller) {
        let fitting = fitting_plants(home, controller);
        if !fitting.is_empty() {
            let text = format!("{} can drive these plants: {}", controller.member.fmu, fitting.join(", "));
            proposal.remarks.push(text);
        }
    }
    if plant.description.part == LoopRole::Controller {
        proposal.remarks.push(format!("{} is also a controller: choose a plant instead", plant.member.fmu));
    }
}

/// Adds all other possible connections.
fn others(controller: &End, plant: &End, proposal: &mut Draft) {
    for (from, to) in [(controller, plant), (plant, controller)] {
        for output in from.of_role("output") {
            for input in to.of_role("input").filter(|input| fits(output, input)) {
                let (full, full_input) = (from.full(&output.name), to.full(&input.name));
                if proposal.connections.iter().any(|wire| wire.from == full && wire.to == full_input) {
                    continue;
                }
                if proposal.others.len() == MOST_OTHERS {
                    proposal
                        .remarks
                        .push(format!("more than {MOST_OTHERS} connections are possible: not all are listed"));
                    return;
                }
                let reason = match (&output.unit, &input.unit) {
                    (Some(unit), Some(_)) => format!("same unit, {}", units::shown(unit)),
                    _ => format!("same type, {}", type_of(input)),
                };
                proposal.others.push(Wire { from: full, to: full_input, reason });
            }
        }
    }
}

#[cfg(test)]
mod tests;
