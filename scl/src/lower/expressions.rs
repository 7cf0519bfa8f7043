//! Expressions.

use super::Lowerer;
use crate::check::compiler::{Note, Operand};
use crate::check::constant::{self, Literal};
use crate::check::types::{Elementary, Type, text_name};
use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, ExpressionKind};
use crate::ir::{self, At, Base, Convert, Expr, Place, Scalar, Value};

/// The size of a DTL in bytes.
pub(crate) const DTL_BYTES: usize = 12;

impl Lowerer<'_, '_> {
    /// Lowers an expression; `expected` is the type of the variable to which it is directly assigned, if any.
    pub(crate) fn operand(&mut self, id: ExpressionId, expected: Option<Elementary>) -> Operand {
        let operand = self.calculated(id, expected);
        self.noted(id, operand)
    }

    /// Adds code that records a watched truth value when it is evaluated.
    fn noted(&mut self, id: ExpressionId, operand: Operand) -> Operand {
        let Operand::Value(of @ Elementary::Bool, value) = operand else { return operand };
        let Some(place) = self.place_of_note(id) else { return Operand::Value(of, value) };
        let number = Expr::Convert(Convert::Value, Scalar::Bool, Scalar::U8, Box::new(value), At::default());
        let reached = Box::new(Expr::Const(Note::FALSE.into()));
        let number = Expr::Binary(ir::Binary::Add, Scalar::U8, Box::new(number), reached, At::default());
        let note = ir::Statement { at: At::NOTE, what: ir::What::Assign(place.clone(), number) };
        let (load, truth) = (Expr::Load(Scalar::U8, place), Expr::Const(Note::TRUE.into()));
        let value = Expr::Binary(ir::Binary::Eq, Scalar::U8, Box::new(load), Box::new(truth), At::default());
        Operand::Value(of, Expr::After(vec![note], Box::new(value)))
    }

    /// Adds a local in which the truth value of an expression is recorded; `None` if the expression is not watched.
    pub(super) fn place_of_note(&mut self, id: ExpressionId) -> Option<ir::Place> {
        let function = self.compiler.blocks[self.block?].function;
        if !self.compiler.watched.contains(&(self.file, id)) {
            return None;
        }
        let place = self.temp(ir::Type::Scalar(Scalar::U8));
        self.compiler.notes.push(Note { file: self.file, expression: id.0, function, local: self.locals.len() - 1 });
        Some(place)
    }

    fn calculated(&mut self, id: ExpressionId, expected: Option<Elementary>) -> Operand {
        let expressions = self.expressions();
        let span = expressions[id].span;
        match &expressions[id].kind {
            ExpressionKind::Literal(text) => self.literal(text, span),
            ExpressionKind::Unary(operator, operand) => {
                let operand = self.operand(*operand, None);
                self.unary(*operator, operand, span)
            }
            ExpressionKind::Binary(..) => {
                // A chain such as `a + b + c` nests to the left: iterate instead of recursing.
                let mut chain = Vec::new();
                let mut first = id;
                while let ExpressionKind::Binary(operator, left, right) = &expressions[first].kind {
                    chain.push((*operator, *right, first));
                    first = *left;
                }
                let mut left = self.operand(first, None);
                for (operator, right, whole) in chain.into_iter().rev() {
                    let right = self.operand(right, None);
                    left = self.binary(operator, left, right, expressions[whole].span);
                    // The caller records the whole expression.
                    if whole != id {
                        left = self.noted(whole, left);
                    }
                }
                left
            }
            ExpressionKind::Call(callee, arguments) => self.call_value(*callee, arguments, expected, span),
            ExpressionKind::As(of, inner) => {
                let operand = self.operand(*inner, Some(*of));
                match operand {
                    Operand::Variable(..) | Operand::Text(..) if !of.is_number() => operand,
                    operand => Operand::Value(*of, self.converted(operand, *of, span)),
                }
            }
            _ => self.load(id),
        }
    }

    pub(crate) fn literal(&mut self, text: &str, span: Span) -> Operand {
        match constant::read(text) {
            Ok(Literal::Whole(whole, None)) => Operand::Whole(whole),
            Ok(Literal::Whole(whole, Some(of))) => {
                Operand::Value(of, Expr::Const(Value::new(of.scalar(), whole as u64)))
            }
            Ok(Literal::Fraction(wide, narrow, None)) => Operand::Fraction(wide, narrow),
            Ok(Literal::Fraction(_, narrow, Some(Elementary::Real))) => {
                Operand::Value(Elementary::Real, Expr::Const(narrow.into()))
            }
            Ok(Literal::Fraction(wide, ..)) => Operand::Value(Elementary::LReal, Expr::Const(wide.into())),
            Ok(Literal::Truth(truth)) => Operand::Value(Elementary::Bool, Expr::Const(truth.into())),
            Ok(Literal::Text(text, wide)) => Operand::Text(text, wide),
            Ok(Literal::Moment(parts)) => {
                let of = self.compiler.dtl();
                let place = self.constant_place(self.compiler.lowered(&of), &moment(parts));
                Operand::Variable(of, place)
            }
            Err((expected, help)) => {
                let found = parameters::problem::quoted(text);
                self.error(span, format!("expected {expected}, found {found}"), help)
            }
        }
    }

