//! Recorded and computed values, side by side.

use super::columns::{Recording, Signal};
use super::instance::{Beginning, Block, Variant};
use anyhow::Result;
use blocks::Kind;
use modeldescription::digits::short;

/// The seeds for varying the last digits of the measured values.
const SEEDS: [u64; 3] = [1, 2, 3];

/// The factor by which these few variations may underestimate the effect of the last digits.
const SPREAD: f64 = 3.0;

/// If the outputs agree for this many rows with a beginning, that is not a coincidence.
const LONG: usize = 20;

/// Agreement for more additional rows than this is not a coincidence.
pub(super) const CLEARLY: usize = 3;

/// A recording and the block it is compared with.
pub(super) struct Comparison<'a> {
    pub(super) block: &'a Block<'a>,
    pub(super) recording: &'a Recording,
    /// The allowed deviation of a value; by default, it depends on the digits of the recording.
    pub(super) tolerance: Option<f64>,
    /// The possible effect of the inputs' last digits on each output in each row, if it is the same for all runs;
    /// otherwise, it is computed for each run.
    pub(super) spread: Option<&'a [Vec<f64>]>,
}

/// A run of the block, compared with the recording.
#[derive(Clone)]
pub(super) struct Outcome {
    pub(super) variant: Variant,
    /// The values of each output.
    pub(super) outputs: Vec<Vec<f64>>,
    /// The differences, one for each output.
    pub(super) compared: Vec<Difference>,
    /// The effect of the inputs' last digits on each output up to each row; empty if it was not computed.
    spread: Vec<Vec<f64>>,
}

/// How an output differs from the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Difference {
    /// The first row that differs.
    pub(super) first: Option<usize>,
    /// The number of rows that differ.
    pub(super) different: usize,
    /// The largest difference in any row.
    pub(super) largest: f64,
}

impl Outcome {
    /// Drops the computed outputs, which may be long.
    pub(super) fn without_outputs(mut self) -> Outcome {
        self.outputs = Vec::new();
        self.spread = Vec::new();
        self
    }

    /// Returns the largest possible effect of the inputs' last digits on an output in any row.
    pub(super) fn spread(&self, output: usize) -> f64 {
        self.spread.get(output).and_then(|rows| rows.last()).copied().unwrap_or_default()
    }

    /// Returns the number of values that differ, over all rows and outputs.
    pub(super) fn different(&self) -> usize {
        self.compared.iter().map(|of| of.different).sum()
    }

    /// Returns the largest difference of any output.
    pub(super) fn largest(&self) -> f64 {
        self.compared.iter().map(|of| of.largest).fold(0.0, f64::max)
    }

    /// Returns the first row in which an output differs.
    pub(super) fn first(&self) -> Option<usize> {
        self.compared.iter().filter_map(|of| of.first).min()
    }

    /// Whether no output differs earlier than in another run, and at least one differs clearly later. Only the first
    /// difference counts: a setting may have been changed there.
    pub(super) fn agrees_longer_than(&self, other: &Outcome, rows: usize) -> bool {
        let lengths = |of: &Outcome| of.compared.iter().map(|of| of.first.unwrap_or(rows)).collect::<Vec<_>>();
        let (own, others) = (lengths(self), lengths(other));
        let pairs = || own.iter().zip(&others);
        // A lead of one row does not count, because the outputs may be shifted by one row in one of the two runs.
        pairs().all(|(own, other)| own + 1 >= *other) && pairs().any(|(own, other)| *own > other + CLEARLY)
    }

    /// Returns a remark on the deviations that are allowed because of the inputs' last digits, if any.
    pub(super) fn spread_remarks(&self, comparison: &Comparison) -> Option<String> {
        let outputs = &comparison.recording.outputs;
        let shown: Vec<String> = outputs
            .iter()
            .enumerate()
            .map(|(output, of)| (self.spread(output), of))
            // An effect within the rounding of REAL is not due to the digits of the recording.
            .filter(|(spread, of)| *spread > of.rounding && !of.is_boolean)
            .map(|(spread, of)| format!("{} by up to {}", of.name, short(spread)))
            .collect();
        (!shown.is_empty()).then(|| {
            format!(
                "The measured values are rounded to the digits of the recording, which alone may change {}: \
                 differences of this size are accepted.",
                shown.join(", ")
            )
        })
    }
}

