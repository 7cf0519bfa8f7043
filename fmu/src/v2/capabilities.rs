//! What the FMUs can do, as `<CoSimulation>` in modelDescription.xml says it.
//!
//! Each flag stands beside the code that provides it; here they are collected.

use crate::v2::{component, ffi, instance};

/// A capability flag: its attribute name and its value.
pub type Capability = (&'static str, Setting);

/// The value of a capability flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Whether the FMU can.
    Flag(bool),
    /// The highest order of derivatives.
    Order(u32),
}

impl Setting {
    /// The value as it is written in JSON and in XML.
    pub fn text(self) -> String {
        match self {
            Setting::Flag(flag) => flag.to_string(),
            Setting::Order(order) => order.to_string(),
        }
    }
}

/// All flags. Those that are left out, such as `needsExecutionTool`, are false.
pub fn all() -> impl Iterator<Item = Capability> {
    [instance::CAPABILITIES, component::CAPABILITIES, ffi::CAPABILITIES].into_iter().flatten().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_flag_is_told_once() {
        let mut names: Vec<&str> = all().map(|(name, _)| name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{names:?}");
    }
}
