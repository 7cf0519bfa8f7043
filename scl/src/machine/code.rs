//! The target of compilation: instructions for a register machine.

use crate::ir::operations::{One, OneChecked, Three, Two, TwoChecked};
use crate::ir::{At, Binary, Scalar};
use std::collections::BTreeMap;

/// A register. A function's registers lie above those of all the functions it calls; functions that do not call each
/// other may share registers.
pub(crate) type Register = u16;

/// The index of an instruction.
pub(crate) type Target = u32;

/// The register that is always 0: the base of absolute addresses.
pub(crate) const ZERO: Register = 0;

/// An instruction. A register holds 64 bits ([`Scalar::of_bits`]) or a memory address.
#[derive(Clone, Copy)]
pub(crate) enum Op {
    /// Loads a constant.
    Const {
        to: Register,
        bits: u64,
    },
    /// Copies a register.
    Move {
        to: Register,
        from: Register,
    },
    /// Clears consecutive registers.
    Clear {
        from: Register,
        count: u16,
    },
    /// Loads a number from memory.
    Load {
        ty: Scalar,
        to: Register,
        base: Register,
        offset: u32,
    },
    /// Stores a number to memory.
    Store {
        ty: Scalar,
        from: Register,
        base: Register,
        offset: u32,
    },
    /// This and the next three: loads and stores of frequent types, specialized to avoid dispatch on the type.
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
    /// A unary operation.
    One {
        to: Register,
        a: Register,
        function: One,
    },
    /// A unary operation that may warn.
    OneChecked {
        to: Register,
        a: Register,
        function: OneChecked,
    },
    /// A binary operation.
    Two {
        to: Register,
        a: Register,
        b: Register,
        function: Two,
    },
    /// A binary operation that may warn.
    TwoChecked {
        to: Register,
        a: Register,
        b: Register,
        function: TwoChecked,
    },
    /// This and the next two: frequent operations, specialized to avoid a function call.
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
    /// An operation on three consecutive registers.
    Three {
        to: Register,
        first: Register,
        function: Three,
    },
    /// Selects from three consecutive registers: the second if the first is TRUE, else the third.
    Select {
        to: Register,
        first: Register,
    },
    /// Adds a constant offset to a base address.
    Address {
        to: Register,
        base: Register,
        offset: u32,
    },
    /// Computes the address of an array element, `base + (index - low) * stride`, after a bounds check.
    Index {
        to: Register,
        base: Register,
        index: Register,
        bounds: u32,
    },
    /// Applies the next index to the element number of an open array: `number * (high - low + 1) + (index - low)`,
    /// after a bounds check. The registers `bounds` and `bounds + 1` hold `low` and `high`.
    IndexOpen {
        number: Register,
        index: Register,
        bounds: Register,
    },
    /// Computes the address of an open array's element: `base + number * size`.
    Scale {
        to: Register,
        base: Register,
        number: Register,
        size: u32,
    },
    /// Copies the bytes of a variable.
    Copy {
        to: Register,
        from: Register,
        size: u32,
    },
    /// Copies start values from [`Code::images`] into a frame.
    Image {
        to: u32,
        from: u32,
        size: u32,
    },
    /// Copies a string, truncated to the capacity of the target.
    CopyText {
        to: Register,
        from: Register,
        to_capacity: u16,
        from_capacity: u16,
        wide: bool,
    },
    /// Compares two strings.
    CompareText {
        op: Binary,
        to: Register,
        a: Register,
        b: Register,
        capacities: (u16, u16),
        wide: bool,
    },
    /// Compares two variables part by part.
    Same {
        to: Register,
        a: Register,
        b: Register,
        parts: u32,
    },
    /// Loads the time of the call.
    Now {
        to: Register,
    },
    /// Jumps.
    Jump {
        to: Target,
    },
    /// Deducts 1 from the budget and jumps, or stops the call if the budget is exceeded: every backward jump, and GOTO.
    Back {
        to: Target,
    },
    /// Jumps if the register is TRUE.
    JumpIf {
        condition: Register,
        to: Target,
    },
    /// Jumps if the register is FALSE.
    JumpUnless {
        condition: Register,
        to: Target,
    },
    /// Jumps if the value lies within the range with this index in [`Code::ranges`].
    JumpInside {
        value: Register,
        range: u32,
        to: Target,
    },
    /// Jumps if a FOR loop has ended; `last` and the next register hold the last value and the step.
    ForTest {
        ty: Scalar,
        value: Register,
        last: Register,
        to: Target,
    },
    /// Advances a loop counter; the register after `value` is set to 1 if the counter overflows its type, else to 0.
    ForStep {
        ty: Scalar,
        value: Register,
        step: Register,
    },
    /// Marks a run of `count` statements as executed and deducts them from the budget.
    Mark {
        run: u32,
        count: u32,
    },
    /// Calls a function, or stops the call of the program if the budget is exceeded.
    Call {
        to: Target,
    },
    /// Returns from a function.
    Return,
    /// Runs a block's law on the instance whose address is in the register.
    Native {
        law: u16,
        instance: Register,
    },
}

