//! The complete compilation, from sources and options to a [`Compiled`]: the typed program, the calls in a cycle
//! ([`root`]), the interface that an FMU exposes ([`interface`]), and warnings. This folder handles the program as a
//! whole rather than a single block: several [`copies`] of a block, tags that [`overlap`], tags written by the CPU
//! ([`system_memory`]), and declarations for missing names ([`assume`](mod@assume)).

pub mod assume;
mod copies;
pub mod interface;
mod overlap;
pub(crate) mod root;
pub(crate) mod system_memory;

use crate::check::compiler::{BlockId, Compiler, Note};
use crate::front::lexer::Span;
use crate::front::parser;
use crate::front::syntax::{BlockKind, ExpressionId, Tree, key};
use crate::ir::{Body, Program, Statement};
use crate::ladder::{self, Network};
use crate::report::Report;
use crate::watch;
use assume::{Assumption, declare, signatures};
use manifest::{Cpu, Manifest};
use parameters::{Problems, Remedy, Source};
use root::Root;
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A compiled program.
#[derive(Debug)]
pub struct Compiled {
    /// The typed program.
    pub program: Program,
    /// The CPU whose rules apply.
    pub cpu: Cpu,
    /// The function to run every cycle, and the path of its instance in memory; `None` if no block can be run, or if
    /// several can and none has been chosen.
    pub root: Option<Root>,
    /// The names of all blocks that can be run: organization blocks except startup, and function blocks that no other
    /// block calls.
    pub candidates: Vec<String>,
    /// The global variables: tags and the members of data blocks, by name.
    pub globals: Vec<interface::Variable>,
    /// Warnings for the program's author.
    pub warnings: Vec<Problems>,
    /// Where a watched program records the values on its wires.
    pub notes: Vec<Note>,
}

impl Compiled {
    /// The indices of the functions that contain statements from the user's sources.
    pub fn blocks(&self) -> Vec<usize> {
        let own = self.program.files.len().saturating_sub(1);
        let is_own = |statement: &Statement| statement.at.line > 0 && usize::from(statement.at.file) < own;
        let functions = self.program.functions.iter().enumerate();
        let blocks = functions.filter(|(_, function)| match &function.body {
            Body::Code(code) => code.iter().any(is_own),
            Body::Native(_) => false,
        });
        blocks.map(|(number, _)| number).collect()
    }
}

/// The parsed sources, with the library last.
struct Trees {
    sources: Vec<Source>,
    trees: Vec<Tree>,
    cpu: Cpu,
}

impl Trees {
    fn read(sources: &[Source], options: &Manifest, report: &mut Report) -> Trees {
        let mut trees = crate::front::trees(sources, report);
        let is_tia = trees.iter().any(|tree| tree.is_tia);
        let cpu = options.cpu.unwrap_or(if is_tia { Cpu::S71500 } else { Cpu::S7300 });
        if trees.iter().all(|tree| tree.blocks.is_empty()) && !report.has_errors() {
            report.error(
                Span::default(),
                "no block is declared here",
                Some("declare one, for example with FUNCTION_BLOCK"),
            );
        }
        let library = crate::library::source();
        let library_tree = parser::parse(&library.text, sources.len() as u32, report);
        trees.push(Tree { may_set_eno: false, ..library_tree });
        let mut sources: Vec<Source> = sources.to_vec();
        sources.push(library);
        Trees { sources, trees, cpu }
    }
}

/// Compiles sources to a program.
///
/// # Errors
/// All errors in all sources, by source.
pub fn compile(sources: &[Source], options: &Manifest) -> Result<Compiled, Vec<Problems>> {
    translated(sources, options, false)
}

/// Compiles a program that records, while it runs, the values on the wires of its networks and the operands of its
/// conditions. Its results are the same as without recording.
///
/// # Errors
/// All errors in all sources, by source.
pub fn compile_watched(sources: &[Source], options: &Manifest) -> Result<Compiled, Vec<Problems>> {
    translated(sources, options, true)
}

