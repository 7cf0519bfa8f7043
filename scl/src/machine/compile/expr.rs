//! Compiles expressions.

use super::place::Location;
use super::{Compiler, Home, Scope, warning, wrong_type};
use crate::ir::operations::{Either, limit};
use crate::ir::walk::runs_statements;
use crate::ir::{Binary, Expr, Place, Scalar, Type};
use crate::machine::code::{Op, Register};

impl Compiler<'_> {
    /// Compiles an expression, which must have the given type, and returns the register with its value: `into` if
    /// given, else any. Only `into` and free registers are written.
    pub(super) fn typed(
        &mut self,
        scope: &mut Scope,
        expr: &Expr,
        ty: Scalar,
        into: Option<Register>,
    ) -> Result<Register, String> {
        let found = expr.ty();
        if found != ty {
            return Err(wrong_type(ty, found));
        }
        self.expr(scope, expr, into)
    }

    /// Compiles an expression, which must have an integer type.
    pub(super) fn integer(&mut self, scope: &mut Scope, expr: &Expr) -> Result<Register, String> {
        let ty = expr.ty();
        if ty.is_integer() { self.expr(scope, expr, None) } else { Err(wrong_type("an integer", ty)) }
    }

    fn expr(&mut self, scope: &mut Scope, expr: &Expr, into: Option<Register>) -> Result<Register, String> {
        // Operand registers are free again after the operation, so the result may reuse one of them.
        let begin = scope.next;
        let op = |compiler: &mut Self, scope: &mut Scope, op: &dyn Fn(Register) -> Op| {
            scope.next = begin;
            let to = into.map_or_else(|| scope.take(), Ok)?;
            compiler.emit(scope, op(to));
            Ok(to)
        };
        match expr {
            Expr::Const(value) => op(self, scope, &|to| Op::Const { to, bits: value.bits() }),
            Expr::Load(ty, place) => match self.place(scope, place)? {
                (_, found) if found != Type::Scalar(*ty) => Err(wrong_type(ty, "another type")),
                (Location::Register(from), _) if into.is_none() => Ok(from),
                (Location::Register(from), _) => op(self, scope, &|to| Op::Move { to, from }),
                (Location::Memory { base, offset }, _) => op(self, scope, &|to| Op::load(*ty, to, base, offset as u32)),
            },
            Expr::Unary(unary, ty, a) => {
                let a = self.typed(scope, a, *ty, None)?;
                let function = unary.function(*ty).ok_or_else(|| format!("{unary:?} is undefined for {ty}"))?;
                op(self, scope, &|to| Op::One { to, a, function })
            }
            Expr::Binary(binary, ty, left, right, at) => {
                let (a, b) = self.operands(scope, *binary, *ty, left, right)?;
                let function = binary.function(*ty).ok_or_else(|| format!("{binary:?} is undefined for {ty}"))?;
                let line = std::mem::replace(&mut scope.at, *at);
                let to = op(self, scope, &|to| match (function, binary, ty) {
                    (_, Binary::Add, Scalar::F32) => Op::AddF32 { to, a, b },
                    (_, Binary::Sub, Scalar::F32) => Op::SubF32 { to, a, b },
                    (_, Binary::Mul, Scalar::F32) => Op::MulF32 { to, a, b },
                    (Either::Plain(function), ..) => Op::Two { to, a, b, function },
                    (Either::Checked(function), ..) => Op::TwoChecked { to, a, b, function },
                });
                scope.at = line;
                if matches!(function, Either::Checked(_)) {
                    self.warn(matches!(binary, Binary::Div | Binary::Rem), *ty);
                }
                to
            }
            Expr::Convert(how, from, ty, a, at) => {
                let a = self.typed(scope, a, *from, None)?;
                let function =
                    how.function(*from, *ty).ok_or_else(|| format!("{how:?} from {from} to {ty} is undefined"))?;
                let line = std::mem::replace(&mut scope.at, *at);
                let to = op(self, scope, &|to| match function {
                    Either::Plain(function) => Op::One { to, a, function },
                    Either::Checked(function) => Op::OneChecked { to, a, function },
                });
                scope.at = line;
                if matches!(function, Either::Checked(_)) {
                    self.warn(false, *ty);
                }
                to
            }
            Expr::Select(ty, parts) => {
                let first = self.three(scope, parts, [Scalar::Bool, *ty, *ty])?;
                op(self, scope, &|to| Op::Select { to, first })
            }
            Expr::Limit(ty, parts) => {
                let first = self.three(scope, parts, [*ty; 3])?;
                let function = limit(*ty).ok_or_else(|| format!("LIMIT is undefined for {ty}"))?;
                op(self, scope, &|to| Op::Three { to, first, function })
            }
            Expr::Texts(binary, a, b) => {
                let (first, second, capacities, wide) = self.texts(scope, a, b)?;
                if !binary.compares() {
                    return Err("the only operations on strings are comparisons".to_string());
                }
                op(self, scope, &|to| Op::CompareText { op: *binary, to, a: first, b: second, capacities, wide })
            }
            Expr::Same(a, b) => {
                let (a, first) = self.address(scope, a)?;
                let (b, second) = self.address(scope, b)?;
                let (mut parts, mut others) = (Vec::new(), Vec::new());
                self.parts(&first, 0, &mut parts)?;
                self.parts(&second, 0, &mut others)?;
                if parts != others {
                    return Err("structures of different types cannot be compared".to_string());
                }
                self.code.parts.push(parts);
                let parts = (self.code.parts.len() - 1) as u32;
                op(self, scope, &|to| Op::Same { to, a, b, parts })
            }
            Expr::Bound { local, dimension, upper } => {
                let ty = scope.function.locals.get(*local).map(|local| &local.ty);
                match (scope.homes.get(*local), ty) {
                    (Some(Home::Reference(home)), Some(Type::Open { dimensions, .. })) if dimension < dimensions => {
                        let from = home + 1 + 2 * *dimension as Register + Register::from(*upper);
                        op(self, scope, &|to| Op::Move { to, from })
                    }
                    _ => Err("only an open array has bounds".to_string()),
                }
            }
            Expr::Now => op(self, scope, &|to| Op::Now { to }),
            Expr::After(before, value) => {
                self.statements(scope, before)?;
                self.expr(scope, value, into)
            }
        }
    }

    /// Compiles both operands. The left one is copied if the right one runs statements, which may change a variable.
    fn operands(
        &mut self,
        scope: &mut Scope,
        binary: Binary,
        ty: Scalar,
        left: &Expr,
        right: &Expr,
    ) -> Result<(Register, Register), String> {
        let into = if runs_statements(right) { Some(scope.take()?) } else { None };
        let a = self.typed(scope, left, ty, into)?;
        let b = self.typed(scope, right, if binary.shifts() { Scalar::U32 } else { ty }, None)?;
        Ok((a, b))
    }

    /// Compiles three expressions to consecutive registers and returns the first.
    fn three(&mut self, scope: &mut Scope, parts: &[Expr; 3], types: [Scalar; 3]) -> Result<Register, String> {
        let registers = [scope.take()?, scope.take()?, scope.take()?];
        for ((part, ty), register) in parts.iter().zip(types).zip(registers) {
            self.typed(scope, part, ty, Some(register))?;
        }
        Ok(registers[0])
    }

    /// The registers with the addresses of two strings, their capacities, and whether both are wide.
    #[allow(clippy::type_complexity)]
    fn texts(
        &mut self,
        scope: &mut Scope,
        a: &Place,
        b: &Place,
    ) -> Result<(Register, Register, (u16, u16), bool), String> {
        let (a, first) = self.address(scope, a)?;
        let (b, second) = self.address(scope, b)?;
        match (first, second) {
            (Type::Text { capacity: first, wide }, Type::Text { capacity: second, wide: same }) if wide == same => {
                Ok((a, b, (first, second), wide))
            }
            _ => Err("a STRING and a WSTRING cannot be compared".to_string()),
        }
    }

    /// Records the warning that the last emitted instruction may issue.
    fn warn(&mut self, by_zero: bool, ty: Scalar) {
        let warning = warning(by_zero, ty);
        self.code.warnings.insert((self.code.ops.len() - 1) as u32, warning);
    }
}
