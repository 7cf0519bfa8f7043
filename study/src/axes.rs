//! The axes of a study with their variables resolved, and the point of every run.

use crate::correlation;
use crate::distribution::Distribution;
use crate::results::{Loops, Quantity};
use crate::sampling::{LEAST_PROBABILITY, Sampler};
use crate::{Along, Axis, Sampling, Study};
use anyhow::{Context, Result, bail};
use modeldescription::digits::short;
use run::component::Type;
use run::plan::{self, Names, Reference, effective, value, wires};
use run::subject::About;
use run::system::{Setting, System, Value};
use std::ops::Range;

/// The axes of a study.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axes {
    axes: Vec<Resolved>,
    /// The number of runs at each point of the grid.
    samples: u64,
    /// The number of runs.
    count: u64,
    sampler: Sampler,
    /// How the distributions depend on each other (see [`correlation::mixing`]); empty if they are independent.
    mixing: Vec<Vec<f64>>,
    /// The variable that each coordinate sets.
    pub targets: Vec<Target>,
}

/// A variable that an axis varies.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    /// `FMU.VARIABLE`
    pub name: String,
    /// Its unit, if the FMU declares one.
    pub unit: Option<String>,
    /// The index of its member.
    pub member: usize,
    /// Its type.
    pub kind: Type,
    /// Its value reference.
    pub reference: u32,
    /// The time at which it is set, in seconds; `None` for the start.
    pub time: Option<f64>,
    /// The minimum and maximum declared by the FMU.
    range: (Option<f64>, Option<f64>),
    /// The value by which the axis' values are multiplied, if these are relative.
    base: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
struct Resolved {
    values: Values,
    /// The number of its variables.
    width: usize,
    /// The number of consecutive grid points that share a value of this axis.
    stride: u64,
    /// The number of values it contributes to the grid.
    length: u64,
}

/// The source of an axis' values.
#[derive(Clone, Debug, PartialEq)]
enum Values {
    /// One value per point along the axis, shared by all variables.
    Shared(Vec<f64>),
    /// One value per variable for each point along the axis, in row-major order.
    Rows(Vec<f64>),
    Range {
        from: f64,
        to: f64,
        count: u64,
        logarithmic: bool,
    },
    /// The distribution, its 0-based index among the distributions, and whether its values are rounded to integers.
    Drawn(Distribution, usize, bool),
}

impl Target {
    fn new(names: &Names, reference: &Reference, time: Option<f64>, base: Option<f64>) -> Target {
        Target {
            name: names.full(reference),
            unit: reference.variable.unit.clone(),
            member: reference.member,
            kind: reference.kind,
            reference: reference.variable.value_reference,
            time,
            range: (reference.variable.min, reference.variable.max),
            base,
        }
    }

    /// Whether both set the same variable at the same time. Two names with the same value reference denote the same
    /// variable.
    fn is_same(&self, other: &Target) -> bool {
        self.is_variable(other.member, other.kind, other.reference) && self.time == other.time
    }

    fn is_variable(&self, member: usize, kind: Type, reference: u32) -> bool {
        (self.member, self.kind, self.reference) == (member, kind, reference)
    }

    /// The column of its values: `FMU.VARIABLE`, or `FMU.VARIABLE@SECONDS` if it is set later.
    pub(crate) fn coordinate(&self) -> Quantity {
        let name = match self.time {
            None => self.name.clone(),
            Some(time) => format!("{}@{time}", self.name),
        };
        Quantity::new(&name, self.unit.as_deref())
    }

    /// The setting that assigns a value to the variable.
    fn setting(&self, value: f64) -> Setting {
        Setting {
            variable: self.name.clone(),
            value: Value::Number(value),
            time: self.time,
            is_preliminary: false,
            place: None,
        }
    }

    /// The variable's value for a value of the axis.
    fn absolute(&self, value: f64) -> f64 {
        self.base.map_or(value, |base| base * value)
    }

    fn is_outside(&self, value: f64) -> bool {
        self.range.0.is_some_and(|min| value < min) || self.range.1.is_some_and(|max| value > max)
    }

