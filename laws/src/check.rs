//! Reads the check that rejects a block's settings. In Rust, `check` returns a string, but typed programs have no
//! formatted strings. It is therefore read as a function that returns the number of the message and the numbers in
//! it; the messages are kept separately.

use crate::item::Function;
use crate::reader::Reader;
use crate::source::Error;
use crate::table::Table;
use proc_macro2::Span;
use scl::ir::{Base, Call, Place, Scalar, Statement, Type, What};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::visit_mut::{VisitMut, visit_expr_mut};
use syn::{Expr, Lit, Token};

/// The maximum number of numbers in a message.
pub const NUMBERS: usize = 4;

/// The check of a block's settings.
#[derive(Clone, Debug)]
pub struct Check {
    /// The index of the function that writes the check's result to memory: the 1-based number of the message (0 if the
    /// settings are accepted) to `refusal`, and the numbers in the message to `refusal_1`, `refusal_2` and so on.
    pub function: usize,
    /// The messages, in the order of their numbers. The character U+0001 is a placeholder for a number formatted with
    /// `{}`, U+0002 for one formatted with `{:?}`.
    pub messages: Vec<String>,
}

/// The members of memory that the check writes.
pub(crate) fn members() -> impl Iterator<Item = (String, Type)> {
    let number = |number| (format!("refusal_{number}"), Type::Scalar(Scalar::F64));
    std::iter::once(("refusal".to_string(), Type::Scalar(Scalar::I32))).chain((1..=NUMBERS).map(number))
}

/// The function read from a block's `check` method, and its messages.
pub(crate) struct Refusals {
    function: usize,
    messages: Vec<String>,
}

impl Reader<'_> {
    /// Reads the check of a block; `None` if it has none.
    pub(crate) fn refusals(&mut self, file: usize, table: &Table) -> Result<Option<Refusals>, Error> {
        let owner = table.ident.to_string();
        let items = self.items;
        let Some(item) = items.function(self.sources, Some(&owner), "check", file) else { return Ok(None) };
        let it = &items.functions[item];
        let mut rewrite = Rewrite::default();
        let mut body = it.body.clone();
        rewrite.visit_block_mut(&mut body);
        if let Some((span, message)) = rewrite.error {
            return Err(self.error(it.file, span, message));
        }
        let numbers = ", f64".repeat(NUMBERS);
        let signature = syn::parse_str(&format!("fn check(&self) -> (i32{numbers})"));
        let signature = signature.map_err(|error| self.error(it.file, error.span(), error.to_string()))?;
        let docs = Vec::new();
        let function = self.build(&Function { file: it.file, owner: it.owner.clone(), docs, signature, body })?;
        let docs = "Rejects unusable settings: returns the number of the message (0 for none) and the numbers in it.";
        self.program.docs.functions.insert(function, docs.to_string());
        Ok(Some(Refusals { function, messages: rewrite.messages }))
    }

    /// Adds a function without parameters that checks the block in memory, whose last members are [`members`].
    pub(crate) fn check(&mut self, file: usize, table: &Table, refusals: Refusals) -> Check {
        let Refusals { function, messages } = refusals;
        let first = self.program.records[self.program.memory].members.len() - 1 - NUMBERS;
        let places = (first..).map(|member| Place::new(Base::Memory).member(member));
        let outputs = self.signatures[&function].results.iter().copied().zip(places).collect();
        let instance = Some(Place::new(Base::Memory).member(0));
        let call = Call { function, instance, arguments: Vec::new(), outputs };
        let at = self.at(file, table.ident.span());
        let function = self.add_entry("check", vec![Statement { at, what: What::Call(call) }]);
        Check { function, messages }
    }
}

/// Rewrites `Ok(())` to `(0, 0.0, ...)`, and `Err(format!("...", a, b))` to `(1, a as f64, b as f64, ...)`.
#[derive(Default)]
struct Rewrite {
    messages: Vec<String>,
    error: Option<(Span, String)>,
}

