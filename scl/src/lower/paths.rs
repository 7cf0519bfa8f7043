//! Names, members, indices and slices.

use super::Lowerer;
use super::convert::{convert, zero};
use crate::check::compiler::{Global, Operand, Slot, Symbol};
use crate::check::types::{Elementary, Type};
use crate::check::undeclared::{Missing, UndeclaredStep, What as Kind};
use crate::front::lexer::Span;
use crate::front::syntax::{BlockKind, ExpressionId, ExpressionKind, Name, Scope, SectionKind, key};
use crate::ir::{Base, Binary, Call, Convert, Expr, Place, Scalar, Step, Value, What};
use manifest::Cpu;
use parameters::problem::{nearest, with_article};
use parameters::tags;

/// The error message for an absolute address, including advice.
pub(super) const ABSOLUTE: &str = "an absolute address has no value in an FMU; make it an input of the block";

/// A variable or a part of one.
#[derive(Clone, Debug)]
pub(crate) struct Variable {
    pub of: Type,
    pub place: Place,
    /// The bits selected from it, if it is sliced.
    pub slice: Option<Slice>,
    /// The section that declares it, if it belongs to the block itself.
    pub section: Option<SectionKind>,
    /// The timer to update before the variable is read, if any: its block and its place.
    pub timer: Option<(usize, Place)>,
}

/// A selection of bits of a variable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slice {
    /// The bit string type of the selection.
    pub of: Elementary,
    /// The number of its lowest bit within the variable.
    pub shift: u32,
}

/// The result of resolving a path.
pub(crate) enum Path {
    Variable(Variable),
    Constant(Operand),
    /// An undeclared name.
    Missing(Missing),
    /// An error already reported.
    Wrong,
}

impl Lowerer<'_, '_> {
    /// The value at a path if it is elementary, else the variable itself.
    pub(crate) fn load(&mut self, id: ExpressionId) -> Operand {
        match self.path(id) {
            Path::Variable(variable) => self.value_of(&variable, self.span(id)),
            Path::Constant(operand) => operand,
            Path::Missing(missing) => {
                self.compiler.use_missing(&missing);
                Operand::Wrong(Some(missing))
            }
            Path::Wrong => Operand::Wrong(None),
        }
    }

    /// The value of a variable or slice if it is elementary, else the variable itself.
    pub(crate) fn value_of(&mut self, variable: &Variable, span: Span) -> Operand {
        let Type::Elementary(of) = variable.of else {
            return match &variable.of {
                Type::Wrong | Type::Missing(_) => Operand::Wrong(None),
                of => Operand::Variable(of.clone(), variable.place.clone()),
            };
        };
        let at = self.at(span);
        let mut value = Expr::Load(of.scalar(), variable.place.clone());
        if let Some((block, place)) = &variable.timer {
            let function = self.compiler.blocks[*block].function;
            let call = Call { function, instance: Some(place.clone()), arguments: Vec::new(), outputs: Vec::new() };
            let (update, ()) = self.aside(|lowerer| lowerer.push(span, What::Call(call)));
            value = Expr::After(update, Box::new(value));
        }
        let Some(slice) = variable.slice else { return Operand::Value(of, value) };
        let shift = Expr::Const(Value::from(slice.shift));
        let shifted = super::convert::binary(Binary::Shr, of.scalar(), value, shift, at);
        Operand::Value(slice.of, convert(shifted, of.scalar(), slice.of.scalar(), Convert::Value, at))
    }

    /// The writable variable at a path. `None` for anything else: an undeclared name is recorded as written, all else
    /// is reported as an error.
    pub(crate) fn target(&mut self, id: ExpressionId) -> Option<Variable> {
        let span = self.span(id);
        if matches!(self.expressions()[id].kind, ExpressionKind::Call(..) | ExpressionKind::Literal(_)) {
            self.error(span, "this cannot be assigned to", Some("assign to a variable"));
            return None;
        }
        match self.path(id) {
            Path::Variable(variable) => {
                self.use_view(&variable, true);
                Some(variable)
            }
            Path::Constant(_) => {
                self.error(span, "a constant cannot be written", None);
                None
            }
            Path::Missing(missing) => {
                self.compiler.write_missing(&missing);
                None
            }
            Path::Wrong => None,
        }
    }

