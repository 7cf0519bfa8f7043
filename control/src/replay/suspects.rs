//! Explanations for a difference between a recording and a block: common mistakes are tried, numbers are searched for.

use super::Suspect;
use super::change::{Change, Why};
use super::columns::Signal;
use super::compare::{Comparison, Outcome, rank};
use super::estimate::{Found, Search, held};
use super::instance::{Block, Variant, change, typed};
use crate::extremes;
use crate::tune::rounded;
use anyhow::Result;
use blocks::Kind;
use run::fmus::{Values, number_of};
use std::collections::BTreeSet;

/// The number of rows after the first difference that show whether a suspect is worth a full run.
const BEHIND: usize = 3_000;

/// The maximum number of calls spent on trying suspects.
const MOST_CALLS: usize = 3_000_000;

/// The maximum number of missed calls searched for.
const MOST_MISSED: usize = 10;

/// The maximum number of settings among which pairs are tried.
const MOST_PAIRED: usize = 6;

/// A value far beyond any limit.
const BEYOND: f64 = 1e6;

/// The end of a range that is open on one side: any value beyond the other end explains the recording.
pub(super) const OPEN: f64 = f64::MAX;

/// A value with at most this many significant digits looks like a typed one.
const FEW: i32 = 4;

/// Two settings count as an explanation if less than this fraction of the error remains.
const GOOD: f64 = 0.05;

/// A value is certain if its range is narrower than this fraction of the value.
const WIDE: f64 = 0.15;

/// The maximum number of suspects in the answer.
const MOST_SUSPECTS: usize = 8;

/// A suspect to be tried.
struct Try {
    variant: Variant,
    changes: Vec<Change>,
}

impl Try {
    /// Whether the times of the recording leave no other CYCLE: a recording cannot have more rows with new outputs than
    /// calls, and outputs that change only in every n-th row are those of a slower block.
    fn is_sure(&self, comparison: &Comparison) -> bool {
        let own = comparison.block.settings[comparison.block.table.cycle];
        self.changes.iter().any(|change| match change {
            Change::Setting { why: Some(Why::Rhythm(_)), .. } => true,
            Change::Setting { value, why: Some(Why::Spacing), .. } => number_of(*value) < own,
            _ => false,
        })
    }
}

/// A suspect that was tried.
pub(super) struct Tried {
    pub(super) outcome: Outcome,
    changes: Vec<Change>,
    /// The settings that it changes, including numbers that were searched for.
    rows: Vec<usize>,
    is_estimate: bool,
    range: Option<(f64, f64)>,
    confused: Vec<String>,
}

impl Tried {
    fn new(outcome: Outcome, changes: Vec<Change>, rows: Vec<usize>) -> Tried {
        Tried { outcome, changes, rows, is_estimate: false, range: None, confused: Vec::new() }
    }

    /// Creates a tried suspect whose numbers were searched for.
    pub(super) fn estimated(outcome: Outcome, changes: Vec<Change>, rows: Vec<usize>) -> Tried {
        Tried { is_estimate: true, ..Tried::new(outcome, changes, rows) }
    }
}

/// Tries explanations and returns them, best first. The mode is tried first, then the time, single settings, and pairs.
pub(super) fn tried(comparison: &Comparison, base: &Outcome) -> Result<Vec<Suspect>> {
    let rows = (base.first().unwrap_or(0) + BEHIND).min(comparison.recording.rows);
    let search = Search::new(comparison, rows, MOST_CALLS);
    let diagnosis = Diagnosis { comparison, search, rows };
    let (start, mut known) = match mode(comparison, base) {
        Some(Try { variant, changes }) => (comparison.best(&variant, rows)?, changes),
        None => (comparison.run(&base.variant, rows)?, Vec::new()),
    };
    let mut start = start.without_outputs();
    let mut all: Vec<Tried> = Vec::new();
    let mut is_told = false;
    if !known.is_empty() {
        is_told = start.different() == 0;
        all.push(Tried::new(start.clone(), known.clone(), Vec::new()));
    }
    if !is_told {
        let of_time = diagnosis.discrete(&start, time(comparison), &|changes| after(&known, changes));
        is_told = of_time.iter().any(|tried| tried.outcome.different() == 0);
        all.extend(of_time);
    }
    // Correct a CYCLE that is certainly wrong first: otherwise, a wrong TI would compensate for it.
    if !is_told
        && let Some(Try { mut variant, changes }) = time(comparison).into_iter().find(|one| one.is_sure(comparison))
    {
        variant.values.extend(&start.variant.values);
        start = comparison.best(&variant, rows)?.without_outputs();
        known.extend(changes);
    }
    let whole = |changes: Vec<Change>| after(&known, changes);
    let mut is_sure = is_told;
    // If the recorder is slower than the block, do not search: a wrong TI would compensate for the calls between the
    // rows.
    if !is_told && !comparison.recording.is_coarse {
        let (found, sure) = diagnosis.settings(&start, &whole)?;
        is_sure = sure;
        all.extend(found);
    }
    // A limit that the recording exceeds is certainly wrong.
    let is_explained = all.iter().any(|tried| tried.outcome.different() == 0);
    if !is_explained
        && !comparison.recording.is_coarse
        && let Some(Try { mut variant, changes }) = exceeded(comparison)
    {
        variant.values.extend(&start.variant.values);
        let start = comparison.best(&variant, rows)?.without_outputs();
        let known = after(&known, changes);
        let (found, sure) = diagnosis.settings(&start, &|changes| after(&known, changes))?;
        if found.iter().any(|tried| tried.outcome.different() == 0) {
            is_sure = sure;
            all.extend(found);
        }
    }
    all.sort_by(|a, b| rank(&a.outcome).partial_cmp(&rank(&b.outcome)).unwrap_or(std::cmp::Ordering::Equal));
    all.truncate(MOST_SUSPECTS);
    diagnosis.told(all, is_sure, base)
}

