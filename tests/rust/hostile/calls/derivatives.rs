//! fmi2GetDirectionalDerivative, which the FMUs do not offer, and the derivatives of inputs and outputs.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, count_of, good_array, ok_if};
use crate::numbers::any_real;
use std::ffi::c_int;
use std::ptr;
use tests::{Fmu, Kind, Role, Status};

impl Host<'_> {
    pub(crate) fn get_directional_derivative(&mut self, turn: &mut Turn) -> Answer {
        let references = [0, 1, u32::MAX];
        let (known, mut unknown) = ([1.0; 3], [4711.5; 3]);
        let count = turn.random.below(4);
        let vr = references.as_ptr();
        let get = self.fmu.library.get_directional_derivative;
        // SAFETY: as many elements as counted.
        let status = unsafe { get(turn.component, vr, count, vr, count, known.as_ptr(), unknown.as_mut_ptr()) }.into();
        let arguments = format!("{count}");
        assert_eq!(unknown, [4711.5; 3], "{} was refused but wrote", turn.with(&arguments));
        turn.unchanged(status, Expected::Exactly(Status::Error), arguments)
    }

    pub(crate) fn set_real_input_derivatives(&mut self, turn: &mut Turn) -> Answer {
        let references = self.references(turn.random, "fmi2SetReal");
        let random = &mut *turn.random;
        let (count, vr_null) = count_of(random, references.len());
        let (orders_null, values_null) = (random.once_in(16), random.once_in(16));
        let orders: Vec<c_int> = references
            .iter()
            .map(|_| random.pick(&[1, 1, 1, 1, 2, 3, 4, 4, 0, 5, -1, c_int::MAX, c_int::MIN]))
            .collect();
        let values: Vec<f64> = references
            .iter()
            .map(|_| if random.once_in(4) { any_real(random) } else { random.pick(&[0.0, -0.0, 0.5, -2.0, 10.0]) })
            .collect();
        let null = vr_null || orders_null || values_null;
        let expected = input_derivatives_expected(turn, self.fmu, &references, count, null, &orders, &values);

        let vr = if vr_null { ptr::null() } else { references.as_ptr() };
        let order = if orders_null { ptr::null() } else { orders.as_ptr() };
        let value = if values_null { ptr::null() } else { values.as_ptr() };
        let set = self.fmu.library.set_real_input_derivatives;
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status = unsafe { set(turn.component, vr, count, order, value) }.into();

        let mut after = turn.model.clone();
        if status == Status::Ok {
            for place in 0..count.min(references.len()) {
                let derivatives = after.derivatives.entry(references[place]).or_default();
                derivatives[orders[place] as usize - 1] = values[place];
            }
            after.derivatives.retain(|_, derivatives| *derivatives != [0.0; 4]);
        }
        Answer { status, expected, arguments: format!("{references:?}, {count}, {orders:?}, {values:?}"), after }
    }

    pub(crate) fn get_real_output_derivatives(&mut self, turn: &mut Turn) -> Answer {
        let count = turn.random.below(3);
        let (references, orders, mut values) = ([0; 3], [1; 3], [4711.5; 3]);
        // The FMUs offer none.
        let expected = ok_if(turn.allowed && count == 0);
        let get = self.fmu.library.get_real_output_derivatives;
        // SAFETY: as many elements as counted.
        let status =
            unsafe { get(turn.component, references.as_ptr(), count, orders.as_ptr(), values.as_mut_ptr()) }.into();
        let arguments = format!("{count}");
        assert_eq!(values, [4711.5; 3], "{} has nothing to write", turn.with(&arguments));
        turn.unchanged(status, expected, arguments)
    }
}

/// All are REAL or LREAL inputs, with an order from 1 to 4 and a finite value.
fn input_derivatives_expected(
    turn: &Turn,
    fmu: &Fmu,
    references: &[u32],
    count: usize,
    null: bool,
    orders: &[c_int],
    values: &[f64],
) -> Expected {
    let fit = (0..count.min(references.len())).all(|place| {
        let variable = fmu.variables.get(references[place] as usize);
        variable
            .is_some_and(|variable| variable.role == Role::Input && matches!(variable.kind, Kind::Real | Kind::LReal))
            && (1..=4).contains(&orders[place])
            && values[place].is_finite()
    });
    ok_if(turn.allowed && good_array(count, references.len(), null) && fit)
}
