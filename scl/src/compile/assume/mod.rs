//! Declarations assumed for undeclared names: an SCL source for the program's author to read and edit.
//!
//! Tags and data blocks become variables of VAR_GLOBAL, inputs or outputs depending on their use. Blocks that are only
//! called become stubs without statements: the FMU exposes a stub's inputs as outputs and its outputs as inputs.

mod caller;
mod known;

use super::system_memory;
use crate::check::compiler::{BlockId, Compiler, Interface};
use crate::check::types::Elementary;
use crate::check::undeclared::{Bounds, Formal, Undeclared, UndeclaredStep, Uses, What};
use crate::front::syntax::{BlockKind, ExpressionKind, STUB, Scope, SectionKind, Tree, key};
use crate::ladder::{Call, Parameter, Way};
use crate::lower::placed;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;

/// The type assumed where the uses of a name do not determine one.
const DEFAULT: &str = "BOOL";

/// The lowest upper bound assumed for an array with computed indices.
const MOST_ELEMENTS: i32 = 99;

/// Constants of unknown value get increasing values above this number, which is large enough for an array bound.
const FIRST_CONSTANT: usize = 100;

/// An assumed declaration of one undeclared name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assumption {
    /// The undeclared name.
    pub name: String,
    /// A description of the assumption for the user.
    pub what: String,
    /// The first use: source index and byte offset.
    pub at: (u32, u32),
    /// Its declaration in SCL.
    pub text: String,
}

/// A block called in a network, and the call with the parameters it lists.
type Signature<'a> = (&'a str, &'a Call);

/// The signatures of the blocks called in networks, by the upper-case name of the block and of its instance.
pub fn signatures(trees: &[Tree]) -> HashMap<String, Signature<'_>> {
    let mut all = HashMap::new();
    for tree in trees {
        for element in tree.networks.iter().flat_map(|(_, network)| &network.elements) {
            let Some(call) = element.call.as_ref().filter(|call| !call.parameters.is_empty()) else { continue };
            let signature = (element.name.as_str(), call);
            all.entry(key(&element.name)).or_insert(signature);
            if let Some(ExpressionKind::Name(Scope::Global, instance)) =
                element.called.map(|called| &tree.expressions[called].kind)
            {
                all.entry(instance.key()).or_insert(signature);
            }
        }
    }
    all
}

/// Returns the declarations to assume in this round: those of the first stage that has any, since more types are known
/// in later rounds. `count` is the number of assumptions made so far; `is_declared` reports whether a block of that
/// name exists.
pub fn declare(
    missing: &BTreeMap<String, Undeclared>,
    signatures: &HashMap<String, Signature>,
    count: usize,
    is_declared: &dyn Fn(&str) -> bool,
) -> Vec<Assumption> {
    let all: Vec<Declared> =
        missing.iter().map(|(name, of)| Declared::new(of, signatures.get(name).copied())).collect();
    let stages: [&dyn Fn(&Declared) -> bool; 6] = [
        &|of| of.kind == Kind::Variable && of.is_complete,
        &|of| of.kind == Kind::Function && of.is_complete,
        &|of| of.is_complete,
        &|of| of.kind == Kind::Variable,
        &|of| of.kind == Kind::Function,
        &|_| true,
    ];
    let found = stages.iter().map(|stage| all.iter().filter(|of| stage(of)).collect::<Vec<_>>());
    let first = found.into_iter().find(|found| !found.is_empty()).unwrap_or_default();
    let mut constants = FIRST_CONSTANT + count;
    let mut assumptions = Vec::new();
    // Several instances may share one block.
    let mut blocks = BTreeSet::new();
    for declared in first {
        constants += usize::from(declared.kind == Kind::Constant);
        let block = declared.block_name();
        let is_new = !is_declared(&block) && blocks.insert(key(&block));
        assumptions.push(declared.assumption(constants, is_new));
    }
    assumptions.sort_by_key(|assumption| assumption.at);
    assumptions
}

/// The kind of declaration assumed for an undeclared name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Variable,
    Constant,
    Structure,
    Function,
    /// An undeclared function block whose instances are declared.
    Block,
    /// An undeclared instance of an undeclared function block.
    Instance,
}

/// A tag with an address.
struct Placed {
    what: String,
    name: String,
    address: String,
    of: String,
}

struct Declared<'a> {
    of: &'a Undeclared,
    kind: Kind,
    node: Node<'a>,
    /// The block and its parameters as listed in a network that calls it.
    signature: Option<Signature<'a>>,
    /// The parameters, if this is a block.
    formals: Vec<Formal>,
    is_complete: bool,
}

