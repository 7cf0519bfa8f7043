//! The types in which a host passes values, depending on the version of the standard.

use crate::cyclic::Cyclic;
use crate::ordinary;
use blocks::{Kind, Row, TableText, Value};

/// The names used by a version of the standard.
pub trait Version {
    /// The version number as in modelDescription.xml.
    const NUMBER: &'static str;

    /// The common prefix of its function names.
    const PREFIX: &'static str;

    /// The name of the type in which a host accesses a row, as used in the name of the setter.
    fn name_of<S: TableText>(row: &Row<S>) -> &'static str;
}

/// A C type in which a version of the standard passes values.
pub trait HostType<V: Version>: Copy {
    /// Whether a host passes PLC values of this kind as this type.
    fn holds(kind: Kind) -> bool;

    /// Whether a host passes the values of this row as this type.
    #[inline(always)]
    fn is_of<S: TableText>(row: &Row<S>) -> bool {
        Self::holds(row.kind)
    }

    /// Converts to a PLC value of a kind that this type holds.
    ///
    /// # Errors
    /// The range, as a string, if the value is outside it.
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str>;

    /// Converts from a PLC value; `None` if this type does not hold its kind.
    fn from_plc(value: Value) -> Option<Self>;

    /// The value as a string, for messages.
    fn text(self) -> String;

    /// Writes variables in the ordinary case; see [`ordinary`]. In every other case, returns false and changes nothing.
    #[inline(always)]
    fn set_ordinary<B: Cyclic>(block: &mut B, references: &[u32], values: &[Self]) -> bool {
        ordinary::set_values(block, references, values)
    }

    /// Reads variables in the ordinary case. In every other case, returns false and leaves `values` unchanged.
    #[inline(always)]
    fn get_ordinary<B: Cyclic>(block: &B, references: &[u32], values: &mut [Self]) -> bool {
        ordinary::get_values(block, references, values)
    }
}
