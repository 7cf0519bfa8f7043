//! Prints expressions so that every part is computed in the type that the program specifies.

use super::facts::Use;
use super::{Dialect, Printer, bits, literal, natural, number};
use crate::check::types::{Class, Elementary};
use crate::ir::{Argument, Binary, Call, Convert, Expr, Place, Scalar, Statement, Unary, What};

/// Precedence levels: the higher the level, the tighter the operator binds.
const OR: u8 = 0;
const XOR: u8 = 1;
const AND: u8 = 2;
const EQUAL: u8 = 3;
const ORDER: u8 = 4;
const SUM: u8 = 5;
const PRODUCT: u8 = 6;
const POWER: u8 = 7;
const ATOM: u8 = 9;

/// The numeric and bit conversions available in S7-SCL.
const STEP7: &str = "BOOL_TO_BYTE BOOL_TO_WORD BOOL_TO_DWORD BYTE_TO_WORD BYTE_TO_DWORD WORD_TO_DWORD INT_TO_DINT INT_TO_REAL \
    DINT_TO_REAL BOOL_TO_INT BOOL_TO_DINT BYTE_TO_BOOL BYTE_TO_CHAR BYTE_TO_INT BYTE_TO_DINT CHAR_TO_BYTE CHAR_TO_INT DINT_TO_BOOL \
    DINT_TO_BYTE DINT_TO_DWORD DINT_TO_INT DINT_TO_TIME DINT_TO_WORD DWORD_TO_BOOL DWORD_TO_BYTE DWORD_TO_DINT DWORD_TO_INT \
    DWORD_TO_REAL DWORD_TO_WORD INT_TO_BOOL INT_TO_BYTE INT_TO_CHAR INT_TO_DWORD INT_TO_WORD REAL_TO_DINT REAL_TO_DWORD REAL_TO_INT \
    TIME_TO_DINT WORD_TO_BOOL WORD_TO_BYTE WORD_TO_DINT WORD_TO_INT";

/// The text of an expression, and its precedence level.
pub(super) struct Printed {
    pub text: String,
    level: u8,
}

impl Printed {
    fn atom(text: impl Into<String>) -> Printed {
        Printed { text: text.into(), level: ATOM }
    }

    /// The text, in parentheses if its precedence level is lower than `level`.
    fn at_least(self, level: u8) -> String {
        if self.level < level { format!("({})", self.text) } else { self.text }
    }
}

