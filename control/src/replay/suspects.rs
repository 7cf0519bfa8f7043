//! What usually is the matter when a recording and a block do not agree, tried one after the other.

use super::Suspect;
use super::columns::Signal;
use super::compare::{Comparison, Outcome, rank};
use super::instance::Variant;
use anyhow::Result;
use blocks::Kind;
use modeldescription::digits::short;
use run::fmus::Values;
use run::system::Value;

/// So many rows behind the first difference tell whether a suspect is worth a full run.
const BEHIND: usize = 3_000;

/// So many calls may be spent on trying.
const MOST_CALLS: usize = 3_000_000;

/// So many missed calls are looked for.
const MOST_MISSED: usize = 10;

/// At most so many suspects are answered.
const MOST_SUSPECTS: usize = 8;

/// A suspect to be tried.
struct Try {
    variant: Variant,
    /// `CYCLE is 0.2 s instead of 0.1 s`
    text: String,
}

/// Tries the usual suspects; those that make it better, the best first.
pub(super) fn tried(comparison: &Comparison, base: &Outcome) -> Result<Vec<Suspect>> {
    let all = comparison.recording.rows;
    let rows = (base.first().unwrap_or(0) + BEHIND).min(all);
    let mut tries = settings(comparison);
    let most = (MOST_CALLS / (6 * rows.max(1))).max(1);
    // Several calls for each row take as much longer.
    tries.retain(|of| of.variant.more_calls.saturating_mul(rows) <= MOST_CALLS / 6);
    tries.truncate(most);
    let before = comparison.run(&base.variant, rows)?;
    let mut better: Vec<(Outcome, String)> = Vec::new();
    for Try { variant, text } in tries {
        let Ok(outcome) = comparison.best(&variant, rows).map(Outcome::without_outputs) else { continue };
        if rank(&outcome) < rank(&before) {
            better.push((outcome, text));
        }
    }
    better.extend(missed(comparison, &before, rows)?);
    sort(&mut better);
    if better.first().is_none_or(|(outcome, _)| outcome.different() > 0) {
        better.extend(pairs(comparison, &better, rows));
        sort(&mut better);
    }
    better.truncate(MOST_SUSPECTS);
    // The best ones over all rows.
    let mut suspects = Vec::new();
    for (outcome, text) in better {
        let outcome = if rows < all { comparison.run(&outcome.variant, all)? } else { outcome };
        if rank(&outcome) >= rank(base) {
            continue;
        }
        let value = |(row, value): (&usize, &f64)| {
            let of = &comparison.block.table.variables[*row];
            let value = if of.kind == Kind::Bool { Value::Boolean(*value != 0.0) } else { Value::Number(*value) };
            (of.name.clone(), value)
        };
        suspects.push(Suspect {
            text: format!("{text}."),
            values: outcome.variant.values.iter().map(value).collect::<Values>(),
            different: outcome.different(),
            largest: outcome.largest(),
            fits: outcome.different() == 0,
        });
    }
    suspects.sort_by(|a, b| (a.different, a.largest).partial_cmp(&(b.different, b.largest)).expect("finite"));
    Ok(suspects)
}

