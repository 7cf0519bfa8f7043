//! String functions.

use super::super::Lowerer;
use super::super::convert::{binary, convert, unary, zero};
use super::Given;
use crate::check::compiler::{Operand, Parameter};
use crate::check::types::{Class, Elementary, Type};
use crate::front::lexer::Span;
use crate::front::syntax::Argument;
use crate::ir::{self, Binary, Convert, Expr, Scalar, Unary, What};

/// The format parameters of VAL_STRG; STRG_VAL has only the last two.
const FORMATTED: [(&str, Elementary); 4] =
    [("SIZE", Elementary::DInt), ("PREC", Elementary::DInt), ("FORMAT", Elementary::Word), ("P", Elementary::DInt)];

impl Lowerer<'_, '_> {
    /// LEN, LEFT, CONCAT and so on, for STRING or WSTRING; `None` for any other function.
    pub(super) fn function_of_texts(&mut self, given: &Given) -> Option<Operand> {
        let suffix = ["_STRING", "_WSTRING"].into_iter().find(|suffix| given.name.ends_with(suffix)).unwrap_or("");
        let base = &given.name[..given.name.len() - suffix.len()];
        if !crate::library::is_text(base) {
            return None;
        }
        let is_wide = match suffix {
            "" => self.is_wide(given),
            suffix => suffix == "_WSTRING",
        };
        let name = if is_wide { format!("{base}_WSTRING") } else { base.to_string() };
        let given = Given { name: &name, ..*given };
        Some(self.text_function(&given).unwrap_or(Operand::Wrong(None)))
    }

    /// Whether an argument is a WSTRING or WCHAR. Only the types matter: the code is discarded.
    fn is_wide(&mut self, given: &Given) -> bool {
        given.arguments.iter().any(|argument| {
            let (_, operand) = self.aside(|lowerer| lowerer.operand(argument.value, None));
            matches!(
                operand,
                Operand::Variable(Type::Text { wide: true, .. }, _)
                    | Operand::Text(_, Some(true))
                    | Operand::Value(Elementary::WChar, _)
            )
        })
    }

    /// Calls a string function; CONCAT of more than two strings becomes a chain of calls.
    pub(super) fn text_function(&mut self, given: &Given) -> Option<Operand> {
        let block = self.compiler.system_block(given.name)?;
        let is_input = |member: &&Parameter| member.section == crate::front::syntax::SectionKind::Input;
        let inputs: Vec<_> = self.compiler.blocks[block].members.iter().filter(is_input).cloned().collect();
        let mut passed = Vec::new();
        for (position, parameter) in inputs.iter().enumerate() {
            let position = if given.arguments.len() == 1 { 0 } else { position };
            // The name of a single argument is ignored: it is S in STEP 7, IN in TIA Portal.
            let name = if inputs.len() == 1 { given.arguments.first()?.name.as_ref() } else { None };
            let name = name.map_or(parameter.key.clone(), |name| name.key());
            passed.push(self.text_argument(given, &name, position, &parameter.of)?);
        }
        let mut value = self.text_call(block, passed, given.span);
        let mut number = inputs.len();
        while given.name.starts_with("CONCAT") && given.find(&format!("IN{}", number + 1), number).is_some() {
            let added = self.text_argument(given, &format!("IN{}", number + 1), number, &inputs[1].of)?;
            let before = ir::Argument::Copy(self.text_place(value)?);
            value = self.text_call(block, vec![before, added], given.span);
            number += 1;
        }
        Some(value)
    }

    fn text_argument(&mut self, given: &Given, name: &str, position: usize, of: &Type) -> Option<ir::Argument> {
        let span = self.argument_span(given, name, position);
        let of_parameter = of;
        match (self.argument(given, name, position), of) {
            (Operand::Variable(of, place), Type::Structure(_)) if of.is_like(of_parameter) => {
                Some(ir::Argument::Reference(self.referred(place, &of, span)))
            }
            (Operand::Wrong(_), Type::Structure(_)) => None,
            (operand, Type::Structure(_)) => {
                let found = self.type_name(&operand);
                self.error(span, format!("expected {of_parameter}, found {found}"), None);
                None
            }
            (operand, of) => self.by_copy(of, operand, span),
        }
    }

