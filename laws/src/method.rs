//! Reads calls and conversions.

use crate::body::Body;
use crate::reader::owner_of;
use crate::source::Error;
use crate::value::{Ty, Val, Var};
use scl::ir::{Argument, Binary, Call, Convert, Expr, Place, Scalar, Statement, Unary, Value, What};
use syn::spanned::Spanned;
use syn::{ExprCall, ExprCast, ExprMethodCall, Stmt};

impl Body<'_, '_> {
    /// Reads `receiver.name(arguments)`.
    pub(crate) fn method(&mut self, it: &ExprMethodCall, want: Option<&Ty>) -> Result<Val, Error> {
        let name = it.method.to_string();
        let at = self.place_of_line();
        let arguments: Vec<&syn::Expr> = it.args.iter().collect();
        let unknown = |this: &Self, ty: &Ty| {
            this.error(
                it.method.span(),
                format!("the method {name} of {ty} is not supported; use operators or a function instead"),
            )
        };
        if let ("is_none" | "is_some", syn::Expr::MethodCall(checked)) = (&*name, &*it.receiver)
            && let Some(overflows) = self.overflows(checked)?
        {
            let value =
                if name == "is_none" { overflows } else { Expr::Unary(Unary::Not, Scalar::Bool, Box::new(overflows)) };
            return Ok(Val::Number(value, Ty::BOOL));
        }
        // A literal receiver has the type of the first argument, otherwise the expected type.
        let receiver = self.value(&it.receiver, None)?;
        let receiver = match receiver {
            Val::Number(_, Ty::Float | Ty::Integer) => {
                let ty = match (arguments.first(), want) {
                    (Some(argument), _) => self.common(&it.receiver, argument)?,
                    (None, Some(want)) => want.clone(),
                    (None, None) => {
                        return Err(self.error(
                            it.receiver.span(),
                            "the type of this number is ambiguous: add a suffix, such as 2.0_f64",
                        ));
                    }
                };
                self.value(&it.receiver, Some(&ty))?
            }
            other => other,
        };
        match receiver {
            Val::Var(Var::Place(place, Ty::Struct(record))) => {
                let owner = self.reader.block_of(record).unwrap_or_default();
                let function = self.reader.method(&owner, &name, self.file, it.method.span())?;
                self.call_function(function, Some(place), &arguments, it.span())
            }
            Val::Var(Var::Option(some, _)) if name == "is_some" || name == "is_none" => {
                let load = Expr::Load(Scalar::Bool, some);
                let value =
                    if name == "is_some" { load } else { Expr::Unary(Unary::Not, Scalar::Bool, Box::new(load)) };
                Ok(Val::Number(value, Ty::BOOL))
            }
            Val::Range(low, high, closed, ty) if name == "contains" && arguments.len() == 1 => {
                let (value, _) = self.number(arguments[0], Some(&Ty::Scalar(ty)))?;
                let above = Expr::Binary(Binary::Le, ty, Box::new(low), Box::new(value.clone()), at);
                let op = if closed { Binary::Le } else { Binary::Lt };
                let below = Expr::Binary(op, ty, Box::new(value), Box::new(high), at);
                Ok(Val::Number(Expr::Binary(Binary::And, Scalar::Bool, Box::new(above), Box::new(below), at), Ty::BOOL))
            }
            Val::Compared(left, right, ty) if name == "is_some_and" && arguments.len() == 1 => {
                let op = match arguments[0] {
                    syn::Expr::Path(path) => match path.path.segments.last().map(|last| last.ident.to_string()) {
                        Some(last) if last == "is_ne" => Some(Binary::Ne),
                        Some(last) if last == "is_eq" => Some(Binary::Eq),
                        Some(last) if last == "is_lt" => Some(Binary::Lt),
                        Some(last) if last == "is_le" => Some(Binary::Le),
                        Some(last) if last == "is_gt" => Some(Binary::Gt),
                        Some(last) if last == "is_ge" => Some(Binary::Ge),
                        _ => None,
                    },
                    _ => None,
                };
                let op =
                    op.ok_or_else(|| self.error(it.args.span(), "use Ordering::is_ne or a similar method here"))?;
                Ok(Val::Number(Expr::Binary(op, ty, Box::new(left), Box::new(right), at), Ty::BOOL))
            }
            Val::Number(value, ty @ Ty::New { .. }) => {
                let Ty::New { name: owner, kept, .. } = &ty else { return Err(unknown(self, &ty)) };
                if let Some(item) = self.reader.items.function(self.reader.sources, Some(owner), &name, self.file) {
                    return self.of_newtype(item, vec![(value, ty.clone())], &arguments, it.span());
                }
                match (&*name, arguments.len()) {
                    ("max" | "min", 1) => {
                        let (other, _) = self.number(arguments[0], Some(&ty))?;
                        let op = if name == "max" { Binary::Max } else { Binary::Min };
                        Ok(Val::Number(Expr::Binary(op, *kept, Box::new(value), Box::new(other), at), ty))
                    }
                    _ => Err(unknown(self, &ty)),
                }
            }
            Val::Number(value, Ty::Scalar(ty)) => self.of_number(it, &name, value, ty, &arguments),
            _ => Err(self.error(it.receiver.span(), "no methods of this value are supported here")),
        }
    }