impl Printer<'_> {
    /// Prints an expression as a value of this type, where the context determines the type of a constant.
    pub(super) fn value(&mut self, expr: &Expr, of: Elementary) -> Result<String, String> {
        Ok(self.expr(expr, of, true)?.text)
    }

    /// Prints an expression as a value of this type, where the context determines the type only of an integer constant.
    pub(super) fn argument(&mut self, expr: &Expr, of: Elementary) -> Result<String, String> {
        Ok(self.expr(expr, of, matches!(expr, Expr::Const(_)) && of.is_whole())?.text)
    }

    /// Converts the text of a complete value to another type with the same scalar.
    pub(super) fn as_type(&self, text: String, from: Elementary, to: Elementary) -> Result<String, String> {
        Ok(self.converted(Printed::atom(text), from, to)?.text)
    }

    /// Converts a printed value to another type with the same scalar.
    fn converted(&self, printed: Printed, from: Elementary, to: Elementary) -> Result<Printed, String> {
        if from == to {
            return Ok(printed);
        }
        self.dialect.check(to)?;
        // TIME is converted by way of an integer, CHAR by way of a bit string.
        let between = |of: Elementary| match of.class() {
            Class::Time => Some(number(of.scalar())),
            Class::Character => Some(bits(of.scalar())),
            _ => None,
        };
        if let Some(middle) = between(from).filter(|middle| *middle != to) {
            let printed = self.converted(printed, from, middle)?;
            return self.converted(printed, middle, to);
        }
        if let Some(middle) = between(to).filter(|middle| *middle != from) {
            let printed = self.converted(printed, from, middle)?;
            return self.converted(printed, middle, to);
        }
        let name = format!("{}_TO_{}", from.name(), to.name());
        if self.dialect == Dialect::Step7 && !STEP7.split_whitespace().any(|known| known == name) {
            return Err(format!("STEP 7 has no {name}; print the program for TIA Portal"));
        }
        Ok(Printed::atom(format!("{name}({})", printed.text)))
    }

    /// Prints an expression as a value of this type, which has the same scalar. If `is_bare`, the context determines
    /// the type of a constant, so the constant may be printed without one.
    fn expr(&mut self, expr: &Expr, want: Elementary, is_bare: bool) -> Result<Printed, String> {
        match expr {
            Expr::Const(value) => {
                let text = literal(*value, want, is_bare, self.dialect)?;
                let level = if text.starts_with('-') { SUM } else { ATOM };
                Ok(Printed { text, level })
            }
            Expr::Load(_, place) => {
                let (text, of) = self.place(place)?;
                let of = of.ok_or_else(|| format!("{text} is not a number"))?;
                self.converted(Printed::atom(text), of, want)
            }
            Expr::Unary(op, ty, a) => self.unary(*op, *ty, a, want),
            Expr::Binary(op, ty, a, b, _) => self.binary(*op, *ty, a, b, want),
            Expr::Convert(how, from, to, a, _) => self.convert(*how, (*from, *to), a, want),
            Expr::Select(ty, parts) => {
                let of = natural(*ty);
                let [condition, yes, no] = &**parts;
                let parts = self.list(&[(condition, Elementary::Bool), (no, of), (yes, of)], Some(1))?;
                let text = format!("SEL(G := {}, IN0 := {}, IN1 := {})", parts[0], parts[1], parts[2]);
                self.converted(Printed::atom(text), of, want)
            }
            Expr::Limit(ty, parts) => {
                let of = number(*ty);
                let [low, x, high] = &**parts;
                let parts = self.list(&[(low, of), (x, of), (high, of)], Some(0))?;
                let text = format!("LIMIT(MN := {}, IN := {}, MX := {})", parts[0], parts[1], parts[2]);
                self.converted(Printed::atom(text), of, want)
            }
            Expr::Texts(op, a, b) => {
                let (a, b) = (self.text_of(a)?, self.text_of(b)?);
                Ok(compared(*op, &a, &b))
            }
            Expr::Same(a, b) => {
                let (a, b) = (self.place(a)?.0, self.place(b)?.0);
                Ok(compared(Binary::Eq, &a, &b))
            }
            Expr::Bound { local, dimension, upper } => {
                let name = if *upper { "UPPER_BOUND" } else { "LOWER_BOUND" };
                let array = self.own(&self.scope.interface.locals[*local]);
                let text = format!("{name}(ARR := {array}, DIM := {})", dimension + 1);
                self.converted(Printed::atom(text), Elementary::DInt, want)
            }
            Expr::Now => Err("SCL cannot read the time of the call in nanoseconds".to_string()),
            Expr::After(before, value) => {
                if let Some(call) = self.value_call(before, value) {
                    let (text, of) = self.called(&call.clone())?;
                    return self.converted(Printed::atom(text), of, want);
                }
                if !self.updates(before, value) {
                    self.statements(before)?;
                }
                self.expr(value, want, is_bare)
            }
        }
    }

    fn text_of(&mut self, place: &Place) -> Result<String, String> {
        match self.constant_text(place) {
            Some(text) => Ok(text),
            None => Ok(self.place(place)?.0),
        }
    }

    /// Prints expressions, evaluated from left to right: a value is stored in a temporary if a later expression needs
    /// statements before it, which may change that value. Constants are printed without a type, except from index
    /// `together` onward if all expressions there are constants.
    pub(super) fn list(
        &mut self,
        list: &[(&Expr, Elementary)],
        together: Option<usize>,
    ) -> Result<Vec<String>, String> {
        let is_constant = |(expr, _): &(&Expr, Elementary)| matches!(expr, Expr::Const(_));
        let mut all = Vec::new();
        for (at, (expr, of)) in list.iter().enumerate() {
            let is_bare = match together {
                Some(first) if at >= first => !list[first..].iter().all(is_constant),
                _ => true,
            };
            let text = self.expr(expr, *of, is_bare)?.text;
            all.push(if list[at + 1..].iter().any(|(later, _)| self.hoists(later)) && !is_constant(&list[at]) {
                self.kept(*of, &text)
            } else {
                text
            });
        }
        Ok(all)
    }

    /// Stores a value in a new temporary and returns the temporary's name.
    pub(super) fn kept(&mut self, of: Elementary, value: &str) -> String {
        let name = self.temporary(of.name());
        let name = self.own(&name);
        self.line(&format!("{name} := {value};"));
        name
    }

    fn unary(&mut self, op: Unary, ty: Scalar, a: &Expr, want: Elementary) -> Result<Printed, String> {
        let of = match op {
            Unary::Not | Unary::Swap => bits(ty),
            _ => number(ty),
        };
        self.dialect.check(of)?;
        let is_signed = ty.is_signed() || ty.is_float();
        let printed = self.expr(a, of, false)?;
        let printed = match op {
            Unary::Neg if !is_signed => {
                let zero = literal(crate::ir::Value::new(ty, 0), of, false, self.dialect)?;
                Printed { text: format!("{zero} - {}", printed.at_least(PRODUCT)), level: SUM }
            }
            Unary::Neg => Printed { text: format!("-{}", printed.at_least(ATOM)), level: SUM },
            Unary::Not => Printed { text: format!("NOT {}", printed.at_least(ATOM)), level: ATOM - 1 },
            Unary::Abs if !is_signed => printed,
            Unary::Swap if ty.size() == 1 => printed,
            Unary::Frac if self.dialect == Dialect::Step7 => {
                return Err("STEP 7 has no FRAC; print the program for TIA Portal".to_string());
            }
            // FRAC without a suffix returns a REAL.
            Unary::Frac if ty == Scalar::F64 => Printed::atom(format!("FRAC_LREAL({})", printed.text)),
            op => Printed::atom(format!("{}({})", format!("{op:?}").to_uppercase(), printed.text)),
        };
        self.converted(printed, of, want)
    }

    fn binary(&mut self, op: Binary, ty: Scalar, a: &Expr, b: &Expr, want: Elementary) -> Result<Printed, String> {
        let (symbol, level) = match op {
            Binary::Add => ("+", SUM),
            Binary::Sub => ("-", SUM),
            Binary::Mul => ("*", PRODUCT),
            Binary::Div => ("/", PRODUCT),
            Binary::Rem => ("MOD", PRODUCT),
            Binary::Pow => ("**", POWER),
            Binary::And => ("AND", AND),
            Binary::Or => ("OR", OR),
            Binary::Xor => ("XOR", XOR),
            Binary::Eq => ("=", EQUAL),
            Binary::Ne => ("<>", EQUAL),
            Binary::Lt => ("<", ORDER),
            Binary::Le => ("<=", ORDER),
            Binary::Gt => (">", ORDER),
            Binary::Ge => (">=", ORDER),
            _ => return self.called_binary(op, ty, a, b, want),
        };
        let of = match op {
            Binary::And | Binary::Or | Binary::Xor => bits(ty),
            // Equality of bits does not depend on the type.
            Binary::Eq | Binary::Ne if ty.is_integer() && !ty.is_signed() => bits(ty),
            _ => number(ty),
        };
        self.dialect.check(of)?;
        let both_constant = matches!((a, b), (Expr::Const(_), Expr::Const(_)));
        let left = self.expr(a, of, !both_constant)?;
        let left = if self.hoists(b) && !matches!(a, Expr::Const(_)) {
            Printed::atom(self.kept(of, &left.text))
        } else {
            left
        };
        let right = self.expr(b, of, true)?;
        // Only a left operand with the same operator needs no parentheses: operations must keep their order.
        let is_chain = matches!(a, Expr::Binary(inner, ..) if *inner == op) && !op.compares() && op != Binary::Pow;
        let left = left.at_least(if is_chain { level } else { (level + 1).max(SUM) });
        let right = right.at_least((level + 1).max(SUM));
        let printed = Printed { text: format!("{left} {symbol} {right}"), level };
        if op.compares() { Ok(printed) } else { self.converted(printed, of, want) }
    }

    /// Prints a binary operation that is a function in SCL.
    fn called_binary(
        &mut self,
        op: Binary,
        ty: Scalar,
        a: &Expr,
        b: &Expr,
        want: Elementary,
    ) -> Result<Printed, String> {
        let name = format!("{op:?}").to_uppercase();
        if !op.shifts() {
            let of = number(ty);
            let parts = self.list(&[(a, of), (b, of)], Some(0))?;
            let text = format!("{name}(IN1 := {}, IN2 := {})", parts[0], parts[1]);
            return self.converted(Printed::atom(text), of, want);
        }
        let of = if op == Binary::Shr && ty.is_signed() { number(ty) } else { bits(ty) };
        if self.dialect == Dialect::Step7 {
            if of.class() == Class::Integer {
                return Err(format!(
                    "STEP 7 has no sign-preserving SHR for {}; print the program for TIA Portal",
                    of.name()
                ));
            }
            if !matches!(b, Expr::Const(_)) {
                return Err(format!(
                    "in STEP 7, the shift amount of {name} must be an INT; print the program for TIA Portal"
                ));
            }
        }
        let first = self.expr(a, of, false)?.text;
        let first = if self.hoists(b) { self.kept(of, &first) } else { first };
        let count = if self.dialect == Dialect::Tia { Elementary::UDInt } else { Elementary::DWord };
        let amount = match b {
            Expr::Const(value) => value.bits().to_string(),
            amount => self.expr(amount, count, true)?.text,
        };
        self.converted(Printed::atom(format!("{name}(IN := {first}, N := {amount})")), of, want)
    }

    fn convert(
        &mut self,
        how: Convert,
        (from, to): (Scalar, Scalar),
        a: &Expr,
        want: Elementary,
    ) -> Result<Printed, String> {
        let (source, target) = match how {
            Convert::Bits => {
                let side = |ty: Scalar| if ty.is_float() { natural(ty) } else { bits(ty) };
                (side(from), side(to))
            }
            Convert::Value if from == Scalar::Bool => {
                (Elementary::Bool, if want.is_whole() { want } else { number(to) })
            }
            Convert::Value if to == Scalar::Bool => (bits(from), Elementary::Bool),
            Convert::Value if from.is_integer() && to.is_integer() => {
                (self.whole_type(a), if want.is_whole() { want } else { number(to) })
            }
            Convert::Value => (number(from), number(to)),
            Convert::Trunc | Convert::Ceil | Convert::Floor => {
                let of = number(to);
                let printed = self.expr(a, number(from), false)?;
                let name = format!("{how:?}").to_uppercase();
                let text = match self.dialect {
                    Dialect::Tia => format!("{name}_{}({})", of.name(), printed.text),
                    Dialect::Step7 if how == Convert::Trunc && to == Scalar::I32 => format!("TRUNC({})", printed.text),
                    Dialect::Step7 => {
                        return Err(format!("STEP 7 has no {name} to {}; print the program for TIA Portal", of.name()));
                    }
                };
                return self.converted(Printed::atom(text), of, want);
            }
        };
        self.dialect.check(source)?;
        let printed = self.expr(a, source, false)?;
        let printed = self.converted(printed, source, target)?;
        self.converted(printed, target, want)
    }

    /// The integer type that a variable already has in SCL, otherwise the default one of the expression's scalar.
    fn whole_type(&mut self, expr: &Expr) -> Elementary {
        let of = match expr {
            Expr::Load(_, place) => self.place(place).ok().and_then(|(_, of)| of),
            _ => None,
        };
        let default = if expr.ty().is_signed() { number(expr.ty()) } else { natural(expr.ty()) };
        of.filter(|of| of.is_whole()).unwrap_or(default)
    }

    /// The call that returns an expression's value, if it can be printed inside the expression.
    fn value_call<'e>(&self, before: &'e [Statement], value: &Expr) -> Option<&'e Call> {
        let [Statement { what: What::Call(call), .. }] = before else { return None };
        let Expr::Load(_, taken) = value else { return None };
        let [(local, to)] = call.outputs.as_slice() else { return None };
        let is_value = self.facts.values.get(&call.function) == Some(local);
        let is_function = matches!(self.facts.uses.get(&call.function), Some(Use::Function | Use::Method));
        (to == taken && is_value && is_function && !self.needs_statements(call)).then_some(call)
    }

    /// Whether the statements only update a timer before it is read, which a CPU does automatically.
    fn updates(&self, before: &[Statement], value: &Expr) -> bool {
        let [Statement { what: What::Call(call), .. }] = before else { return false };
        let (Expr::Load(_, place), Some(instance)) = (value, &call.instance) else { return false };
        self.facts.uses.get(&call.function) == Some(&Use::System)
            && place.base == instance.base
            && place.steps.starts_with(&instance.steps)
    }

    /// Whether statements must be printed before an expression.
    pub(super) fn hoists(&self, expr: &Expr) -> bool {
        fn collect<'e>(expr: &'e Expr, all: &mut Vec<(&'e [Statement], &'e Expr)>) {
            match expr {
                Expr::After(before, value) => {
                    all.push((before, value));
                    collect(value, all);
                }
                Expr::Unary(_, _, a) | Expr::Convert(_, _, _, a, _) => collect(a, all),
                Expr::Binary(_, _, a, b, _) => {
                    collect(a, all);
                    collect(b, all);
                }
                Expr::Select(_, parts) | Expr::Limit(_, parts) => parts.iter().for_each(|part| collect(part, all)),
                _ => {}
            }
        }
        let mut afters = Vec::new();
        collect(expr, &mut afters);
        afters.into_iter().any(|(before, value)| {
            if self.updates(before, value) {
                return false;
            }
            let Some(call) = self.value_call(before, value) else { return true };
            // Its arguments may need statements, too.
            call.arguments.iter().any(|argument| matches!(argument, Argument::Value(value) if self.hoists(value)))
        })
    }
}

fn compared(op: Binary, a: &str, b: &str) -> Printed {
    let (symbol, level) = match op {
        Binary::Eq => ("=", EQUAL),
        Binary::Ne => ("<>", EQUAL),
        Binary::Lt => ("<", ORDER),
        Binary::Le => ("<=", ORDER),
        Binary::Gt => (">", ORDER),
        _ => (">=", ORDER),
    };
    Printed { text: format!("{a} {symbol} {b}"), level }
}