    /// `INT_TO_STRING` and the reverse; `None` if neither type is a string.
    pub(super) fn text_conversion(&mut self, from: &str, to: &str, given: &Given) -> Option<Operand> {
        let is_text = |name: &str| matches!(name, "STRING" | "WSTRING" | "CHARS" | "STRG");
        if !is_text(from) && !is_text(to) {
            return None;
        }
        let number = |name: &str| {
            let of = Elementary::named(name);
            of.filter(|of| of.is_number() || of.class() == Class::Character || *of == Elementary::Bool)
        };
        let converted = match (number(from), number(to)) {
            (Some(Elementary::Bool), _) | (_, Some(Elementary::Bool)) => None,
            (Some(of), None) => Some(self.number_to_text(of, to == "WSTRING", given)),
            (None, Some(of)) => Some(self.text_to_number(of, from == "WSTRING", given)),
            _ if (from, to) == ("STRING", "WSTRING") || (from, to) == ("WSTRING", "STRING") => {
                Some(self.other_width(given, to == "WSTRING"))
            }
            _ => None,
        };
        let Some(converted) = converted else {
            let help = "compute it outside the program and pass it in through an input";
            return Some(self.error(given.span, format!("{} is not supported", given.name), Some(help)));
        };
        Some(converted.unwrap_or(Operand::Wrong(None)))
    }

    /// The argument IN of a function, which must be a string.
    fn text_argument_of(&mut self, given: &Given, wide: bool) -> Option<ir::Argument> {
        self.text_argument(given, "IN", 0, &Type::Text { capacity: 254, wide })
    }

    /// A string converted to the other character width.
    fn other_width(&mut self, given: &Given, wide: bool) -> Option<Operand> {
        let text = self.text_argument_of(given, !wide)?;
        self.of_library(if wide { "STRING_TO_WSTRING" } else { "WSTRING_TO_STRING" }, vec![text], given.span)
    }

    /// S_CONV: number to string, string to number, or a plain copy, depending on IN and the variable at OUT.
    pub(super) fn text_or_number(&mut self, given: &Given) {
        let (Some(_), Some(output)) = (given.find("IN", 0), given.find("OUT", 1)) else {
            self.error(given.span, "S_CONV needs both IN and OUT", None);
            return;
        };
        let Some(to) = self.target(output) else { return };
        // Only the type matters: the code is discarded.
        let (_, operand) = self.aside(|lowerer| lowerer.argument(given, "IN", 0));
        let value = match (&operand, to.of.elementary()) {
            (Operand::Variable(Type::Text { wide, .. }, _) | Operand::Text(_, Some(wide)), Some(of)) => {
                self.text_to_number(of, *wide, given)
            }
            (Operand::Text(..), Some(of)) => self.text_to_number(of, false, given),
            (Operand::Value(of, _), None) => {
                self.number_to_text(*of, matches!(to.of, Type::Text { wide: true, .. }), given)
            }
            _ => Some(self.argument(given, "IN", 0)),
        };
        if let Some(value) = value {
            self.assign(&to, value, given.span);
        }
    }

    /// A number as a string, right-aligned to the width of the longest number of its type.
    fn number_to_text(&mut self, of: Elementary, wide: bool, given: &Given) -> Option<Operand> {
        let span = given.span;
        let operand = self.argument(given, "IN", 0);
        if matches!(operand, Operand::Wrong(_)) {
            return None;
        }
        let text = if of.class() == Class::Character {
            let value = self.converted(operand, of, span);
            let wide = of == Elementary::WChar;
            let text = self.text_of(value, wide, span);
            Operand::Variable(Type::Text { capacity: 1, wide }, text)
        } else {
            self.digits(operand, of, span)?
        };
        let Operand::Variable(Type::Text { wide: found, .. }, place) = &text else { return None };
        if *found == wide {
            return Some(text);
        }
        let name = if wide { "STRING_TO_WSTRING" } else { "WSTRING_TO_STRING" };
        self.of_library(name, vec![ir::Argument::Copy(place.clone())], span)
    }

