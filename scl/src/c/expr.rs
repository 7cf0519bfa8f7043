//! Prints expressions and places.

use super::facts::{self, is_quiet};
use super::{Printer, line, scalar};
use crate::ir::walk::{self, Look, runs_statements};
use crate::ir::{Base, Binary, Convert, Expr, Place, Scalar, Step, Type, Unary, Value};

impl Printer<'_> {
    /// Returns an expression as C text, after printing the statements that must run before it.
    pub(super) fn expr(&mut self, expr: &Expr) -> Result<String, String> {
        Ok(match expr {
            Expr::Const(value) => constant(*value),
            Expr::Load(_, place) => self.place(place)?,
            Expr::Unary(op, ty, a) => {
                let a = self.expr(a)?;
                match (op, ty) {
                    (Unary::Not, Scalar::Bool) => format!("!{a}"),
                    (Unary::Abs, ty) if ty.is_integer() && !ty.is_signed() => a,
                    (Unary::Neg, ty) if ty.is_float() && !a.starts_with('-') => format!("-{a}"),
                    (Unary::Neg, ty) if ty.is_float() => format!("-({a})"),
                    _ => format!("{}_{ty}({})", format!("{op:?}").to_lowercase(), bare(&a)),
                }
            }
            Expr::Binary(op, ty, left, right, _) => {
                let is_logic = *ty == Scalar::Bool && matches!(op, Binary::And | Binary::Or);
                let is_lazy = is_logic && is_quiet(right, &self.facts) && !self.scope.counts;
                let parts = self.exprs(&[&**left, &**right])?;
                let (a, b) = (&parts[0], &parts[1]);
                match (symbol(*op), ty) {
                    _ if is_lazy && *op == Binary::And => format!("({a} && {b})"),
                    _ if is_lazy => format!("({a} || {b})"),
                    (_, Scalar::Bool) if *op == Binary::Eq => format!("(!{a} == !{b})"),
                    (_, Scalar::Bool) if matches!(op, Binary::Xor | Binary::Ne) => format!("(!{a} != !{b})"),
                    (Some((symbol, true)), _) => format!("({a} {symbol} {b})"),
                    (Some((symbol, _)), Scalar::F32 | Scalar::F64) => format!("({a} {symbol} {b})"),
                    _ if *op == Binary::Ne && ty.is_integer() => format!("({a} != {b})"),
                    _ => format!("{}_{ty}({}, {})", format!("{op:?}").to_lowercase(), bare(a), bare(b)),
                }
            }
            Expr::Convert(how, from, to, a, _) => {
                let a = self.expr(a)?;
                converted(*how, *from, *to, &a)
            }
            Expr::Select(_, parts) if !self.scope.counts && parts.iter().all(|part| is_quiet(part, &self.facts)) => {
                let parts = self.exprs(&parts.each_ref())?;
                format!("({} ? {} : {})", parts[0], bare(&parts[1]), bare(&parts[2]))
            }
            Expr::Select(ty, parts) => format!("select_{ty}({})", self.joined(&parts.each_ref())?),
            Expr::Limit(ty, parts) => format!("limit_{ty}({})", self.joined(&parts.each_ref())?),
            Expr::Texts(op, a, b) => {
                let (first, second) = (self.type_of(a)?, self.type_of(b)?);
                let (Type::Text { capacity: p, wide }, Type::Text { capacity: q, .. }) = (first, second) else {
                    return Err("only strings can be compared as strings".to_string());
                };
                let (a, b) = self.addresses(a, b)?;
                let symbol = symbol(*op).map_or("==", |(symbol, _)| symbol);
                let symbol = if *op == Binary::Ne { "!=" } else { symbol };
                format!("(compare_text({a}, {p}u, {b}, {q}u, {}) {symbol} 0)", 1 + u8::from(wide))
            }
            Expr::Same(a, b) => {
                let ty = self.type_of(a)?;
                let (a, b) = self.addresses(a, b)?;
                let mut parts = Vec::new();
                self.same(&ty, 0, &a, &b, &mut parts)?;
                format!("({})", if parts.is_empty() { "1".to_string() } else { parts.join(" && ") })
            }
            Expr::Bound { local, dimension, upper } => {
                self.scope.locals[*local].has_named_bounds = true;
                format!("{}_bounds[{}]", self.scope.locals[*local].name, 2 * dimension + usize::from(*upper))
            }
            Expr::Now => format!("{}->now", self.argument("call")),
            Expr::After(before, value) => {
                if let Some((call, local)) = facts::taken(expr, &self.facts)
                    && self.scope.locals[local].is_elided
                {
                    return self.called(call);
                }
                self.statements(before)?;
                self.expr(value)?
            }
        })
    }

    /// The whole value of a statement as C text: without outer parentheses, and cast to `u8_t` if it is a truth value
    /// that has type `int` in C.
    pub(super) fn whole(&mut self, expr: &Expr) -> Result<String, String> {
        let text = self.expr(expr)?;
        let text = bare(&text);
        Ok(if is_int(expr) { format!("(u8_t)({text})") } else { text.to_string() })
    }

    /// Expressions as C text, separated by commas.
    fn joined(&mut self, list: &[&Expr]) -> Result<String, String> {
        let parts = self.exprs(list)?;
        Ok(parts.iter().map(|part| bare(part)).collect::<Vec<_>>().join(", "))
    }

    /// Expressions as C text. One that must be evaluated before a later one is stored in a temporary.
    pub(super) fn exprs(&mut self, list: &[&Expr]) -> Result<Vec<String>, String> {
        let mut printed = Vec::new();
        for (number, expr) in list.iter().enumerate() {
            let text = self.expr(expr)?;
            let is_before = list[number + 1..].iter().any(|later| self.comes_before(expr, self.of_expr(later)));
            printed.push(if is_before { self.kept(expr.ty(), &text) } else { text });
        }
        Ok(printed)
    }

    /// Whether an expression must be evaluated before later code: statements there may change its value, or both may
    /// stop the call, and C does not specify the order in which operands are evaluated.
    pub(super) fn comes_before(&self, expr: &Expr, later: Effect) -> bool {
        !matches!(expr, Expr::Const(_)) && (later.runs || later.stops && self.of_expr(expr).stops)
    }

    /// The side effects of evaluating an expression.
    pub(super) fn of_expr(&self, expr: &Expr) -> Effect {
        struct Finds<'a>(&'a Printer<'a>, bool);
        impl Look for Finds<'_> {
            fn expr(&mut self, it: &Expr) {
                self.1 |= match it {
                    Expr::Load(_, place) => self.0.is_checked(place),
                    Expr::Texts(_, a, b) | Expr::Same(a, b) => self.0.is_checked(a) || self.0.is_checked(b),
                    _ => false,
                };
            }
        }
        let mut finds = Finds(self, false);
        walk::expr(expr, &mut finds);
        Effect { runs: self.runs(expr), stops: finds.1 }
    }

    /// The side effects of resolving a place.
    pub(super) fn of_place(&self, place: &Place) -> Effect {
        let indices = self.indices(place);
        Effect {
            runs: indices.iter().any(|(index, _)| self.runs(index)),
            stops: indices.iter().any(|(_, is_checked)| *is_checked),
        }
    }

    /// Whether a place has an index that is checked at run time, so that it may resolve to different variables at
    /// different times.
    pub(super) fn is_checked(&self, place: &Place) -> bool {
        self.indices(place).iter().any(|(_, is_checked)| *is_checked)
    }

    /// The indices of a place in order, and whether each is checked at run time.
    fn indices<'e>(&self, place: &'e Place) -> Vec<(&'e Expr, bool)> {
        let mut all = Vec::new();
        for (number, step) in place.steps.iter().enumerate() {
            let Step::Index(indices, _) = step else { continue };
            let of = Place { base: place.base, steps: place.steps[..number].to_vec() };
            let bounds = match self.type_of(&of) {
                Ok(Type::Text { capacity, .. }) => vec![(1, i32::from(capacity))],
                Ok(Type::Array { bounds, .. }) => bounds,
                _ => Vec::new(),
            };
            let is_checked = |(number, index): (usize, &'e Expr)| {
                (index, bounds.get(number).is_none_or(|bounds| index.constant_within(*bounds).is_none()))
            };
            all.extend(indices.iter().enumerate().map(is_checked));
        }
        all
    }

    /// Whether an expression needs statements printed before it.
    pub(super) fn runs(&self, expr: &Expr) -> bool {
        runs_statements(expr) && (self.scope.counts || !is_quiet(expr, &self.facts))
    }

    /// Stores a value in a new temporary and returns the temporary's name.
    pub(super) fn kept(&mut self, ty: Scalar, value: &str) -> String {
        let name = self.temporary(|_, name| format!("{} {name}", scalar(ty)));
        self.line(&format!("{name} = {};", bare(value)));
        name
    }

    /// Appends the C conditions that must all hold for two variables to be equal.
    fn same(&self, ty: &Type, offset: usize, a: &str, b: &str, parts: &mut Vec<String>) -> Result<(), String> {
        let at = |text: &str| format!("(const char *){text} + {offset}");
        match ty {
            Type::Scalar(ty) => parts.push(format!("same_{ty}({}, {}, 1)", at(a), at(b))),
            Type::Text { capacity, wide } => {
                let width = 1 + u8::from(*wide);
                parts.push(format!("compare_text({}, {capacity}u, {}, {capacity}u, {width}) == 0", at(a), at(b)));
            }
            Type::Array { of, .. } => {
                let count = self.program.size(ty) / self.program.size(of).max(1);
                if let Type::Scalar(ty) = **of {
                    parts.push(format!("same_{ty}({}, {}, {count})", at(a), at(b)));
                } else {
                    for index in 0..count {
                        self.same(of, offset + index * self.program.size(of), a, b, parts)?;
                    }
                }
            }
            Type::Record(record) => {
                for member in &self.program.records[*record].members {
                    self.same(&member.ty, offset + member.offset, a, b, parts)?;
                }
            }
            Type::Open { .. } => return Err("an open array cannot be compared".to_string()),
        }
        Ok(())
    }

    /// The addresses of two variables as C text, resolved from left to right.
    pub(super) fn addresses(&mut self, a: &Place, b: &Place) -> Result<(String, String), String> {
        let mut first = self.address(a)?;
        if self.is_found_before(a, self.of_place(b)) {
            first = self.held("const void *", &first);
        }
        Ok((first, self.address(b)?))
    }

    /// Whether a place must be resolved before later code.
    pub(super) fn is_found_before(&self, place: &Place, later: Effect) -> bool {
        (later.runs || later.stops) && self.is_checked(place)
    }

    /// Stores an address or an index in a new temporary and returns the temporary's name.
    pub(super) fn held(&mut self, ty: &str, text: &str) -> String {
        let name = self.temporary(|_, name| format!("{ty}{name}"));
        self.line(&format!("{name} = {text};"));
        name
    }

    /// The address of a variable as C text.
    pub(super) fn address(&mut self, place: &Place) -> Result<String, String> {
        let text = self.place(place)?;
        Ok(match text.strip_prefix("(*").and_then(|rest| rest.strip_suffix(')')) {
            Some(pointer) => pointer.to_string(),
            None => format!("&{text}"),
        })
    }

    /// A variable as C text.
    pub(super) fn place(&mut self, place: &Place) -> Result<String, String> {
        let function = self.scope.function.ok_or("no function")?;
        let mut ty = self.type_of(&Place::new(place.base))?;
        let mut pointer = true;
        let mut text = match place.base {
            Base::Memory => self.argument("memory"),
            Base::Instance => self.argument("self"),
            Base::Constants => {
                self.reads_constants = true;
                pointer = false;
                "constants.value".to_string()
            }
            Base::Local(local) => {
                let name = self.local(local);
                pointer = function.locals[local].by_reference;
                self.scope.locals[local].has_named_bounds |= matches!(ty, Type::Open { .. });
                if pointer && matches!(ty, Type::Array { .. } | Type::Open { .. }) {
                    pointer = false;
                }
                name
            }
        };
        let indices_of_place = self.indices(place);
        let mut later = &indices_of_place[..];
        for step in &place.steps {
            match (step, ty) {
                (Step::Member(member), Type::Record(record)) => {
                    let name = &self.members[record][*member];
                    text = format!("{text}{}{name}", if pointer { "->" } else { "." });
                    ty = self.program.records[record].members[*member].ty.clone();
                }
                (Step::Length, Type::Text { .. }) => {
                    text = format!("{text}{}length", if pointer { "->" } else { "." });
                    ty = Type::Scalar(Scalar::U16);
                }
                (Step::Index(_, at), Type::Text { capacity, wide }) => {
                    let bounds = [(1, i32::from(capacity))];
                    let number = self.element(&mut later, Bounds::Fixed(&bounds), line(*at))?;
                    text = format!("{text}{}characters[{number}]", if pointer { "->" } else { "." });
                    ty = Type::Scalar(if wide { Scalar::U16 } else { Scalar::U8 });
                }
                (Step::Index(_, at), Type::Array { of, bounds }) => {
                    text = format!("{text}[{}]", self.element(&mut later, Bounds::Fixed(&bounds), line(*at))?);
                    ty = *of;
                }
                (Step::Index(_, at), Type::Open { of, dimensions }) => {
                    let bounds = Bounds::Open(&text, dimensions);
                    text = format!("{text}[{}]", self.element(&mut later, bounds, line(*at))?);
                    ty = *of;
                }
                _ => return Err("a variable does not exist".to_string()),
            }
            pointer = false;
        }
        Ok(if pointer { format!("(*{text})") } else { text })
    }

    /// The flat index of an array element as C text; takes the element's indices from the front of `later`.
    fn element(&mut self, later: &mut &[(&Expr, bool)], bounds: Bounds, line: String) -> Result<String, String> {
        let dimensions = match bounds {
            Bounds::Fixed(all) => all.len(),
            Bounds::Open(_, dimensions) => dimensions,
        };
        let mut number = String::new();
        for dimension in 0..dimensions {
            let Some(((index, is_checked), rest)) = later.split_first() else {
                return Err("an array index is missing".to_string());
            };
            *later = rest;
            let (low, high) = match bounds {
                Bounds::Fixed(all) => (all[dimension].0.to_string(), all[dimension].1.to_string()),
                Bounds::Open(name, _) => {
                    let bound = |upper: usize| format!("{name}_bounds[{}]", 2 * dimension + upper);
                    (bound(0), bound(1))
                }
            };
            let text = match bounds {
                Bounds::Fixed(all) if !is_checked => {
                    let (low, _) = all[dimension];
                    index.constant_within(all[dimension]).map_or(0, |number| number - i64::from(low)).to_string()
                }
                _ => {
                    let index = self.expr(index)?;
                    format!("index_of({}, (i64_t){index}, {low}, {high}, {line})", self.argument("call"))
                }
            };
            number = match &number[..] {
                "" | "0" => text,
                _ => format!("({number}) * (size_t)({high} - {low} + 1) + {text}"),
            };
            // C may evaluate later indices first, so this one is stored in a temporary where the order matters.
            let is_before = |(index, is_checked): &(&Expr, bool)| *is_checked || self.runs(index);
            if *is_checked && rest.iter().any(is_before) {
                number = self.held("size_t ", &number);
            }
        }
        Ok(number)
    }
}

