//! Writes variables of any role, outputs and local variables included: once, or for every call.

use super::{Present, Session, Wired, fitting, shown};
use crate::message::{Act, Event, State, Values};
use anyhow::{Context, Result, bail};
use blocks::table::number::{number, to_value};
use modeldescription::Description;
use run::component::Force;
use run::plan::{self, Assignment, Names};
use run::system::Value;

/// A forced variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forced {
    pub(super) member: usize,
    /// The assignment, with the value rounded to the PLC type.
    assignment: Assignment,
}

impl Forced {
    /// The value as represented in messages.
    pub(super) fn shown(&self) -> Value {
        shown(self.assignment.kind, self.assignment.value)
    }
}

impl Session {
    /// Writes, forces or releases variables.
    ///
    /// # Errors
    /// The run has ended; a variable is unknown or belongs to a foreign FMU; a value is invalid; or a variable to be
    /// written once is forced or a connected input.
    pub fn force(&mut self, act: Act, values: &Values) -> Result<State> {
        let present = self.present()?;
        present.is_running()?;
        present.check_room(values.len())?;
        let all = values.iter().map(|(name, value)| present.wired.forced(act, name, *value));
        let all = all.collect::<Result<Vec<_>>>()?;
        for (name, forced) in values.keys().zip(all) {
            present.force(act, name, forced)?;
        }
        self.state()
    }
}

impl Present {
    /// Repeats an event of another run.
    pub(super) fn act(&mut self, event: &Event) -> Result<()> {
        let Event { variable, value, act, .. } = event;
        if *act == Act::Set {
            let (member, assignment, _) = self.wired.assignment(variable, *value)?;
            return self.put(member, assignment, variable);
        }
        let forced = self.wired.forced(*act, variable, *value)?;
        self.force(*act, variable, forced)
    }

    fn force(&mut self, act: Act, name: &str, of: Forced) -> Result<()> {
        let (call, column) = (self.run.steps(), self.record.column(name)?);
        let how = match act {
            Act::Set => bail!("{name}: `set` is not possible here; use `send`, or force it with `write` or `force`"),
            Act::Write if self.forced.contains_key(&column) => bail!("{name} is forced: release it first"),
            Act::Write => Force::Once(of.assignment.value),
            Act::Force => Force::Always(of.assignment.value),
            // Releasing a variable that is not forced has no effect.
            Act::Release if !self.forced.contains_key(&column) => return Ok(()),
            Act::Release => Force::Release,
        };
        self.run.force(of.member, of.assignment.reference, how).with_context(|| name.to_string())?;
        self.ramps.remove(&column);
        self.note(call, column, of.assignment, act);
        match act {
            Act::Force => self.forced.insert(column, of),
            _ => self.forced.remove(&column),
        };
        Ok(())
    }

    /// Puts the forced values into the row: a connected input that is forced has the forced value rather than that of
    /// the connected output.
    pub(super) fn show_forced(&mut self) {
        for (column, of) in &self.forced {
            self.row[*column] = of.assignment.value;
        }
    }
}

impl Wired {
    fn forced(&self, act: Act, name: &str, value: Value) -> Result<Forced> {
        let descriptions: Vec<&Description> = self.descriptions.iter().map(|of| &**of).collect();
        let names = Names::new(&self.system, &descriptions)?;
        let reference = names.find(name)?;
        let wires = plan::wires(&names, &self.system.connections)?;
        if let Some(wire) = wires.iter().find(|wire| wire.is_to(&reference))
            && act == Act::Write
        {
            bail!("{name} is connected to {}, which sets it in each call: force it instead", names.full(&wire.from));
        }
        let table = self.tables[reference.member].as_deref();
        let value = fitting(table, &reference, name, value)?;
        let row = table.and_then(|table| table.rows.iter().find(|row| row.name == reference.variable.name));
        let row = row.with_context(|| {
            format!("{name} cannot be forced: in a foreign FMU, only inputs and tunable parameters can be set")
        })?;
        let held = to_value(value, row.kind).map_err(|range| anyhow::anyhow!("{name} = {value:?}: {range}"))?;
        let (kind, reference, member) = (reference.kind, reference.variable.value_reference, reference.member);
        Ok(Forced { member, assignment: Assignment { kind, reference, value: number(held) } })
    }
}