/// Returns the known changes followed by `changes`.
fn after(known: &[Change], changes: Vec<Change>) -> Vec<Change> {
    known.iter().cloned().chain(changes).collect()
}

/// Prepends the known changes to the mode and CYCLE to other changes.
type Whole<'a> = &'a dyn Fn(Vec<Change>) -> Vec<Change>;

pub(super) struct Diagnosis<'a> {
    pub(super) comparison: &'a Comparison<'a>,
    pub(super) search: Search<'a>,
    pub(super) rows: usize,
}

impl Diagnosis<'_> {
    /// Runs the tries and returns those that reduce the differences.
    fn discrete(&self, start: &Outcome, tries: Vec<Try>, whole: Whole) -> Vec<Tried> {
        let mut better = Vec::new();
        for Try { mut variant, changes } in tries {
            // Skip tries that take too long because of several calls per row.
            if !self.search.may_go_on() || variant.more_calls.saturating_mul(self.rows) > MOST_CALLS / 6 {
                continue;
            }
            let rows: Vec<usize> = variant.values.keys().copied().collect();
            for (row, value) in &start.variant.values {
                variant.values.entry(*row).or_insert(*value);
            }
            if variant.skipped.is_empty() {
                variant.skipped.clone_from(&start.variant.skipped);
            }
            let Ok(outcome) = self.comparison.best(&variant, self.rows).map(Outcome::without_outputs) else { continue };
            if rank(&outcome) < rank(start) {
                better.push(Tried::new(outcome, whole(changes), rows));
            }
        }
        better
    }

    /// Tries single settings and missed calls and, if none of them explains everything, two settings at once. Also
    /// returns whether there is exactly one explanation and its values are certain.
    fn settings(&self, start: &Outcome, whole: Whole) -> Result<(Vec<Tried>, bool)> {
        let (search, block) = (&self.search, self.comparison.block);
        let base = Found { error: search.error(&start.variant), variant: start.variant.clone() };
        let mut tried = self.discrete(start, settings(self.comparison), whole);
        if let Some((outcome, changes)) = missed(self.comparison, start, self.rows)? {
            tried.push(Tried::new(outcome, whole(changes), Vec::new()));
        }
        let candidates = search.candidates(&base);
        // The beginning was chosen with settings that may be wrong: if no single setting explains the recording, try
        // the other beginnings.
        let mut found: Vec<(usize, Found)> = Vec::new();
        for beginning in self.comparison.beginnings(start.variant.beginning) {
            let base = Variant { beginning, ..start.variant.clone() };
            let ones: Vec<(usize, Found)> =
                candidates.iter().filter_map(|row| Some((*row, search.one(&base, *row)?))).collect();
            let error = |ones: &[(usize, Found)]| ones.iter().map(|(_, one)| one.error).fold(f64::INFINITY, f64::min);
            if error(&ones) < error(&found) {
                found = ones;
            }
            let is_exact = |one: &Found| one.error == 0.0 || search.has_numbers() && search.fits(&one.variant);
            if found.iter().any(|(_, one)| is_exact(one)) || !search.may_go_on() {
                break;
            }
        }
        let base = match found.first() {
            Some((_, one)) => {
                let variant = Variant { beginning: one.variant.beginning, ..base.variant };
                Found { error: search.error(&variant), variant }
            }
            None => base,
        };
        found.sort_by(|a, b| a.1.error.total_cmp(&b.1.error));
        let changes = |rows: &[usize], of: &Found| {
            let one = |row: &usize| change(block, *row, of.variant.values[row], start.variant.values.get(row));
            whole(rows.iter().map(one).collect())
        };
        let own = |row: &usize| start.variant.values.get(row).copied().unwrap_or(block.settings[*row]);
        let is_changed = |row: &usize, of: &Found| of.variant.values[row] as f32 != own(row) as f32;
        let estimate = |rows: &[usize], of: &Found| {
            if !rows.iter().all(|row| is_changed(row, of)) {
                return None;
            }
            let outcome = search.outcome(&of.variant)?;
            Some(Tried::estimated(outcome, changes(rows, of), rows.to_vec()))
        };
        tried.extend(found.iter().filter_map(|(row, of)| estimate(&[*row], of)));
        self.keep_likeliest(&mut tried);
        self.open_limits(&mut tried);
        let singles = fitting(&tried);
        if singles > 0 {
            let sure = singles == 1 && self.is_told(&mut tried, &candidates);
            return Ok((tried, sure));
        }
        let mut two = self.two_discrete(&tried);
        let is_of_controller = |row: &usize| block.roles.controller.contains(&block.table.rows[*row].name);
        let (usual, others): (Vec<usize>, Vec<usize>) = found.iter().map(|(row, _)| *row).partition(is_of_controller);
        let pair = |base: &Found, a: usize, b: usize| {
            let best = self.pair(base, &found, [a, b])?;
            estimate(&[a, b], &search.snapped(best, &[a, b]))
        };
        // Try pairs of the controller's settings first, with each beginning: the beginning cannot be judged on its own
        // while the settings are wrong.
        for beginning in self.comparison.beginnings(base.variant.beginning) {
            let variant = Variant { beginning, ..base.variant.clone() };
            let base = Found { error: search.error(&variant), variant };
            two.extend(pairs(&usual).filter_map(|[a, b]| pair(&base, a, b)));
            if fitting(&two) > 0 {
                break;
            }
        }
        two.extend(self.besides(&tried, &base, &is_changed));
        let best: Vec<usize> = usual.iter().chain(&others).copied().take(MOST_PAIRED).collect();
        let is_new = |rows: &[usize; 2]| rows.iter().any(|row| others.contains(row));
        two.extend(pairs(&best).filter(is_new).filter_map(|[a, b]| pair(&base, a, b)));
        self.keep_likeliest(&mut two);
        self.open_limits(&mut two);
        let pairs = fitting(&two);
        let sure = pairs == 1 && self.is_told(&mut two, &candidates);
        tried.extend(two);
        Ok((tried, sure))
    }

    /// Returns the best values of two settings; `None` if too much of the error remains.
    fn pair(&self, base: &Found, found: &[(usize, Found)], rows: [usize; 2]) -> Option<Found> {
        let search = &self.search;
        if !search.may_go_on() {
            return None;
        }
        let beginning = base.variant.beginning;
        let of = |row: &usize| found.iter().find(|(other, _)| other == row).map(|(_, of)| of.clone());
        let one = |of: Found| {
            let variant = Variant { beginning, ..of.variant };
            Found { error: search.error(&variant), variant }
        };
        let starts = [Some(base.clone()), of(&rows[0]).map(one), of(&rows[1]).map(one)].into_iter().flatten();
        let all: Vec<Found> = match search.has_numbers() {
            true => starts.map(|start| search.polished(start, &rows)).collect(),
            false => search.two(base, &rows).into_iter().collect(),
        };
        let best = all.into_iter().min_by(|a, b| a.error.total_cmp(&b.error))?;
        let has_both = rows.iter().all(|row| best.variant.values.contains_key(row));
        (has_both && best.error < GOOD * base.error).then_some(best)
    }

    /// Tries a switch, a limit or a sign together with a number.
    fn besides(&self, tried: &[Tried], base: &Found, is_changed: &dyn Fn(&usize, &Found) -> bool) -> Vec<Tried> {
        let (search, block) = (&self.search, self.comparison.block);
        let mut two = Vec::new();
        let mut discrete: Vec<&Tried> = tried.iter().filter(|of| !of.is_estimate && !of.rows.is_empty()).collect();
        discrete.sort_by(|a, b| search.error(&a.outcome.variant).total_cmp(&search.error(&b.outcome.variant)));
        for of in discrete.into_iter().take(3) {
            let variant = &of.outcome.variant;
            let from = Found { error: search.error(variant), variant: variant.clone() };
            for row in search.candidates(&from).into_iter().filter(|row| !of.rows.contains(row)) {
                if let Some(found) =
                    search.one(variant, row).filter(|found| found.error < GOOD * base.error && is_changed(&row, found))
                    && let Some(outcome) = search.outcome(&found.variant)
                {
                    let besides = change(block, row, found.variant.values[&row], None);
                    let changes = of.changes.iter().cloned().chain([besides]).collect();
                    let rows = of.rows.iter().copied().chain([row]).collect();
                    two.push(Tried::estimated(outcome, changes, rows));
                }
            }
        }
        two
    }

    /// Drops explanations that change more settings than needed: if one limit explains everything, a second one is
    /// superfluous. If only switches are recorded and one explanation reproduces them exactly, also drops those that
    /// need the tolerance.
    fn keep_likeliest(&self, tried: &mut Vec<Tried>) {
        let fits = |of: &Tried| of.outcome.different() == 0 && !of.rows.is_empty();
        // An explanation by settings needs no missed calls.
        if tried.iter().any(fits) {
            tried.retain(|of| !of.rows.is_empty() || of.outcome.different() > 0);
        }
        // The same set of settings may have been found more than once, in another order.
        let mut known = BTreeSet::new();
        tried.retain(|of| !fits(of) || known.insert(of.rows.iter().copied().collect::<BTreeSet<_>>()));
        let is_exact = |of: &Tried| of.outcome.largest() == 0.0;
        if !self.search.has_numbers() && tried.iter().any(|of| fits(of) && is_exact(of)) {
            tried.retain(|of| !fits(of) || is_exact(of));
        }
        let sets: Vec<Vec<usize>> = tried.iter().filter(|of| fits(of)).map(|of| of.rows.clone()).collect();
        let is_less =
            |set: &Vec<usize>, of: &Tried| set.len() < of.rows.len() && set.iter().all(|row| of.rows.contains(row));
        tried.retain(|of| !fits(of) || !sets.iter().any(|set| is_less(set, of)));
    }

    /// Combines two of the changes that need no search.
    fn two_discrete(&self, tried: &[Tried]) -> Vec<Tried> {
        let mut best: Vec<&Tried> = tried.iter().filter(|of| !of.is_estimate && !of.rows.is_empty()).collect();
        best.sort_by(|a, b| rank(&a.outcome).partial_cmp(&rank(&b.outcome)).unwrap_or(std::cmp::Ordering::Equal));
        best.truncate(6);
        let mut found = Vec::new();
        for (number, a) in best.iter().enumerate() {
            for b in best[number + 1..].iter().filter(|b| b.rows.iter().all(|row| !a.rows.contains(row))) {
                let mut variant = a.outcome.variant.clone();
                variant.values.extend(&b.outcome.variant.values);
                variant.more_calls = variant.more_calls.max(b.outcome.variant.more_calls);
                let Ok(outcome) = self.comparison.best(&variant, self.rows).map(Outcome::without_outputs) else {
                    continue;
                };
                if rank(&outcome) < rank(&a.outcome) && rank(&outcome) < rank(&b.outcome) {
                    // Both may contain the same known changes, such as that of the mode.
                    let rest = b.changes.iter().filter(|change| !a.changes.contains(change));
                    let changes = a.changes.iter().chain(rest).cloned().collect();
                    let rows = a.rows.iter().chain(&b.rows).copied().collect();
                    found.push(Tried::new(outcome, changes, rows));
                }
            }
        }
        found
    }

    /// Determines, for each explanation that fits, the range of its value and the settings that would explain the
    /// recording equally well, and adds them to it. Returns whether each value is certain and there are no such
    /// settings.
    fn is_told(&self, tried: &mut [Tried], candidates: &[usize]) -> bool {
        let (search, block) = (&self.search, self.comparison.block);
        let name = |row: &usize| block.table.rows[*row].name.clone();
        let mut is_told = true;
        for of in tried.iter_mut().filter(|of| of.outcome.different() == 0 && !of.rows.is_empty()) {
            let numbers: Vec<usize> = of.rows.iter().copied().filter(|row| candidates.contains(row)).collect();
            let variant = of.outcome.variant.clone();
            let found = Found { error: search.error(&variant), variant };
            let mut confused = Vec::new();
            for row in &numbers {
                let others: Vec<usize> = candidates.iter().copied().filter(|other| !of.rows.contains(other)).collect();
                let rest: Vec<usize> = numbers.iter().copied().filter(|other| other != row).collect();
                confused.extend(search.confused(&found, *row, &others).iter().map(name));
                confused.extend(search.confused(&found, *row, &rest).iter().map(name));
                if numbers.len() == 1 && of.range.is_none() {
                    let (low, high) = search.range(&found, *row);
                    let own = search.value(&found.variant, *row);
                    is_told &= !is_wide(low, high, own);
                    of.range = range_to_tell(low, high, own);
                }
            }
            confused.sort_unstable();
            confused.dedup();
            is_told &= confused.is_empty();
            of.confused = confused;
        }
        is_told
    }

    /// Opens the range of a limit that the manipulated value never reaches: any value beyond its recorded extreme
    /// explains the recording. The block's start value is preferred.
    fn open_limits(&self, tried: &mut [Tried]) {
        let (search, block) = (&self.search, self.comparison.block);
        let Some((high, low)) = block.roles.limits.as_ref() else { return };
        for of in tried.iter_mut().filter(|of| of.outcome.different() == 0) {
            let way_of = |row: &usize| match &block.table.rows[*row].name {
                name if name == high => Some(1.0),
                name if name == low => Some(-1.0),
                _ => None,
            };
            let Some((row, way)) = of.rows.iter().find_map(|row| Some((*row, way_of(row)?))) else { continue };
            let variant = of.outcome.variant.clone();
            let found = Found { error: search.error(&variant), variant };
            if search.doing_as_well(&found, row, way * BEYOND).is_none() {
                continue;
            }
            let (least, most) = search.range(&found, row);
            let start = block.table.rows[row].start();
            if way * start >= way * search.value(&found.variant, row)
                && let Some(variant) = search.doing_as_well(&found, row, start)
            {
                of.outcome.variant = variant;
                of.changes.retain(
                    |change| !matches!(change, Change::Setting { name, .. } if *name == block.table.rows[row].name),
                );
                of.changes.push(change(block, row, start, None));
            }
            of.range = Some(if way > 0.0 { (least, OPEN) } else { (-OPEN, most) });
        }
    }

    /// Returns values of the table's rows by name.
    pub(super) fn named<'v>(&self, values: impl Iterator<Item = (&'v usize, &'v f64)>) -> Values {
        let named = |(row, value): (&usize, &f64)| {
            let of = &self.comparison.block.table.rows[*row];
            (of.name.clone(), typed(of.kind, *value))
        };
        values.map(named).collect()
    }

    /// Returns the suspects, judged over all rows, best first.
    fn told(&self, all: Vec<Tried>, is_sure: bool, base: &Outcome) -> Result<Vec<Suspect>> {
        let mut suspects = Vec::new();
        for Tried { outcome, changes, range, confused, .. } in all {
            let total = self.comparison.recording.rows;
            let outcome = if self.rows < total { self.comparison.run(&outcome.variant, total)? } else { outcome };
            // A change that leaves fewer but larger differences is not an improvement: a limit reached by rounded
            // values is known less precisely, and would be accepted because of the tolerance it adds.
            let is_farther = outcome.largest() > base.largest();
            if rank(&outcome) >= rank(base) || is_farther {
                continue;
            }
            let fits = outcome.different() == 0;
            let ends_without_call = fits && self.comparison.ends_without_call(&outcome)?;
            suspects.push(Suspect {
                changes,
                range,
                confused,
                values: self.named(outcome.variant.values.iter()),
                since: None,
                different: outcome.different(),
                largest: outcome.largest(),
                fits,
                is_sure: fits && is_sure,
                ends_without_call,
            });
        }
        let block = self.comparison.block;
        // Prefer values with few digits, as typed by users.
        let rank = |of: &Suspect| (of.different, of.fits && !is_round(of), of.fits && !is_usual(block, of), of.largest);
        suspects.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).expect("finite"));
        if suspects.iter().filter(|suspect| suspect.fits).count() != 1 {
            // Several fitting suspects that change the same settings do not contradict each other.
            let first = suspects.iter().find(|suspect| suspect.fits).map(|suspect| suspect.values.clone());
            let is_same = |suspect: &Suspect| {
                Some(suspect.values.keys().collect::<Vec<_>>()) == first.as_ref().map(|of| of.keys().collect())
            };
            if !suspects.iter().filter(|suspect| suspect.fits).all(is_same) {
                suspects.iter_mut().for_each(|suspect| suspect.is_sure = false);
            }
        }
        Ok(suspects)
    }
}

