//! Reads `match` expressions.

use crate::body::Body;
use crate::source::Error;
use crate::value::{Ty, Val, Var};
use scl::ir::{Binary, Expr, Scalar, Statement, Unary, Value, What};
use syn::spanned::Spanned;
use syn::{ExprMatch, Pat};

impl Body<'_, '_> {
    /// Reads a `match`; stores the value of the arm taken in `to`, if given. The last arm, unless it has a guard, is
    /// taken if no other arm matches.
    pub(crate) fn choose(&mut self, it: &ExprMatch, to: Option<&Var>) -> Result<(), Error> {
        let value = self.value(&it.expr, None)?;
        let value = self.fixed(value);
        let at = self.place_of_line();
        let mut arms = Vec::new();
        for (number, arm) in it.arms.iter().enumerate() {
            let is_last = number + 1 == it.arms.len();
            let condition = self.matches(&arm.pat, &value)?;
            let (body, ()) = self.apart(|this| match (&*arm.body, to) {
                (expr, Some(to)) => this.store(to, expr),
                (syn::Expr::Block(block), None) => this.block(&block.block, None),
                (expr, None) => this.block(
                    &syn::Block { brace_token: Default::default(), stmts: vec![syn::Stmt::Expr(expr.clone(), None)] },
                    None,
                ),
            })?;
            arms.push((if is_last && !matches!(arm.pat, Pat::Guard(_)) { None } else { condition }, body));
        }
        let mut otherwise: Vec<Statement> = Vec::new();
        for (condition, body) in arms.into_iter().rev() {
            otherwise = match condition {
                None => body,
                Some(condition) => vec![Statement { at, what: What::If(condition, body, otherwise) }],
            };
        }
        self.append(otherwise);
        Ok(())
    }

    /// The same value, stored in variables where necessary, so that it can be examined several times.
    fn fixed(&mut self, value: Val) -> Val {
        match value {
            Val::Number(expr @ Expr::After(..), ty) => match self.local("value", &ty, proc_macro2::Span::call_site()) {
                Ok(Var::Place(place, ty)) => {
                    self.assign(place.clone(), expr);
                    Var::Place(place, ty).load()
                }
                _ => Val::Number(expr, ty),
            },
            Val::Tuple(parts) => Val::Tuple(parts.into_iter().map(|part| self.fixed(part)).collect()),
            other => other,
        }
    }

    /// The condition under which a value matches a pattern; `None` if it always does.
    fn matches(&mut self, pat: &Pat, value: &Val) -> Result<Option<Expr>, Error> {
        let at = self.place_of_line();
        match (pat, value) {
            (Pat::Wild(_), _) => Ok(None),
            (Pat::Paren(it), _) => self.matches(&it.pat, value),
            (Pat::Tuple(it), Val::Tuple(parts)) if it.elems.len() == parts.len() => {
                let mut all = None;
                for (pat, part) in it.elems.iter().zip(parts) {
                    all = match (all, self.matches(pat, part)?) {
                        (Some(all), Some(one)) => Some(and(all, one, at)),
                        (all, one) => all.or(one),
                    };
                }
                Ok(all)
            }
            (Pat::Guard(it), _) => {
                let pattern = self.matches(&it.pat, value)?;
                let guard = self.condition(&it.guard)?;
                Ok(Some(match pattern {
                    Some(pattern) => and(pattern, guard, at),
                    None => guard,
                }))
            }
            (Pat::Or(it), _) => {
                let mut any: Option<Expr> = None;
                for pat in &it.cases {
                    let Some(one) = self.matches(pat, value)? else { return Ok(None) };
                    any = Some(match any {
                        Some(any) => Expr::Binary(Binary::Or, Scalar::Bool, Box::new(any), Box::new(one), at),
                        None => one,
                    });
                }
                Ok(any)
            }
            (Pat::Lit(it), Val::Number(expr, ty)) => {
                let (pattern, _) = self.number(&syn::Expr::Lit(it.clone()), Some(ty))?;
                Ok(Some(match (ty, &pattern) {
                    (Ty::Scalar(Scalar::Bool), Expr::Const(value)) if *value == Value::from(true) => expr.clone(),
                    (Ty::Scalar(Scalar::Bool), _) => Expr::Unary(Unary::Not, Scalar::Bool, Box::new(expr.clone())),
                    _ => {
                        let kept = ty.kept().unwrap_or(Scalar::I32);
                        Expr::Binary(Binary::Eq, kept, Box::new(expr.clone()), Box::new(pattern), at)
                    }
                }))
            }
            (Pat::Ident(it), Val::Number(expr, ty)) => {
                let name = it.ident.to_string();
                let var = self.local(&name, ty, it.span())?;
                if let Var::Place(place, _) = &var {
                    self.assign(place.clone(), expr.clone());
                }
                self.bind(&name, var);
                Ok(None)
            }
            _ => Err(self.error(pat.span(), "this pattern is not supported")),
        }
    }
}

fn and(a: Expr, b: Expr, at: scl::ir::At) -> Expr {
    Expr::Binary(Binary::And, Scalar::Bool, Box::new(a), Box::new(b), at)
}
