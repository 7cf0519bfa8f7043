//! The items declared in all files.

use crate::source::{Error, File, LIBRARY_PATH, Sources};
use crate::table::{Doc, Table, docs};
use proc_macro2::Span;
use syn::{Block, Expr, Ident, ImplItem, Item, Signature, Type};

/// The items that a law can use.
#[derive(Default)]
pub(crate) struct Items {
    pub functions: Vec<Function>,
    pub constants: Vec<Constant>,
    /// Type aliases: name and type.
    pub aliases: Vec<(String, Type)>,
    /// Newtypes of numbers: name and inner type.
    pub newtypes: Vec<(String, Type)>,
    /// Blocks, each with the index of its file.
    pub blocks: Vec<(usize, Table)>,
}

/// A function or a method.
pub(crate) struct Function {
    pub file: usize,
    /// The type whose `impl` contains it.
    pub owner: Option<String>,
    pub docs: Vec<Doc>,
    pub signature: Signature,
    pub body: Block,
}

pub(crate) struct Constant {
    pub file: usize,
    pub owner: Option<String>,
    pub name: Ident,
    pub ty: Type,
    pub value: Expr,
}

impl Items {
    pub(crate) fn read(sources: &Sources) -> Result<Items, Error> {
        let mut items = Items::default();
        for (number, file) in sources.files.iter().enumerate().filter(|(_, file)| file.path.ends_with(".rs")) {
            let parsed = syn::parse_file(&file.text).map_err(|error| in_file(file, &error))?;
            for item in parsed.items {
                items.add(number, file, item)?;
            }
        }
        Ok(items)
    }

    fn add(&mut self, file: usize, source: &File, item: Item) -> Result<(), Error> {
        match item {
            Item::Fn(it) => self.functions.push(Function {
                file,
                owner: None,
                docs: docs(&it.attrs),
                signature: it.sig,
                body: *it.block,
            }),
            Item::Const(it) => {
                self.constants.push(Constant { file, owner: None, name: it.ident, ty: *it.ty, value: *it.expr });
            }
            Item::Type(it) => self.aliases.push((it.ident.to_string(), *it.ty)),
            Item::Struct(it) => {
                if let syn::Fields::Unnamed(fields) = &it.fields
                    && let (1, Some(field)) = (fields.unnamed.len(), fields.unnamed.first())
                {
                    self.newtypes.push((it.ident.to_string(), field.ty.clone()));
                }
            }
            Item::Impl(it) => {
                let Some(owner) = type_name(&it.self_ty) else { return Ok(()) };
                for item in it.items {
                    match item {
                        ImplItem::Fn(method) => self.functions.push(Function {
                            file,
                            owner: Some(owner.clone()),
                            docs: docs(&method.attrs),
                            signature: method.sig,
                            body: method.block,
                        }),
                        ImplItem::Const(it) => self.constants.push(Constant {
                            file,
                            owner: Some(owner.clone()),
                            name: it.ident,
                            ty: it.ty,
                            value: it.expr,
                        }),
                        _ => {}
                    }
                }
            }
            Item::Macro(it) if it.mac.path.segments.last().is_some_and(|last| last.ident == "block") => {
                let table = it.mac.parse_body::<Table>().map_err(|error| in_file(source, &error))?;
                self.blocks.push((file, table));
            }
            _ => {}
        }
        Ok(())
    }

    /// The index of the function with this name, as visible in the file `from`: the library's, otherwise the file's
    /// own, otherwise the only one in all other files.
    pub(crate) fn function(&self, sources: &Sources, owner: Option<&str>, name: &str, from: usize) -> Option<usize> {
        let named = |it: &Function| it.owner.as_deref() == owner && it.signature.ident == name;
        let all: Vec<usize> = (0..self.functions.len()).filter(|number| named(&self.functions[*number])).collect();
        let of_library = |number: &&usize| sources.files[self.functions[**number].file].path == LIBRARY_PATH;
        let own = |number: &&usize| self.functions[**number].file == from;
        let only = || if all.len() == 1 { all.first() } else { None };
        all.iter().find(of_library).or_else(|| all.iter().find(own)).or_else(only).copied()
    }

    /// The constant with this name, as visible in the file `from`: the file's own, otherwise the only one in all other
    /// files.
    pub(crate) fn constant(&self, owner: Option<&str>, name: &str, from: usize) -> Option<&Constant> {
        let named = |it: &&Constant| it.owner.as_deref() == owner && it.name == name;
        let mut all = self.constants.iter().filter(named);
        let own = self.constants.iter().filter(named).find(|it| it.file == from);
        own.or_else(|| all.next().filter(|_| all.next().is_none()))
    }
}

/// The last segment of a type's path.
pub(crate) fn type_name(ty: &Type) -> Option<String> {
    match ty {
        Type::Path(path) => path.path.segments.last().map(|last| last.ident.to_string()),
        _ => None,
    }
}

/// A parser error in a file.
fn in_file(file: &File, error: &syn::Error) -> Error {
    let span: Span = error.span();
    Error::at(file, span, error.to_string())
}