/// Returns all pairs of rows.
fn pairs(rows: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    rows.iter().enumerate().flat_map(|(number, a)| rows[number + 1..].iter().map(move |b| [*a, *b]))
}

/// Whether a suspect changes only settings of the controller, which are changed most often.
pub(super) fn is_usual(block: &Block, suspect: &Suspect) -> bool {
    !suspect.values.is_empty() && suspect.values.keys().all(|name| block.roles.controller.contains(name))
}

/// Whether all numbers of a suspect have few digits, like typed ones.
fn is_round(suspect: &Suspect) -> bool {
    let mut numbers = suspect.values.values().map(|value| number_of(*value));
    numbers.all(|value| (rounded(value, FEW) - value).abs() <= 1e-6 * value.abs())
}

/// Returns the width of a value's range as a fraction of the value.
fn part(low: f64, high: f64, value: f64) -> f64 {
    (high - low) / value.abs().max(1e-12)
}

/// Returns the range if it is wide enough to be worth reporting: more than 0.1 % of the value.
pub(super) fn range_to_tell(low: f64, high: f64, value: f64) -> Option<(f64, f64)> {
    (part(low, high, value) > 0.001).then_some((low, high))
}

/// Whether the range of a value is too wide for the value to be certain.
pub(super) fn is_wide(low: f64, high: f64, value: f64) -> bool {
    part(low, high, value) >= WIDE
}

