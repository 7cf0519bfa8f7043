//! fmi2DoStep and fmi2CancelStep.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, Model};
use crate::numbers::any_real;
use tests::{Kind, Random, Status};

impl Host<'_> {
    pub(crate) fn do_step(&mut self, turn: &mut Turn) -> Answer {
        let cycle = turn.model.values[self.fmu.cycle as usize];
        let (tc, h) = any_step(turn.random, cycle, turn.model.end);
        let expected =
            if turn.allowed { self.step_expected(&turn.model, tc, h) } else { Expected::Exactly(Status::Error) };
        // SAFETY: a living component.
        let status = unsafe { (self.fmu.library.do_step)(turn.component, tc, h, turn.random.pick(&[0, 1])) }.into();
        let mut after = turn.model.clone();
        self.slot(turn.place).is_step_odd = 1e-6 < h && h < cycle / 100.0;
        if h != 0.0 {
            after.end = after.end.max(tc + h);
        }
        Answer { status, expected, arguments: format!("{tc:?}, {h:?}"), after }
    }

    /// No step is ever in progress.
    pub(crate) fn cancel_step(&mut self, turn: &mut Turn) -> Answer {
        // SAFETY: a living component.
        let status = unsafe { (self.fmu.library.cancel_step)(turn.component) }.into();
        turn.unchanged(status, Expected::Exactly(Status::Error), String::new())
    }

    /// What a step has to answer in state stepComplete.
    fn step_expected(&self, model: &Model, tc: f64, h: f64) -> Expected {
        let cycle = model.values[self.fmu.cycle as usize];
        let extreme = model.derivatives.iter().any(|(reference, derivatives)| {
            let largest = if self.fmu.variables[*reference as usize].kind == Kind::Real { 1e37 } else { 1e300 };
            model.values[*reference as usize].abs() > largest || derivatives.iter().any(|order| order.abs() > 1e4)
        });
        match step_expected(model.experiment.unwrap(), cycle, model.end, tc, h) {
            Expected::Exactly(Status::Ok) if extreme => Expected::OkOrError,
            expected => expected,
        }
    }
}

/// A point and a step: what a host would go on with, and what it gets wrong.
pub(crate) fn any_step(random: &mut Random, cycle: f64, end: f64) -> (f64, f64) {
    let cycle = cycle.max(0.001);
    let h = match random.below(12) {
        0 => random.pick(&[
            0.0,
            0.0,
            -0.0,
            cycle * 0.003,
            -cycle,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e300,
            f64::MAX,
        ]),
        1 => random.pick(&[1e-16, 5e-324, cycle * 1e-9, cycle * 1e10]),
        2 => random.between(0.0, 5.0) * cycle,
        3 => cycle * 20.0,
        4 => any_real(random),
        _ => cycle * random.pick(&[1.0, 1.0, 1.0, 0.1, 1.0 / 3.0, 2.0]),
    };
    let tc = match random.below(12) {
        0 => random.pick(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 0.0, -1.0]),
        1 => end - cycle * random.pick(&[0.5, 1.0, 3.0, 1e6]),
        2 => end + cycle * random.pick(&[1.0, 0.25, 20.0, 1e10]),
        3 => end * (1.0 + f64::EPSILON),
        4 => any_real(random),
        _ => end,
    };
    // No step that would take long: few calls, or too many to be made at all.
    let calls = (tc + h - end) / cycle;
    if (100.0..1e10).contains(&calls) { (end, cycle) } else { (tc, h) }
}

/// What a step has to answer where one may be made, for an experiment from `start` to `stop` whose steps went to `end`.
pub(crate) fn step_expected((start, stop): (f64, f64), cycle: f64, end: f64, tc: f64, h: f64) -> Expected {
    if !(h >= 0.0 && h.is_finite() && tc.is_finite()) {
        return Expected::Exactly(Status::Error);
    }
    // 2^47 CYCLEs from 0 a double no longer tells the calls apart.
    let far = start.abs().max(tc.abs()) / cycle / 2f64.powi(47);
    // How much two times may differ that are one.
    let same = 1e-6 * cycle + 4.0 * f64::EPSILON * start.abs().max(tc.abs());
    let behind = end - tc;
    let beyond = tc + h - stop;
    // `any_step` leaves out what lies in between. A step of 0 makes no call at all.
    let too_many = h != 0.0 && (tc + h - end) / cycle >= 1e10;
    if far > 1.01 || behind > 2.0 * same || beyond > 2.0 * same + 0.26 * cycle || too_many {
        return Expected::Exactly(Status::Error);
    }
    if far > 0.98 || behind > 0.5 * same || beyond > 0.5 * same {
        return Expected::OkOrError;
    }
    Expected::Exactly(Status::Ok)
}
