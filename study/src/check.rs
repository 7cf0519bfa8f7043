//! Checks of a study that do not depend on its loop.

use crate::distribution::Distribution;
use crate::sampling::{SOBOL_AXES, SOBOL_SAMPLES};
use crate::sobol::runs_of_sample;
use crate::{Along, Axis, Limit, Sampling, Study, Window};
use anyhow::{Context, Result, bail};
use run::bail_at;
use run::subject::About;
use run::system::Value;

/// The maximum number of runs in a study.
const MOST_RUNS: u64 = 1_000_000_000;

impl Study {
    /// Checks everything that does not depend on the loop.
    ///
    /// # Errors
    /// An axis, a limit, the window or the sampling is wrong; the message names it and the remedy.
    pub fn check(&self) -> Result<()> {
        for (number, axis) in self.axes.iter().enumerate() {
            axis.check().with_context(|| axis.label(number)).at(number).at("axes")?;
        }
        for (number, axis) in self.axes.iter().enumerate() {
            self.check_group(number).with_context(|| axis.label(number)).at(number).at("axes")?;
        }
        self.window.check().context("window").at("window")?;
        for (number, limit) in self.limits.iter().enumerate() {
            limit.check().context("limits").at(number).at("limits")?;
        }
        let distributions = self.distributions();
        if self.samples == 0 {
            bail_at!("samples", "samples = 0: the distributions need at least 1 sample");
        }
        if distributions == 0 && self.samples > 1 {
            bail_at!(
                "samples",
                "samples = {}, but no axis has a distribution: omit `samples`, or give an axis a distribution: \
                 uniform, normal, log_normal or triangular",
                self.samples
            );
        }
        let is_saltelli = self.sampling == Sampling::Saltelli;
        if is_saltelli && !self.correlations.is_empty() {
            bail_at!(
                "sampling",
                "sampling = \"saltelli\" needs independent axes, but [[correlations]] makes some depend on others: remove one of the two"
            );
        }
        if is_saltelli && self.axes.iter().any(|axis| axis.along.length() > 1) {
            bail_at!(
                "sampling",
                "sampling = \"saltelli\" works only with distributions, but an axis has several values: create a \
                 study for each value, or give the axis a distribution"
            );
        }
        if distributions > 0 && (is_saltelli || self.sampling == Sampling::Sobol) {
            let most = if is_saltelli { SOBOL_AXES / 2 } else { SOBOL_AXES };
            if self.samples > SOBOL_SAMPLES {
                bail_at!(
                    "samples",
                    "samples = {}: a Sobol sequence has at most {SOBOL_SAMPLES} samples; use fewer, or set sampling = \
                     \"latin_hypercube\"",
                    self.samples
                );
            }
            if distributions > most {
                bail_at!(
                    "sampling",
                    "{distributions} axes have distributions: a Sobol sequence supports at most {most}; use fewer, or \
                     set sampling = \"latin_hypercube\""
                );
            }
        }
        self.count().map(|_| ())
    }

    /// Returns the number of runs that the axes span.
    ///
    /// # Errors
    /// The axes span more than 10^9 runs.
    pub fn count(&self) -> Result<u64> {
        let lengths = self.lengths();
        let samples = self.runs_of_point();
        let count = lengths.iter().copied().chain([samples]).try_fold(1_u64, |count, length| count.checked_mul(length));
        match count {
            Some(count) if count <= MOST_RUNS => Ok(count),
            _ => {
                let factors: Vec<String> = lengths
                    .into_iter()
                    .chain([samples])
                    .filter(|length| *length > 1)
                    .map(|length| length.to_string())
                    .collect();
                bail_at!(
                    "axes",
                    "the axes span {} runs, but a study has at most {MOST_RUNS}: use fewer values or samples",
                    factors.join(" x ")
                )
            }
        }
    }

    /// Returns the number of values of each axis that spans the grid; a group is represented by its first axis.
    fn lengths(&self) -> Vec<u64> {
        let spans = |number: &usize| self.leader(*number) == *number;
        (0..self.axes.len()).filter(spans).map(|number| self.axes[number].along.length()).collect()
    }

    /// Returns the index of the first axis in an axis' group; its own index if it has no group.
    pub(super) fn leader(&self, number: usize) -> usize {
        let Some(group) = &self.axes[number].group else { return number };
        self.axes.iter().position(|axis| axis.group.as_ref() == Some(group)).unwrap_or(number)
    }

