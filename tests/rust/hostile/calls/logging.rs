//! fmi2SetDebugLogging.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, count_of, good_array, ok_if};
use std::ffi::{CStr, c_char};
use std::ptr;
use tests::{Random, Status};

/// The four categories of the FMUs, and two that they do not have.
const CATEGORIES: [&CStr; 6] =
    [c"logStatusError", c"logStatusDiscard", c"logStatusFatal", c"logAdvice", c"logAll", c""];

impl Host<'_> {
    pub(crate) fn set_debug_logging(&mut self, turn: &mut Turn) -> Answer {
        let random = &mut *turn.random;
        let (chosen, pointers) = any_categories(random);
        let (count, null) = count_of(random, chosen.len());
        let on = random.pick(&[0, 1, 1, -1]);
        let expected = expected(turn, count, &chosen, null);

        let categories = if null { ptr::null() } else { pointers.as_ptr() };
        // SAFETY: as many strings as counted, or counts and pointers that are to be refused.
        let status: Status =
            unsafe { (self.fmu.library.set_debug_logging)(turn.component, on, count, categories) }.into();
        if status == Status::Ok {
            let slot = self.slot(turn.place);
            for category in 0..4 {
                slot.logged[category] = on != 0 && (count == 0 || chosen[..count].contains(&category));
            }
        }
        turn.unchanged(status, expected, format!("{on}, {count}, {chosen:?}"))
    }
}

/// Categories by their places, of which 4 and more are none that an FMU has, and what the function takes.
pub(crate) fn any_categories(random: &mut Random) -> (Vec<usize>, Vec<*const c_char>) {
    // 6 stands for NULL.
    let chosen: Vec<usize> = (0..random.below(4)).map(|_| random.pick(&[0, 0, 1, 1, 2, 3, 3, 4, 5, 6])).collect();
    let pointer = |choice: &usize| CATEGORIES.get(*choice).map_or(ptr::null(), |text| text.as_ptr());
    let pointers = chosen.iter().map(pointer).collect();
    (chosen, pointers)
}

fn expected(turn: &Turn, count: usize, chosen: &[usize], null: bool) -> Expected {
    let known = chosen.iter().take(count).all(|choice| *choice < 4);
    ok_if(turn.allowed && good_array(count, chosen.len(), null) && known)
}
