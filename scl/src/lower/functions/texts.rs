//! Functions of texts.

use super::super::Lowerer;
use super::super::convert::{binary, convert, unary, zero};
use super::Given;
use crate::compiler::{Operand, Parameter};
use crate::lexer::Span;
use crate::program::{self, Binary, Convert, Expr, Place, Scalar, Unary, What};
use crate::types::{Class, Elementary, Type};

impl Lowerer<'_, '_> {
    /// A function of texts, of which the library has one for two texts.
    pub(super) fn text_function(&mut self, given: &Given) -> Option<Operand> {
        let block = self.compiler.system_block(given.name)?;
        let is_input = |member: &&Parameter| member.section == crate::syntax::SectionKind::Input;
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

    /// A character as a text.
    fn text_of(&mut self, code: Expr, span: Span) -> Place {
        let text = self.temp(program::Type::Text { capacity: 1, wide: false });
        let part = |step| Place { steps: vec![step], ..text.clone() };
        let first = program::Step::Index(vec![Expr::Const(1_i32.into())], self.at(span));
        self.push(span, What::Assign(part(first), code));
        self.push(span, What::Assign(part(program::Step::Length), Expr::Const(1_u16.into())));
        text
    }

    fn text_argument(&mut self, given: &Given, name: &str, position: usize, of: &Type) -> Option<program::Argument> {
        let span = self.argument_span(given, name, position);
        let of_parameter = of;
        match (self.argument(given, name, position), of) {
            (Operand::Value(Elementary::Char, code), Type::Text { .. }) => {
                Some(program::Argument::Copy(self.text_of(code, span)))
            }
            (Operand::Variable(of, place), Type::Structure(_)) if of.is_like(of_parameter) => {
                Some(program::Argument::Reference(self.frozen(place, span)))
            }
            (Operand::Wrong(_), _) => None,
            (operand, Type::Structure(_)) => {
                let found = self.type_name(&operand);
                self.error(span, format!("expected {of_parameter}, found {found}"), None);
                None
            }
            (operand, of) => self.by_copy(of, operand, span),
        }
    }

    /// `INT_TO_STRING` and back; `None` if no type is a text.
    pub(super) fn text_conversion(&mut self, from: &str, to: &str, given: &Given) -> Option<Operand> {
        let is_text = |name: &str| matches!(name, "STRING" | "WSTRING" | "CHARS" | "STRG");
        if !is_text(from) && !is_text(to) {
            return None;
        }
        let number = |name: &str| Elementary::named(name).filter(|of| of.is_number() || *of == Elementary::Char);
        let converted = match (number(from), number(to)) {
            (Some(of), None) if to == "STRING" => self.number_to_text(of, given),
            (None, Some(of)) if from == "STRING" => self.text_to_number(of, given),
            _ => {
                let help = "compute it outside of the program and feed it through an input";
                return Some(self.error(given.span, format!("{} is not supported", given.name), Some(help)));
            }
        };
        Some(converted.unwrap_or(Operand::Wrong(None)))
    }

    /// S_CONV: a number to a text, a text to a number, or a text as it is; the variable at OUT says which.
    pub(super) fn text_or_number(&mut self, given: &Given) {
        let (Some(_), Some(output)) = (given.find("IN", 0), given.find("OUT", 1)) else {
            self.error(given.span, "S_CONV is called without IN or OUT", None);
            return;
        };
        let Some(to) = self.target(output) else { return };
        // Only its type: what it calculates is thrown away.
        let (_, operand) = self.aside(|lowerer| lowerer.argument(given, "IN", 0));
        let value = match (&operand, to.of.elementary()) {
            (Operand::Variable(Type::Text { wide: false, .. }, _) | Operand::Text(..), Some(of)) => {
                self.text_to_number(of, given)
            }
            (Operand::Value(of, _), None) => self.number_to_text(*of, given),
            _ => Some(self.argument(given, "IN", 0)),
        };
        if let Some(value) = value {
            self.assign(&to, value, given.span);
        }
    }

    /// A number as a text: as wide as the longest one of its type, right-aligned.
    fn number_to_text(&mut self, of: Elementary, given: &Given) -> Option<Operand> {
        let span = given.span;
        let operand = self.argument(given, "IN", 0);
        if of == Elementary::Char {
            let value = self.converted(operand, of, span);
            let text = self.text_of(value, span);
            return Some(Operand::Variable(Type::Text { capacity: 1, wide: false }, text));
        }
        if matches!(operand, Operand::Wrong(_)) {
            return None;
        }
        let at = self.at(span);
        let value = self.converted(operand, of, span);
        let (_, value) = self.kept(of, value, span);
        let number = |number: i16| program::Argument::Value(Expr::Const(number.into()));
        if of.class() == Class::Real {
            let (digits, exponent, width) = if of == Elementary::Real { (6, 2, 14) } else { (13, 3, 21) };
            let value = convert(value, of.scalar(), Scalar::F64, Convert::Value, at);
            let passed = vec![program::Argument::Value(value), number(digits), number(exponent), number(width)];
            return self.of_library("__REAL_TO_TEXT", passed, span);
        }
        let width = match of.bits() {
            8 => 4,
            16 => 6,
            32 => 11,
            _ => 21,
        };
        let is_minus = if of.scalar().is_signed() {
            binary(Binary::Lt, of.scalar(), value.clone(), zero(of), at)
        } else {
            Expr::Const(false.into())
        };
        let wide = convert(value, of.scalar(), Scalar::I64, Convert::Value, at);
        let wide = if of.scalar().is_signed() { unary(Unary::Abs, Scalar::I64, wide) } else { wide };
        let wide = convert(wide, Scalar::I64, Scalar::U64, Convert::Value, at);
        let passed = vec![program::Argument::Value(wide), program::Argument::Value(is_minus), number(width)];
        self.of_library("__WHOLE_TO_TEXT", passed, span)
    }

    /// The number with which a text begins; 0 if it has none or it does not fit.
    fn text_to_number(&mut self, of: Elementary, given: &Given) -> Option<Operand> {
        let (span, at) = (given.span, self.at(given.span));
        let text = self.text_argument(given, "IN", 0, &Type::Text { capacity: 254, wide: false })?;
        if of == Elementary::Char {
            let program::Argument::Copy(mut place) = text else { return None };
            place.steps.push(program::Step::Index(vec![Expr::Const(1_i32.into())], at));
            return Some(Operand::Value(of, Expr::Load(of.scalar(), place)));
        }
        if of.class() == Class::Real {
            let Some(Operand::Value(wide, value)) = self.of_library("__TEXT_TO_REAL", vec![text], span) else {
                return None;
            };
            return Some(Operand::Value(of, convert(value, wide.scalar(), of.scalar(), Convert::Value, at)));
        }
        let Some(Operand::Value(wide, value)) = self.of_library("__TEXT_TO_WHOLE", vec![text], span) else {
            return None;
        };
        let (code, (_, value)) = self.aside(|lowerer| lowerer.kept(wide, value, span));
        let narrow = convert(value.clone(), wide.scalar(), of.scalar(), Convert::Value, at);
        let again = convert(narrow.clone(), of.scalar(), wide.scalar(), Convert::Value, at);
        let is_same = binary(Binary::Eq, wide.scalar(), again, value, at);
        let fitting = Expr::Select(of.scalar(), Box::new([is_same, narrow, zero(of)]));
        Some(Operand::Value(of, Expr::After(code, Box::new(fitting))))
    }

    /// Calls a function of the library.
    pub(super) fn of_library(&mut self, name: &str, passed: Vec<program::Argument>, span: Span) -> Option<Operand> {
        let block = self.compiler.system_block(name)?;
        Some(self.text_call(block, passed, span))
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