/// Returns the number of distinct sets of settings that explain everything.
pub(super) fn fitting(tried: &[Tried]) -> usize {
    let mut sets: Vec<Vec<usize>> =
        tried.iter().filter(|of| of.outcome.different() == 0).map(|of| of.rows.clone()).collect();
    sets.iter_mut().for_each(|rows| rows.sort_unstable());
    sets.sort_unstable();
    sets.dedup();
    sets.len()
}

/// Returns a change with this reason.
fn because(mut change: Change, reason: Option<Why>) -> Change {
    if let Change::Setting { why, .. } = &mut change {
        *why = reason;
    }
    change
}

/// Returns a change to the other mode if the mode was not recorded and the manipulated value indicates it: automatic
/// mode if it moves, manual mode if it never moves.
fn mode(comparison: &Comparison, base: &Outcome) -> Option<Try> {
    let (block, recording) = (comparison.block, comparison.recording);
    let (switch, value) = block.manual()?;
    let is_recorded = |row: usize| recording.inputs.iter().any(|input| input.row == row);
    if is_recorded(switch) || is_recorded(value) {
        return None;
    }
    let output = block.manipulated(recording)?;
    let recorded: Vec<f64> =
        recording.outputs[output].values.iter().copied().filter(|value| value.is_finite()).collect();
    let moves = |values: &[f64]| values.iter().any(|value| *value != values[0]);
    let is_manual = block.settings[switch] == 1.0;
    let mut variant = base.variant.clone();
    variant.values.insert(switch, f64::from(u8::from(!is_manual)));
    if is_manual && moves(&recorded) {
        return Some(Try { changes: vec![change(block, switch, 0.0, None)], variant });
    }
    let computed = &base.outputs[output];
    // In automatic mode, the manipulated value is also constant while it is at a limit.
    if !is_manual && recorded.len() > 2 && !moves(&recorded) && moves(computed) && !block.is_limit(recorded[0]) {
        variant.values.insert(value, recorded[0]);
        let changes = vec![change(block, switch, 1.0, None), change(block, value, recorded[0], None)];
        return Some(Try { changes, variant });
    }
    None
}

