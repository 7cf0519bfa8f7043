//! Prints block heads, types, sections and data blocks.

use super::facts::Use;
use super::{Dialect, Printer, Scope, declared, literal};
use crate::check::types::text_name;
use crate::ir::{Body, Function, Kind, Section, Type, Value};
use std::fmt::Write;

impl<'a> Printer<'a> {
    /// Prints the source's documentation of the program as a whole.
    pub(super) fn head(&mut self) {
        let head = self.program.docs.head.trim_end();
        if head.is_empty() {
            return;
        }
        for line in head.lines() {
            let _ = writeln!(self.text, "{}", format!("// {line}").trim_end());
        }
    }

    /// Prints the attributes and the version that follow the name of a block.
    fn attributes(&mut self) {
        self.text.push_str(match self.dialect {
            Dialect::Tia => "{ S7_Optimized_Access := 'TRUE' }\nVERSION : 0.1\n",
            Dialect::Step7 => "VERSION : '0.1'\n",
        });
    }

    fn docs(&mut self, docs: Option<&String>) {
        for line in docs.into_iter().flat_map(|docs| docs.lines()) {
            let _ = writeln!(self.text, "// {line}");
        }
    }

    /// Prints the types of all records in use that are not instances of blocks.
    pub(super) fn types(&mut self) -> Result<(), String> {
        let mut done = Vec::new();
        for number in self.facts.reached.clone() {
            let function = &self.program.functions[number];
            if let Some(record) = function.instance {
                self.types_in(&Type::Record(record), &mut done)?;
            }
            for local in &function.locals {
                self.types_in(&local.ty, &mut done)?;
            }
        }
        for number in self.used_globals() {
            let ty = self.program.records[self.program.memory].members[number].ty.clone();
            self.types_in(&ty, &mut done)?;
        }
        Ok(())
    }

    fn types_in(&mut self, ty: &Type, done: &mut Vec<usize>) -> Result<(), String> {
        let record = match ty {
            Type::Array { of, .. } | Type::Open { of, .. } => return self.types_in(of, done),
            Type::Record(record) if !done.contains(record) => *record,
            _ => return Ok(()),
        };
        done.push(record);
        if self.facts.systems.contains_key(&record) {
            return Ok(());
        }
        let program = self.program;
        for member in &program.records[record].members {
            self.types_in(&member.ty, done)?;
        }
        if self.facts.blocks.contains_key(&record) {
            return Ok(());
        }
        let _ = writeln!(self.text, "\nTYPE \"{}\"", self.records[record]);
        if self.dialect == Dialect::Tia {
            self.text.push_str("VERSION : 0.1\n");
        }
        self.docs(program.docs.records.get(&record));
        self.text.push_str("    STRUCT\n");
        let members: Vec<usize> = (0..program.records[record].members.len()).collect();
        self.members(record, &members, 2)?;
        self.text.push_str("    END_STRUCT;\nEND_TYPE\n");
        Ok(())
    }

    /// The SCL name of a variable's type.
    fn type_name(&self, ty: &Type, kind: Option<Kind>) -> Result<String, String> {
        Ok(match ty {
            Type::Scalar(ty) => self.dialect.check(declared(*ty, kind))?.name().to_string(),
            Type::Text { wide: true, .. } if self.dialect == Dialect::Step7 => {
                return Err("STEP 7 has no type WSTRING; print the program for TIA Portal".to_string());
            }
            Type::Text { capacity, wide } => format!("{}[{capacity}]", text_name(*wide)),
            Type::Array { of, bounds } => {
                let bounds: Vec<String> = bounds.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                format!("ARRAY[{}] OF {}", bounds.join(", "), self.type_name(of, kind)?)
            }
            Type::Open { .. } if self.dialect == Dialect::Step7 => {
                return Err("STEP 7 has no ARRAY[*]; print the program for TIA Portal".to_string());
            }
            Type::Open { of, dimensions } => {
                format!("ARRAY[{}] OF {}", vec!["*"; *dimensions].join(", "), self.type_name(of, kind)?)
            }
            Type::Record(record) => match self.facts.systems.get(record) {
                Some(system) if self.dialect == Dialect::Step7 => system.trim_end_matches("_TIME").to_string(),
                Some(system) => system.clone(),
                None => format!("\"{}\"", self.records[*record]),
            },
        })
    }

