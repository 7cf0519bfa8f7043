//! Names that no source declares.

use crate::compiler::Compiler;
use crate::lexer::Span;
use crate::syntax::{BlockKind, key};
use crate::types::Type;
use parameters::Remedy;
use std::collections::BTreeMap;

/// What is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A PLC tag, a constant or a data block.
    Variable,
    /// A constant: only one can stand where it is used.
    Constant,
    /// A type.
    Type,
    /// A function.
    Function,
    /// A function block.
    Block,
    /// An instance.
    Instance,
}

/// A name that no source declares, or a part of what it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The name by which it is found.
    pub name: String,
    /// What leads to the part; empty for the whole.
    pub path: Vec<Part>,
}

/// A step into something whose declaration is missing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// A member, as it is written.
    Member(String),
    /// An element of an array with so many dimensions.
    Element(usize),
    /// The value of a function.
    Value,
}

impl Missing {
    /// All of a name.
    pub fn whole(name: impl Into<String>) -> Missing {
        Missing { name: name.into(), path: Vec::new() }
    }

    /// A part of it.
    pub fn part(mut self, part: Part) -> Missing {
        self.path.push(part);
        self
    }
}

/// What its uses tell of something whose declaration is missing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// Its type as it is written, where its surroundings tell.
    pub of: Option<String>,
    /// Whether only a 0 or 1 tells the type, which may be a truth value as well.
    pub is_doubtful: bool,
    /// Whether something writes it.
    pub is_written: bool,
    /// The lowest and the highest index of each dimension, where it is an array, and whether some are calculated.
    pub bounds: Vec<Bounds>,
}

/// The indices of a dimension that are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// The lowest and the highest one that is a constant.
    pub known: Option<(i32, i32)>,
    /// Whether there are others.
    pub has_others: bool,
}

/// An argument of a call of something whose declaration is missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formal {
    /// The parameter.
    pub name: String,
    /// Whether the call takes its value.
    pub is_output: bool,
    /// Its type as it is written, where the argument tells.
    pub of: Option<String>,
}

/// A name that no source declares.
#[derive(Clone, Debug)]
pub struct Undeclared {
    /// Its first spelling.
    pub name: String,
    /// Where first.
    pub span: Span,
    /// What it is by its use.
    pub what: What,
    /// What its uses tell, of the whole and of its parts.
    pub uses: BTreeMap<Vec<Part>, Uses>,
    /// The arguments with which it is called, each once.
    pub formals: Vec<Formal>,
    /// Whether it is called.
    pub is_called: bool,
}

/// A message lists this many names at most.
pub const MOST_NAMES: usize = 10;

impl Undeclared {
    /// Its type, where its surroundings tell.
    fn of(&self) -> Option<&str> {
        self.uses.get([].as_slice()).and_then(|uses| uses.of.as_deref())
    }

    /// The members that are used, without what is below them.
    fn members(&self) -> Vec<&str> {
        let mut members: Vec<&str> = Vec::new();
        for path in self.uses.keys() {
            let member = match path.first() {
                Some(Part::Member(name)) => name.as_str(),
                Some(Part::Element(_)) => "[]",
                Some(Part::Value) | None => continue,
            };
            if members.last() != Some(&member) {
                members.push(member);
            }
        }
        members
    }
}