    /// The undeclared name at a path, if there is one.
    pub(crate) fn missing(&mut self, id: ExpressionId) -> Option<Missing> {
        match self.path(id) {
            Path::Missing(missing) => Some(missing),
            _ => None,
        }
    }

    pub(crate) fn path(&mut self, id: ExpressionId) -> Path {
        let span = self.span(id);
        let expressions = self.expressions();
        match &expressions[id].kind {
            ExpressionKind::Name(scope, name) => self.name(*scope, name),
            ExpressionKind::Member(base, name) => match self.path(*base) {
                Path::Variable(variable) => self.member(variable, name),
                Path::Missing(missing) => self.missing_member(missing, &name.text, span),
                Path::Constant(_) => {
                    self.error(span, format!("a constant has no member {}", name.text), None);
                    Path::Wrong
                }
                Path::Wrong => Path::Wrong,
            },
            ExpressionKind::Index(base, indices) => match self.path(*base) {
                Path::Variable(variable) => self.indexed(variable, indices, span),
                Path::Missing(missing) => {
                    let indices: Vec<Option<i32>> = indices.iter().map(|index| self.constant_index(*index)).collect();
                    self.compiler.index_missing(&missing, &indices);
                    Path::Missing(missing.part(UndeclaredStep::Element(indices.len())))
                }
                _ => Path::Wrong,
            },
            ExpressionKind::Address(address) => self.addressed(address, span),
            ExpressionKind::Pointer(_) => {
                let help = "pass the variable itself, or ARRAY[*]";
                self.error(span, "references (^) are not supported", Some(help));
                Path::Wrong
            }
            ExpressionKind::Wrong => Path::Wrong,
            // STEP 7: `WORD_TO_BLOCK_DB(number).DW[4]`.
            ExpressionKind::Call(callee, _) if self.is_named(*callee, "WORD_TO_BLOCK_DB") => {
                self.error(span, ABSOLUTE, None);
                Path::Wrong
            }
            _ => {
                self.error(span, "expected a variable", None);
                Path::Wrong
            }
        }
    }

    /// Resolves an absolute address to the tag declared there.
    fn addressed(&mut self, written: &str, span: Span) -> Path {
        if let Some(name) = self.compiler.tag_at(written).map(str::to_string) {
            return self.name(Scope::Global, &Name { text: name, span });
        }
        let Some(address) = tags::address(written).filter(|address| tags::bits(address).is_some()) else {
            self.error(span, ABSOLUTE, None);
            return Path::Wrong;
        };
        if self.compiler.assumes {
            return Path::Missing(self.compiler.miss(&address, span, Kind::Variable));
        }
        let (name, of) = placed(&address);
        let message = format!("{ABSOLUTE}, or declare a tag there: \"{name}\" AT {address} : {}", of.name());
        self.error(span, message, None);
        Path::Wrong
    }

    fn is_named(&self, id: ExpressionId, wanted: &str) -> bool {
        matches!(&self.expressions()[id].kind, ExpressionKind::Name(_, name) if name.key() == wanted)
    }

    fn missing_member(&mut self, missing: Missing, name: &str, span: Span) -> Path {
        if is_data_address(name) || is_numbered_block(&missing.name) && is_classic_address(name) {
            self.compiler.undeclared.remove(&missing.name);
            self.error(span, ABSOLUTE, None);
            return Path::Wrong;
        }
        if name.starts_with('%') {
            // A bit selection implies the smallest bit string that contains it.
            let of = [Elementary::Byte, Elementary::Word, Elementary::DWord, Elementary::LWord]
                .into_iter()
                .find(|of| slice(&name.to_uppercase(), *of, None).is_some());
            if let Some(of) = of {
                self.guess(&missing, of);
            }
            return Path::Wrong;
        }
        Path::Missing(missing.part(UndeclaredStep::Member(name.to_string())))
    }

