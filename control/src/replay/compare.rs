//! Recorded and computed values, side by side.

use super::columns::{Recording, Signal};
use super::instance::{Beginning, Block, Variant};
use anyhow::Result;
use blocks::Kind;
use modeldescription::digits::short;

/// In this many ways the last digits of the measured values are varied.
const SEEDS: [u64; 3] = [1, 2, 3];

/// What these few ways show may be too little by so much.
const SPREAD: f64 = 3.0;

/// By so many rows more that agree, it is no accident.
pub(super) const CLEARLY: usize = 3;

/// What is compared with what.
pub(super) struct Comparison<'a> {
    pub(super) block: &'a Block<'a>,
    pub(super) recording: &'a Recording,
    /// How far a value may be off; by the digits of the recording without it.
    pub(super) tolerance: Option<f64>,
}

/// How the block did.
#[derive(Clone)]
pub(super) struct Outcome {
    pub(super) variant: Variant,
    /// The values of each output.
    pub(super) outputs: Vec<Vec<f64>>,
    /// One for each output.
    pub(super) compared: Vec<Difference>,
    /// What the last digits of the inputs do to each output; nothing if it was not looked at.
    spread: Vec<f64>,
}

/// How an output differs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Difference {
    /// The first row that differs.
    pub(super) first: Option<usize>,
    /// How many rows differ.
    pub(super) different: usize,
    /// The largest difference of all rows.
    pub(super) largest: f64,
}

impl Outcome {
    /// Without what was computed, which may be long.
    pub(super) fn without_outputs(mut self) -> Outcome {
        self.outputs = Vec::new();
        self
    }

    /// How many rows of outputs differ.
    pub(super) fn different(&self) -> usize {
        self.compared.iter().map(|of| of.different).sum()
    }

    /// The largest difference of an output that is no switch, else of all.
    pub(super) fn largest(&self) -> f64 {
        self.compared.iter().map(|of| of.largest).fold(0.0, f64::max)
    }

    /// The first row in which an output differs.
    pub(super) fn first(&self) -> Option<usize> {
        self.compared.iter().filter_map(|of| of.first).min()
    }

    /// Whether no output differs earlier than in another run, and one clearly later. What differs later on is of no account: there a
    /// setting may have been changed.
    pub(super) fn agrees_longer_than(&self, other: &Outcome, rows: usize) -> bool {
        let lengths = |of: &Outcome| of.compared.iter().map(|of| of.first.unwrap_or(rows)).collect::<Vec<_>>();
        let (own, others) = (lengths(self), lengths(other));
        let pairs = || own.iter().zip(&others);
        // A row is the call after it in one of the two.
        pairs().all(|(own, other)| own + 1 >= *other) && pairs().any(|(own, other)| *own > other + CLEARLY)
    }

    /// What was allowed because of the inputs' last digits.
    pub(super) fn spread_remarks(&self, comparison: &Comparison) -> Option<String> {
        let outputs = &comparison.recording.outputs;
        let shown: Vec<String> = self
            .spread
            .iter()
            .zip(outputs)
            // What REAL leaves open anyway is no rounding of the recording.
            .filter(|(spread, of)| **spread > of.rounding && !of.is_boolean)
            .map(|(spread, of)| format!("{} by up to {}", of.name, short(*spread)))
            .collect();
        (!shown.is_empty()).then(|| {
            format!(
                "The measured values are rounded to the digits of the recording, which alone may move {}: \
                 differences of this size are accepted.",
                shown.join(", ")
            )
        })
    }
}

