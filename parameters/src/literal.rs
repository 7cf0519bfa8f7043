//! Values as a PLC program writes them: `2.0e+000`, `T#20S`, `W#16#6C00`, `TRUE`.

use blocks::{Kind, Value};

/// The value of a literal for a member of this type.
///
/// # Errors
/// What was found and what is expected, as a part of a sentence.
pub fn parse(literal: &str, kind: Kind) -> Result<Value, String> {
    let _ = (literal, kind);
    todo!()
}

/// The value as a literal that reads back bit-equal.
pub fn text(value: Value) -> String {
    let _ = value;
    todo!()
}
