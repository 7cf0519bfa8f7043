//! Global variables and constants in IEC 61131-3 notation; in TIA Portal they are kept in tag tables.

use super::{Parsed, Parser};
use crate::front::lexer::Kind;
use crate::front::syntax::{Name, Section, SectionKind};

impl Parser<'_> {
    /// Parses `VAR_GLOBAL ... END_VAR` outside all blocks.
    pub(crate) fn globals(&mut self) {
        self.step();
        let kind = if self.takes_word("CONSTANT") { SectionKind::Constant } else { SectionKind::Static };
        let members = self.members("END_VAR");
        self.takes(";");
        self.tree.globals.push(Section { kind, is_retained: false, members });
    }

    /// Parses the operand of AT: a variable, or an address such as `%I0.0` or `%Q*`.
    pub(crate) fn place(&mut self) -> Parsed<Name> {
        if self.token().kind != Kind::Percent {
            return self.name("a variable");
        }
        let start = self.step().span;
        self.takes("*");
        let span = start.to(self.before());
        Ok(Name { text: self.text[span.range()].to_string(), span })
    }
}
