//! Functions of texts.

use super::super::{Lowerer, Operand};
use super::Given;
use crate::lexer::Span;
use crate::program::{self, Expr, Place, What};
use crate::types::{Elementary, Type};

impl Lowerer<'_, '_> {
    /// A function of texts, of which the library has one for two texts.
    pub(super) fn text_function(&mut self, given: &Given) -> Option<Operand> {
        let block = self.compiler.system_block(given.name)?;
        let is_input = |member: &&crate::declare::Parameter| member.section == crate::syntax::SectionKind::Input;
        let inputs: Vec<_> = self.compiler.blocks[block].members.iter().filter(is_input).cloned().collect();
        let mut passed = Vec::new();
        for (position, parameter) in inputs.iter().enumerate() {
            let position = if given.arguments.len() == 1 { 0 } else { position };
            // Of a single argument the name does not matter: S in STEP 7, IN in TIA.
            let name = if inputs.len() == 1 { given.arguments.first()?.name.as_ref() } else { None };
            let name = name.map_or(parameter.key.clone(), |name| name.key());
            passed.push(self.text_argument(given, &name, position, &parameter.of)?);
        }
        let mut value = self.text_call(block, passed, given.span);
        let mut number = inputs.len();
        while given.name == "CONCAT" && given.find(&format!("IN{}", number + 1), number).is_some() {
            let added = self.text_argument(given, &format!("IN{}", number + 1), number, &inputs[1].of)?;
            let before = program::Argument::Copy(self.text_place(value)?);
            value = self.text_call(block, vec![before, added], given.span);
            number += 1;
        }
        Some(value)
    }

    fn text_argument(&mut self, given: &Given, name: &str, position: usize, of: &Type) -> Option<program::Argument> {
        let span = self.argument_span(given, name, position);
        match (self.argument(given, name, position), of) {
            (Operand::Value(Elementary::Char, code), Type::Text { .. }) => {
                let text = self.temp(program::Type::Text { capacity: 1, wide: false });
                let part = |step| Place { steps: vec![step], ..text.clone() };
                let first = program::Step::Index(vec![Expr::Const(1_i32.into())], self.at(span));
                self.push(span, What::Assign(part(first), code));
                self.push(span, What::Assign(part(program::Step::Length), Expr::Const(1_u16.into())));
                Some(program::Argument::Copy(text))
            }
            (operand, of) => self.by_copy(of, operand, span),
        }
    }

    /// Calls a function of the library; a text is calculated before the statement.
    fn text_call(&mut self, block: usize, passed: Vec<program::Argument>, span: Span) -> Operand {
        let function = self.compiler.blocks[block].function;
        let of = self.compiler.blocks[block].result.clone();
        let result = self.temp(self.compiler.lowered(&of));
        let outputs = vec![(self.value_local(function), result.clone())];
        let call = What::Call(program::Call { function, instance: None, arguments: passed, outputs });
        match of {
            Type::Elementary(of) => {
                let (code, ()) = self.aside(|lowerer| lowerer.push(span, call));
                Operand::Value(of, Expr::After(code, Box::new(Expr::Load(of.scalar(), result))))
            }
            of => {
                self.push(span, call);
                Operand::Variable(of, result)
            }
        }
    }

    /// The most characters of a text.
    pub(super) fn capacity(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Variable(Type::Text { capacity, .. }, _) => {
                Operand::Value(Elementary::DInt, Expr::Const(i32::from(capacity).into()))
            }
            Operand::Wrong(name) => Operand::Wrong(name),
            _ => self.error(given.span, "MAX_LEN is for texts", None),
        }
    }
}