    /// Prints members of a record as declarations.
    fn members(&mut self, record: usize, members: &[usize], indent: usize) -> Result<(), String> {
        let program = self.program;
        let mut lines: Vec<(String, String)> = Vec::new();
        for number in members {
            let member = &program.records[record].members[*number];
            let said = program.docs.declared.get(&(record, *number));
            let name = self.member(&member.name)?;
            let attribute = match (&member.ty, self.dialect) {
                (Type::Record(inner), Dialect::Tia) => self
                    .facts
                    .systems
                    .get(inner)
                    .map(|system| format!(" {{InstructionName := '{system}'; LibVersion := '1.0'}}")),
                _ => None,
            };
            let kind = said.and_then(|said| said.of);
            let ty = self.type_name(&member.ty, kind)?;
            let bytes = &program.records[record].start[member.offset..member.offset + program.size(&member.ty)];
            let start = self.start(&member.ty, kind, bytes)?;
            let start = start.map_or(String::new(), |start| format!(" := {start}"));
            let line = format!("{}{name}{} : {ty}{start};", "    ".repeat(indent), attribute.unwrap_or_default());
            let docs = program.docs.members.get(&(record, *number)).cloned().unwrap_or_default();
            lines.push((line, docs.replace('\n', " ")));
        }
        let column = lines.iter().map(|(line, _)| line.len()).filter(|length| *length <= 44).max().unwrap_or(0);
        for (line, docs) in lines {
            let text = if docs.is_empty() { line } else { format!("{line:column$}  // {docs}") };
            let _ = writeln!(self.text, "{text}");
        }
        Ok(())
    }

    /// The start value in a variable's declaration; `None` if it is the default of the variable's type or cannot be
    /// declared there.
    fn start(&self, ty: &Type, kind: Option<Kind>, bytes: &[u8]) -> Result<Option<String>, String> {
        if bytes.iter().all(|byte| *byte == 0) {
            return Ok(None);
        }
        Ok(match ty {
            Type::Scalar(ty) => {
                let of = declared(*ty, kind);
                Some(literal(Value::read(*ty, bytes), of, true, self.dialect)?)
            }
            Type::Array { of, .. } if matches!(**of, Type::Scalar(_)) => {
                let Type::Scalar(scalar) = **of else { return Ok(None) };
                let of = declared(scalar, kind);
                let values = bytes.chunks(scalar.size());
                let values: Result<Vec<String>, String> =
                    values.map(|value| literal(Value::read(scalar, value), of, true, self.dialect)).collect();
                let values = values?.join(", ");
                Some(if self.dialect == Dialect::Tia { format!("[{values}]") } else { values })
            }
            Type::Text { capacity: _, wide: false } => {
                let length = usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
                let text: String = bytes[2..2 + length].iter().map(|byte| char::from(*byte)).collect();
                Some(format!("'{}'", text.replace('$', "$$").replace('\'', "$'")))
            }
            // A structure has the start values of its type; a data block assigns any that differ.
            _ => None,
        })
    }

    /// Prints a function or function block.
    pub(super) fn function(&mut self, number: usize) -> Result<(), String> {
        let program = self.program;
        let function = &program.functions[number];
        let Body::Code(body) = &function.body else { return Ok(()) };
        let interface = self.interfaces[&number].clone();
        self.scope = Scope { function: Some(function), number, interface, indent: 1, ..Scope::default() };
        self.statements(body).map_err(|error| format!("{}: {error}", function.name))?;
        let of = self.facts.uses[&number];
        let end = match (of, function.instance) {
            (Use::Block, Some(record)) => {
                let _ = writeln!(self.text, "\nFUNCTION_BLOCK \"{}\"", self.records[record]);
                self.attributes();
                self.docs(program.docs.records.get(&record));
                self.docs(program.docs.functions.get(&number));
                self.block_sections(record, function)?;
                "END_FUNCTION_BLOCK"
            }
            _ => {
                let value = self.facts.values.get(&number).map(|local| &function.locals[*local].ty);
                let value = match value {
                    Some(ty) => self.type_name(ty, None)?,
                    None => "VOID".to_string(),
                };
                let _ = writeln!(self.text, "\nFUNCTION \"{}\" : {value}", self.functions[number]);
                self.attributes();
                self.docs(program.docs.functions.get(&number));
                self.function_sections(number, function)?;
                "END_FUNCTION"
            }
        };
        if let Some(labels) = self.label_section() {
            self.text.push_str(&labels);
        }
        self.text.push_str("\nBEGIN\n");
        for line in std::mem::take(&mut self.scope.lines) {
            let _ = writeln!(self.text, "{line}");
        }
        let _ = writeln!(self.text, "{end}");
        Ok(())
    }

