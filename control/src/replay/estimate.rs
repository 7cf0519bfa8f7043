//! Estimates the values of settings with which the block reproduces a recording: the block itself is run with the
//! recorded inputs, and its outputs are compared with the recorded ones.
//!
//! One setting is searched for on a grid and by golden section, two by least squares (Levenberg–Marquardt). For a
//! switch, the number of TRUE values up to each row is compared: a late pulse thus adds little to the error, but a
//! missing one adds to it in every later row.

use super::columns::{Signal, is_tunable};
use super::compare::{Comparison, Outcome};
use super::instance::Variant;
use crate::extremes;
use crate::tune::rounded;
use blocks::table::number::to_value;
use blocks::{Kind, Role};
use modeldescription::Row;
use std::cell::Cell;

/// The factors by which the grid multiplies and divides the current value of a setting.
const FACTORS: [f64; 9] = [1.1, 1.25, 1.5, 2.0, 3.0, 4.5, 7.0, 12.0, 30.0];
/// The grid for a setting that is 0, as fractions of the range of the recorded values.
const PARTS: [f64; 6] = [0.002, 0.01, 0.05, 0.1, 0.25, 0.5];
/// The number of golden-section divisions of an interval.
const DIVISIONS: usize = 24;
/// The number of intervals in the grid that replaces golden section if only switches are recorded.
const POINTS: usize = 40;
/// The number of grid points per setting in a grid of two settings.
const PAIR_POINTS: i32 = 11;
/// The ratio of the widths of successive grids of two settings.
const NARROWER: f64 = 0.4;
/// The half width of the narrowest grid of two settings, as a fraction of their values.
const FINEST: f64 = 1e-3;
/// The maximum number of least-squares steps.
const STEPS: usize = 14;
/// The maximum number of digits of a value that is assumed to have been typed by a user.
const DIGITS: usize = 6;
/// Values that differ by less than this fraction count as equal.
const NEAR: f64 = 0.02;
/// A setting has no effect if changing it changes the error by less than this fraction.
const INSENSITIVE: f64 = 1e-9;

/// A search over the first rows of a recording.
pub(super) struct Search<'a> {
    pub(super) comparison: &'a Comparison<'a>,
    pub(super) rows: usize,
    /// The number of calls that may still be made.
    left: Cell<usize>,
    /// The number of calls in a run.
    calls: usize,
    /// The divisor of each output's residuals.
    scales: Vec<f64>,
}

