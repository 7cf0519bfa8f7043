//! Declares blocks, types and data blocks.

use crate::check::compiler::{
    BlockId, Compiler, Global, Interface, Operand, Parameter, Slot, State, Symbol, View, nothing,
};
use crate::check::types::{Array, Elementary, Field, Structure, Type};
use crate::check::undeclared::What;
use crate::front::lexer::Span;
use crate::front::syntax::{
    BlockKind, Member, Name, Section, SectionKind, SourceBlock, Start, Statement, StatementKind, Type as Written,
    TypeKind, attribute, key,
};
use crate::ir::{self, Body, Function, Local};
use crate::lower::Lowerer;
use manifest::Cpu;
use parameters::problem::nearest;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// The maximum size of a program's memory, in bytes.
const MOST_MEMORY: usize = 64 << 20;

fn too_large(what: &str) -> String {
    format!("{what} more than {} MiB, more than any CPU has", MOST_MEMORY >> 20)
}

impl Compiler<'_> {
    /// Lowers a type to its representation in the program.
    pub fn lowered(&self, of: &Type) -> ir::Type {
        of.lowered(&|block| self.blocks[block].record)
    }

    /// Resolves a type as written in the source.
    pub fn type_of(&mut self, written: &Written, file: usize, symbols: &Rc<HashMap<String, Symbol>>) -> Type {
        match &written.kind {
            TypeKind::Name { name, is_quoted } => self.type_named(name, *is_quoted, written.span, file),
            TypeKind::Text { is_wide, length } => {
                let capacity = match length {
                    Some(length) => self.constant_whole(*length, file, symbols).unwrap_or(254),
                    None => 254,
                };
                let most = if *is_wide { 16382 } else { 254 };
                if !(1..=most).contains(&capacity) {
                    let message = format!("{capacity} is not a valid string length: it must be 1 to {most}");
                    self.error(written.span, message, None);
                    return Type::Wrong;
                }
                Type::Text { capacity: capacity as u16, wide: *is_wide }
            }
            TypeKind::Array(bounds, of) => {
                let of = self.type_of(of, file, symbols);
                if of == Type::Wrong {
                    return Type::Wrong;
                }
                let open = bounds.iter().filter(|bounds| bounds.is_none()).count();
                if open == bounds.len() {
                    return Type::Open(Rc::new(of), open);
                }
                let mut known = Vec::new();
                for bounds in bounds {
                    let Some([low, high]) = bounds else { return Type::Wrong };
                    let low = self.constant_whole(*low, file, symbols);
                    let high = self.constant_whole(*high, file, symbols);
                    let (Some(low), Some(high)) = (low, high) else { return Type::Wrong };
                    let is_range = low <= high && i32::try_from(low).is_ok() && i32::try_from(high).is_ok();
                    if !is_range {
                        let help = (low > high).then_some("write the lower bound first");
                        self.error(written.span, format!("{low}..{high} is not a range of DINT values"), help);
                        return Type::Wrong;
                    }
                    known.push((low as i32, high as i32));
                }
                if matches!(of, Type::Array(_) | Type::Open(..)) {
                    let message = "an array of arrays is not supported";
                    self.error(written.span, message, Some("use multiple dimensions: ARRAY[0..1, 0..2]"));
                    return Type::Wrong;
                }
                let array = Type::Array(Rc::new(Array { bounds: known, of }));
                if self.program.size(&self.lowered(&array)) > MOST_MEMORY {
                    self.error(written.span, too_large("this array needs"), None);
                    return Type::Wrong;
                }
                array
            }
            TypeKind::Struct(members) => Type::Structure(Rc::new(self.structure_of("", members, file, symbols))),
            TypeKind::Reference => self.refused_type(written.span, "REF_TO"),
            TypeKind::Wrong => Type::Wrong,
        }
    }

    fn refused_type(&mut self, span: Span, name: &str) -> Type {
        let help = match name {
            "S5TIME" | "TIMER" | "COUNTER" => "use IEC timers and counters: TON, TOF, TP, CTU, CTD, CTUD",
            "POINTER" | "ANY" | "VARIANT" | "REF_TO" | "DB_ANY" => {
                "pass the variable itself; for an array of any length, declare ARRAY[*]"
            }
            "ERRORSTRUCT" => "remove it: an error stops the FMU and reports file and line",
            _ => "it depends on hardware: supply its values through inputs",
        };
        self.error(span, format!("{name} is not supported"), Some(help));
        Type::Wrong
    }

    fn type_named(&mut self, name: &str, is_quoted: bool, span: Span, file: usize) -> Type {
        let capitals = key(name);
        if !is_quoted {
            if let Some(elementary) = Elementary::named(&capitals) {
                if self.cpu != Cpu::S71500
                    && matches!(
                        elementary,
                        Elementary::LWord | Elementary::LInt | Elementary::ULInt | Elementary::LTime
                    )
                    && file != self.library_file()
                {
                    self.warn(span, format!("{} exists only on S7-1500", elementary.name()), None);
                }
                return Type::Elementary(elementary);
            }
            if capitals == "VOID" {
                return Type::Void;
            }
        }
        if let Some(id) = self.names.get(&capitals).copied() {
            return match self.block(id).kind {
                BlockKind::Type => self.structure(id),
                BlockKind::FunctionBlock => self.interface(id, span).map_or(Type::Wrong, Type::Instance),
                _ => {
                    let help = "the type of a variable can be a TYPE or a FUNCTION_BLOCK";
                    self.error(span, format!("{name} is not a type"), Some(help));
                    Type::Wrong
                }
            };
        }
        if let Some(of) = self.system_block(&capitals) {
            return Type::Instance(of);
        }
        if capitals == "DTL" {
            return self.dtl();
        }
        if let Some(id) = self.library.get(&capitals).copied().filter(|id| self.block(*id).kind == BlockKind::Type) {
            return self.structure(id);
        }
        if let Some(number) = number_of_hardware(&capitals).filter(|_| !is_quoted) {
            return Type::Elementary(number);
        }
        let is_hardware = ["TO_", "TCON_", "TADDR_"];
        let is_refused = matches!(
            capitals.as_str(),
            "S5TIME"
                | "TIMER"
                | "COUNTER"
                | "POINTER"
                | "ANY"
                | "VARIANT"
                | "DB_ANY"
                | "REMOTE"
                | "BLOCK_DB"
                | "BLOCK_FB"
                | "BLOCK_FC"
                | "ERRORSTRUCT"
                | "NREF"
                | "CREF"
        );
        let is_hardware = !is_quoted && is_hardware.iter().any(|prefix| capitals.starts_with(prefix));
        if is_refused || is_hardware && !self.assumes {
            return self.refused_type(span, &capitals);
        }
        if let Some(message) = crate::lower::refused(&capitals).filter(|_| !is_quoted && !self.assumes) {
            self.error(span, message.0, Some(&message.1));
            return Type::Wrong;
        }
        let types = self
            .names
            .values()
            .map(|id| self.block(*id))
            .filter(|block| matches!(block.kind, BlockKind::Type | BlockKind::FunctionBlock));
        let like = nearest(name, types.map(|block| block.name.text.as_str())).map(str::to_string);
        match like.filter(|_| !self.assumes) {
            Some(like) => {
                let help = format!("did you mean \"{like}\"?");
                self.error(span, format!("no source declares the type \"{name}\""), Some(&help));
            }
            None => {
                self.miss(name, span, What::Type);
                return Type::Missing(key(name).into());
            }
        }
        Type::Wrong
    }

    /// The type DTL, a date with time of day; declared on its first use.
    pub fn dtl(&mut self) -> Type {
        if let Some(of) = &self.dtl {
            return of.clone();
        }
        let fields = [
            ("YEAR", Elementary::UInt),
            ("MONTH", Elementary::USInt),
            ("DAY", Elementary::USInt),
            ("WEEKDAY", Elementary::USInt),
            ("HOUR", Elementary::USInt),
            ("MINUTE", Elementary::USInt),
            ("SECOND", Elementary::USInt),
            ("NANOSECOND", Elementary::UDInt),
        ];
        let members = fields.map(|(name, of)| (name.to_string(), ir::Type::Scalar(of.scalar())));
        let record = self.program.add_record("DTL", members);
        let fields = fields.map(|(name, of)| Field {
            name: name.to_string(),
            key: name.to_string(),
            of: Type::Elementary(of),
            comment: String::new(),
            is_setting: false,
            is_hidden: false,
            is_retained: false,
        });
        // The default date: 1970-01-01, a Thursday.
        let start = &mut self.program.records[record].start;
        start[..2].copy_from_slice(&1970u16.to_le_bytes());
        start[2..5].copy_from_slice(&[1, 1, 5]);
        let of = Type::Structure(Rc::new(Structure::new("DTL", fields.into(), record)));
        self.dtl = Some(of.clone());
        of
    }

    /// The type declared by a TYPE block.
    pub fn structure(&mut self, id: BlockId) -> Type {
        match self.types.get(&id) {
            Some(State::Known(of)) => return of.clone(),
            Some(State::Open) => {
                let name = &self.block(id).name;
                self.error(name.span, format!("{} contains itself", name.text), None);
                return Type::Wrong;
            }
            None => {}
        }
        self.types.insert(id, State::Open);
        let block = self.block(id);
        let symbols = nothing();
        let of = match (&block.of, block.sections.first()) {
            (_, Some(section)) => {
                Type::Structure(Rc::new(self.structure_of(&block.name.text, &section.members, id.0, &symbols)))
            }
            (Some(of), None) => self.type_of(of, id.0, &symbols),
            (None, None) => {
                self.error(block.name.span, format!("{} has no members", block.name.text), None);
                Type::Wrong
            }
        };
        self.types.insert(id, State::Known(of.clone()));
        of
    }

    fn structure_of(
        &mut self,
        name: &str,
        members: &[Member],
        file: usize,
        symbols: &Rc<HashMap<String, Symbol>>,
    ) -> Structure {
        let mut fields: Vec<Field> = Vec::new();
        let mut taken = HashSet::new();
        let mut starts = Vec::new();
        for member in members {
            let of = self.member_type(member, file, symbols);
            for name in &member.names {
                if !taken.insert(name.key()) {
                    self.error(
                        name.span,
                        format!("{} is declared twice", name.text),
                        Some("rename or delete one of them"),
                    );
                    continue;
                }
                starts.push(member.start.as_ref());
                fields.push(Field {
                    name: name.text.clone(),
                    key: name.key(),
                    of: of.clone(),
                    comment: member.comment.clone(),
                    is_setting: is_setting(member),
                    is_hidden: is_hidden(member),
                    is_retained: false,
                });
            }
        }
        let lowered: Vec<_> = fields.iter().map(|field| (field.name.clone(), self.lowered(&field.of))).collect();
        let record =
            self.add_record(name, lowered, members.first().map_or(Span::default(), |member| member.names[0].span));
        for (number, field) in fields.iter().enumerate() {
            self.declare_member(record, number, ir::Section::Static, &field.of);
        }
        for (number, start) in starts.into_iter().enumerate() {
            if let Some(start) = start {
                self.start_member(record, number, &fields[number].of.clone(), start, file, symbols);
            }
        }
        Structure::new(name, fields, record)
    }

    fn member_type(&mut self, member: &Member, file: usize, symbols: &Rc<HashMap<String, Symbol>>) -> Type {
        if let Some(at) = &member.at {
            self.error(at.span, "AT is only allowed for variables of a block", Some("use slices such as .%X0"));
            return Type::Wrong;
        }
        let Some(written) = &member.of else { return Type::Wrong };
        // The attribute in `{InstructionName := 'TON_TIME'}` only repeats the type, so it is ignored.
        self.type_of(written, file, symbols)
    }

    /// Records a member's section and elementary type; for an array, the elementary type of its elements.
    pub fn declare_member(&mut self, record: usize, number: usize, section: ir::Section, of: &Type) {
        let of = match of {
            Type::Array(array) => array.of.elementary(),
            of => of.elementary(),
        };
        let of = of.and_then(|of| blocks::Kind::named(of.name()));
        self.program.docs.declared.insert((record, number), ir::Declared { section, of });
    }

    /// Adds a record. If memory would become too large, reports an error and adds an empty record instead.
    fn add_record(&mut self, name: &str, members: Vec<(String, ir::Type)>, span: Span) -> usize {
        let size = members.iter().fold(0usize, |size, (_, of)| size.saturating_add(self.program.size(of)));
        if self.bytes.saturating_add(size) > MOST_MEMORY {
            self.error(span, too_large("the variables need"), None);
            return self.program.add_record(name, []);
        }
        self.bytes += size;
        self.program.add_record(name, members)
    }

    /// The index of a block's interface, which is declared on first use. A block that contains itself is reported at
    /// `named`, where the source names it.
    pub fn interface(&mut self, id: BlockId, named: Span) -> Option<usize> {
        match self.block_of.get(&id) {
            Some(State::Known(block)) => return Some(*block),
            Some(State::Open) => {
                self.error(named, format!("{} contains an instance of itself", self.block(id).name.text), None);
                return None;
            }
            None => {}
        }
        self.block_of.insert(id, State::Open);
        let block = self.block(id);
        let mut symbols = self.constants(block, id.0);
        let mut names: HashSet<String> = symbols.keys().cloned().collect();
        let mut declared: Vec<Declared> = Vec::new();
        let mut statics: Vec<(String, ir::Type)> = Vec::new();
        let mut starts = Vec::new();
        let mut views: Vec<(SectionKind, View)> = Vec::new();
        let (mut parameters, mut temporaries) = (Vec::new(), Vec::new());
        let known = Rc::new(symbols.clone());
        let result = match &block.of {
            Some(of) if block.kind == BlockKind::Function => self.type_of(of, id.0, &known),
            _ => Type::Void,
        };
        for section in block.sections.iter().filter(|section| section.kind != SectionKind::Constant) {
            let kind = match section.kind {
                SectionKind::Static if block.kind != BlockKind::FunctionBlock => SectionKind::Temp,
                kind => kind,
            };
            for member in &section.members {
                if member.at.is_some() {
                    for (local, view) in self.views_of(member, id.0, &known) {
                        names.insert(key(&view.name));
                        views.push((kind, View { local: temporaries.len(), ..view }));
                        temporaries.push(local);
                    }
                    continue;
                }
                let of = self.member_type(member, id.0, &known);
                for name in &member.names {
                    if !names.insert(name.key()) {
                        self.error(
                            name.span,
                            format!("{} is declared twice", name.text),
                            Some("rename or delete one of them"),
                        );
                        continue;
                    }
                    let in_instance = block.kind == BlockKind::FunctionBlock
                        && kind != SectionKind::Temp
                        && (kind != SectionKind::InOut || of.is_elementary());
                    let is_parameter = matches!(kind, SectionKind::Input | SectionKind::InOut)
                        || kind == SectionKind::Output && !is_copied(&of);
                    let storage = if in_instance {
                        statics.push((name.text.clone(), self.lowered(&of)));
                        starts.push(member.start.as_ref().map(|start| (of.clone(), start)));
                        Storage::Instance(statics.len() - 1)
                    } else {
                        let list = if is_parameter { &mut parameters } else { &mut temporaries };
                        let by_reference = is_parameter && !is_copied(&of);
                        list.push(Local {
                            name: name.text.clone(),
                            ty: of.lowered(&|block| self.blocks[block].record),
                            by_reference,
                        });
                        let number = list.len() - 1;
                        if is_parameter { Storage::Parameter(number) } else { Storage::Temporary(number) }
                    };
                    declared.push(Declared {
                        name,
                        member,
                        section: kind,
                        is_retained: section.is_retained,
                        of: of.clone(),
                        storage,
                    });
                }
            }
        }
        // Parameters come first among the locals.
        let count = parameters.len();
        let members: Vec<Parameter> = declared.into_iter().map(|of| of.parameter(count)).collect();
        for member in &members {
            symbols.insert(member.key.clone(), Symbol::Variable(member.section, member.of.clone(), member.slot));
        }
        for (section, view) in &mut views {
            view.local += count;
            symbols.insert(key(&view.name), Symbol::Variable(*section, view.of.clone(), Slot::Local(view.local)));
        }
        if result != Type::Void {
            temporaries.push(Local { name: block.name.text.clone(), ty: self.lowered(&result), by_reference: false });
            let slot = Slot::Local(count + temporaries.len() - 1);
            let value = Symbol::Variable(SectionKind::Output, result.clone(), slot);
            symbols.entry("RET_VAL".to_string()).or_insert(value.clone());
            symbols.insert(block.name.key(), value);
        }
        let may_set_eno = !symbols.contains_key("ENO") && self.trees[id.0].may_set_eno;
        if may_set_eno {
            let ty = ir::Type::Scalar(ir::Scalar::Bool);
            temporaries.push(Local { name: "ENO".to_string(), ty, by_reference: false });
        }
        parameters.extend(temporaries);
        let eno = may_set_eno.then(|| parameters.len() - 1);
        let is_block = block.kind == BlockKind::FunctionBlock;
        let record = match self.shared_record(id) {
            Some(record) => record,
            None if is_block => self.add_record(&block.name.text, statics, block.name.span),
            None => 0,
        };
        for (number, start) in starts.into_iter().enumerate() {
            if let Some((of, start)) = start {
                self.start_member(record, number, &of, start, id.0, &known);
            }
        }
        if is_block {
            for member in &members {
                if let Slot::Member(number) = member.slot {
                    self.declare_member(record, number, member.section.into(), &member.of);
                }
            }
        }
        self.program.functions.push(Function {
            name: block.name.text.clone(),
            instance: is_block.then_some(record),
            locals: parameters,
            parameters: count,
            body: Body::Code(Vec::new()),
        });
        self.blocks.push(Interface {
            name: block.name.text.clone(),
            kind: block.kind,
            source: Some(id),
            members,
            symbols: Rc::new(symbols),
            result,
            record,
            function: self.program.functions.len() - 1,
            eno,
            views: views.into_iter().map(|(_, view)| view).collect(),
            is_stub: self.is_stub(block),
        });
        self.block_of.insert(id, State::Known(self.blocks.len() - 1));
        Some(self.blocks.len() - 1)
    }

    /// The views declared with AT, each with its local.
    fn views_of(&mut self, member: &Member, file: usize, known: &Rc<HashMap<String, Symbol>>) -> Vec<(Local, View)> {
        let (Some(behind), Some(of)) = (&member.at, &member.of) else { return Vec::new() };
        let of = self.type_of(of, file, known);
        let ty = self.lowered(&of);
        let view = |name: &Name| {
            let local = Local { name: name.text.clone(), ty: ty.clone(), by_reference: false };
            let name = name.text.clone();
            (local, View { name, local: 0, behind: behind.key(), of: of.clone(), span: behind.span })
        };
        member.names.iter().map(view).collect()
    }

    /// The constants of a block; each may use those declared before it.
    fn constants(&mut self, block: &SourceBlock, file: usize) -> HashMap<String, Symbol> {
        let mut symbols = HashMap::new();
        if file == self.library_file() {
            crate::library::constants(self.cpu, &block.name.text, &mut symbols);
        }
        for section in block.sections.iter().filter(|section| section.kind == SectionKind::Constant) {
            for member in &section.members {
                let known = Rc::new(symbols.clone());
                let of = member.of.as_ref().map(|of| self.type_of(of, file, &known));
                let value = match &member.start {
                    _ if of
                        .as_ref()
                        .is_some_and(|of| matches!(of, Type::Array(_) | Type::Open(..) | Type::Instance(_))) =>
                    {
                        let name = &member.names[0];
                        let of = of.unwrap_or(Type::Wrong);
                        let help = "only elementary values and strings can be constants: declare it in VAR";
                        self.error(name.span, format!("the constant {} is declared as {of}", name.text), Some(help));
                        Operand::Wrong(None)
                    }
                    None if of.as_ref().is_some_and(Type::is_elementary) => {
                        let of = of.and_then(|of| of.elementary()).unwrap_or(Elementary::Bool);
                        Operand::Value(of, crate::lower::zero(of))
                    }
                    None if matches!(of, Some(Type::Text { .. })) => {
                        let is_wide = matches!(of, Some(Type::Text { wide: true, .. }));
                        Operand::Text(Vec::new(), Some(is_wide))
                    }
                    Some(crate::front::syntax::Start::Value(value)) => {
                        let mut lowerer = Lowerer::of_constants(self, file, known);
                        lowerer.constant(*value, of.as_ref())
                    }
                    _ => {
                        let name = &member.names[0];
                        let help = "give it one, such as LIMIT : INT := 10;";
                        self.error(name.span, format!("the constant {} has no value", name.text), Some(help));
                        Operand::Wrong(None)
                    }
                };
                for name in &member.names {
                    symbols.insert(name.key(), Symbol::Constant(value.clone()));
                }
            }
        }
        symbols
    }

    /// A data block or another global variable, by its upper-case name; declared on first use.
    pub fn global(&mut self, name: &str) -> Option<Global> {
        match self.globals.get(name) {
            Some(State::Known(global)) => return Some(global.clone()),
            Some(State::Open) => return None,
            None => {}
        }
        let Some(id) = self.names.get(name).copied() else { return self.declared(name) };
        let block = self.block(id);
        if block.kind != BlockKind::DataBlock {
            return None;
        }
        self.globals.insert(name.to_string(), State::Open);
        let symbols = nothing();
        let of = match (&block.of, block.sections.as_slice()) {
            // A data block may have both `VAR` and `VAR RETAIN`.
            (_, [_, ..]) => Type::Structure(Rc::new(self.joined(block, id.0, &symbols))),
            (Some(of), []) => self.type_of(of, id.0, &symbols),
            (None, []) => Type::Structure(Rc::new(self.structure_of(&block.name.text, &[], id.0, &symbols))),
        };
        let global = self.add_global(&block.name.text, of);
        self.start_values(block, id.0, &global);
        Some(global)
    }

    /// The members of all sections of a data block as one structure.
    fn joined(&mut self, block: &SourceBlock, file: usize, symbols: &Rc<HashMap<String, Symbol>>) -> Structure {
        let part = |section: &Section| {
            let mut part = self.structure_of("", &section.members, file, symbols);
            part.fields.iter_mut().for_each(|field| field.is_retained = section.is_retained);
            part
        };
        let parts: Vec<Structure> = block.sections.iter().map(part).collect();
        let mut members = Vec::new();
        let mut bytes = Vec::new();
        for part in &parts {
            let record = &self.program.records[part.record];
            for member in &record.members {
                let end = member.offset + self.program.size(&member.ty);
                bytes.push(record.start[member.offset..end].to_vec());
                members.push((member.name.clone(), member.ty.clone()));
            }
        }
        let record = self.add_record(&block.name.text, members, block.name.span);
        let record_of = &mut self.program.records[record];
        for (member, bytes) in record_of.members.iter().zip(bytes) {
            record_of.start[member.offset..member.offset + bytes.len()].copy_from_slice(&bytes);
        }
        let fields = parts.into_iter().flat_map(|part| part.fields).collect();
        Structure::new(&block.name.text, fields, record)
    }

    /// Adds a global variable.
    pub fn add_global(&mut self, name: &str, of: Type) -> Global {
        let lowered = self.lowered(&of);
        let member = self.program.extend_record(self.program.memory, name, lowered);
        let global = Global { member, of, parameter: None };
        self.globals.insert(key(name), State::Known(global.clone()));
        global
    }

    /// Whether to compile the block as a stub.
    fn is_stub(&self, block: &SourceBlock) -> bool {
        block.kind == BlockKind::FunctionBlock && (self.stubs.contains(&block.name.key()) || block.is_stub())
    }

    /// A global declared outside blocks, in a source or in the options.
    fn declared(&mut self, name: &str) -> Option<Global> {
        if let Some((file, section, member)) = self.global_members.get(name).copied() {
            return self.global_member(name, file, section, member);
        }
        let tag = self.declared.get(name).copied()?;
        let of = self.type_named(tag.of.trim_matches('"'), false, Span::default(), 0);
        Some(self.add_global(&tag.name, of))
    }

    fn global_member(&mut self, name: &str, file: usize, section: &Section, member: &Member) -> Option<Global> {
        let (SectionKind::Static, Some(written)) = (section.kind, &member.of) else { return None };
        let symbols = nothing();
        self.globals.insert(name.to_string(), State::Open);
        let of = self.type_of(written, file, &symbols);
        let spelled = member.names.iter().find(|of| of.key() == name)?.text.clone();
        let global = self.add_global(&spelled, of);
        if let Some(start) = &member.start {
            let memory = self.program.memory;
            self.start_member(memory, global.member, &global.of.clone(), start, file, &symbols);
        }
        Some(global)
    }

    /// The value of a constant declared outside blocks.
    pub fn global_constant(&mut self, name: &str) -> Option<Operand> {
        let (file, section, member) = self.global_members.get(name).copied()?;
        let (SectionKind::Constant, Some(Start::Value(value))) = (section.kind, &member.start) else { return None };
        let of = member.of.as_ref().map(|of| self.type_of(of, file, &nothing()));
        Some(Lowerer::of_constants(self, file, nothing()).constant(*value, of.as_ref()))
    }

    /// Applies the start values in the body of a data block: `BEGIN a.b := 1;`.
    fn start_values(&mut self, block: &SourceBlock, file: usize, global: &Global) {
        for statement in &block.body {
            self.start_value_of(statement, file, global);
        }
    }

    fn start_value_of(&mut self, statement: &Statement, file: usize, global: &Global) {
        let StatementKind::Assign(targets, value) = &statement.kind else {
            self.error(statement.span, "a data block can contain only start values, such as a := 1;", None);
            return;
        };
        for (target, _) in targets {
            let mut lowerer = Lowerer::of_constants(self, file, nothing());
            let Some((place, of)) = lowerer.member_of(global, *target) else {
                // The data block may set members that the stub of its block lacks.
                if matches!(global.of, Type::Instance(block) if self.blocks[block].is_stub) {
                    self.report.forget(statement.span);
                }
                continue;
            };
            let Some(offset) = self.offset(&place) else { continue };
            let memory = self.program.memory;
            let start = crate::front::syntax::Start::Value(*value);
            self.start_at(memory, offset, &of, &start, file, &nothing());
        }
    }
}