    /// The constant index into an undeclared array; `None` if it is computed.
    fn constant_index(&mut self, id: ExpressionId) -> Option<i32> {
        match self.operand(id, None) {
            Operand::Whole(whole) => i32::try_from(whole).ok(),
            Operand::Value(of, Expr::Const(value)) if of.is_whole() => i32::try_from(value.bits() as i64).ok(),
            Operand::Wrong(Some(missing)) => {
                self.guess(&missing, Elementary::Int);
                None
            }
            _ => None,
        }
    }

    fn name(&mut self, scope: Scope, name: &Name) -> Path {
        if scope != Scope::Global {
            match self.symbol(&name.text) {
                Some(Symbol::Variable(section, of, slot)) => {
                    let place = match slot {
                        Slot::Member(number) => Place::new(Base::Instance).member(number),
                        Slot::Local(number) => Place::new(Base::Local(number)),
                    };
                    let variable = Variable { of, place, slice: None, section: Some(section), timer: None };
                    self.use_view(&variable, false);
                    return Path::Variable(variable);
                }
                Some(Symbol::Constant(operand)) => return Path::Constant(operand),
                None => {}
            }
            match name.key().as_str() {
                "TRUE" => return Path::Constant(Operand::Value(Elementary::Bool, Expr::Const(true.into()))),
                "NULL" => {
                    self.error(name.span, "NULL is not supported", Some("pass the variable itself"));
                    return Path::Wrong;
                }
                "FALSE" => return Path::Constant(Operand::Value(Elementary::Bool, Expr::Const(false.into()))),
                // STEP 7's OK becomes ENO at the end of the block.
                "ENO" | "OK" if self.block.is_some() && self.is_eno(scope, &name.key()) => {
                    let own = self.block.and_then(|block| self.compiler.blocks[block].eno);
                    let place = match self.eno.or(own) {
                        Some(eno) => Place::new(Base::Local(eno)),
                        None => {
                            self.eno = Some(self.locals.len());
                            self.temp(crate::ir::Type::Scalar(Scalar::Bool))
                        }
                    };
                    let of = Type::Elementary(Elementary::Bool);
                    return Path::Variable(Variable::whole(of, place));
                }
                _ => {}
            }
        }
        if scope == Scope::Local {
            let names: Vec<String> = self.block.map_or_else(Vec::new, |block| {
                self.compiler.blocks[block].members.iter().map(|member| member.name.clone()).collect()
            });
            let like = nearest(&name.text, names.iter().map(String::as_str));
            let help = like.map(|like| format!("did you mean #{like}?"));
            self.error(name.span, format!("#{} is not declared in this block", name.text), help.as_deref());
            return Path::Wrong;
        }
        self.global(scope, name)
    }

    /// Whether a name that the block does not declare denotes its ENO; on S7-300 and S7-400, OK does too unless a
    /// source declares it.
    fn is_eno(&self, scope: Scope, name: &str) -> bool {
        let is_free =
            || self.compiler.cpu == Cpu::S7300 && scope == Scope::Bare && !self.compiler.names.contains_key(name);
        name == "ENO" || is_free() && !self.compiler.globals.contains_key(name)
    }

    /// The ENO variable of the block.
    pub(crate) fn eno_path(&mut self, name: &Name) -> Path {
        self.name(Scope::Bare, name)
    }