    fn section(&mut self, name: &str, lines: &[String]) {
        if lines.is_empty() {
            return;
        }
        let _ = writeln!(self.text, "\n{name}");
        for line in lines {
            let _ = writeln!(self.text, "    {line};");
        }
        self.text.push_str("END_VAR\n");
    }

    fn block_sections(&mut self, record: usize, function: &'a Function) -> Result<(), String> {
        let sections = [
            ("VAR_INPUT", Section::Input),
            ("VAR_OUTPUT", Section::Output),
            ("VAR_IN_OUT", Section::InOut),
            ("VAR", Section::Static),
        ];
        for (name, section) in sections {
            let said = |number: &usize| self.program.docs.declared.get(&(record, *number)).map(|said| said.section);
            let members: Vec<usize> = (0..self.program.records[record].members.len())
                .filter(|number| said(number).unwrap_or(Section::Static) == section)
                .collect();
            if !members.is_empty() {
                let _ = writeln!(self.text, "\n{name}");
                self.members(record, &members, 1)?;
                self.text.push_str("END_VAR\n");
            }
        }
        let references = (0..function.parameters).map(|local| self.local(local)).collect::<Result<Vec<_>, _>>()?;
        self.section("VAR_IN_OUT", &references);
        let temporaries = self.temporaries(function, &[])?;
        self.section("VAR_TEMP", &temporaries);
        Ok(())
    }

    /// The declaration of a local.
    fn local(&self, local: usize) -> Result<String, String> {
        let ty = self.type_name(self.local_type(local), None)?;
        Ok(format!("{} : {ty}", self.scope.interface.locals[local]))
    }

    /// The declarations of the locals in use that are neither parameters nor among `others`, and of the printer's
    /// temporaries.
    fn temporaries(&self, function: &Function, others: &[usize]) -> Result<Vec<String>, String> {
        let own = (function.parameters..function.locals.len())
            .filter(|local| !others.contains(local) && self.scope.used.contains(local));
        let mut all = own.map(|local| self.local(local)).collect::<Result<Vec<_>, _>>()?;
        all.extend(self.scope.temporaries.iter().map(|(name, of)| format!("{name} : {of}")));
        Ok(all)
    }

    fn function_sections(&mut self, number: usize, function: &'a Function) -> Result<(), String> {
        let outs = self.facts.outs.get(&number).cloned().unwrap_or_default();
        let value = self.facts.values.get(&number).copied();
        let (mut inputs, mut in_outs, mut outputs) = (Vec::new(), Vec::new(), Vec::new());
        for (local, variable) in function.locals.iter().enumerate() {
            let is_parameter = local < function.parameters;
            match (is_parameter, variable.by_reference || outs.contains(&local)) {
                (true, true) => in_outs.push(self.local(local)?),
                (true, false) => inputs.push(self.local(local)?),
                (false, true) if Some(local) != value => outputs.push(local),
                _ => {}
            }
        }
        if let Some(record) = function.instance {
            for (path, writes) in self.facts.members.get(&number).cloned().unwrap_or_default() {
                let (ty, kind) = self.part(record, &path);
                let name = &self.scope.interface.members[&path];
                let text = format!("{name} : {}", self.type_name(&ty, kind)?);
                let is_number = matches!(ty, Type::Scalar(_));
                if writes || !is_number { in_outs.push(text) } else { inputs.push(text) }
            }
        }
        self.section("VAR_INPUT", &inputs);
        let lines = outputs.iter().map(|local| self.local(*local)).collect::<Result<Vec<_>, _>>()?;
        self.section("VAR_OUTPUT", &lines);
        self.section("VAR_IN_OUT", &in_outs);
        outputs.extend(value);
        let temporaries = self.temporaries(function, &outputs)?;
        self.section("VAR_TEMP", &temporaries);
        Ok(())
    }

    /// The type of a part of a record, and the type declared for it in the source, if any.
    pub(super) fn part(&self, record: usize, path: &[usize]) -> (Type, Option<Kind>) {
        let mut found = (Type::Record(record), None);
        for number in path {
            let Type::Record(record) = found.0 else { break };
            let declared = self.program.docs.declared.get(&(record, *number));
            let member = &self.program.records[record].members[*number];
            found = (member.ty.clone(), declared.and_then(|declared| declared.of));
        }
        found
    }

    /// The members of memory that the printed functions use.
    fn used_globals(&self) -> Vec<usize> {
        let mut used = Vec::new();
        for number in &self.facts.reached {
            if let Body::Code(body) = &self.program.functions[*number].body {
                super::facts::each_place(body, &mut |place, _| {
                    if let (crate::ir::Base::Memory, Some(crate::ir::Step::Member(member))) =
                        (place.base, place.steps.first())
                    {
                        used.push(*member);
                    }
                });
            }
        }
        used.sort_unstable();
        used.dedup();
        used
    }