/// The uses of a variable or function, and those of its members, its elements and its return value.
#[derive(Default)]
struct Node<'a> {
    uses: Option<&'a Uses>,
    members: BTreeMap<&'a str, Node<'a>>,
    element: Option<Box<Node<'a>>>,
    value: Option<Box<Node<'a>>>,
}

impl<'a> Node<'a> {
    fn new(of: &'a Undeclared) -> Node<'a> {
        let mut root = Node::default();
        for (path, uses) in &of.uses {
            let mut node = &mut root;
            for part in path {
                node = match part {
                    UndeclaredStep::Member(name) => node.members.entry(name).or_default(),
                    UndeclaredStep::Element(_) => node.element.get_or_insert_default(),
                    UndeclaredStep::Value => node.value.get_or_insert_default(),
                };
            }
            node.uses = Some(uses);
        }
        root
    }

    fn ty(&self) -> Option<&'a str> {
        self.uses.and_then(|uses| uses.of.as_deref())
    }

    /// Whether the uses determine the type of every part.
    fn is_complete(&self) -> bool {
        match (self.ty(), &self.element) {
            (Some(_), _) => true,
            (None, Some(element)) => element.is_complete(),
            (None, None) => !self.members.is_empty() && self.members.values().all(Node::is_complete),
        }
    }

    /// The type in SCL; continuation lines are indented by `indent`.
    fn written(&self, indent: &str) -> String {
        if let Some(of) = self.ty() {
            return of.to_string();
        }
        if let Some(element) = &self.element {
            let bounds: Vec<String> = self.uses.iter().flat_map(|uses| &uses.bounds).map(range).collect();
            let bounds = if bounds.is_empty() { range(&Bounds::default()) } else { bounds.join(", ") };
            return format!("ARRAY[{bounds}] OF {}", element.written(indent));
        }
        match self.members.is_empty() {
            true => DEFAULT.to_string(),
            false => format!("STRUCT\n{}{indent}END_STRUCT", self.lines(&format!("{indent}   "))),
        }
    }

    /// The declarations of the members.
    fn lines(&self, indent: &str) -> String {
        let line = |(name, node): (&&str, &Node)| format!("{indent}{} : {};\n", quoted(name), node.written(indent));
        self.members.iter().map(line).collect()
    }

    fn is_written(&self) -> bool {
        self.uses.is_some_and(|uses| uses.is_written)
            || self.members.values().any(Node::is_written)
            || self.element.as_ref().is_some_and(|element| element.is_written())
    }
}

fn range(bounds: &Bounds) -> String {
    match bounds {
        Bounds { known: Some((low, high)), has_others: false } => format!("{low}..{high}"),
        Bounds { known, .. } => {
            let (low, high) = known.unwrap_or_default();
            format!("{}..{}", low.min(0), high.max(MOST_ELEMENTS))
        }
    }
}

/// The name as written in a declaration, quoted if necessary.
fn quoted(name: &str) -> String {
    let is_plain = name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    if is_plain { name.to_string() } else { format!("\"{name}\"") }
}

