//! Converts items to a program: types, records and functions are each converted when first used.

use crate::body::Body;
use crate::check;
use crate::item::{Function, Items};
use crate::source::{Error, Sources};
use crate::table::{Doc, Table, short};
use crate::value::{Ty, Var};
use crate::{Law, ORIGINS};
use proc_macro2::Span;
use scl::ir::{
    self as typed, At, Base, Call, Declared, Expr, Kind, Place, Program, Scalar, Section, Statement, Type, Value, What,
};
use std::collections::BTreeMap;
use syn::spanned::Spanned;
use syn::{FnArg, Pat, ReturnType};

/// The input, and the program built from it so far.
pub(crate) struct Reader<'a> {
    pub sources: &'a Sources,
    pub items: &'a Items,
    pub program: Program,
    /// For each record, the Rust names and types of its fields, in member order.
    pub fields: BTreeMap<usize, Vec<(String, Ty)>>,
    /// The records of blocks, by struct name, and of their memories, by [`memory_name`].
    records: BTreeMap<String, usize>,
    /// The functions converted so far, by item index; `None` while being converted.
    made: BTreeMap<usize, Option<usize>>,
    /// The functions that clear a block's outputs and memory, by record.
    cleared: BTreeMap<usize, usize>,
    /// The signature of each converted function.
    pub signatures: BTreeMap<usize, Signature>,
}

/// The signature of a function.
#[derive(Clone, Debug)]
pub(crate) struct Signature {
    pub parameters: Vec<Ty>,
    pub result: Ty,
    /// The locals with the numbers of the result, in order.
    pub results: Vec<usize>,
    /// Whether it writes only to its own locals.
    pub is_pure: bool,
}

/// Reads the law of a block; `is_whole` adds the functions that only a host needs ([`crate::read_whole`]).
pub(crate) fn law(sources: &Sources, name: &str, is_whole: bool) -> Result<Law, Error> {
    let items = Items::read(sources)?;
    let find = || items.blocks.iter().find(|(_, table)| table.name.eq_ignore_ascii_case(name));
    let Some((file, table)) = find() else {
        return Err(Error {
            file: name.to_string(),
            line: 1,
            column: 1,
            message: "no source declares this block; check its name, or add its source file".to_string(),
        });
    };
    let mut reader = Reader {
        sources,
        items: &items,
        program: Program { files: sources.files.iter().map(|file| file.path.clone()).collect(), ..Program::default() },
        fields: BTreeMap::new(),
        records: BTreeMap::new(),
        made: BTreeMap::new(),
        cleared: BTreeMap::new(),
        signatures: BTreeMap::new(),
    };
    let record = reader.block(*file, table)?;
    let refusals = if is_whole { reader.refusals(*file, table)? } else { None };
    let mut members = vec![(table.name.clone(), Type::Record(record))];
    if table.mean.is_some() {
        members.push(("pulse".to_string(), Type::Scalar(Scalar::I32)));
    }
    if refusals.is_some() {
        members.extend(check::members());
    }
    reader.program.memory = reader.program.add_record("memory", members);
    reader.program.constants = reader.program.add_record("constants", []);
    let restart = reader.entry(*file, table, "restart")?;
    let call = reader.entry(*file, table, "call")?;
    let pulse = if is_whole && table.mean.is_some() { Some(reader.pulse(*file, table)?) } else { None };
    let check = refusals.map(|refusals| reader.check(*file, table, refusals));
    let mut program = reader.program;
    program.docs.head = head(sources, *file, table);
    Ok(Law { program, name: table.name.clone(), record, restart, call, pulse, check })
}

/// The comment at the head of the program: the summary of the block's documentation, and its clauses.
fn head(sources: &Sources, file: usize, table: &Table) -> String {
    let path = &sources.files[file].path;
    let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
    let lines = table.docs.iter().flat_map(|doc| match doc {
        Doc::Line(line) => line.lines().map(str::to_string).collect::<Vec<_>>(),
        Doc::File(name) => {
            let path = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
            let file = sources.files.iter().find(|file| file.path == path);
            file.map_or_else(Vec::new, |file| file.text.lines().map(str::to_string).collect())
        }
    });
    let lines: Vec<String> = lines.collect();
    let mut head = format!("{}: {}\n", table.name, short(&table.docs));
    head += &format!("The algorithm is written in {path}; names, order and comments are those of that file.\n");
    let clauses = lines.iter().skip_while(|line| line.trim() != "# Clauses").skip(1);
    let clauses: Vec<&str> = clauses.take_while(|line| !line.starts_with("# ")).map(String::as_str).collect();
    let clauses = clauses.join("\n");
    if !clauses.trim().is_empty() {
        head += &format!("\nClauses, to which the numbers in the comments refer:\n\n{}\n", clauses.trim());
        let named = ORIGINS.iter().filter(|(word, _)| clauses.contains(word));
        let origins: Vec<String> = named.map(|(word, whence)| format!("  {word}: {whence}")).collect();
        if !origins.is_empty() {
            head += &format!("\nThe words in brackets state the origin of a rule:\n\n{}\n", origins.join("\n"));
        }
    }
    head
}

