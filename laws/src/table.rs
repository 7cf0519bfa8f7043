//! Parses the table of a block: the contents of `block!`.

use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, Ident, LitStr, Meta, Token, Type, braced, parenthesized};

/// A block as declared in its source.
pub(crate) struct Table {
    /// The name of the struct in Rust.
    pub ident: Ident,
    /// The name of the block in the PLC.
    pub name: String,
    /// The parts of its documentation.
    pub docs: Vec<Doc>,
    pub rows: Vec<Row>,
    pub instances: Vec<Instance>,
    pub mean: Option<(Ident, Vec<Doc>)>,
    pub memory: Option<(Ident, Vec<Member>)>,
}

pub(crate) struct Row {
    pub section: Ident,
    pub field: Ident,
    pub kind: Ident,
    pub start: Option<Expr>,
    pub docs: Vec<Doc>,
}

pub(crate) struct Instance {
    pub field: Ident,
    pub block: Type,
    pub starts: Vec<(Ident, Expr)>,
    pub docs: Vec<Doc>,
}

pub(crate) struct Member {
    pub field: Ident,
    pub ty: Type,
    pub docs: Vec<Doc>,
}

/// A line of documentation, or the name of a file with documentation.
#[derive(Clone, Debug)]
pub(crate) enum Doc {
    Line(String),
    File(String),
}

/// The documentation in a list of attributes.
pub(crate) fn docs(attributes: &[Attribute]) -> Vec<Doc> {
    let of = |attribute: &Attribute| {
        let Meta::NameValue(pair) = &attribute.meta else { return None };
        if !pair.path.is_ident("doc") {
            return None;
        }
        match &pair.value {
            Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => {
                Some(Doc::Line(text.value().trim().to_string()))
            }
            Expr::Macro(included) => included.mac.parse_body::<LitStr>().ok().map(|file| Doc::File(file.value())),
            _ => None,
        }
    };
    attributes.iter().filter_map(of).collect()
}

/// The lines of the documentation before the first empty line or included file.
pub(crate) fn short(docs: &[Doc]) -> String {
    let line = |doc: &Doc| match doc {
        Doc::Line(line) if !line.is_empty() => Some(line.clone()),
        _ => None,
    };
    docs.iter().map_while(line).collect::<Vec<_>>().join("\n")
}

mod keyword {
    syn::custom_keyword!(mean);
    syn::custom_keyword!(instances);
    syn::custom_keyword!(memory);
    syn::custom_keyword!(from);
    syn::custom_keyword!(min);
    syn::custom_keyword!(max);
    syn::custom_keyword!(unit);
    syn::custom_keyword!(wired);
    syn::custom_keyword!(start);
}

impl Parse for Table {
    fn parse(input: ParseStream) -> syn::Result<Table> {
        let docs = docs(&input.call(Attribute::parse_outer)?);
        input.parse::<Token![pub]>()?;
        input.parse::<Token![struct]>()?;
        let ident = input.parse()?;
        input.parse::<Token![as]>()?;
        let name = input.parse::<LitStr>()?.value();
        while input.parse::<Option<Token![|]>>()?.is_some() {
            input.parse::<LitStr>()?;
        }
        let mut table = Table { ident, name, docs, rows: Vec::new(), instances: Vec::new(), mean: None, memory: None };
        let sections;
        braced!(sections in input);
        while !sections.is_empty() {
            let section: Ident = sections.parse()?;
            let rows;
            braced!(rows in sections);
            while !rows.is_empty() {
                table.rows.push(row(&rows, section.clone())?);
            }
        }
        while !input.is_empty() {
            table.part(input)?;
        }
        Ok(table)
    }
}

impl Table {
    /// Parses `mean`, `instances` or `memory`.
    fn part(&mut self, input: ParseStream) -> syn::Result<()> {
        let part;
        if input.parse::<Option<keyword::mean>>()?.is_some() {
            braced!(part in input);
            let docs = docs(&part.call(Attribute::parse_outer)?);
            self.mean = Some((part.parse()?, docs));
            part.parse::<Token![;]>()?;
        } else if input.parse::<Option<keyword::instances>>()?.is_some() {
            braced!(part in input);
            while !part.is_empty() {
                self.instances.push(instance(&part)?);
            }
        } else {
            input.parse::<keyword::memory>()?;
            let ident = input.parse()?;
            braced!(part in input);
            let mut members = Vec::new();
            while !part.is_empty() {
                let docs = docs(&part.call(Attribute::parse_outer)?);
                let field = part.parse()?;
                part.parse::<Token![:]>()?;
                members.push(Member { field, ty: part.parse()?, docs });
                part.parse::<Token![;]>()?;
            }
            self.memory = Some((ident, members));
        }
        Ok(())
    }
}

/// Parses `name: Kind = start, from a b, min x, max y, unit "u";`.
fn row(input: ParseStream, section: Ident) -> syn::Result<Row> {
    let docs = docs(&input.call(Attribute::parse_outer)?);
    let field = input.parse()?;
    input.parse::<Token![:]>()?;
    let kind = input.parse()?;
    let start = match input.parse::<Option<Token![=]>>()? {
        Some(_) => Some(input.parse()?),
        None => None,
    };
    while input.parse::<Option<Token![,]>>()?.is_some() {
        if input.parse::<Option<keyword::from>>()?.is_some() {
            while input.peek(syn::Ident) {
                input.parse::<Ident>()?;
            }
        } else if input.parse::<Option<keyword::unit>>()?.is_some() {
            input.parse::<LitStr>()?;
        } else {
            if input.parse::<Option<keyword::min>>()?.is_none() {
                input.parse::<keyword::max>()?;
            }
            input.parse::<Expr>()?;
        }
    }
    input.parse::<Token![;]>()?;
    Ok(Row { section, field, kind, start, docs })
}

/// Parses `name: Block { wired: a b; start: c = Bool(true), d = Real(1.0); }`.
fn instance(input: ParseStream) -> syn::Result<Instance> {
    let docs = docs(&input.call(Attribute::parse_outer)?);
    let field = input.parse()?;
    input.parse::<Token![:]>()?;
    let block = input.parse()?;
    let content;
    braced!(content in input);
    content.parse::<keyword::wired>()?;
    content.parse::<Token![:]>()?;
    while content.peek(syn::Ident) {
        content.parse::<Ident>()?;
    }
    content.parse::<Token![;]>()?;
    let mut starts = Vec::new();
    if content.parse::<Option<keyword::start>>()?.is_some() {
        content.parse::<Token![:]>()?;
        let list = Punctuated::<Start, Token![,]>::parse_separated_nonempty(&content)?;
        starts = list.into_iter().map(|Start(field, value)| (field, value)).collect();
        content.parse::<Token![;]>()?;
    }
    Ok(Instance { field, block, starts, docs })
}

struct Start(Ident, Expr);

impl Parse for Start {
    fn parse(input: ParseStream) -> syn::Result<Start> {
        let field = input.parse()?;
        input.parse::<Token![=]>()?;
        input.parse::<Ident>()?;
        let value;
        parenthesized!(value in input);
        Ok(Start(field, value.parse()?))
    }
}
