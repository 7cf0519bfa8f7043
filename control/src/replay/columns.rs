//! The assignment of a recording's columns to the block's variables, with values in the form that the block expects.

use super::change::{Change, Moving};
use super::instance::{Block, change, typed};
use crate::csv::names::{MANIPULATED_VALUES, MANUAL, PROCESS_VALUES, SETPOINTS, ends, short_name};
use crate::csv::{Column, CsvTable as Csv};
use crate::extremes;
use anyhow::{Context, Result, bail};
use blocks::table::number::to_value;
use blocks::{Kind, Role};
use modeldescription::digits::{ordinal, short};
use run::plan::suggestion;
use std::collections::BTreeSet;

/// If the interval between rows exceeds that between calls by this factor, the recorder is slower than the block.
const COARSE: f64 = 1.5;

/// The part of a recording that concerns the block.
pub(super) struct Recording {
    /// The number of rows.
    pub(super) rows: usize,
    /// The time of each row in seconds.
    pub(super) times: Vec<f64>,
    /// The line of each row in the file.
    pub(super) lines: Vec<usize>,
    /// The most frequent interval between rows in seconds, if the file has times.
    pub(super) spacing: Option<f64>,
    /// Whether this interval exceeds the time between two calls by so much that there must be calls between the rows.
    pub(super) is_coarse: bool,
    /// The signals set before the calls.
    pub(super) inputs: Vec<Signal>,
    /// The signals compared after the calls.
    pub(super) outputs: Vec<Signal>,
    /// The assigned columns with their variables.
    pub(super) matched: Vec<(String, String)>,
    /// Whether the recording itself shows that its first row is a restart.
    pub(super) says_restart: bool,
    /// The last row, if it repeats all outputs of the row before it: the last row of a run holds its final values and
    /// is not a call.
    pub(super) end: Option<usize>,
    /// The rows between calls, if the recorder is faster than the block.
    pub(super) between: BTreeSet<usize>,
    /// The settings whose value differs from the loop's throughout the recording.
    pub(super) settings: Vec<Change>,
    /// The settings that change during the recording and end with a value other than the loop's.
    pub(super) moving: Vec<Moving>,
}

/// A variable with its value in each row.
pub(super) struct Signal {
    /// Its row in the table.
    pub(super) row: usize,
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Its values, in seconds for a TIME. A missing value of an input is replaced with the previous one.
    pub(super) values: Vec<f64>,
    pub(super) is_boolean: bool,
    /// Whether it can be set between calls.
    pub(super) is_tunable: bool,
    /// Whether it changes from row to row like a measured value, so that its last digit is rounded.
    pub(super) is_measured: bool,
    /// Whether it is an input, such as the setpoint, that stays constant for many rows.
    is_held: bool,
    /// The format of the column, without its values.
    written: Column,
    /// The factor from the numbers in the file to `values`.
    scale: f64,
    /// The allowed deviation due to the rounding of REAL: [`ROUNDING`] times the largest value; 0 for other types.
    pub(super) rounding: f64,
    /// Whether the column holds an output of the block that is used as this input.
    is_output_column: bool,
}

/// The minimum number of rows for which a manipulated value must stay the same to count as constant.
const STANDS_STILL: usize = 10;

/// The fraction of an output's largest value that counts as rounding: 16 times the resolution of REAL, because each
/// call rounds again.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64 / 2.0;

impl Signal {
    /// Returns the largest possible difference between the true and the recorded value, given the digits in the file.
    pub(super) fn resolution(&self, value: f64) -> f64 {
        if self.is_boolean { 0.0 } else { self.written.resolution(value / self.scale) * self.scale }
    }

    /// Whether digits of a measured or truncated value are unknown, because more than one REAL would be written like
    /// it.
    pub(super) fn is_rounded(&self) -> bool {
        let is_open = |value: &f64| {
            let resolution = self.resolution(*value);
            [value - resolution, value + resolution].iter().any(|other| *other as f32 != *value as f32)
        };
        self.values.iter().any(|value| (self.is_measured || self.is_cut(*value)) && is_open(value))
    }

