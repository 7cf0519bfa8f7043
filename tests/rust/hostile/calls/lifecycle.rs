//! The functions that lead an instance from state to state.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, Model, ok_if};
use crate::numbers::any_real;
use std::ffi::c_int;
use tests::{Random, Status};

impl Host<'_> {
    pub(crate) fn setup_experiment(&mut self, turn: &mut Turn) -> Answer {
        let random = &mut *turn.random;
        let cycle = turn.model.values[self.fmu.cycle as usize];
        let (start, stop) = any_experiment(random, cycle);
        let stop_defined: c_int = random.pick(&[0, 0, 1, -1]);
        let tolerance = any_real(random);
        let expected = ok_if(turn.allowed && is_good_experiment(start, stop_defined, stop));
        let setup_experiment = self.fmu.library.setup_experiment;
        // SAFETY: a living component.
        let status = unsafe { setup_experiment(turn.component, 1, tolerance, start, stop_defined, stop) }.into();
        let mut after = turn.model.clone();
        after.experiment = Some((start, if stop_defined != 0 { stop } else { f64::INFINITY }));
        Answer { status, expected, arguments: format!("{start:?}, {stop_defined}, {stop:?}"), after }
    }

    pub(crate) fn enter_initialization_mode(&mut self, turn: &mut Turn) -> Answer {
        let expected = ok_if(turn.allowed && turn.model.experiment.is_some());
        // SAFETY: a living component.
        let status = unsafe { (self.fmu.library.enter_initialization_mode)(turn.component) }.into();
        Answer { status, expected, arguments: String::new(), after: Model { state: 1, ..turn.model.clone() } }
    }

    pub(crate) fn exit_initialization_mode(&mut self, turn: &mut Turn) -> Answer {
        let expected = if turn.allowed && self.has_whole_cycle(&turn.model) {
            Expected::OkOrError
        } else {
            Expected::Exactly(Status::Error)
        };
        // SAFETY: a living component.
        let status = unsafe { (self.fmu.library.exit_initialization_mode)(turn.component) }.into();
        let start = turn.model.experiment.map_or(0.0, |(start, _)| start);
        Answer {
            status,
            expected,
            arguments: String::new(),
            after: Model { state: 2, end: start, ..turn.model.clone() },
        }
    }

    /// The time between two calls is a millisecond or more.
    fn has_whole_cycle(&self, model: &Model) -> bool {
        model.values[self.fmu.cycle as usize] >= 0.001
    }

    pub(crate) fn terminate(&mut self, turn: &mut Turn) -> Answer {
        let expected = ok_if(turn.allowed);
        // SAFETY: a living component.
        let status: Status = unsafe { (self.fmu.library.terminate)(turn.component) }.into();
        Answer { status, expected, arguments: String::new(), after: Model { state: 3, ..turn.model.clone() } }
    }

    pub(crate) fn reset(&mut self, turn: &mut Turn) -> Answer {
        let expected = ok_if(turn.allowed);
        // SAFETY: a living component.
        let status: Status = unsafe { (self.fmu.library.reset)(turn.component) }.into();
        Answer { status, expected, arguments: String::new(), after: Model::new(self.fmu) }
    }
}

/// Start and stop time.
pub(crate) fn any_experiment(random: &mut Random, cycle: f64) -> (f64, f64) {
    let start = match random.below(3) {
        0 => any_real(random),
        _ => random.pick(&[0.0, 0.0, 1234.5, -5.0, 1e5, 1e7, 1e9, -1e9, 1e12, 1e18, 1e300]),
    };
    let cycle = cycle.max(0.001);
    let stop = match random.below(6) {
        0 => any_real(random),
        1 => start,
        2 => start + 20.0 * cycle,
        _ => start + 1e6 * cycle,
    };
    (start, stop)
}

pub(crate) fn is_good_experiment(start: f64, stop_defined: c_int, stop: f64) -> bool {
    start.is_finite() && (stop_defined == 0 || stop >= start)
}