    /// Checks that an axis in a group has as many values as the first one there, the same loop names as the others in
    /// the same order, and no distribution; and that it has `whole` only with a distribution.
    fn check_group(&self, number: usize) -> Result<()> {
        let (axis, leader) = (&self.axes[number], self.leader(number));
        let other = &self.axes[leader];
        let (own, first) = (axis.along.length(), other.along.length());
        if own != first {
            bail!(
                "it has {}, but {} in the same group has {first}: both must have the same number",
                counted(own as usize, "value"),
                other.label(leader)
            );
        }
        let before = self.axes[..number].iter().position(|other| !other.names.is_empty());
        if let Some(before) = before.filter(|_| !axis.names.is_empty()) {
            let (other, place) = (&self.axes[before], self.axes[before].label(before));
            if self.leader(before) != leader {
                bail!("its rows belong to named loops, as do those of {place}: put both in the same group");
            }
            let names = other.names.iter().zip(&axis.names);
            if let Some((row, (other, own))) = (1..).zip(names).find(|(_, (other, own))| other != own) {
                bail!(
                    "row {row} belongs to {own}, but row {row} of {place}, in the same group, belongs to {other}: put \
                     the rows in the same order"
                );
            }
        }
        let is_drawn = Distribution::new(&axis.along).is_some();
        if is_drawn && axis.group.is_some() {
            bail!("an axis with a distribution cannot belong to a group: remove `group`");
        }
        if axis.whole && !is_drawn {
            bail!("`whole` applies only to distributions: write whole numbers, and remove `whole`");
        }
        Ok(())
    }

    /// The number of runs at each point of the grid.
    pub fn runs_of_point(&self) -> u64 {
        match (self.distributions(), self.sampling) {
            (0, _) => 1,
            (axes, Sampling::Saltelli) => self.samples.saturating_mul(runs_of_sample(axes)),
            _ => self.samples,
        }
    }

    /// Whether the runs only sample distributions, without a grid or Saltelli's scheme, so that confidence intervals
    /// are meaningful.
    pub fn is_independent(&self) -> bool {
        let is_grid = self.axes.iter().any(|axis| axis.along.length() > 1);
        self.distributions() > 0 && !is_grid && self.sampling != Sampling::Saltelli
    }

    /// The number of axes with a distribution.
    pub(super) fn distributions(&self) -> usize {
        self.axes.iter().filter(|axis| Distribution::new(&axis.along).is_some()).count()
    }
}

impl Window {
    fn check(self) -> Result<()> {
        if [self.from, self.to].into_iter().flatten().any(|time| !time.is_finite()) {
            bail!("specify finite times in seconds, or omit `from` or `to`");
        }
        if let (Some(from), Some(to)) = (self.from, self.to)
            && from >= to
        {
            bail!("from = {from:?} is not before to = {to:?}: correct one of them");
        }
        Ok(())
    }
}

impl Limit {
    fn check(&self) -> Result<()> {
        let name = &self.variable;
        for (bound, value) in [("min", self.min), ("max", self.max)] {
            if value.is_some_and(|value| !value.is_finite()) {
                bail!("{name}: {bound} is not a finite number: omit it if there is no such limit");
            }
        }
        match (self.min, self.max) {
            (None, None) => bail!("{name} has no limit: specify `min`, `max` or both"),
            (Some(min), Some(max)) if min > max => {
                bail!("{name}: min = {min:?} is above max = {max:?}: swap them")
            }
            _ => Ok(()),
        }
    }
}

impl Axis {
    /// The label in error messages: the 1-based axis number and the variables.
    pub fn label(&self, number: usize) -> String {
        format!("axis {} ({})", number + 1, self.variables.join(", "))
    }

    fn check(&self) -> Result<()> {
        if self.variables.is_empty() {
            bail!("it has no variable: write variable = \"FMU.VARIABLE\"");
        }
        if let Some(time) = self.time
            && !time.is_finite()
        {
            bail_at!("time", "time = {time:?}: specify a time in seconds");
        }
        self.along.check(self.variables.len()).at(self.along.name())?;
        let bounds = Distribution::new(&self.along).filter(|_| self.whole).map(|of| of.bounds());
        if let Some((min, max)) = bounds.filter(|(min, max)| min.ceil() > max.floor()) {
            let name = self.along.name();
            bail_at!(
                name,
                "{name}: no whole number lies between min = {min:?} and max = {max:?}: choose bounds with one between \
                 them, or remove `whole`"
            );
        }
        Ok(())
    }
}