    fn global(&mut self, scope: Scope, name: &Name) -> Path {
        let capitals = name.key();
        if let Some(global) = self.compiler.global(&capitals) {
            return Path::Variable(Variable::whole(global.of.clone(), global.place()));
        }
        if let Some(constant) = self.compiler.global_constant(&capitals) {
            return Path::Constant(constant);
        }
        let constant = self.compiler.options.constants.iter().find(|(constant, _)| key(constant) == capitals);
        if let Some((_, value)) = constant {
            let value = value.clone();
            return Path::Constant(self.literal(&value, name.span));
        }
        if let Some(kind) = self.compiler.names.get(&capitals).map(|id| self.compiler.block(*id).kind) {
            let what = match kind {
                BlockKind::Type => "a type",
                BlockKind::DataBlock => return Path::Wrong,
                _ => "a block, not a variable",
            };
            let own = self.block.map(|block| &self.compiler.blocks[block]);
            let is_own = own.is_some_and(|own| own.kind == BlockKind::Function && key(&own.name) == capitals);
            let help = is_own.then(|| format!("its return value is #{}", name.text));
            self.error(name.span, format!("{} is {what}", name.text), help.as_deref());
            return Path::Wrong;
        }
        if scope == Scope::Bare && Elementary::named(&capitals).is_some() {
            let help = "types are fixed at compile time: write a block for each type";
            self.error(name.span, format!("{} is a type, not a value", name.text), Some(help));
            return Path::Wrong;
        }
        // STEP 7 writes `MW10` without a percent sign.
        if scope == Scope::Bare && is_address(&capitals) {
            let address = tags::address(&capitals).and_then(|address| tags::bits(&address));
            if address.is_some_and(|(_, bits)| bits.end - bits.start > 1) {
                return self.addressed(&capitals, name.span);
            }
            self.error(name.span, ABSOLUTE, None);
            return Path::Wrong;
        }
        // An undeclared data block of a timer or counter: its call determines the kind.
        if scope == Scope::Global
            && let Some(method) = self.compiler.kinds.get(&capitals).cloned()
            && let Some(block) = self.compiler.system_block(&method)
        {
            let global = self.compiler.implied(&name.text, block);
            return Path::Variable(Variable::whole(global.of.clone(), global.place()));
        }
        Path::Missing(self.compiler.miss(&name.text, name.span, Kind::Variable))
    }

    /// A member of a variable.
    pub(crate) fn member(&mut self, variable: Variable, name: &Name) -> Path {
        let capitals = name.key();
        match &variable.of {
            Type::Structure(structure) => {
                if let Some(number) = structure.number(&capitals) {
                    let of = structure.fields[number].of.clone();
                    return Path::Variable(Variable {
                        of,
                        place: variable.place.member(number),
                        timer: None,
                        ..variable
                    });
                }
                if is_data_address(&name.text) {
                    self.error(name.span, ABSOLUTE, None);
                    return Path::Wrong;
                }
                let like = nearest(&name.text, structure.fields.iter().map(|field| field.name.as_str()));
                self.no_member(&variable.of.to_string(), name, like.map(str::to_string))
            }
            Type::Instance(block) => {
                let interface = &self.compiler.blocks[*block];
                let found = interface.members.iter().find(|member| member.key == capitals).cloned();
                let Some(found) = found else {
                    let like = nearest(&name.text, interface.members.iter().map(|member| member.name.as_str()));
                    let like = like.map(str::to_string);
                    let of = interface.name.clone();
                    return self.no_member(&of, name, like);
                };
                let Slot::Member(number) = found.slot else {
                    let message = format!("{} exists only during a call: it cannot be read from outside", name.text);
                    self.error(name.span, message, None);
                    return Path::Wrong;
                };
                let updates = self.compiler.cpu != Cpu::S7300
                    && self.file != self.compiler.library_file()
                    && found.section == SectionKind::Output
                    && self.compiler.is_timer(*block);
                let timer = updates.then(|| (self.kind_of(&variable, *block), variable.place.clone()));
                let place = variable.place.clone().member(number);
                Path::Variable(Variable { of: found.of, place, timer, ..variable })
            }
            Type::Elementary(of) => match slice(&capitals, *of, variable.slice) {
                Some(slice) => Path::Variable(Variable { slice: Some(slice), ..variable }),
                None => {
                    let of = of.name();
                    self.no_member(of, name, None)
                }
            },
            Type::Text { .. } if capitals == "__LENGTH" && self.file == self.compiler.library_file() => {
                let mut place = variable.place.clone();
                place.steps.push(Step::Length);
                Path::Variable(Variable { of: Type::Elementary(Elementary::UInt), place, ..variable })
            }
            Type::Missing(missing) => {
                Path::Missing(Missing::whole(&**missing).part(UndeclaredStep::Member(name.text.clone())))
            }
            Type::Wrong => Path::Wrong,
            // A data block declared as an array: `"DB"."THIS"[1]`.
            Type::Array(_) if capitals == "THIS" => Path::Variable(variable),
            of => {
                let of = of.to_string();
                self.no_member(&of, name, None)
            }
        }
    }

