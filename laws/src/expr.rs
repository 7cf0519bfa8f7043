//! Reads expressions.

use crate::body::{Body, folded};
use crate::reader::{number, owner_of};
use crate::source::Error;
use crate::value::{Ty, Val, Var};
use scl::ir::{Binary, Convert, Expr, Scalar, Unary, Value};
use syn::spanned::Spanned;
use syn::{BinOp, ExprBinary, ExprIf, ExprLit, Lit, Stmt, UnOp};

impl Body<'_, '_> {
    /// Reads an expression that must be a number, and returns its type as well.
    pub(crate) fn number(&mut self, expr: &syn::Expr, want: Option<&Ty>) -> Result<(Expr, Ty), Error> {
        match self.value(expr, want)? {
            Val::Number(expr, ty) => Ok((expr, ty)),
            Val::Rounded(..) => {
                Err(self.error(expr.span(), "a rounded number must be converted to an integer here: add `as`"))
            }
            _ => Err(self.error(expr.span(), "a number is expected here")),
        }
    }

    /// The variable that an expression names; `None` if it is not a variable.
    pub(crate) fn place(&mut self, expr: &syn::Expr) -> Result<Option<Var>, Error> {
        Ok(match expr {
            syn::Expr::Paren(it) => self.place(&it.expr)?,
            syn::Expr::Reference(it) => self.place(&it.expr)?,
            syn::Expr::Unary(it) if matches!(it.op, UnOp::Deref(_)) => self.place(&it.expr)?,
            syn::Expr::Path(it) => match it.path.get_ident() {
                Some(name) => self.find(&name.to_string()).cloned(),
                None => None,
            },
            syn::Expr::Field(it) => {
                let Some(Var::Place(place, Ty::Struct(record))) = self.place(&it.base)? else { return Ok(None) };
                let syn::Member::Named(name) = &it.member else { return Ok(None) };
                let found = self.reader.field(record, &name.to_string());
                let (number, ty) =
                    found.ok_or_else(|| self.error(name.span(), format!("the struct has no field {name}")))?;
                Some(Var::Place(place.member(number), ty))
            }
            _ => None,
        })
    }

    /// Reads an expression; a literal takes the expected type.
    pub(crate) fn value(&mut self, expr: &syn::Expr, want: Option<&Ty>) -> Result<Val, Error> {
        if let Some(var) = self.place(expr)? {
            return Ok(var.load());
        }
        match expr {
            syn::Expr::Lit(it) => self.literal(it, want),
            syn::Expr::Paren(it) => self.value(&it.expr, want),
            syn::Expr::Group(it) => self.value(&it.expr, want),
            syn::Expr::Reference(it) => self.value(&it.expr, want),
            syn::Expr::Unary(it) => {
                let (value, ty) = self.number(&it.expr, want)?;
                let op = match it.op {
                    UnOp::Neg(_) => Unary::Neg,
                    UnOp::Not(_) => Unary::Not,
                    _ => return Err(self.error(expr.span(), "this operation is not supported")),
                };
                let kept = match &ty {
                    Ty::Integer => Scalar::I64,
                    Ty::Float => Scalar::F64,
                    Ty::Scalar(scalar) => *scalar,
                    _ => return Err(self.error(expr.span(), format!("this operation is not defined for {ty}"))),
                };
                let negated = Expr::Unary(op, kept, Box::new(value));
                Ok(Val::Number(folded(&negated).map_or(negated, Expr::Const), ty))
            }
            syn::Expr::Binary(it) => self.binary(it, want),
            syn::Expr::Path(it) => self.path(it),
            syn::Expr::Field(it) => {
                // The number inside a newtype.
                let (value, ty) = self.number(&it.base, None)?;
                match (&it.member, ty) {
                    (syn::Member::Unnamed(index), Ty::New { kept, inner, .. }) if index.index == 0 => {
                        Ok(Val::Number(self.converted(value, kept, inner), Ty::Scalar(inner)))
                    }
                    _ => Err(self.error(expr.span(), "this field is not supported")),
                }
            }
            syn::Expr::MethodCall(it) => self.method(it, want),
            syn::Expr::Call(it) => self.call_path(it, want),
            syn::Expr::Cast(it) => self.cast(it),
            syn::Expr::If(it) => self.select(expr, it, want),
            syn::Expr::Match(_) | syn::Expr::Block(_) => self.apart_value(expr, want),
            syn::Expr::Tuple(it) => {
                let mut parts = Vec::new();
                for (number, part) in it.elems.iter().enumerate() {
                    let want = match want {
                        Some(Ty::Tuple(wanted)) => wanted.get(number),
                        _ => None,
                    };
                    parts.push(self.value(part, want)?);
                }
                Ok(Val::Tuple(parts))
            }
            syn::Expr::Range(it) => {
                let (Some(start), Some(end)) = (&it.start, &it.end) else {
                    return Err(self.error(expr.span(), "a range must have both ends here"));
                };
                let ty = self.common(start, end)?;
                let kept = ty.kept().ok_or_else(|| self.error(expr.span(), "the type of this range is ambiguous"))?;
                let (low, _) = self.number(start, Some(&ty))?;
                let (high, _) = self.number(end, Some(&ty))?;
                Ok(Val::Range(low, high, matches!(it.limits, syn::RangeLimits::Closed(_)), kept))
            }
            _ => Err(self.error(expr.span(), "this expression is not supported")),
        }
    }