impl<'a> Comparison<'a> {
    pub(super) fn new(block: &'a Block<'a>, recording: &'a Recording, tolerance: Option<f64>) -> Comparison<'a> {
        Comparison { block, recording, tolerance, spread: None }
    }

    /// Returns the ways in which the block may have reached the first row, with `first` first.
    pub(super) fn beginnings(&self, first: Beginning) -> Vec<Beginning> {
        let all = match () {
            () if self.recording.says_restart => vec![Beginning::Restart],
            () if self.block.can_be_held(self.recording) => {
                vec![Beginning::Fresh, Beginning::Restart, Beginning::Held]
            }
            () => vec![Beginning::Fresh, Beginning::Restart],
        };
        let (mut sorted, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|beginning| *beginning == first);
        sorted.extend(others);
        sorted
    }

    /// Returns the run with the beginning that fits best.
    pub(super) fn best(&self, variant: &Variant, rows: usize) -> Result<Outcome> {
        let mut all: Vec<Outcome> = Vec::new();
        for beginning in self.beginnings(Beginning::Fresh) {
            let mut outcome = self.run(&Variant { beginning, ..variant.clone() }, rows)?;
            // A beginning in manual mode has a wider tolerance: if another beginning agrees for long enough, use the
            // tolerance of that one.
            let tight = all.iter().filter(|of| of.first().is_some_and(|first| first >= LONG));
            if let Some(tight) = tight.max_by_key(|of| of.first()).filter(|_| beginning == Beginning::Held) {
                outcome.compared = self.differences(&outcome.outputs, &[], &tight.spread);
                outcome.spread.clone_from(&tight.spread);
            }
            let is_equal = outcome.different() == 0;
            all.push(outcome);
            if is_equal {
                break;
            }
        }
        let best = all.into_iter().min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
        Ok(best.expect("there is a beginning"))
    }

    /// Runs a variant and compares its outputs. The effect of the inputs' last digits is computed only if it affects
    /// the result.
    pub(super) fn run(&self, variant: &Variant, rows: usize) -> Result<Outcome> {
        let outputs = self.block.simulate(self.recording, variant, rows, None)?;
        let spread = self.spread.map_or_else(Vec::new, <[_]>::to_vec);
        let compared = self.differences(&outputs, &[], &spread);
        let mut outcome = Outcome { variant: variant.clone(), compared, spread, outputs };
        let is_measured = self.recording.inputs.iter().any(Signal::is_rounded);
        let is_open = is_measured || variant.beginning == Beginning::Held;
        let has_switches = self.recording.outputs.iter().any(|of| of.is_boolean);
        let is_judged = self.spread.is_some() && !has_switches;
        if outcome.different() == 0 || self.tolerance.is_some() || !is_open || is_judged {
            return Ok(outcome);
        }
        let others = self.others(variant, rows)?;
        if self.spread.is_none() {
            outcome.spread = self.spread_of(&outcome.outputs, &others, variant.beginning);
        }
        outcome.compared = self.differences(&outcome.outputs, &others, &outcome.spread);
        Ok(outcome)
    }

    /// Returns the possible effect of the inputs' last digits on each output up to each row of a run.
    pub(super) fn spread(&self, variant: &Variant) -> Result<Vec<Vec<f64>>> {
        let rows = self.recording.rows;
        let outputs = self.block.simulate(self.recording, variant, rows, None)?;
        Ok(self.spread_of(&outputs, &self.others(variant, rows)?, variant.beginning))
    }

    /// Repeats a run once per seed, varying the last digits of the inputs, and returns the outputs of each repetition.
    fn others(&self, variant: &Variant, rows: usize) -> Result<Vec<Vec<Vec<f64>>>> {
        SEEDS.iter().map(|seed| self.block.simulate(self.recording, variant, rows, Some(*seed))).collect()
    }

    /// Whether only switches are compared, and varying the last digits of the measured inputs changes at least as many
    /// values of the switches as differ from the recording.
    pub(super) fn is_within_rounding(&self, run: &Outcome) -> Result<bool> {
        let recording = self.recording;
        let is_measured = recording.inputs.iter().any(Signal::is_rounded);
        if self.tolerance.is_some() || !is_measured || !recording.outputs.iter().all(|of| of.is_boolean) {
            return Ok(false);
        }
        let different = |others: &[&[f64]]| -> usize {
            let rows = (0..recording.rows).filter(|row| recording.is_call(*row));
            let pairs = |row: usize| run.outputs.iter().zip(others).map(move |(own, other)| (own[row], other[row]));
            rows.flat_map(pairs).filter(|(own, other)| !other.is_nan() && own != other).count()
        };
        let recorded: Vec<&[f64]> = recording.outputs.iter().map(|of| of.values.as_slice()).collect();
        let others = self.others(&run.variant, recording.rows)?;
        let changed = others.iter().map(|other| different(&other.iter().map(Vec::as_slice).collect::<Vec<_>>()));
        Ok(changed.max() >= Some(different(&recorded)))
    }

    fn spread_of(&self, outputs: &[Vec<f64>], others: &[Vec<Vec<f64>>], beginning: Beginning) -> Vec<Vec<f64>> {
        let of_output = |output: usize| {
            let of = &self.recording.outputs[output];
            let held = if beginning == Beginning::Held { of.resolution(of.values[0]) } else { 0.0 };
            let mut spread = 0.0f64;
            let of_row = |(row, now): (usize, &f64)| {
                let widest = others.iter().map(|other| (other[output][row] - now).abs()).fold(0.0, f64::max);
                spread = spread.max(SPREAD * widest);
                spread + held
            };
            outputs[output].iter().enumerate().map(of_row).collect()
        };
        (0..outputs.len()).map(of_output).collect()
    }

    fn differences(&self, outputs: &[Vec<f64>], others: &[Vec<Vec<f64>>], spread: &[Vec<f64>]) -> Vec<Difference> {
        let of_output = |(output, computed): (usize, &Vec<f64>)| {
            let others: Vec<&[f64]> = others.iter().map(|outputs| outputs[output].as_slice()).collect();
            let spread = spread.get(output).map_or(&[][..], Vec::as_slice);
            self.difference(&self.recording.outputs[output], computed, &others, spread)
        };
        outputs.iter().enumerate().map(of_output).collect()
    }

    /// Compares an output; `others` are its values with other last digits of the inputs, and `spread` is their effect
    /// up to each row.
    fn difference(&self, of: &Signal, computed: &[f64], others: &[&[f64]], spread: &[f64]) -> Difference {
        let mut difference = Difference::default();
        for (row, (now, recorded)) in computed.iter().zip(&of.values).enumerate() {
            if !self.recording.is_call(row) || recorded.is_nan() || is_equal(of.kind, *now, *recorded) {
                continue;
            }
            let off = (now - recorded).abs();
            difference.largest = difference.largest.max(if off.is_nan() { f64::INFINITY } else { off });
            let allowed = match self.tolerance {
                None if of.is_boolean => {
                    // Another last digit of an input may move a switch by one call.
                    let near = row.saturating_sub(1)..(row + 2).min(computed.len());
                    let may_be = near.clone().any(|row| others.iter().any(|other| other[row] == *recorded));
                    f64::from(u8::from(may_be))
                }
                _ => self.allowed(of, row, spread),
            };
            if is_beyond(off, allowed) {
                difference.first.get_or_insert(row);
                difference.different += 1;
            }
        }
        difference
    }

    /// Returns the allowed deviation of an output in a row.
    fn allowed(&self, of: &Signal, row: usize, spread: &[f64]) -> f64 {
        match self.tolerance {
            _ if of.is_boolean => 0.0,
            Some(tolerance) => tolerance,
            None => of.tolerance(of.values[row]) + spread.get(row).copied().unwrap_or_default(),
        }
    }

    /// Whether the last row, which repeats all outputs, is not a call: a call would have computed other outputs.
    pub(super) fn ends_without_call(&self, run: &Outcome) -> Result<bool> {
        let Some(end) = self.recording.end else { return Ok(false) };
        let again;
        let outputs = if run.outputs.is_empty() {
            again = self.block.simulate(self.recording, &run.variant, self.recording.rows, None)?;
            &again
        } else {
            &run.outputs
        };
        let differs = |(of, computed): (&Signal, &Vec<f64>)| {
            let (now, recorded) = (computed[end], of.values[end]);
            let is_known = !recorded.is_nan() && !is_equal(of.kind, now, recorded);
            is_known && is_beyond((now - recorded).abs(), self.allowed(of, end, &[]))
        };
        Ok(self.recording.outputs.iter().zip(outputs).any(differs))
    }
}

/// Whether a deviation exceeds the allowed one, with some slack for the rounding error of the subtraction.
fn is_beyond(off: f64, allowed: f64) -> bool {
    off.is_nan() || off > allowed * (1.0 + 1e-5)
}

/// Returns the rank of an outcome: lower is better.
pub(super) fn rank(outcome: &Outcome) -> (usize, f64) {
    (outcome.different(), outcome.largest())
}

fn is_equal(kind: Kind, a: f64, b: f64) -> bool {
    match kind {
        Kind::Real => (a as f32).to_bits() == (b as f32).to_bits() || a == b,
        _ => a == b,
    }
}