impl VisitMut for Rewrite {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        let Expr::Call(call) = &*expr else { return visit_expr_mut(self, expr) };
        let is = |name: &str| matches!(&*call.func, Expr::Path(path) if path.path.is_ident(name));
        let rewritten = match call.args.first() {
            Some(_) if is("Ok") => tuple(0, Vec::new()),
            Some(message) if is("Err") => self.refusal(message),
            _ => return visit_expr_mut(self, expr),
        };
        match rewritten {
            Ok(rewritten) => *expr = rewritten,
            Err(error) => {
                self.error.get_or_insert((error.span(), error.to_string()));
            }
        }
    }
}

impl Rewrite {
    fn refusal(&mut self, message: &Expr) -> syn::Result<Expr> {
        let (text, mut given) = match message {
            Expr::Macro(it) if it.mac.path.is_ident("format") => {
                let parts = it.mac.parse_body_with(Punctuated::<Expr, Token![,]>::parse_terminated)?;
                let mut parts = parts.into_iter();
                (parts.next(), parts.collect::<Vec<_>>().into_iter())
            }
            Expr::MethodCall(it) => (Some((*it.receiver).clone()), Vec::new().into_iter()),
            _ => (None, Vec::new().into_iter()),
        };
        let Some(Expr::Lit(syn::ExprLit { lit: Lit::Str(text), .. })) = text else {
            return Err(syn::Error::new(
                message.span(),
                "a refusal must be format!(\"...\", numbers) or \"...\".into() here",
            ));
        };
        let unknown = |what: &str| syn::Error::new(text.span(), format!("{what} in a message is not supported"));
        let (mut plain, mut numbers) = (String::new(), Vec::new());
        let value = text.value();
        let mut rest = value.as_str();
        while let Some(begin) = rest.find(['{', '}']) {
            plain.push_str(&rest[..begin]);
            let doubled = &rest[begin..(begin + 2).min(rest.len())];
            if doubled == "{{" || doubled == "}}" {
                plain.push_str(&doubled[1..]);
                rest = &rest[begin + 2..];
                continue;
            }
            let end = rest.find('}').filter(|end| *end > begin).ok_or_else(|| unknown("a single }"))?;
            let (name, form) = rest[begin + 1..end].split_once(':').unwrap_or((&rest[begin + 1..end], ""));
            plain.push(match form {
                "" => '\u{1}',
                "?" => '\u{2}',
                form => return Err(unknown(&format!("{{:{form}}}"))),
            });
            numbers.push(match name {
                "" => given.next().ok_or_else(|| unknown("a {} without its number"))?,
                name => syn::parse_str(name)?,
            });
            rest = &rest[end + 1..];
        }
        plain.push_str(rest);
        if numbers.len() > NUMBERS {
            return Err(syn::Error::new(text.span(), format!("a message can have at most {NUMBERS} numbers here")));
        }
        self.messages.push(plain);
        tuple(self.messages.len(), numbers)
    }
}

/// The number of a refusal and the numbers in its message as a tuple, padded with 0 to [`NUMBERS`].
fn tuple(refusal: usize, numbers: Vec<Expr>) -> syn::Result<Expr> {
    // The numbers keep their source locations; new expressions have none.
    let mut elements: Punctuated<Expr, Token![,]> = Punctuated::new();
    elements.push(syn::parse_str(&refusal.to_string())?);
    let missing = NUMBERS - numbers.len();
    for number in numbers {
        let mut cast = syn::parse_str("(0) as f64")?;
        if let Expr::Cast(cast) = &mut cast
            && let Expr::Paren(inner) = &mut *cast.expr
        {
            *inner.expr = number;
        }
        elements.push(cast);
    }
    for _ in 0..missing {
        elements.push(syn::parse_str("0.0")?);
    }
    Ok(Expr::Tuple(syn::ExprTuple { attrs: Vec::new(), paren_token: Default::default(), elems: elements }))
}