impl Compiler<'_> {
    /// Keeps a name that is missing, for one message.
    pub fn miss(&mut self, name: &str, span: Span, what: What) -> Missing {
        let new = || Undeclared {
            name: name.to_string(),
            span,
            what,
            uses: BTreeMap::new(),
            formals: Vec::new(),
            is_called: false,
        };
        self.undeclared.entry(key(name)).or_insert_with(new);
        Missing::whole(key(name))
    }

    /// What is known of the uses of something that is missing.
    fn uses(&mut self, missing: &Missing) -> Option<&mut Uses> {
        let undeclared = self.undeclared.get_mut(&missing.name)?;
        Some(undeclared.uses.entry(missing.path.clone()).or_default())
    }

    /// Something of a missing name is read.
    pub fn use_missing(&mut self, missing: &Missing) {
        self.uses(missing);
    }

    /// Something of a missing name is written.
    pub fn write_missing(&mut self, missing: &Missing) {
        if let Some(uses) = self.uses(missing) {
            uses.is_written = true;
        }
    }

    /// What the surroundings tell of the type of something that is missing: the first that tell it count.
    pub fn guess_missing(&mut self, missing: &Missing, of: String) {
        if let Some(uses) = self.uses(missing) {
            if std::mem::take(&mut uses.is_doubtful) {
                uses.of = None;
            }
            uses.of.get_or_insert(of);
        }
    }

    /// A 0 or 1 is written to something that is missing: a number, unless another use tells a truth value.
    pub fn guess_bit(&mut self, missing: &Missing) {
        if let Some(uses) = self.uses(missing).filter(|uses| uses.of.is_none()) {
            (uses.of, uses.is_doubtful) = (Some("INT".to_string()), true);
        }
    }

    /// An array that is missing has an element with these indices; `None` is one that is calculated.
    pub fn index_missing(&mut self, array: &Missing, indices: &[Option<i32>]) {
        let Some(uses) = self.uses(array) else { return };
        uses.bounds.resize(uses.bounds.len().max(indices.len()), Bounds::default());
        for (bounds, index) in uses.bounds.iter_mut().zip(indices) {
            match *index {
                Some(index) => {
                    let (low, high) = bounds.known.unwrap_or((index, index));
                    bounds.known = Some((low.min(index), high.max(index)));
                }
                None => bounds.has_others = true,
            }
        }
    }

    /// Something that is missing is called.
    pub fn call_missing(&mut self, name: &str, formals: Vec<Formal>) {
        let Some(undeclared) = self.undeclared.get_mut(name) else { return };
        undeclared.is_called = true;
        for formal in formals {
            match undeclared.formals.iter_mut().find(|of| key(&of.name) == key(&formal.name)) {
                Some(known) => known.of = known.of.take().or(formal.of),
                None => undeclared.formals.push(formal),
            }
        }
    }

    /// A type as a declaration has it; `None` if it has no name there.
    pub fn written(&self, of: &Type) -> Option<String> {
        match of {
            Type::Elementary(of) => Some(of.name().to_string()),
            Type::Text { wide, .. } => Some(if *wide { "WSTRING" } else { "STRING" }.to_string()),
            Type::Array(array) => {
                let bounds: Vec<String> = array.bounds.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                Some(format!("ARRAY[{}] OF {}", bounds.join(", "), self.written(&array.of)?))
            }
            Type::Structure(structure) if structure.name == "DTL" => Some("DTL".to_string()),
            Type::Structure(structure) if self.library.contains_key(&key(&structure.name)) => {
                Some(structure.name.clone())
            }
            Type::Structure(structure) => {
                let id = self.names.get(&key(&structure.name))?;
                (self.block(*id).kind == BlockKind::Type).then(|| format!("\"{}\"", structure.name))
            }
            Type::Instance(block) => {
                let interface = &self.blocks[*block];
                match interface.source {
                    Some((file, _)) if file != self.library_file() => Some(format!("\"{}\"", interface.name)),
                    _ => Some(interface.name.clone()),
                }
            }
            Type::Missing(_) | Type::Open(..) | Type::Void | Type::Wrong => None,
        }
    }

    /// A missing name stands where only a constant can.
    pub fn is_constant(&mut self, missing: &Missing) {
        if let Some(undeclared) = self.undeclared.get_mut(&missing.name) {
            undeclared.what = What::Constant;
        }
    }

    /// One message for all tags, and one for each other name; at most ten names of a kind.
    pub fn tell_undeclared(&mut self) {
        let (tags, mut others): (Vec<Undeclared>, Vec<Undeclared>) = std::mem::take(&mut self.undeclared)
            .into_values()
            .partition(|of| of.what == What::Variable && of.members().is_empty());
        others.sort_by_key(|of| (of.what as u8, of.span));
        for kind in others.chunk_by(|one, other| one.what == other.what) {
            kind.iter().take(MOST_NAMES).for_each(|missing| self.tell_missing(missing));
            if let Some(rest) = kind.get(MOST_NAMES) {
                let (count, what) = (kind.len() - MOST_NAMES, kind[0].what.plural());
                let message = format!("no source declares {count} more {what}");
                self.report.error_with(rest.span, message, Some(Remedy::ListMissing));
            }
        }
        self.tell_tags(tags);
    }

    fn tell_missing(&mut self, missing: &Undeclared) {
        let Undeclared { name, span, what, .. } = missing;
        let sources = || "in TIA Portal: Generate source from blocks, including dependent ones".into();
        let (what, help): (&str, Remedy) = match what {
            What::Variable => {
                let all = missing.members();
                let mut members: Vec<String> =
                    all.iter().take(MOST_NAMES).map(|member| format!("{name}.{member}")).collect();
                members.extend(more(all.len()));
                let message = format!("no source declares the data block \"{name}\": {}", members.join(", "));
                let help = match more(all.len()) {
                    Some(_) => Remedy::ListMissing,
                    None => "export this DB as source, or declare it in a .scl file".into(),
                };
                return self.report.error_with(*span, message, Some(help));
            }
            What::Constant => ("constant", Remedy::DeclareConstant(name.clone())),
            What::Type => ("type", sources()),
            What::Function => ("function", sources()),
            What::Block => ("function block", sources()),
            What::Instance => ("instance", Remedy::DeclareInstance(name.clone())),
        };
        self.report.error_with(*span, format!("no source declares the {what} \"{name}\""), Some(help));
    }

    fn tell_tags(&mut self, mut tags: Vec<Undeclared>) {
        tags.sort_by_key(|tag| tag.span);
        let Some(first) = tags.first() else { return };
        let name = |tag: &Undeclared| match tag.of() {
            Some(of) => format!("\"{}\" : {of}", tag.name),
            None => format!("\"{}\"", tag.name),
        };
        let mut names: Vec<String> = tags.iter().take(MOST_NAMES).map(name).collect();
        names.extend(more(tags.len()));
        let of = first.of().unwrap_or("Bool").to_string();
        let help = match more(tags.len()) {
            Some(_) => Remedy::ListMissing,
            None => Remedy::DeclareTag { name: first.name.clone(), of },
        };
        self.report.error_with(first.span, format!("no source declares the tags {}", names.join(", ")), Some(help));
    }
}

impl Undeclared {
    /// What it is by its use, in the plural.
    pub fn kind(&self) -> &'static str {
        match self.what {
            What::Variable if self.members().is_empty() => "tags",
            what => what.plural(),
        }
    }
}

impl What {
    /// Several of them, in a message.
    fn plural(self) -> &'static str {
        match self {
            What::Variable => "data blocks",
            What::Constant => "constants",
            What::Type => "types",
            What::Function => "functions",
            What::Block => "function blocks",
            What::Instance => "instances",
        }
    }
}

/// What a list ends with that leaves names out.
fn more(count: usize) -> Option<String> {
    (count > MOST_NAMES).then(|| format!("and {} more", count - MOST_NAMES))
}
