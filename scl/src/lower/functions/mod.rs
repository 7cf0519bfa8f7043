//! Built-in functions of the CPU.

mod failures;
mod memory;
mod moments;
mod numbers;
mod refused;
mod texts;

use super::Lowerer;
use super::convert::{binary, convert, zero};
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary};
use crate::front::lexer::Span;
use crate::front::syntax::{Argument, ExpressionId};
use crate::ir::{self, Binary, Convert, Expr, Place, Scalar, Unary, What};
use std::cell::Cell;

pub(crate) use refused::{is_of_variants, is_ordinary, refused};

/// Functions whose name may carry the result type as a suffix: `LIMIT_REAL`.
const TYPED: [&str; 21] = [
    "ABS", "MIN", "MAX", "LIMIT", "SEL", "MUX", "SQR", "SQRT", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ASIN", "ACOS",
    "ATAN", "SHL", "SHR", "ROL", "ROR",
];

/// The arguments of a built-in function.
struct Given<'a> {
    arguments: &'a [Argument],
    name: &'a str,
    span: Span,
    /// A bit mask of the arguments read so far; bit 63 represents all arguments from index 63.
    used: &'a Cell<u64>,
}

impl<'a> Given<'a> {
    /// All arguments; marks them as read.
    fn all(&self) -> &'a [Argument] {
        self.used.set(u64::MAX);
        self.arguments
    }

    /// The argument with this name, or the unnamed one at this position; marks it as read. Without a position, searches
    /// by name only.
    fn find(&self, name: &str, position: impl Into<Option<usize>>) -> Option<ExpressionId> {
        let is_it = |argument: &Argument| argument.name.as_ref().is_some_and(|given| given.key() == name);
        let by_name = self.arguments.iter().position(is_it);
        let is_free = |position: &usize| self.arguments.get(*position).is_some_and(|argument| argument.name.is_none());
        let number = by_name.or(position.into().filter(is_free))?;
        self.used.set(self.used.get() | 1 << number.min(63));
        Some(self.arguments[number].value)
    }

    /// The first argument that the function did not read; `None` if that is EN or ENO.
    fn surplus(&self) -> Option<&'a Argument> {
        let is_used = |number: usize| self.used.get() >> number.min(63) & 1 == 1;
        let unused = self.arguments.iter().enumerate().find(|(number, _)| !is_used(*number));
        unused
            .map(|(_, argument)| argument)
            .filter(|argument| !argument.name.as_ref().is_some_and(|name| matches!(name.key().as_str(), "EN" | "ENO")))
    }
}

impl Lowerer<'_, '_> {
    /// Lowers a call of a built-in function in an expression; `None` if no function has that name.
    pub(crate) fn function(
        &mut self,
        name: &str,
        arguments: &[Argument],
        expected: Option<Elementary>,
        span: Span,
    ) -> Option<Operand> {
        let used = &Cell::new(0);
        let given = Given { arguments, name, span, used };
        let value = self.computed(&given, expected)?;
        // Missing or wrong arguments have already been reported.
        if !matches!(value, Operand::Wrong(_)) {
            self.refuse_surplus(&given);
        }
        Some(value)
    }

    /// Rejects an argument for which the function has no parameter and which would otherwise be silently ignored.
    fn refuse_surplus(&mut self, given: &Given) {
        let Some(argument) = given.surplus() else { return };
        let message = match &argument.name {
            Some(name) => format!("{} has no parameter {}", given.name, name.text),
            None => format!("{} has no parameter for this argument", given.name),
        };
        let span = argument.name.as_ref().map_or_else(|| self.span(argument.value), |name| name.span);
        self.error(span, message, Some("remove it"));
    }

