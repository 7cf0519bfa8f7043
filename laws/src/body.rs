//! Reads statements.

use crate::reader::{Reader, is_outside};
use crate::source::Error;
use crate::value::{Ty, Val, Var};
use proc_macro2::Span;
use scl::ir::{At, Base, Binary, Call, Expr, Local, Place, Scalar, Statement, Type, Value, What};
use syn::spanned::Spanned;
use syn::{Block, Item, Pat, Stmt};

/// The state while reading a function body.
pub(crate) struct Body<'r, 'a> {
    pub reader: &'r mut Reader<'a>,
    pub file: usize,
    /// The type that the function belongs to, if it is a method or an associated function.
    pub owner: Option<String>,
    pub locals: Vec<Local>,
    scopes: Vec<Vec<(String, Var)>>,
    out: Vec<Statement>,
    /// Whether the function has so far written only to its own locals.
    pub is_pure: bool,
    /// The number of side effects so far, which remain even if the result is ignored.
    pub effects: usize,
    result: Option<Var>,
    at: At,
}

impl<'r, 'a> Body<'r, 'a> {
    pub(crate) fn new(reader: &'r mut Reader<'a>, file: usize, owner: Option<String>) -> Body<'r, 'a> {
        Body {
            reader,
            file,
            owner,
            locals: Vec::new(),
            scopes: vec![Vec::new()],
            out: Vec::new(),
            is_pure: true,
            effects: 0,
            result: None,
            at: At::default(),
        }
    }

    /// Evaluates a constant expression of this type.
    pub(crate) fn constant(reader: &mut Reader, file: usize, expr: &syn::Expr, ty: &Ty) -> Result<Value, Error> {
        let mut body = Body::new(reader, file, None);
        let (value, _) = body.number(expr, Some(ty))?;
        folded(&value).ok_or_else(|| body.error(expr.span(), "only a constant expression is supported here"))
    }

    pub(crate) fn error(&self, span: Span, message: impl Into<String>) -> Error {
        self.reader.error(self.file, span, message)
    }

    /// Reads the body of a function and stores its value in `result`.
    pub(crate) fn function(&mut self, block: &Block, result: Var) -> Result<Vec<Statement>, Error> {
        self.result = Some(result.clone());
        self.block(block, Some(&result))?;
        Ok(std::mem::take(&mut self.out))
    }

    /// Creates a variable of a type: one local for each number in it.
    pub(crate) fn local(&mut self, name: &str, ty: &Ty, span: Span) -> Result<Var, Error> {
        Ok(match ty {
            Ty::Tuple(parts) => {
                let part = |(number, ty): (usize, &Ty)| self.local(&format!("{name}_{}", number + 1), ty, span);
                Var::Tuple(parts.iter().enumerate().map(part).collect::<Result<_, _>>()?)
            }
            Ty::Option(of) => {
                let some = self.new_local(&format!("has_{name}"), Scalar::Bool);
                Var::Option(some, Box::new(self.local(name, of, span)?))
            }
            ty => {
                let kept = ty.kept().ok_or_else(|| {
                    let example = format!("let {name}: Real = ...;");
                    self.error(span, format!("the type of {name} is ambiguous ({ty}): declare it, as in {example}"))
                })?;
                Var::Place(self.new_local(name, kept), ty.clone())
            }
        })
    }

    fn new_local(&mut self, name: &str, ty: Scalar) -> Place {
        self.locals.push(Local { name: name.to_string(), ty: Type::Scalar(ty), by_reference: false });
        Place::new(Base::Local(self.locals.len() - 1))
    }