impl Comparison<'_> {
    /// How the block may have got to the first row, this way before the others.
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

    /// The run with the beginning that fits best.
    pub(super) fn best(&self, variant: &Variant, rows: usize) -> Result<Outcome> {
        let mut best: Option<Outcome> = None;
        for beginning in self.beginnings(Beginning::Fresh) {
            let outcome = self.run(&Variant { beginning, ..variant.clone() }, rows)?;
            let is_better = best.as_ref().is_none_or(|best| rank(&outcome) < rank(best));
            if is_better {
                best = Some(outcome);
            }
            if best.as_ref().is_some_and(|best| best.different() == 0) {
                break;
            }
        }
        let best = best.expect("there is a beginning");
        Ok(best)
    }

    /// A run. What the last digits of the inputs do is looked at only if it matters.
    pub(super) fn run(&self, variant: &Variant, rows: usize) -> Result<Outcome> {
        let outputs = self.block.simulate(self.recording, variant, rows, None)?;
        let recorded = &self.recording.outputs;
        let mut outcome = Outcome {
            variant: variant.clone(),
            compared: recorded.iter().zip(&outputs).map(|(of, now)| self.difference(of, now, None)).collect(),
            spread: vec![0.0; outputs.len()],
            outputs,
        };
        let is_measured = self.recording.inputs.iter().any(Signal::is_rounded);
        let is_held = variant.beginning == Beginning::Held;
        if outcome.different() == 0 || self.tolerance.is_some() || !(is_measured || is_held) {
            return Ok(outcome);
        }
        let others = SEEDS
            .iter()
            .map(|seed| self.block.simulate(self.recording, variant, rows, Some(*seed)))
            .collect::<Result<Vec<_>>>()?;
        for (output, of) in recorded.iter().enumerate() {
            let others: Vec<&[f64]> = others.iter().map(|outputs| outputs[output].as_slice()).collect();
            let now = &outcome.outputs[output];
            let held = if is_held { of.resolution(of.values[0]) } else { 0.0 };
            outcome.compared[output] = self.difference(of, now, Some((&others, held)));
            let spread = |row: usize| others.iter().map(|other| (other[row] - now[row]).abs()).fold(0.0, f64::max);
            outcome.spread[output] = SPREAD * (0..now.len()).map(spread).fold(0.0, f64::max) + held;
        }
        Ok(outcome)
    }

    /// Compares an output; `others` are what it is with other last digits of the inputs, and what is allowed besides.
    fn difference(&self, of: &Signal, computed: &[f64], others: Option<(&[&[f64]], f64)>) -> Difference {
        let mut difference = Difference::default();
        let mut spread = 0.0f64;
        for (row, (now, recorded)) in computed.iter().zip(&of.values).enumerate() {
            if let Some((others, _)) = others {
                let widest = others.iter().map(|other| (other[row] - now).abs()).fold(0.0, f64::max);
                spread = spread.max(SPREAD * widest);
            }
            let is_no_call = self.recording.end == Some(row) || self.recording.between.contains(&row);
            if is_no_call || recorded.is_nan() || is_equal(of.kind, *now, *recorded) {
                continue;
            }
            let off = (now - recorded).abs();
            difference.largest = difference.largest.max(if off.is_nan() { f64::INFINITY } else { off });
            let allowed = match (self.tolerance, others) {
                (Some(tolerance), _) if !of.is_boolean => tolerance,
                (None, None) => of.tolerance(*recorded),
                (None, Some((_, held))) if !of.is_boolean => of.tolerance(*recorded) + spread + held,
                (None, Some((others, _))) => {
                    // A switch that another last digit moves by a call.
                    let near = row.saturating_sub(1)..(row + 2).min(computed.len());
                    let may_be = near.clone().any(|row| others.iter().any(|other| other[row] == *recorded));
                    f64::from(u8::from(may_be))
                }
                _ => 0.0,
            };
            // The limit itself is a decimal number, which the subtraction does not hit exactly.
            if off.is_nan() || off > allowed * (1.0 + 1e-5) {
                difference.first.get_or_insert(row);
                difference.different += 1;
            }
        }
        difference
    }
}

/// The better, the smaller.
pub(super) fn rank(outcome: &Outcome) -> (usize, f64) {
    (outcome.different(), outcome.largest())
}

fn is_equal(kind: Kind, a: f64, b: f64) -> bool {
    match kind {
        Kind::Real => (a as f32).to_bits() == (b as f32).to_bits() || a == b,
        _ => a == b,
    }
}
