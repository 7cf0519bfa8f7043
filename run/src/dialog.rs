//! The dialog in a block's documentation: the roles of its variables in a loop, and its settings, in groups.
//!
//! A block specifies it in a fenced block in its documentation:
//!
//! ````text
//! ```dialog
//! setpoint: SP_INT
//! process value: PV_IN, PV
//! manipulated value: LMN
//! manual: MAN_ON, MAN
//! controller: GAIN, TI, TD, TM_LAG
//! structure: P_SEL, I_SEL, D_SEL
//!
//! [Process value]
//! PVPER_ON
//! PV_FAC, PV_OFF if PVPER_ON
//! ```
//! ````
//!
//! A block without a dialog has one group for its inputs, one for its parameters, and no roles.

use crate::fmus::LoopRole;
use crate::plan::suggestion;
use anyhow::{Context, Result, bail};
use blocks::Role;
use modeldescription::Table;
use serde::{Deserialize, Serialize};

/// The meaning of the signal that is TRUE while a controller in a program is in manual mode.
pub const MANUAL_MODE: &str = "manual mode";

/// The roles of an FMU's variables in a loop. The variable names are without the name of the FMU.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Roles {
    /// The setpoint that the user changes.
    pub setpoint: Option<String>,
    /// The process value: an input of a controller, an output of a plant.
    pub process_value: Option<String>,
    /// The process value to plot, in the setpoint's unit.
    pub shown_process_value: Option<String>,
    /// The manipulated value: an output of a controller, an input of a plant.
    pub manipulated_value: Option<String>,
    /// The switch to manual mode and the manual value.
    pub manual: Option<(String, String)>,
    /// The switch to manual mode and the manual pulses, up and down, of a controller without a manual value.
    pub manual_pulses: Option<(String, [String; 2])>,
    /// The parameters GAIN, TI, TD and TM_LAG, in this order; the list may end earlier.
    pub controller: Vec<String>,
    /// The switches for the P, I and D actions, in this order.
    pub structure: Vec<String>,
    /// The pulses: outputs of a controller (up, down or heat, cool), inputs of a plant.
    pub pulses: Vec<String>,
    /// The settings of the pulse former: period, shortest pulse, ratio.
    pub pulse_former: Vec<String>,
    /// The disturbances of the loop: inputs of a plant, and values that a controller adds to its output.
    pub disturbances: Vec<String>,
    /// The limits of the manipulated value: high, low.
    pub limits: Option<(String, String)>,
    /// The width of the dead band.
    pub dead_band: Option<String>,
    /// The shortest pulse of a step controller.
    pub shortest_pulse: Option<String>,
    /// The input that triggers a complete restart.
    pub restart: Option<String>,
    /// The inputs that are settings; see [`Roles::is_stimulus`].
    pub settings: Vec<String>,
    /// The parameters that are stimuli.
    pub stimuli: Vec<String>,
    /// Additional signals, as pairs of meaning and variable, such as `high stop`: LMNR_HS. Controller and plant use the
    /// same meanings. A `fault` is an output that is TRUE while a plant has stopped, such as a tripped drive.
    pub signals: Vec<(String, String)>,
}

/// Settings that belong together.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Group {
    /// Its title.
    pub title: String,
    /// Its settings, in order.
    pub fields: Vec<Field>,
}

/// A setting of a group.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Field {
    /// The variable.
    pub name: String,
    /// The condition under which it has an effect, as pairs `(name, wanted)`: each inner list is joined by AND, the
    /// lists by OR; always if empty.
    pub used_if: Vec<Vec<(String, bool)>>,
}

/// Parses the dialog from the documentation; without one, there is one group for the inputs and one for the parameters.
///
/// # Errors
/// A line of the dialog cannot be parsed, a name does not exist in the block, or a setting is in no group or in two.
pub fn read(table: &Table) -> Result<(Roles, Vec<Group>)> {
    let Some(lines) = fence(&table.docs)? else { return Ok((Roles::default(), groups(table, "Parameters"))) };
    let mut roles = Roles::default();
    let mut groups: Vec<Group> = Vec::new();
    for line in lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty()) {
        let mut read = || match line.strip_prefix('[') {
            Some(title) => {
                let title = title.strip_suffix(']').context("a title must end with ]")?.trim();
                if title.is_empty() {
                    bail!("the title is empty");
                }
                groups.push(Group { title: title.into(), fields: Vec::new() });
                Ok(())
            }
            None => match groups.last_mut() {
                None => roles.read(table, line),
                Some(group) => {
                    group.fields.extend(fields(table, line)?);
                    Ok(())
                }
            },
        };
        read().with_context(|| format!("{}: the dialog line {line:?}", table.name))?;
    }
    check(table, &groups)?;
    Ok((roles, groups))
}

