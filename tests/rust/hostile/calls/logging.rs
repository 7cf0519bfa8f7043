//! fmi2SetDebugLogging.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, count_of, good_array, ok_if};
use std::ffi::{CStr, c_char};
use std::ptr;
use tests::Status;

/// The three categories of the FMUs, and two that they do not have.
const CATEGORIES: [&CStr; 5] = [c"logStatusError", c"logStatusDiscard", c"logStatusFatal", c"logAll", c""];

impl Host<'_> {
    pub fn set_debug_logging(&mut self, turn: &mut Turn) -> Answer {
        let random = &mut *turn.random;
        // 5 stands for NULL.
        let chosen: Vec<usize> = (0..random.below(4)).map(|_| random.pick(&[0, 0, 1, 1, 2, 3, 4, 5])).collect();
        let pointers: Vec<*const c_char> =
            chosen.iter().map(|choice| CATEGORIES.get(*choice).map_or(ptr::null(), |text| text.as_ptr())).collect();
        let (count, null) = count_of(random, chosen.len());
        let on = random.pick(&[0, 1, 1, -1]);
        let expected = expected(turn, count, &chosen, null);

        let categories = if null { ptr::null() } else { pointers.as_ptr() };
        // SAFETY: as many strings as counted, or counts and pointers that are to be refused.
        let status: Status =
            unsafe { (self.fmu.library.set_debug_logging)(turn.component, on, count, categories) }.into();
        if status == Status::Ok {
            let slot = self.slot(turn.place);
            for category in 0..3 {
                slot.logged[category] = on != 0 && (count == 0 || chosen[..count].contains(&category));
            }
        }
        turn.unchanged(status, expected, format!("{on}, {count}, {chosen:?}"))
    }
}

fn expected(turn: &Turn, count: usize, chosen: &[usize], null: bool) -> Expected {
    let known = chosen.iter().take(count).all(|choice| *choice < 3);
    ok_if(turn.allowed && good_array(count, chosen.len(), null) && known)
}