    /// The condition under which `checked_add`, `checked_sub` or `checked_mul` overflows, for integers of up to 32
    /// bits; `None` for other methods.
    fn overflows(&mut self, it: &ExprMethodCall) -> Result<Option<Expr>, Error> {
        let at = self.place_of_line();
        let op = match &*it.method.to_string() {
            "checked_add" => Binary::Add,
            "checked_sub" => Binary::Sub,
            "checked_mul" => Binary::Mul,
            _ => return Ok(None),
        };
        let (value, ty) = self.number(&it.receiver, None)?;
        let (Ty::Scalar(kept), Some(other)) = (&ty, it.args.first()) else { return Ok(None) };
        if !kept.is_integer() || kept.size() == 8 {
            return Err(self.error(it.method.span(), format!("method {} of {ty} is not supported", it.method)));
        }
        let (other, _) = self.number(other, Some(&ty))?;
        let wide = |value| Box::new(self.converted(value, *kept, Scalar::I64));
        let exact = Expr::Binary(op, Scalar::I64, wide(value), wide(other), at);
        let limit = |which| Box::new(Expr::Const(Value::from(limit(*kept, which) as i64)));
        let below = Expr::Binary(Binary::Lt, Scalar::I64, Box::new(exact.clone()), limit("MIN"), at);
        let above = Expr::Binary(Binary::Gt, Scalar::I64, Box::new(exact), limit("MAX"), at);
        Ok(Some(Expr::Binary(Binary::Or, Scalar::Bool, Box::new(below), Box::new(above), at)))
    }

