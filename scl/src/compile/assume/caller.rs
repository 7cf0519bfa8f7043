//! The organization block assumed for a library of blocks that nothing in the sources calls.

use super::{Assumption, quoted, section, way};
use crate::check::compiler::Compiler;
use crate::check::types::Type;
use crate::front::syntax::{BlockKind, key};
use crate::ladder::Way;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The name that TIA Portal gives to the first organization block.
const MAIN: &str = "Main";

/// The declarations and statements of an organization block.
#[derive(Default)]
struct Calls {
    globals: String,
    statements: String,
    names: BTreeSet<String>,
}

impl Compiler<'_> {
    /// An organization block that calls, once per cycle, each block not called by any other, with a tag for each
    /// parameter. `None` if the user has specified the blocks to call, or if the sources have an organization block
    /// other than startup or exactly one function block that no other block calls.
    pub fn caller(&self) -> Option<Assumption> {
        let is_asked = self.options.block.is_none() && self.options.calls.is_empty();
        if !is_asked || self.organization_blocks().any(|block| !self.is_startup(block)) {
            return None;
        }
        let (unread, blocks): (Vec<usize>, Vec<usize>) = self.unused().partition(|block| self.has_error(*block));
        if blocks.len() == 1 && unread.is_empty() {
            return None;
        }
        let functions: Vec<usize> =
            self.uncalled(BlockKind::Function).filter(|block| !self.has_error(*block)).collect();
        let mut calls = Calls::default();
        let called: Vec<usize> =
            blocks.into_iter().chain(functions).filter(|block| self.add_call(*block, &mut calls).is_some()).collect();
        let (file, index) = self.blocks[*called.first()?].source?;
        let name = self.free(MAIN, &mut calls);
        let text = format!(
            "{}ORGANIZATION_BLOCK \"{name}\"\nBEGIN\n{}END_ORGANIZATION_BLOCK\n",
            section("VAR_GLOBAL", &calls.globals),
            calls.statements
        );
        let what = format!(
            "an organization block that calls each block not called by any other ({}), with a tag for each parameter",
            called.len()
        );
        Some(Assumption { name, what, at: (file as u32, self.block((file, index)).name.span.start), text })
    }

    fn has_error(&self, block: usize) -> bool {
        let extent = self.blocks[block].source.map(|(file, index)| self.trees[file].extents[index]);
        extent.is_some_and(|extent| self.report.first_error(extent).is_some())
    }

    /// Adds a call to a block. `None` if the type of a required argument cannot be written in a declaration.
    fn add_call(&self, block: usize, calls: &mut Calls) -> Option<()> {
        let interface = &self.blocks[block];
        let is_function = interface.kind == BlockKind::Function;
        let mut tags = String::new();
        let mut arguments = Vec::new();
        for parameter in &interface.members {
            let Some(way) = way(parameter.section) else { continue };
            let Some(of) = self.written(&parameter.of) else {
                // A function needs all arguments; a function block falls back on the start value.
                if is_function || way == Way::InOut {
                    return None;
                }
                continue;
            };
            let tag = self.free(&format!("{}_{}", interface.name, parameter.name), calls);
            let _ = writeln!(tags, "   \"{tag}\" : {of};");
            let assign = if way == Way::Output { "=>" } else { ":=" };
            arguments.push(format!("{} {assign} \"{tag}\"", quoted(&parameter.name)));
        }
        let mut called = format!("\"{}\"", interface.name);
        if !is_function {
            let name = match self.only_instance(block) {
                Some(name) => name,
                None => {
                    let name = self.free(&format!("{}_DB", interface.name), calls);
                    let _ = writeln!(tags, "   \"{name}\" : \"{}\";", interface.name);
                    name
                }
            };
            called = format!("\"{name}\"");
        } else if interface.result != Type::Void {
            let of = self.written(&interface.result)?;
            let tag = self.free(&format!("{}_value", interface.name), calls);
            let _ = writeln!(tags, "   \"{tag}\" : {of};");
            called = format!("\"{tag}\" := {called}");
        }
        calls.globals.push_str(&tags);
        let _ = writeln!(calls.statements, "   {called}({});", arguments.join(", "));
        Some(())
    }

    /// A name not yet in use: `name`, with a number appended if it is taken.
    fn free(&self, name: &str, calls: &mut Calls) -> String {
        let is_taken = |name: &String| {
            self.names.contains_key(&key(name))
                || self.global_members.contains_key(&key(name))
                || self.declared.contains_key(&key(name))
                || calls.names.contains(&key(name))
        };
        let mut names = std::iter::once(name.to_string()).chain((2..).map(|number| format!("{name}_{number}")));
        let free = names.find(|name| !is_taken(name)).unwrap_or_default();
        calls.names.insert(key(&free));
        free
    }
}
