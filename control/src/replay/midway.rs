//! A setting that was changed during the recording: the block reproduces the recording with one value up to a row, and
//! with another from there onward.
//!
//! If the block agrees with the recording at first, the value before the change is the loop's. Otherwise, that value is
//! searched for in the first rows and accepted only if it explains more rows than were searched. The value after the
//! change and the row of the change are searched for together. Of the interpretations of the recording, the one whose
//! outputs are closest to those recorded before the change wins. All settings are judged by the tolerance computed for
//! the one that fits best. Only an answer that explains every row is accepted.

use super::Suspect;
use super::change::{Change, Since};
use super::compare::{CLEARLY, Comparison, Outcome};
use super::estimate::{Found, Search};
use super::instance::{Beginning, Later, Variant, change};
use super::suspects::{Diagnosis, Tried, fitting, is_wide, range_to_tell};
use anyhow::Result;
use std::collections::{BTreeMap, BTreeSet};

/// The minimum number of rows before a change and after it; fewer prove nothing.
const FEWEST: usize = 8;

/// The number of rows after the first difference that the search for the value before the change includes.
const BEFORE: usize = 40;

/// The number of rows after the first difference that the search for the value after the change includes.
const AFTER: usize = 600;

/// The maximum number of calls spent on each search.
const MOST_CALLS: usize = 6_000_000;

/// The row of the change is searched for only for this many settings: those that fit best.
const MOST_MOVED: usize = 6;

/// The initial step of the search for the row of a change.
const STRIDE: usize = 16;

/// A start is worse than another if its mean square residual is more than this many times as large.
const WORSE: f64 = 2.0;

/// A variant that explains the first rows of one interpretation of the recording.
#[derive(Clone)]
struct Start<'a> {
    comparison: &'a Comparison<'a>,
    /// The index of that interpretation.
    reading: usize,
    variant: Variant,
    /// The first row that the variant does not explain.
    first: usize,
}

/// The explanation of a recording by a change to a setting during the recording.
pub(super) struct Midway {
    /// The index of the interpretation of the recording.
    pub(super) reading: usize,
    /// The run with the settings of the loop.
    pub(super) base: Outcome,
    pub(super) suspects: Vec<Suspect>,
}

/// Finds settings whose change during the recording explains at least one of these interpretations of the recording.
pub(super) fn midway(readings: &[Comparison]) -> Result<Option<Midway>> {
    let mut all = Vec::new();
    for (reading, comparison) in readings.iter().enumerate() {
        for beginning in comparison.beginnings(Beginning::Fresh) {
            let skipped = comparison.recording.between.clone();
            let variant = Variant { beginning, skipped, ..Variant::default() };
            let first = comparison.run(&variant, comparison.recording.rows)?.first();
            all.extend(first.map(|first| Start { comparison, reading, variant, first }));
        }
    }
    let agreeing = all.iter().filter(|start| start.first >= FEWEST).cloned().collect();
    if let Some(midway) = answer(agreeing)? {
        return Ok(Some(midway));
    }
    let mut before = Vec::new();
    for start in &all {
        before.extend(start.before()?);
    }
    answer(before)
}

/// Returns the answer with the fewest changed settings from any of these starts; if there are several, the one from the
/// start that fits best. It is uncertain if a different start has an answer with equally few settings.
fn answer(starts: Vec<Start>) -> Result<Option<Midway>> {
    let mut best: Option<(usize, Midway)> = None;
    for start in judged(starts) {
        let suspects = start.changed()?;
        let Some(settings) = suspects.iter().map(settings).min() else { continue };
        match &mut best {
            Some((fewest, midway)) if *fewest <= settings => {
                midway.suspects.iter_mut().for_each(|suspect| suspect.is_sure = false);
            }
            _ => {
                let comparison = start.comparison;
                let own = Variant { values: BTreeMap::new(), ..start.variant };
                let base = comparison.run(&own, comparison.recording.rows)?;
                best = Some((settings, Midway { reading: start.reading, base, suspects }));
            }
        }
        // There is no answer with fewer than one setting.
        if settings == 1 {
            break;
        }
    }
    Ok(best.map(|(_, midway)| midway))
}