    /// Whether a held value looks truncated: it uses the last of three or more decimals, unlike a typed setpoint.
    pub(super) fn is_cut(&self, value: f64) -> bool {
        let digits = value / self.scale * 10f64.powi(self.written.decimals);
        let has_last = self.written.decimals >= 3 && (digits.round() % 10.0 != 0.0);
        self.is_held && has_last
    }

    /// Returns the allowed deviation of a computed value: the effect of unknown digits in the recording, but at least
    /// that of the rounding of REAL.
    pub(super) fn tolerance(&self, value: f64) -> f64 {
        self.resolution(value).max(self.rounding)
    }

    /// Returns the largest allowed deviation over all values.
    pub(super) fn coarsest(&self) -> f64 {
        let known = self.values.iter().filter(|value| value.is_finite());
        known.map(|value| self.tolerance(*value)).fold(0.0, f64::max)
    }
}

impl Recording {
    /// Whether a row is a call.
    pub(super) fn is_call(&self, row: usize) -> bool {
        self.end != Some(row) && !self.between.contains(&row)
    }

    /// Finds the columns of the block's variables. `wanted` is the user's choice: pairs of a column and a variable, or
    /// `time`.
    pub(super) fn new(
        block: &Block,
        csv: &Csv,
        wanted: &[(String, String)],
        remarks: &mut Vec<String>,
    ) -> Result<Recording> {
        let time = match wanted.iter().find(|(_, variable)| variable == "time") {
            Some((column, _)) => Some(found(csv, column)?),
            None => csv.time(),
        };
        let chosen = wanted.iter().filter(|(_, variable)| variable != "time");
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for (column, variable) in chosen {
            let names = || block.table.rows.iter().map(|row| row.name.as_str());
            let row = block.table.find(variable).with_context(|| {
                let hint = suggestion(variable, names());
                format!("{} has no variable {variable}{hint}", block.table.name)
            })?;
            pairs.push((found(csv, column)?, row));
        }
        if pairs.is_empty() {
            pairs = matched(block, csv, time, remarks);
        }
        let scale = time_scale(block, csv, &pairs);
        let mut recording = Recording {
            rows: csv.rows(),
            times: Vec::new(),
            lines: csv.lines.clone(),
            spacing: None,
            is_coarse: false,
            inputs: Vec::new(),
            outputs: Vec::new(),
            matched: Vec::new(),
            says_restart: false,
            end: None,
            between: BTreeSet::new(),
            settings: Vec::new(),
            moving: Vec::new(),
        };
        for (column, row) in pairs {
            recording.add(block, csv, (column, row), scale, remarks)?;
        }
        recording.check(block, csv)?;
        recording.complete(block, remarks);
        recording.find_times(block, csv, time, remarks)?;
        let last = recording.rows - 1;
        recording.end = (last > 1 && !recording.changes(last)).then_some(last);
        Ok(recording)
    }

    /// Returns the tolerance of the coarsest numeric output: normally half a unit in its last recorded digit.
    pub(super) fn resolution(&self) -> f64 {
        self.outputs.iter().filter(|of| !of.is_boolean).map(Signal::coarsest).fold(0.0, f64::max)
    }

    /// Whether any output has a value in this row that differs from that in the previous row.
    pub(super) fn changes(&self, row: usize) -> bool {
        row > 0 && self.outputs.iter().any(|of| of.values[row] != of.values[row - 1] && !of.values[row].is_nan())
    }

    /// Returns the rows between calls, if the outputs change only in every `ratio`-th row, and in at least five rows.
    pub(super) fn rows_between_calls(&self, ratio: usize) -> Option<BTreeSet<usize>> {
        const FEWEST: usize = 5;
        let changed: Vec<usize> = (1..self.rows).filter(|row| self.changes(*row)).collect();
        let first = *changed.first()?;
        let is_call = |row: usize| row % ratio == first % ratio;
        let has_rhythm = ratio > 1 && changed.len() >= FEWEST && changed.iter().all(|row| is_call(*row));
        has_rhythm.then(|| (0..self.rows).filter(|row| !is_call(*row)).collect())
    }