    fn literal(&mut self, it: &ExprLit, want: Option<&Ty>) -> Result<Val, Error> {
        let unknown = |this: &Self| this.error(it.span(), "this number does not fit its type");
        let (value, ty) = match &it.lit {
            Lit::Bool(truth) => (Value::from(truth.value), Ty::BOOL),
            Lit::Int(number_) => {
                let ty = number(number_.suffix()).or_else(|| want.and_then(open_integer));
                let bits: i128 = number_.base10_parse().map_err(|_| unknown(self))?;
                match ty {
                    Some(ty) => (Value::new(ty, bits as u64), Ty::Scalar(ty)),
                    None => (Value::from(bits as i64), Ty::Integer),
                }
            }
            Lit::Float(number_) => {
                let ty = number(number_.suffix()).or_else(|| want.and_then(Ty::kept).filter(|it| it.is_float()));
                let digits = number_.base10_digits();
                match ty {
                    Some(Scalar::F32) => {
                        (Value::from(digits.parse::<f32>().map_err(|_| unknown(self))?), Ty::Scalar(Scalar::F32))
                    }
                    ty => {
                        let value = Value::from(digits.parse::<f64>().map_err(|_| unknown(self))?);
                        (value, ty.map_or(Ty::Float, Ty::Scalar))
                    }
                }
            }
            _ => return Err(self.error(it.span(), "only numbers, true and false are supported here")),
        };
        Ok(Val::Number(Expr::Const(value), ty))
    }

    fn path(&mut self, it: &syn::ExprPath) -> Result<Val, Error> {
        let last = it.path.segments.last().map(|last| last.ident.to_string()).unwrap_or_default();
        if last == "None" {
            return Ok(Val::Option(None));
        }
        let owner =
            owner_of(&it.path).map(|name| if name == "Self" { self.owner.clone().unwrap_or_default() } else { name });
        if let Some(ty) = owner.as_deref().and_then(|name| self.scalar_named(name)) {
            let value = limit_of(ty, &last)
                .ok_or_else(|| self.error(it.span(), format!("the constant {last} of {ty} is not supported")))?;
            return Ok(Val::Number(Expr::Const(value), Ty::Scalar(ty)));
        }
        let items = self.reader.items;
        let Some(constant) = items.constant(owner.as_deref(), &last, self.file) else {
            return Err(
                self.error(it.span(), format!("the constant {last} is unknown here, or its name is not unique"))
            );
        };
        let ty = self.reader.ty(constant.file, &constant.ty, owner.as_deref())?;
        let value = Body::constant(self.reader, constant.file, &constant.value, &ty)?;
        Ok(Val::Number(Expr::Const(value), ty))
    }

    /// The number type that a name or an alias denotes.
    pub(crate) fn scalar_named(&mut self, name: &str) -> Option<Scalar> {
        let ty = syn::parse_str::<syn::Type>(name).ok()?;
        match self.reader.ty(self.file, &ty, None) {
            Ok(Ty::Scalar(scalar)) => Some(scalar),
            _ => None,
        }
    }

