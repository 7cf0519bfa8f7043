//! fmi2GetStatus, fmi2GetRealStatus, fmi2GetIntegerStatus, fmi2GetBooleanStatus, fmi2GetStringStatus.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::Expected;
use std::ffi::c_int;
use std::ptr;
use tests::Status;

impl Host<'_> {
    pub(crate) fn get_status(&mut self, turn: &mut Turn) -> Answer {
        let kind: c_int = turn.random.pick(&[0, 1, 2, 2, 3, 3, 4, -1, c_int::MAX]);
        let null = turn.random.once_in(8);
        let expected = expected(turn, kind, null);
        let (mut real, mut integer, mut text) = (4711.5, -4711, ptr::null());
        let to_integer = if null { ptr::null_mut() } else { &raw mut integer };
        let to_real = if null { ptr::null_mut() } else { &raw mut real };
        let to_text = if null { ptr::null_mut() } else { &raw mut text };
        let (library, component) = (&self.fmu.library, turn.component);
        // SAFETY: NULL, which is to be refused, or the host's variable.
        let status: Status = unsafe {
            match turn.name {
                "fmi2GetStatus" => (library.get_status)(component, kind, to_integer),
                "fmi2GetRealStatus" => (library.get_real_status)(component, kind, to_real),
                "fmi2GetIntegerStatus" => (library.get_integer_status)(component, kind, to_integer),
                "fmi2GetBooleanStatus" => (library.get_boolean_status)(component, kind, to_integer),
                "fmi2GetStringStatus" => (library.get_string_status)(component, kind, to_text),
                other => panic!("{other} gives no status"),
            }
        }
        .into();

        let arguments = format!("{kind}");
        let what = turn.with(&arguments);
        let is_ok = status == Status::Ok;
        let written_real = if is_ok && turn.name == "fmi2GetRealStatus" { turn.model.end } else { 4711.5 };
        let written_integer = if is_ok && turn.name == "fmi2GetBooleanStatus" { 0 } else { -4711 };
        assert_eq!((real.to_bits(), integer), (written_real.to_bits(), written_integer), "{what}");
        assert!(text.is_null(), "{what} wrote a text");
        turn.unchanged(status, expected, arguments)
    }
}

/// Two kinds are answered, fmi2LastSuccessfulTime and fmi2Terminated; the others are discarded: there is no pending step.
fn expected(turn: &Turn, kind: c_int, null: bool) -> Expected {
    let answered = matches!((turn.name, kind), ("fmi2GetRealStatus", 2) | ("fmi2GetBooleanStatus", 3));
    Expected::Exactly(match (turn.allowed && !null, answered) {
        (false, _) => Status::Error,
        (true, true) => Status::Ok,
        (true, false) => Status::Discard,
    })
}