/// Returns changes to the time between two calls that the recorded times indicate.
fn time(comparison: &Comparison) -> Vec<Try> {
    let (block, recording) = (comparison.block, comparison.recording);
    let mut tries = Tries { comparison, tries: Vec::new() };
    let (cycle, own) = (Some(block.table.cycle), block.settings[block.table.cycle]);
    let rhythm = recording.rhythm();
    let longer = (rhythm as f64 * recording.spacing.unwrap_or(own) * 1000.0).round() / 1000.0;
    if longer != own
        && tries.own(cycle).is_some()
        && let Some(skipped) = recording.rows_between_calls(rhythm)
    {
        let values = [(block.table.cycle, longer)].into();
        let changes = vec![because(change(block, block.table.cycle, longer, None), Some(Why::Rhythm(rhythm)))];
        tries.tries.push(Try { variant: Variant { values, skipped, ..Variant::default() }, changes });
    }
    let is_other = |spacing: &f64| recording.between.is_empty() && (spacing / own - 1.0).abs() > 0.02;
    if let Some(spacing) = recording.spacing.filter(is_other) {
        let spacing = (spacing * 1000.0).round() / 1000.0;
        tries.value(cycle, spacing, Some(Why::Spacing));
        let calls = (spacing / own).round();
        if (2.0..=1000.0).contains(&calls) && (spacing / own / calls - 1.0).abs() < 0.02 {
            let variant = Variant { more_calls: calls as usize - 1, ..Variant::default() };
            tries.tries.push(Try { variant, changes: vec![Change::Calls(calls as usize)] });
        }
    }
    tries.tries
}

