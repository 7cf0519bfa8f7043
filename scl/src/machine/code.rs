//! What a typed program is compiled to: instructions for registers.

use crate::program::operations::{One, OneChecked, Three, Two, TwoChecked};
use crate::program::{At, Binary, Scalar};
use std::collections::BTreeMap;

/// The number of a register: every function has its own ones, above those of all functions that it calls.
pub(crate) type Register = u16;

/// The place of an instruction.
pub(crate) type Target = u32;

/// The register that is always 0: the base of absolute addresses.
pub(crate) const ZERO: Register = 0;

/// An instruction. Registers hold 64 bits ([`Scalar::of_bits`]) or an address in the memory.
#[derive(Clone, Copy)]
pub(crate) enum Op {
    /// A constant.
    Const {
        to: Register,
        bits: u64,
    },
    /// A copy of a register.
    Move {
        to: Register,
        from: Register,
    },
    /// Registers, from this one on, to 0.
    Clear {
        from: Register,
        count: u16,
    },
    /// A number from the memory.
    Load {
        ty: Scalar,
        to: Register,
        base: Register,
        offset: u32,
    },
    /// A number to the memory.
    Store {
        ty: Scalar,
        from: Register,
        base: Register,
        offset: u32,
    },
    /// The same for frequent types, without a look at the type.
    LoadBool {
        to: Register,
        base: Register,
        offset: u32,
    },
    Load32 {
        to: Register,
        base: Register,
        offset: u32,
    },
    Store8 {
        from: Register,
        base: Register,
        offset: u32,
    },
    Store32 {
        from: Register,
        base: Register,
        offset: u32,
    },
    /// An operation on one number.
    One {
        to: Register,
        a: Register,
        function: One,
    },
    /// The same with a warning.
    OneChecked {
        to: Register,
        a: Register,
        function: OneChecked,
    },
    /// An operation on two numbers.
    Two {
        to: Register,
        a: Register,
        b: Register,
        function: Two,
    },
    /// The same with a warning.
    TwoChecked {
        to: Register,
        a: Register,
        b: Register,
        function: TwoChecked,
    },
    /// Frequent operations, without a call of a function.
    AddF32 {
        to: Register,
        a: Register,
        b: Register,
    },
    SubF32 {
        to: Register,
        a: Register,
        b: Register,
    },
    MulF32 {
        to: Register,
        a: Register,
        b: Register,
    },
    /// An operation on the numbers in three registers, from this one on.
    Three {
        to: Register,
        first: Register,
        function: Three,
    },
    /// The second register behind `first` if the first one is TRUE, else the third.
    Select {
        to: Register,
        first: Register,
    },
    /// An address: a constant behind another.
    Address {
        to: Register,
        base: Register,
        offset: u32,
    },
    /// The address of an element: `base + (index - low) * stride`, if the bounds allow it.
    Index {
        to: Register,
        base: Register,
        index: Register,
        bounds: u32,
    },
    /// `number * extent + (index - low)` for the bounds in the registers `bounds` and the next one, if they allow it.
    IndexOpen {
        number: Register,
        index: Register,
        bounds: Register,
    },
    /// `base + number * size`.
    Scale {
        to: Register,
        base: Register,
        number: Register,
        size: u32,
    },
    /// Bytes of a variable to another.
    Copy {
        to: Register,
        from: Register,
        size: u32,
    },
    /// The start values of a frame to the memory.
    Image {
        to: u32,
        from: u32,
        size: u32,
    },
    /// A text, cut to the capacity.
    CopyText {
        to: Register,
        from: Register,
        to_capacity: u16,
        from_capacity: u16,
        wide: bool,
    },
    /// A comparison of texts.
    CompareText {
        op: Binary,
        to: Register,
        a: Register,
        b: Register,
        capacities: (u16, u16),
        wide: bool,
    },
    /// A comparison of variables, by a list of their parts.
    Same {
        to: Register,
        a: Register,
        b: Register,
        parts: u32,
    },
    /// The time of the call.
    Now {
        to: Register,
    },
    /// On to an instruction.
    Jump {
        to: Target,
    },
    /// Back to an earlier instruction, if the budget allows it.
    Back {
        to: Target,
    },
    /// On if the register is TRUE.
    JumpIf {
        condition: Register,
        to: Target,
    },
    /// On if the register is FALSE.
    JumpUnless {
        condition: Register,
        to: Target,
    },
    /// On if the register is within the range of this number.
    JumpInside {
        value: Register,
        range: u32,
        to: Target,
    },
    /// On if a loop has ended; `last` and the next register hold the last value and the step.
    ForTest {
        ty: Scalar,
        value: Register,
        last: Register,
        to: Target,
    },
    /// The next value of a loop; the register behind it becomes TRUE if it lies beyond the type.
    ForStep {
        ty: Scalar,
        value: Register,
        step: Register,
    },
    /// This many statements begin here.
    Mark {
        run: u32,
        count: u32,
    },
    /// A call of a function, if the budget allows it.
    Call {
        to: Target,
    },
    /// The end of a function.
    Return,
    /// A call of a block with its instance at an address.
    Native {
        law: u16,
        instance: Register,
    },
}

