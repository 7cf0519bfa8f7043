//! Loops: instances of blocks with the values of their inputs and parameters.

use crate::block::BlockType;
use crate::layout::Address;
use crate::value::decimal;
use blocks::table::number::number;
use blocks::{Kind, Value};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// One instance of a block, such as an instance data block of a PLC project.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its name: the name of the data block (`TIC101`, or `DB41` if it has only a number), of the member that is a
    /// multi-instance, or of the file.
    pub name: String,
    /// Its title: the TITLE of its data block in a STEP 7 source.
    pub title: Option<String>,
    /// The type of its block.
    pub block: Arc<BlockType>,
    /// The values of the block's settable members ([`blocks::Role::is_settable`]), in the order of the members.
    pub settings: Vec<MemberValue>,
}

/// A value of an input or parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberValue {
    /// The index of the member in the block.
    pub member: usize,
    /// Its value, of the member's type.
    pub value: Value,
    /// The origin of the value.
    pub origin: Origin,
}

/// The origin of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The block's start value, because the file contains no value.
    Default,
    /// A location in a text.
    Text {
        /// The file name, as given by the user.
        file: String,
        /// The 1-based line number.
        line: usize,
        /// The 1-based column, in characters.
        column: usize,
        /// The byte range in the text.
        span: Range<usize>,
    },
    /// A file, without a location in it.
    File {
        /// The file name, as given by the user.
        file: String,
    },
    /// An address in a data block.
    Data {
        /// The file name or the PLC's address, as given by the user.
        file: String,
        /// The address in the data block.
        address: Address,
    },
}

impl fmt::Display for Origin {
    /// Displays `plant.awl:12:8`, `DB41.bin, byte 20` or `default`.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Origin::Default => write!(formatter, "default"),
            Origin::Text { file, line, column, .. } => write!(formatter, "{file}:{line}:{column}"),
            Origin::File { file } => write!(formatter, "{file}"),
            Origin::Data { file, address } => write!(formatter, "{file}, byte {address}"),
        }
    }
}

impl Loop {
    /// An instance with the start values of its block.
    pub fn new(name: impl Into<String>, block: Arc<BlockType>) -> Loop {
        let settings = block
            .members
            .iter()
            .enumerate()
            .filter(|(_, member)| member.role.is_settable())
            .map(|(index, member)| MemberValue { member: index, value: member.start, origin: Origin::Default })
            .collect();
        Loop { name: name.into(), title: None, block, settings }
    }

    /// Sets the value of a member. Does nothing if the member is not settable.
    pub fn set(&mut self, member: usize, value: Value, origin: Origin) {
        if let Some(setting) = self.settings.iter_mut().find(|setting| setting.member == member) {
            (setting.value, setting.origin) = (value, origin);
        }
    }

    /// The value of the member with this full name; `None` if it does not exist or is not settable.
    pub fn get(&self, name: &str) -> Option<Value> {
        let member = self.block.find(name)?;
        self.settings.iter().find(|setting| setting.member == member).map(|setting| setting.value)
    }

    /// Warnings about settings outside their plausible range, which the block does not enforce: one sentence each.
    pub fn outside(&self) -> Vec<String> {
        let outside = |setting: &MemberValue| {
            let member = &self.block.members[setting.member];
            let value = number(setting.value);
            let is_low = member.min.is_some_and(|min| value < number(min));
            let is_high = member.max.is_some_and(|max| value > number(max));
            let unit = if member.kind == Kind::Time { " s" } else { "" };
            let bound = match (member.min, member.max) {
                _ if !value.is_finite() => "it is not a finite number".to_string(),
                (Some(min), _) if is_low => format!("the lowest sensible value is {}{unit}", decimal(min)),
                (_, Some(max)) if is_high => format!("the highest sensible value is {}{unit}", decimal(max)),
                _ => return None,
            };
            Some(format!("{} = {}{unit}: {bound}", member.name, decimal(setting.value)))
        };
        self.settings.iter().filter_map(outside).collect()
    }

    /// Warnings to the user about the settings: one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        [self.outside(), self.advice()].concat()
    }

    /// Advice on unexpected effects of the settings.
    pub fn advice(&self) -> Vec<String> {
        let settings: Vec<_> = self.settings.iter().map(|setting| (setting.member, setting.value)).collect();
        self.block.advice(&settings)
    }
}