/// Searches for a row without a call, or a call without a row, where the differences begin; then where the remaining
/// ones begin.
fn missed(comparison: &Comparison, base: &Outcome, rows: usize) -> Result<Option<(Outcome, Vec<Change>)>> {
    let (mut variant, mut best) = (base.variant.clone(), rank(base));
    let mut first = base.first();
    let mut found: Vec<Change> = Vec::new();
    let mut outcome = None;
    while let Some(at) = first
        && found.len() < MOST_MISSED
    {
        let mut step: Option<(Outcome, Change)> = None;
        // With many rows, each run takes a long time: try only the first row that differs.
        let earlier = if rows.saturating_mul(40) > MOST_CALLS { 0 } else { 4 };
        for row in (at.saturating_sub(earlier).max(1)..=at).rev() {
            let mut without = variant.clone();
            without.skipped.insert(row);
            let mut with = variant.clone();
            with.doubled.insert(row);
            let (line, time) = (comparison.recording.lines[row], comparison.recording.times[row]);
            for (variant, change) in [(without, Change::LeftOut { line, time }), (with, Change::Added { line, time })] {
                let now = comparison.run(&variant, rows)?.without_outputs();
                let is_later = now.first().is_none_or(|first| first > at + 2);
                let is_best = step.as_ref().is_none_or(|(step, _)| rank(&now) < rank(step));
                if is_later && is_best && rank(&now) < best {
                    step = Some((now, change));
                }
            }
        }
        let Some((now, change)) = step else { break };
        (variant, best, first) = (now.variant.clone(), rank(&now), now.first());
        found.push(change);
        outcome = Some(now);
    }
    Ok(outcome.map(|outcome| (outcome, found)))
}