    fn digits(&mut self, operand: Operand, of: Elementary, span: Span) -> Option<Operand> {
        let at = self.at(span);
        let value = self.converted(operand, of, span);
        let (_, value) = self.kept(of, value, span);
        let number = |number: i16| ir::Argument::Value(Expr::Const(number.into()));
        if of.class() == Class::Real {
            let (digits, exponent, width) = if of == Elementary::Real { (6, 2, 14) } else { (13, 3, 21) };
            let value = convert(value, of.scalar(), Scalar::F64, Convert::Value, at);
            let passed = vec![ir::Argument::Value(value), number(digits), number(exponent), number(width)];
            return self.of_library("__REAL_TO_TEXT", passed, span);
        }
        let width = match of.bits() {
            8 => 4,
            16 => 6,
            32 => 11,
            _ => 21,
        };
        let [amount, is_minus] = self.amount(of, value, span);
        let passed = vec![ir::Argument::Value(amount), ir::Argument::Value(is_minus), number(width)];
        self.of_library("__WHOLE_TO_TEXT", passed, span)
    }

    /// The absolute value of an integer, and whether it is negative.
    fn amount(&mut self, of: Elementary, value: Expr, span: Span) -> [Expr; 2] {
        let at = self.at(span);
        let is_minus = if of.scalar().is_signed() {
            binary(Binary::Lt, of.scalar(), value.clone(), zero(of), at)
        } else {
            Expr::Const(false.into())
        };
        let wide = convert(value, of.scalar(), Scalar::I64, Convert::Value, at);
        let wide = if of.scalar().is_signed() { unary(Unary::Abs, Scalar::I64, wide) } else { wide };
        [convert(wide, Scalar::I64, Scalar::U64, Convert::Value, at), is_minus]
    }

    /// The number at the start of a string; 0 if there is none or it does not fit.
    fn text_to_number(&mut self, of: Elementary, wide: bool, given: &Given) -> Option<Operand> {
        let (span, at) = (given.span, self.at(given.span));
        let text = self.text_argument_of(given, wide)?;
        let ir::Argument::Copy(mut place) = text else { return None };
        if of.class() == Class::Character {
            place.steps.push(ir::Step::Index(vec![Expr::Const(1_i32.into())], at));
            let found = if wide { Elementary::WChar } else { Elementary::Char };
            return Some(self.explicit(Expr::Load(found.scalar(), place), found, of, span));
        }
        if wide {
            let narrow = self.of_library("WSTRING_TO_STRING", vec![ir::Argument::Copy(place)], span)?;
            place = self.text_place(narrow)?;
        }
        self.number_at(of, place, span)
    }

