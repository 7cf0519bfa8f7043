//! A block that is called as in a recording.

use super::change::Change;
use super::columns::Recording;
use anyhow::{Context, Result, bail};
use blocks::table::number::to_value;
use blocks::{Kind, Role};
use modeldescription::Table;
use run::component::{Component, Type};
use run::dialog::{Group, Roles};
use run::fmus::Fmus;
use run::fmus::Member;
use run::fmus::number_of;
use run::plan::suggestion;
use run::system::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The block of a loop with its settings.
pub(super) struct Block<'a> {
    home: &'a dyn Fmus,
    fmu: &'a str,
    name: &'a str,
    pub(super) table: Arc<Table>,
    pub(super) roles: &'a Roles,
    pub(super) groups: &'a [Group],
    /// The type and the value reference of each variable in the table.
    variables: Vec<(Type, u32)>,
    /// The initial value of each variable in the table: the loop's or, if it specifies none, a new
    /// instance's.
    pub(super) settings: Vec<f64>,
    /// The rows in the table of the variables whose values the loop specifies.
    given: Vec<usize>,
}

/// How the block reaches the first row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Beginning {
    /// The first row is the restart.
    #[default]
    Restart,
    /// The first row is the first call after the restart.
    Fresh,
    /// In manual mode, with the recorded manipulated value; the first row is the last call in manual mode.
    Held,
}

/// How a run differs from the recording and the loop's settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Variant {
    /// The values that replace the loop's or the recorded ones, by the variables' rows in the table.
    pub(super) values: BTreeMap<usize, f64>,
    /// The values that are changed while the block runs, if any.
    pub(super) later: Option<Later>,
    pub(super) beginning: Beginning,
    /// The rows in which the block is not called.
    pub(super) skipped: BTreeSet<usize>,
    /// The rows that are preceded by an additional call.
    pub(super) doubled: BTreeSet<usize>,
    /// The number of additional calls per row.
    pub(super) more_calls: usize,
}

/// Values of variables from a row onward.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Later {
    /// The first row in whose call they apply.
    pub(super) from: usize,
    /// The values, by the variables' rows in the table.
    pub(super) values: BTreeMap<usize, f64>,
}

impl Variant {
    /// Returns the final value of a variable; `None` if the variant does not change it.
    pub(super) fn value(&self, row: usize) -> Option<f64> {
        let later = self.later.as_ref().and_then(|later| later.values.get(&row));
        later.or_else(|| self.values.get(&row)).copied()
    }

    /// Sets a variable: from the row of the change onward if there is one, otherwise from the start.
    pub(super) fn set(&mut self, row: usize, value: f64) {
        let values = self.later.as_mut().map_or(&mut self.values, |later| &mut later.values);
        values.insert(row, value);
    }
}