    /// Returns the greatest common divisor of the numbers of rows between changes in the outputs.
    pub(super) fn rhythm(&self) -> usize {
        let changed: Vec<usize> = (1..self.rows).filter(|row| self.changes(*row)).collect();
        changed.windows(2).map(|pair| pair[1] - pair[0]).fold(0, |a, b| {
            let (mut a, mut b) = (a, b);
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        })
    }

    /// Whether the column of the process value may hold the block's input or its output, since it is named after
    /// neither.
    pub(super) fn has_unclear_process_value(&self, block: &Block) -> bool {
        let terminal = block.row(block.roles.process_value.as_ref());
        let named = |of: &&Signal| Some(of.row) == terminal && !of.is_output_column;
        self.inputs.iter().find(named).is_some_and(|of| variable_of(block, &of.written.name).is_none())
    }

    /// Moves each output to the row of its call, for a recording whose rows hold the outputs of the previous call, as
    /// the other FMUs read them with parallel exchange. With `has_late_process_value`, the process value is moved, too.
    pub(super) fn with_earlier_outputs(mut self, block: &Block, has_late_process_value: bool) -> Recording {
        if has_late_process_value {
            let terminal = block.row(block.roles.process_value.as_ref());
            self.inputs.iter_mut().filter(|of| Some(of.row) == terminal).for_each(|of| of.is_output_column = true);
        }
        let shifted = self.inputs.iter_mut().filter(|of| of.is_output_column).chain(&mut self.outputs);
        for of in shifted {
            of.values.remove(0);
            let last = of.values.last().copied().unwrap_or_default();
            of.values.push(if of.is_output_column { last } else { f64::NAN });
        }
        self.end = None;
        // The calls are still the same number of rows apart, but one row earlier.
        let mut calls = (0..self.rows).filter(|row| !self.between.contains(row));
        if !self.between.is_empty()
            && let (Some(first), Some(second)) = (calls.next(), calls.next())
        {
            self.between = self.rows_between_calls(second - first).unwrap_or_default();
        }
        self
    }

    /// While the recorded manipulated value is constant and the computed one moves by more than the last digits
    /// explain, the controller may have been in manual mode, unless the value looks like a limit: one of the loop, or
    /// the lowest or highest recorded value. Assumes manual mode there and returns the times; empty if the mode was
    /// recorded or there are no such times.
    pub(super) fn take_for_manual(
        &mut self,
        block: &Block,
        computed: &[Vec<f64>],
        spread: impl Fn(usize) -> f64,
    ) -> Vec<(f64, f64)> {
        let Some((switch, manual)) = block.manual().filter(|(switch, _)| block.settings[*switch] == 0.0) else {
            return Vec::new();
        };
        let Some(output) = block.manipulated(self) else { return Vec::new() };
        if self.inputs.iter().any(|input| [switch, manual].contains(&input.row)) {
            return Vec::new();
        }
        let (recorded, computed, spread) = (&self.outputs[output], &computed[output], spread(output));
        let ends: [f64; 2] = extremes(recorded.values.iter().filter(|value| value.is_finite())).into();
        let mut is_on = self.constant(block, switch, 0.0);
        let mut value = self.constant(block, manual, block.settings[manual]);
        let mut times: Vec<(f64, f64)> = Vec::new();
        let mut end = 0;
        for still in recorded.values.chunk_by(|one, other| one == other) {
            let rows = end..end + still.len();
            end = rows.end;
            let (low, high) = extremes(&computed[rows.clone()]);
            let moves = high - low > 2.0 * (recorded.tolerance(still[0]) + spread);
            if still.len() < STANDS_STILL || !moves || block.is_limit(still[0]) || ends.contains(&still[0]) {
                continue;
            }
            is_on.values[rows.clone()].fill(1.0);
            value.values[rows.clone()].fill(still[0]);
            let (first, last) = (self.times[rows.start], self.times[rows.end - 1]);
            match times.last_mut() {
                Some((_, end)) if *end == self.times[rows.start.saturating_sub(1)] => *end = last,
                _ => times.push((first, last)),
            }
        }
        if !times.is_empty() {
            self.inputs.extend([is_on, value]);
        }
        times
    }