impl Reader<'_> {
    pub(crate) fn error(&self, file: usize, span: Span, message: impl Into<String>) -> Error {
        Error::at(&self.sources.files[file], span, message)
    }

    pub(crate) fn at(&self, file: usize, span: Span) -> At {
        At { file: file as u16, line: span.start().line as u32 }
    }

    /// Resolves a Rust type.
    pub(crate) fn ty(&mut self, file: usize, ty: &syn::Type, owner: Option<&str>) -> Result<Ty, Error> {
        match ty {
            syn::Type::Tuple(tuple) => {
                Ok(Ty::Tuple(tuple.elems.iter().map(|ty| self.ty(file, ty, owner)).collect::<Result<_, _>>()?))
            }
            syn::Type::Reference(reference) => self.ty(file, &reference.elem, owner),
            syn::Type::Paren(inner) => self.ty(file, &inner.elem, owner),
            syn::Type::Path(path) => {
                let last = path.path.segments.last().expect("a path has a segment");
                if last.ident == "Option"
                    && let syn::PathArguments::AngleBracketed(arguments) = &last.arguments
                    && let Some(syn::GenericArgument::Type(of)) = arguments.args.first()
                {
                    return Ok(Ty::Option(Box::new(self.ty(file, of, owner)?)));
                }
                let name = last.ident.to_string();
                let name = if name == "Self" { owner.unwrap_or_default().to_string() } else { name };
                self.named(file, &name, owner)?.ok_or_else(|| {
                    self.error(
                        file,
                        ty.span(),
                        format!("the type {name} is not supported; use numbers, bool, tuples and blocks"),
                    )
                })
            }
            _ => Err(self.error(file, ty.span(), "this type is not supported; use numbers, bool, tuples and blocks")),
        }
    }

    fn named(&mut self, file: usize, name: &str, owner: Option<&str>) -> Result<Option<Ty>, Error> {
        if let Some(scalar) = number(name) {
            return Ok(Some(Ty::Scalar(scalar)));
        }
        let items = self.items;
        if let Some((_, inner)) = items.newtypes.iter().find(|(it, _)| it == name) {
            let Ty::Scalar(inner) = self.ty(file, inner, None)? else { return Ok(None) };
            // An analog word is a signed number in Rust and a bit string in a PLC.
            let kept = if name == "Word" { Scalar::U16 } else { inner };
            return Ok(Some(Ty::New { name: name.to_string(), kept, inner }));
        }
        if let Some((_, ty)) = items.aliases.iter().find(|(it, _)| it == name) {
            return self.ty(file, ty, None).map(Some);
        }
        if let Some((file, table)) = items.blocks.iter().find(|(_, table)| table.ident == name) {
            return Ok(Some(Ty::Struct(self.block(*file, table)?)));
        }
        // The struct name of a memory is not unique, so the memory is found by its block.
        let block = items.blocks.iter().find(|(number, table)| match owner {
            Some(owner) => table.ident == owner,
            None => *number == file,
        });
        let Some((file, table)) = block.filter(|(_, table)| table.memory.as_ref().is_some_and(|(it, _)| it == name))
        else {
            return Ok(None);
        };
        self.block(*file, table)?;
        Ok(self.records.get(&memory_name(table)).map(|record| Ty::Struct(*record)))
    }

    /// The record of a block, created on first use.
    pub(crate) fn block(&mut self, file: usize, table: &Table) -> Result<usize, Error> {
        let ident = table.ident.to_string();
        if let Some(record) = self.records.get(&ident) {
            return Ok(*record);
        }
        // For each member: its name in the program, its Rust name, its type and its description.
        let mut members: Vec<(String, String, Ty, String)> = Vec::new();
        let mut starts = Vec::new();
        for row in &table.rows {
            let ty = self
                .named(file, &row.kind.to_string(), None)?
                .ok_or_else(|| self.error(file, row.kind.span(), "this type is not supported"))?;
            starts.extend(row.start.as_ref().map(|start| (vec![members.len()], start, ty.clone())));
            members.push((upper(&row.field), row.field.to_string(), ty, short(&row.docs)));
        }
        for instance in &table.instances {
            let ty = self.ty(file, &instance.block, None)?;
            let Ty::Struct(inner) = ty else {
                return Err(self.error(file, instance.block.span(), "an instance must be a block"));
            };
            for (field, start) in &instance.starts {
                let (number, ty) = self
                    .field(inner, &field.to_string())
                    .ok_or_else(|| self.error(file, field.span(), "the inner block has no such variable"))?;
                starts.push((vec![members.len(), number], start, ty));
            }
            members.push((upper(&instance.field), instance.field.to_string(), ty, short(&instance.docs)));
        }
        if let Some((mean, docs)) = &table.mean {
            members.push((upper(mean), mean.to_string(), Ty::Scalar(Scalar::F64), short(docs)));
        }
        if let Some((_, memory)) = &table.memory {
            let mut inner = Vec::new();
            for member in memory {
                let ty = self.ty(file, &member.ty, Some(&ident))?;
                inner.push((member.field.to_string(), member.field.to_string(), ty, short(&member.docs)));
            }
            let record = self.record(file, &format!("{}_memory", table.name), inner)?;
            self.program.docs.records.insert(record, format!("The state that {} keeps between calls.", table.name));
            self.records.insert(memory_name(table), record);
            members.push((
                "memory".to_string(),
                "memory".to_string(),
                Ty::Struct(record),
                "The state that the block keeps between calls".to_string(),
            ));
        }
        let record = self.record(file, &table.name, members)?;
        self.program.docs.records.insert(record, short(&table.docs));
        for number in 0..self.program.records[record].members.len() {
            let is_mean = table.mean.is_some() && number == table.rows.len() + table.instances.len();
            let row = table.rows.get(number);
            let section = match row.map(|row| row.section.to_string()).as_deref() {
                Some("output") => Section::Output,
                Some("local") | None if !is_mean => Section::Static,
                None => Section::Host,
                Some(_) => Section::Input,
            };
            let of = row.and_then(|row| Kind::named(&row.kind.to_string().to_uppercase()));
            self.program.docs.declared.insert((record, number), Declared { section, of });
        }
        self.records.insert(ident.clone(), record);
        for (path, start, ty) in starts {
            let value = Body::constant(self, file, start, &ty)?;
            let place = path.iter().fold((0, Type::Record(record)), |(offset, ty), number| match ty {
                Type::Record(record) => {
                    let member = &self.program.records[record].members[*number];
                    (offset + member.offset, member.ty.clone())
                }
                other => (offset, other),
            });
            value.write(&mut self.program.records[record].start[place.0..]);
        }
        Ok(record)
    }

    fn record(&mut self, file: usize, name: &str, members: Vec<(String, String, Ty, String)>) -> Result<usize, Error> {
        let mut typed = Vec::new();
        for (name, _, ty, _) in &members {
            let ty = match ty {
                Ty::Struct(record) => Type::Record(*record),
                ty => Type::Scalar(
                    ty.kept().ok_or_else(|| self.error(file, Span::call_site(), format!("{name} is not a number")))?,
                ),
            };
            typed.push((name.clone(), ty));
        }
        let record = self.program.add_record(name, typed);
        for (number, (_, _, _, docs)) in members.iter().enumerate().filter(|(_, (.., docs))| !docs.is_empty()) {
            self.program.docs.members.insert((record, number), docs.clone());
        }
        self.fields.insert(record, members.into_iter().map(|(_, field, ty, _)| (field, ty)).collect());
        Ok(record)
    }

    /// The member index and type of a struct's field.
    pub(crate) fn field(&self, record: usize, name: &str) -> Option<(usize, Ty)> {
        let fields = self.fields.get(&record)?;
        let number = fields.iter().position(|(field, _)| field == name)?;
        Some((number, fields[number].1.clone()))
    }

    /// The name of the Rust struct that a record represents.
    pub(crate) fn block_of(&self, record: usize) -> Option<String> {
        self.records.iter().find(|(_, number)| **number == record).map(|(name, _)| name.clone())
    }

    /// Adds a function without parameters that calls a method of the block in memory and updates the pulse, if any.
    fn entry(&mut self, file: usize, table: &Table, method: &str) -> Result<usize, Error> {
        let owner = table.ident.to_string();
        let instance = Place::new(Base::Memory).member(0);
        let at = self.at(file, table.ident.span());
        let function = self.method(&owner, method, file, table.ident.span())?;
        let call = Call { function, instance: Some(instance.clone()), arguments: Vec::new(), outputs: Vec::new() };
        let mut body = vec![Statement { at, what: What::Call(call) }];
        if table.mean.is_some() {
            body.push(Statement { at, what: self.pulse_of(file, table)? });
        }
        Ok(self.add_entry(if method == "call" { "cycle" } else { method }, body))
    }

    /// Adds a function without parameters that updates the pulse of the block in memory.
    fn pulse(&mut self, file: usize, table: &Table) -> Result<usize, Error> {
        let body = vec![Statement { at: self.at(file, table.ident.span()), what: self.pulse_of(file, table)? }];
        Ok(self.add_entry("pulse", body))
    }

    /// The statement that updates the member `pulse`, which follows the block in memory.
    fn pulse_of(&mut self, file: usize, table: &Table) -> Result<What, Error> {
        let pulse = Place::new(Base::Memory).member(1);
        let Some(item) = self.items.function(self.sources, Some(&table.ident.to_string()), "pulse", file) else {
            return Ok(What::Assign(pulse, Expr::Const(Value::from(0_i32))));
        };
        let function = self.function(item)?;
        let result = self.signatures[&function].results[0];
        let instance = Some(Place::new(Base::Memory).member(0));
        Ok(What::Call(Call { function, instance, arguments: Vec::new(), outputs: vec![(result, pulse)] }))
    }

    /// Adds a function for the host to call.
    pub(crate) fn add_entry(&mut self, name: &str, body: Vec<Statement>) -> usize {
        self.program.functions.push(typed::Function {
            name: name.to_string(),
            instance: None,
            locals: Vec::new(),
            parameters: 0,
            body: typed::Body::Code(body),
        });
        self.program.functions.len() - 1
    }

    /// The function for a method of the block with this struct name.
    pub(crate) fn method(&mut self, owner: &str, name: &str, file: usize, span: Span) -> Result<usize, Error> {
        if let Some(item) = self.items.function(self.sources, Some(owner), name, file) {
            return self.function(item);
        }
        if name == "clear"
            && let Some((file, table)) = self.items.blocks.iter().find(|(_, table)| table.ident == owner)
        {
            return self.clear(*file, table);
        }
        Err(self.error(file, span, format!("{owner} has no method {name} that can be read")))
    }

    /// The function for the method `clear` that `block!` generates: it clears outputs, locals, mean and memory.
    fn clear(&mut self, file: usize, table: &Table) -> Result<usize, Error> {
        let record = self.block(file, table)?;
        if let Some(function) = self.cleared.get(&record) {
            return Ok(*function);
        }
        let at = self.at(file, table.ident.span());
        let mut body = Vec::new();
        let mut zero = |place: Place, ty: &Type| {
            if let Type::Scalar(ty) = ty {
                body.push(Statement { at, what: What::Assign(place, Expr::Const(Value::new(*ty, 0))) });
            }
        };
        let instance = Place::new(Base::Instance);
        for (number, member) in self.program.records[record].members.iter().enumerate() {
            let place = instance.clone().member(number);
            match (&member.ty, table.rows.get(number)) {
                (ty, Some(row)) if row.section == "output" || row.section == "local" => zero(place, ty),
                (_, Some(_)) => {}
                (Type::Record(inner), None) if member.name == "memory" => {
                    for (number, member) in self.program.records[*inner].members.iter().enumerate() {
                        zero(place.clone().member(number), &member.ty);
                    }
                }
                (ty, None) => zero(place, ty),
            }
        }
        self.program.functions.push(typed::Function {
            name: format!("{}.clear", table.name),
            instance: Some(record),
            locals: Vec::new(),
            parameters: 0,
            body: typed::Body::Code(body),
        });
        let function = self.program.functions.len() - 1;
        let docs = "Sets outputs, locals and memory to 0 or FALSE; inner blocks are not cleared.";
        self.program.docs.functions.insert(function, docs.to_string());
        let signature = Signature { parameters: Vec::new(), result: Ty::unit(), results: Vec::new(), is_pure: false };
        self.signatures.insert(function, signature);
        self.cleared.insert(record, function);
        Ok(function)
    }

    /// The function for an item, converted on first use.
    pub(crate) fn function(&mut self, item: usize) -> Result<usize, Error> {
        let items = self.items;
        let it = &items.functions[item];
        match self.made.get(&item) {
            Some(Some(function)) => return Ok(*function),
            Some(None) => return Err(self.error(it.file, it.signature.ident.span(), "a law must not call itself")),
            None => {}
        }
        self.made.insert(item, None);
        let function = self.build(it)?;
        self.made.insert(item, Some(function));
        Ok(function)
    }

    /// Converts a function and adds it to the program.
    pub(crate) fn build(&mut self, it: &Function) -> Result<usize, Error> {
        let items = self.items;
        let owner = it.owner.as_deref();
        let table = items.blocks.iter().find(|(_, table)| Some(table.ident.to_string().as_str()) == owner);
        let mut body = Body::new(self, it.file, it.owner.clone());
        let mut parameters = Vec::new();
        let mut instance = None;
        for input in &it.signature.inputs {
            match (input, table) {
                (FnArg::Receiver(_), Some((file, table))) => {
                    let record = body.reader.block(*file, table)?;
                    instance = Some(record);
                    body.bind("self", Var::Place(Place::new(Base::Instance), Ty::Struct(record)));
                }
                (FnArg::Receiver(receiver), None) => {
                    let name = owner.unwrap_or_default().to_string();
                    let ty = body
                        .reader
                        .named(it.file, &name, None)?
                        .ok_or_else(|| body.reader.error(it.file, receiver.span(), "this type is not supported"))?;
                    let var = body.local(&name.to_lowercase(), &ty, receiver.span())?;
                    body.bind("self", var);
                    parameters.push(ty);
                }
                (FnArg::Typed(typed), _) => {
                    let ty = body.reader.ty(it.file, &typed.ty, owner)?;
                    let Pat::Ident(name) = &*typed.pat else {
                        return Err(body.reader.error(
                            it.file,
                            typed.span(),
                            "a parameter must be a plain name here, not a pattern",
                        ));
                    };
                    if matches!(ty, Ty::Struct(_)) {
                        return Err(body.reader.error(it.file, typed.span(), "a parameter must be a number here"));
                    }
                    let var = body.local(&name.ident.to_string(), &ty, typed.span())?;
                    body.bind(&name.ident.to_string(), var);
                    parameters.push(ty);
                }
            }
        }
        let count = body.locals.len();
        let result = match &it.signature.output {
            ReturnType::Default => Ty::unit(),
            ReturnType::Type(_, ty) => body.reader.ty(it.file, ty, owner)?,
        };
        let var = body.local("result", &result, it.signature.ident.span())?;
        let results = (count..body.locals.len()).collect();
        let statements = body.function(&it.body, var)?;
        let (locals, is_pure) = (body.locals, body.is_pure);
        let name = it.signature.ident.to_string();
        let name = match (table, owner) {
            (Some((_, table)), _) => format!("{}.{name}", table.name),
            (None, Some(owner)) => format!("{}_{name}", owner.to_lowercase()),
            _ => name,
        };
        self.program.functions.push(typed::Function {
            name,
            instance,
            locals,
            parameters: count,
            body: typed::Body::Code(statements),
        });
        let function = self.program.functions.len() - 1;
        let docs = short(&it.docs);
        if !docs.is_empty() {
            self.program.docs.functions.insert(function, docs);
        }
        self.signatures.insert(function, Signature { parameters, result, results, is_pure });
        Ok(function)
    }
}