/// Returns the number of settings that differ from the loop's, from the start or later.
fn settings(suspect: &Suspect) -> usize {
    let changes = suspect.changes.iter().chain(suspect.since.as_ref().map(|since| &since.change));
    let names = changes.filter_map(|change| match change {
        Change::Setting { name, .. } => Some(name),
        _ => None,
    });
    names.collect::<BTreeSet<_>>().len()
}

/// Returns the starts that fit best in the rows that all of them explain, best first. The number of rows is no measure:
/// a start with a larger tolerance explains more of them without fitting better.
fn judged(mut starts: Vec<Start>) -> Vec<Start> {
    let farthest = starts.iter().map(|start| start.first).max().unwrap_or_default();
    starts.retain(|start| start.first >= farthest / 2);
    let common = starts.iter().map(|start| start.first).min().unwrap_or_default();
    let error = |start: &Start| Search::new(start.comparison, common, MOST_CALLS).error(&start.variant);
    let mut starts: Vec<(f64, Start)> = starts.into_iter().map(|start| (error(&start), start)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = starts.first().map_or(0.0, |(error, _)| *error);
    starts.into_iter().filter(|(error, _)| *error <= WORSE * least).map(|(_, start)| start).collect()
}

impl<'a> Start<'a> {
    /// Returns the starts in which one setting has a different value, found in the first rows, that explains more rows
    /// than these.
    fn before(&self) -> Result<Vec<Start<'a>>> {
        let (comparison, total) = (self.comparison, self.comparison.recording.rows);
        let rows = (self.first + BEFORE).min(total);
        let search = Search::new(comparison, rows, MOST_CALLS);
        let base = Found { error: search.error(&self.variant), variant: self.variant.clone() };
        let mut all = Vec::new();
        for row in search.candidates(&base) {
            let Some(mut found) = search.one(&self.variant, row).filter(|found| search.fits(&found.variant)) else {
                continue;
            };
            let mut reached = rows;
            // Refine the value with all rows that it explains, as long as it then explains more.
            while let Some(first) =
                comparison.run(&found.variant, total)?.first().filter(|first| *first > reached + CLEARLY)
            {
                reached = first;
                let search = Search::new(comparison, first, MOST_CALLS);
                let from = Found { error: search.error(&found.variant), ..found };
                found = search.snapped(search.polished(from, &[row]), &[row]);
            }
            if reached > rows {
                all.push(Start { variant: found.variant, first: reached, ..*self });
            }
        }
        Ok(all)
    }

    /// Returns the settings whose change near the first difference explains all rows, best first.
    fn changed(&self) -> Result<Vec<Suspect>> {
        let (comparison, total) = (self.comparison, self.comparison.recording.rows);
        if self.first + FEWEST > total {
            return Ok(Vec::new());
        }
        let rows = (self.first + AFTER).min(total);
        let search = Search::new(comparison, rows, MOST_CALLS);
        let later = Some(Later { from: self.first, ..Later::default() });
        let variant = Variant { later, ..self.variant.clone() };
        let base = Found { error: search.error(&variant), variant };
        let candidates = search.candidates(&base);
        let ones = candidates.iter().filter_map(|row| Some((*row, search.one(&base.variant, *row)?)));
        let mut found: Vec<(usize, Found)> = ones.collect();
        let nearest = |found: &mut Vec<(usize, Found)>| found.sort_by(|a, b| a.1.error.total_cmp(&b.1.error));
        nearest(&mut found);
        for (row, found) in found.iter_mut().take(MOST_MOVED) {
            *found = search.snapped(moved(&search, found, *row), &[*row]);
        }
        nearest(&mut found);
        // If the search ran out of calls, accept only an exact fit: a setting that was not tried could otherwise
        // explain the recording as well.
        let is_enough = |best: &Found| best.error == 0.0 || search.may_go_on();
        let Some((_, best)) = found.first().filter(|(_, best)| is_enough(best)) else { return Ok(Vec::new()) };
        if comparison.run(&best.variant, total)?.different() > 0 {
            return Ok(Vec::new());
        }
        let spread = comparison.spread(&best.variant)?;
        let judge = Comparison { spread: Some(&spread), ..*comparison };
        let diagnosis = Diagnosis { comparison: &judge, search: Search::new(&judge, rows, MOST_CALLS), rows };
        let mut tried = Vec::new();
        for (row, of) in &found {
            let outcome = judge.run(&of.variant, total)?;
            if outcome.different() == 0 {
                tried.push(Tried::estimated(outcome.without_outputs(), Vec::new(), vec![*row]));
            }
        }
        let is_one = fitting(&tried) == 1;
        tried.into_iter().map(|of| self.since(&diagnosis, &of.outcome, is_one)).collect()
    }

    /// Converts an outcome into a suspect: a setting that has another value from some row onward.
    fn since(&self, diagnosis: &Diagnosis, outcome: &Outcome, is_one: bool) -> Result<Suspect> {
        let (block, recording) = (self.comparison.block, self.comparison.recording);
        let variant = outcome.variant.clone();
        let later = variant.later.as_ref().expect("it was searched for from a row on");
        let (row, value) = later.values.iter().next().map(|(row, value)| (*row, *value)).expect("of a setting");
        let call = |row: usize| (row - recording.between.range(..row).count(), recording.times[row]);
        let search = &diagnosis.search;
        let found = Found { error: search.error(&variant), variant: variant.clone() };
        let [earliest, latest] = [true, false].map(|is_earlier| edge(search, &found, row, is_earlier));
        let ranges = [&found, &earliest, &latest].map(|found| search.range(found, row));
        let (low, high) = ranges.into_iter().fold((value, value), |all, (low, high)| (all.0.min(low), all.1.max(high)));
        let from = |found: &Found| found.variant.later.as_ref().map_or(later.from, |later| later.from);
        let of_start = |(row, value): (&usize, &f64)| change(block, *row, *value, None);
        let mut ends = self.variant.values.clone();
        ends.insert(row, value);
        ends.retain(|row, value| *value as f32 != block.settings[*row] as f32);
        let own = change(block, row, value, self.variant.values.get(&row));
        let mut whole = self.variant.clone();
        whole.values.insert(row, value);
        // If the new value fits from the start, the setting was not changed during the recording.
        let is_whole = from(&earliest) <= 1 && self.comparison.run(&whole, recording.rows)?.different() == 0;
        let (changes, since) = match is_whole {
            true => (whole.values.iter().map(of_start).collect(), None),
            false => {
                let [at, earliest, latest] = [later.from, from(&earliest), from(&latest)].map(call);
                (self.variant.values.iter().map(of_start).collect(), Some(Since { change: own, at, earliest, latest }))
            }
        };
        Ok(Suspect {
            changes,
            since,
            range: range_to_tell(low, high, value),
            // It is likelier that one setting was changed than two at the same time.
            confused: Vec::new(),
            values: diagnosis.named(ends.iter()),
            different: 0,
            largest: outcome.largest(),
            fits: true,
            is_sure: is_one && !is_wide(low, high, value) && search.may_go_on(),
            ends_without_call: self.comparison.ends_without_call(outcome)?,
        })
    }
}

