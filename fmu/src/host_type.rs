//! Values as a host passes them: the properties of each of its types in a version of the standard.

use crate::cyclic::Cyclic;
use crate::ordinary;
use blocks::{Kind, Row, TableText, Value};

/// The words of a version of the standard.
pub trait Version {
    /// Its number, as modelDescription.xml has it.
    const NUMBER: &'static str;

    /// The common prefix of its function names.
    const PREFIX: &'static str;

    /// Its name of the type that holds the values of a row, as in the name of the function that sets it.
    fn name_of<S: TableText>(row: &Row<S>) -> &'static str;
}

/// A type of values, as C passes it in a version of the standard.
pub trait HostType<V: Version>: Copy {
    /// Whether PLC values of this kind are values of this type.
    fn holds(kind: Kind) -> bool;

    /// Whether the values of a row are values of this type.
    #[inline(always)]
    fn is_of<S: TableText>(row: &Row<S>) -> bool {
        Self::holds(row.kind)
    }

    /// The PLC value of a kind that this type holds.
    ///
    /// # Errors
    /// The range, as a text, if the value lies outside.
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str>;

    /// The PLC value in this type; `None` if it is of another.
    fn from_plc(value: Value) -> Option<Self>;

    /// The value for a message.
    fn text(self) -> String;

    /// Writes variables in the ordinary cases, see [`ordinary`]. False, and nothing is changed, in every other
    /// case.
    #[inline(always)]
    fn set_ordinary<B: Cyclic>(block: &mut B, references: &[u32], values: &[Self]) -> bool {
        ordinary::set_values(block, references, values)
    }

    /// Reads variables in the ordinary case. False, and nothing is written, in every other case.
    #[inline(always)]
    fn get_ordinary<B: Cyclic>(block: &B, references: &[u32], values: &mut [Self]) -> bool {
        ordinary::get_values(block, references, values)
    }
}