    fn binary(&mut self, it: &ExprBinary, want: Option<&Ty>) -> Result<Val, Error> {
        let at = self.place_of_line();
        let (op, compares) = match it.op {
            BinOp::And(_) | BinOp::Or(_) => return self.logic(it),
            BinOp::Add(_) => (Binary::Add, false),
            BinOp::Sub(_) => (Binary::Sub, false),
            BinOp::Mul(_) => (Binary::Mul, false),
            BinOp::Div(_) => (Binary::Div, false),
            BinOp::Rem(_) => (Binary::Rem, false),
            BinOp::BitAnd(_) => (Binary::And, false),
            BinOp::BitOr(_) => (Binary::Or, false),
            BinOp::BitXor(_) => (Binary::Xor, false),
            BinOp::Eq(_) => (Binary::Eq, true),
            BinOp::Ne(_) => (Binary::Ne, true),
            BinOp::Lt(_) => (Binary::Lt, true),
            BinOp::Le(_) => (Binary::Le, true),
            BinOp::Gt(_) => (Binary::Gt, true),
            BinOp::Ge(_) => (Binary::Ge, true),
            _ => return Err(self.error(it.op.span(), "this operation is not supported")),
        };
        let ty = match want.filter(|want| !compares && want.kept().is_some()) {
            Some(want) => want.clone(),
            None => self.common(&it.left, &it.right)?,
        };
        if compares && let Ty::Tuple(_) = ty {
            let (left, right) = (self.value(&it.left, Some(&ty))?, self.value(&it.right, Some(&ty))?);
            let same = self.same(left, right, it)?;
            let value = if op == Binary::Ne { Expr::Unary(Unary::Not, Scalar::Bool, Box::new(same)) } else { same };
            return Ok(Val::Number(value, Ty::BOOL));
        }
        let (left, found) = self.number(&it.left, Some(&ty))?;
        let (right, other) = self.number(&it.right, Some(&ty))?;
        for (found, part) in [(&found, &it.left), (&other, &it.right)] {
            if *found != ty {
                return Err(self.error(part.span(), format!("expected {ty}, found {found}")));
            }
        }
        let kept = match (&ty, compares) {
            (Ty::Scalar(scalar), _) => *scalar,
            (Ty::New { kept, .. }, true) => *kept,
            (Ty::Float, false) => Scalar::F64,
            _ => {
                return Err(self.error(
                    it.span(),
                    format!(
                        "this operation is not supported for {ty}; use a primitive type, such as 1_i32 for a literal"
                    ),
                ));
            }
        };
        if kept.is_float() && matches!(op, Binary::Rem) {
            return Err(self.error(it.op.span(), "the remainder of floating-point numbers is not supported"));
        }
        let (left, right) = (Box::new(left), Box::new(right));
        // In Rust, a comparison of NaN with `!=` is true; in the typed program it is false.
        let value = if op == Binary::Ne && kept.is_float() {
            Expr::Unary(Unary::Not, Scalar::Bool, Box::new(Expr::Binary(Binary::Eq, kept, left, right, at)))
        } else {
            Expr::Binary(op, kept, left, right, at)
        };
        Ok(Val::Number(value, if compares { Ty::BOOL } else { ty }))
    }

    /// Compares two values for equality, part by part.
    fn same(&mut self, left: Val, right: Val, it: &ExprBinary) -> Result<Expr, Error> {
        let at = self.place_of_line();
        match (left, right) {
            (Val::Number(left, ty), Val::Number(right, other)) if ty == other && ty.kept().is_some() => {
                let kept = ty.kept().unwrap_or(Scalar::Bool);
                Ok(Expr::Binary(Binary::Eq, kept, Box::new(left), Box::new(right), at))
            }
            (Val::Tuple(left), Val::Tuple(right)) if left.len() == right.len() && !left.is_empty() => {
                let mut all = None;
                for (left, right) in left.into_iter().zip(right) {
                    let one = self.same(left, right, it)?;
                    all = Some(match all {
                        Some(all) => Expr::Binary(Binary::And, Scalar::Bool, Box::new(all), Box::new(one), at),
                        None => one,
                    });
                }
                all.ok_or_else(|| self.error(it.span(), "there is nothing to compare"))
            }
            _ => Err(self.error(it.span(), "these two values cannot be compared here")),
        }
    }