impl Op {
    /// Reads a number from the memory.
    pub(crate) fn load(ty: Scalar, to: Register, base: Register, offset: u32) -> Op {
        match ty {
            Scalar::Bool => Op::LoadBool { to, base, offset },
            Scalar::F32 | Scalar::U32 => Op::Load32 { to, base, offset },
            _ => Op::Load { ty, to, base, offset },
        }
    }

    /// Writes a number to the memory.
    pub(crate) fn store(ty: Scalar, from: Register, base: Register, offset: u32) -> Op {
        match ty.size() {
            1 => Op::Store8 { from, base, offset },
            4 => Op::Store32 { from, base, offset },
            _ => Op::Store { ty, from, base, offset },
        }
    }
}

/// The bounds of an index, and how far its elements lie apart.
pub(crate) struct Bounds {
    pub low: i64,
    pub high: i64,
    pub stride: u64,
}

/// A stretch of equal numbers, or a text, in a structure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Part {
    Numbers { ty: Scalar, offset: u32, count: u32 },
    Text { offset: u32, capacity: u16, wide: bool },
}

/// The law of a block: the bytes of an instance, and room for writing it. `false` if the bytes do not belong to the block.
pub(crate) type Native = fn(&mut [u8], &mut Vec<u8>) -> bool;

/// A compiled program. Many machines can run it.
#[derive(Default)]
pub struct Code {
    pub(crate) ops: Vec<Op>,
    /// The line of each instruction.
    pub(crate) lines: Vec<At>,
    /// What the instructions that may warn say.
    pub(crate) warnings: BTreeMap<Target, String>,
    /// The first instruction of each function.
    pub(crate) entries: Vec<Target>,
    /// Which functions can be called from outside: those without parameters and instance.
    pub(crate) callable: Vec<bool>,
    pub(crate) files: Vec<String>,
    pub(crate) bounds: Vec<Bounds>,
    pub(crate) ranges: Vec<(i64, i64)>,
    pub(crate) parts: Vec<Vec<Part>>,
    /// The laws of blocks, with the size of an instance.
    pub(crate) natives: Vec<(Native, usize)>,
    /// The start values of frames.
    pub(crate) images: Vec<u8>,
    /// Memory, constants and frames at the start.
    pub(crate) start: Vec<u8>,
    /// How much of it is the memory of the program.
    pub(crate) state: usize,
    pub(crate) registers: usize,
    /// The registers of the numbers among the locals of each function.
    pub(crate) locals: Vec<Vec<Option<Register>>>,
    /// The register with the address of the instance, of each function that works on one.
    pub(crate) instances: Vec<Option<Register>>,
    /// The functions with code in the order of their instructions, each with its first one.
    pub(crate) owners: Vec<(Target, usize)>,
    /// The most calls inside one another.
    pub(crate) depth: usize,
    /// The lines of the statements.
    pub(crate) statements: Vec<At>,
    /// Of each run of statements, the first one and their count.
    pub(crate) runs: Vec<(u32, u32)>,
}
