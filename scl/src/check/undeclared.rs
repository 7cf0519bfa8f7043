//! Names that no source declares: collects their uses and reports them.

use crate::check::compiler::Compiler;
use crate::check::types::{Elementary, Type, text_name};
use crate::front::lexer::Span;
use crate::front::syntax::{BlockKind, key};
use crate::ladder::Way;
use parameters::Remedy;
use std::collections::BTreeMap;

/// The kind of an undeclared name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A PLC tag, a data block or a constant not recognizable as such.
    Variable,
    /// A constant, recognizable because only a constant is allowed where the name is used.
    Constant,
    Type,
    Function,
    Block,
    Instance,
}

/// An undeclared name, or a part of the object it denotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The lookup key of the name.
    pub name: String,
    /// The path to the part; empty for the whole.
    pub path: Vec<UndeclaredStep>,
}

/// A step in the path to a part of something undeclared.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum UndeclaredStep {
    /// A member, as written.
    Member(String),
    /// An element of an array with this number of dimensions.
    Element(usize),
    /// The return value of a function.
    Value,
}

impl Missing {
    /// The whole object that a name denotes.
    pub fn whole(name: impl Into<String>) -> Missing {
        Missing { name: name.into(), path: Vec::new() }
    }

    /// Extends the path by a step.
    pub fn part(mut self, part: UndeclaredStep) -> Missing {
        self.path.push(part);
        self
    }
}

/// Information about an undeclared variable or part, inferred from its uses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// Its type as written in SCL, if the context determines it.
    pub of: Option<String>,
    /// Whether the type is only the likeliest one: 0 or 1 is written to the variable, or it is compared or computed
    /// only with other undeclared ones.
    pub is_doubtful: bool,
    /// Whether it is written anywhere.
    pub is_written: bool,
    /// The indices used in each dimension, if it is an array.
    pub bounds: Vec<Bounds>,
}

/// The indices used in one dimension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// The lowest and highest constant index.
    pub known: Option<(i32, i32)>,
    /// Whether there are computed indices.
    pub has_others: bool,
}

/// A parameter of something undeclared, inferred from an argument in a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formal {
    /// The name of the parameter.
    pub name: String,
    /// Its direction.
    pub way: Way,
    /// Its type as written in SCL, if the argument determines it.
    pub of: Option<String>,
}

/// An undeclared name, with all its uses.
#[derive(Clone, Debug)]
pub struct Undeclared {
    /// Its spelling at the first use.
    pub name: String,
    /// The location of the first use.
    pub span: Span,
    /// Its kind, inferred from its uses.
    pub what: What,
    /// The uses of the whole and of its parts.
    pub uses: BTreeMap<Vec<UndeclaredStep>, Uses>,
    /// The arguments with which it is called, without duplicates.
    pub formals: Vec<Formal>,
    pub is_called: bool,
}

/// The maximum number of names listed in a message.
pub(crate) const MOST_NAMES: usize = 10;

impl Undeclared {
    /// Its type, if the context determines it.
    fn ty(&self) -> Option<&str> {
        self.uses.get([].as_slice()).and_then(|uses| uses.of.as_deref())
    }

    /// The names of the members that are used, without their own members; `[]` represents the elements.
    fn members(&self) -> Vec<&str> {
        let mut members: Vec<&str> = Vec::new();
        for path in self.uses.keys() {
            let member = match path.first() {
                Some(UndeclaredStep::Member(name)) => name.as_str(),
                Some(UndeclaredStep::Element(_)) => "[]",
                Some(UndeclaredStep::Value) | None => continue,
            };
            if members.last() != Some(&member) {
                members.push(member);
            }
        }
        members
    }
}