/// The key of a block's memory in [`Reader::records`].
fn memory_name(table: &Table) -> String {
    format!("{}::{}", table.ident, table.memory.as_ref().map_or(String::new(), |(name, _)| name.to_string()))
}

fn upper(name: &syn::Ident) -> String {
    name.to_string().to_uppercase()
}

/// The Rust number type with this name.
pub(crate) fn number(name: &str) -> Option<Scalar> {
    Some(match name {
        "bool" => Scalar::Bool,
        "i8" => Scalar::I8,
        "i16" => Scalar::I16,
        "i32" => Scalar::I32,
        "i64" => Scalar::I64,
        "u8" => Scalar::U8,
        "u16" => Scalar::U16,
        "u32" => Scalar::U32,
        "u64" => Scalar::U64,
        "f32" => Scalar::F32,
        "f64" => Scalar::F64,
        _ => return None,
    })
}

/// The type in a path such as `Type::item`.
pub(crate) fn owner_of(path: &syn::Path) -> Option<String> {
    let count = path.segments.len();
    (count >= 2).then(|| path.segments[count - 2].ident.to_string())
}

/// Whether a place is outside the locals of the function that uses it.
pub(crate) fn is_outside(place: &Place) -> bool {
    !matches!(place.base, Base::Local(_))
}