fn sort(better: &mut [(Outcome, String)]) {
    better.sort_by(|(a, _), (b, _)| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
}

/// Two suspects at once.
fn pairs(comparison: &Comparison, better: &[(Outcome, String)], rows: usize) -> Vec<(Outcome, String)> {
    let mut found = Vec::new();
    let best: Vec<_> = better.iter().filter(|(of, _)| !of.variant.values.is_empty()).take(6).collect();
    for (number, (a, a_text)) in best.iter().enumerate() {
        for (b, b_text) in &best[number + 1..] {
            if b.variant.values.keys().any(|row| a.variant.values.contains_key(row)) {
                continue;
            }
            let mut variant = a.variant.clone();
            variant.values.extend(&b.variant.values);
            variant.more_calls = variant.more_calls.max(b.variant.more_calls);
            if let Ok(outcome) = comparison.best(&variant, rows).map(Outcome::without_outputs)
                && rank(&outcome) < rank(a)
                && rank(&outcome) < rank(b)
            {
                found.push((outcome, format!("{a_text}, and {b_text}")));
            }
        }
    }
    found
}

/// A row without a call, or a call without a row, where the difference begins; then the next ones.
fn missed(comparison: &Comparison, base: &Outcome, rows: usize) -> Result<Option<(Outcome, String)>> {
    let (mut variant, mut best) = (base.variant.clone(), rank(base));
    let mut first = base.first();
    let mut found: Vec<String> = Vec::new();
    let mut outcome = None;
    let line = |row: usize| comparison.recording.lines[row];
    let time = |row: usize| short(comparison.recording.times[row]);
    while let Some(at) = first
        && found.len() < MOST_MISSED
    {
        let mut step: Option<(Outcome, String)> = None;
        // Far into a recording, each run takes long.
        let earlier = if rows.saturating_mul(40) > MOST_CALLS { 0 } else { 4 };
        for row in (at.saturating_sub(earlier).max(1)..=at).rev() {
            let mut without = variant.clone();
            without.skipped.insert(row);
            let mut with = variant.clone();
            with.doubled.insert(row);
            for (variant, text) in [
                (without, format!("the call of line {} ({} s) is left out", line(row), time(row))),
                (with, format!("one more call is made before line {} ({} s)", line(row), time(row))),
            ] {
                let now = comparison.run(&variant, rows)?.without_outputs();
                let is_later = now.first().is_none_or(|first| first > at + 2);
                let is_best = step.as_ref().is_none_or(|(step, _)| rank(&now) < rank(step));
                if is_later && is_best && rank(&now) < best {
                    step = Some((now, text));
                }
            }
        }
        let Some((now, text)) = step else { break };
        (variant, best, first) = (now.variant.clone(), rank(&now), now.first());
        found.push(text);
        outcome = Some(now);
    }
    Ok(outcome.map(|outcome| {
        let more = found.len() - 1;
        let text = match more {
            0 => found.swap_remove(0),
            _ => format!("{}, and {}", found[..more].join(", "), found[more]),
        };
        (outcome, text)
    }))
}

/// All single changes of settings.
fn settings(comparison: &Comparison) -> Vec<Try> {
    let (block, recording) = (comparison.block, comparison.recording);
    let mut tries = Tries { comparison, tries: Vec::new() };
    let roles = block.roles;
    let cycle = Some(block.table.cycle);
    if let Some(spacing) = recording.spacing {
        let spacing = (spacing * 1000.0).round() / 1000.0;
        tries.value(cycle, spacing, ", the spacing of the rows");
        let own = block.settings[block.table.cycle];
        let calls = (spacing / own).round();
        if (2.0..=1000.0).contains(&calls) && (spacing / own / calls - 1.0).abs() < 0.02 {
            let variant = Variant { more_calls: calls as usize - 1, ..Variant::default() };
            tries.tries.push(Try { variant, text: format!("the block is called {calls} times from row to row") });
        }
    }
    for (factor, what) in [(0.5, ": half"), (2.0, ": twice"), (10.0, ": ten times"), (0.1, ": a tenth")] {
        tries.factor(cycle, factor, what);
    }
    tries.factor(block.row(roles.controller.first()), -1.0, ": the other sign");
    limits(&mut tries);
    tries.switch(block.named("PVPER_ON"));
    structure(&mut tries);
    for time in roles.controller.get(1..).unwrap_or_default() {
        for (factor, what) in [
            (60.0, ": minutes, not seconds"),
            (1.0 / 60.0, ": seconds, not minutes"),
            (1000.0, ": seconds, not milliseconds"),
            (0.001, ": milliseconds, not seconds"),
        ] {
            tries.factor(block.row(Some(time)), factor, what);
        }
    }
    dead_band(&mut tries);
    tries.tries
}

/// Changes of settings that are collected.
struct Tries<'a> {
    comparison: &'a Comparison<'a>,
    tries: Vec<Try>,
}

impl Tries<'_> {
    /// What a variable is set to now; nothing if the block does not have it or the recording sets it.
    fn own(&self, row: Option<usize>) -> Option<(usize, f64)> {
        let row = row?;
        let is_recorded =
            self.comparison.recording.inputs.iter().any(|input| input.row == row && input.values.len() > 1);
        (!is_recorded).then(|| (row, self.comparison.block.settings[row]))
    }

    fn value(&mut self, row: Option<usize>, value: f64, why: &str) {
        self.values(&[(row, value)], why);
    }

    /// Tries several values at once.
    fn values(&mut self, values: &[(Option<usize>, f64)], why: &str) {
        let mut variant = Variant::default();
        let mut texts = Vec::new();
        for (row, value) in values {
            let Some((row, own)) = self.own(*row) else { return };
            let of = &self.comparison.block.table.variables[row];
            let value = match of.kind {
                Kind::Time => (value * 1000.0).round() / 1000.0,
                Kind::Real => f64::from(*value as f32),
                _ => *value,
            };
            let is_held = blocks::table::number::to_value(value, of.kind).is_ok();
            if value == own || !is_held || of.kind == Kind::Time && value < 0.001 {
                return;
            }
            let unit = if of.kind == Kind::Time { " s" } else { "" };
            let text = |value: f64| match of.kind {
                Kind::Bool => if value == 0.0 { "FALSE" } else { "TRUE" }.to_string(),
                Kind::Real => format!("{}{unit}", value as f32),
                _ => format!("{value}{unit}"),
            };
            texts.push(format!("{} is {} instead of {}", of.name, text(value), text(own)));
            variant.values.insert(row, value);
        }
        let text = format!("{}{why}", texts.join(" and "));
        if !self.tries.iter().any(|other| other.variant == variant) {
            self.tries.push(Try { variant, text });
        }
    }

    fn factor(&mut self, row: Option<usize>, factor: f64, why: &str) {
        if let Some((row, own)) = self.own(row) {
            self.value(Some(row), own * factor, why);
        }
    }

    fn switch(&mut self, row: Option<usize>) {
        if let Some((row, own)) = self.own(row) {
            self.value(Some(row), 1.0 - own, "");
        }
    }
}

