//! Axis scales: they map a range of values to a length, with round numbers as ticks.

/// The largest drawable number. Larger ones would overflow when converted to pixels; they are left out, like infinity.
const LARGEST: f64 = 1e300;

/// The range of values that an axis covers.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The value at the lower end.
    pub from: f64,
    /// The value at the upper end.
    pub to: f64,
}

impl Scale {
    /// A scale that contains all drawable values, with some margin.
    pub fn around(values: impl Iterator<Item = f64>) -> Scale {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| is_drawn(*value)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            return Scale { from: 0.0, to: 1.0 };
        }
        let room = if high > low { (high - low) * 0.06 } else { high.abs().max(1.0) * 0.5 };
        Scale { from: low - room, to: high + room }
    }

    /// The relative position of a value: 0 at the lower end, 1 at the upper.
    pub fn part(&self, value: f64) -> f64 {
        (value - self.from) / (self.to - self.from)
    }

    /// About `count` round numbers in the range.
    pub fn ticks(&self, count: f64) -> Vec<f64> {
        self.ticks_by(round_step((self.to - self.from) / count))
    }

    /// About `count` round numbers in the range, including both ends if there is a suitable step.
    pub fn ticks_to_the_ends(&self, count: f64) -> Vec<f64> {
        let least = (self.to - self.from) / count;
        let is_tick = |step: f64, end: f64| (end / step - (end / step).round()).abs() < 1e-6;
        let power = 10f64.powf(least.log10().floor());
        // Common steps come first. Up to a quarter more ticks than `count`, or as few as half, are acceptable.
        let steps = [1.0, 2.0, 5.0, 10.0, 2.5, 3.0, 4.0, 6.0].map(|factor| factor * power);
        let fits = |step: &&f64| {
            (least * 0.8..=least * 2.0).contains(*step) && is_tick(**step, self.from) && is_tick(**step, self.to)
        };
        steps.iter().find(fits).map_or_else(|| self.ticks(count), |step| self.ticks_by(*step))
    }

    fn ticks_by(&self, step: f64) -> Vec<f64> {
        let first = (self.from / step - 1e-9).ceil() as i64;
        let last = (self.to / step + 1e-9).floor() as i64;
        (first..=last).map(|tick| tick as f64 * step).collect()
    }
}

/// The smallest number of the series ..., 0.5, 1, 2, 5, 10, ... that is not less than `least`.
pub fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= least * 0.999);
    step.unwrap_or(least)
}

/// Whether a value is a number and small enough in magnitude to be drawn.
pub fn is_drawn(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// The label of a tick: its value without the digits added by floating-point errors.
pub fn tick_label(tick: f64) -> String {
    let rounded: f64 = format!("{tick:.9e}").parse().unwrap_or(tick);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) { format!("{rounded:e}") } else { rounded.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_of_time_has_a_tick_at_its_end() {
        let ticks = |to| Scale { from: 0.0, to }.ticks_to_the_ends(8.0);
        let by = |step: f64, count: i32| (0..=count).map(|tick| f64::from(tick) * step).collect::<Vec<_>>();
        assert_eq!(ticks(1500.0), by(250.0, 6));
        assert_eq!(ticks(900.0), by(100.0, 9));
        assert_eq!(ticks(240.0), by(30.0, 8));
        assert_eq!(ticks(3600.0), by(400.0, 9));
        assert_eq!(ticks(60.0), by(10.0, 6));
        assert_eq!(Scale { from: -50.0, to: 50.0 }.ticks_to_the_ends(8.0).len(), 11, "by 10");
        // No round step leads to 613.
        assert_eq!(ticks(613.0), by(100.0, 6));
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let ticks = |from, to, count| Scale { from, to }.ticks(count);
        assert_eq!(ticks(0.0, 60.0, 8.0), [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
        assert_eq!(ticks(-0.6, 10.6, 5.0), [0.0, 5.0, 10.0]);
        assert_eq!(ticks(-2.0, 2.0, 4.0), [-2.0, -1.0, 0.0, 1.0, 2.0]);
        let labels: Vec<_> = ticks(0.0, 0.6, 6.0).into_iter().map(tick_label).collect();
        assert_eq!(labels, ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
    }
}