    /// Reads `&&` and `||`. The right side is evaluated unconditionally if that makes no observable difference.
    fn logic(&mut self, it: &ExprBinary) -> Result<Val, Error> {
        let at = self.place_of_line();
        let is_and = matches!(it.op, BinOp::And(_));
        let left = self.condition(&it.left)?;
        let effects = self.effects;
        let (before, right) = self.apart(|this| this.condition(&it.right))?;
        if before.is_empty() && effects == self.effects {
            let op = if is_and { Binary::And } else { Binary::Or };
            let value = Expr::Binary(op, Scalar::Bool, Box::new(left), Box::new(right), at);
            return Ok(Val::Number(value, Ty::BOOL));
        }
        let Var::Place(place, _) = self.local("both", &Ty::BOOL, it.span())? else {
            return Err(self.error(it.span(), "this is not a Boolean"));
        };
        let (statements, ()) = self.apart(|this| {
            this.assign(place.clone(), left);
            let (mut then, ()) = this.apart(|this| {
                this.append(before);
                this.assign(place.clone(), right);
                Ok(())
            })?;
            let load = Expr::Load(Scalar::Bool, place.clone());
            let mut otherwise = Vec::new();
            if !is_and {
                std::mem::swap(&mut then, &mut otherwise);
            }
            this.push(scl::ir::What::If(load, then, otherwise));
            Ok(())
        })?;
        Ok(Val::Number(Expr::After(statements, Box::new(Expr::Load(Scalar::Bool, place))), Ty::BOOL))
    }

    /// The common type of two expressions.
    pub(crate) fn common(&mut self, left: &syn::Expr, right: &syn::Expr) -> Result<Ty, Error> {
        let (a, b) = (self.ty(left)?, self.ty(right)?);
        a.unified(&b).ok_or_else(|| self.error(right.span(), format!("expected {a}, found {b}")))
    }

    /// The type of an expression.
    pub(crate) fn ty(&mut self, expr: &syn::Expr) -> Result<Ty, Error> {
        match expr {
            syn::Expr::Paren(it) => self.ty(&it.expr),
            syn::Expr::Return(_) => Ok(Ty::Never),
            syn::Expr::Block(it) => self.block_ty(&it.block),
            syn::Expr::If(it) => {
                let then = self.tried(|this| {
                    if let syn::Expr::Let(_) = &*it.cond {
                        return this.if_let_ty(it);
                    }
                    this.block_ty(&it.then_branch)
                })?;
                let otherwise = match &it.else_branch {
                    Some((_, expr)) => self.ty(expr)?,
                    None => Ty::unit(),
                };
                then.unified(&otherwise)
                    .ok_or_else(|| self.error(expr.span(), format!("one branch is {then}, the other {otherwise}")))
            }
            syn::Expr::Match(it) => {
                let mut ty = Ty::Never;
                for arm in &it.arms {
                    let of_arm = self.ty(&arm.body)?;
                    ty = ty.unified(&of_arm).ok_or_else(|| {
                        self.error(arm.body.span(), format!("other arms are {ty}, this one is {of_arm}"))
                    })?;
                }
                Ok(ty)
            }
            syn::Expr::Tuple(it) => Ok(Ty::Tuple(it.elems.iter().map(|part| self.ty(part)).collect::<Result<_, _>>()?)),
            _ => {
                let value = self.tried(|this| this.value(expr, None))?;
                self.ty_of(&value, expr)
            }
        }
    }

    fn ty_of(&self, value: &Val, expr: &syn::Expr) -> Result<Ty, Error> {
        Ok(match value {
            Val::Number(_, ty) => ty.clone(),
            Val::Var(var) => var.ty(),
            Val::Tuple(parts) => Ty::Tuple(parts.iter().map(|part| self.ty_of(part, expr)).collect::<Result<_, _>>()?),
            Val::Option(Some(of)) => Ty::Option(Box::new(self.ty_of(of, expr)?)),
            Val::Option(None) => Ty::Option(Box::new(Ty::Never)),
            Val::Rounded(_, _, ty) => Ty::Scalar(*ty),
            _ => return Err(self.error(expr.span(), "no variable can hold a value of this type")),
        })
    }

    fn if_let_ty(&mut self, it: &ExprIf) -> Result<Ty, Error> {
        let syn::Expr::Let(condition) = &*it.cond else { return Ok(Ty::Never) };
        self.if_let(condition)?;
        self.block_ty(&it.then_branch)
    }

