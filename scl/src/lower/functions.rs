//! Functions of the CPU.

use super::convert::{binary, convert, unary, zero};
use super::paths::Variable;
use super::{Lowerer, Operand};
use crate::lexer::Span;
use crate::program::{self, Binary, Convert, Expr, For, Place, Scalar, Step, Unary, Value, What};
use crate::syntax::{Argument, ExpressionId, ExpressionKind};
use crate::types::{Class, Elementary, Type};

/// So many inputs has MIN, MAX or MUX.
const MOST_INPUTS: usize = 32;

/// Functions that need the hardware or the system, by the beginning of their names.
const HARDWARE: [&str; 40] = [
    "T_CONFIG",
    "TSEND",
    "TRCV",
    "TCON",
    "TDISCON",
    "TURCV",
    "TUSEND",
    "T_RESET",
    "T_DIAG",
    "TMAIL",
    "MB_",
    "MODBUS",
    "PUT",
    "GET_ERR",
    "GET",
    "MC_",
    "RDREC",
    "WRREC",
    "DPRD_DAT",
    "DPWR_DAT",
    "STP",
    "GETIO",
    "SETIO",
    "RALRM",
    "D_ACT_DP",
    "LED",
    "DEVICESTATES",
    "MODULESTATES",
    "DEVICE",
    "RE_TRIGR",
    "SET_CINT",
    "ATTACH",
    "DETACH",
    "DATALOG",
    "FILE",
    "PROGRAM_ALARM",
    "GEN_",
    "CTRL_HSC",
    "CTRL_PWM",
    "P2P",
];

/// Functions whose name may be followed by the type of their value: `LIMIT_REAL`.
const TYPED: [&str; 21] = [
    "ABS", "MIN", "MAX", "LIMIT", "SEL", "MUX", "SQR", "SQRT", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ASIN", "ACOS",
    "ATAN", "SHL", "SHR", "ROL", "ROR",
];

/// Functions that work on memory or pointers.
const POINTERS: [&str; 22] = [
    "PEEK",
    "PEEK_BOOL",
    "PEEK_WORD",
    "PEEK_DWORD",
    "POKE",
    "POKE_BLK",
    "POKE_BOOL",
    "BLKMOV",
    "UBLKMOV",
    "FILL",
    "MOVE_BLK_VARIANT",
    "SERIALIZE",
    "DESERIALIZE",
    "VARIANTGET",
    "VARIANTPUT",
    "TYPEOF",
    "TYPEOFELEMENTS",
    "COUNTOFELEMENTS",
    "IS_ARRAY",
    "READ_DBL",
    "WRIT_DBL",
    "CREATE_DB",
];

/// Functions of texts and of the clock, which do not exist here yet.
const LATER: [&str; 30] = [
    "S_CONV",
    "S_COMP",
    "S_MOVE",
    "STRG_VAL",
    "VAL_STRG",
    "STRG_TO_CHARS",
    "CHARS_TO_STRG",
    "JOIN",
    "SPLIT",
    "ATH",
    "HTA",
    "WR_SYS_T",
    "WR_LOC_T",
    "T_CONV",
    "T_COMBINE",
    "SET_TIMEZONE",
    "SCATTER",
    "GATHER",
    "SCATTER_BLK",
    "GATHER_BLK",
    "DECO",
    "ENCO",
    "CTRL",
    "BITSUM",
    "PARITY",
    "SEG",
    "LTD",
    "CALCULATE",
    "RD_SINFO",
    "TIME_TO_S5TIME",
];

/// Why a function or a type is refused, and what to do; `None` if it is not known to be.
pub fn refused(name: &str) -> Option<(String, String)> {
    if name.starts_with("PID_") {
        let available = crate::library::natives().join(", ");
        return Some((
            format!("{name} is not supported"),
            format!("its law is not published; available are {available}"),
        ));
    }
    if POINTERS.contains(&name) {
        let help = "a pointer of this kind has no type here; assign the variables themselves";
        return Some((format!("{name} is not supported"), help.into()));
    }
    if LATER.contains(&name) {
        let help = "compute it outside of the program and feed it through an input";
        return Some((format!("{name} is not supported"), help.into()));
    }
    if HARDWARE.iter().any(|hardware| {
        name == *hardware
            || hardware.len() > 3 && name.starts_with(hardware)
            || hardware.ends_with('_') && name.starts_with(hardware)
    }) {
        let message = format!("{name} talks to the PLC's hardware or system");
        return Some((message, "make its values inputs".into()));
    }
    if matches!(name, "S_ODT" | "S_ODTS" | "S_OFFDT" | "S_PULSE" | "S_PEXT" | "S_CU" | "S_CD" | "S_CUD") {
        return Some((
            format!("{name} is not supported"),
            "S5 timers: use TON, TOF or TP; S5 counters: use CTU, CTD or CTUD".into(),
        ));
    }
    None
}