    /// Checks that the variable can have this value.
    fn check(&self, value: f64) -> Result<()> {
        if !value.is_finite() {
            bail!("{} = {value}: use values and factors whose products are finite", self.name);
        }
        plan::value(self.kind, Value::Number(value)).with_context(|| format!("{} = {value:?}", self.name))?;
        Ok(())
    }
}

impl Axes {
    /// Resolves the axes of a study.
    ///
    /// # Errors
    /// An axis is wrong; the message names it and the remedy.
    pub(crate) fn new(study: &Study, system: &System, names: &Names) -> Result<Axes> {
        study.check()?;
        let count = study.count()?;
        let samples = study.runs_of_point();
        let mut axes = Axes {
            axes: Vec::new(),
            samples,
            count,
            sampler: Sampler::new(study.sampling, study.seed, samples, study.distributions()),
            mixing: correlation::mixing(study)?,
            targets: Vec::new(),
        };
        let (mut stride, mut distributions) = (count / samples, 0);
        for (number, axis) in study.axes.iter().enumerate() {
            let mut add = || {
                let targets = targets(axis, system, names)?;
                for (place, target) in targets.iter().enumerate() {
                    if targets[..place].iter().any(|other| other.is_same(target)) {
                        bail!("{} is named twice: remove one of the two", target.name);
                    }
                    if let Some(other) = axes.targets.iter().position(|other| other.is_same(target)) {
                        let is_of = |axis: &usize| axes.coordinates(*axis).contains(&other);
                        let other = (0..axes.axes.len()).find(is_of).unwrap_or_default();
                        let label = study.axes[other].label(other);
                        bail!("{} is also varied by {label}: keep it in only one of them", target.coordinate().name);
                    }
                }
                let values = values(axis, &targets, &mut distributions)?;
                Ok((values, targets))
            };
            let (values, targets) = add().with_context(|| axis.label(number)).at(number).at("axes")?;
            let length = axis.along.length();
            let leader = study.leader(number);
            if leader == number {
                stride /= length;
            }
            let stride = axes.axes.get(leader).map_or(stride, |leader| leader.stride);
            axes.axes.push(Resolved { values, width: targets.len(), stride, length });
            axes.targets.extend(targets);
        }
        Ok(axes)
    }

    /// The number of runs.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// The named loops of the study's table; `None` if no axis has names.
    pub(crate) fn loops(&self, study: &Study) -> Option<Loops> {
        let number = study.axes.iter().position(|axis| !axis.names.is_empty())?;
        Some(Loops { names: study.axes[number].names.clone(), runs: self.axes[number].stride * self.samples })
    }

    /// The values of a run, one for each coordinate.
    ///
    /// # Panics
    /// The run does not exist.
    pub(crate) fn point(&self, run: u64) -> Vec<f64> {
        assert!(run < self.count, "run {run} does not exist: the study has {} runs", self.count);
        let (grid, sample) = (run / self.samples, run % self.samples);
        let mut point = Vec::with_capacity(self.targets.len());
        for axis in &self.axes {
            let place = grid / axis.stride % axis.length;
            let shared = match &axis.values {
                Values::Rows(values) => {
                    let row = &values[place as usize * axis.width..][..axis.width];
                    point.extend_from_slice(row);
                    continue;
                }
                Values::Shared(values) => values[place as usize],
                Values::Range { from, to, count, logarithmic } => between(*from, *to, place, *count, *logarithmic),
                Values::Drawn(distribution, number, is_whole) => {
                    let own = |number: usize| self.sampler.probability(number, sample);
                    let probability = correlation::probability(&self.mixing, *number, own);
                    distribution.quantile_of(probability, *is_whole)
                }
            };
            point.extend(std::iter::repeat_n(shared, axis.width));
        }
        for (value, target) in point.iter_mut().zip(&self.targets) {
            *value = target.absolute(*value);
        }
        point
    }