/// Finds the row of the change and the value that fit best.
fn moved(search: &Search, from: &Found, row: usize) -> Found {
    let mut best = from.clone();
    let mut stride = STRIDE;
    while stride > 0 && best.error > 0.0 && search.may_go_on() {
        match at(search, &best, row, -(stride as isize)).filter(|there| there.error < best.error) {
            Some(there) => {
                best = there;
                stride *= 2;
            }
            None => stride /= 2,
        }
    }
    best
}

/// Finds the earliest or the latest row of the change that the recording allows.
fn edge(search: &Search, from: &Found, row: usize, is_earlier: bool) -> Found {
    let mut edge = from.clone();
    let mut stride = 1;
    while stride > 0 && search.may_go_on() {
        let by = if is_earlier { -(stride as isize) } else { stride as isize };
        match at(search, &edge, row, by).filter(|there| search.fits(&there.variant)) {
            Some(there) => {
                edge = there;
                stride *= 2;
            }
            None => stride /= 2,
        }
    }
    edge
}

/// Moves the change by this many rows and finds the value that fits best there.
fn at(search: &Search, of: &Found, row: usize, by: isize) -> Option<Found> {
    let mut variant = of.variant.clone();
    let later = variant.later.as_mut()?;
    let from = later.from.checked_add_signed(by).unwrap_or(0).max(1);
    if from == later.from || from >= search.rows {
        return None;
    }
    later.from = from;
    let there = Found { error: search.error(&variant), variant };
    // If the value fits at least as well there, keep it.
    if search.fits(&there.variant) && there.error <= of.error {
        return Some(there);
    }
    Some(search.polished(there, &[row]))
}