/// The arguments of a function of the CPU.
struct Given<'a> {
    arguments: &'a [Argument],
    name: &'a str,
    span: Span,
}

impl Given<'_> {
    /// The argument of this name, or at this position if none has a name.
    fn find(&self, name: &str, position: usize) -> Option<ExpressionId> {
        let is_it = |argument: &&Argument| argument.name.as_ref().is_some_and(|given| given.key() == name);
        let by_name = self.arguments.iter().find(is_it);
        let by_position = self.arguments.get(position).filter(|argument| argument.name.is_none());
        by_name.or(by_position).map(|argument| argument.value)
    }
}

impl Lowerer<'_, '_> {
    /// The value of a function of the CPU; `None` if there is no such function.
    pub fn function(
        &mut self,
        name: &str,
        arguments: &[Argument],
        expected: Option<Elementary>,
        span: Span,
    ) -> Option<Operand> {
        let given = Given { arguments, name, span };
        if let Some((from, to)) = name.split_once("_TO_") {
            return self.conversion(from, to, &given);
        }
        if let Some(to) = name.strip_prefix("TO_").and_then(Elementary::named) {
            return Some(self.conversion_of(None, to, &given));
        }
        let (base, suffix) = match name.rsplit_once('_') {
            Some((base, suffix)) => (base, Elementary::named(suffix)),
            None => (name, None),
        };
        if let Some(of) = suffix.filter(|_| TYPED.contains(&base)) {
            let operand = self.function(base, arguments, Some(of), span)?;
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
            return Some(self.float_function(operation, &given, expected));
        }
        let operand = match (name, base) {
            ("__NOW", _) if self.file == self.compiler.library_file() => Operand::Value(Elementary::LInt, Expr::Now),
            ("ABS", _) => self.absolute(&given),
            ("SQR", _) => self.square(&given, expected),
            ("MIN" | "MAX", _) => self.extreme(&given, expected),
            ("LIMIT", _) => self.limited(&given, expected),
            ("SEL", _) => self.selected(&given, expected),
            ("MUX", _) => self.multiplexed(&given, expected),
            ("SHL" | "SHR" | "ROL" | "ROR", _) => self.shifted(&given, expected),
            ("SWAP", _) => self.swapped(&given, expected),
            ("NORM_X", _) | (_, "NORM_X") => self.normed(&given, suffix.or(expected)),
            ("SCALE_X", _) | (_, "SCALE_X") => self.scaled(&given, suffix.or(expected)),
            ("ROUND" | "TRUNC" | "CEIL" | "FLOOR", _) => self.rounded(name, &given, expected),
            (_, "ROUND" | "TRUNC" | "CEIL" | "FLOOR") if suffix.is_some() => self.rounded(base, &given, suffix),
            ("FRAC", _) | (_, "FRAC") => self.fraction(&given, suffix.or(expected)),
            ("T_ADD" | "T_SUB" | "T_DIFF", _) => {
                let operator =
                    if name == "T_ADD" { crate::syntax::Binary::Add } else { crate::syntax::Binary::Subtract };
                let left = self.argument(&given, "IN1", 0);
                let right = self.argument(&given, "IN2", 1);
                self.binary(operator, left, right, span)
            }
            ("LOWER_BOUND" | "UPPER_BOUND", _) => self.bound(&given),
            ("TIME_TCK", _) => {
                let at = self.at(span);
                let milliseconds = binary(Binary::Div, Scalar::I64, Expr::Now, Expr::Const(1_000_000i64.into()), at);
                let low = binary(Binary::And, Scalar::I64, milliseconds, Expr::Const(i64::from(i32::MAX).into()), at);
                Operand::Value(Elementary::Time, convert(low, Scalar::I64, Scalar::I32, Convert::Value, at))
            }
            ("RUNTIME", _) => self.runtime(&given),
            ("RD_SYS_T" | "RD_LOC_T", _) => match self.compiler.system_block("RD_SYS_T") {
                Some(block) => self.value_of_function(block, arguments, span),
                None => Operand::Wrong(None),
            },
            ("MAX_LEN", _) => self.capacity(&given),
            _ if crate::library::TEXTS.contains(&name) => self.text_function(&given).unwrap_or(Operand::Wrong(None)),
            _ => {
                let (message, help) = refused(name)?;
                self.error(span, message, Some(&help))
            }
        };
        Some(operand)
    }

