//! The messages shared by both doors, the Rust library and the C sources of an FMU. Each is written once: here it
//! becomes a Rust function, and a C function when an FMU is packed.

/// A message.
#[derive(Debug)]
pub(crate) struct Message {
    /// The name of its function.
    pub(crate) name: &'static str,
    /// The arguments, each with its type.
    pub(crate) arguments: &'static [(&'static str, &'static str)],
    /// Its text, with the arguments in braces.
    pub(crate) text: &'static str,
}

macro_rules! messages {
    ($($name:ident($($argument:ident: $type:ty),*): $text:literal;)*) => {
        $(
            #[cold]
            pub(crate) fn $name($($argument: $type),*) -> String {
                format!($text)
            }
        )*

        /// All messages.
        pub(crate) const ALL: &[$crate::messages::Message] = &[$($crate::messages::Message {
            name: stringify!($name),
            arguments: &[$((stringify!($argument), stringify!($type))),*],
            text: $text,
        }),*];
    };
}
pub(crate) use messages;

messages! {
    // Calls and their arguments
    not_now(state: &str, allowed: &str): "not allowed in state {state}, only in {allowed}";
    no_elements(name: &str, count: usize): "{name} is NULL; an array of length {count} is required";
    too_many_elements(name: &str, count: usize): "{name} cannot have {count} elements: they would not fit in memory";
    no_target(name: &str): "{name} is NULL; it must point to a variable";
    no_name(): "instanceName is NULL or empty: give the instance a name";
    other_library(name: &str, given: &str, own: &str):
        "{name} = {given}: this library is {own}; use the modelDescription.xml that came with it";
    no_category(): "a category is NULL";
    unknown_category(name: &str):
        "category {name:?} is unknown: the categories are logStatusError, logStatusDiscard, logStatusFatal, logAdvice";
    not_provided(capability: &str): "not provided ({capability} = false)";
    no_output_derivatives(): "outputs change in steps and have no derivatives (maxOutputDerivativeOrder = 0)";
    no_event_mode(): "the instance was created without Event Mode (eventModeUsed = false)";

    // Variables
    other_type(reference: u32, name: &str, kind: &str, prefix: &str, access: &str):
        "value reference {reference} is {name}, of type {kind}: use {prefix}{access}{kind}";
    unknown_reference(reference: u32, last: usize):
        "value reference {reference} is unknown: valid ones are 0 to {last}";
    fixed_parameter(name: &str, prefix: &str):
        "{name} is a fixed parameter: set it before {prefix}ExitInitializationMode, or call {prefix}Reset \
         first";
    computed(name: &str): "{name} is computed by the block and can only be read";
    out_of_range(name: &str, value: &str, range: &str): "{name} = {value}: {range}";
    no_text(name: &str): "{name} = NULL: a string is required; it may be empty";
    not_utf8(name: &str, byte: usize): "{name}: the string is not UTF-8: byte {byte} is invalid";
    no_real_input(name: &str): "{name} is not a Real input: only Real inputs have derivatives";
    wrong_order(name: &str, order: i32): "{name}: the order of a derivative must be 1 to 4, not {order}";
    endless_derivative(name: &str, derivative: f64): "{name}: a derivative must be finite, not {derivative:?}";
    extrapolated(name: &str, seconds: f64, range: &str):
        "{name}, extrapolated over {seconds:?} s, may leave its range: {range}";

    // Times
    start_time(start: f64): "startTime = {start:?}: must be finite";
    stop_time(stop: f64, start: f64): "stopTime = {stop:?}: must not be before startTime = {start:?}";
    no_start_time(setup: &str): "the start time is unknown: call {setup} first";
    short_cycle(name: &str, cycle: f64): "{name} = {cycle:?} s: the time between two calls must be at least 0.001 s";
    no_time(tc: f64, h: f64):
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the point must be finite, the \
         step finite and not negative";
    no_resolution(name: &str, time: f64, cycle: f64):
        "{name} = {time:?}: this far from 0, a double no longer distinguishes one CYCLE of {cycle} s from \
         the next; start closer to 0";
    before_end(tc: f64, end: f64):
        "currentCommunicationPoint = {tc:?} is before {end:?}, where the last step ended; to go back, \
         restore an FMU state";
    after_stop(tc: f64, h: f64, stop: f64):
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the step ends after stopTime = \
         {stop:?}";
    too_many_calls(tc: f64, h: f64, end: f64, cycle: f64):
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: from {end:?} onward, with one \
         call every {cycle} s, this is more than 4294967296 calls; make the step shorter";
    short_step(h: f64, name: &str, cycle: f64, times: f64):
        "communicationStepSize = {h:?}: {name} = {cycle:?} s is {times} times as long, and most steps make \
         no call; is {name} given in ms instead of s?";

    // States
    unknown_state():
        "the state was not saved by this instance or has been freed; to move a state to another instance, \
         serialize it";
    state_in_event_mode():
        "the state was saved in Event Mode, but this instance was created without it (eventModeUsed = false)";
    small_buffer(size: usize, length: usize): "size = {size}: the state needs {length} bytes";
    no_serialized_state(): "the bytes are not a serialized state of this format";
    state_of_another_fmu(name: &str): "the state belongs to another FMU or version; this is {name}";
    damaged_state(): "the serialized state is damaged";
}