    /// Binds a name to a variable in the innermost scope.
    pub(crate) fn bind(&mut self, name: &str, var: Var) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.push((name.to_string(), var));
        }
    }

    /// The variable bound to a name.
    pub(crate) fn find(&self, name: &str) -> Option<&Var> {
        self.scopes.iter().rev().flat_map(|scope| scope.iter().rev()).find(|(it, _)| it == name).map(|(_, var)| var)
    }

    pub(crate) fn push(&mut self, what: What) {
        self.out.push(Statement { at: self.at, what });
    }

    pub(crate) fn append(&mut self, statements: Vec<Statement>) {
        self.out.extend(statements);
    }

    /// Runs `done` and returns its statements separately.
    pub(crate) fn apart<T>(
        &mut self,
        done: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<(Vec<Statement>, T), Error> {
        let before = std::mem::take(&mut self.out);
        let result = done(self);
        let statements = std::mem::replace(&mut self.out, before);
        Ok((statements, result?))
    }

    /// Runs `done` and returns its result; its statements, locals, bindings and effects are discarded.
    pub(crate) fn tried<T>(&mut self, done: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<T, Error> {
        let (locals, effects, is_pure, scopes) = (self.locals.len(), self.effects, self.is_pure, self.scopes.clone());
        let result = self.apart(done).map(|(_, result)| result);
        self.locals.truncate(locals);
        (self.effects, self.is_pure, self.scopes) = (effects, is_pure, scopes);
        result
    }

    pub(crate) fn assign(&mut self, to: Place, value: Expr) {
        if is_outside(&to) {
            self.is_pure = false;
            self.effects += 1;
        }
        self.push(What::Assign(to, value));
    }

    /// Reads a block with its own scope; stores the block's value in `to`, if given.
    pub(crate) fn block(&mut self, block: &Block, to: Option<&Var>) -> Result<(), Error> {
        self.scopes.push(Vec::new());
        self.statements(block, to)?;
        self.scopes.pop();
        Ok(())
    }

    /// Reads the statements of a block in the current scope; stores the block's value in `to`, if given.
    pub(crate) fn statements(&mut self, block: &Block, to: Option<&Var>) -> Result<(), Error> {
        let last = block.stmts.len();
        for (number, statement) in block.stmts.iter().enumerate() {
            self.at = self.reader.at(self.file, statement.span());
            let file = &self.reader.sources.files[self.file];
            let (start, end) = (statement.span().start(), statement.span().end());
            // A comment before a line belongs to the statement that starts there, not to those within its braces.
            if start.line > block.brace_token.span.open().start().line {
                for comment in file.comments_before(start.line) {
                    self.push(What::Comment(comment));
                }
            }
            let is_one_line = start.line == end.line;
            let behind = file.comment_behind(end.line, end.column).filter(|_| is_one_line);
            behind.into_iter().for_each(|comment| self.push(What::Comment(comment)));
            match statement {
                Stmt::Local(it) => self.declare(it)?,
                Stmt::Item(Item::Const(it)) => {
                    let ty = self.reader.ty(self.file, &it.ty, None)?;
                    let value = Body::constant(self.reader, self.file, &it.expr, &ty)?;
                    let var = self.local(&it.ident.to_string(), &ty, it.ident.span())?;
                    for place in var.places() {
                        self.assign(place, Expr::Const(value));
                    }
                    self.bind(&it.ident.to_string(), var);
                }
                Stmt::Item(Item::Use(_)) => {}
                Stmt::Expr(expr, None) if number + 1 == last => match to {
                    Some(to) if to.ty() != Ty::unit() => self.store(to, expr)?,
                    _ => self.statement(expr)?,
                },
                Stmt::Expr(expr, _) => self.statement(expr)?,
                other => return Err(self.error(other.span(), "this statement is not supported")),
            }
        }
        Ok(())
    }

    /// Reads a `let`.
    fn declare(&mut self, it: &syn::Local) -> Result<(), Error> {
        let Some(init) = it.init.as_ref().filter(|init| init.diverge.is_none()) else {
            return Err(self.error(it.span(), "a variable must be initialized where it is declared"));
        };
        let (pat, ty) = match &it.pat {
            Pat::Type(typed) => {
                let ty = self.reader.ty(self.file, &typed.ty, self.owner.clone().as_deref())?;
                (&*typed.pat, Some(ty))
            }
            pat => (pat, None),
        };
        if let Some(var) = self.place(&init.expr)?
            && let Var::Place(_, Ty::Struct(record)) = &var
        {
            // A struct is not copied: the new name is bound to it, or its fields are copied to new variables.
            return match pat {
                Pat::Ident(name) => {
                    self.bind(&name.ident.to_string(), var);
                    Ok(())
                }
                Pat::Struct(fields) => self.copy_fields(fields, &var, *record),
                _ => Err(self.error(pat.span(), "this pattern is not supported")),
            };
        }
        let ty = match ty {
            Some(ty) => ty,
            None => self.ty(&init.expr)?,
        };
        let (var, names) = self.pattern(pat, &ty)?;
        self.store(&var, &init.expr)?;
        names.into_iter().for_each(|(name, var)| self.bind(&name, var));
        Ok(())
    }

    fn copy_fields(&mut self, fields: &syn::PatStruct, from: &Var, record: usize) -> Result<(), Error> {
        let Var::Place(place, _) = from else { return Ok(()) };
        for field in &fields.fields {
            let syn::Member::Named(name) = &field.member else {
                return Err(self.error(field.span(), "this pattern is not supported"));
            };
            let found = self.reader.field(record, &name.to_string());
            let (number, ty) = found.ok_or_else(|| self.error(name.span(), "the struct has no such field"))?;
            let (var, names) = self.pattern(&field.pat, &ty)?;
            if let (Var::Place(to, _), Some(kept)) = (&var, ty.kept()) {
                self.assign(to.clone(), Expr::Load(kept, place.clone().member(number)));
            } else {
                return Err(self.error(field.span(), "only numbers can be copied here"));
            }
            names.into_iter().for_each(|(name, var)| self.bind(&name, var));
        }
        Ok(())
    }

    /// Creates variables for a pattern, and returns the names that it binds.
    fn pattern(&mut self, pat: &Pat, ty: &Ty) -> Result<(Var, Vec<(String, Var)>), Error> {
        match (pat, ty) {
            (Pat::Ident(it), ty) if it.subpat.is_none() => {
                let name = it.ident.to_string();
                let var = self.local(&name, ty, it.span())?;
                Ok((var.clone(), vec![(name, var)]))
            }
            (Pat::Wild(it), ty) => Ok((self.local("unused", ty, it.span())?, Vec::new())),
            (Pat::Tuple(it), Ty::Tuple(parts)) if it.elems.len() == parts.len() => {
                let (mut vars, mut names) = (Vec::new(), Vec::new());
                for (pat, ty) in it.elems.iter().zip(parts) {
                    let (var, more) = self.pattern(pat, ty)?;
                    vars.push(var);
                    names.extend(more);
                }
                Ok((Var::Tuple(vars), names))
            }
            _ => Err(self.error(pat.span(), format!("this pattern does not fit {ty}, or is not supported"))),
        }
    }

    /// Stores the value of an expression in a variable.
    pub(crate) fn store(&mut self, to: &Var, expr: &syn::Expr) -> Result<(), Error> {
        match expr {
            syn::Expr::Paren(it) => return self.store(to, &it.expr),
            syn::Expr::Block(it) => return self.block(&it.block, Some(to)),
            syn::Expr::If(it) => return self.branch(it, Some(to)),
            syn::Expr::Match(it) => return self.choose(it, Some(to)),
            syn::Expr::Return(_) => return self.statement(expr),
            syn::Expr::Tuple(it) => {
                if let Var::Tuple(parts) = to
                    && parts.len() == it.elems.len()
                {
                    return parts.iter().zip(&it.elems).try_for_each(|(to, expr)| self.store(to, expr));
                }
            }
            _ => {}
        }
        let value = self.value(expr, Some(&to.ty()))?;
        self.put(to, value, expr.span())
    }

    /// Stores a value in a variable of its type.
    fn put(&mut self, to: &Var, value: Val, span: Span) -> Result<(), Error> {
        match (to, value) {
            (Var::Place(place, ty), Val::Number(expr, found)) => {
                if *ty != found {
                    return Err(self.error(span, format!("expected {ty}, found {found}")));
                }
                self.assign(place.clone(), expr);
                Ok(())
            }
            (Var::Tuple(parts), Val::Tuple(values)) if parts.len() == values.len() => {
                parts.iter().zip(values).try_for_each(|(to, value)| self.put(to, value, span))
            }
            (Var::Option(some, _), Val::Option(None)) => {
                self.assign(some.clone(), Expr::Const(Value::from(false)));
                Ok(())
            }
            (Var::Option(some, to), Val::Option(Some(value))) => {
                self.assign(some.clone(), Expr::Const(Value::from(true)));
                self.put(to, *value, span)
            }
            (Var::Option(some, to), Val::Var(Var::Option(from_some, from))) => {
                self.assign(some.clone(), Expr::Load(Scalar::Bool, from_some));
                self.put(to, from.load(), span)
            }
            (to, _) => Err(self.error(span, format!("expected {}", to.ty()))),
        }
    }

    /// Reads an expression statement.
    fn statement(&mut self, expr: &syn::Expr) -> Result<(), Error> {
        match expr {
            syn::Expr::Assign(it) => self.assignment(&it.left, &it.right),
            syn::Expr::Binary(it) => match compound(&it.op) {
                Some(op) => {
                    let Some(Var::Place(place, ty)) = self.place(&it.left)? else {
                        return Err(self.error(it.left.span(), "this is not a variable"));
                    };
                    let kept = ty.kept().ok_or_else(|| self.error(it.left.span(), "this is not a number"))?;
                    let (value, found) = self.number(&it.right, Some(&ty))?;
                    if found != ty {
                        return Err(self.error(it.right.span(), format!("expected {ty}, found {found}")));
                    }
                    let load = Box::new(Expr::Load(kept, place.clone()));
                    self.assign(place, Expr::Binary(op, kept, load, Box::new(value), self.at));
                    Ok(())
                }
                None => Err(self.error(expr.span(), "the value of this expression is unused")),
            },
            syn::Expr::If(it) => self.branch(it, None),
            syn::Expr::Match(it) => self.choose(it, None),
            syn::Expr::Block(it) => self.block(&it.block, None),
            syn::Expr::Paren(it) => self.statement(&it.expr),
            syn::Expr::While(it) => {
                let condition = self.condition(&it.cond)?;
                let (body, ()) = self.apart(|this| this.block(&it.body, None))?;
                self.push(What::While(condition, body));
                Ok(())
            }
            syn::Expr::Loop(it) => {
                let (body, ()) = self.apart(|this| this.block(&it.body, None))?;
                self.push(What::While(Expr::Const(Value::from(true)), body));
                Ok(())
            }
            syn::Expr::Break(it) if it.expr.is_none() && it.label.is_none() => {
                self.push(What::Break);
                Ok(())
            }
            syn::Expr::Continue(it) if it.label.is_none() => {
                self.push(What::Continue);
                Ok(())
            }
            syn::Expr::Return(it) => {
                match (&it.expr, self.result.clone()) {
                    (Some(value), Some(result)) if result.ty() != Ty::unit() => self.store(&result, value)?,
                    (Some(value), _) => self.statement(value)?,
                    (None, _) => {}
                }
                self.push(What::Return);
                Ok(())
            }
            syn::Expr::Call(_) | syn::Expr::MethodCall(_) => match self.value(expr, None)? {
                Val::Number(Expr::After(before, _), _) => {
                    self.append(before);
                    Ok(())
                }
                _ => Ok(()),
            },
            syn::Expr::Tuple(it) if it.elems.is_empty() => Ok(()),
            _ => {
                Err(self.error(expr.span(), "this statement is not supported; use let, =, if, match, while and calls"))
            }
        }
    }

    fn assignment(&mut self, to: &syn::Expr, from: &syn::Expr) -> Result<(), Error> {
        let Some(var) = self.place(to)? else {
            return Err(self.error(to.span(), "this is not a variable"));
        };
        let Var::Place(place, Ty::Struct(record)) = &var else { return self.store(&var, from) };
        // All values are computed before the first field is assigned, because they may be computed from old fields.
        let syn::Expr::Struct(it) = from else {
            return Err(self.error(from.span(), "write a struct as Name { field: value, ... }"));
        };
        let fields = self.reader.fields[record].clone();
        if it.rest.is_some() || it.fields.len() != fields.len() {
            return Err(self.error(from.span(), "all fields of the struct must be listed here"));
        }
        let mut values = Vec::new();
        for field in &it.fields {
            let syn::Member::Named(name) = &field.member else { continue };
            let found = self.reader.field(*record, &name.to_string());
            let (number, ty) = found.ok_or_else(|| self.error(name.span(), "the struct has no such field"))?;
            let (value, found) = self.number(&field.expr, Some(&ty))?;
            if found != ty {
                return Err(self.error(field.expr.span(), format!("expected {ty}, found {found}")));
            }
            let is_fixed = match &value {
                Expr::Const(_) => true,
                Expr::Load(_, place) => !is_outside(place),
                _ => false,
            };
            let value = match (is_fixed, ty.kept()) {
                (false, Some(kept)) => {
                    let place = self.new_local(&name.to_string(), kept);
                    self.assign(place.clone(), value);
                    Expr::Load(kept, place)
                }
                _ => value,
            };
            values.push((place.clone().member(number), value));
        }
        values.into_iter().for_each(|(to, value)| self.assign(to, value));
        Ok(())
    }

    /// Reads an `if`; stores the value of the branch taken in `to`, if given.
    fn branch(&mut self, it: &syn::ExprIf, to: Option<&Var>) -> Result<(), Error> {
        let at = self.at;
        self.scopes.push(Vec::new());
        let condition = match &*it.cond {
            syn::Expr::Let(it) => self.if_let(it)?,
            condition => self.condition(condition)?,
        };
        let (then, ()) = self.apart(|this| this.block(&it.then_branch, to))?;
        self.scopes.pop();
        let (otherwise, ()) = self.apart(|this| match &it.else_branch {
            Some((_, expr)) => match to {
                Some(to) => this.store(to, expr),
                None => this.statement(expr),
            },
            None => Ok(()),
        })?;
        self.at = at;
        self.push(What::If(condition, then, otherwise));
        Ok(())
    }

    /// The condition of `if let Some(name) = ...`; binds the name.
    pub(crate) fn if_let(&mut self, it: &syn::ExprLet) -> Result<Expr, Error> {
        let unknown = |this: &Self| this.error(it.pat.span(), "this pattern is not supported; use Some(name)");
        let Pat::TupleStruct(pat) = &*it.pat else { return Err(unknown(self)) };
        let (Some(inner), true) = (pat.elems.first(), pat.path.is_ident("Some")) else { return Err(unknown(self)) };
        let Val::Var(Var::Option(some, value)) = self.value(&it.expr, None)? else {
            return Err(self.error(it.expr.span(), "this is not an Option"));
        };
        match inner {
            Pat::Ident(name) => self.bind(&name.ident.to_string(), *value),
            Pat::Wild(_) => {}
            _ => return Err(unknown(self)),
        }
        Ok(Expr::Load(Scalar::Bool, some))
    }

    /// Reads an expression of type bool.
    pub(crate) fn condition(&mut self, expr: &syn::Expr) -> Result<Expr, Error> {
        let (condition, ty) = self.number(expr, Some(&Ty::BOOL))?;
        if ty == Ty::BOOL { Ok(condition) } else { Err(self.error(expr.span(), format!("expected bool, found {ty}"))) }
    }

    /// Adds a call as a statement; `is_pure` means that the called function writes only to its own locals.
    pub(crate) fn call(&mut self, call: Call, is_pure: bool) {
        let what = What::Call(call);
        self.note(is_pure);
        self.push(what);
    }

    /// Records the side effects of a call, unless the called function writes only to its own locals.
    pub(crate) fn note(&mut self, is_pure: bool) {
        if !is_pure {
            self.is_pure = false;
            self.effects += 1;
        }
    }

    pub(crate) fn place_of_line(&self) -> At {
        self.at
    }
}

/// The operation of a compound assignment such as `+=`.
fn compound(op: &syn::BinOp) -> Option<Binary> {
    Some(match op {
        syn::BinOp::AddAssign(_) => Binary::Add,
        syn::BinOp::SubAssign(_) => Binary::Sub,
        syn::BinOp::MulAssign(_) => Binary::Mul,
        syn::BinOp::DivAssign(_) => Binary::Div,
        syn::BinOp::RemAssign(_) => Binary::Rem,
        syn::BinOp::BitAndAssign(_) => Binary::And,
        syn::BinOp::BitOrAssign(_) => Binary::Or,
        syn::BinOp::BitXorAssign(_) => Binary::Xor,
        _ => return None,
    })
}

/// The value of an expression, if it is constant.
pub(crate) fn folded(expr: &Expr) -> Option<Value> {
    match expr {
        Expr::Const(value) => Some(*value),
        Expr::Unary(op, _, a) => op.fold(folded(a)?),
        Expr::Binary(op, _, a, b, _) => op.fold(folded(a)?, folded(b)?).map(|(value, _)| value),
        Expr::Convert(how, _, to, a, _) => how.fold(folded(a)?, *to).map(|(value, _)| value),
        _ => None,
    }
}