    fn computed(&mut self, given: &Given, expected: Option<Elementary>) -> Option<Operand> {
        let Given { name, span, .. } = *given;
        if let Some((kind, to)) = name.split_once('?') {
            return Some(self.failure(kind, to, given));
        }
        if let Some((from, to)) = name.split_once("_TO_").filter(|(from, _)| !from.starts_with("__")) {
            return self.conversion(from, to, given);
        }
        if crate::library::is_block(name) {
            let block = self.compiler.system_block(name)?;
            return Some(self.value_of_function(block, given.all(), span));
        }
        if let Some(to) = name.strip_prefix("TO_").and_then(Elementary::named) {
            return Some(self.conversion_of(None, to, given));
        }
        let (base, suffix) = match name.rsplit_once('_') {
            Some((base, suffix)) => (base, Elementary::named(suffix)),
            None => (name, None),
        };
        if let Some(of) = suffix.filter(|_| TYPED.contains(&base)) {
            let operand = self.function(base, given.all(), Some(of), span)?;
            return Some(Operand::Value(of, self.converted(operand, of, span)));
        }
        let float = match name {
            "SQRT" => Some(Unary::Sqrt),
            "EXP" => Some(Unary::Exp),
            "LN" => Some(Unary::Ln),
            "LOG" => Some(Unary::Log),
            "SIN" => Some(Unary::Sin),
            "COS" => Some(Unary::Cos),
            "TAN" => Some(Unary::Tan),
            "ASIN" => Some(Unary::Asin),
            "ACOS" => Some(Unary::Acos),
            "ATAN" => Some(Unary::Atan),
            _ => None,
        };
        if let Some(operation) = float {
            return Some(self.float_function(operation, given, expected));
        }
        let operand = match (name, base) {
            ("__NOW", _) if self.file == self.compiler.library_file() => Operand::Value(Elementary::LInt, Expr::Now),
            ("ABS", _) => self.absolute(given),
            ("SQR", _) => self.square(given, expected),
            ("MIN" | "MAX", _) => self.extreme(given, expected),
            ("LIMIT", _) => self.limited(given, expected),
            ("SEL", _) => self.selected(given, expected),
            ("MUX", _) => self.multiplexed(given, expected),
            ("SHL" | "SHR" | "ROL" | "ROR", _) => self.shifted(given, expected),
            ("SWAP", _) | (_, "SWAP") => self.swapped(given, suffix.or(expected)),
            ("NORM_X", _) | (_, "NORM_X") => self.normed(given, suffix.or(expected)),
            ("SCALE_X", _) | (_, "SCALE_X") => self.scaled(given, suffix.or(expected)),
            ("ROUND" | "TRUNC" | "CEIL" | "FLOOR", _) => self.rounded(name, given, expected),
            (_, "ROUND" | "TRUNC" | "CEIL" | "FLOOR") if suffix.is_some() => self.rounded(base, given, suffix),
            ("FRAC", _) | (_, "FRAC") => self.fraction(given, suffix.or(expected)),
            ("T_ADD" | "T_SUB" | "T_DIFF", _) => {
                let operator = if name == "T_ADD" {
                    crate::front::syntax::Binary::Add
                } else {
                    crate::front::syntax::Binary::Subtract
                };
                let left = self.argument(given, "IN1", 0);
                let right = self.argument(given, "IN2", 1);
                match self.moments(operator, &left, &right, span) {
                    Some(moment) => moment,
                    None => self.binary(operator, left, right, span),
                }
            }
            ("T_COMBINE" | "CONCAT_DATE_TOD" | "CONCAT_DATE_LTOD", _) => self.combined(given),
            ("DECO", _) | (_, "DECO") => self.decoded(given, suffix.or(expected)),
            ("LOWER_BOUND" | "UPPER_BOUND", _) => self.bound(given),
            ("COUNTOFELEMENTS", _) => self.count(given),
            ("MOVE_BLK_VARIANT", _) => self.elements_of_arrays(given),
            ("BLKMOV" | "UBLKMOV", _) => self.copied_block(given),
            ("TIME_TCK", _) => {
                let at = self.at(span);
                let milliseconds = binary(Binary::Div, Scalar::I64, Expr::Now, Expr::Const(1_000_000i64.into()), at);
                let low = binary(Binary::And, Scalar::I64, milliseconds, Expr::Const(i64::from(i32::MAX).into()), at);
                Operand::Value(Elementary::Time, convert(low, Scalar::I64, Scalar::I32, Convert::Value, at))
            }
            ("RUNTIME", _) => self.runtime(given),
            ("RD_SYS_T" | "RD_LOC_T" | "READ_CLK", _) => self.clock(given),
            ("DT_DATE" | "DT_TOD" | "DT_DAY", _) => self.part_of_moment(given),
            ("MAX_LEN", _) => self.capacity(given),
            ("T_CONV", _) => self.converted_moment(given, expected),
            _ if crate::library::is_function(name) || self.is_inner(name) => {
                self.text_function(given).unwrap_or(Operand::Wrong(None))
            }
            _ => {
                if let Some(operand) = self.function_of_texts(given) {
                    return Some(operand);
                }
                let (message, help) = refused(name).filter(|_| !self.compiler.assumes || is_of_variants(name))?;
                self.error(span, message, Some(&help))
            }
        };
        Some(operand)
    }