    /// Reads the call of a method of a number.
    fn of_number(
        &mut self,
        it: &ExprMethodCall,
        name: &str,
        value: Expr,
        ty: Scalar,
        arguments: &[&syn::Expr],
    ) -> Result<Val, Error> {
        let at = self.place_of_line();
        let want = Ty::Scalar(ty);
        let same = |value| Ok(Val::Number(value, Ty::Scalar(ty)));
        let one = |op, value| Expr::Unary(op, ty, Box::new(value));
        let bits = |value, to| Expr::Convert(Convert::Bits, ty, to, Box::new(value), at);
        match (name, arguments.len(), ty.is_float()) {
            ("abs", 0, _) => same(one(Unary::Abs, value)),
            ("sqrt", 0, true) => same(one(Unary::Sqrt, value)),
            ("wrapping_neg", 0, false) => same(one(Unary::Neg, value)),
            ("swap_bytes", 0, false) => same(one(Unary::Swap, value)),
            ("is_nan", 0, true) => {
                let equal = Expr::Binary(Binary::Eq, ty, Box::new(value.clone()), Box::new(value), at);
                Ok(Val::Number(Expr::Unary(Unary::Not, Scalar::Bool, Box::new(equal)), Ty::BOOL))
            }
            ("to_bits", 0, true) => {
                let to = if ty == Scalar::F32 { Scalar::U32 } else { Scalar::U64 };
                Ok(Val::Number(bits(value, to), Ty::Scalar(to)))
            }
            ("round_ties_even", 0, true) => Ok(Val::Rounded(Convert::Value, value, ty)),
            ("trunc", 0, true) => Ok(Val::Rounded(Convert::Trunc, value, ty)),
            ("ceil", 0, true) => Ok(Val::Rounded(Convert::Ceil, value, ty)),
            ("floor", 0, true) => Ok(Val::Rounded(Convert::Floor, value, ty)),
            ("cast_unsigned" | "cast_signed", 0, false) => {
                let to = other_sign(ty);
                Ok(Val::Number(self.converted(value, ty, to), Ty::Scalar(to)))
            }
            ("partial_cmp" | "cmp", 1, _) => {
                let (other, _) = self.number(arguments[0], Some(&want))?;
                Ok(Val::Compared(value, other, ty))
            }
            ("clamp", 2, _) => {
                let (low, _) = self.number(arguments[0], Some(&want))?;
                let (high, _) = self.number(arguments[1], Some(&want))?;
                same(Expr::Limit(ty, Box::new([low, value, high])))
            }
            ("max" | "min", 1, true) => {
                let kind = if ty == Scalar::F32 { "real" } else { "lreal" };
                self.of_library(&format!("{name}_{kind}"), value, arguments, it)
            }
            ("saturating_sub", 1, false) if ty == Scalar::I32 => {
                self.of_library("sub_saturating", value, arguments, it)
            }
            ("saturating_add", 1, false) if ty == Scalar::I32 => {
                self.of_library("add_saturating", value, arguments, it)
            }
            ("signum", 0, false) if ty == Scalar::I32 => self.of_library("sign", value, arguments, it),
            (_, 1, false) => {
                let op = match name {
                    "max" => Binary::Max,
                    "min" => Binary::Min,
                    "wrapping_add" => Binary::Add,
                    "wrapping_sub" => Binary::Sub,
                    "wrapping_mul" => Binary::Mul,
                    _ => return Err(self.error(it.method.span(), format!("method {name} of {ty} is not supported"))),
                };
                let (other, found) = self.number(arguments[0], Some(&want))?;
                if found != want {
                    return Err(self.error(it.args.span(), format!("expected {want}, found {found}")));
                }
                same(Expr::Binary(op, ty, Box::new(value), Box::new(other), at))
            }
            _ => Err(self.error(it.method.span(), format!("method {name} of {ty} is not supported"))),
        }
    }

    /// Calls a library function, with the receiver as its first argument.
    fn of_library(
        &mut self,
        name: &str,
        value: Expr,
        arguments: &[&syn::Expr],
        it: &ExprMethodCall,
    ) -> Result<Val, Error> {
        let item = self.reader.items.function(self.reader.sources, None, name, self.file);
        let item =
            item.ok_or_else(|| self.error(it.method.span(), format!("laws/src/library.rs has no function {name}")))?;
        let function = self.reader.function(item)?;
        let ty = self.reader.signatures[&function].parameters[0].clone();
        self.call_with(function, None, vec![(value, ty)], arguments, it.span())
    }

    /// Reads the call of a newtype's function: access to the inner number, a constructor, or an ordinary function.
    fn of_newtype(
        &mut self,
        item: usize,
        first: Vec<(Expr, Ty)>,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
    ) -> Result<Val, Error> {
        let items = self.reader.items;
        let function = &items.functions[item];
        if let [Stmt::Expr(tail, None)] = &function.body.stmts[..] {
            match (tail, first.first(), arguments) {
                (syn::Expr::Field(field), Some((value, Ty::New { kept, inner, .. })), []) => {
                    if matches!(&field.member, syn::Member::Unnamed(_)) {
                        return Ok(Val::Number(self.converted(value.clone(), *kept, *inner), Ty::Scalar(*inner)));
                    }
                }
                (syn::Expr::Call(call), None, [argument]) => {
                    if let syn::Expr::Path(path) = &*call.func
                        && let Some(name) = path.path.get_ident()
                        && (function.owner.as_deref() == Some(&name.to_string()) || name == "Self")
                    {
                        return self.newtype(function.owner.as_deref().unwrap_or_default(), argument, span);
                    }
                }
                _ => {}
            }
        }
        let function = self.reader.function(item)?;
        self.call_with(function, None, first, arguments, span)
    }

