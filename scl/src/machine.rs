//! Runs a typed program.
//!
//! A [`Program`] is compiled to [`Code`] once; each [`Machine`] has a memory of its own. A call allocates nothing.
//!
//! [`Program`]: crate::program::Program

mod code;
mod compile;
mod run;

pub use code::Code;

use crate::program::{At, Scalar, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

/// A program with its memory.
#[derive(Clone)]
pub struct Machine {
    code: Arc<Code>,
    /// The memory of the program, constants, and the frames of functions.
    memory: Vec<u8>,
    /// The memory of the program before the call.
    before: Vec<u8>,
    registers: Box<[u64]>,
    /// Where calls return to.
    returns: Vec<u32>,
    /// What a block is stored in.
    room: Vec<u8>,
    /// Which runs of statements were run.
    covered: Vec<bool>,
    /// The instructions that have warned.
    warned: BTreeSet<u32>,
    warnings: Vec<Warning>,
    /// The locals of functions, if they are kept.
    kept: Option<Kept>,
    /// The most statements in a call.
    pub budget: u32,
}

/// The numbers among the locals of functions at the end of their last call, by the function and the address of its instance.
type Kept = BTreeMap<(usize, u64), Vec<u64>>;

/// Something that a PLC goes on with; told once for each place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The name of the file.
    pub file: String,
    /// The line in it.
    pub line: u32,
    /// What happened, in one sentence.
    pub message: String,
}

/// Why a call ended before its end. The memory is as it was before the call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stop {
    /// The name of the file.
    pub file: String,
    /// The line in it.
    pub line: u32,
    /// What happened.
    pub cause: Cause,
}

/// Why a program stops.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// An index outside of its array.
    Index {
        /// The index.
        index: i64,
        /// The lowest one.
        low: i64,
        /// The highest one.
        high: i64,
    },
    /// More statements than the budget allows.
    Budget(u32),
    /// A loop with the step 0.
    Step,
    /// An instance whose bytes are no state of its block.
    Instance,
}

impl fmt::Display for Stop {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}: ", self.file, self.line)?;
        match &self.cause {
            Cause::Index { index, low, high } => write!(formatter, "index {index} is outside of {low}..{high}"),
            Cause::Budget(budget) => write!(
                formatter,
                "the call has run {budget} statements and is stopped; if this loop does end, give the program a larger budget"
            ),
            Cause::Step => formatter.write_str("the loop has the step 0 and would not end"),
            Cause::Instance => formatter.write_str("the saved state of a block inside the program is damaged"),
        }
    }
}

impl std::error::Error for Stop {}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}: {}", self.file, self.line, self.message)
    }
}

impl Machine {
    /// The most statements in a call, unless another [`Machine::budget`] is set.
    pub const BUDGET: u32 = 1_000_000;

    /// A machine with the start values of the program.
    pub fn new(code: Arc<Code>) -> Machine {
        Machine {
            memory: code.start.clone(),
            before: vec![0; code.state],
            registers: vec![0; code.registers].into(),
            returns: Vec::with_capacity(code.depth),
            room: Vec::with_capacity(code.natives.iter().map(|(_, size)| *size).max().unwrap_or(0)),
            covered: vec![false; code.runs.len()],
            warned: BTreeSet::new(),
            warnings: Vec::new(),
            kept: None,
            budget: Machine::BUDGET,
            code,
        }
    }

    /// Sets the memory to the start values.
    pub fn restart(&mut self) {
        self.memory.copy_from_slice(&self.code.start);
    }

    /// Calls a function that has neither parameters nor an instance, by its number, at a time in nanoseconds since the start.
    ///
    /// # Errors
    /// The program stops; its memory is as it was before.
    ///
    /// # Panics
    /// There is no such function.
    pub fn call(&mut self, function: usize, now: i64) -> Result<(), Stop> {
        assert!(self.code.callable[function], "function {function} has parameters or an instance");
        let state = self.code.state;
        self.before.copy_from_slice(&self.memory[..state]);
        let done = self.run(self.code.entries[function], now);
        if done.is_err() {
            self.memory[..state].copy_from_slice(&self.before);
        }
        done
    }

    /// All that the program keeps from call to call. Any bytes of this length can be written: what a type does not have,
    /// such as the 2 of a BOOL, counts as one of its values, or stops the next call of a block that is not written in SCL.
    pub fn state(&self) -> &[u8] {
        &self.memory[..self.code.state]
    }

    /// The same to be written.
    pub fn state_mut(&mut self) -> &mut [u8] {
        &mut self.memory[..self.code.state]
    }

    /// A number of the memory.
    ///
    /// # Panics
    /// It lies outside of the memory.
    pub fn get(&self, ty: Scalar, offset: usize) -> Value {
        Value::read(ty, &self.state()[offset..])
    }

    /// Writes a number of the memory.
    ///
    /// # Panics
    /// It lies outside of the memory.
    pub fn set(&mut self, value: Value, offset: usize) {
        value.write(&mut self.state_mut()[offset..]);
    }

    /// What a local of a function had when the last call was over, if it is a number. It counts for a function that runs once in a
    /// call and is called by no other but the first: what is called beside it has the same registers.
    pub fn local(&self, function: usize, local: usize, ty: Scalar) -> Option<Value> {
        let register = (*self.code.locals.get(function)?.get(local)?)?;
        Some(Value::new(ty, *self.registers.get(usize::from(register))?))
    }

    /// From now on the locals of all functions are kept when they return, which takes a little time.
    pub fn keep_locals(&mut self) {
        self.kept.get_or_insert_default();
    }

    /// What a local of a function had when it returned last since [`Machine::forget_coverage`], if it is a number: of a function
    /// block that of the instance at this address, else the address is 0. `None` if it has not returned.
    pub fn kept(&self, function: usize, instance: usize, local: usize) -> Option<u64> {
        self.kept.as_ref()?.get(&(function, instance as u64))?.get(local).copied()
    }

    /// The warnings since the last time that this was called.
    pub fn take_warnings(&mut self) -> Vec<Warning> {
        std::mem::take(&mut self.warnings)
    }

    /// The line of each statement of the program, and whether it has been run since [`Machine::forget_coverage`].
    pub fn coverage(&self) -> impl Iterator<Item = (At, bool)> {
        let of_run = |(&(first, count), &covered): (&(u32, u32), &bool)| {
            let statements = &self.code.statements[first as usize..(first + count) as usize];
            statements.iter().map(move |at| (*at, covered))
        };
        self.code.runs.iter().zip(&self.covered).flat_map(of_run)
    }

    /// No statement counts as run, and no local is kept.
    pub fn forget_coverage(&mut self) {
        self.kept.iter_mut().for_each(Kept::clear);
        self.covered.fill(false);
    }
}

#[cfg(test)]
pub(crate) mod tests;