fn translated(sources: &[Source], options: &Manifest, is_watched: bool) -> Result<Compiled, Vec<Problems>> {
    let mut report = Report::default();
    let Trees { sources: all, trees, cpu } = Trees::read(sources, options, &mut report);
    let mut compiler = Compiler::new(&all, &trees, cpu, options, report, 0);
    if is_watched {
        let all = trees.iter().enumerate();
        let conditions = all.flat_map(|(file, tree)| watch::terms(tree).into_iter().map(move |id| (file, id)));
        compiler.watched = wires(&trees).into_iter().chain(conditions).collect();
    }
    compiler.run();
    compiler.tell_different();
    let (root, candidates) = (compiler.root(), compiler.candidates());
    let instance = root.as_ref().map_or("", |root| root.instance.as_str());
    let globals = interface::globals(&compiler, instance);
    let globals = compiler.told(globals, Span::default()).unwrap_or_default();
    compiler.tell_overlaps();
    compiler.tell_undeclared();
    let Compiler { report, mut program, notes, .. } = compiler;
    program.files = all.iter().map(|source| source.file.clone()).collect();
    let has_errors = report.has_errors();
    let (errors, warnings) = report.problems(&all);
    if has_errors { Err(errors) } else { Ok(Compiled { program, cpu, root, candidates, globals, warnings, notes }) }
}

/// The expressions on the wires of the networks: operands of elements and their results.
fn wires(trees: &[Tree]) -> HashSet<(usize, ExpressionId)> {
    let all = trees.iter().enumerate().flat_map(|(file, tree)| tree.networks.iter().map(move |(_, of)| (file, of)));
    let of = |(file, network): (usize, &Network)| {
        let sources = network.elements.iter().flat_map(|element| &element.inputs).flat_map(|input| &input.sources);
        let operands = sources.filter_map(|source| match source {
            ladder::Source::Operand(operand) => Some(*operand),
            ladder::Source::Rail | ladder::Source::Pin(..) => None,
        });
        let carried = network.carried.iter().filter_map(|(_, of)| *of);
        operands.chain(carried).map(|id| (file, id)).collect::<Vec<_>>()
    };
    all.flat_map(of).collect()
}

/// An overview of sources, which may be incomplete.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// The blocks: kind, name, source index. A block found in several sources is listed once.
    pub blocks: Vec<(BlockKind, String, usize)>,
    /// Undeclared names, each with its kind inferred from its use, in the plural.
    pub missing: Vec<(String, &'static str)>,
    /// The number of declared tags that the program uses.
    pub tags: usize,
}

/// Lists the declarations in the sources, and the names used without one.
pub fn survey(sources: &[Source], options: &Manifest) -> Survey {
    let mut report = Report::default();
    let Trees { sources: all, trees, cpu } = Trees::read(sources, options, &mut report);
    let mut compiler = Compiler::new(&all, &trees, cpu, options, report, 0);
    compiler.assumes = true;
    compiler.run();
    let is_used = |tag: &&parameters::tags::Tag| compiler.globals.contains_key(&key(&tag.name));
    let tags = options.declared.iter().filter(is_used).count();
    let mut ids: Vec<BlockId> = compiler.names.values().copied().collect();
    ids.sort_unstable();
    let (instantiated, ids): (Vec<BlockId>, Vec<BlockId>) =
        ids.into_iter().partition(|(file, index)| trees[*file].instantiated.contains(index));
    let listed = |id: &BlockId| (compiler.block(*id).kind, compiler.block(*id).name.text.clone(), id.0);
    let blocks = ids.iter().map(listed).collect();
    let instantiated = instantiated.into_iter().map(|id| (compiler.block(id).name.text.clone(), "function blocks"));
    let undeclared = compiler.undeclared.values().map(|of| (of.name.clone(), of.kind()));
    let missing = undeclared.chain(instantiated).collect();
    Survey { blocks, missing, tags }
}

/// The maximum number of inference rounds, which is the deepest nesting of structures that is resolved.
const MOST_ROUNDS: usize = 100;

