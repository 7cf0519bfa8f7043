//! Dates and times of day, all computed in nanoseconds.

use super::super::Lowerer;
use super::super::convert::{binary, convert, zero};
use super::super::paths::Variable;
use super::Given;
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary, Type};
use crate::front::lexer::Span;
use crate::front::syntax;
use crate::ir::{self, Argument, At, Convert, Expr, Scalar};

const MILLISECOND: i64 = 1_000_000;
const DAY: i64 = 86_400_000 * MILLISECOND;

/// The nanoseconds from 1970-01-01 (the epoch of LDT) to 1990-01-01 (the epoch of DATE and DT).
const TO_DATE: i64 = 7305 * DAY;

/// The initial value of the clock, 2000-01-01, in nanoseconds since 1970-01-01. The library has the same value.
const START_OF_CLOCK: i64 = 10_957 * DAY;

/// A type that is computed in nanoseconds.
#[derive(Clone, Copy, PartialEq)]
enum Moment {
    /// DTL, a structure with a date and a time of day.
    Dtl,
    Of(Elementary),
}

fn constant(number: i64) -> Expr {
    Expr::Const(number.into())
}

/// A 64-bit integer operation whose right operand is a constant.
fn with(operation: ir::Binary, left: Expr, right: i64, at: At) -> Expr {
    binary(operation, Scalar::I64, left, constant(right), at)
}

impl Lowerer<'_, '_> {
    fn moment_of(&self, operand: &Operand) -> Option<Moment> {
        match operand {
            Operand::Variable(Type::Structure(structure), _) if structure.name == "DTL" => Some(Moment::Dtl),
            Operand::Value(of, _) if matches!(of.class(), Class::Date | Class::Time) => Some(Moment::Of(*of)),
            _ => None,
        }
    }

    /// A date, a time of day or a duration in nanoseconds: dates since 1970-01-01, times of day since midnight.
    fn nanoseconds(&mut self, operand: Operand, span: Span) -> Option<Expr> {
        let at = self.at(span);
        match operand {
            Operand::Variable(of, place) => {
                let passed = Argument::Reference(self.referred(place, &of, span));
                match self.of_library("DTL_TO_LDT", vec![passed], span)? {
                    Operand::Value(_, value) => Some(value),
                    _ => None,
                }
            }
            Operand::Value(of, value) => {
                let wide = convert(value, of.scalar(), Scalar::I64, Convert::Value, at);
                Some(match of {
                    Elementary::Time | Elementary::Tod => with(ir::Binary::Mul, wide, MILLISECOND, at),
                    Elementary::Date => {
                        let days = with(ir::Binary::Mul, wide, DAY, at);
                        with(ir::Binary::Add, days, TO_DATE, at)
                    }
                    Elementary::Dt => with(ir::Binary::Add, wide, TO_DATE, at),
                    _ => wide,
                })
            }
            _ => None,
        }
    }

    /// Converts nanoseconds to a moment of a type.
    fn as_moment(&mut self, nanoseconds: Expr, to: Moment, span: Span) -> Option<Operand> {
        use ir::Binary::{Add, Div, Rem, Sub};
        let at = self.at(span);
        let Moment::Of(of) = to else {
            return self.of_library("LDT_TO_DTL", vec![Argument::Value(nanoseconds)], span);
        };
        let in_day = |value: Expr| with(Rem, with(Add, with(Rem, value, DAY, at), DAY, at), DAY, at);
        let value = match of {
            Elementary::Time => with(Div, nanoseconds, MILLISECOND, at),
            Elementary::Tod => with(Div, in_day(nanoseconds), MILLISECOND, at),
            Elementary::LTod => in_day(nanoseconds),
            Elementary::Date => with(Div, with(Sub, nanoseconds, TO_DATE, at), DAY, at),
            // DT counts milliseconds.
            Elementary::Dt => {
                let milliseconds = with(Div, with(Sub, nanoseconds, TO_DATE, at), MILLISECOND, at);
                with(ir::Binary::Mul, milliseconds, MILLISECOND, at)
            }
            _ => nanoseconds,
        };
        Some(Operand::Value(of, convert(value, Scalar::I64, of.scalar(), Convert::Value, at)))
    }

