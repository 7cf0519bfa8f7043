//! Loops: instances of blocks with the values of their inputs and parameters.

use crate::block::Block;
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
    /// Its name: that of the data block (`TIC101`, or `DB41` where there is only a number), of the member of a
    /// multi-instance, or of the file.
    pub name: String,
    /// What its author calls it: the TITLE of its data block in a source of STEP 7.
    pub title: Option<String>,
    /// What it is an instance of.
    pub block: Arc<Block>,
    /// One for each member of the block that is settable ([`blocks::Role::is_settable`]), in the order of the members.
    pub settings: Vec<Setting>,
}

/// The value of an input or a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The index of the member of the block.
    pub member: usize,
    /// Its value, of the member's type.
    pub value: Value,
    /// Where the value comes from.
    pub origin: Origin,
}

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The file does not have it: the block's start value.
    Default,
    /// From this place of a text.
    Text {
        /// The file's name, as the user gave it.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The column in characters, from 1.
        column: usize,
        /// Where in the text, in bytes.
        span: Range<usize>,
    },
    /// From this file, which has no lines.
    File {
        /// The file's name, as the user gave it.
        file: String,
    },
    /// From this address of a data block.
    Data {
        /// The file's name, or the address of the PLC, as the user gave it.
        file: String,
        /// Where in the data block.
        address: Address,
    },
}

impl fmt::Display for Origin {
    /// `plant.awl:12:8`, `DB41.bin, byte 20`, `default`.
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
    /// An instance whose settings all have the block's start values.
    pub fn new(name: impl Into<String>, block: Arc<Block>) -> Loop {
        let settings = block
            .members
            .iter()
            .enumerate()
            .filter(|(_, member)| member.role.is_settable())
            .map(|(index, member)| Setting { member: index, value: member.start, origin: Origin::Default })
            .collect();
        Loop { name: name.into(), title: None, block, settings }
    }

    /// Gives a member of the block its value. Nothing happens if the member is not settable.
    pub fn set(&mut self, member: usize, value: Value, origin: Origin) {
        if let Some(setting) = self.settings.iter_mut().find(|setting| setting.member == member) {
            (setting.value, setting.origin) = (value, origin);
        }
    }

    /// The value of the member with this full name; `None` if there is none, or it is not settable.
    pub fn get(&self, name: &str) -> Option<Value> {
        let member = self.block.find(name)?;
        self.settings.iter().find(|setting| setting.member == member).map(|setting| setting.value)
    }

    /// The settings outside their range of sense, which the block does not enforce: a sentence each.
    pub fn outside(&self) -> Vec<String> {
        let outside = |setting: &Setting| {
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

    /// What a user should know of the settings before he uses them: a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        [self.outside(), self.advice()].concat()
    }

    /// What the block will do with the settings where a user may not expect it.
    pub fn advice(&self) -> Vec<String> {
        let settings: Vec<_> = self.settings.iter().map(|setting| (setting.member, setting.value)).collect();
        self.block.advice(&settings)
    }
}