/// Estimated values of settings.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) variant: Variant,
    /// The mean square of the residuals.
    pub(super) error: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(comparison: &'a Comparison<'a>, rows: usize, most: usize) -> Search<'a> {
        let scale = |of: &Signal| {
            let known: Vec<f64> = of.values[..rows].iter().copied().filter(|value| value.is_finite()).collect();
            let count = known.len().max(1) as f64;
            if of.is_boolean {
                return (0.05 * known.iter().sum::<f64>()).max(1.0);
            }
            let mean = known.iter().sum::<f64>() / count;
            let deviation = (known.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count).sqrt();
            deviation.max(1e-3 * mean.abs()).max(1e-9)
        };
        let scales = comparison.recording.outputs.iter().map(scale).collect();
        let calls = rows - comparison.recording.between.range(..rows).count();
        Search { comparison, rows, left: Cell::new(most), calls, scales }
    }

    /// Whether there are calls left for another run.
    pub(super) fn may_go_on(&self) -> bool {
        self.left.get() > self.calls
    }

    fn spend(&self, runs: usize) {
        self.left.set(self.left.get().saturating_sub(runs * self.calls));
    }

    /// Returns the scaled residuals of each output, row by row; `None` if the block reports an error.
    fn residuals(&self, variant: &Variant) -> Option<Vec<f64>> {
        self.spend(1);
        let recording = self.comparison.recording;
        let computed = self.comparison.block.simulate(recording, variant, self.rows, None).ok()?;
        let mut all = Vec::with_capacity(self.rows * computed.len());
        for ((of, now), scale) in recording.outputs.iter().zip(&computed).zip(&self.scales) {
            let mut count = 0.0;
            let rows = self.rows.min(recording.end.unwrap_or(self.rows));
            let both = of.values[..rows].iter().zip(now);
            for (recorded, now) in both.filter(|(recorded, _)| !recorded.is_nan()) {
                count += now - recorded;
                let off = if of.is_boolean { count } else { now - recorded };
                all.push(if off.is_finite() { off / scale } else { 1e6 });
            }
        }
        Some(all)
    }

    /// Returns the mean square of the residuals.
    pub(super) fn error(&self, variant: &Variant) -> f64 {
        self.residuals(variant).map_or(f64::INFINITY, |all| square(&all))
    }

    /// Whether the unknown digits of the recording explain all differences.
    pub(super) fn fits(&self, variant: &Variant) -> bool {
        self.spend(4);
        self.comparison.run(variant, self.rows).is_ok_and(|outcome| outcome.different() == 0)
    }

    pub(super) fn outcome(&self, variant: &Variant) -> Option<Outcome> {
        self.spend(4);
        self.comparison.run(variant, self.rows).ok().map(Outcome::without_outputs)
    }

    /// Returns the value of a setting in a variant.
    pub(super) fn value(&self, variant: &Variant, row: usize) -> f64 {
        variant.value(row).unwrap_or(self.comparison.block.settings[row])
    }

    /// Returns the variant with another value of a setting, as represented by its type; `None` if the type cannot hold
    /// the value or a running block does not accept it.
    fn with(&self, variant: &Variant, row: usize, value: f64) -> Option<Variant> {
        let of = &self.comparison.block.table.rows[row];
        let value = held(of.kind, value).filter(|value| is_sensible(of, *value))?;
        let mut variant = variant.clone();
        if variant.later.is_some() && !is_tunable(of.role) {
            return None;
        }
        variant.set(row, value);
        Some(variant)
    }

    /// Whether other values fit as well as those found. If the outputs are only switches and were exactly equal, they
    /// must remain so.
    fn does_as_well(&self, found: &Found, other: &Variant) -> bool {
        if found.error == 0.0 && !self.has_numbers() { self.error(other) == 0.0 } else { self.fits(other) }
    }

    /// Returns the rows in the table of the numeric settings that are in use, affect the outputs and are missing from
    /// the recording.
    pub(super) fn candidates(&self, base: &Found) -> Vec<usize> {
        let (block, recording) = (self.comparison.block, self.comparison.recording);
        let is_on = |name: &str| block.table.find(name).is_some_and(|row| self.value(&base.variant, row) != 0.0);
        let fields = || block.groups.iter().flat_map(|group| &group.fields);
        let is_used = |name: &str| fields().find(|field| field.name == name).is_none_or(|field| field.is_used(is_on));
        let is_candidate = |row: &usize| {
            let of = &block.table.rows[*row];
            let is_setting = matches!(of.role, Role::Parameter | Role::Fixed | Role::Input)
                // During the run, any input may have changed: an unrecorded disturbance acts like a change to LMN_OFF.
                && (base.variant.later.is_some() || !block.roles.is_stimulus(&of.name, of.role == Role::Input));
            let is_number = !matches!(of.kind, Kind::Bool | Kind::Word | Kind::Byte | Kind::DWord | Kind::LWord);
            let is_recorded = recording.inputs.iter().any(|input| input.row == *row);
            is_setting && is_number && !is_recorded && *row != block.table.cycle && is_used(&of.name)
        };
        let changes = |row: &usize| {
            let own = self.value(&base.variant, *row);
            let mut others = if own == 0.0 { vec![self.span() * 0.1, 1.0] } else { vec![own * 1.3, own * 0.7] };
            if block.table.rows[*row].kind == Kind::Time {
                // The block may round a short time to whole calls, so that smaller changes have no effect.
                others.extend([1.0, 10.0].map(|calls| own + calls * block.settings[block.table.cycle]));
            }
            others.extend(self.stays(&base.variant, *row));
            let mut others = others.into_iter().filter_map(|value| self.with(&base.variant, *row, value));
            others.any(|variant| (self.error(&variant) - base.error).abs() > INSENSITIVE * base.error)
        };
        (0..block.table.rows.len()).filter(is_candidate).filter(changes).collect()
    }

    /// If the setting is a limit of the manipulated value that changes during the run, returns the highest or lowest
    /// recorded value after the change, at which the limit may act.
    fn stays(&self, variant: &Variant, row: usize) -> Option<f64> {
        let (block, recording) = (self.comparison.block, self.comparison.recording);
        let (from, (high, low)) = (variant.later.as_ref()?.from, block.roles.limits.as_ref()?);
        let after = recording.outputs[block.manipulated(recording)?].values[..self.rows].get(from..)?.iter().copied();
        match block.table.find(high) == Some(row) {
            true => after.reduce(f64::max),
            false => after.filter(|_| block.table.find(low) == Some(row)).reduce(f64::min),
        }
    }

    /// Returns the range of values of the recorded floating-point signal for which it is largest.
    fn span(&self) -> f64 {
        let recording = self.comparison.recording;
        let span = |of: &Signal| {
            let (low, high) = extremes(of.values[..self.rows].iter().filter(|value| value.is_finite()));
            if of.is_boolean || high < low { 0.0 } else { high - low }
        };
        let all = recording.inputs.iter().chain(&recording.outputs);
        all.filter(|of| matches!(of.kind, Kind::Real | Kind::LReal)).map(span).fold(0.0, f64::max)
    }

    /// Returns characteristic times of the recorded switches, in seconds: for each, the shortest time TRUE, the
    /// shortest time FALSE and the median period.
    fn times(&self) -> Vec<f64> {
        let recording = self.comparison.recording;
        let step = recording.spacing.unwrap_or(self.comparison.block.settings[self.comparison.block.table.cycle]);
        let mut times = Vec::new();
        for of in recording.outputs.iter().filter(|of| of.is_boolean) {
            let runs: Vec<&[f64]> = of.values[..self.rows].chunk_by(|a, b| a == b).collect();
            // The first run has no known beginning, and the last one no known end.
            let inner = runs.get(1..runs.len().saturating_sub(1)).unwrap_or_default();
            for level in [1.0, 0.0] {
                times.extend(inner.iter().filter(|run| run[0] == level).map(|run| run.len()).min());
            }
            let mut periods: Vec<usize> = inner.windows(2).map(|pair| pair[0].len() + pair[1].len()).collect();
            periods.sort_unstable();
            times.extend(periods.get(periods.len() / 2));
        }
        times.into_iter().map(|calls| calls as f64 * step).collect()
    }

    /// Whether any recorded output is a number: unlike a switch, it responds to small changes to a setting.
    pub(super) fn has_numbers(&self) -> bool {
        self.comparison.recording.outputs.iter().any(|of| !of.is_boolean)
    }

    fn grid(&self, variant: &Variant, row: usize) -> Vec<f64> {
        let block = self.comparison.block;
        let kind = block.table.rows[row].kind;
        let own = self.value(variant, row);
        let mut grid: Vec<f64> = FACTORS.iter().flat_map(|factor| [own * factor, own / factor]).collect();
        match kind {
            Kind::Time | Kind::LTime => {
                grid.extend(self.times());
                if own == 0.0 {
                    let cycle = block.settings[block.table.cycle];
                    grid.extend([1.0, 3.0, 10.0, 30.0, 100.0].map(|factor| factor * cycle));
                }
            }
            Kind::Real | Kind::LReal => {
                let span = self.span();
                grid.extend(PARTS.iter().flat_map(|part| [part * span, -part * span]).filter(|_| own == 0.0));
                grid.push(0.0);
            }
            _ => {
                let cycle = block.settings[block.table.cycle];
                grid.extend(self.times().into_iter().map(|time| time / cycle));
                grid.extend([1.0, 2.0, 5.0].into_iter().filter(|_| own == 0.0));
            }
        }
        grid.push(own);
        grid.extend(self.stays(variant, row));
        grid.retain_mut(|value| {
            held(kind, *value).is_some_and(|held| {
                *value = held;
                true
            })
        });
        grid.sort_unstable_by(f64::total_cmp);
        grid.dedup();
        grid
    }

    /// Finds the best value of one setting.
    pub(super) fn one(&self, base: &Variant, row: usize) -> Option<Found> {
        let grid = self.grid(base, row);
        let at = |value: f64| self.with(base, row, value).map_or(f64::INFINITY, |variant| self.error(&variant));
        let errors: Vec<f64> = grid.iter().map(|value| at(*value)).collect();
        let best = (0..grid.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]))?;
        let (low, high) = (grid[best.saturating_sub(1)], grid[(best + 1).min(grid.len() - 1)]);
        let by_factor = low > 0.0;
        let place = |value: f64| if by_factor { value.ln() } else { value };
        let value = |place: f64| if by_factor { place.exp() } else { place };
        let middle = if self.has_numbers() {
            crate::identify::golden_section(place(low), place(high), DIVISIONS, |place| at(value(place)))
        } else {
            // The number of pulses is a step function: use two grids, the second around the best point of the first.
            let mut interval = (place(low), place(high));
            for _ in 0..2 {
                let width = (interval.1 - interval.0) / POINTS as f64;
                let points = (0..=POINTS).map(|number| interval.0 + width * number as f64);
                let best = points.map(|place| (at(value(place)), place)).min_by(|a, b| a.0.total_cmp(&b.0))?;
                interval = (best.1 - width, best.1 + width);
            }
            f64::midpoint(interval.0, interval.1)
        };
        let found = [grid[best], value(middle)].into_iter().filter_map(|value| {
            let variant = self.with(base, row, value)?;
            Some(Found { error: self.error(&variant), variant })
        });
        let best = found.min_by(|a, b| a.error.total_cmp(&b.error))?;
        Some(self.snapped(self.polished(best, &[row]), &[row]))
    }

    /// Finds the best values of two settings if only switches are recorded, on increasingly fine grids: the number of
    /// pulses is a step function without a slope.
    pub(super) fn two(&self, base: &Found, rows: &[usize; 2]) -> Option<Found> {
        let mut best = base.clone();
        let mut width = FACTORS[FACTORS.len() - 3].ln();
        while width > FINEST && best.error > 0.0 && self.may_go_on() {
            let centre = rows.map(|row| self.value(&best.variant, row));
            let half = PAIR_POINTS / 2;
            let factor = |number: i32| (width * f64::from(number) / f64::from(half)).exp();
            for (a, b) in (-half..=half).flat_map(|a| (-half..=half).map(move |b| (a, b))) {
                let with = |variant: &Variant, place: usize, number: i32| {
                    self.with(variant, rows[place], centre[place] * factor(number))
                };
                let variant = with(&best.variant, 0, a).and_then(|variant| with(&variant, 1, b));
                let Some(variant) = variant else { continue };
                let error = self.error(&variant);
                if error < best.error {
                    best = Found { variant, error };
                }
            }
            width *= NARROWER;
        }
        rows.iter().all(|row| best.variant.values.contains_key(row)).then_some(best)
    }

    /// Refines one or two settings by least squares, starting from their current values.
    pub(super) fn polished(&self, from: Found, rows: &[usize]) -> Found {
        let mut best = from;
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            if !self.may_go_on() || best.error == 0.0 {
                break;
            }
            let Some(here) = self.residuals(&best.variant) else { break };
            let slopes: Option<Vec<(f64, Vec<f64>)>> = rows.iter().map(|row| self.slope(&best, *row, &here)).collect();
            let Some(slopes) = slopes else { break };
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let mut step = vec![0.0; rows.len()];
            match slopes.as_slice() {
                [(scale, a)] => step[0] = -scale * dot(a, &here) / (dot(a, a) * (1.0 + damping)),
                [(first, a), (second, b)] => {
                    let (aa, ab, bb) = (dot(a, a) * (1.0 + damping), dot(a, b), dot(b, b) * (1.0 + damping));
                    let (ra, rb, whole) = (-dot(a, &here), -dot(b, &here), aa * bb - ab * ab);
                    step = vec![first * (ra * bb - rb * ab) / whole, second * (rb * aa - ra * ab) / whole];
                }
                _ => break,
            }
            let moved = rows.iter().zip(&step).try_fold(best.variant.clone(), |variant, (row, step)| {
                self.with(&variant, *row, self.value(&best.variant, *row) + step)
            });
            let after = moved.map(|variant| Found { error: self.error(&variant), variant });
            match after.filter(|after| after.error < best.error) {
                Some(after) => {
                    let is_done = after.error > best.error * (1.0 - 1e-6);
                    best = after;
                    damping = (damping * 0.2f64).max(1e-9);
                    if is_done {
                        break;
                    }
                }
                None if damping > 1e4 => break,
                None => damping *= 20.0,
            }
        }
        best
    }

    /// Returns a small change to a setting, and its effect on the residuals.
    fn slope(&self, from: &Found, row: usize, here: &[f64]) -> Option<(f64, Vec<f64>)> {
        let own = self.value(&from.variant, row);
        let kind = self.comparison.block.table.rows[row].kind;
        let least = match kind {
            Kind::Time | Kind::LTime => 0.001,
            Kind::Real | Kind::LReal => 1e-4 * self.span(),
            _ => 1.0,
        };
        let there = held(kind, own + (own.abs() * 1e-3).max(least))?;
        let after = self.residuals(&self.with(&from.variant, row, there)?)?;
        Some((there - own, after.iter().zip(here).map(|(after, here)| after - here).collect()))
    }

    /// Returns the values with the fewest digits that fit about as well.
    pub(super) fn snapped(&self, found: Found, rows: &[usize]) -> Found {
        let enough = found.error * 4.0 + 1e-12;
        let with_digits = |digits: &[usize]| {
            let variant = rows.iter().zip(digits).try_fold(found.variant.clone(), |variant, (row, digits)| {
                let value = self.value(&found.variant, *row);
                self.with(&variant, *row, if *digits == 0 { 0.0 } else { rounded(value, *digits as i32) })
            });
            variant.map(|variant| Found { error: self.error(&variant), variant })
        };
        let mut all: Vec<Vec<usize>> = vec![Vec::new()];
        for _ in rows {
            let longer = |one: usize| all.iter().map(move |digits| [digits.as_slice(), &[one]].concat());
            all = (0..=DIGITS).flat_map(longer).collect();
        }
        all.sort_by_key(|digits| digits.iter().sum::<usize>());
        let good = |found: &Found| found.error <= enough && self.fits(&found.variant);
        all.iter().filter_map(|digits| with_digits(digits)).find(good).unwrap_or(found)
    }

    /// Returns the other settings that the recording cannot distinguish from this one: the block still reproduces the
    /// recording if both settings have other values.
    pub(super) fn confused(&self, found: &Found, row: usize, others: &[usize]) -> Vec<usize> {
        let is_confused = |other: &&usize| {
            let own = self.value(&found.variant, **other);
            let moved = if own == 0.0 { 0.05 * self.span() } else { own * 1.25 };
            let Some(variant) = self.with(&found.variant, **other, moved) else { return false };
            let start = Found { error: self.error(&variant), variant };
            let after = self.polished(start, &[row]).variant;
            let (before, now) = (self.value(&found.variant, row), self.value(&after, row));
            (now - before).abs() > NEAR * before.abs() && self.does_as_well(found, &after)
        };
        others.iter().filter(|other| **other != row).filter(is_confused).copied().collect()
    }

    /// Returns the variant with another value of a setting, if it fits as well.
    pub(super) fn doing_as_well(&self, found: &Found, row: usize, value: f64) -> Option<Variant> {
        self.with(&found.variant, row, value).filter(|other| self.does_as_well(found, other))
    }

    /// Returns the range of values of a setting that fit as well.
    pub(super) fn range(&self, found: &Found, row: usize) -> (f64, f64) {
        const WIDTHS: [f64; 8] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002];
        const FAR: [f64; 9] = [2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0];
        let own = self.value(&found.variant, row);
        let fits = |value: f64| self.doing_as_well(found, row, value).is_some();
        let widest = |sign: f64| {
            let mut values = WIDTHS.iter().map(|width| own + sign * width * own.abs());
            let end = values.find(|value| fits(*value)).unwrap_or(own);
            if own == 0.0 || end != own + sign * WIDTHS[0] * own.abs() {
                return end;
            }
            // If a value 50 % away still fits, there may be no bound at all: try values farther out.
            let factors = FAR.map(|factor| if (sign > 0.0) == (own > 0.0) { factor } else { 1.0 / factor });
            factors.into_iter().map(|factor| own * factor).take_while(|value| fits(*value)).last().unwrap_or(end)
        };
        (widest(-1.0), widest(1.0))
    }
}

fn square(all: &[f64]) -> f64 {
    all.iter().map(|one| one * one).sum::<f64>() / all.len().max(1) as f64
}

/// Whether a value is within the range that the table specifies as sensible.
fn is_sensible(of: &Row, value: f64) -> bool {
    of.least().is_none_or(|min| value >= min) && of.greatest().is_none_or(|max| value <= max)
}

/// Returns the value as represented by the type; `None` if the type cannot hold it or if it is a TIME below one
/// millisecond.
pub(super) fn held(kind: Kind, value: f64) -> Option<f64> {
    let value = match kind {
        Kind::Time => (value * 1000.0).round() / 1000.0,
        Kind::Real => f64::from(value as f32),
        Kind::LReal | Kind::LTime => value,
        _ => value.round(),
    };
    let is_good = to_value(value, kind).is_ok() && (kind != Kind::Time || value >= 0.001);
    is_good.then_some(value)
}