    /// The number at the start of a STRING.
    fn number_at(&mut self, of: Elementary, place: ir::Place, span: Span) -> Option<Operand> {
        let (text, at) = (ir::Argument::Copy(place), self.at(span));
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

    /// VAL_STRG: writes a number into a string, starting at a position.
    pub(super) fn number_in_text(&mut self, given: &Given) {
        let span = given.span;
        let Some(output) = given.find("OUT", 5) else {
            self.error(span, "VAL_STRG is called without OUT", None);
            return;
        };
        let Some(to) = self.target(output) else { return };
        let operand = self.argument(given, "IN", 0);
        let Some((of, value)) = self.typed(operand, None, self.argument_span(given, "IN", 0)) else { return };
        let old = self.value_of(&to, span);
        let Some(old) = self.text_as(old, false, span) else { return };
        let mut passed = vec![ir::Argument::Copy(old)];
        let name = if of.class() == Class::Real {
            let at = self.at(span);
            let wide = convert(value, of.scalar(), Scalar::F64, Convert::Value, at);
            passed.push(ir::Argument::Value(wide));
            "__VAL_STRG_REAL"
        } else {
            let (_, value) = self.kept(of, value, span);
            passed.extend(self.amount(of, value, span).map(ir::Argument::Value));
            "__VAL_STRG_WHOLE"
        };
        self.pass_format(given, &FORMATTED, &mut passed);
        if let Some(text) = self.of_library(name, passed, span) {
            self.assign(&to, text, span);
        }
    }

    /// Passes the format parameters, which follow IN.
    fn pass_format(&mut self, given: &Given, parameters: &[(&str, Elementary)], passed: &mut Vec<ir::Argument>) {
        for (number, (name, of)) in (1..).zip(parameters) {
            let operand = self.argument(given, name, number);
            let value = self.converted(operand, *of, self.argument_span(given, name, number));
            passed.push(ir::Argument::Value(value));
        }
    }

    /// STRG_VAL: reads a number from a string, starting at a position.
    pub(super) fn number_of_text(&mut self, given: &Given) {
        let span = given.span;
        let Some(output) = given.find("OUT", 3) else {
            self.error(span, "STRG_VAL is called without OUT", None);
            return;
        };
        let Some(to) = self.target(output) else { return };
        let Some(of) = to.of.elementary().filter(|of| of.is_number()) else {
            self.error(span, format!("STRG_VAL writes a number, not {}", to.of), None);
            return;
        };
        let Some(text) = self.text_argument_of(given, false) else { return };
        let mut passed = vec![text];
        self.pass_format(given, &FORMATTED[2..], &mut passed);
        let Some(number) = self.of_library("__STRG_VAL", passed, span) else { return };
        let Some(number) = self.text_place(number) else { return };
        if let Some(value) = self.number_at(of, number, span) {
            self.assign(&to, value, span);
        }
    }

    /// Strg_TO_Chars and Chars_TO_Strg: the element type of the array selects the library function.
    pub(super) fn text_and_array(&mut self, given: &Given) {
        let Some(array) = given.find("CHARS", 3) else {
            self.error(given.span, format!("{} is called without Chars", given.name), None);
            return;
        };
        let (_, found) = self.aside(|lowerer| lowerer.target(array));
        let of = match found.map(|variable| variable.of) {
            Some(Type::Array(array)) => array.of.elementary(),
            Some(Type::Open(of, _)) => of.elementary(),
            None | Some(Type::Wrong | Type::Missing(_)) => return,
            _ => None,
        };
        let block = of.and_then(|of| self.compiler.system_block(&format!("{}_{}", given.name, of.name())));
        let Some(block) = block else {
            let help = "Chars must be an array of CHAR, BYTE, WCHAR or WORD";
            self.error(self.span(array), format!("{} does not accept this argument", given.name), Some(help));
            return;
        };
        let is_text = |argument: &&Argument| {
            given.name == "CHARS_TO_STRG" && argument.name.as_ref().is_some_and(|name| name.key() == "STRG")
        };
        let target = given.all().iter().find(is_text);
        let others: Vec<Argument> = given.all().iter().filter(|argument| !is_text(argument)).cloned().collect();
        let value = self.call_function(block, &others, given.span);
        if let (Some(target), Some((of, place))) = (target, value)
            && let Some(to) = self.target(target.value)
        {
            self.assign(&to, Operand::Variable(of, place), given.span);
        }
    }

    /// Calls a library function by name, with all its arguments.
    pub(super) fn of_library(&mut self, name: &str, passed: Vec<ir::Argument>, span: Span) -> Option<Operand> {
        let block = self.compiler.system_block(name)?;
        Some(self.text_call(block, passed, span))
    }

    /// Calls a library function; a result that is not a number is computed before the statement.
    fn text_call(&mut self, block: usize, passed: Vec<ir::Argument>, span: Span) -> Operand {
        let function = self.compiler.blocks[block].function;
        let of = self.compiler.blocks[block].result.clone();
        let result = self.temp(self.compiler.lowered(&of));
        let outputs = vec![(self.value_local(function), result.clone())];
        let call = What::Call(ir::Call { function, instance: None, arguments: passed, outputs });
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

    /// The capacity of a string in characters.
    pub(super) fn capacity(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Variable(Type::Text { capacity, .. }, _) => {
                Operand::Value(Elementary::DInt, Expr::Const(i32::from(capacity).into()))
            }
            Operand::Wrong(name) => Operand::Wrong(name),
            _ => self.error(given.span, "MAX_LEN needs a string", None),
        }
    }
}
