//! The FMI 2.0 messages, in addition to the shared ones.

pub(crate) use crate::messages::*;

messages! {
    no_simulation_of_this_type(kind: i32): "fmuType = {kind}: this FMU is for co-simulation (1) only";
    nothing_to_cancel(): "a step is complete when fmi2DoStep returns, so there is never a step to cancel";
    no_status(kind: i32): "status kind {kind} is not available: no step is ever pending";
    counts_as_real(name: &str, kind: &str): "{name} is of type {kind} but is accessed as a Real (TRUE is 1)";
}