    /// The type of a block's value.
    fn block_ty(&mut self, block: &syn::Block) -> Result<Ty, Error> {
        self.tried(|this| {
            let Some((last, before)) = block.stmts.split_last() else { return Ok(Ty::unit()) };
            let before = syn::Block { brace_token: Default::default(), stmts: before.to_vec() };
            this.statements(&before, None)?;
            match last {
                Stmt::Expr(syn::Expr::Return(_), _) => Ok(Ty::Never),
                Stmt::Expr(expr, None) => this.ty(expr),
                _ => Ok(Ty::unit()),
            }
        })
    }

    /// Reads an `if` with a value: as a selection if each branch is a single expression without side effects.
    fn select(&mut self, expr: &syn::Expr, it: &ExprIf, want: Option<&Ty>) -> Result<Val, Error> {
        let ty = match want.filter(|want| want.is_known()) {
            Some(want) => want.clone(),
            None => self.ty(expr)?,
        };
        let only = |block: &syn::Block| match &block.stmts[..] {
            [Stmt::Expr(expr, None)] => Some(expr.clone()),
            _ => None,
        };
        let otherwise = match &it.else_branch {
            Some((_, expr)) => match &**expr {
                syn::Expr::Block(block) => only(&block.block),
                expr => Some(expr.clone()),
            },
            None => None,
        };
        if let (Some(then), Some(otherwise), Some(kept)) = (only(&it.then_branch), otherwise, ty.kept())
            && !matches!(&*it.cond, syn::Expr::Let(_))
        {
            let effects = self.effects;
            let locals = self.locals.len();
            let condition = self.condition(&it.cond)?;
            let after = self.effects;
            let (before, (a, b)) =
                self.apart(|this| Ok((this.number(&then, Some(&ty))?, this.number(&otherwise, Some(&ty))?)))?;
            if before.is_empty() && after == self.effects && a.1 == ty && b.1 == ty {
                return Ok(Val::Number(Expr::Select(kept, Box::new([condition, a.0, b.0])), ty));
            }
            self.locals.truncate(locals);
            self.effects = effects;
        }
        self.apart_value(expr, Some(&ty))
    }

    /// Reads an expression that needs statements, which store its value in a new variable.
    fn apart_value(&mut self, expr: &syn::Expr, want: Option<&Ty>) -> Result<Val, Error> {
        let ty = match want.filter(|want| want.is_known()) {
            Some(want) => want.clone(),
            None => self.ty(expr)?,
        };
        let var = self.local("value", &ty, expr.span())?;
        let (statements, ()) = self.apart(|this| this.store(&var, expr))?;
        Ok(match (&var, ty.kept()) {
            (Var::Place(place, _), Some(kept)) => {
                Val::Number(Expr::After(statements, Box::new(Expr::Load(kept, place.clone()))), ty)
            }
            _ => {
                self.append(statements);
                var.load()
            }
        })
    }

    /// Converts a number by value to another type.
    pub(crate) fn converted(&self, value: Expr, from: Scalar, to: Scalar) -> Expr {
        if from == to { value } else { Expr::Convert(Convert::Value, from, to, Box::new(value), self.place_of_line()) }
    }
}

/// The integer type of a literal where this type is expected; `None` if the expected type is not an integer type.
fn open_integer(want: &Ty) -> Option<Scalar> {
    want.kept().filter(|it| it.is_integer())
}

/// The value of an associated constant of a number type, such as `MAX`.
fn limit_of(ty: Scalar, name: &str) -> Option<Value> {
    let bits = 8 * ty.size();
    let float = |f32: f32, f64: f64| if ty == Scalar::F32 { Value::from(f32) } else { Value::from(f64) };
    Some(match (name, ty.is_float()) {
        ("NAN", true) => float(f32::NAN, f64::NAN),
        ("INFINITY", true) => float(f32::INFINITY, f64::INFINITY),
        ("NEG_INFINITY", true) => float(f32::NEG_INFINITY, f64::NEG_INFINITY),
        ("MAX", true) => float(f32::MAX, f64::MAX),
        ("MIN", true) => float(f32::MIN, f64::MIN),
        ("EPSILON", true) => float(f32::EPSILON, f64::EPSILON),
        ("MAX", false) if ty.is_signed() => Value::new(ty, (1 << (bits - 1)) - 1),
        ("MIN", false) if ty.is_signed() => Value::new(ty, 1 << (bits - 1)),
        ("MAX", false) if ty.is_integer() => Value::new(ty, u64::MAX),
        ("MIN", false) if ty.is_integer() => Value::new(ty, 0),
        _ => return None,
    })
}