impl Compiler<'_> {
    /// Records an undeclared name so that it is reported only once.
    pub fn miss(&mut self, name: &str, span: Span, what: What) -> Missing {
        let is_constant = || self.trees.iter().any(|tree| tree.constants.contains(&key(name)));
        let new = || Undeclared {
            name: name.to_string(),
            span,
            what: if is_constant() { What::Constant } else { what },
            uses: BTreeMap::new(),
            formals: Vec::new(),
            is_called: false,
        };
        self.undeclared.entry(key(name)).or_insert_with(new);
        Missing::whole(key(name))
    }

    /// The recorded uses of something undeclared.
    fn uses(&mut self, missing: &Missing) -> Option<&mut Uses> {
        let undeclared = self.undeclared.get_mut(&missing.name)?;
        Some(undeclared.uses.entry(missing.path.clone()).or_default())
    }

    /// Records that something undeclared is read.
    pub fn use_missing(&mut self, missing: &Missing) {
        self.uses(missing);
    }

    /// Records that something undeclared is written.
    pub fn write_missing(&mut self, missing: &Missing) {
        if let Some(uses) = self.uses(missing) {
            uses.is_written = true;
        }
    }

    /// Records the type that the context implies for something undeclared. The first such type wins; it replaces a
    /// doubtful one.
    pub fn guess_missing(&mut self, missing: &Missing, of: String) {
        if let Some(uses) = self.uses(missing) {
            if std::mem::take(&mut uses.is_doubtful) {
                uses.of = None;
            }
            uses.of.get_or_insert(of);
        }
    }

    /// Records the likeliest type of something undeclared, unless another use determines it.
    pub fn guess_likely(&mut self, missing: &Missing, of: Elementary) {
        if let Some(uses) = self.uses(missing).filter(|uses| uses.of.is_none()) {
            (uses.of, uses.is_doubtful) = (Some(of.name().to_string()), true);
        }
    }

    /// Records the indices used to access an undeclared array; `None` means a computed index.
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

    /// Records a call to something undeclared.
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

    /// A type in SCL notation; `None` if it cannot be written in a declaration.
    pub fn written(&self, of: &Type) -> Option<String> {
        match of {
            Type::Elementary(of) => Some(of.name().to_string()),
            Type::Text { wide, .. } => Some(text_name(*wide).to_string()),
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

    /// Records that an undeclared name is used where only a constant is allowed.
    pub fn is_constant(&mut self, missing: &Missing) {
        if let Some(undeclared) = self.undeclared.get_mut(&missing.name) {
            undeclared.what = What::Constant;
        }
    }

    /// Reports undeclared names: one message for all tags, and one for each other name, up to [`MOST_NAMES`] per kind.
    pub fn tell_undeclared(&mut self) {
        let (tags, mut others): (Vec<Undeclared>, Vec<Undeclared>) = std::mem::take(&mut self.undeclared)
            .into_values()
            .partition(|of| of.what == What::Variable && of.members().is_empty());
        others.sort_by_key(|of| (of.what as u8, of.span));
        for kind in others.chunk_by(|one, other| one.what == other.what) {
            // A single one more is named, not counted.
            let named = if kind.len() == MOST_NAMES + 1 { kind.len() } else { MOST_NAMES };
            kind.iter().take(named).for_each(|missing| self.tell_missing(missing));
            if let Some(rest) = kind.get(named) {
                let (count, what) = (kind.len() - named, kind[0].what.plural());
                let message = format!("no source declares {count} more {what}");
                self.report.error_with(rest.span, message, Some(Remedy::ListMissing));
            }
        }
        self.tell_tags(tags);
    }

    fn tell_missing(&mut self, missing: &Undeclared) {
        let Undeclared { name, span, what, .. } = missing;
        let sources = || "in TIA Portal: Generate source from blocks, including all dependent blocks".into();
        let (what, help): (&str, Remedy) = match what {
            What::Variable => {
                let all = missing.members();
                let mut members: Vec<String> =
                    all.iter().take(MOST_NAMES).map(|member| format!("{name}.{member}")).collect();
                members.extend(more(all.len()));
                let message = format!("no source declares the data block \"{name}\": {}", members.join(", "));
                let help = match more(all.len()) {
                    Some(_) => Remedy::ListMissing,
                    None => "export this DB as a source, or declare it in a .scl file".into(),
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
        let name = |tag: &Undeclared| match tag.ty() {
            Some(of) => format!("\"{}\" : {of}", tag.name),
            None => format!("\"{}\"", tag.name),
        };
        let mut names: Vec<String> = tags.iter().take(MOST_NAMES).map(name).collect();
        names.extend(more(tags.len()));
        let of = first.ty().unwrap_or("Bool").to_string();
        let help = match more(tags.len()) {
            Some(_) => Remedy::ListMissing,
            None => Remedy::DeclareTag { name: first.name.clone(), of },
        };
        let plural = if tags.len() == 1 { "" } else { "s" };
        let message = format!("no source declares the tag{plural} {}", names.join(", "));
        self.report.error_with(first.span, message, Some(help));
    }
}

impl Undeclared {
    /// Its inferred kind, in the plural.
    pub fn kind(&self) -> &'static str {
        match self.what {
            What::Variable if self.members().is_empty() => "tags",
            what => what.plural(),
        }
    }
}

impl What {
    /// The plural of the kind, for messages.
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

/// The end of a list of `count` names, of which [`MOST_NAMES`] are shown; `None` if all are.
fn more(count: usize) -> Option<String> {
    (count > MOST_NAMES).then(|| format!("and {} more", count - MOST_NAMES))
}
