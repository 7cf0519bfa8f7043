//! PLC control blocks in plain Rust, faithful to the last bit of a 32-bit REAL.
//!
//! A block is a struct with its inputs, parameters and outputs as public fields; [`Law::call`] is one call of a cyclic
//! interrupt. Nothing here depends on how a block is packaged: it can be used in any Rust program.
//!
//! ```
//! use blocks::{ContC, Law};
//!
//! let mut controller = ContC { man_on: false, sp_int: 1.0, ..ContC::default() };
//! controller.restart();
//! controller.call();
//! assert_eq!(controller.lmn, 2.05);
//! ```
//!
//! The documentation of each block states its law, clause by clause, and the source of each rule: *manual* (the
//! vendor's published manual), *vendor* (later vendor texts on the same or related blocks), *measured* (recorded at the
//! terminals of a real block), *observed* (published descriptions of how the blocks behave), *decided* (by us, where
//! all of these are silent).

/// Exports the listed blocks from a vendor's module, and defines the module's `for_each_block`.
macro_rules! vendor {
    ($($block:ident::$Block:ident),* $(,)?) => {
        $(pub use $block::$Block;)*

        pub(crate) fn for_each_block(what: &mut impl crate::EachBlock) {
            $(what.block::<$Block>();)*
        }
    };
}

mod abb;
mod siemens;
pub mod table;

pub use table::{
    Block, Bool, Characteristic, Class, Form, Int, Kind, LReal, Law, Real, Response, Role, Row, StaticRow, StaticTable,
    Stored, Table, TableText, Text, TextType, Time, Types, Value, Word, low_word, rnd,
};

/// A hash of the sources of this crate; `None` in a copy without the build script.
pub const CODE: Option<&str> = option_env!("PLCFMU_CODE");

/// An operation on each block, for [`for_each_block`].
pub trait EachBlock {
    /// Performs the operation on one block.
    fn block<B: Block>(&mut self);
}

pub use abb::*;
pub use siemens::*;

/// Calls `what` for every block of this crate, for example to collect their tables:
///
/// ```
/// use blocks::{Block, EachBlock, StaticTable, for_each_block};
///
/// struct Tables(Vec<&'static StaticTable>);
///
/// impl EachBlock for Tables {
///     fn block<B: Block>(&mut self) {
///         self.0.push(B::TABLE);
///     }
/// }
///
/// let mut tables = Tables(Vec::new());
/// for_each_block(&mut tables);
/// assert!(tables.0.iter().any(|table| table.name == "CONT_C"));
/// ```
pub fn for_each_block(what: &mut impl EachBlock) {
    siemens::for_each_block(what);
    abb::for_each_block(what);
}

/// Calls `what` for every block of this crate that runs faster [in lanes](table::abreast).
pub fn for_each_in_lanes(what: &mut impl table::abreast::EachInLanes) {
    what.block::<ContC>();
}