    /// Prints the data blocks that functions use and, if the last function is a function block with start values that
    /// cannot be declared, an instance of it.
    pub(super) fn data_blocks(&mut self) -> Result<(), String> {
        let program = self.program;
        let memory = &program.records[program.memory];
        let mut loose = Vec::new();
        for number in self.used_globals() {
            let member = &memory.members[number];
            let Type::Record(_) = member.ty else {
                loose.push(number);
                continue;
            };
            let bytes = &memory.start[member.offset..member.offset + program.size(&member.ty)];
            let name = self.globals[number].clone();
            self.data_block(&name, &member.ty, bytes)?;
        }
        if !loose.is_empty() {
            let _ = writeln!(self.text, "\nDATA_BLOCK \"{}\"", self.loose);
            self.attributes();
            self.text.push_str("    STRUCT\n");
            self.members(program.memory, &loose, 2)?;
            self.text.push_str("    END_STRUCT;\nBEGIN\nEND_DATA_BLOCK\n");
        }
        for (record, function) in self.facts.blocks.clone() {
            let is_root = self.facts.reached.last() == Some(&function);
            let start = &program.records[record].start;
            if is_root && self.differences(&Type::Record(record), start, "")?.is_some() {
                let name = format!("{}_DB", self.records[record]);
                self.data_block(&name, &Type::Record(record), start)?;
            }
        }
        Ok(())
    }

    fn data_block(&mut self, name: &str, ty: &Type, bytes: &[u8]) -> Result<(), String> {
        let _ = writeln!(self.text, "\nDATA_BLOCK \"{name}\"");
        self.attributes();
        let of = self.type_name(ty, None)?;
        let starts = self.differences(ty, bytes, "")?.unwrap_or_default();
        let _ = writeln!(self.text, "{of}\nBEGIN\n{starts}END_DATA_BLOCK");
        Ok(())
    }

    /// The start values that the declarations of a type can express, as bytes.
    fn declared_start(&self, ty: &Type) -> Vec<u8> {
        let program = self.program;
        match ty {
            Type::Record(record) => {
                let mut bytes = program.records[*record].start.clone();
                for member in &program.records[*record].members {
                    if !matches!(member.ty, Type::Scalar(_) | Type::Text { .. }) && !is_list(&member.ty) {
                        let inner = self.declared_start(&member.ty);
                        bytes[member.offset..member.offset + inner.len()].copy_from_slice(&inner);
                    }
                }
                bytes
            }
            Type::Array { of, .. } => {
                let one = self.declared_start(of);
                one.repeat(program.size(ty) / one.len().max(1))
            }
            _ => vec![0; program.size(ty)],
        }
    }

    /// Assignments for the start values that differ from the declared ones; `None` if there are none.
    fn differences(&self, ty: &Type, bytes: &[u8], path: &str) -> Result<Option<String>, String> {
        let program = self.program;
        if self.declared_start(ty) == bytes {
            return Ok(None);
        }
        let Type::Record(record) = ty else {
            return Err(format!("the start values of {path} cannot be written in SCL"));
        };
        let declared_start = self.declared_start(ty);
        let mut text = String::new();
        for (number, member) in program.records[*record].members.iter().enumerate() {
            let range = member.offset..member.offset + program.size(&member.ty);
            let name = format!("{path}{}", self.member(&member.name)?);
            match &member.ty {
                Type::Scalar(ty) if bytes[range.clone()] != declared_start[range.clone()] => {
                    let kind = program.docs.declared.get(&(*record, number)).and_then(|said| said.of);
                    let of = declared(*ty, kind);
                    let value = literal(Value::read(*ty, &bytes[range]), of, true, self.dialect)?;
                    let _ = writeln!(text, "    {name} := {value};");
                }
                Type::Scalar(_) => {}
                inner if is_list(inner) && bytes[range.clone()] == declared_start[range.clone()] => {}
                inner => {
                    let more = self.differences(inner, &bytes[range], &format!("{name}."))?;
                    text += &more.unwrap_or_default();
                }
            }
        }
        Ok(Some(text).filter(|text| !text.is_empty()))
    }
}

/// Whether the start values of a variable can be declared as a list.
fn is_list(ty: &Type) -> bool {
    matches!(ty, Type::Array { of, .. } if matches!(**of, Type::Scalar(_)))
}