impl<'a> Block<'a> {
    pub(super) fn new(
        home: &'a dyn Fmus,
        of: &'a Member,
        (roles, groups): &'a (Roles, Vec<Group>),
    ) -> Result<Block<'a>> {
        let table = home.table(&of.fmu)?.with_context(|| format!("{} has no table", of.fmu))?;
        let description = home.description(&of.fmu)?;
        let mut variables = Vec::with_capacity(table.rows.len());
        let mut settings = Vec::with_capacity(table.rows.len());
        for row in &table.rows {
            let missing = || format!("{} does not describe its variable {}", of.fmu, row.name);
            let variable = description.variable(&row.name).with_context(missing)?;
            variables.push((variable.kind.with_context(missing)?, variable.value_reference));
            settings.push(description.start(&row.name).unwrap_or(row.start()));
        }
        let mut given = Vec::new();
        for (name, value) in &of.values {
            let Some(row) = table.find(name).filter(|row| table.rows[*row].role.is_settable()) else {
                let names = table.rows.iter().filter(|row| row.role.is_settable()).map(|row| row.name.as_str());
                let hint = suggestion(name, names);
                bail!("{}: {} has no setting {name}{hint}", of.name, of.fmu);
            };
            settings[row] = number_of(*value);
            to_value(settings[row], table.rows[row].kind)
                .map_err(|range| anyhow::anyhow!("{}: {name} = {:?}: {range}", of.name, settings[row]))?;
            given.push(row);
        }
        Ok(Block { home, fmu: &of.fmu, name: &of.name, table, roles, groups, variables, settings, given })
    }

    /// Returns the loop's name.
    pub(super) fn name(&self) -> &str {
        self.name
    }

    /// Returns the rows in the table of the peripheral word of the process value and of the switch that makes the block
    /// use it.
    pub(super) fn peripheral(&self) -> Option<(usize, usize)> {
        let is_word = |(meaning, _): &&(String, String)| meaning == "process value peripheral";
        let (_, word) = self.roles.signals.iter().find(is_word)?;
        let mut fields = self.groups.iter().flat_map(|group| &group.fields);
        let used_if = &fields.find(|field| field.name == *word)?.used_if;
        let (switch, _) = used_if.first()?.first()?;
        Some((self.table.find(word)?, self.table.find(switch)?))
    }

    /// Returns the row of a variable in the table.
    pub(super) fn row(&self, name: Option<&String>) -> Option<usize> {
        name.and_then(|name| self.table.find(name))
    }

    /// Returns the rows in the table of the switch to manual mode and of the manual value.
    pub(super) fn manual(&self) -> Option<(usize, usize)> {
        let (switch, value) = self.roles.manual.as_ref()?;
        Some((self.table.find(switch)?, self.table.find(value)?))
    }

    /// Whether a manipulated value is at one of its limits.
    pub(super) fn is_limit(&self, value: f64) -> bool {
        let limits = self.roles.limits.iter().flat_map(|(high, low)| [high, low]);
        limits.filter_map(|name| self.table.find(name)).any(|row| self.settings[row] as f32 == value as f32)
    }

    /// Whether the block is in manual mode in all rows.
    pub(super) fn is_always_manual(&self, recording: &Recording) -> bool {
        let Some(switch) = self.row(self.roles.manual_switch()) else { return false };
        let recorded = recording.inputs.iter().find(|input| input.row == switch);
        recorded.map_or(self.settings[switch] == 1.0, |input| input.values.iter().all(|value| *value == 1.0))
    }

    /// Whether the block can be brought to the recorded manipulated value in manual mode.
    pub(super) fn can_be_held(&self, recording: &Recording) -> bool {
        let output = self.manipulated(recording);
        self.manual().is_some() && output.is_some_and(|output| recording.outputs[output].values[0].is_finite())
    }

    /// Returns the index of the recorded manipulated value among the outputs.
    pub(super) fn manipulated(&self, recording: &Recording) -> Option<usize> {
        let row = self.row(self.roles.manipulated_value.as_ref())?;
        recording.outputs.iter().position(|output| output.row == row)
    }

    fn is_input(&self, row: usize) -> bool {
        self.table.rows[row].role == Role::Input
    }

    /// Makes the calls of the first `rows` rows and returns the computed values of each output. `jitter` is the seed of
    /// a variation of the measured and truncated inputs within their last digit.
    pub(super) fn simulate(
        &self,
        recording: &Recording,
        variant: &Variant,
        rows: usize,
        jitter: Option<u64>,
    ) -> Result<Vec<Vec<f64>>> {
        let component = self.home.instantiate(self.fmu, self.name)?;
        let cycle = variant.values.get(&self.table.cycle).copied();
        let recorded = recording.inputs.iter().find(|input| input.row == self.table.cycle).map(|input| input.values[0]);
        let cycle = cycle.or(recorded).unwrap_or(self.settings[self.table.cycle]);
        let mut calls = Calls { block: self, component, cycle, calls: 0, last: vec![f64::NAN; self.variables.len()] };
        let input = |input: usize, row: usize| {
            let of = &recording.inputs[input];
            let value = of.values[row];
            match jitter {
                Some(seed) if of.is_measured => value + of.resolution(value) * sign(seed, row, input),
                // While a value is held, its truncated digits stay the same.
                Some(seed) if of.is_cut(value) => {
                    value + of.resolution(value) * sign(seed, value.to_bits() as usize, input)
                }
                _ => value,
            }
        };
        calls.initialize(recording, variant, |number| input(number, 0))?;
        let outputs: Vec<usize> = recording.outputs.iter().map(|output| output.row).collect();
        let mut computed: Vec<Vec<f64>> = outputs.iter().map(|_| Vec::with_capacity(rows)).collect();
        let mut now = vec![0.0; outputs.len()];
        let groups = self.groups(&outputs);
        let recorded = recording.inputs.iter().enumerate();
        let written: Vec<_> = recorded.filter(|(_, of)| !variant.values.contains_key(&of.row)).collect();
        let later = variant.later.as_ref();
        for row in 0..rows {
            let is_called = match variant.beginning {
                Beginning::Restart => row > 0,
                Beginning::Fresh => true,
                Beginning::Held if row == 0 => {
                    let target = recording.outputs[self.manipulated(recording).unwrap_or_default()].values[0];
                    calls.hold(recording, target)?;
                    false
                }
                Beginning::Held => {
                    if row == 1 {
                        calls.release(recording, variant)?;
                    }
                    true
                }
            };
            let is_called = is_called && !variant.skipped.contains(&row);
            if is_called {
                let context = || format!("line {} of the recording", recording.lines[row]);
                if row > 0 && variant.doubled.contains(&row) {
                    // Nothing was recorded between the rows: interpolate the measured inputs.
                    for &(number, of) in written.iter().filter(|(_, of)| of.is_measured) {
                        let share = jitter.map_or(0.5, |seed| 0.5 + 0.5 * sign(seed, row, number));
                        let (before, after) = (input(number, row - 1), input(number, row));
                        calls.set(of.row, before + share * (after - before)).with_context(context)?;
                    }
                    calls.step().with_context(context)?;
                }
                for (changed, value) in later.iter().filter(|later| row >= later.from).flat_map(|later| &later.values) {
                    calls.set(*changed, *value).with_context(context)?;
                }
                for &(number, of) in written.iter().filter(|(_, of)| of.is_tunable) {
                    calls.set(of.row, input(number, row)).with_context(context)?;
                }
                for _ in 0..=variant.more_calls {
                    calls.step().with_context(context)?;
                }
            }
            if is_called || row == 0 {
                calls.read(&groups, &mut now)?;
            }
            for (all, now) in computed.iter_mut().zip(&now) {
                all.push(*now);
            }
        }
        Ok(computed)
    }

    /// Groups the value references of table rows by type, each with its index in `rows`.
    fn groups(&self, rows: &[usize]) -> Vec<(Type, Vec<u32>, Vec<usize>)> {
        let group = |kind: Type| {
            let places: Vec<usize> = (0..rows.len()).filter(|place| self.variables[rows[*place]].0 == kind).collect();
            let references = places.iter().map(|place| self.variables[rows[*place]].1).collect();
            (kind, references, places)
        };
        Type::ALL.map(group).into_iter().filter(|(_, _, places)| !places.is_empty()).collect()
    }
}