impl<'a> Declared<'a> {
    fn new(of: &'a Undeclared, signature: Option<Signature<'a>>) -> Declared<'a> {
        let node = Node::new(of);
        let signature = signature.filter(|_| of.is_called || matches!(of.what, What::Type | What::Block));
        let system = known::formals(&known::without_instance(&of.name));
        let has_members = !node.members.is_empty();
        let kind = match of.what {
            What::Constant => Kind::Constant,
            _ if let Some((_, call)) = signature => match (call.is_function, of.what) {
                (true, _) => Kind::Function,
                (false, What::Type | What::Block) => Kind::Block,
                (false, _) => Kind::Instance,
            },
            What::Type | What::Block if of.is_called || known::is_block(&of.name) => Kind::Block,
            What::Type | What::Block => Kind::Structure,
            What::Instance => Kind::Instance,
            // Only a function has a return value, whatever its name suggests.
            _ if node.value.is_some() => Kind::Function,
            _ if of.is_called && known::is_block(&known::without_instance(&of.name)) => {
                if known::is_block(&of.name) && !has_members { Kind::Function } else { Kind::Instance }
            }
            _ if of.is_called && (has_members || is_instance(&of.name)) => Kind::Instance,
            _ if of.is_called || of.what == What::Function => Kind::Function,
            _ => Kind::Variable,
        };
        let formals = match kind {
            Kind::Function | Kind::Block | Kind::Instance => formals(of, &node, signature, system),
            _ => Vec::new(),
        };
        let is_complete = match kind {
            Kind::Variable => node.is_complete(),
            Kind::Constant => true,
            Kind::Structure => node.members.values().all(Node::is_complete),
            Kind::Function => {
                formals.iter().all(|formal| formal.of.is_some())
                    && node
                        .value
                        .as_ref()
                        .is_none_or(|value| value.ty().is_some() || known::value(&key(&of.name)).is_some())
            }
            Kind::Block | Kind::Instance => formals.iter().all(|formal| formal.of.is_some()),
        };
        Declared { of, kind, node, signature, formals, is_complete }
    }

    /// The name of the block itself or, for an instance, of its block.
    fn block_name(&self) -> String {
        let name = &self.of.name;
        if let (Kind::Instance, Some((block, _))) = (self.kind, self.signature) {
            return block.to_string();
        }
        let block = known::without_instance(name);
        if self.kind == Kind::Instance && block == *name { format!("{name}_block") } else { block }
    }

    /// The assumption; `constant` is the value of a constant, `is_new` whether an instance's block must still be
    /// declared.
    fn assumption(&self, constant: usize, is_new: bool) -> Assumption {
        let name = &self.of.name;
        let stub = "its inputs become FMU outputs, and its outputs FMU inputs";
        let (what, text) = match (self.kind, self.placed()) {
            (Kind::Variable, Some(Placed { what, name, address, of })) => {
                (what, format!("VAR_GLOBAL\n   \"{name}\" AT {address} : {of};\nEND_VAR\n"))
            }
            (Kind::Variable, None) => {
                let of = self.node.written("   ");
                let what = match (self.node.ty(), self.node.members.len()) {
                    _ if self.node.element.is_some() => "an array".to_string(),
                    (None, 1..) => format!("a data block with {}", counted(self.node.members.len(), "member")),
                    _ if self.node.is_written() => format!("an output of type {of}"),
                    _ => format!("an input of type {of}"),
                };
                (what, format!("VAR_GLOBAL\n   \"{name}\" : {of};\nEND_VAR\n"))
            }
            (Kind::Constant, _) => {
                let of =
                    self.node.ty().filter(|of| Elementary::named(&of.to_uppercase()).is_some_and(Elementary::is_whole));
                (
                    format!("the constant {constant}: a placeholder; replace it with the actual value"),
                    format!("VAR_GLOBAL CONSTANT\n   \"{name}\" : {} := {constant};\nEND_VAR\n", of.unwrap_or("INT")),
                )
            }
            (Kind::Structure, _) => {
                let (what, lines) = match self.node.members.len() {
                    // An empty STRUCT is invalid in SCL.
                    0 => ("a type whose members are not used".to_string(), format!("   reserved : {DEFAULT};\n")),
                    count => (format!("a type with {}", counted(count, "member")), self.node.lines("   ")),
                };
                (what, format!("TYPE \"{name}\"\nSTRUCT\n{lines}END_STRUCT;\nEND_TYPE\n"))
            }
            (Kind::Function, _) => (format!("a stub of a function: {stub}"), self.function()),
            (Kind::Block, _) => (format!("a stub of a function block: {stub}"), self.block(name)),
            (Kind::Instance, _) => {
                let block = self.block_name();
                let text = if is_new { self.block(&block) } else { String::new() };
                let instance = format!("VAR_GLOBAL\n   \"{name}\" : \"{block}\";\nEND_VAR\n");
                (format!("an instance of the stub {block}: {stub}"), text + &instance)
            }
        };
        Assumption { name: name.clone(), what, at: (self.of.span.file, self.of.span.start), text }
    }

    /// The tag for an absolute address, or for memory that the CPU itself writes, unless the uses imply another type.
    fn placed(&self) -> Option<Placed> {
        let name = &self.of.name;
        let told = self.node.ty();
        if name.starts_with('%') {
            let (tag, usual) = placed(name);
            let is_wide = |of: &&str| Elementary::named(&of.to_uppercase()).is_some_and(|of| of.bits() == usual.bits());
            let of = told.filter(is_wide).unwrap_or(usual.name()).to_string();
            return Some(Placed { what: format!("a tag at {name}"), name: tag, address: name.clone(), of });
        }
        let (address, of) = system_memory::proposed(&key(name))?;
        let is_plain = self.node.element.is_none() && self.node.members.is_empty() && !self.node.is_written();
        (is_plain && told.is_none_or(|told| told.eq_ignore_ascii_case(of))).then(|| Placed {
            what: format!("system or clock memory at {address}"),
            name: name.clone(),
            address,
            of: of.to_string(),
        })
    }

    fn block(&self, name: &str) -> String {
        function_block(name, &sections(&self.formals))
    }

    fn function(&self) -> String {
        let value = self.node.value.as_ref().map(|value| value.ty().unwrap_or(DEFAULT));
        let mut listed = self.signature.iter().flat_map(|(_, call)| &call.parameters);
        let listed = listed.find(|parameter| parameter.way == Way::Value).and_then(|of| declarable(of.of.as_deref()?));
        let value = listed.as_deref().or(known::value(&key(&self.of.name))).or(value);
        function(&self.of.name, value.unwrap_or("VOID"), &self.formals)
    }
}