/// The lines between "```dialog" and "```".
fn fence(docs: &str) -> Result<Option<Vec<&str>>> {
    let begin = |line: &&str| line.trim() == "```dialog";
    let mut after = docs.lines().skip_while(|line| !begin(line)).skip(1).peekable();
    if after.peek().is_none() && !docs.lines().any(|line| begin(&line)) {
        return Ok(None);
    }
    let mut lines = Vec::new();
    loop {
        match after.next().context("a dialog must end with the line ```")? {
            line if line.trim() == "```" => break,
            line => lines.push(line),
        }
    }
    if after.any(|line| begin(&line)) {
        bail!("there are two dialogs: remove one");
    }
    Ok(Some(lines))
}

/// A group for the inputs, and one titled `others` for the other settings; without empty groups.
pub fn groups(table: &Table, others: &str) -> Vec<Group> {
    let group = |title: &str, is_of: fn(Role) -> bool| Group {
        title: title.into(),
        fields: table
            .rows
            .iter()
            .filter(|row| is_of(row.role))
            .map(|row| Field { name: row.name.clone(), used_if: Vec::new() })
            .collect(),
    };
    let inputs = group("Inputs", |role| role == Role::Input);
    let others = group(others, |role| role.is_settable() && role != Role::Input);
    [inputs, others].into_iter().filter(|group| !group.fields.is_empty()).collect()
}

/// Parses comma-separated names of variables in the table.
fn names(table: &Table, text: &str) -> Result<Vec<String>> {
    text.split(',').map(|name| known(table, name.trim())).collect()
}

fn known(table: &Table, name: &str) -> Result<String> {
    if table.find(name).is_some() {
        return Ok(name.into());
    }
    let hint = suggestion(name, table.rows.iter().map(|row| row.name.as_str()));
    bail!("no variable {name:?}{hint}")
}

/// Parses `NAMES` or `NAMES if CONDITION`.
fn fields(table: &Table, line: &str) -> Result<Vec<Field>> {
    let (listed, used_if) = match line.split_once(" if ") {
        Some((listed, condition)) => (listed, self::condition(table, condition)?),
        None => (line, Vec::new()),
    };
    let field = |name: String| match table.find(&name).map(|row| table.rows[row].role) {
        Some(role) if !role.is_settable() => {
            bail!("{name} is {}: only inputs and parameters can be in groups", role.name())
        }
        _ => Ok(Field { name, used_if: used_if.clone() }),
    };
    names(table, listed)?.into_iter().map(field).collect()
}