/// The elementary type of which a system data type such as HW_IO or OB_CYCLIC is an alias; `None` for any other type.
fn number_of_hardware(name: &str) -> Option<Elementary> {
    match name {
        "PORT" | "RTM" | "PIP" => Some(Elementary::UInt),
        "AOM_IDENT" | "CONN_R_ID" => Some(Elementary::DWord),
        _ if name.starts_with("HW_") => Some(Elementary::UInt),
        _ if name.starts_with("CONN_") => Some(Elementary::Word),
        _ if name.starts_with("OB_") => Some(Elementary::Int),
        _ if name.starts_with("EVENT_") => Some(Elementary::DWord),
        _ => None,
    }
}

/// Whether an argument of this type is passed by value.
pub(crate) fn is_copied(of: &Type) -> bool {
    matches!(of, Type::Elementary(_) | Type::Text { .. } | Type::Missing(_) | Type::Wrong)
}

/// A declared variable of a block.
struct Declared<'a> {
    name: &'a Name,
    member: &'a Member,
    section: SectionKind,
    is_retained: bool,
    of: Type,
    storage: Storage,
}

/// Where a variable of a block is stored, and its index there.
enum Storage {
    Instance(usize),
    Parameter(usize),
    Temporary(usize),
}

impl Declared<'_> {
    /// Converts it to a parameter of an interface whose function has `parameters` parameters.
    fn parameter(self, parameters: usize) -> Parameter {
        let Declared { name, member, section, is_retained, of, storage } = self;
        Parameter {
            name: name.text.clone(),
            key: name.key(),
            section,
            of,
            slot: match storage {
                Storage::Instance(number) => Slot::Member(number),
                Storage::Parameter(number) => Slot::Local(number),
                Storage::Temporary(number) => Slot::Local(parameters + number),
            },
            comment: member.comment.clone(),
            is_setting: is_setting(member),
            is_hidden: is_hidden(member),
            is_retained,
        }
    }
}

fn is_setting(member: &Member) -> bool {
    attribute(&member.attributes, "S7_SETPOINT").is_some_and(|value| value.eq_ignore_ascii_case("true"))
}

fn is_hidden(member: &Member) -> bool {
    ["EXTERNALVISIBLE", "EXTERNALACCESSIBLE"]
        .iter()
        .any(|name| attribute(&member.attributes, name).is_some_and(|value| value.eq_ignore_ascii_case("false")))
}