    /// The block that a timer of generic type is called as; `block` if no call determines it.
    fn kind_of(&mut self, variable: &Variable, block: usize) -> usize {
        let name = self.name_of(&variable.place);
        let kind = name.and_then(|name| self.compiler.kinds.get(&name).cloned());
        kind.and_then(|kind| self.compiler.as_method(block, &kind)).unwrap_or(block)
    }

    /// The name of the last member in a place, in upper case.
    fn name_of(&self, place: &Place) -> Option<String> {
        let members = place.steps.iter().filter_map(|step| match step {
            Step::Member(number) => Some(*number),
            _ => None,
        });
        let mut of = match place.base {
            Base::Memory => crate::ir::Type::Record(self.compiler.program.memory),
            Base::Instance => crate::ir::Type::Record(self.compiler.blocks[self.block?].record),
            Base::Local(local) => self.locals[local].ty.clone(),
            Base::Constants => return None,
        };
        let mut name = None;
        for number in members {
            while let crate::ir::Type::Array { of: inner, .. } = of {
                of = *inner;
            }
            let crate::ir::Type::Record(record) = of else { return None };
            let member = self.compiler.program.records[record].members.get(number)?;
            name = Some(key(&member.name));
            of = member.ty.clone();
        }
        name
    }

    fn no_member(&mut self, of: &str, name: &Name, like: Option<String>) -> Path {
        let help = like.map(|like| format!("it has {like}"));
        self.error(name.span, format!("{of} has no member {}", name.text), help.as_deref());
        Path::Wrong
    }

    fn indexed(&mut self, variable: Variable, indices: &[ExpressionId], span: Span) -> Path {
        let (of, dimensions) = match &variable.of {
            Type::Array(array) => (array.of.clone(), array.bounds.len()),
            Type::Open(of, dimensions) => ((**of).clone(), *dimensions),
            Type::Text { wide, .. } => (Type::Elementary(if *wide { Elementary::WChar } else { Elementary::Char }), 1),
            Type::Wrong | Type::Missing(_) => return Path::Wrong,
            of => {
                let message = format!("{of} has no elements");
                self.error(span, message, None);
                return Path::Wrong;
            }
        };
        if indices.len() != dimensions {
            let message = format!("wrong number of indices: {} instead of {dimensions}", indices.len());
            self.error(span, message, None);
            return Path::Wrong;
        }
        let bounds = match &variable.of {
            Type::Array(array) => array.bounds.iter().copied().map(Some).collect(),
            _ => vec![None; dimensions],
        };
        let numbers = indices.iter().zip(bounds).map(|(index, bounds)| self.index(*index, bounds)).collect();
        let at = self.at(span);
        let mut place = variable.place;
        place.steps.push(Step::Index(numbers, at));
        Path::Variable(Variable { of, place, timer: None, ..variable })
    }

    fn index(&mut self, id: ExpressionId, bounds: Option<(i32, i32)>) -> Expr {
        let span = self.span(id);
        let operand = self.operand(id, None);
        if let Operand::Value(of, _) = &operand
            && !of.is_whole()
        {
            self.error(span, format!("an index must be an integer, not {}", with_article(of.name())), None);
            return zero(Elementary::DInt);
        }
        let value = match operand {
            Operand::Value(of, value) => {
                let to = if of.bits() > 32 || of == Elementary::UDInt || of == Elementary::DWord {
                    Scalar::I64
                } else {
                    Scalar::I32
                };
                let at = self.at(span);
                convert(value, of.scalar(), to, Convert::Value, at)
            }
            other => self.converted(other, Elementary::DInt, span),
        };
        if let (Expr::Const(number), Some((low, high))) = (&value, bounds) {
            let number = number.bits() as i64;
            if !(i64::from(low)..=i64::from(high)).contains(&number) {
                self.error(span, format!("index {number} is outside {low}..{high}"), None);
            }
        }
        value
    }