    /// A moment plus or minus a duration, or the duration between two moments; `None` for any other operands.
    pub(crate) fn moments(
        &mut self,
        operator: syntax::Binary,
        left: &Operand,
        right: &Operand,
        span: Span,
    ) -> Option<Operand> {
        let is_date = |moment: Moment| {
            matches!(moment, Moment::Dtl) || matches!(moment, Moment::Of(of) if of.class() == Class::Date)
        };
        let (one, other) = (self.moment_of(left)?, self.moment_of(right)?);
        let is_difference = operator == syntax::Binary::Subtract;
        let to = match (is_date(one), is_date(other)) {
            (true, false) => one,
            (false, true) if !is_difference => other,
            (true, true) if is_difference && one == other => match one {
                Moment::Of(Elementary::Ldt | Elementary::LTod) => Moment::Of(Elementary::LTime),
                _ => Moment::Of(Elementary::Time),
            },
            _ => return None,
        };
        let left = self.nanoseconds(left.clone(), span)?;
        let right = self.nanoseconds(right.clone(), span)?;
        let operation = if is_difference { ir::Binary::Sub } else { ir::Binary::Add };
        let at = self.at(span);
        self.as_moment(binary(operation, Scalar::I64, left, right, at), to, span)
    }

    /// Two DTLs in nanoseconds, for comparison; `None` if either operand is not a DTL.
    pub(crate) fn compared_moments(&mut self, left: &Operand, right: &Operand, span: Span) -> Option<[Operand; 2]> {
        let are = [left, right].map(|operand| self.moment_of(operand) == Some(Moment::Dtl));
        if are != [true, true] {
            return None;
        }
        let left = self.nanoseconds(left.clone(), span)?;
        let right = self.nanoseconds(right.clone(), span)?;
        Some([left, right].map(|value| Operand::Value(Elementary::LInt, value)))
    }

    /// `DTL_TO_TOD` and similar; `None` if the function does not convert between two moments.
    pub(super) fn moment_conversion(&mut self, from: &str, to: &str, given: &Given) -> Option<Operand> {
        let named = |name: &str| match name {
            "DTL" => Some(Moment::Dtl),
            name => {
                Elementary::named(name).filter(|of| matches!(of.class(), Class::Date | Class::Time)).map(Moment::Of)
            }
        };
        let (from, to) = (named(from)?, named(to)?);
        let is_duration = |moment: Moment| matches!(moment, Moment::Of(of) if of.class() == Class::Time);
        if is_duration(from) && is_duration(to) {
            return None;
        }
        let is_of_day =
            |moment: Moment| is_duration(moment) || matches!(moment, Moment::Of(Elementary::Tod | Elementary::LTod));
        let help = match (is_of_day(from), is_of_day(to)) {
            (true, false) => Some("a time has no date: combine it with one, using T_COMBINE"),
            (false, _) if is_duration(to) => Some("a date is not a duration: subtract another date from it"),
            _ => None,
        };
        if help.is_some() {
            return Some(self.error(given.span, format!("there is no function {}", given.name), help));
        }
        let operand = self.argument(given, "IN", 0);
        let operand = match (self.moment_of(&operand), from, operand) {
            (_, _, Operand::Wrong(name)) => return Some(Operand::Wrong(name)),
            (Some(Moment::Dtl), Moment::Dtl, operand) => operand,
            (_, Moment::Of(of), operand) => {
                let value = self.converted(operand, of, given.span);
                Operand::Value(of, value)
            }
            (_, _, operand) => {
                let found = self.type_name(&operand);
                return Some(self.error(given.span, format!("expected DTL, found {found}"), None));
            }
        };
        let nanoseconds = self.nanoseconds(operand, given.span)?;
        self.as_moment(nanoseconds, to, given.span)
    }

    /// T_CONV: converts a duration, a date or a time of day to the type of the variable to which it is assigned.
    pub(super) fn converted_moment(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let Some(to) = expected else {
            // DTL is the only supported target that is not an elementary type.
            return match self.moment_of(&operand) {
                Some(_) => self.between(operand, Moment::Dtl, given.span),
                None if matches!(operand, Operand::Wrong(_)) => operand,
                None => self.error(given.span, "T_CONV must be assigned to a variable of the target type", None),
            };
        };
        match self.moment_of(&operand) {
            Some(_) if matches!(to.class(), Class::Date | Class::Time) => {
                self.between(operand, Moment::Of(to), given.span)
            }
            _ => match self.typed_moment(operand, given) {
                Some((from, value)) => self.explicit(value, from, to, given.span),
                None => Operand::Wrong(None),
            },
        }
    }