    /// Whether the manipulated value, from the time `from` onward, never exceeds or never falls below its value at that
    /// time, as at a limit.
    pub(super) fn stays_on_one_side(&self, block: &Block, from: f64) -> bool {
        let Some(output) = block.manipulated(self) else { return false };
        let start = self.times.partition_point(|time| *time < from);
        let later = self.outputs[output].values[start..].iter().filter(|value| value.is_finite());
        let (low, high) = extremes(later);
        let value = self.outputs[output].values[start];
        value == low || value == high
    }

    fn add(
        &mut self,
        block: &Block,
        csv: &Csv,
        (column, row): (usize, usize),
        time_scale: f64,
        remarks: &mut Vec<String>,
    ) -> Result<()> {
        let (of, variable) = (&csv.columns[column], &block.table.rows[row]);
        let of_unit = of.unit.as_deref().and_then(crate::csv::seconds_of_unit);
        let scale = if variable.kind == Kind::Time { of_unit.unwrap_or(time_scale) } else { 1.0 };
        let scaled = |value: &f64| if scale < 1.0 { value / (1.0 / scale).round() } else { value * scale };
        let mut values: Vec<f64> = of.values.iter().map(scaled).collect();
        let is_input = variable.role.is_settable();
        remarks.extend(of.missing(0..values.len(), &csv.lines).map(|missing| {
            let instead = if is_input { "the previous value is used" } else { "nothing is compared there" };
            format!("{missing}; {instead}. Complete the file, or remove the rows.")
        }));
        if is_input {
            let mut before = block.settings[row];
            for (value, line) in values.iter_mut().zip(&csv.lines) {
                if value.is_nan() {
                    *value = before;
                }
                before = *value;
                to_value(*value, variable.kind).map_err(|range| {
                    anyhow::anyhow!(
                        "line {line}, column {}: {value:?} is not a valid value for {}: {range}",
                        of.name,
                        variable.name
                    )
                })?;
            }
        }
        let is_tunable = is_tunable(variable.role);
        let changes = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let name = &variable.name;
        let is_setting = is_input && variable.role != Role::Input;
        if is_setting && changes > 0 {
            let counts = match is_tunable {
                true => "the recorded values are used",
                false => "it is fixed in a running block, so its first value is used",
            };
            remarks.push(format!("{name} changes in the recording: {counts}."));
        }
        if is_setting && (changes == 0 || !is_tunable) && values[0] as f32 != block.settings[row] as f32 {
            self.settings.push(change(block, row, values[0], None));
        }
        let last = values.last().copied().unwrap_or(block.settings[row]);
        if is_setting && changes > 0 && is_tunable && last as f32 != block.settings[row] as f32 {
            let [first, last, before] = [values[0], last, block.settings[row]].map(|of| typed(variable.kind, of));
            self.moving.push(Moving { name: name.clone(), first, last, before });
        }
        let is_process_value = block.row(block.roles.process_value.as_ref()) == Some(row);
        let is_real = matches!(variable.kind, Kind::Real | Kind::LReal);
        let is_measured =
            variable.role == Role::Input && is_real && (changes * 5 > values.len() || is_process_value && changes > 0);
        let largest = values
            .iter()
            .copied()
            .filter(|value| value.is_finite())
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        let rounding = if variable.kind == Kind::Real { ROUNDING * largest } else { 0.0 };
        let signal = Signal {
            row,
            name: name.clone(),
            kind: variable.kind,
            values,
            is_boolean: variable.kind == Kind::Bool,
            is_tunable,
            is_measured,
            is_held: variable.role == Role::Input && is_real && !is_measured,
            written: Column { values: Vec::new(), ..of.clone() },
            scale,
            rounding,
            is_output_column: is_input
                && variable_of(block, &of.name).is_some_and(|row| !block.table.rows[row].role.is_settable()),
        };
        self.matched.push((of.header.clone(), name.clone()));
        if is_input {
            self.inputs.push(signal)
        } else {
            self.outputs.push(signal)
        }
        Ok(())
    }

