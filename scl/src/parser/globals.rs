//! Variables and constants that all blocks see, as IEC 61131-3 declares them: TIA Portal has them in tag tables.

use super::{Parsed, Parser};
use crate::lexer::Kind;
use crate::syntax::{Name, Section, SectionKind};

impl Parser<'_> {
    /// `VAR_GLOBAL ... END_VAR`, outside of all blocks.
    pub fn globals(&mut self) {
        self.step();
        let kind = if self.takes_word("CONSTANT") { SectionKind::Constant } else { SectionKind::Static };
        let members = self.members("END_VAR");
        self.takes(";");
        self.tree.globals.push(Section { kind, is_retained: false, members });
    }

    /// What follows AT: a variable, or an address such as `%I0.0` and `%Q*`.
    pub fn place(&mut self) -> Parsed<Name> {
        if self.token().kind != Kind::Percent {
            return self.name("a variable");
        }
        let start = self.step().span;
        self.takes("*");
        let span = start.to(self.before());
        Ok(Name { text: self.text[span.range()].to_string(), span })
    }
}