    /// Whether the library calls one of its internal functions here; user code cannot.
    fn is_inner(&self, name: &str) -> bool {
        crate::library::is_inner(name) && self.file == self.compiler.library_file()
    }

    /// Lowers a call of a built-in function as a statement; returns `false` if no function has that name.
    pub(crate) fn statement_function(&mut self, name: &str, arguments: &[Argument], span: Span) -> bool {
        let used = &Cell::new(0);
        let given = Given { arguments, name, span, used };
        let errors = self.compiler.report.errors();
        match name {
            "RESET_TIMER" | "PRESET_TIMER" => self.timer_function(&given),
            "RD_SYS_T" | "RD_LOC_T" | "READ_CLK" => drop(self.clock(&given)),
            "RE_TRIGR" => {
                self.warn(span, "RE_TRIGR has no effect: an FMU has no cycle monitoring time to restart", None);
            }
            "MOVE_BLK" | "UMOVE_BLK" | "FILL_BLK" | "UFILL_BLK" => self.block_of_elements(&given),
            "MOVE_BLK_VARIANT" | "BLKMOV" | "UBLKMOV" => {
                let value = match name {
                    "MOVE_BLK_VARIANT" => self.elements_of_arrays(&given),
                    _ => self.copied_block(&given),
                };
                if let Operand::Value(_, Expr::After(code, _)) = value {
                    self.code.extend(code);
                }
            }
            "SCATTER" | "GATHER" => self.bits_of_elements(&given),
            "S_CONV" => self.text_or_number(&given),
            "VAL_STRG" => self.number_in_text(&given),
            "STRG_VAL" => self.number_of_text(&given),
            "STRG_TO_CHARS" | "CHARS_TO_STRG" => self.text_and_array(&given),
            "T_CONV" if given.find("OUT", 1).is_some() => self.convert_moment(&given),
            _ if crate::library::is_block(name) => {
                if let Some(block) = self.compiler.system_block(name) {
                    self.call_function(block, given.all(), span);
                }
            }
            "S_MOVE" => {
                if let (Some(from), Some(to)) = (given.find("IN", 0), given.find("OUT", 1))
                    && let Some(to) = self.target(to)
                {
                    let from = self.operand(from, None);
                    self.assign(&to, from, span);
                }
            }
            _ => match self.function(name, given.all(), None, span) {
                Some(Operand::Wrong(_)) => {}
                Some(_) => {
                    self.warn(span, format!("the value of {name} is not used"), Some("assign it to a variable"));
                }
                None => return false,
            },
        }
        if self.compiler.report.errors() == errors {
            self.refuse_surplus(&given);
        }
        true
    }

    /// The operand of an argument; reports an error if it is missing.
    fn argument(&mut self, given: &Given, name: &str, position: usize) -> Operand {
        match given.find(name, position) {
            Some(id) => self.operand(id, None),
            None => self.error(given.span, format!("{} is called without {name}", given.name), None),
        }
    }

    fn argument_span(&self, given: &Given, name: &str, position: usize) -> Span {
        given.find(name, position).map_or(given.span, |id| self.span(id))
    }

    /// An argument as a number in its own type; an untyped one takes the expected type or the widest one.
    fn typed(&mut self, operand: Operand, expected: Option<Elementary>, span: Span) -> Option<(Elementary, Expr)> {
        let of = match &operand {
            Operand::Value(of, _) => *of,
            Operand::Whole(whole) => expected.filter(|of| of.is_number()).unwrap_or_else(|| self.widest(*whole)),
            Operand::Fraction(..) => {
                expected.filter(|of| of.class() == Class::Real).unwrap_or_else(|| self.widest_real())
            }
            Operand::Wrong(_) => return None,
            other => {
                let found = self.type_name(other);
                self.error(span, format!("expected a number, found {found}"), None);
                return None;
            }
        };
        let value = self.converted(operand, of, span);
        Some((of, value))
    }