/// A running instance.
struct Calls<'b, 'a> {
    block: &'b Block<'a>,
    component: Box<dyn Component>,
    /// The time between two calls in seconds.
    cycle: f64,
    /// The number of calls made.
    calls: usize,
    /// The last value set for each variable of the table; NaN if none was set.
    last: Vec<f64>,
}

impl Calls<'_, '_> {
    /// Initializes the instance up to the restart, with the values of the first row.
    fn initialize(&mut self, recording: &Recording, variant: &Variant, first: impl Fn(usize) -> f64) -> Result<()> {
        let mut values: BTreeMap<usize, f64> =
            self.block.given.iter().map(|row| (*row, self.block.settings[*row])).collect();
        values.extend(recording.inputs.iter().enumerate().map(|(number, of)| (of.row, first(number))));
        values.extend(&variant.values);
        self.component.setup(0.0, None)?;
        for (row, value) in values.iter().filter(|(row, _)| !self.block.is_input(**row)) {
            self.set(*row, *value)?;
        }
        self.component.enter_initialization()?;
        for (row, value) in values.iter().filter(|(row, _)| self.block.is_input(**row)) {
            self.set(*row, *value)?;
        }
        self.component.exit_initialization()
    }

    fn set(&mut self, row: usize, value: f64) -> Result<()> {
        if self.last[row].to_bits() == value.to_bits() {
            return Ok(());
        }
        let (kind, reference) = self.block.variables[row];
        let of = &self.block.table.rows[row];
        self.component.write(kind, &[reference], &[value]).with_context(|| format!("{} = {value:?}", of.name))?;
        self.last[row] = value;
        Ok(())
    }