    /// Rejects a recording that has no outputs to compare or no inputs to replay.
    fn check(&self, block: &Block, csv: &Csv) -> Result<()> {
        let columns: Vec<_> = csv.columns.iter().take(12).map(|column| column.name.as_str()).collect();
        let names = |is_wanted: fn(Role) -> bool| {
            let rows = block.table.rows.iter().filter(|row| is_wanted(row.role));
            rows.take(6).map(|row| row.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let (columns, name) = (columns.join(", "), &block.table.name);
        if self.outputs.is_empty() {
            bail!(
                "none of the columns ({columns}) is an output of {name} ({} ...), so nothing can be compared: rename \
                 or assign the columns",
                names(|role| role == Role::Output)
            );
        }
        if self.inputs.is_empty() {
            bail!(
                "none of the columns ({columns}) is an input of {name} ({} ...), so nothing can be replayed: rename or \
                 assign the columns",
                names(|role| role == Role::Input)
            );
        }
        Ok(())
    }

    /// Adds inputs that were not recorded but follow from recorded signals.
    fn complete(&mut self, block: &Block, remarks: &mut Vec<String>) {
        let has = |recording: &Recording, row: usize| recording.inputs.iter().any(|input| input.row == row);
        let restart =
            block.row(block.roles.restart.as_ref()).and_then(|row| self.inputs.iter().find(|input| input.row == row));
        self.says_restart = restart.is_some_and(|input| input.values[0] == 1.0);
        // If the process value was recorded as a number in its unit, the block must not read the peripheral word.
        if let (Some(terminal), Some((word, switch))) =
            (block.row(block.roles.process_value.as_ref()), block.peripheral())
            && word != terminal
            && has(self, terminal)
            && !has(self, switch)
            && block.settings[switch] == 1.0
            && !has(self, word)
        {
            remarks.push(format!(
                "{} is TRUE, but the recording has the process value at {}: the replay uses FALSE.",
                block.table.rows[switch].name, block.table.rows[terminal].name
            ));
            self.inputs.push(self.constant(block, switch, 0.0));
        }
        if let Some((switch, manual)) = &block.roles.manual
            && let (Some(switch), Some(manual)) = (block.table.find(switch), block.table.find(manual))
            && !has(self, manual)
            && self.inputs.iter().any(|input| input.row == switch && input.values.contains(&1.0))
            && let Some(output) = block.manipulated(self)
        {
            let (name, from) = (&block.table.rows[manual].name, &self.outputs[output].name);
            remarks.push(format!("The recording has no {name}: in manual mode, the recorded {from} is used."));
            let mut signal = self.constant(block, manual, 0.0);
            let mut before = block.settings[manual];
            signal.values.clone_from(&self.outputs[output].values);
            for value in &mut signal.values {
                if value.is_nan() {
                    *value = before;
                }
                before = *value;
            }
            signal.written = self.outputs[output].written.clone();
            signal.is_output_column = true;
            self.inputs.push(signal);
        }
        let terminal = block.row(block.roles.process_value.as_ref());
        for row in [block.row(block.roles.setpoint.as_ref()), terminal].into_iter().flatten() {
            let is_other_way = Some(row) == terminal && block.peripheral().is_some_and(|(word, _)| has(self, word));
            if !has(self, row) && !is_other_way {
                let name = &block.table.rows[row].name;
                remarks.push(format!("The recording has no {name}: a constant {} is used.", block.settings[row]));
            }
        }
    }

    fn constant(&self, block: &Block, row: usize, value: f64) -> Signal {
        let variable = &block.table.rows[row];
        Signal {
            row,
            name: variable.name.clone(),
            kind: variable.kind,
            values: vec![value; self.rows],
            is_boolean: variable.kind == Kind::Bool,
            is_tunable: true,
            is_measured: false,
            is_held: false,
            written: Column { is_boolean: true, ..Column::default() },
            scale: 1.0,
            rounding: 0.0,
            is_output_column: false,
        }
    }

    fn find_times(&mut self, block: &Block, csv: &Csv, time: Option<usize>, remarks: &mut Vec<String>) -> Result<()> {
        let recorded = self.inputs.iter().find(|input| input.row == block.table.cycle).map(|input| input.values[0]);
        let cycle = recorded.unwrap_or(block.settings[block.table.cycle]);
        let Some(time) = time else {
            self.times = (0..self.rows).map(|row| row as f64 * cycle).collect();
            remarks.push("The recording has no time column: each row counts as one call.".into());
            return Ok(());
        };
        let times = csv.times(time)?;
        let step = |times: &[f64]| {
            let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let middle = steps.len() / 2;
            if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
        };
        self.times = times.seconds;
        if !times.is_unit_known {
            // Decide between seconds and milliseconds: rows are probably about one cycle apart.
            let values = &csv.columns[time].values;
            let far = |scale: f64| (step(values) * scale / cycle).log10().abs();
            let (scale, unit) = if far(1e-3) < far(1.0) { (1000.0, "milliseconds") } else { (1.0, "seconds") };
            self.times = values.iter().map(|value| value / scale).collect();
            if scale != 1.0 {
                remarks.push(format!(
                    "Column {} has no unit and is read as {unit}. If this is wrong, add the unit to the header.",
                    csv.columns[time].name
                ));
            }
        }
        let spacing = step(&self.times);
        if spacing > 0.0 {
            self.spacing = Some(spacing);
            let ratio = (cycle / spacing).round();
            let is_whole = (cycle / spacing / ratio - 1.0).abs() < 0.02;
            self.between = self.rows_between_calls(ratio as usize).filter(|_| is_whole).unwrap_or_default();
            if !self.between.is_empty() {
                remarks.push(format!(
                    "The rows are {} s apart, and the outputs change only in every {} row, like those of a block \
                     called every {} s: the rows in between are not calls.",
                    short(spacing),
                    ordinal(ratio as usize),
                    short(cycle)
                ));
            } else if (spacing / cycle - 1.0).abs() > 0.02 {
                self.is_coarse = spacing > COARSE * cycle;
                remarks.push(format!(
                    "Most rows are {} s apart, but the block is called every {} s: each row counts as one call.",
                    short(spacing),
                    short(cycle)
                ));
            }
            let gap = self.times.windows(2).position(|pair| pair[1] - pair[0] > 1.6 * spacing);
            if let Some(row) = gap {
                let gaps = self.times.windows(2).filter(|pair| pair[1] - pair[0] > 1.6 * spacing).count();
                remarks.push(format!(
                    "{gaps} {} longer than the others, the first after line {} ({} s): rows or calls are missing.",
                    if gaps == 1 { "time step is" } else { "time steps are" },
                    self.lines[row],
                    short(self.times[row])
                ));
            }
        }
        Ok(())
    }
}

/// Whether a variable with this role can be set while the block runs.
pub(super) fn is_tunable(role: Role) -> bool {
    matches!(role, Role::Input | Role::Parameter)
}

fn found(csv: &Csv, name: &str) -> Result<usize> {
    csv.column(name)?;
    csv.find(name).context("the column is there")
}

/// Matches columns and variables by name.
fn matched(block: &Block, csv: &Csv, time: Option<usize>, remarks: &mut Vec<String>) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    let mut left = Vec::new();
    // If column names include the loop's name, the GAIN of another member is not the loop's.
    let is_own = |name: &str| {
        let mut owners = ends(name).filter_map(|end| Some(end.split_once('.')?.0.trim_matches('"')));
        owners.any(|owner| owner.eq_ignore_ascii_case(block.name()))
    };
    let has_names = csv.columns.iter().any(|of| is_own(&of.name));
    for (column, of) in csv.columns.iter().enumerate().filter(|(column, _)| Some(*column) != time) {
        let is_of_loop = !has_names || is_own(&of.name) || ends(&of.name).count() == 1;
        match variable_of(block, &of.name).filter(|_| is_of_loop) {
            Some(row) if pairs.iter().any(|(_, other)| *other == row) => {
                remarks.push(format!("{} occurs twice; column {} is ignored.", block.table.rows[row].name, of.name));
            }
            Some(row) => pairs.push((column, row)),
            None => left.push(column),
        }
    }
    let roles = block.roles;
    let manual = roles.manual_switch().cloned();
    let by_role: [(&Option<String>, &[&str]); 4] = [
        (&roles.setpoint, &SETPOINTS),
        (&roles.process_value, &PROCESS_VALUES),
        (&roles.manipulated_value, &MANIPULATED_VALUES),
        (&manual, &MANUAL),
    ];
    for (role, names) in by_role {
        let Some(row) = block.row(role.as_ref()).filter(|row| !pairs.iter().any(|(_, other)| other == row)) else {
            continue;
        };
        // Even if the block also has an output of that name, a column PV is taken to be the block's input.
        let is_called = |column: usize| names.contains(&short_name(&csv.columns[column].name).as_str());
        let shown = block.row(roles.shown_process_value.as_ref());
        let is_shown = |column: usize| {
            *role == roles.process_value && pairs.iter().any(|pair| Some(pair.1) == shown && pair.0 == column)
        };
        let mut candidates = (0..csv.columns.len()).filter(|column| Some(*column) != time);
        let candidate = candidates.find(|column| left.contains(column) && is_called(*column) || is_shown(*column));
        // A peripheral word in the file takes precedence over the number.
        let has_word = *role == roles.process_value
            && block.peripheral().is_some_and(|(word, _)| pairs.iter().any(|(_, other)| *other == word));
        if let Some(column) = candidate.filter(|_| !has_word) {
            left.retain(|other| *other != column);
            // A column that sets a variable cannot be compared as well.
            pairs.retain(|(other, _)| *other != column);
            pairs.push((column, row));
        }
    }
    let unused: Vec<_> = left.iter().map(|column| csv.columns[*column].name.as_str()).collect();
    if !unused.is_empty() {
        let list = unused.iter().take(8).copied().collect::<Vec<_>>().join(", ");
        let more = if unused.len() > 8 { format!(" and {} more", unused.len() - 8) } else { String::new() };
        let are = if unused.len() == 1 { "is not a variable" } else { "are not variables" };
        remarks.push(format!("{list}{more} {are} of {}: ignored.", block.table.name));
    }
    pairs
}

/// Returns the row in the table of the variable that a column is named after.
fn variable_of(block: &Block, column: &str) -> Option<usize> {
    let rows = &block.table.rows;
    let of = |name: &str| rows.iter().position(|row| row.name.eq_ignore_ascii_case(name));
    let plain = |name: &str| {
        let lower = name.to_lowercase();
        let prefix = ["in_", "out_"].iter().find(|prefix| lower.starts_with(**prefix)).map_or(0, |prefix| prefix.len());
        of(name).or_else(|| of(&name[prefix..]))
    };
    if let Some(row) = ends(column).find_map(plain) {
        return Some(row);
    }
    // `TIC101_LMN` where the loop is called TIC101.
    let loop_name = block.name();
    let last = ends(column).last()?;
    let prefix = last.get(..loop_name.len()).filter(|prefix| prefix.eq_ignore_ascii_case(loop_name))?;
    of(last[prefix.len()..].trim_start_matches(['_', '-', ' ', '.']))
}

/// Returns the unit, in seconds, of TIME columns without one: seconds or milliseconds, whichever is closer to the
/// settings of the loop.
fn time_scale(block: &Block, csv: &Csv, pairs: &[(usize, usize)]) -> f64 {
    let (mut seconds, mut milliseconds) = (0.0, 0.0);
    for (column, row) in pairs {
        let (of, own) = (&csv.columns[*column], block.settings[*row]);
        let value = of.values.iter().copied().find(|value| *value > 0.0);
        if block.table.rows[*row].kind == Kind::Time
            && of.unit.is_none()
            && own > 0.0
            && let Some(value) = value
        {
            seconds += (value / own).log10().abs();
            milliseconds += (value / 1000.0 / own).log10().abs();
            // The type cannot represent fractions of a millisecond.
            if of.values.iter().any(|value| value.fract() != 0.0) {
                milliseconds += 100.0;
            }
        }
    }
    if milliseconds < seconds { 1e-3 } else { 1.0 }
}