/// A function stub that copies its arguments to variables, and its outputs and return value from variables.
fn function(name: &str, result: &str, formals: &[Formal]) -> String {
    let call = format!("{name}_call");
    let mut members = String::new();
    let mut body = String::new();
    for formal in formals {
        let own = quoted(&formal.name);
        let of = formal.of.as_deref().unwrap_or(DEFAULT);
        let _ = writeln!(members, "      {own} : {of};");
        let parameter = format!("#{own}");
        let _ = match formal.way {
            Way::Output => writeln!(body, "   {parameter} := \"{call}\".{own};"),
            _ => writeln!(body, "   \"{call}\".{own} := {parameter};"),
        };
    }
    if result != "VOID" {
        let _ = writeln!(members, "      RET_VAL : {result};");
        let _ = writeln!(body, "   RET_VAL := \"{call}\".RET_VAL;");
    }
    let globals = match members.is_empty() {
        true => String::new(),
        false => format!("VAR_GLOBAL\n   \"{call}\" : STRUCT\n{members}   END_STRUCT;\nEND_VAR\n"),
    };
    let sections = sections(formals);
    format!("FUNCTION \"{name}\" : {result}\n{{ {STUB} := 'TRUE' }}\n{sections}BEGIN\n{body}END_FUNCTION\n{globals}")
}

impl Compiler<'_> {
    /// Stubs for blocks that contain errors: those named in `only` or, if it is `None`, all but the block to run. The
    /// errors in a block replaced by a stub are ignored.
    pub fn unreadable(&self, only: Option<&[String]>) -> Vec<Assumption> {
        let is_called =
            |block: usize| self.calls.iter().any(|(caller, callee, _)| *callee == block && *caller != block);
        let is_protected = |(file, index): BlockId| self.trees[file].protected.iter().any(|(of, _)| *of == index);
        let is_asked = |block: usize, of: &Interface| match only {
            Some(names) => names.iter().any(|name| key(name) == key(&of.name)),
            // The block to run is not replaced by a stub. Without organization blocks, this may be any block that no
            // other calls.
            None => {
                is_called(block)
                    || of.source.is_some_and(is_protected)
                    || self.blocks.iter().any(|of| of.kind == BlockKind::OrganizationBlock)
            }
        };
        let stub = |(number, interface): (usize, &Interface)| {
            let (file, index) = interface.source.filter(|(file, _)| *file != self.library_file())?;
            let block = self.block((file, index));
            let reason = self.report.first_error(self.trees[file].extents[index])?;
            if block.is_stub() || !is_asked(number, interface) {
                return None;
            }
            let text = match interface.kind {
                BlockKind::FunctionBlock => self.stub_of_block(interface),
                BlockKind::Function => self.stub_of_function(interface),
                _ => return None,
            };
            let what = format!("a stub, because it cannot be read: {reason}");
            Some(Assumption { name: interface.name.clone(), what, at: (file as u32, block.name.span.start), text })
        };
        self.blocks.iter().enumerate().filter_map(stub).collect()
    }

    /// The declarations of a block's variables in a section, except those whose type cannot be written in a
    /// declaration.
    fn lines(&self, interface: &Interface, of: SectionKind) -> String {
        let members = interface.members.iter().filter(|member| member.section == of);
        members
            .filter_map(|member| Some(format!("   {} : {};\n", quoted(&member.name), self.written(&member.of)?)))
            .collect()
    }

    fn stub_of_block(&self, interface: &Interface) -> String {
        let words = [
            ("VAR_INPUT", SectionKind::Input),
            ("VAR_OUTPUT", SectionKind::Output),
            ("VAR_IN_OUT", SectionKind::InOut),
            ("VAR", SectionKind::Static),
        ];
        let sections = words.map(|(word, of)| section(word, &self.lines(interface, of)));
        function_block(&interface.name, &sections.concat())
    }

    fn stub_of_function(&self, interface: &Interface) -> String {
        let formals = interface.members.iter().filter_map(|member| {
            let (way, of) = (way(member.section)?, Some(self.written(&member.of)?));
            Some(Formal { name: member.name.clone(), way, of })
        });
        let result = self.written(&interface.result).unwrap_or_else(|| "VOID".into());
        function(&interface.name, &result, &formals.collect::<Vec<_>>())
    }
}

