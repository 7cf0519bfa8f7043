//! Adds block laws to programs with instances of those blocks.

use crate::{Sources, read};
use scl::ir::{Body, Program};

/// A copy of the program to which the laws of its native blocks have been added, so that it can be printed as C.
///
/// # Errors
/// The law of a block uses something unsupported; the message states the location.
pub fn with_laws(program: &Program) -> Result<Program, String> {
    let mut linked = program.clone();
    let sources = Sources::of_blocks();
    for (number, function) in program.functions.iter().enumerate() {
        let Body::Native(name) = function.body else { continue };
        let law = read(&sources, name).map_err(|error| error.to_string())?;
        let is_call = |name: &str| name.strip_prefix(law.name.as_str()) == Some(".call");
        let call = law.program.functions.iter().position(|function| is_call(&function.name));
        let call = call.ok_or_else(|| format!("{name} has no method `call`"))?;
        linked.add_law(number, &law.program, call)?;
    }
    Ok(linked)
}