    /// A function of the CPU as a statement; false if there is no such function.
    pub fn statement_function(&mut self, name: &str, arguments: &[Argument], span: Span) -> bool {
        let given = Given { arguments, name, span };
        match name {
            "RESET_TIMER" | "PRESET_TIMER" => self.timer_function(&given),
            "RD_SYS_T" | "RD_LOC_T" => {
                if let Some(block) = self.compiler.system_block("RD_SYS_T") {
                    self.call_function(block, arguments, span);
                }
            }
            "MOVE_BLK" | "UMOVE_BLK" | "FILL_BLK" | "UFILL_BLK" => self.block_of_elements(&given),
            _ => match self.function(name, arguments, None, span) {
                Some(Operand::Wrong(_)) => {}
                Some(_) => {
                    self.warn(span, format!("the value of {name} is not used"), Some("assign it to a variable"));
                }
                None => return false,
            },
        }
        true
    }

    /// An argument; a message tells if it is missing.
    fn argument(&mut self, given: &Given, name: &str, position: usize) -> Operand {
        match given.find(name, position) {
            Some(id) => self.operand(id, None),
            None => self.error(given.span, format!("{} is called without {name}", given.name), None),
        }
    }

    fn argument_span(&self, given: &Given, name: &str, position: usize) -> Span {
        given.find(name, position).map_or(given.span, |id| self.span(id))
    }

    /// An argument as a number of its own type, or of the one that a number without a type takes.
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