/// Returns every change to a single setting to try.
fn settings(comparison: &Comparison) -> Vec<Try> {
    let (block, recording) = (comparison.block, comparison.recording);
    let mut tries = Tries { comparison, tries: Vec::new() };
    let roles = block.roles;
    if recording.spacing.is_none() {
        for factor in [0.5, 2.0, 10.0, 0.1] {
            tries.factor(Some(block.table.cycle), factor, Why::Factor);
        }
    }
    tries.factor(block.row(roles.controller.first()), -1.0, Why::Sign);
    limits(&mut tries);
    tries.switch(block.peripheral().map(|(_, switch)| switch));
    structure(&mut tries);
    switches(&mut tries);
    for time in roles.controller.get(1..).unwrap_or_default() {
        for (factor, what) in
            [(60.0, Why::Minutes), (1.0 / 60.0, Why::NoMinutes), (1000.0, Why::Seconds), (0.001, Why::Milliseconds)]
        {
            tries.factor(block.row(Some(time)), factor, what);
        }
    }
    dead_band(&mut tries);
    tries.tries
}

/// A collection of changes to try.
struct Tries<'a> {
    comparison: &'a Comparison<'a>,
    tries: Vec<Try>,
}

impl Tries<'_> {
    /// Returns the row and current value of a variable; `None` if the block does not have the variable or the recording
    /// contains it.
    fn own(&self, row: Option<usize>) -> Option<(usize, f64)> {
        let row = row?;
        let is_recorded =
            self.comparison.recording.inputs.iter().any(|input| input.row == row && input.values.len() > 1);
        (!is_recorded).then(|| (row, self.comparison.block.settings[row]))
    }

    fn value(&mut self, row: Option<usize>, value: f64, why: Option<Why>) {
        self.values(&[(row, value)], why);
    }

    /// Adds a try that changes several values at the same time.
    fn values(&mut self, values: &[(Option<usize>, f64)], why: Option<Why>) {
        let mut variant = Variant::default();
        let mut changes = Vec::new();
        for (row, value) in values {
            let Some((row, own)) = self.own(*row) else { return };
            let of = &self.comparison.block.table.rows[row];
            let Some(value) = held(of.kind, *value).filter(|value| *value != own) else { return };
            changes.push(because(change(self.comparison.block, row, value, None), why));
            variant.values.insert(row, value);
        }
        if !self.tries.iter().any(|other| other.variant == variant) {
            self.tries.push(Try { variant, changes });
        }
    }

    fn factor(&mut self, row: Option<usize>, factor: f64, why: Why) {
        if let Some((row, own)) = self.own(row) {
            self.value(Some(row), own * factor, Some(why));
        }
    }

    fn switch(&mut self, row: Option<usize>) {
        if let Some((row, own)) = self.own(row) {
            self.value(Some(row), 1.0 - own, None);
        }
    }
}

