//! The description of a block that parameter files need: its names, its members and its advice on settings.

use blocks::{EachBlock, Kind, Role, StaticRow, Value, for_each_block};
use std::fmt;
use std::sync::Arc;

/// A block type, as far as parameter files are concerned.
#[derive(Clone)]
pub struct BlockType {
    /// Its name, such as `PUMP`.
    pub name: String,
    /// Other names by which a PLC project may call it, such as `FB 41`.
    pub aliases: Vec<String>,
    /// Its variables, in the order of the instance data block; then those of inner blocks, with full names; then those
    /// that exist only in the FMU.
    pub members: Vec<Member>,
    advice: Option<Advice>,
}

/// A function that advises on settings, given as member indices and values.
type Advice = fn(&[(usize, Value)]) -> Vec<String>;

/// One variable of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its name, qualified by the instances that lead to it: `GAIN`, `DI_PUMP.GAIN`.
    pub name: String,
    /// A short description.
    pub description: String,
    /// Its PLC type.
    pub kind: Kind,
    /// Its role: who sets it, and when. [`Role::is_settable`] is true of inputs and parameters.
    pub role: Role,
    /// Its start value.
    pub start: Value,
    /// The lowest plausible value; the block does not enforce it.
    pub min: Option<Value>,
    /// The highest plausible value; the block does not enforce it.
    pub max: Option<Value>,
    /// Its physical unit; `None` also for a TIME, which is in seconds.
    pub unit: Option<String>,
    /// Where the PLC stores it.
    pub part: VariableOwner,
}

impl Member {
    /// A variable of the block itself, with the type of its start value, and without description, range and unit.
    pub fn new(name: impl Into<String>, role: Role, start: Value) -> Member {
        Member {
            name: name.into(),
            description: String::new(),
            kind: start.kind(),
            role,
            start,
            min: None,
            max: None,
            unit: None,
            part: VariableOwner::Own,
        }
    }

    /// The unit in which its values are displayed: seconds for a duration, otherwise its own.
    pub fn shown_unit(&self) -> Option<&str> {
        self.kind.shown_unit(self.unit.as_deref())
    }
}

/// The owner of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableOwner {
    /// The block itself: the variable has an address in the instance data block.
    Own,
    /// A block inside it.
    Inner,
    /// The FMU only; the PLC does not have the variable.
    FmuOnly,
}

impl BlockType {
    /// The description in the table of a block.
    pub fn for_block<B: blocks::Block>() -> BlockType {
        let table = B::TABLE;
        let member = |(index, row): (usize, &StaticRow)| Member {
            name: row.name.to_string(),
            description: row.description.to_string(),
            kind: row.kind,
            role: row.role,
            start: row.start,
            min: row.min,
            max: row.max,
            unit: row.unit.map(str::to_string),
            part: match () {
                () if table.mean == Some(index) => VariableOwner::FmuOnly,
                () if row.is_inner() => VariableOwner::Inner,
                () => VariableOwner::Own,
            },
        };
        BlockType {
            name: table.name.to_string(),
            aliases: table.aliases.iter().map(|alias| alias.to_string()).collect(),
            members: table.rows.iter().enumerate().map(member).collect(),
            advice: Some(advice::<B>),
        }
    }

    /// A block known only by its description, so that no advice on its settings is available.
    pub fn new(name: String, aliases: Vec<String>, members: Vec<Member>) -> BlockType {
        BlockType { name, aliases, members, advice: None }
    }

    /// All blocks of the crate `blocks`.
    pub fn all() -> Vec<Arc<BlockType>> {
        struct All(Vec<Arc<BlockType>>);
        impl EachBlock for All {
            fn block<B: blocks::Block>(&mut self) {
                self.0.push(Arc::new(BlockType::for_block::<B>()));
            }
        }
        let mut all = All(Vec::new());
        for_each_block(&mut all);
        all.0
    }

    /// Whether `name` denotes the block in a PLC project: it is its name or an alias, ignoring case, spaces and quotes:
    /// `FB41`, `fb 41` and `"PUMP"`.
    pub fn is_called(&self, name: &str) -> bool {
        let plain = |name: &str| name.replace([' ', '\t', '"'], "").to_uppercase();
        let name = plain(name);
        std::iter::once(&self.name).chain(&self.aliases).any(|own| plain(own) == name)
    }

    /// The index of the member with this full name, ignoring case.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|member| member.name.eq_ignore_ascii_case(name))
    }

    /// Advice on what the block does with these settings that a user may not expect: sentences with names and numbers.
    /// Other settings have their start values. Empty for a block known only by its description.
    pub fn advice(&self, settings: &[(usize, Value)]) -> Vec<String> {
        self.advice.map_or_else(Vec::new, |advice| advice(settings))
    }
}

fn advice<B: blocks::Block>(settings: &[(usize, Value)]) -> Vec<String> {
    let mut block = B::default();
    for (index, value) in settings {
        block.set(*index, *value);
    }
    let mut advice = block.advice();
    advice.extend(block.check().err());
    advice
}

impl fmt::Debug for BlockType {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_struct("Block").field("name", &self.name).finish_non_exhaustive()
    }
}

impl PartialEq for BlockType {
    fn eq(&self, other: &BlockType) -> bool {
        (&self.name, &self.aliases, &self.members) == (&other.name, &other.aliases, &other.members)
    }
}