impl Along {
    /// The key in a study file.
    fn name(&self) -> &'static str {
        match self {
            Along::Values(_) | Along::Rows(_) => "values",
            Along::Range { .. } => "range",
            Along::Uniform { .. } => "uniform",
            Along::Normal { .. } => "normal",
            Along::LogNormal { .. } => "log_normal",
            Along::Triangular { .. } => "triangular",
        }
    }

    /// The number of values it contributes to the grid; 1 for a distribution.
    pub(super) fn length(&self) -> u64 {
        match self {
            Along::Values(values) => values.len() as u64,
            Along::Rows(rows) => rows.len() as u64,
            Along::Range { count, .. } => *count,
            Along::Uniform { .. } | Along::Normal { .. } | Along::LogNormal { .. } | Along::Triangular { .. } => 1,
        }
    }

    /// Checks the values of an axis with this many variables.
    fn check(&self, variables: usize) -> Result<()> {
        match self {
            Along::Values(values) => {
                if values.is_empty() {
                    bail!("`values` is empty: specify at least one value");
                }
                values.iter().try_for_each(|value| finite_value(*value))
            }
            Along::Rows(rows) => {
                if rows.is_empty() {
                    bail!("`values` is empty: specify at least one row");
                }
                for (number, row) in rows.iter().enumerate() {
                    if row.len() != variables {
                        let (values, variables) = (counted(row.len(), "value"), counted(variables, "variable"));
                        bail!("row {} of `values` has {values} for {variables}: each variable needs one", number + 1);
                    }
                    row.iter().try_for_each(|value| finite_value(*value))?;
                }
                Ok(())
            }
            Along::Range { from, to, count, logarithmic } => {
                finite("range", &[("from", *from), ("to", *to)])?;
                if *count < 2 {
                    bail!(
                        "range: count = {count}: a range has at least 2 values; for a single one write values = [{from:?}]"
                    );
                }
                if from == to {
                    bail!("range: from and to are both {from:?}: use different ends, or write values = [{from:?}]");
                }
                if *logarithmic && !(*from > 0.0 && *to > 0.0) {
                    bail!(
                        "range: from = {from:?}, to = {to:?}: both ends of a logarithmic range must be above 0; \
                         correct them, or omit `logarithmic`"
                    );
                }
                spread("range", from.min(*to), from.max(*to))
            }
            Along::Uniform { min, max } => {
                finite("uniform", &[("min", *min), ("max", *max)])?;
                ordered("uniform", ("min", *min), ("max", *max))?;
                spread("uniform", *min, *max)
            }
            Along::Normal { mean, deviation, min, max } => {
                finite("normal", &[("mean", *mean), ("deviation", *deviation)])?;
                let bounds: Vec<_> = [("min", *min), ("max", *max)]
                    .into_iter()
                    .filter_map(|(name, value)| Some((name, value?)))
                    .collect();
                finite("normal", &bounds)?;
                positive("normal", "deviation", *deviation)?;
                if let (Some(min), Some(max)) = (min, max) {
                    ordered("normal", ("min", *min), ("max", *max))?;
                }
                match Distribution::new(self) {
                    Some(Distribution::Truncated { share, .. }) if share <= 0.0 => bail!(
                        "normal: practically no values are within the bounds, since the mean is {mean:?} and the \
                         deviation {deviation:?}: use bounds closer to the mean"
                    ),
                    _ => Ok(()),
                }
            }
            Along::LogNormal { median, deviation } => {
                finite("log_normal", &[("median", *median), ("deviation", *deviation)])?;
                positive("log_normal", "median", *median)?;
                positive("log_normal", "deviation", *deviation)
            }
            Along::Triangular { min, mode, max } => {
                finite("triangular", &[("min", *min), ("mode", *mode), ("max", *max)])?;
                ordered("triangular", ("min", *min), ("max", *max))?;
                if mode < min || mode > max {
                    bail!(
                        "triangular: mode = {mode:?} is not between min = {min:?} and max = {max:?}: correct one of them"
                    );
                }
                spread("triangular", *min, *max)
            }
        }
    }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn finite_value(value: Value) -> Result<()> {
    match value {
        Value::Number(number) if !number.is_finite() => bail!("`values` contains {number}: use finite numbers"),
        _ => Ok(()),
    }
}

fn finite(what: &str, numbers: &[(&str, f64)]) -> Result<()> {
    match numbers.iter().find(|(_, number)| !number.is_finite()) {
        Some((name, number)) => bail!("{what}: {name} = {number}: use a finite number"),
        None => Ok(()),
    }
}

fn positive(what: &str, name: &str, number: f64) -> Result<()> {
    if number > 0.0 {
        return Ok(());
    }
    bail!("{what}: {name} = {number:?}: it must be above 0")
}

fn ordered(what: &str, (low, min): (&str, f64), (high, max): (&str, f64)) -> Result<()> {
    if min > max {
        bail!("{what}: {low} = {min:?} is above {high} = {max:?}: swap them");
    }
    if min == max {
        bail!("{what}: {low} and {high} are both {min:?}: use different bounds, or write values = [{min:?}]");
    }
    Ok(())
}

/// Checks that the difference of two finite numbers is finite as well.
fn spread(what: &str, min: f64, max: f64) -> Result<()> {
    if (max - min).is_finite() {
        return Ok(());
    }
    bail!("{what}: {min:?} and {max:?} are too far apart: use bounds whose difference is below 1.8e308")
}