/// The direction of the parameters in a section; `None` for sections without parameters.
fn way(section: SectionKind) -> Option<Way> {
    match section {
        SectionKind::Input => Some(Way::Input),
        SectionKind::Output => Some(Way::Output),
        SectionKind::InOut => Some(Way::InOut),
        SectionKind::Static | SectionKind::Temp | SectionKind::Constant => None,
    }
}

/// Whether a name follows TIA Portal's scheme for instances, such as `TON_DB_1`.
fn is_instance(name: &str) -> bool {
    known::without_instance(name) != name
}

/// The parameters of a block: those listed in a network's call or, failing that, of the known system block, then the
/// arguments of other calls and the members used of its instances.
fn formals(of: &Undeclared, node: &Node, signature: Option<Signature>, system: Vec<Formal>) -> Vec<Formal> {
    let mut all: Vec<Formal> = Vec::new();
    let mut names = BTreeSet::new();
    let listed = signature.map(|(_, call)| {
        let parameters = call.parameters.iter().filter(|parameter| parameter.way != Way::Value);
        let formal = |parameter: &Parameter| Formal {
            name: parameter.name.clone(),
            way: parameter.way,
            of: parameter.of.as_deref().and_then(declarable),
        };
        parameters.map(formal).collect()
    });
    for known in listed.unwrap_or(system) {
        let given = of.formals.iter().find(|formal| key(&formal.name) == key(&known.name));
        // A parameter without a type in the table takes the type of its argument.
        let ty = known.of.clone().or_else(|| given.and_then(|given| given.of.clone()));
        if known.of.is_some() || given.is_some() {
            names.insert(key(&known.name));
            all.push(Formal { of: ty, ..known });
        }
    }
    for formal in &of.formals {
        if names.insert(key(&formal.name)) {
            all.push(formal.clone());
        }
    }
    for (name, member) in &node.members {
        let ty = member.is_complete().then(|| member.written("   "));
        match all.iter_mut().find(|formal| key(&formal.name) == key(name)) {
            Some(formal) => formal.of = formal.of.take().or(ty),
            None => {
                let way = if member.is_written() { Way::Input } else { Way::Output };
                all.push(Formal { name: (*name).to_string(), way, of: ty });
            }
        }
    }
    all
}

fn sections(formals: &[Formal]) -> String {
    let of_kind = |(word, way): (&str, Way)| {
        let of = |formal: &Formal| formal.of.clone().unwrap_or_else(|| DEFAULT.to_string());
        let lines: String = formals
            .iter()
            .filter(|formal| formal.way == way)
            .map(|formal| format!("   {} : {};\n", quoted(&formal.name), of(formal)))
            .collect();
        section(word, &lines)
    };
    let words = [("VAR_INPUT", Way::Input), ("VAR_OUTPUT", Way::Output), ("VAR_IN_OUT", Way::InOut)];
    words.into_iter().map(of_kind).collect()
}

/// The type of a parameter listed in a call, if it can be written in the declaration of a stub.
fn declarable(of: &str) -> Option<String> {
    let is_plain =
        Elementary::named(&of.to_uppercase()).is_some() || ["STRING", "WSTRING", "DTL"].contains(&key(of).as_str());
    (is_plain || of.starts_with('"')).then(|| of.to_string())
}

/// A count with its noun: `1 member`, `2 members`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A declaration section; empty if it has no declarations.
fn section(word: &str, lines: &str) -> String {
    if lines.is_empty() { String::new() } else { format!("{word}\n{lines}END_VAR\n") }
}

/// A stub for a function block with these sections.
fn function_block(name: &str, sections: &str) -> String {
    format!("FUNCTION_BLOCK \"{name}\"\n{{ {STUB} := 'TRUE' }}\n{sections}BEGIN\nEND_FUNCTION_BLOCK\n")
}