    /// `INT_TO_REAL(x)`.
    fn conversion(&mut self, from: &str, to: &str, given: &Given) -> Option<Operand> {
        let bcd = |name: &str| name.contains("BCD") || matches!(name, "S5TIME" | "BLOCK_DB");
        if bcd(from) || bcd(to) {
            let message = format!("{} is not supported", given.name);
            return Some(self.error(given.span, message, Some("BCD and S5TIME: work with INT and TIME")));
        }
        let is_text = |name: &str| matches!(name, "STRING" | "WSTRING" | "CHARS" | "STRG");
        let is_date = |name: &str| matches!(name, "DTL" | "DT" | "LDT" | "DATE" | "TOD" | "LTOD");
        if is_text(from) || is_text(to) || is_date(from) != is_date(to) {
            let message = format!("{} is not supported", given.name);
            return Some(self.error(
                given.span,
                message,
                Some("compute it outside of the program and feed it through an input"),
            ));
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

    fn float_function(&mut self, operation: Unary, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let span = self.argument_span(given, "IN", 0);
        let of = match &operand {
            Operand::Value(Elementary::LReal, _) => Elementary::LReal,
            Operand::Value(Elementary::Real, _) => Elementary::Real,
            Operand::Wrong(_) => return Operand::Wrong(None),
            _ => expected.filter(|of| of.class() == Class::Real).unwrap_or_else(|| self.widest_real()),
        };
        let value = self.converted(operand, of, span);
        Operand::Value(of, unary(operation, of.scalar(), value))
    }

    fn absolute(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Whole(whole) => Operand::Whole(whole.abs()),
            Operand::Fraction(wide, narrow) => Operand::Fraction(wide.abs(), narrow.abs()),
            Operand::Value(of, value) if of.is_number() || of.class() == Class::Time => {
                Operand::Value(of, unary(Unary::Abs, of.scalar(), value))
            }
            Operand::Wrong(_) => Operand::Wrong(None),
            other => {
                let found = self.type_name(&other);
                self.error(given.span, format!("ABS of {found} is not possible"), None)
            }
        }
    }

    fn square(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let expected = expected.filter(|of| of.class() == Class::Real).or(Some(self.widest_real()));
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        let to = if of.class() == Class::Real { of } else { expected.unwrap_or(of) };
        let at = self.at(given.span);
        let value = convert(value, of.scalar(), to.scalar(), Convert::Value, at);
        let (code, (place, _)) = self.aside(|lowerer| lowerer.kept(to, value, given.span));
        let load = || Box::new(Expr::Load(to.scalar(), place.clone()));
        let product = Expr::Binary(Binary::Mul, to.scalar(), load(), load(), at);
        Operand::Value(to, Expr::After(code, Box::new(product)))
    }

    /// A value in a temporary, so that it is calculated once.
    fn kept(&mut self, of: Elementary, value: Expr, span: Span) -> (Place, Expr) {
        let temp = self.temp(program::Type::Scalar(of.scalar()));
        self.push(span, What::Assign(temp.clone(), value));
        (temp.clone(), Expr::Load(of.scalar(), temp))
    }

    /// The type in which all of these are compared or chosen.
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
                self.error(span, format!("{} have no type in common", names.join(" and ")), None);
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

    /// An operand widened to a common type.
    fn quietly(&mut self, operand: Operand, to: Elementary, span: Span) -> Expr {
        match operand {
            Operand::Value(from, value) if from.is_number() && to.is_number() => {
                let at = self.at(span);
                convert(value, from.scalar(), to.scalar(), Convert::Value, at)
            }
            other => self.converted(other, to, span),
        }
    }

    fn extreme(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operation = if given.name == "MIN" { Binary::Min } else { Binary::Max };
        let operands: Vec<Operand> =
            given.arguments.iter().map(|argument| self.operand(argument.value, None)).collect();
        if !(2..=MOST_INPUTS).contains(&operands.len()) {
            return self.error(given.span, format!("{} has 2 to 32 inputs", given.name), None);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let at = self.at(given.span);
        let values = self.all(operands, of, given.span);
        let value = values.into_iter().reduce(|one, other| binary(operation, of.scalar(), one, other, at));
        value.map_or(Operand::Wrong(None), |value| Operand::Value(of, value))
    }

    fn limited(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MN", "IN", "MX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let values = self.all(operands, of, given.span);
        match <[Expr; 3]>::try_from(values) {
            Ok(values) => Operand::Value(of, Expr::Limit(of.scalar(), Box::new(values))),
            Err(_) => Operand::Wrong(None),
        }
    }

    fn selected(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let condition = self.argument(given, "G", 0);
        let condition = self.condition(condition, given.span);
        let operands = vec![self.argument(given, "IN0", 1), self.argument(given, "IN1", 2)];
        if let [Operand::Text(..) | Operand::Variable(..), Operand::Text(..) | Operand::Variable(..)] =
            operands.as_slice()
        {
            return self.selected_variable(condition, operands, given.span);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let mut values = self.all(operands, of, given.span).into_iter();
        let (Some(no), Some(yes)) = (values.next(), values.next()) else { return Operand::Wrong(None) };
        Operand::Value(of, Expr::Select(of.scalar(), Box::new([condition, yes, no])))
    }

    /// SEL of two texts or structures: a copy of one of them.
    fn selected_variable(&mut self, condition: Expr, operands: Vec<Operand>, span: Span) -> Operand {
        let of = operands.iter().find_map(|operand| match operand {
            Operand::Variable(of, _) => Some(of.clone()),
            _ => None,
        });
        let of = of.unwrap_or(Type::Text { capacity: 254, wide: false });
        let chosen = Variable::whole(of.clone(), self.temp(self.compiler.lowered(&of)));
        let mut branches =
            operands.into_iter().map(|operand| self.aside(|lowerer| lowerer.assign(&chosen, operand, span)).0);
        let (no, yes) = (branches.next().unwrap_or_default(), branches.next().unwrap_or_default());
        drop(branches);
        self.push(span, What::If(condition, yes, no));
        Operand::Variable(of, chosen.place)
    }

    fn multiplexed(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let number = self.argument(given, "K", 0);
        let Some((of_number, number)) = self.typed(number, Some(Elementary::DInt), given.span) else {
            return Operand::Wrong(None);
        };
        let mut operands = Vec::new();
        while operands.len() < MOST_INPUTS
            && let Some(id) = given.find(&format!("IN{}", operands.len()), operands.len() + 1)
        {
            operands.push(self.operand(id, None));
        }
        let otherwise = given.find("INELSE", usize::MAX).map(|id| self.operand(id, None));
        let has_otherwise = otherwise.is_some();
        operands.extend(otherwise);
        if operands.is_empty() {
            return self.error(given.span, "MUX is called without IN0", None);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let mut values = self.all(operands, of, given.span);
        let at = self.at(given.span);
        let mut value = if has_otherwise { values.pop().unwrap_or(zero(of)) } else { zero(of) };
        let (code, (_, number)) = self.aside(|lowerer| lowerer.kept(of_number, number, given.span));
        for (index, input) in values.into_iter().enumerate().rev() {
            let this = Expr::Const(Value::new(of_number.scalar(), index as u64));
            let is_this = binary(Binary::Eq, of_number.scalar(), number.clone(), this, at);
            value = Expr::Select(of.scalar(), Box::new([is_this, input, value]));
        }
        Operand::Value(of, Expr::After(code, Box::new(value)))
    }

    fn shifted(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operation = match given.name {
            "SHL" => Binary::Shl,
            "SHR" => Binary::Shr,
            "ROL" => Binary::Rol,
            _ => Binary::Ror,
        };
        let operand = self.argument(given, "IN", 0);
        let expected = expected.filter(|of| of.is_whole());
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        let amount = self.argument(given, "N", 1);
        let span = self.argument_span(given, "N", 1);
        let Some((of_amount, amount)) = self.typed(amount, Some(Elementary::UDInt), span) else {
            return Operand::Wrong(None);
        };
        if !of.is_whole() || !of_amount.is_whole() {
            let name = given.name;
            return self.error(given.span, format!("{name} shifts bit strings and integers by an integer"), None);
        }
        let at = self.at(given.span);
        let amount = convert(amount, of_amount.scalar(), Scalar::U32, Convert::Value, at);
        Operand::Value(of, binary(operation, of.scalar(), value, amount, at))
    }

    fn swapped(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        if !of.is_whole() {
            return self.error(given.span, format!("SWAP of {} is not possible", of.name()), None);
        }
        Operand::Value(of, unary(Unary::Swap, of.scalar(), value))
    }

    /// The floating-point type of an operation on these.
    fn real_of(&self, operands: &[Operand], expected: Option<Elementary>) -> Elementary {
        let is_wide = operands.iter().any(|operand| matches!(operand, Operand::Value(Elementary::LReal, _)));
        if is_wide || expected == Some(Elementary::LReal) { Elementary::LReal } else { Elementary::Real }
    }

    fn normed(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MIN", "VALUE", "MAX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let of = self.real_of(&operands, expected);
        let at = self.at(given.span);
        let values: Vec<Expr> = self.all(operands, of, given.span);
        let (code, [low, value, high]) = self.aside(|lowerer| lowerer.kept_all(of, values, given.span));
        let scalar = of.scalar();
        let above = binary(Binary::Sub, scalar, value, low.clone(), at);
        let range = binary(Binary::Sub, scalar, high, low, at);
        Operand::Value(of, Expr::After(code, Box::new(binary(Binary::Div, scalar, above, range, at))))
    }

    fn kept_all(&mut self, of: Elementary, values: Vec<Expr>, span: Span) -> [Expr; 3] {
        let mut kept = values
            .into_iter()
            .map(|value| if matches!(value, Expr::Const(_)) { value } else { self.kept(of, value, span).1 });
        [(); 3].map(|()| kept.next().unwrap_or(zero(of)))
    }

    fn scaled(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MIN", "VALUE", "MAX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let limits = [&operands[0], &operands[2]];
        let of_limits = limits.iter().find_map(|operand| match operand {
            Operand::Value(of, _) => Some(*of),
            _ => None,
        });
        let of = self.real_of(&operands, expected);
        let to = expected.or(of_limits).filter(|to| to.is_number()).unwrap_or(of);
        let at = self.at(given.span);
        let values: Vec<Expr> = self.all(operands, of, given.span);
        let (code, [low, value, high]) = self.aside(|lowerer| lowerer.kept_all(of, values, given.span));
        let scalar = of.scalar();
        let range = binary(Binary::Sub, scalar, high, low.clone(), at);
        let product = binary(Binary::Mul, scalar, value, range, at);
        let sum = binary(Binary::Add, scalar, product, low, at);
        let result = convert(Expr::After(code, Box::new(sum)), scalar, to.scalar(), Convert::Value, at);
        Operand::Value(to, result)
    }

    fn rounded(&mut self, name: &str, given: &Given, expected: Option<Elementary>) -> Operand {
        let how = match name {
            "ROUND" => Convert::Value,
            "TRUNC" => Convert::Trunc,
            "CEIL" => Convert::Ceil,
            _ => Convert::Floor,
        };
        let operand = self.argument(given, "IN", 0);
        let Some((from, value)) = self.typed(operand, None, given.span) else { return Operand::Wrong(None) };
        let to = expected.filter(|to| to.is_number()).unwrap_or(Elementary::DInt);
        let at = self.at(given.span);
        let value = match from.class() {
            Class::Real => value,
            Class::Integer | Class::Bits => convert(value, from.scalar(), Scalar::F64, Convert::Value, at),
            _ => return self.error(given.span, format!("{name} of {} is not possible", from.name()), None),
        };
        let from = if from.class() == Class::Real { from.scalar() } else { Scalar::F64 };
        if to.class() == Class::Real {
            let whole = convert(value, from, Scalar::I64, how, at);
            return Operand::Value(to, convert(whole, Scalar::I64, to.scalar(), Convert::Value, at));
        }
        Operand::Value(to, convert(value, from, to.scalar(), how, at))
    }

    fn fraction(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let of = self.real_of(std::slice::from_ref(&operand), expected);
        let value = self.converted(operand, of, given.span);
        Operand::Value(of, unary(Unary::Frac, of.scalar(), value))
    }

    fn bound(&mut self, given: &Given) -> Operand {
        let array = self.argument(given, "ARR", 0);
        let dimension = given.find("DIM", 1).and_then(|id| self.whole(id));
        let is_upper = given.name == "UPPER_BOUND";
        let number =
            dimension.and_then(|dimension| usize::try_from(dimension).ok()).filter(|dimension| *dimension >= 1);
        match (array, number) {
            (Operand::Variable(Type::Array(array), _), Some(number)) if number <= array.bounds.len() => {
                let (low, high) = array.bounds[number - 1];
                Operand::Value(Elementary::DInt, Expr::Const(if is_upper { high } else { low }.into()))
            }
            (Operand::Variable(Type::Open(_, dimensions), place), Some(number)) if number <= dimensions => {
                let program::Base::Local(local) = place.base else { return Operand::Wrong(None) };
                let bound = Expr::Bound { local, dimension: number - 1, upper: is_upper };
                Operand::Value(Elementary::DInt, bound)
            }
            (Operand::Wrong(_), _) | (_, None) => Operand::Wrong(None),
            (_, Some(_)) => self.error(given.span, format!("{} is for the dimensions of an array", given.name), None),
        }
    }

    fn runtime(&mut self, given: &Given) -> Operand {
        let Some(block) = self.compiler.system_block("RUNTIME") else { return Operand::Wrong(None) };
        let Some(id) = given.find("MEM", 0) else {
            return self.error(given.span, "RUNTIME is called without MEM", None);
        };
        let Some(memory) = self.target(id) else { return Operand::Wrong(None) };
        if memory.of != Type::Elementary(Elementary::LReal) {
            return self.error(self.span(id), "the memory of RUNTIME is an LREAL", None);
        }
        let function = self.compiler.blocks[block].function;
        let result = self.temp(program::Type::Scalar(Scalar::F64));
        let value = Expr::Load(Scalar::F64, memory.place.clone());
        let call = program::Call {
            function,
            instance: None,
            arguments: vec![program::Argument::Value(value)],
            outputs: vec![(0, memory.place), (self.value_local(function), result.clone())],
        };
        let (code, ()) = self.aside(|lowerer| lowerer.push(given.span, What::Call(call)));
        Operand::Value(Elementary::LReal, Expr::After(code, Box::new(Expr::Load(Scalar::F64, result))))
    }

    /// The local with the value of a function: it has the function's name.
    fn value_local(&self, function: usize) -> usize {
        let function = &self.compiler.program.functions[function];
        function.locals.iter().position(|local| local.name.eq_ignore_ascii_case(&function.name)).unwrap_or(0)
    }

    /// A function of texts, of which the library has one for two texts.
    fn text_function(&mut self, given: &Given) -> Option<Operand> {
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
    fn capacity(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Variable(Type::Text { capacity, .. }, _) => {
                Operand::Value(Elementary::DInt, Expr::Const(i32::from(capacity).into()))
            }
            Operand::Wrong(name) => Operand::Wrong(name),
            _ => self.error(given.span, "MAX_LEN is for texts", None),
        }
    }

    fn timer_function(&mut self, given: &Given) {
        let Some(id) = given.find("TIMER", if given.name == "RESET_TIMER" { 0 } else { 1 }) else {
            self.error(given.span, format!("{} is called without TIMER", given.name), None);
            return;
        };
        let Some(Variable { of: Type::Instance(block), place, .. }) = self.target(id) else { return };
        if !self.compiler.is_timer(block) {
            self.error(self.span(id), "this is no timer", None);
            return;
        }
        let members = self.compiler.blocks[block].members.clone();
        let slot = |member: &crate::declare::Parameter| match member.slot {
            crate::declare::Slot::Member(number) => number,
            crate::declare::Slot::Local(_) => 0,
        };
        if given.name == "RESET_TIMER" {
            for member in &members {
                if let Type::Elementary(of) = member.of {
                    self.push(given.span, What::Assign(place.clone().member(slot(member)), zero(of)));
                }
            }
            return;
        }
        let time = self.argument(given, "PT", 0);
        let of = |key: &str| members.iter().find(|member| member.key == key);
        let (Some(pt), Some(held)) = (of("PT"), of("HELD")) else { return };
        let Type::Elementary(elementary) = pt.of else { return };
        let value = self.converted(time, elementary, given.span);
        let at = self.at(given.span);
        let pt = place.clone().member(slot(pt));
        self.push(given.span, What::Assign(pt.clone(), value));
        let wide = convert(Expr::Load(elementary.scalar(), pt), elementary.scalar(), Scalar::I64, Convert::Value, at);
        let value = binary(Binary::Max, Scalar::I64, wide, Expr::Const(0i64.into()), at);
        self.push(given.span, What::Assign(place.member(slot(held)), value));
    }

    /// MOVE_BLK, FILL_BLK: element by element.
    fn block_of_elements(&mut self, given: &Given) {
        let is_fill = given.name.contains("FILL");
        let (Some(input), Some(count), Some(output)) =
            (given.find("IN", 0), given.find("COUNT", 1), given.find("OUT", 2))
        else {
            self.error(given.span, format!("{} is called without IN, COUNT or OUT", given.name), None);
            return;
        };
        let is_element =
            |lowerer: &Self, id: ExpressionId| matches!(lowerer.expressions()[id].kind, ExpressionKind::Index(..));
        if !is_element(self, output) || !is_fill && !is_element(self, input) {
            let help = "write the first element: #a[0]";
            self.error(given.span, format!("{} copies from and to the elements of an array", given.name), Some(help));
            return;
        }
        let operand = self.operand(count, Some(Elementary::DInt));
        let count = self.quietly(operand, Elementary::DInt, given.span);
        let Some(mut to) = self.target(output) else { return };
        to.place = self.frozen(to.place, given.span);
        let from = if is_fill { None } else { self.target(input) };
        let from = from.map(|from| Variable { place: self.frozen(from.place.clone(), given.span), ..from });
        if !is_fill && from.is_none() {
            return;
        }
        let fill = if is_fill { Some(self.operand(input, to.of.elementary())) } else { None };
        let number = self.temp(program::Type::Scalar(Scalar::I32));
        let at = self.at(given.span);
        let moved = |variable: &Variable| {
            let mut variable = variable.clone();
            if let Some(Step::Index(indices, _)) = variable.place.steps.last_mut()
                && let Some(index) = indices.last_mut()
            {
                let of = index.ty();
                let number = convert(Expr::Load(Scalar::I32, number.clone()), Scalar::I32, of, Convert::Value, at);
                let first = std::mem::replace(index, Expr::Const(0i32.into()));
                *index = binary(Binary::Add, of, first, number, at);
            }
            variable
        };
        let (body, ()) = self.aside(|lowerer| {
            let target = moved(&to);
            let value = match (&from, fill) {
                (Some(from), _) => lowerer.value_of(&moved(from), given.span),
                (None, Some(fill)) => fill,
                (None, None) => return,
            };
            lowerer.assign(&target, value, given.span);
        });
        let last = binary(Binary::Sub, Scalar::I32, count, Expr::Const(1i32.into()), at);
        let first = Expr::Const(0i32.into());
        let step = Expr::Const(1i32.into());
        self.push(given.span, What::For(Box::new(For { variable: number, first, last, step, body })));
    }
}

/// 0 of a type, from which nothing is concluded.
fn zero_of(of: Elementary) -> Expr {
    Expr::After(Vec::new(), Box::new(zero(of)))
}