impl Op {
    /// The instruction that loads a number from memory.
    pub(crate) fn load(ty: Scalar, to: Register, base: Register, offset: u32) -> Op {
        match ty {
            Scalar::Bool => Op::LoadBool { to, base, offset },
            Scalar::F32 | Scalar::U32 => Op::Load32 { to, base, offset },
            _ => Op::Load { ty, to, base, offset },
        }
    }

    /// The instruction that stores a number to memory.
    pub(crate) fn store(ty: Scalar, from: Register, base: Register, offset: u32) -> Op {
        match ty.size() {
            1 => Op::Store8 { from, base, offset },
            4 => Op::Store32 { from, base, offset },
            _ => Op::Store { ty, from, base, offset },
        }
    }
}

/// The bounds of an array index, and the distance in bytes between elements whose index differs by 1.
pub(crate) struct Bounds {
    pub low: i64,
    pub high: i64,
    pub stride: u64,
}

/// A part of a structure to compare: consecutive numbers, or a string.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Part {
    Numbers { ty: Scalar, offset: u32, count: u32 },
    Text { offset: u32, capacity: u16, wide: bool },
}

/// Runs a block's law on the bytes of an instance; returns `false` if the bytes are not a valid state of the block. The
/// vector is a reusable buffer.
pub(crate) type Native = fn(&mut [u8], &mut Vec<u8>) -> bool;

/// A compiled program, which any number of machines can run.
#[derive(Default)]
pub struct Code {
    pub(crate) ops: Vec<Op>,
    /// The source file and line of each instruction.
    pub(crate) lines: Vec<At>,
    /// The messages of possible warnings, by instruction.
    pub(crate) warnings: BTreeMap<Target, String>,
    /// The first instruction of each function.
    pub(crate) entries: Vec<Target>,
    /// Whether each function can be called from outside: it has neither parameters nor an instance.
    pub(crate) callable: Vec<bool>,
    pub(crate) files: Vec<String>,
    pub(crate) bounds: Vec<Bounds>,
    pub(crate) ranges: Vec<(i64, i64)>,
    pub(crate) parts: Vec<Vec<Part>>,
    /// The laws of blocks, each with the size of an instance.
    pub(crate) natives: Vec<(Native, usize)>,
    /// The start values for frames.
    pub(crate) images: Vec<u8>,
    /// The initial memory: the program's own memory, constants and frames.
    pub(crate) start: Vec<u8>,
    /// The size of the program's own memory, in bytes.
    pub(crate) state: usize,
    pub(crate) registers: usize,
    /// The register of each local, by function; `None` for a local that is not a number or is passed by reference.
    pub(crate) locals: Vec<Vec<Option<Register>>>,
    /// The register with the instance address, for each function that has an instance.
    pub(crate) instances: Vec<Option<Register>>,
    /// The functions in instruction order, each with its first instruction.
    pub(crate) owners: Vec<(Target, usize)>,
    /// The maximum depth of nested calls in the program.
    pub(crate) depth: usize,
    /// The source file and line of each statement.
    pub(crate) statements: Vec<At>,
    /// The runs of statements that are always executed together: first statement and count.
    pub(crate) runs: Vec<(u32, u32)>,
}