    fn typed_moment(&mut self, operand: Operand, given: &Given) -> Option<(Elementary, Expr)> {
        match operand {
            Operand::Value(of, value) => Some((of, value)),
            operand => self.typed(operand, None, given.span),
        }
    }

    /// A moment as a DTL.
    pub(crate) fn dtl_of(&mut self, operand: Operand, span: Span) -> Operand {
        self.between(operand, Moment::Dtl, span)
    }

    fn between(&mut self, operand: Operand, to: Moment, span: Span) -> Operand {
        let nanoseconds = self.nanoseconds(operand, span);
        nanoseconds.and_then(|value| self.as_moment(value, to, span)).unwrap_or(Operand::Wrong(None))
    }

    /// STEP 7's DT_DATE, DT_TOD and DT_DAY: the date, the time of day and the day of the week (1 is Sunday) of a DT.
    pub(super) fn part_of_moment(&mut self, given: &Given) -> Operand {
        let operand = match self.argument(given, "IN", 0) {
            Operand::Wrong(name) => return Operand::Wrong(name),
            operand => Operand::Value(Elementary::Dt, self.converted(operand, Elementary::Dt, given.span)),
        };
        match given.name {
            "DT_DATE" => self.between(operand, Moment::Of(Elementary::Date), given.span),
            "DT_TOD" => self.between(operand, Moment::Of(Elementary::Tod), given.span),
            _ => {
                let Some(nanoseconds) = self.nanoseconds(operand, given.span) else { return Operand::Wrong(None) };
                let at = self.at(given.span);
                // 1970-01-01 was a Thursday.
                let days = with(ir::Binary::Add, with(ir::Binary::Div, nanoseconds, DAY, at), 4, at);
                let day = with(ir::Binary::Add, with(ir::Binary::Rem, days, 7, at), 1, at);
                Operand::Value(Elementary::Int, convert(day, Scalar::I64, Scalar::I16, Convert::Value, at))
            }
        }
    }

    /// RD_SYS_T, RD_LOC_T and STEP 7's READ_CLK: store the clock time in a DTL, an LDT or a DT and return 0.
    pub(super) fn clock(&mut self, given: &Given) -> Operand {
        let output = given.find(if given.name == "READ_CLK" { "CDT" } else { "OUT" }, 0);
        let (_, target) = self.aside(|lowerer| output.and_then(|output| lowerer.target(output)));
        let to = match target.map(|target| target.of) {
            Some(Type::Elementary(of @ (Elementary::Ldt | Elementary::Dt))) => Moment::Of(of),
            _ => {
                let called = self
                    .compiler
                    .system_block("RD_SYS_T")
                    .and_then(|block| self.call_function(block, given.all(), given.span));
                let Some((of, place)) = called else { return Operand::Wrong(None) };
                return self.value_of(&Variable::whole(of, place), given.span);
            }
        };
        let Some(target) = output.and_then(|output| self.target(output)) else { return Operand::Wrong(None) };
        let now = with(ir::Binary::Add, Expr::Now, START_OF_CLOCK, self.at(given.span));
        if let Some(moment) = self.as_moment(now, to, given.span) {
            self.assign(&target, moment, given.span);
        }
        Operand::Value(Elementary::Int, zero(Elementary::Int))
    }

    /// T_CONV with its result at OUT.
    pub(super) fn convert_moment(&mut self, given: &Given) {
        let Some(to) = given.find("OUT", 1).and_then(|output| self.target(output)) else { return };
        let value = self.converted_moment(given, to.of.elementary());
        self.assign(&to, value, given.span);
    }

    /// `T_COMBINE`: combines a date and a time of day into a DTL.
    pub(super) fn combined(&mut self, given: &Given) -> Operand {
        let (date, time) = (self.argument(given, "IN1", 0), self.argument(given, "IN2", 1));
        match self.moments(syntax::Binary::Add, &date, &time, given.span) {
            _ if matches!(date, Operand::Wrong(_)) || matches!(time, Operand::Wrong(_)) => Operand::Wrong(None),
            None => {
                let (date, time) = (self.nanoseconds(date, given.span), self.nanoseconds(time, given.span));
                let (Some(date), Some(time)) = (date, time) else { return Operand::Wrong(None) };
                let sum = binary(ir::Binary::Add, Scalar::I64, date, time, self.at(given.span));
                self.as_moment(sum, Moment::Dtl, given.span).unwrap_or(Operand::Wrong(None))
            }
            Some(_) => self.error(given.span, format!("{} needs a DATE and a time of day", given.name), None),
        }
    }
}
