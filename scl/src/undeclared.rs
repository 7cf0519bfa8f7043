//! Names that no source declares.

use crate::compiler::Compiler;
use crate::lexer::Span;
use crate::syntax::key;
use crate::types::Elementary;
use parameters::Remedy;
use std::collections::BTreeSet;

/// What is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A PLC tag, a constant or a data block.
    Variable,
    /// A constant: only one can stand where it is used.
    Constant,
    /// A type.
    Type,
    /// A function.
    Function,
    /// A function block.
    Block,
    /// An instance.
    Instance,
}

/// A name that no source declares.
#[derive(Clone, Debug)]
pub struct Undeclared {
    /// Its first spelling.
    pub name: String,
    /// Where first.
    pub span: Span,
    /// What it is by its use.
    pub what: What,
    /// What of it is used.
    pub members: BTreeSet<String>,
    /// Its type, where its surroundings tell.
    pub of: Option<Elementary>,
}

impl Compiler<'_> {
    /// Keeps a name that is missing, for one message.
    pub fn miss(&mut self, name: &str, span: Span, what: What) {
        let new = Undeclared { name: name.to_string(), span, what, members: BTreeSet::new(), of: None };
        self.undeclared.entry(key(name)).or_insert(new);
    }

    /// A missing name stands where only a constant can.
    pub fn is_constant(&mut self, name: &str) {
        if let Some(missing) = self.undeclared.get_mut(name) {
            missing.what = What::Constant;
        }
    }

    /// One message for all tags, and one for each other name.
    pub fn tell_undeclared(&mut self) {
        let mut tags: Vec<Undeclared> = Vec::new();
        for missing in std::mem::take(&mut self.undeclared).into_values() {
            let Undeclared { name, span, what, members, .. } = &missing;
            let sources = "in TIA Portal: Generate source from blocks, including dependent ones";
            match what {
                What::Variable if members.is_empty() => tags.push(missing),
                What::Variable => {
                    let members: Vec<String> = members.iter().map(|member| format!("{name}.{member}")).collect();
                    let message = format!("no source declares the data block \"{name}\": {}", members.join(", "));
                    self.error(*span, message, Some("export this DB as source, or declare it in a .scl file"));
                }
                What::Constant => {
                    let help = Remedy::DeclareConstant(name.clone());
                    self.report.error_with(*span, format!("no source declares the constant \"{name}\""), Some(help));
                }
                What::Type => {
                    self.error(*span, format!("no source declares the type \"{name}\""), Some(sources));
                }
                What::Function => {
                    self.error(*span, format!("no source declares the function \"{name}\""), Some(sources));
                }
                What::Block => {
                    self.error(*span, format!("no source declares the function block \"{name}\""), Some(sources));
                }
                What::Instance => {
                    let help = Remedy::DeclareInstance(name.clone());
                    self.report.error_with(*span, format!("no source declares the instance \"{name}\""), Some(help));
                }
            }
        }
        tags.sort_by_key(|tag| tag.span);
        let Some(first) = tags.first() else { return };
        let names: Vec<String> = tags
            .iter()
            .map(|tag| match tag.of {
                Some(of) => format!("\"{}\" : {}", tag.name, of.name()),
                None => format!("\"{}\"", tag.name),
            })
            .collect();
        let of = first.of.map_or("Bool", Elementary::name);
        let help = Remedy::DeclareTag { name: first.name.clone(), of };
        self.report.error_with(first.span, format!("no source declares the tags {}", names.join(", ")), Some(help));
    }
}
