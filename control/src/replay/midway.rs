//! A setting that was changed by hand while the recording was made: the block does what was recorded with one value up to a row, and with
//! another one from there on.
//!
//! The value before the change is that of the loop, if the block agrees for a while, or is searched for in the first rows; it counts only if
//! it explains more rows than those. The value after it is searched for in the rows from the first difference on. Only an answer that
//! explains every row and that no other setting gives is one.

use super::Suspect;
use super::change::Since;
use super::compare::{CLEARLY, Outcome};
use super::estimate::{Found, Search};
use super::instance::{Later, Variant, change};
use super::suspects::{Diagnosis, Tried, fitting};
use anyhow::Result;

/// Fewer rows before a change or from it on prove nothing.
const FEWEST: usize = 8;

/// In this many rows from the first difference on the value before the change is searched for.
const BEFORE: usize = 40;

/// In this many rows from the change on the value after it is searched for.
const AFTER: usize = 600;

/// This many calls may be spent on each search.
const MOST_CALLS: usize = 6_000_000;

impl Diagnosis<'_> {
    /// The setting that was changed, if it is one, and if nothing else explains the recording.
    pub(super) fn midway(&self, base: &Outcome) -> Result<Option<Suspect>> {
        let Some(first) = base.first() else { return Ok(None) };
        if first >= FEWEST
            && let Some(suspect) = self.changed(&base.variant, first)?
        {
            return Ok(Some(suspect));
        }
        for beginning in self.comparison.beginnings(base.variant.beginning) {
            let start = Variant { beginning, ..base.variant.clone() };
            let mut suspects = Vec::new();
            for (variant, first) in self.before(&start, first)? {
                suspects.extend(self.changed(&variant, first)?);
            }
            if !suspects.is_empty() {
                return Ok(suspects.pop().filter(|_| suspects.is_empty()));
            }
        }
        Ok(None)
    }

    /// Values of a setting that explain the first rows and more than those they were searched for in, with the row that they do not explain.
    fn before(&self, start: &Variant, first: usize) -> Result<Vec<(Variant, usize)>> {
        let total = self.comparison.recording.rows;
        let rows = (first + BEFORE).min(total);
        let search = Search::new(self.comparison, rows, MOST_CALLS);
        let base = Found { error: search.error(start), variant: start.clone() };
        let mut all = Vec::new();
        for row in search.candidates(&base) {
            let Some(found) = search.one(start, row).filter(|found| search.fits(&found.variant)) else { continue };
            let outcome = self.comparison.run(&found.variant, total)?;
            all.extend(outcome.first().filter(|first| *first > rows + CLEARLY).map(|first| (found.variant, first)));
        }
        Ok(all)
    }

    /// The setting that has another value than in `start` from about this row on.
    fn changed(&self, start: &Variant, first: usize) -> Result<Option<Suspect>> {
        let total = self.comparison.recording.rows;
        if first + FEWEST > total {
            return Ok(None);
        }
        // The first value that differs may be the second one with the change.
        for from in [first, first - 1] {
            let rows = (first + AFTER).min(total);
            let search = Search::new(self.comparison, rows, MOST_CALLS);
            let diagnosis = Diagnosis { comparison: self.comparison, search, rows };
            let search = &diagnosis.search;
            let variant = Variant { later: Some(Later { from, ..Later::default() }), ..start.clone() };
            let base = Found { error: search.error(&variant), variant };
            let candidates = search.candidates(&base);
            let mut tried = Vec::new();
            for row in &candidates {
                // A setting that was not tried might explain it as well.
                if !search.may_go_on() {
                    return Ok(None);
                }
                let Some(found) = search.one(&base.variant, *row) else { continue };
                let outcome = self.comparison.run(&found.variant, total)?;
                if outcome.different() == 0 {
                    tried.push(Tried::estimated(outcome.without_outputs(), Vec::new(), vec![*row]));
                }
            }
            if !tried.is_empty() {
                let is_sure = fitting(&tried) == 1 && diagnosis.is_told(&mut tried, &candidates);
                return Ok(tried.pop().filter(|_| is_sure).map(|of| diagnosis.since(start, of)));
            }
        }
        Ok(None)
    }

    /// The answer: a setting that another value explains from a row on.
    fn since(&self, start: &Variant, of: Tried) -> Suspect {
        let (block, recording) = (self.comparison.block, self.comparison.recording);
        let variant = &of.outcome.variant;
        let (row, value, from) = variant
            .later
            .iter()
            .find_map(|later| later.values.iter().next().map(|(row, value)| (*row, *value, later.from)))
            .expect("it was searched for from a row on");
        let call = |row: usize| (row - recording.between.range(..row).count(), recording.times[row]);
        let of_start = |(row, value): (&usize, &f64)| change(block, *row, *value, None);
        let mut ends = start.values.clone();
        ends.insert(row, value);
        ends.retain(|row, value| *value as f32 != block.settings[*row] as f32);
        Suspect {
            changes: start.values.iter().map(of_start).collect(),
            since: Some(Since {
                change: change(block, row, value, start.values.get(&row)),
                latest: call(from),
                earliest: call(self.earliest(variant, from)),
            }),
            range: of.range,
            confused: Vec::new(),
            values: self.named(ends.iter()),
            different: 0,
            largest: of.outcome.largest(),
            fits: true,
            is_sure: true,
        }
    }

    /// The first row from which on the block may have had its later values: it does the same then.
    fn earliest(&self, variant: &Variant, latest: usize) -> usize {
        let (mut earliest, mut stride) = (latest, 1);
        while stride > 0 && self.search.may_go_on() {
            let mut other = variant.clone();
            let from = earliest.saturating_sub(stride).max(1);
            other.later.iter_mut().for_each(|later| later.from = from);
            if from < earliest && self.search.fits(&other) {
                earliest = from;
                stride *= 2;
            } else {
                stride /= 2;
            }
        }
        earliest
    }
}