    /// The place and type of a data block's member, for its start value.
    pub(crate) fn member_of(&mut self, global: &Global, id: ExpressionId) -> Option<(Place, Type)> {
        let root = Variable::whole(global.of.clone(), global.place());
        match self.path_in(root, id)? {
            Path::Variable(variable) => Some((variable.place, variable.of)),
            _ => None,
        }
    }

    fn path_in(&mut self, root: Variable, id: ExpressionId) -> Option<Path> {
        let span = self.span(id);
        let expressions = self.expressions();
        let found = match &expressions[id].kind {
            ExpressionKind::Name(_, name) => self.member(root, name),
            ExpressionKind::Member(base, name) => match self.path_in(root, *base)? {
                Path::Variable(variable) => self.member(variable, name),
                other => other,
            },
            ExpressionKind::Index(base, indices) => match self.path_in(root, *base)? {
                Path::Variable(variable) => self.indexed(variable, indices, span),
                other => other,
            },
            _ => {
                self.error(span, "expected a member of the data block", None);
                return None;
            }
        };
        Some(found)
    }
}

/// The slice `%X3` or `%B1` of a variable or of another slice; `None` if that has no such part.
fn slice(name: &str, of: Elementary, within: Option<Slice>) -> Option<Slice> {
    let name = name.strip_prefix('%').unwrap_or(name);
    let bits = match name.chars().next()? {
        'X' => 1,
        'B' => 8,
        'W' => 16,
        'D' => 32,
        _ => return None,
    };
    let number: u32 = name[1..].parse().ok()?;
    let whole = within.map_or(of, |slice| slice.of);
    let shift = number.checked_mul(bits)?;
    let is_part = whole.is_whole() && bits <= whole.bits() && shift < whole.bits();
    is_part.then(|| Slice { of: Elementary::bit_string(bits), shift: shift + within.map_or(0, |slice| slice.shift) })
}

/// The name and type of a tag declared for an address such as `%IW4`.
pub(crate) fn placed(address: &str) -> (String, Elementary) {
    let bits = tags::bits(address).map_or(1, |(_, bits)| (bits.end - bits.start) as u32);
    (address.trim_start_matches('%').replace('.', "_"), Elementary::bit_string(bits))
}

/// Whether an unquoted name is an absolute address: `I0`, `MW10`, `PEW256`.
fn is_address(name: &str) -> bool {
    let letters = name.trim_end_matches(|last: char| last.is_ascii_digit());
    let area = letters.strip_suffix(['B', 'W', 'D', 'X']).unwrap_or(letters);
    let is_area =
        matches!(area, "I" | "E" | "Q" | "A" | "M" | "PI" | "PE" | "PQ" | "PA" | "T" | "C" | "Z" | "DB" | "DI" | "L");
    is_area && letters.len() < name.len() || matches!(name, "M" | "I" | "Q" | "E" | "A" | "MW" | "MB" | "MD")
}

/// Whether an upper-case name is a data block number: `DB11`.
pub(super) fn is_numbered_block(name: &str) -> bool {
    let number = name.strip_prefix("DB");
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether the name after a data block number is a STEP 7 area: `DX2.0`, or `DW` before an index.
fn is_classic_address(name: &str) -> bool {
    let name = name.to_uppercase();
    let letters = name.trim_end_matches(|last: char| last.is_ascii_digit() || last == '.');
    matches!(letters, "DBX" | "DBB" | "DBW" | "DBD" | "DX" | "DB" | "DW" | "DD")
}

/// Whether a member of a data block is an absolute address: `DBX0`, `%DBW2`.
fn is_data_address(name: &str) -> bool {
    let name = name.trim_start_matches('%').to_uppercase();
    let number = ["DBX", "DBB", "DBW", "DBD", "D"].iter().find_map(|area| name.strip_prefix(area));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.')))
}