    fn step(&mut self) -> Result<()> {
        self.component.step(self.calls as f64 * self.cycle, self.cycle)?;
        self.calls += 1;
        Ok(())
    }

    fn read(&mut self, groups: &[(Type, Vec<u32>, Vec<usize>)], values: &mut [f64]) -> Result<()> {
        let mut room = vec![0.0; values.len()];
        for (kind, references, places) in groups {
            self.component.read(*kind, references, &mut room[..references.len()])?;
            for (place, value) in places.iter().zip(&room) {
                values[*place] = *value;
            }
        }
        Ok(())
    }

    /// Brings the manipulated value to `target` in manual mode, assuming that it depends linearly on the manual value.
    fn hold(&mut self, recording: &Recording, target: f64) -> Result<()> {
        let Some((switch, manual)) = self.block.manual() else { return Ok(()) };
        let recorded = |row: usize| recording.inputs.iter().find(|of| of.row == row).map(|of| of.values[0]);
        if recorded(switch) == Some(1.0) && recorded(manual).is_some() {
            // Make a few calls, so that the block's internal state settles.
            for _ in 0..4 {
                self.step()?;
            }
            return Ok(());
        }
        let output = self.block.row(self.block.roles.manipulated_value.as_ref()).unwrap_or_default();
        let (kind, reference) = self.block.variables[output];
        self.set(switch, 1.0)?;
        let at = |calls: &mut Self, value: f64| -> Result<f64> {
            calls.set(manual, value)?;
            calls.step()?;
            let mut now = [0.0];
            calls.component.read(kind, &[reference], &mut now)?;
            Ok(now[0])
        };
        let first = at(self, target)?;
        let mut best = target;
        if first as f32 != target as f32 {
            let step = if target.abs() > 1.0 { -target.signum() } else { 1.0 };
            let second = at(self, target + step)?;
            let slope = (second - first) / step;
            if slope != 0.0 && slope.is_finite() {
                best = target + (target - first) / slope;
            }
        }
        for _ in 0..4 {
            at(self, best)?;
        }
        Ok(())
    }

    /// Returns to the mode that the settings specify; if the mode was recorded, each row sets it.
    fn release(&mut self, recording: &Recording, variant: &Variant) -> Result<()> {
        let Some((switch, manual)) = self.block.manual() else { return Ok(()) };
        for row in [switch, manual] {
            if !recording.inputs.iter().any(|of| of.row == row) {
                let value = variant.values.get(&row).copied().unwrap_or(self.block.settings[row]);
                self.set(row, value)?;
            }
        }
        Ok(())
    }
}

/// Returns 1 or -1, chosen pseudorandomly by the arguments.
fn sign(seed: u64, row: usize, input: usize) -> f64 {
    let mut bits =
        seed ^ (row as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (input as u64).wrapping_mul(0xD1B5_4A32_D192_ED03);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    if (bits ^ (bits >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}

/// Converts a value to the type of its variable.
pub(super) fn typed(kind: Kind, value: f64) -> Value {
    if kind == Kind::Bool { Value::Boolean(value != 0.0) } else { Value::Number(value) }
}

/// Returns the change to a setting from `before`, or from its value in the loop, to `value`.
pub(super) fn change(block: &Block, row: usize, value: f64, before: Option<&f64>) -> Change {
    let of = &block.table.rows[row];
    let own = before.copied().unwrap_or(block.settings[row]);
    Change::Setting { name: of.name.clone(), value: typed(of.kind, value), before: typed(of.kind, own), why: None }
}