/// Whether values reach an extreme more than once, to the last digit, as they do at a limit.
fn stays(values: &[f64], extreme: f64) -> bool {
    values.iter().filter(|value| **value == extreme).count() > 1
}

/// Adds the highest and the lowest recorded manipulated value as limits, if it is reached more than once.
fn limits(tries: &mut Tries) {
    let (block, recording) = (tries.comparison.block, tries.comparison.recording);
    let Some(manipulated) = block.manipulated(recording) else { return };
    let values = &recording.outputs[manipulated].values;
    let (low, high) = extremes(values.iter().filter(|value| value.is_finite()));
    let why = Some(Why::Stays);
    let limit = |limit: fn(&(String, String)) -> &String| block.row(block.roles.limits.as_ref().map(limit));
    let high = (limit(|(high, _)| high), high);
    let low = (limit(|(_, low)| low), low);
    if stays(values, high.1) {
        tries.values(&[high], why);
    }
    if stays(values, low.1) {
        tries.values(&[low], why);
    }
    if stays(values, high.1) && stays(values, low.1) {
        tries.values(&[high, low], why);
    }
}

/// Returns a change to the loop's limits that the recorded manipulated value exceeds: to its extreme if it stays there,
/// otherwise to the block's start value if that is wide enough.
fn exceeded(comparison: &Comparison) -> Option<Try> {
    let (block, recording) = (comparison.block, comparison.recording);
    let of = &recording.outputs[block.manipulated(recording)?];
    let (low, high) = extremes(of.values.iter().filter(|value| value.is_finite()));
    let (upper, lower) = block.roles.limits.as_ref()?;
    let mut tries = Tries { comparison, tries: Vec::new() };
    let mut wrong = Vec::new();
    let mut all_stay = true;
    for (name, extreme, way) in [(upper, high, 1.0), (lower, low, -1.0)] {
        let row = block.table.find(name)?;
        if way * (extreme - block.settings[row]) > of.tolerance(extreme) {
            let stays = stays(&of.values, extreme);
            let start = block.table.rows[row].start();
            wrong.push((Some(row), if stays || way * start < way * extreme { extreme } else { start }));
            all_stay &= stays;
        }
    }
    tries.values(&wrong, all_stay.then_some(Why::Stays));
    tries.tries.pop().filter(|one| !one.changes.is_empty())
}

/// Adds every other combination of the P, I and D actions being on or off.
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
        tries.values(&chosen, None);
    }
}

/// Adds each switch in its other position, except those for manual mode, the restart and the actuator's stops.
fn switches(tries: &mut Tries) {
    let block = tries.comparison.block;
    let roles = block.roles;
    let pulses = roles.manual_pulses.iter().flat_map(|(_, pulses)| pulses);
    let others: BTreeSet<&String> =
        roles.manual_switch().into_iter().chain(pulses).chain(&roles.restart).chain(roles.stops()).collect();
    for (row, of) in block.table.rows.iter().enumerate() {
        if of.kind == Kind::Bool && of.role.is_settable() && !others.contains(&of.name) {
            tries.switch(Some(row));
        }
    }
}

/// Adds dead bands: none, and up to three round numbers from the largest deviation at which the recorded manipulated
/// value rests to the smallest at which it moves.
fn dead_band(tries: &mut Tries) {
    let (block, recording) = (tries.comparison.block, tries.comparison.recording);
    let row = block.row(block.roles.dead_band.as_ref());
    tries.value(row, 0.0, Some(Why::NoDeadBand));
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
        // Without an I action, a constant deviation moves nothing.
        if manipulated[at] == manipulated[at - 1] && now != before {
            rests.push(now.max(before));
        } else if manipulated[at] != manipulated[at - 1] {
            moves.push(now.max(before));
        }
    }
    if rests.len() < 3 {
        return;
    }
    // At its limits, the manipulated value does not move either: leave out deviations larger than the smallest at which
    // it moves.
    rests.sort_unstable_by(f64::total_cmp);
    let low = moves.iter().copied().fold(f64::INFINITY, f64::min);
    let rests: Vec<f64> = rests.into_iter().filter(|rest| *rest <= low).collect();
    let Some(high) = rests.last() else { return };
    for value in round_numbers(*high, if low.is_finite() { low } else { 2.0 * high }) {
        tries.value(row, value, Some(Why::Rests));
    }
}

/// Returns up to three numbers between two bounds, those with the fewest digits.
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
                // Powers of ten below 1 have no exact binary representation; their inverses do.
                .map(|number| if step < 1.0 { number / (1.0 / step).round() } else { number * step })
                .collect();
            if !numbers.is_empty() {
                return numbers;
            }
        }
    }
    vec![low]
}
