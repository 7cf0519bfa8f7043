//! The internals of a program, for tools that show them while it runs.

use crate::{Loaded, Program};
use scl::Note;
use scl::ir::{At, Body, Type, Value, What};
use std::collections::HashSet;

/// The maximum number of instances listed.
const MOST: usize = 2000;

/// An instance of a block inside a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InnerInstance {
    /// Its path, as in the names of its variables in the table: `motors[1]`; empty for the program itself.
    pub path: String,
    /// The name of its block.
    pub block: String,
    /// Whether it is a built-in block from [`blocks`] rather than one written in SCL.
    pub is_native: bool,
    /// Its address in memory.
    address: usize,
}

impl Loaded {
    /// The name of the block that runs: a function block, or the first organization block.
    pub fn block(&self) -> &str {
        &self.block
    }

    /// The block instances, starting with the program itself. Inner instances follow the one that contains them.
    pub fn parts(&self) -> Vec<InnerInstance> {
        let own = InnerInstance { path: String::new(), block: self.block.clone(), is_native: false, address: 0 };
        let mut found = vec![own];
        let memory = self.program.memory;
        for member in &self.program.records[memory].members {
            // Variables of this instance are named without the instance name.
            let is_own = !self.instance.is_empty() && member.name.eq_ignore_ascii_case(&self.instance);
            if let (true, Type::Record(record)) = (is_own, &member.ty) {
                found[0].address = member.offset;
                self.inside(*record, "", member.offset, &mut found);
            } else {
                self.add(&member.ty, &member.name, member.offset, &mut found);
            }
        }
        found
    }

    fn inside(&self, record: usize, path: &str, address: usize, found: &mut Vec<InnerInstance>) {
        for member in &self.program.records[record].members {
            let path = if path.is_empty() { member.name.clone() } else { format!("{path}.{}", member.name) };
            self.add(&member.ty, &path, address + member.offset, found);
        }
    }

    fn add(&self, ty: &Type, path: &str, address: usize, found: &mut Vec<InnerInstance>) {
        if found.len() >= MOST {
            return;
        }
        match ty {
            Type::Record(record) => {
                let function = self.program.functions.iter().find(|function| function.instance == Some(*record));
                if let Some(function) = function {
                    let (block, is_native) = match function.body {
                        Body::Native(name) => (name.to_string(), true),
                        Body::Code(_) => (function.name.clone(), false),
                    };
                    found.push(InnerInstance { path: path.to_string(), block, is_native, address });
                }
                self.inside(*record, path, address, found);
            }
            Type::Array { of, bounds } if matches!(**of, Type::Record(_)) => {
                if let [(low, high)] = bounds.as_slice() {
                    let size = self.program.size(of);
                    for (number, index) in (*low..=*high).enumerate() {
                        self.add(of, &format!("{path}[{index}]"), address + number * size, found);
                    }
                }
            }
            _ => {}
        }
    }

    /// The function that each cycle calls, if it is the only one.
    fn body(&self) -> Option<usize> {
        match &self.program.functions[self.cycle].body {
            Body::Code(code) => match code.as_slice() {
                [only] => match &only.what {
                    What::Call(call) => Some(call.function),
                    _ => None,
                },
                _ => None,
            },
            Body::Native(_) => None,
        }
    }
}

impl Program {
    /// The same program, which then also records what [`Program::wires`], [`Program::lines`] and [`Program::temps`]
    /// return; this makes each call a little slower.
    #[must_use]
    pub fn watched(mut self) -> Program {
        self.is_watched = true;
        self.machine.keep_locals();
        self
    }

    /// The truth values of a block's networks and conditions as calculated by the last call, in the instance at this
    /// path (ignored for functions). Each comes with the number of its expression in the source; values that were not
    /// calculated are omitted.
    pub fn wires(&self, block: &str, path: &str) -> Vec<(u32, bool)> {
        let parts = self.loaded.parts();
        let part = parts.iter().find(|part| part.path == path && part.block.eq_ignore_ascii_case(block));
        let functions = &self.loaded.program.functions;
        let value = |note: &Note| {
            let function = &functions[note.function];
            if !function.name.eq_ignore_ascii_case(block) {
                return None;
            }
            let address = if function.instance.is_some() { part?.address } else { 0 };
            let kept = self.machine.kept(note.function, address, note.local)?;
            // 0 means not calculated.
            (kept > 0).then_some((note.expression, kept == u64::from(Note::TRUE)))
        };
        self.loaded.notes.iter().filter_map(value).collect()
    }

    /// The statements in the user's sources that the last call executed, as sorted pairs of file index and line number.
    pub fn lines(&self) -> Vec<(usize, u32)> {
        let is_own = |at: &At| at.line > 0 && usize::from(at.file) + 1 < self.loaded.program.files.len();
        let run = self.machine.coverage().filter(|(at, is_run)| *is_run && is_own(at));
        let mut lines: Vec<(usize, u32)> = run.map(|(at, _)| (usize::from(at.file), at.line)).collect();
        lines.sort_unstable();
        lines.dedup();
        lines
    }

    /// The temporary variables (numbers and truth values) of the block that runs, with their values at the end of the
    /// last call.
    pub fn temps(&self) -> Vec<(&str, Value)> {
        let Some(body) = self.loaded.body() else { return Vec::new() };
        // Locals that record truth values are not the author's temporaries.
        let notes = self.loaded.notes.iter().filter(|note| note.function == body);
        let notes: HashSet<usize> = notes.map(|note| note.local).collect();
        let locals = self.loaded.program.functions[body].locals.iter().enumerate();
        locals
            .filter_map(|(place, local)| match local.ty {
                Type::Scalar(ty) if !notes.contains(&place) => {
                    Some((local.name.as_str(), self.machine.local(body, place, ty)?))
                }
                _ => None,
            })
            .collect()
    }
}
