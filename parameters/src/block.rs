//! The description of a block for parameter files: its names, its members and its advice on settings.

use blocks::{EachBlock, Row, Table, Value, for_each_block};
use std::fmt;
use std::sync::Arc;

/// A block type, as parameter files see it.
#[derive(Clone)]
pub struct BlockType {
    /// Its name, such as `PUMP`.
    pub name: String,
    /// Other names by which a PLC project may call it, such as `FB 41`.
    pub aliases: Vec<String>,
    /// Its variables, in the order of the instance data block; then those of inner blocks, with full names; then those
    /// that exist only in the FMU.
    pub members: Vec<Row>,
    /// The index of the member that exists only in the FMU, the mean of the pulse; `None` if the block has no pulse.
    pub mean: Option<usize>,
    advice: Option<Advice>,
}

/// A function that advises on settings, given as member indices and values.
type Advice = fn(&[(usize, Value)]) -> Vec<String>;

impl BlockType {
    /// The description of a block, built from its table.
    pub fn for_block<B: blocks::Block>() -> BlockType {
        BlockType { advice: Some(advice::<B>), ..BlockType::from(&Table::from(B::TABLE)) }
    }

    /// A block known only by its description: no advice on its settings is available.
    pub fn new(name: String, aliases: Vec<String>, members: Vec<Row>) -> BlockType {
        BlockType { name, aliases, members, mean: None, advice: None }
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

    /// Whether `name` refers to the block in a PLC project: its name or an alias, ignoring case, spaces and quotes,
    /// such as `FB41`, `fb 41` and `"PUMP"`.
    pub fn is_called(&self, name: &str) -> bool {
        let plain = |name: &str| name.replace([' ', '\t', '"'], "").to_uppercase();
        let name = plain(name);
        std::iter::once(&self.name).chain(&self.aliases).any(|own| plain(own) == name)
    }

    /// Whether a member has an address in the instance data block: members of inner blocks have none, and the mean does
    /// not exist in the PLC.
    pub fn is_own(&self, member: usize) -> bool {
        self.mean != Some(member) && !self.members[member].is_inner()
    }

    /// The index of the member with this full name, ignoring case.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|member| member.name.eq_ignore_ascii_case(name))
    }

    /// Advice on unexpected effects of these settings, and the error that the block's own check finds in them, if any:
    /// one sentence each. All other settings keep their start values. Empty for a block known only by its description.
    pub fn advice(&self, settings: &[(usize, Value)]) -> Vec<String> {
        self.advice.map_or_else(Vec::new, |advice| advice(settings))
    }
}

impl From<&Table> for BlockType {
    fn from(table: &Table) -> BlockType {
        let new = BlockType::new(table.name.clone(), table.aliases.clone(), table.rows.clone());
        BlockType { mean: table.mean, ..new }
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
        (&self.name, &self.aliases, &self.members, self.mean)
            == (&other.name, &other.aliases, &other.members, other.mean)
    }
}