    /// Wraps a number in a newtype.
    fn newtype(&mut self, name: &str, argument: &syn::Expr, span: proc_macro2::Span) -> Result<Val, Error> {
        let parsed = syn::parse_str::<syn::Type>(name).map_err(|_| self.error(span, "this type is not supported"))?;
        let ty = self.reader.ty(self.file, &parsed, None)?;
        let Ty::New { kept, inner, .. } = &ty else { return Err(self.error(span, "this type is not supported")) };
        let (value, found) = self.number(argument, Some(&Ty::Scalar(*inner)))?;
        if found != Ty::Scalar(*inner) {
            return Err(self.error(argument.span(), format!("expected {inner}, found {found}")));
        }
        let value = self.converted(value, *inner, *kept);
        Ok(Val::Number(crate::body::folded(&value).map_or(value, Expr::Const), ty))
    }

    /// Reads `path(arguments)`.
    pub(crate) fn call_path(&mut self, it: &ExprCall, want: Option<&Ty>) -> Result<Val, Error> {
        let syn::Expr::Path(path) = &*it.func else {
            return Err(self.error(it.func.span(), "a function must be called by name here"));
        };
        let arguments: Vec<&syn::Expr> = it.args.iter().collect();
        let name = path.path.segments.last().map(|last| last.ident.to_string()).unwrap_or_default();
        let owner = owner_of(&path.path).filter(|owner| owner.starts_with(char::is_uppercase) || owner.len() <= 4);
        let owner = owner.map(|name| if name == "Self" { self.owner.clone().unwrap_or_default() } else { name });
        match (&owner, &*name, &arguments[..]) {
            (None, "Some", [argument]) => {
                let want = match want {
                    Some(Ty::Option(of)) => Some(&**of),
                    _ => None,
                };
                return Ok(Val::Option(Some(Box::new(self.value(argument, want)?))));
            }
            (Some(owner), "from", [argument]) => {
                if let Some(to) = self.scalar_named(owner) {
                    let (value, ty) = self.number(argument, None)?;
                    let Ty::Scalar(from) = ty else {
                        return Err(self.error(argument.span(), format!("{ty} cannot be converted here")));
                    };
                    return Ok(Val::Number(self.value_as(value, from, to), Ty::Scalar(to)));
                }
            }
            (None, newtype, [argument]) if self.reader.items.newtypes.iter().any(|(it, _)| it == newtype) => {
                return self.newtype(newtype, argument, it.span());
            }
            _ => {}
        }
        let item = self.reader.items.function(self.reader.sources, owner.as_deref(), &name, self.file);
        let Some(item) = item else {
            return Err(
                self.error(it.func.span(), format!("the function {name} is unknown here, or its name is not unique"))
            );
        };
        let is_newtype =
            owner.as_ref().is_some_and(|owner| self.reader.items.newtypes.iter().any(|(it, _)| it == owner));
        if is_newtype {
            return self.of_newtype(item, Vec::new(), &arguments, it.span());
        }
        let function = self.reader.function(item)?;
        self.call_function(function, None, &arguments, it.span())
    }

    fn call_function(
        &mut self,
        function: usize,
        instance: Option<Place>,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
    ) -> Result<Val, Error> {
        self.call_with(function, instance, Vec::new(), arguments, span)
    }

    /// Calls a function with the values in `first`, followed by the arguments.
    fn call_with(
        &mut self,
        function: usize,
        instance: Option<Place>,
        first: Vec<(Expr, Ty)>,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
    ) -> Result<Val, Error> {
        let signature = self.reader.signatures[&function].clone();
        let mut values = first;
        for argument in arguments {
            let want = signature.parameters.get(values.len());
            values.push(self.number(argument, want)?);
        }
        if values.len() != signature.parameters.len() {
            return Err(self.error(
                span,
                format!("wrong number of arguments: expected {}, found {}", signature.parameters.len(), values.len()),
            ));
        }
        for ((_, found), ty) in values.iter().zip(&signature.parameters) {
            if found != ty {
                return Err(self.error(span, format!("expected {ty}, found {found}")));
            }
        }
        let passed = values.into_iter().map(|(value, _)| Argument::Value(value)).collect();
        let at = self.place_of_line();
        let var = self.local("value", &signature.result, span)?;
        let outputs = signature.results.iter().copied().zip(var.places()).collect();
        let call = Call { function, instance, arguments: passed, outputs };
        match (&var, signature.result.kept()) {
            (Var::Place(place, ty), Some(kept)) => {
                self.note(signature.is_pure);
                let call = vec![Statement { at, what: What::Call(call) }];
                Ok(Val::Number(Expr::After(call, Box::new(Expr::Load(kept, place.clone()))), ty.clone()))
            }
            _ => {
                self.call(call, signature.is_pure);
                Ok(var.load())
            }
        }
    }