    /// Warnings for the user: one sentence for each axis with values outside the range that an FMU declares, and for
    /// sample counts that are probably unintended.
    pub(crate) fn warnings(&self, study: &Study) -> Vec<String> {
        let mut warnings = Vec::new();
        if study.distributions() > 0 && self.samples == 1 {
            warnings.push("samples = 1: each distribution yields a single value; use more samples".into());
        } else if study.distributions() > 0
            && matches!(study.sampling, Sampling::Sobol | Sampling::Saltelli)
            && !study.samples.is_power_of_two()
        {
            warnings.push(format!(
                "samples = {}: a Sobol sequence is most even if the number of samples is a power of 2, such as {}",
                study.samples,
                study.samples.next_power_of_two()
            ));
        }
        for (number, axis) in self.axes.iter().enumerate() {
            let targets = &self.targets[self.coordinates(number)];
            let outside = targets.iter().enumerate().find_map(|(place, target)| {
                let values = axis.extremes(place, self.samples).map(|value| target.absolute(value));
                let value = values.into_iter().find(|value| target.is_outside(*value))?;
                Some((target, value))
            });
            if let Some((target, value)) = outside {
                let show = |bound: Option<f64>| bound.map_or("...".into(), |bound| format!("{bound:?}"));
                warnings.push(format!(
                    "{}: values such as {} = {} are outside the range declared by the FMU, {} to {}",
                    study.axes[number].label(number),
                    target.name,
                    short(value),
                    show(target.range.0),
                    show(target.range.1),
                ));
            }
        }
        warnings
    }

    /// The coordinates of an axis, as an index range.
    pub(crate) fn coordinates(&self, axis: usize) -> Range<usize> {
        let first = self.axes[..axis].iter().map(|axis| axis.width).sum();
        first..first + self.axes[axis].width
    }
}

/// A copy of the system in which the targets have the values of `point`, in place of any settings that they had. Targets
/// beyond the end of `point` have no setting in the copy.
pub(super) fn varied(system: &System, names: &Names, targets: &[Target], point: &[f64]) -> System {
    let is_replaced = |setting: &Setting| {
        // Unknown names are reported by the plan.
        names.find(&setting.variable).is_ok_and(|of| {
            let is = |target: &Target| target.is_variable(of.member, of.kind, of.variable.value_reference);
            targets.iter().any(|target| is(target) && target.time == setting.time)
        })
    };
    let kept = system.settings.iter().filter(|setting| !is_replaced(setting)).cloned();
    let settings = kept.chain(targets.iter().zip(point).map(|(target, value)| target.setting(*value))).collect();
    System { settings, ..system.clone() }
}

impl Resolved {
    /// The lowest and highest value for the axis variable at index `place`; for a distribution, approximately the
    /// extremes of this many samples.
    fn extremes(&self, place: usize, samples: u64) -> [f64; 2] {
        let among = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], value| [min.min(value), max.max(value)])
        };
        match &self.values {
            Values::Shared(values) => among(&mut values.iter().copied()),
            Values::Rows(values) => among(&mut values.iter().skip(place).step_by(self.width).copied()),
            Values::Range { from, to, .. } => [from.min(*to), from.max(*to)],
            Values::Drawn(distribution, _, is_whole) => {
                let share = 0.5 / samples as f64;
                [share, 1.0 - share].map(|probability| distribution.quantile_of(probability, *is_whole))
            }
        }
    }
}

/// The value at index `place` of a range.
pub(super) fn between(from: f64, to: f64, place: u64, count: u64, logarithmic: bool) -> f64 {
    if place == 0 {
        from
    } else if place + 1 == count {
        to
    } else if logarithmic {
        // Common logarithms, so that powers of ten are reproduced exactly.
        let (low, high) = (libm::log10(from), libm::log10(to));
        libm::exp10(low + (high - low) * place as f64 / (count - 1) as f64)
    } else {
        from + (to - from) * place as f64 / (count - 1) as f64
    }
}

