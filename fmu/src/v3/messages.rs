//! The FMI 3.0 messages, in addition to the shared ones.

pub(crate) use crate::messages::*;

messages! {
    no_simulation_of_this_kind(): "this FMU is for co-simulation only: call fmi3InstantiateCoSimulation";
    function_of_another_kind(kind: &str): "this function is for {kind}, but this FMU is for co-simulation only";
    no_structural_parameters(): "the FMU has no structural parameters";
    no_configuration_mode(): "the FMU has no structural parameters and no Configuration Mode";
    none_of_this_type(kind: &str): "the FMU has no {kind} variables";
    inside_array(reference: u32, array: u32):
        "value reference {reference} is an element of an array: use {array}, the value reference of the array";
    wrong_count(count: usize, found: usize): "nValues = {count}: must be {found} for these variables";
    time_is_float64(reference: u32): "value reference {reference} is the time, of type Float64: use fmi3GetFloat64";
    time_is_read(reference: u32): "value reference {reference} is the time, of type Float64: it can only be read";
    no_dependencies(reference: u32):
        "value reference {reference} is not an output: only outputs have dependencies";
    wrong_dependency_count(count: usize, found: usize): "nDependencies = {count}: must be {found} for this variable";
    step_of_zero(): "communicationStepSize = 0.0: must be above 0";
}