    /// Reads `expr as Type`.
    pub(crate) fn cast(&mut self, it: &ExprCast) -> Result<Val, Error> {
        let owner = self.owner.clone();
        let Ty::Scalar(to) = self.reader.ty(self.file, &it.ty, owner.as_deref())? else {
            return Err(self.error(it.ty.span(), "a number can only be converted to a number here"));
        };
        let at = self.place_of_line();
        // A conversion from floating point to a 64-bit integer and then to its low bits is a single conversion.
        let mut inner = &*it.expr;
        while let syn::Expr::Paren(paren) = inner {
            inner = &paren.expr;
        }
        if let syn::Expr::Cast(wide) = inner
            && to.is_integer()
            && self.reader.ty(self.file, &wide.ty, None)? == Ty::Scalar(Scalar::I64)
            && let Some((how, value, from)) = self.float(&wide.expr)?
        {
            return Ok(Val::Number(Expr::Convert(how, from, to, Box::new(value), at), Ty::Scalar(to)));
        }
        if to.is_integer()
            && let Some((how, value, from)) = self.float(&it.expr)?
        {
            // The cast saturates at the limits of the type; NaN becomes 0.
            let limits = |low: f64, high: f64, value| {
                Expr::Limit(Scalar::F64, Box::new([Expr::Const(low.into()), value, Expr::Const(high.into())]))
            };
            let wide = self.converted(value, from, Scalar::F64);
            let (low, high) = (limit(to, "MIN"), limit(to, "MAX"));
            let whole = Expr::Convert(how, Scalar::F64, to, Box::new(limits(low, high, wide)), at);
            return Ok(Val::Number(whole, Ty::Scalar(to)));
        }
        let (value, ty) = self.number(&it.expr, None)?;
        let from = match ty {
            Ty::Scalar(from) => from,
            Ty::Integer => Scalar::I64,
            Ty::Float => Scalar::F64,
            ty => return Err(self.error(it.expr.span(), format!("{ty} cannot be converted here"))),
        };
        Ok(Val::Number(self.value_as(value, from, to), Ty::Scalar(to)))
    }

    /// Reads the operand of a conversion to an integer: its rounding mode, value and type. `None` if it is not a
    /// floating-point number.
    fn float(&mut self, expr: &syn::Expr) -> Result<Option<(Convert, Expr, Scalar)>, Error> {
        let ty = self.ty(expr)?;
        if !matches!(ty, Ty::Scalar(Scalar::F32 | Scalar::F64)) {
            return Ok(None);
        }
        Ok(match self.value(expr, None)? {
            Val::Rounded(how, value, from) => Some((how, value, from)),
            Val::Number(value, Ty::Scalar(from)) => Some((Convert::Trunc, value, from)),
            _ => None,
        })
    }

    /// Converts a number by value, as `from` and `as` do; a truth value becomes 0 or 1.
    fn value_as(&self, value: Expr, from: Scalar, to: Scalar) -> Expr {
        let value = self.converted(value, from, to);
        crate::body::folded(&value).map_or(value, Expr::Const)
    }
}

/// The integer type of the same width with the opposite signedness.
fn other_sign(ty: Scalar) -> Scalar {
    match ty {
        Scalar::I8 => Scalar::U8,
        Scalar::I16 => Scalar::U16,
        Scalar::I32 => Scalar::U32,
        Scalar::I64 => Scalar::U64,
        Scalar::U8 => Scalar::I8,
        Scalar::U16 => Scalar::I16,
        Scalar::U32 => Scalar::I32,
        Scalar::U64 => Scalar::I64,
        other => other,
    }
}

/// The lowest or highest value of an integer type.
fn limit(ty: Scalar, which: &str) -> f64 {
    let bits = 8 * ty.size();
    let value = match (which, ty.is_signed()) {
        ("MIN", true) => Value::new(ty, 1 << (bits - 1)),
        ("MIN", false) => Value::new(ty, 0),
        (_, true) => Value::new(ty, (1 << (bits - 1)) - 1),
        (_, false) => Value::new(ty, u64::MAX),
    };
    value.number()
}