/// The variables of an axis.
fn targets(axis: &Axis, system: &System, names: &Names) -> Result<Vec<Target>> {
    let wires = wires(names, &system.connections)?;
    let settings = effective(names, &system.settings, &wires)?;
    let target = |name: &String| {
        let found = names.find(name)?;
        if !axis.relative {
            return Ok(Target::new(names, &found, axis.time, None));
        }
        if found.kind == Type::Boolean {
            bail!("{name} is Boolean, which has no factors: omit `relative` and write values = [false, true]");
        }
        let key = (found.member, found.kind, found.variable.value_reference);
        // The value in effect when the axis sets its own: the setting at the same time, else the last earlier one, else
        // the start value.
        let set = settings
            .iter()
            .filter(|(_, of)| (of.member, of.kind, of.variable.value_reference) == key)
            .filter(|(setting, _)| match (setting.time, axis.time) {
                (None, _) => true,
                (Some(at), Some(time)) => at <= time,
                (Some(_), None) => false,
            })
            .max_by(|(a, _), (b, _)| {
                let time = |of: &Setting| of.time.unwrap_or(f64::NEG_INFINITY);
                time(a).total_cmp(&time(b))
            });
        let base = match set {
            Some((setting, _)) => Some(value(found.kind, setting.value).with_context(|| name.clone())?),
            None => found.variable.start,
        };
        match base {
            None => bail!("{name} has no start value to multiply by factors: set it in the loop"),
            Some(0.0) => bail!(
                "{name} is 0 in the loop, so any factor leaves it 0: omit `relative`, or set another value in the loop"
            ),
            base => Ok(Target::new(names, &found, axis.time, base)),
        }
    };
    axis.variables.iter().map(target).collect()
}

/// The values of an axis, checked against every variable that receives them.
fn values(axis: &Axis, targets: &[Target], distributions: &mut usize) -> Result<Values> {
    let number = |target: &Target, given: Value| {
        let value = match given {
            Value::Boolean(_) | Value::Whole(_) => value(target.kind, given).with_context(|| target.name.clone())?,
            Value::Number(number) => number,
        };
        target.check(target.absolute(value)).map(|()| value)
    };
    match &axis.along {
        Along::Values(list) => {
            let shared = |given: &Value| {
                let numbers: Vec<f64> = targets.iter().map(|target| number(target, *given)).collect::<Result<_>>()?;
                Ok(numbers[0])
            };
            Ok(Values::Shared(list.iter().map(shared).collect::<Result<_>>()?))
        }
        Along::Rows(rows) => {
            let mut all = Vec::new();
            for (place, row) in rows.iter().enumerate() {
                let name = axis.names.get(place).map_or_else(String::new, |name| format!(" ({name})"));
                for (target, given) in targets.iter().zip(row) {
                    all.push(number(target, *given).with_context(|| format!("row {}{name}", place + 1))?);
                }
            }
            Ok(Values::Rows(all))
        }
        Along::Range { from, to, count, logarithmic } => {
            for target in targets {
                // For floating-point types, the ends suffice: if both are finite, so are the values between them.
                let step = if target.kind.is_floating() { count - 1 } else { 1 };
                (0..*count)
                    .step_by(step as usize)
                    .try_for_each(|place| {
                        target.check(target.absolute(between(*from, *to, place, *count, *logarithmic)))
                    })
                    .context("range: write the values as a list, values = [...]")?;
            }
            Ok(Values::Range { from: *from, to: *to, count: *count, logarithmic: *logarithmic })
        }
        Along::Uniform { .. } | Along::Normal { .. } | Along::LogNormal { .. } | Along::Triangular { .. } => {
            let fits = |target: &&Target| target.kind.is_floating() || axis.whole && target.kind.whole().is_some();
            if let Some(target) = targets.iter().find(|target| !fits(target)) {
                let whole = if target.kind.whole().is_some() { "add whole = true, or " } else { "" };
                bail!(
                    "{} is {}, and distributions yield fractions: {whole}write its values as a list, values = [...]",
                    target.name,
                    target.kind.name()
                );
            }
            if let Some(target) = targets.iter().find(|_| axis.whole && axis.relative) {
                bail!("{}: factors are not whole numbers: remove `relative` or `whole`", target.name);
            }
            let distribution = Distribution::new(&axis.along).context("it is a distribution")?;
            let ends =
                [LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY].map(|end| distribution.quantile_of(end, axis.whole));
            for target in targets {
                ends.iter()
                    .try_for_each(|end| target.check(target.absolute(*end)))
                    .context("the distribution is too wide")?;
            }
            *distributions += 1;
            Ok(Values::Drawn(distribution, *distributions - 1, axis.whole))
        }
    }
}