/// Parses `A and not B or C`.
fn condition(table: &Table, text: &str) -> Result<Vec<Vec<(String, bool)>>> {
    let switch = |words: &[&str]| {
        let (name, wanted) = match words {
            ["not", name] => (name, false),
            [name] => (name, true),
            _ => bail!("{:?}: write NAME or `not NAME`, joined by `and` or `or`", words.join(" ")),
        };
        let name = known(table, name)?;
        if table.find(&name).is_some_and(|row| !table.rows[row].role.is_settable()) {
            bail!("{name} is neither an input nor a parameter: a condition can only use settings");
        }
        Ok((name, wanted))
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    words.split(|word| *word == "or").map(|all| all.split(|word| *word == "and").map(switch).collect()).collect()
}

/// Checks that each setting is in exactly one group.
fn check(table: &Table, groups: &[Group]) -> Result<()> {
    let all: Vec<&str> = groups.iter().flat_map(|group| &group.fields).map(|field| field.name.as_str()).collect();
    for row in table.rows.iter().filter(|row| row.role.is_settable()) {
        match all.iter().filter(|name| **name == row.name).count() {
            1 => {}
            0 => bail!("{}: {} is not in any group of its dialog: add it to one", table.name, row.name),
            _ => bail!("{}: {} appears in its dialog more than once: keep it in one group", table.name, row.name),
        }
    }
    Ok(())
}

impl Roles {
    /// The process value that is compared with the setpoint: the one to plot, or `process_value` if there is none to
    /// plot.
    pub fn compared_process_value(&self) -> Option<&String> {
        self.shown_process_value.as_ref().or(self.process_value.as_ref())
    }

    /// The outputs that are TRUE while a plant has stopped.
    pub fn faults(&self) -> impl Iterator<Item = &String> {
        self.signals.iter().filter(|(meaning, _)| meaning == "fault").map(|(_, name)| name)
    }

    /// The setpoint, process value and manipulated value of a loop, as plotted.
    pub fn signals(&self) -> [Option<&String>; 3] {
        [self.setpoint.as_ref(), self.compared_process_value(), self.manipulated_value.as_ref()]
    }

    /// The outputs that drive a plant: the manipulated value and the pulses.
    pub fn driving(&self) -> impl Iterator<Item = &String> {
        self.manipulated_value.iter().chain(&self.pulses)
    }

    /// Whether a variable is a stimulus of the loop, such as setpoint, manual value, disturbance or noise, rather than
    /// a setting being tuned. Inputs are stimuli and parameters are settings unless the dialog specifies otherwise.
    pub fn is_stimulus(&self, name: &str, is_input: bool) -> bool {
        let named = |names: &[String]| names.iter().any(|other| other == name);
        let is_manual = self.manual.as_ref().is_some_and(|(on, value)| on == name || value == name)
            || self.manual_pulses.as_ref().is_some_and(|(on, pulses)| on == name || named(pulses));
        !named(&self.settings)
            && (is_input
                || is_manual
                || self.setpoint.as_deref() == Some(name)
                || named(&self.disturbances)
                || named(&self.stimuli))
    }

    /// The switch to manual mode.
    pub fn manual_switch(&self) -> Option<&String> {
        let of_pulses = || self.manual_pulses.as_ref().map(|(switch, _)| switch);
        self.manual.as_ref().map(|(switch, _)| switch).or_else(of_pulses)
    }

    /// The variable that indicates manual mode: the controller's switch or, if a program sets the switch, a separate
    /// status.
    pub fn manual_mode(&self) -> Option<&String> {
        let said = || self.signals.iter().find(|(meaning, _)| meaning == MANUAL_MODE).map(|(_, name)| name);
        self.manual_switch().or_else(said)
    }

    /// The variables that indicate an actuator at one of its stops.
    pub fn stops(&self) -> impl Iterator<Item = &String> {
        self.signals.iter().filter(|(meaning, _)| meaning.ends_with("stop")).map(|(_, name)| name)
    }

    /// Parses `ROLE: NAMES`.
    fn read(&mut self, table: &Table, line: &str) -> Result<()> {
        let (role, listed) = line.split_once(':').context("write ROLE: NAMES, or [Title] to begin a group")?;
        let (role, mut names) = (role.trim(), names(table, listed)?);
        let most = match role {
            "setpoint" | "manipulated value" | "dead band" | "shortest pulse" | "restart" => 1,
            "process value" | "manual" | "limits" => 2,
            "controller" => 4,
            "structure" | "pulse former" | "manual pulses" => 3,
            "pulses" => 2,
            "disturbances" | "settings" | "stimuli" => usize::MAX,
            _ if role.strip_prefix("signal ").is_some_and(|what| !what.trim().is_empty()) => 1,
            _ => bail!(
                "{role:?} is not a role; available: setpoint, process value, manipulated value, manual, manual pulses, \
                 controller, structure, pulses, pulse former, limits, dead band, shortest pulse, restart, disturbances, \
                 settings, stimuli, signal NAME"
            ),
        };
        if names.len() > most {
            let most = if most == 1 { "one name".into() } else { format!("{most} names") };
            bail!("{role} can have at most {most}");
        }
        let first = names[0].clone();
        match role {
            "setpoint" => self.setpoint = Some(first),
            "process value" => {
                self.shown_process_value = Some(names.pop().unwrap_or_else(|| first.clone()));
                self.process_value = Some(first);
            }
            "manipulated value" => self.manipulated_value = Some(first),
            "manual" => {
                let [on, value] = names.as_slice() else { bail!("manual needs two names: the switch and the value") };
                self.manual = Some((on.clone(), value.clone()));
            }
            "manual pulses" => {
                let [on, up, down] = names.as_slice() else {
                    bail!("manual pulses needs three names: the switch, up and down")
                };
                self.manual_pulses = Some((on.clone(), [up.clone(), down.clone()]));
            }
            "limits" => {
                let [high, low] = names.as_slice() else {
                    bail!("limits needs two names: the high limit and the low limit")
                };
                self.limits = Some((high.clone(), low.clone()));
            }
            "dead band" => self.dead_band = Some(first),
            "shortest pulse" => self.shortest_pulse = Some(first),
            "restart" => self.restart = Some(first),
            "controller" => self.controller = names,
            "structure" => self.structure = names,
            "pulses" => self.pulses = names,
            "pulse former" => self.pulse_former = names,
            "disturbances" => self.disturbances = names,
            "settings" => self.settings = names,
            "stimuli" => self.stimuli = names,
            signal => self.signals.push((signal.trim_start_matches("signal ").trim().into(), first)),
        }
        Ok(())
    }

    /// The role of the FMU in a loop.
    pub fn part(&self, table: &Table) -> LoopRole {
        let is = |name: &Option<String>, role: Role| {
            let row = name.as_ref().and_then(|name| table.find(name));
            row.is_some_and(|row| table.rows[row].role == role)
        };
        let has_pulses = |role: Role| is(&self.pulses.first().cloned(), role);
        if self.setpoint.is_some() || is(&self.manipulated_value, Role::Output) || has_pulses(Role::Output) {
            LoopRole::Controller
        } else if is(&self.manipulated_value, Role::Input)
            || is(&self.process_value, Role::Output)
            || has_pulses(Role::Input)
        {
            LoopRole::Plant
        } else {
            LoopRole::Other
        }
    }
}

impl Field {
    /// Whether the field has an effect; `is_on` returns whether a switch is on.
    pub fn is_used(&self, is_on: impl Fn(&str) -> bool) -> bool {
        self.used_if.is_empty()
            || self.used_if.iter().any(|all| all.iter().all(|(name, wanted)| is_on(name) == *wanted))
    }
}

#[cfg(test)]
mod tests;