/// The declarations assumed for undeclared names: for all of them, or for those in `only`. With these added as a source
/// (see [`assumed`]), the program compiles unless it has other errors.
pub fn assume(sources: &[Source], options: &Manifest, only: Option<&[String]>) -> Vec<Assumption> {
    let mut assumptions: Vec<Assumption> = Vec::new();
    for _ in 0..MOST_ROUNDS {
        let mut all = sources.to_vec();
        all.push(Source::new("assumed", assumed(&assumptions).into_bytes()));
        let mut report = Report::default();
        let Trees { sources: all, trees, cpu } = Trees::read(&all, options, &mut report);
        let mut compiler = Compiler::new(&all, &trees, cpu, options, report, 0);
        compiler.assumes = true;
        compiler.run();
        let mut missing = std::mem::take(&mut compiler.undeclared);
        if let Some(only) = only {
            missing.retain(|name, _| only.iter().any(|of| key(of) == *name));
        }
        let is_declared = |name: &str| compiler.names.contains_key(&key(name));
        let mut found = declare(&missing, &signatures(&trees), assumptions.len(), &is_declared);
        if found.is_empty() {
            found = compiler.unreadable(only);
        }
        if found.is_empty() && only.is_none() {
            found.extend(compiler.caller());
        }
        if found.is_empty() {
            break;
        }
        assumptions.extend(found);
    }
    assumptions
}

/// A source consisting of these declarations.
pub fn assumed(assumptions: &[Assumption]) -> String {
    assumptions.iter().map(|of| format!("// {}: {}\n{}\n", of.name, of.what, of.text)).collect()
}