/// Side effects of evaluating an expression or resolving a place.
#[derive(Clone, Copy, Default)]
pub(super) struct Effect {
    /// Statements must be printed before it.
    pub runs: bool,
    /// An index is checked at run time, which may stop the call.
    pub stops: bool,
}

impl Effect {
    /// The side effects of doing both.
    pub(super) fn and(self, other: Effect) -> Effect {
        Effect { runs: self.runs || other.runs, stops: self.stops || other.stops }
    }
}

/// The bounds of an array's indices.
#[derive(Clone, Copy)]
enum Bounds<'a> {
    /// The lower and upper bound of each dimension.
    Fixed(&'a [(i32, i32)]),
    /// The name of an open array, whose bounds are passed in the parameter `NAME_bounds`, and its number of dimensions.
    Open(&'a str, usize),
}

/// Whether an expression has type `int` in C although it is a truth value: a negated floating-point comparison,
/// combined comparisons, or a choice between truth values that are not both variables.
fn is_int(expr: &Expr) -> bool {
    let compares = |it: &Expr| match it {
        Expr::Binary(op, ty, ..) => op.compares() && ty.is_float(),
        _ => false,
    };
    match expr {
        Expr::Unary(Unary::Not, _, a) => compares(a) || is_int(a),
        Expr::Binary(Binary::And | Binary::Or, Scalar::Bool, a, b, _) => {
            compares(a) && compares(b) || is_int(a) || is_int(b)
        }
        Expr::Select(Scalar::Bool, parts) => !parts[1..].iter().all(|part| matches!(part, Expr::Load(..))),
        _ => false,
    }
}

/// The C operator, and whether it can be used for all types.
fn symbol(op: Binary) -> Option<(&'static str, bool)> {
    Some(match op {
        Binary::Add => ("+", false),
        Binary::Sub => ("-", false),
        Binary::Mul => ("*", false),
        Binary::Div => ("/", false),
        Binary::And => ("&", false),
        Binary::Or => ("|", false),
        Binary::Xor => ("^", false),
        Binary::Eq => ("==", true),
        Binary::Lt => ("<", true),
        Binary::Le => ("<=", true),
        Binary::Gt => (">", true),
        Binary::Ge => (">=", true),
        _ => return None,
    })
}

/// A constant as C text.
pub(super) fn constant(value: Value) -> String {
    match value.ty() {
        Scalar::F32 if value.number().is_finite() => format!("{value}f"),
        Scalar::F32 => format!("f32_of({}u)", value.bits()),
        Scalar::F64 if value.number().is_finite() => value.to_string(),
        Scalar::F64 => format!("f64_of({}ull)", value.bits()),
        Scalar::Bool => value.bits().to_string(),
        Scalar::U32 => format!("{}u", value.bits()),
        Scalar::U64 => format!("{}ull", value.bits()),
        Scalar::I64 if value.bits() == 1 << 63 => "I64_MIN".to_string(),
        Scalar::I64 => format!("{}ll", value.bits() as i64),
        Scalar::I32 if value.bits() as i32 == i32::MIN => "(-2147483647 - 1)".to_string(),
        _ => (value.bits() as i64).to_string(),
    }
}

/// An expression without its outer parentheses.
pub(super) fn bare(expr: &str) -> &str {
    let Some(inner) = expr.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) else { return expr };
    let mut depth = 0_i32;
    let is_whole = inner.chars().all(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth >= 0
    });
    // `(a)(b)` must keep its parentheses: they do not enclose the whole expression.
    if is_whole { inner } else { expr }
}

/// A type conversion as C text.
fn converted(how: Convert, from: Scalar, to: Scalar, a: &str) -> String {
    let name = scalar(to);
    let whole = match how {
        Convert::Value => "round",
        Convert::Trunc => "trunc",
        Convert::Ceil => "ceil",
        Convert::Floor => "floor",
        Convert::Bits if from.is_float() => {
            let unsigned = if from == Scalar::F32 { Scalar::U32 } else { Scalar::U64 };
            let bits = format!("bits_{from}({})", bare(a));
            return if to == unsigned { bits } else { format!("(({name}){bits})") };
        }
        Convert::Bits => {
            let unsigned = if to == Scalar::F32 { "u32_t" } else { "u64_t" };
            return format!("{to}_of(({unsigned}){a})");
        }
    };
    match (from.is_float(), to) {
        (true, Scalar::I32) if how == Convert::Value => format!("round_i32({})", bare(a)),
        (true, to) if to.is_integer() => {
            let wide = if to == Scalar::U64 { "whole_u64" } else { "whole_i64" };
            format!("(({name}){wide}({whole}_f64((double){a})))")
        }
        (_, Scalar::Bool) => format!("((u8_t)({a} & 1))"),
        _ => format!("(({name}){a})"),
    }
}
