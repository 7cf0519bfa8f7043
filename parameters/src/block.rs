//! What a parameter file has to know of a block: its names, its members and what it does with its settings.

use blocks::{EachBlock, Kind, Role, Row, Value, for_each_block};
use std::fmt;
use std::sync::Arc;

/// A block type, as far as its instances can be written to parameter files.
#[derive(Clone)]
pub struct Block {
    /// The block's name, such as `PUMP`.
    pub name: String,
    /// The other names by which a PLC project may call the block, such as `FB 41`.
    pub aliases: Vec<String>,
    /// Its variables, in the order in which an instance data block holds them; then those of the blocks inside it, by their full names;
    /// then what only the FMU has.
    pub members: Vec<Member>,
    advice: Option<Advice>,
}

/// What a block does with settings, which are given by the numbers of the members.
type Advice = fn(&[(usize, Value)]) -> Vec<String>;

/// One variable of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its name with the instances that lead to it: `GAIN`, `DI_PUMP.GAIN`.
    pub name: String,
    /// A short text.
    pub description: String,
    /// Its PLC type.
    pub kind: Kind,
    /// Who sets it, and when. [`Role::is_settable`] says whether it is an input or a parameter.
    pub role: Role,
    /// Its value in a new block.
    pub start: Value,
    /// The lowest sensible value; not enforced by the block.
    pub min: Option<Value>,
    /// The highest sensible value; not enforced either.
    pub max: Option<Value>,
    /// Its physical unit; `None` for a TIME, too, which is in seconds.
    pub unit: Option<String>,
    /// Where the PLC has it.
    pub part: Part,
}

impl Member {
    /// A variable of the block itself, of the type of its start value, without text, range and unit.
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
            part: Part::Own,
        }
    }

    /// The unit in which people read its values: seconds of a duration, and its own else.
    pub fn shown_unit(&self) -> Option<&str> {
        self.kind.shown_unit(self.unit.as_deref())
    }
}

/// To what a variable belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// To the block itself: it has an address in the instance data block.
    Own,
    /// To a block inside it.
    Inner,
    /// To the FMU only; the PLC does not have it.
    FmuOnly,
}

impl Block {
    /// What the table of a block says.
    pub fn of<B: blocks::Block>() -> Block {
        let table = B::TABLE;
        let member = |(index, row): (usize, &Row)| Member {
            name: row.full_name(),
            description: row.description.to_string(),
            kind: row.kind,
            role: row.role,
            start: row.start,
            min: row.min,
            max: row.max,
            unit: row.unit.map(str::to_string),
            part: match () {
                () if table.mean == Some(index) => Part::FmuOnly,
                () if row.path[0].is_empty() => Part::Own,
                () => Part::Inner,
            },
        };
        Block {
            name: table.name.to_string(),
            aliases: table.aliases.iter().map(|alias| alias.to_string()).collect(),
            members: table.rows.iter().enumerate().map(member).collect(),
            advice: Some(advice::<B>),
        }
    }

    /// A block that is known by its description only. Nothing can be said of what it does with its settings.
    pub fn new(name: String, aliases: Vec<String>, members: Vec<Member>) -> Block {
        Block { name, aliases, members, advice: None }
    }

    /// All blocks of the crate `blocks`.
    pub fn all() -> Vec<Arc<Block>> {
        struct All(Vec<Arc<Block>>);
        impl EachBlock for All {
            fn block<B: blocks::Block>(&mut self) {
                self.0.push(Arc::new(Block::of::<B>()));
            }
        }
        let mut all = All(Vec::new());
        for_each_block(&mut all);
        all.0
    }

    /// Whether a PLC project calls the block so: by its name or an alias. Case, spaces and quotes do not count: `FB41`,
    /// `fb 41` and `"PUMP"`.
    pub fn is_called(&self, name: &str) -> bool {
        let plain = |name: &str| name.replace([' ', '\t', '"'], "").to_uppercase();
        let name = plain(name);
        std::iter::once(&self.name).chain(&self.aliases).any(|own| plain(own) == name)
    }

    /// The member with this full name, in any case.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|member| member.name.eq_ignore_ascii_case(name))
    }

    /// What the block will do with these settings where a user may not expect it: sentences with names and numbers. The
    /// others have their start values. Empty for a block that is known by its description only.
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

impl fmt::Debug for Block {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_struct("Block").field("name", &self.name).finish_non_exhaustive()
    }
}

impl PartialEq for Block {
    fn eq(&self, other: &Block) -> bool {
        (&self.name, &self.aliases, &self.members) == (&other.name, &other.aliases, &other.members)
    }
}