impl<'a> Compiler<'a> {
    /// Creates a compiler. Of the copies of a block, it uses the one numbered `copy`; 0 is the first block.
    pub fn new(
        sources: &'a [Source],
        trees: &'a [Tree],
        cpu: Cpu,
        options: &'a Manifest,
        report: Report,
        copy: usize,
    ) -> Compiler<'a> {
        let mut program = Program::default();
        program.memory = program.add_record("memory", []);
        program.constants = program.add_record("constants", []);
        let mut compiler = Compiler {
            sources,
            trees,
            cpu,
            options,
            report,
            program,
            names: HashMap::new(),
            copies: Vec::new(),
            library: HashMap::new(),
            types: HashMap::new(),
            dtl: None,
            blocks: Vec::new(),
            block_of: HashMap::new(),
            natives: HashMap::new(),
            globals: HashMap::new(),
            kinds: HashMap::new(),
            // The first declaration of a name wins.
            declared: options.declared.iter().rev().map(|tag| (key(&tag.name), tag)).collect(),
            by_address: OnceCell::new(),
            global_members: HashMap::new(),
            stubs: options.stubs.iter().map(|name| key(name)).collect(),
            assumes: false,
            undeclared: BTreeMap::new(),
            calls: Vec::new(),
            watched: HashSet::new(),
            notes: Vec::new(),
            bytes: 0,
        };
        compiler.collect(copy);
        compiler
    }

    fn collect(&mut self, copy: usize) {
        for (file, tree) in self.trees.iter().enumerate() {
            for (index, block) in tree.blocks.iter().enumerate() {
                if tree.instantiated.contains(&index) {
                    continue;
                }
                let is_library = file == self.library_file();
                let names = if is_library { &mut self.library } else { &mut self.names };
                let earlier = names.get(&block.name.key()).copied();
                let Some(earlier) = earlier else {
                    names.insert(block.name.key(), (file, index));
                    continue;
                };
                if !is_library && self.is_replaced(earlier, (file, index)) {
                    continue;
                }
                if !is_library {
                    self.add_copy(earlier, (file, index), copy);
                }
            }
        }
        for (file, tree) in self.trees.iter().enumerate() {
            for index in &tree.instantiated {
                self.names.entry(tree.blocks[*index].name.key()).or_insert((file, *index));
            }
        }
        self.refuse_protected();
        self.collect_globals();
        self.collect_kinds();
    }

    /// If exactly one of two blocks is a stub, replaces the other with it and discards the other's errors. Returns
    /// whether it did.
    fn is_replaced(&mut self, earlier: BlockId, id: BlockId) -> bool {
        let is_stub = |id: BlockId| self.block(id).is_stub();
        let (stub, (file, index)) = match (is_stub(earlier), is_stub(id)) {
            (false, true) => (id, earlier),
            (true, false) => (earlier, id),
            _ => return false,
        };
        let name = &self.block((file, index)).name;
        self.names.insert(name.key(), stub);
        self.report.forget(self.trees[file].extents[index]);
        let message = format!("{} does not run: the stub in {} replaces it", name.text, self.sources[stub.0].file);
        self.warn(name.span, message, Some("delete the stub if the block can be read"));
        true
    }

    /// Reports blocks that have only an interface, unless they are to be stubs.
    fn refuse_protected(&mut self) {
        let trees = self.trees;
        for (file, tree) in trees.iter().enumerate() {
            for (number, span) in &tree.protected {
                let name = &self.block((file, *number)).name;
                let is_it = self.names.get(&name.key()) == Some(&(file, *number));
                if is_it && !self.stubs.contains(&name.key()) {
                    let message = match tree.instantiated.contains(number) {
                        true => format!(
                            "no source declares the function block \"{}\": only an instance reveals its interface",
                            name.text
                        ),
                        false => format!("{}: protected block without source code", name.text),
                    };
                    self.report.error_with(*span, message, Some(Remedy::Stub(name.text.clone())));
                }
            }
        }
    }

    fn collect_globals(&mut self) {
        let all = self
            .trees
            .iter()
            .enumerate()
            .flat_map(|(file, tree)| tree.globals.iter().map(move |section| (file, section)));
        for (file, section, member) in
            all.flat_map(|(file, section)| section.members.iter().map(move |of| (file, section, of)))
        {
            for name in &member.names {
                let is_free = !self.names.contains_key(&name.key())
                    && self.global_members.insert(name.key(), (file, section, member)).is_none();
                if !is_free {
                    let help = "rename one of them, or leave one file out";
                    self.error(name.span, format!("{} is declared twice", name.text), Some(help));
                }
            }
        }
    }

    pub fn run(&mut self) {
        let all = (0..self.library_file())
            .flat_map(|file| (0..self.trees[file].blocks.len()).map(move |index| (file, index)));
        let is_chosen = |id: &BlockId| self.names.get(&self.block(*id).name.key()) == Some(id);
        let own: Vec<BlockId> = all.filter(is_chosen).collect();
        for id in &own {
            match self.block(*id).kind {
                BlockKind::Type => drop(self.structure(*id)),
                BlockKind::DataBlock => {}
                _ => drop(self.interface(*id, self.block(*id).name.span)),
            }
        }
        for id in &own {
            if self.block(*id).kind == BlockKind::DataBlock {
                let name = self.block(*id).name.clone();
                self.global(&name.key());
            }
        }
        // Lowering a block may declare library blocks.
        let mut next = 0;
        while next < self.blocks.len() {
            self.translate(next);
            next += 1;
        }
        self.refuse_recursion();
    }

    fn refuse_recursion(&mut self) {
        let mut refused: Vec<(Span, String)> = Vec::new();
        for start in 0..self.blocks.len() {
            // The direct and indirect callees of the block, each with the first caller found.
            let mut from: HashMap<usize, Option<usize>> = HashMap::new();
            let mut open: Vec<usize> = vec![start];
            while let Some(caller) = open.pop() {
                for (at, callee, span) in self.calls.iter().filter(|(at, ..)| *at == caller) {
                    if *callee == start {
                        let name = &self.blocks[start].name;
                        let through =
                            if *at == start { String::new() } else { format!(" through {}", self.blocks[*at].name) };
                        refused.push((*span, format!("{name} calls itself{through}")));
                    } else if !from.contains_key(callee) {
                        from.insert(*callee, Some(*at));
                        open.push(*callee);
                    }
                }
            }
        }
        for (span, message) in refused {
            self.error(span, message, Some("use a loop"));
        }
    }
}