    /// An explicit conversion such as `INT_TO_REAL(x)`.
    fn conversion(&mut self, from: &str, to: &str, given: &Given) -> Option<Operand> {
        let bcd = |name: &str| name.contains("BCD") || matches!(name, "S5TIME" | "BLOCK_DB");
        if bcd(from) || bcd(to) {
            let message = format!("{} is not supported", given.name);
            return Some(self.error(given.span, message, Some("instead of BCD and S5TIME, use INT and TIME")));
        }
        if let Some(converted) =
            self.text_conversion(from, to, given).or_else(|| self.moment_conversion(from, to, given))
        {
            return Some(converted);
        }
        let (from, to) = (Elementary::named(from)?, Elementary::named(to)?);
        Some(self.conversion_of(Some(from), to, given))
    }

    fn conversion_of(&mut self, from: Option<Elementary>, to: Elementary, given: &Given) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let span = self.argument_span(given, "IN", 0);
        let Some(from) = from else {
            return match self.typed(operand, None, span) {
                Some((from, value)) => self.explicit(value, from, to, given.span),
                None => Operand::Wrong(None),
            };
        };
        if matches!(operand, Operand::Wrong(_)) {
            self.converted(operand, from, span);
            return Operand::Value(to, zero_of(to));
        }
        let value = self.converted(operand, from, span);
        self.explicit(value, from, to, given.span)
    }

    /// Stores a value in a temporary, so that it is evaluated only once.
    fn kept(&mut self, of: Elementary, value: Expr, span: Span) -> (Place, Expr) {
        let temp = self.temp(ir::Type::Scalar(of.scalar()));
        self.push(span, What::Assign(temp.clone(), value));
        (temp.clone(), Expr::Load(of.scalar(), temp))
    }

    /// The common type in which all operands are compared or selected; `None` if an operand is wrong or there is none,
    /// which is reported.
    fn common_of(&mut self, operands: &[Operand], expected: Option<Elementary>, span: Span) -> Option<Elementary> {
        if operands.iter().any(|operand| matches!(operand, Operand::Wrong(_))) {
            let of = operands.iter().find_map(|operand| match operand {
                Operand::Value(of, _) => Some(*of),
                _ => None,
            });
            for operand in operands {
                if let (Operand::Wrong(Some(name)), Some(of)) = (operand, of.or(expected)) {
                    let name = name.clone();
                    self.guess(&name, of);
                }
            }
            return None;
        }
        let are_typed = operands.iter().any(|operand| matches!(operand, Operand::Value(..)));
        let has_fraction = operands.iter().any(|operand| matches!(operand, Operand::Fraction(..)));
        if let Some(of) =
            expected.filter(|of| !are_typed && of.is_number() && (!has_fraction || of.class() == Class::Real))
        {
            return Some(of);
        }
        let mut common: Option<Operand> = None;
        for operand in operands {
            let next = match &common {
                None => Some(operand.clone()),
                Some(before) => self.common(before, operand).map(|of| Operand::Value(of, zero(of))),
            };
            if next.is_none() {
                let names: Vec<String> = operands.iter().map(|operand| self.type_name(operand)).collect();
                self.error(span, format!("{} have no common type", names.join(" and ")), None);
                return None;
            }
            common = next;
        }
        match common {
            Some(Operand::Value(of, _)) => Some(of),
            Some(operand) => self.typed(operand, expected, span).map(|(of, _)| of),
            None => None,
        }
    }

    fn all(&mut self, operands: Vec<Operand>, of: Elementary, span: Span) -> Vec<Expr> {
        operands.into_iter().map(|operand| self.quietly(operand, of, span)).collect()
    }

    /// An operand widened to a common type, without warnings.
    fn quietly(&mut self, operand: Operand, to: Elementary, span: Span) -> Expr {
        match operand {
            Operand::Value(from, value) if from.is_number() && to.is_number() => {
                let at = self.at(span);
                convert(value, from.scalar(), to.scalar(), Convert::Value, at)
            }
            other => self.converted(other, to, span),
        }
    }

    /// The local that holds a function's return value; it is named after the function.
    fn value_local(&self, function: usize) -> usize {
        let function = &self.compiler.program.functions[function];
        function.locals.iter().position(|local| local.name.eq_ignore_ascii_case(&function.name)).unwrap_or(0)
    }
}

/// Zero of a type, hidden from constant folding.
fn zero_of(of: Elementary) -> Expr {
    Expr::After(Vec::new(), Box::new(zero(of)))
}
