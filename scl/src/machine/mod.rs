//! Runs programs. A typed [`Program`] is compiled once to [`Code`], which any number of [`Machine`]s can run, each with
//! its own memory. A call allocates nothing.
//!
//! [`Program`]: crate::ir::Program

mod code;
mod compile;
mod run;

pub use code::Code;

use crate::ir::{At, Scalar, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

/// A program and its memory.
#[derive(Clone)]
pub struct Machine {
    code: Arc<Code>,
    /// The program's memory, then constants and function frames.
    memory: Vec<u8>,
    /// A copy of the program's memory from before the call.
    before: Vec<u8>,
    registers: Box<[u64]>,
    /// The stack of return addresses.
    returns: Vec<u32>,
    /// A reusable buffer for the state of a block that is not written in SCL.
    room: Vec<u8>,
    /// For each run of statements, whether it has been executed.
    covered: Vec<bool>,
    /// The instructions whose warning has already been issued.
    warned: BTreeSet<u32>,
    warnings: Vec<Warning>,
    /// The kept locals of functions; `None` before [`Machine::keep_locals`].
    kept: Option<Kept>,
    /// The statement budget: the maximum number of statements executed in a call. Each jump back counts as one more.
    pub budget: u32,
}

/// The locals at the last return of a function (0 if not numeric), by function and instance address.
type Kept = BTreeMap<(usize, u64), Vec<u64>>;

/// An irregularity that a PLC tolerates; reported once per source location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The name of the source file.
    pub file: String,
    /// The line in the file.
    pub line: u32,
    /// A one-sentence description.
    pub message: String,
}

/// Where and why a call was aborted. Memory is left as it was before the call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stop {
    /// The name of the source file.
    pub file: String,
    /// The line in the file.
    pub line: u32,
    /// The cause.
    pub cause: Cause,
}

/// Why a call was aborted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// An index out of bounds.
    Index {
        /// The index.
        index: i64,
        /// The lower bound.
        low: i64,
        /// The upper bound.
        high: i64,
    },
    /// The call exceeded this statement budget.
    Budget(u32),
    /// A FOR loop with step 0.
    Step,
    /// The bytes of an instance are not a valid state of its block.
    Instance,
}

impl fmt::Display for Stop {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}: ", self.file, self.line)?;
        match &self.cause {
            Cause::Index { index, low, high } => write!(formatter, "index {index} is outside {low}..{high}"),
            Cause::Budget(budget) => write!(
                formatter,
                "the call was stopped after {budget} statements; if this loop does end, increase the budget"
            ),
            Cause::Step => formatter.write_str("the loop has step 0 and would never end"),
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
    /// The default statement budget of a call (see [`Machine::budget`]).
    pub const BUDGET: u32 = 1_000_000;

    /// Creates a machine with the program's start values in memory.
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

    /// Resets memory to the start values.
    pub fn restart(&mut self) {
        self.memory.copy_from_slice(&self.code.start);
    }

    /// Calls a function that takes no parameters and no instance, at time `now` in nanoseconds since the start.
    ///
    /// # Errors
    /// The call was aborted; memory is as it was before the call.
    ///
    /// # Panics
    /// The function does not exist, or it has parameters or an instance.
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

    /// The state that the program keeps between calls. Any bytes of this length may be written to it: a value that is
    /// invalid for its type, such as 2 for a BOOL, is read as a valid one; in the instance of a block that is not
    /// written in SCL, it may instead abort the next call of that block ([`Cause::Instance`]).
    pub fn state(&self) -> &[u8] {
        &self.memory[..self.code.state]
    }

    /// The state as mutable bytes, see [`Machine::state`].
    pub fn state_mut(&mut self) -> &mut [u8] {
        &mut self.memory[..self.code.state]
    }

    /// Reads the number at this offset in the program's memory.
    ///
    /// # Panics
    /// The number extends beyond the program's memory.
    pub fn get(&self, ty: Scalar, offset: usize) -> Value {
        Value::read(ty, &self.state()[offset..])
    }

    /// Writes a number at this offset in the program's memory.
    ///
    /// # Panics
    /// The number extends beyond the program's memory.
    pub fn set(&mut self, value: Value, offset: usize) {
        value.write(&mut self.state_mut()[offset..]);
    }

    /// The value of a numeric local at the end of the last call; `None` if the local does not exist or is not numeric.
    /// Meaningful only for a function that runs once per call and is called only by the entry function, because other
    /// functions share registers.
    pub fn local(&self, function: usize, local: usize, ty: Scalar) -> Option<Value> {
        let register = (*self.code.locals.get(function)?.get(local)?)?;
        Some(Value::new(ty, *self.registers.get(usize::from(register))?))
    }

    /// From now on, keeps the numeric locals of every function when it returns; this slows each return slightly.
    pub fn keep_locals(&mut self) {
        self.kept.get_or_insert_default();
    }

    /// The bits of a numeric local when its function last returned, for the instance at this address (0 if the function
    /// has no instance). `None` if the function has not returned since [`Machine::forget_coverage`], or if locals are
    /// not kept ([`Machine::keep_locals`]).
    pub fn kept(&self, function: usize, instance: usize, local: usize) -> Option<u64> {
        self.kept.as_ref()?.get(&(function, instance as u64))?.get(local).copied()
    }

    /// Returns and clears the warnings.
    pub fn take_warnings(&mut self) -> Vec<Warning> {
        std::mem::take(&mut self.warnings)
    }

    /// The source line of each statement, and whether it has been executed since [`Machine::forget_coverage`].
    pub fn coverage(&self) -> impl Iterator<Item = (At, bool)> {
        let of_run = |(&(first, count), &covered): (&(u32, u32), &bool)| {
            let statements = &self.code.statements[first as usize..(first + count) as usize];
            statements.iter().map(move |at| (*at, covered))
        };
        self.code.runs.iter().zip(&self.covered).flat_map(of_run)
    }

    /// Marks all statements as not executed, and discards the kept locals.
    pub fn forget_coverage(&mut self) {
        self.kept.iter_mut().for_each(Kept::clear);
        self.covered.fill(false);
    }
}

#[cfg(test)]
pub(crate) mod tests;