    /// The bytes of a DTL literal; reports an error if it is another literal.
    pub(crate) fn moment(&mut self, id: ExpressionId) -> Option<[u8; DTL_BYTES]> {
        let expressions = self.expressions();
        let ExpressionKind::Literal(text) = &expressions[id].kind else { return None };
        match constant::read(text) {
            Ok(Literal::Moment(parts)) => Some(moment(parts)),
            _ => {
                self.error(expressions[id].span, "expected a DTL such as DTL#2020-01-02-03:04:05.6", None);
                None
            }
        }
    }

    /// Adds a constant with these bytes to the program; returns its place.
    fn constant_place(&mut self, of: ir::Type, bytes: &[u8]) -> Place {
        let constants = self.compiler.program.constants;
        let member = self.compiler.program.extend_record(constants, "constant", of);
        let record = &mut self.compiler.program.records[constants];
        let offset = record.members[member].offset;
        record.start[offset..offset + bytes.len()].copy_from_slice(bytes);
        Place::new(Base::Constants).member(member)
    }

    /// The place of a string of the given width: an untyped constant takes that width, and a character becomes a string
    /// of length 1.
    pub(crate) fn text_as(&mut self, operand: Operand, wide: bool, span: Span) -> Option<Place> {
        match operand {
            Operand::Wrong(name) => {
                if let Some(name) = name {
                    self.compiler.guess_missing(&name, text_name(wide).to_string());
                }
                None
            }
            Operand::Text(text, of) if of.is_none_or(|of| of == wide) => Some(self.text_constant(&text, wide)),
            Operand::Variable(Type::Text { wide: of, .. }, place) if of == wide => Some(place),
            Operand::Value(of @ (Elementary::Char | Elementary::WChar), code) if (of == Elementary::WChar) == wide => {
                Some(self.text_of(code, wide, span))
            }
            other => {
                let found = match &other {
                    Operand::Text(_, Some(true)) => "a WSTRING".to_string(),
                    Operand::Text(_, Some(false)) => "a STRING".to_string(),
                    other => self.type_name(other),
                };
                let is_text = matches!(other, Operand::Text(..) | Operand::Variable(Type::Text { .. }, _));
                let (expected, help) = match wide {
                    true => ("WSTRING", "convert it with STRING_TO_WSTRING"),
                    false => ("STRING", "convert it with WSTRING_TO_STRING"),
                };
                self.error(span, format!("expected {expected}, found {found}"), Some(help).filter(|_| is_text));
                None
            }
        }
    }

    /// A character as a string of length 1.
    pub(crate) fn text_of(&mut self, code: Expr, wide: bool, span: Span) -> Place {
        let text = self.temp(ir::Type::Text { capacity: 1, wide });
        let part = |step| Place { steps: vec![step], ..text.clone() };
        let first = ir::Step::Index(vec![Expr::Const(1_i32.into())], self.at(span));
        self.push(span, ir::What::Assign(part(first), code));
        self.push(span, ir::What::Assign(part(ir::Step::Length), Expr::Const(1_u16.into())));
        text
    }

    /// The place of a string constant or variable; `None` for a scalar.
    pub(crate) fn text_place(&mut self, operand: Operand) -> Option<Place> {
        match operand {
            Operand::Text(text, wide) => {
                let wide = wide.unwrap_or(text.iter().any(|unit| *unit > 255));
                Some(self.text_constant(&text, wide))
            }
            Operand::Variable(_, place) => Some(place),
            _ => None,
        }
    }

    /// The place of a constant string; in a STRING, an unsupported character becomes a question mark.
    pub(crate) fn text_constant(&mut self, text: &[u16], wide: bool) -> Place {
        let of = Type::Text { capacity: text.len().min(16382) as u16, wide };
        let lowered = self.compiler.lowered(&of);
        let mut bytes = vec![0; self.compiler.program.size(&lowered)];
        crate::check::start::write_text(&of, text, &mut bytes);
        self.constant_place(lowered, &bytes)
    }
}

fn moment([year, month, day, hour, minute, second, nanosecond]: [u32; 7]) -> [u8; DTL_BYTES] {
    let mut bytes = [0; DTL_BYTES];
    bytes[..2].copy_from_slice(&(year as u16).to_le_bytes());
    let parts = [month, day, weekday(year, month, day), hour, minute, second];
    for (byte, part) in bytes[2..8].iter_mut().zip(parts) {
        *byte = part as u8;
    }
    bytes[8..].copy_from_slice(&nanosecond.to_le_bytes());
    bytes
}

/// The day of the week; 1 is Sunday.
fn weekday(year: u32, month: u32, day: u32) -> u32 {
    // Sakamoto's algorithm.
    const MONTHS: [u32; 12] = [0, 3, 2, 5, 0, 3, 5, 1, 4, 6, 2, 4];
    let year = if month < 3 { year - 1 } else { year };
    (year + year / 4 - year / 100 + year / 400 + MONTHS[month as usize - 1] + day) % 7 + 1
}
