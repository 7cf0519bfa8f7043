//! A plant model in the time domain: its response to a piecewise constant input, solved in closed form. Dead time is
//! exact: it need not be a multiple of the step size.

use crate::identify::Model;
use libm::{exp, expm1};
use std::collections::VecDeque;

/// The state of a plant model. Input and output are deviations from the rest position.
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    model: Model,
    /// The time in seconds up to which the model has been solved.
    time: f64,
    /// The input in effect, after the dead time.
    input: f64,
    /// The inputs still within the dead time, each with the time at which it takes effect.
    on_the_way: VecDeque<(f64, f64)>,
    /// The input set last, which may still be within the dead time.
    last: f64,
    /// The output of the first lag, or the integral.
    first: f64,
    /// The output of the second lag.
    second: f64,
}

impl Process {
    /// Creates a plant in steady state at the given time, in seconds.
    pub fn at_rest(model: Model, time: f64) -> Process {
        Process { model, time, input: 0.0, on_the_way: VecDeque::new(), last: 0.0, first: 0.0, second: 0.0 }
    }

    /// Sets the input from this time onward. Calls must be in chronological order.
    pub fn put(&mut self, time: f64, input: f64) {
        if input != self.last {
            self.last = input;
            self.on_the_way.push_back((time + self.model.dead_time, input));
        }
    }

    /// Solves the model up to a time and returns the output there.
    pub fn output_at(&mut self, time: f64) -> f64 {
        while let Some((from, input)) = self.on_the_way.front().copied()
            && from <= time
        {
            self.advance(from);
            self.input = input;
            self.on_the_way.pop_front();
        }
        self.advance(time);
        self.second
    }

    /// Advances the model to a time with a constant input.
    fn advance(&mut self, to: f64) {
        let duration = to - self.time;
        if duration <= 0.0 {
            return;
        }
        self.time = to;
        let Model { gain, time_constant, second_time_constant, is_integrating, .. } = self.model;
        let (first, target) = (self.first, gain * self.input);
        // The fraction of a lag's deviation that remains.
        let left = |lag: f64| if lag > 0.0 { exp(-duration / lag) } else { 0.0 };
        if is_integrating {
            self.first = first + target * duration;
            let behind = target * second_time_constant;
            self.second = self.first - behind + (self.second - first + behind) * left(second_time_constant);
        } else {
            self.first = target + (first - target) * left(time_constant);
            self.second = if second_time_constant > 0.0 {
                let through = through(duration / time_constant, duration / second_time_constant);
                target + (self.second - target) * left(second_time_constant) + (first - target) * through
            } else {
                self.first
            };
        }
    }
}

/// Returns the fraction of the first lag's deviation that remains in the second lag after `a` of the first lag's time
/// constants and `b` of the second's: `b (exp(-a) - exp(-b)) / (b - a)`, written to avoid cancellation if `a` is close
/// to `b`.
fn through(a: f64, b: f64) -> f64 {
    if a == f64::INFINITY {
        return 0.0;
    }
    let apart = (b - a).abs();
    let mean = if apart == 0.0 { 1.0 } else { -expm1(-apart) / apart };
    b * exp(-a.min(b)) * mean
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(model: Model, times: &[f64]) -> Vec<f64> {
        let mut process = Process::at_rest(model, 0.0);
        process.put(0.0, 2.0);
        times.iter().map(|time| process.output_at(*time)).collect()
    }

    fn assert_close(is: &[f64], expected: &[f64]) {
        for (is, expected) in is.iter().zip(expected) {
            assert!((is - expected).abs() < 1e-12, "{is} instead of {expected}");
        }
    }

    #[test]
    fn a_lag_with_dead_time_does_63_percent_of_its_way_in_a_time_constant() {
        let model = Model { gain: 1.5, time_constant: 10.0, dead_time: 0.25, ..Model::default() };
        let at = |time: f64| 3.0 * (1.0 - (-(time - 0.25_f64).max(0.0) / 10.0).exp());
        assert_close(
            &step(model, &[0.1, 0.2, 0.3, 10.25, 40.0]),
            &[0.0, 0.0, at(0.3), 3.0 * 0.632_120_558_828_557_7, at(40.0)],
        );
    }

    #[test]
    fn two_lags_are_solved_exactly_whether_they_are_equal_or_not() {
        let model = Model { gain: 0.5, time_constant: 4.0, second_time_constant: 4.0, ..Model::default() };
        let equal = |time: f64| 1.0 - (1.0 + time / 4.0) * (-time / 4.0).exp();
        let times = [0.5, 1.0, 3.0, 20.0];
        assert_close(&step(model, &times), &times.map(equal));
        let apart = |time: f64| 1.0 - (8.0 * (-time / 8.0).exp() - 2.0 * (-time / 2.0).exp()) / 6.0;
        for (time_constant, second_time_constant) in [(8.0, 2.0), (2.0, 8.0)] {
            assert_close(&step(Model { time_constant, second_time_constant, ..model }, &times), &times.map(apart));
        }
        let first = Model { second_time_constant: 0.0, ..model };
        let second = Model { time_constant: 0.0, ..model };
        assert_close(&step(first, &times), &step(second, &times));
    }

    #[test]
    fn an_integrator_rises_evenly_and_a_lag_behind_it_makes_it_late() {
        let model = Model { gain: 0.25, dead_time: 1.0, is_integrating: true, ..Model::default() };
        assert_close(&step(model, &[0.5, 1.0, 3.0, 5.0]), &[0.0, 0.0, 1.0, 2.0]);
        let late = |time: f64| 0.5 * ((time - 1.0) - 2.0 * (1.0 - (-(time - 1.0) / 2.0).exp()));
        let times = [1.5, 3.0, 40.0];
        assert_close(&step(Model { second_time_constant: 2.0, ..model }, &times), &times.map(late));
    }

    #[test]
    fn moves_arrive_in_their_order_and_each_after_the_dead_time() {
        let model = Model { gain: 1.0, dead_time: 2.5, ..Model::default() };
        let mut process = Process::at_rest(model, 10.0);
        for (time, input) in [(10.0, 1.0), (11.0, 5.0), (12.0, 5.0), (13.0, 0.0)] {
            process.put(time, input);
        }
        let outputs: Vec<f64> = [12.0, 12.6, 13.4, 13.6, 15.4, 15.6].map(|time| process.output_at(time)).into();
        assert_close(&outputs, &[0.0, 1.0, 1.0, 5.0, 5.0, 0.0]);
    }
}