/// The limits of the manipulated value, where the recording stays at its highest or its lowest value.
fn limits(tries: &mut Tries) {
    let (block, recording) = (tries.comparison.block, tries.comparison.recording);
    let Some(manipulated) = block.manipulated(recording) else { return };
    let values = &recording.outputs[manipulated].values;
    let stays = |extreme: f64| values.windows(2).filter(|pair| pair[0] == extreme && pair[1] == extreme).count() > 1;
    let known = || values.iter().copied().filter(|value| value.is_finite());
    let (high, low) = (known().fold(f64::NEG_INFINITY, f64::max), known().fold(f64::INFINITY, f64::min));
    let why = ": there the recording stays";
    let high = (block.named("LMN_HLM"), high);
    let low = (block.named("LMN_LLM"), low);
    if stays(high.1) {
        tries.values(&[high], why);
    }
    if stays(low.1) {
        tries.values(&[low], why);
    }
    if stays(high.1) && stays(low.1) {
        tries.values(&[high, low], why);
    }
}

/// The other structures: P, PI, PD, PID and so on.
fn structure(tries: &mut Tries) {
    let block = tries.comparison.block;
    let switches: Vec<usize> = block.roles.structure.iter().filter_map(|name| block.table.find(name)).take(4).collect();
    for choice in 1..1usize << switches.len() {
        let chosen: Vec<_> = switches
            .iter()
            .enumerate()
            .filter(|(number, _)| choice >> number & 1 == 1)
            .map(|(_, row)| (Some(*row), 1.0 - block.settings[*row]))
            .collect();
        tries.values(&chosen, "");
    }
}

/// The dead band: none, or as wide as the deviations at which the recorded manipulated value does not move.
fn dead_band(tries: &mut Tries) {
    let (block, recording) = (tries.comparison.block, tries.comparison.recording);
    let row = block.named("DEADB_W");
    tries.value(row, 0.0, ": no dead band");
    let signal = |name: Option<&String>| -> Option<&Signal> {
        let row = block.row(name)?;
        recording.inputs.iter().find(|input| input.row == row)
    };
    let Some(process_value) = signal(block.roles.process_value.as_ref()) else { return };
    let Some(output) = block.manipulated(recording) else { return };
    let setpoint = signal(block.roles.setpoint.as_ref());
    let own_setpoint = block.row(block.roles.setpoint.as_ref()).map_or(0.0, |row| block.settings[row]);
    let manipulated = &recording.outputs[output].values;
    let deviation = |row: usize| setpoint.map_or(own_setpoint, |of| of.values[row]) - process_value.values[row];
    let (mut rests, mut moves) = (Vec::new(), Vec::new());
    for at in 1..recording.rows.min(200_000) {
        let (now, before) = (deviation(at).abs(), deviation(at - 1).abs());
        // A deviation that does not change moves nothing without an I action.
        if manipulated[at] == manipulated[at - 1] && now != before {
            rests.push(now.max(before));
        } else if manipulated[at] != manipulated[at - 1] {
            moves.push(now.max(before));
        }
    }
    if rests.len() < 3 {
        return;
    }
    // At the limits it does not move either, with large deviations.
    rests.sort_by(f64::total_cmp);
    let low = moves.iter().copied().fold(f64::INFINITY, f64::min);
    let rests: Vec<f64> = rests.into_iter().filter(|rest| *rest <= low).collect();
    let Some(high) = rests.last() else { return };
    for value in round_numbers(*high, if low.is_finite() { low } else { 2.0 * high }) {
        tries.value(row, value, ": within it the recording rests");
    }
}

/// The numbers with the fewest digits from one to another, at most three.
fn round_numbers(low: f64, high: f64) -> Vec<f64> {
    if !(low > 0.0 && low <= high && high.is_finite()) {
        return Vec::new();
    }
    for exponent in (-7..=6).rev() {
        let step = 10f64.powi(exponent);
        for step in [step, step / 2.0] {
            let first = (low / step - 1e-9).ceil();
            let numbers: Vec<f64> = (0..3)
                .map(|number| first + f64::from(number))
                .filter(|number| number * step <= high * (1.0 + 1e-9))
                // Powers of ten below 1 are no binary numbers; their inverses are.
                .map(|number| if step < 1.0 { number / (1.0 / step).round() } else { number * step })
                .collect();
            if !numbers.is_empty() {
                return numbers;
            }
        }
    }
    vec![low]
}
