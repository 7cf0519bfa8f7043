//! Sources to a typed program.

use crate::declare::{Global, Interface};
use crate::lexer::Span;
use crate::parser;
use crate::program::{At, Program};
use crate::report::Report;
use crate::root::Root;
use crate::syntax::{Block, BlockKind, Expressions, Tree};
use crate::types::Type;
use crate::undeclared::Undeclared;
use parameters::{Problems, Source};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// The CPU whose rules hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cpu {
    /// S7-300 and S7-400.
    S7300,
    /// S7-1200.
    S71200,
    /// S7-1500.
    S71500,
}

/// How a program is translated.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The CPU; `None` takes it from the dialect of the sources.
    pub cpu: Option<Cpu>,
    /// The function block that becomes the program, or the data block with its instance. `None` takes the one that no other
    /// block uses.
    pub block: Option<String>,
    /// Names that no source declares, and their types: PLC tags and instances.
    pub declared: Vec<(String, String)>,
    /// Constants that no source declares, and their values as literals.
    pub constants: Vec<(String, String)>,
    /// What is called in a cycle in place of one function block: organization blocks, functions, instances.
    pub calls: Vec<Task>,
}

/// Something that is called at times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// The name of the organization block, of the function, of the function block, or of the data block with its instance.
    pub name: String,
    /// The time between two calls in ms; 0 for every cycle.
    pub period: u32,
}

/// A translated program.
#[derive(Debug)]
pub struct Compiled {
    /// The program.
    pub program: Program,
    /// The CPU whose rules hold.
    pub cpu: Cpu,
    /// The function of a cycle, and the path of its instance in the memory; `None` if the sources have no block to be run.
    pub root: Option<Root>,
    /// What could be run instead: the organization blocks, and the function blocks that no other block calls.
    pub candidates: Vec<String>,
    /// The variables that all blocks see: tags and the members of data blocks, by their paths in the memory.
    pub globals: Vec<crate::interface::Variable>,
    /// What the author should know.
    pub warnings: Vec<Problems>,
}

/// Translates sources to a program.
///
/// # Errors
/// All errors of all sources, by source.
pub fn compile(sources: &[Source], options: &Options) -> Result<Compiled, Vec<Problems>> {
    let mut report = Report::default();
    let mut trees: Vec<Tree> = Vec::new();
    for (file, source) in sources.iter().enumerate() {
        trees.push(parser::parse(&source.text, file as u32, &mut report));
    }
    let is_tia = trees.iter().any(|tree| tree.is_tia);
    let cpu = options.cpu.unwrap_or(if is_tia { Cpu::S71500 } else { Cpu::S7300 });
    let library = crate::library::source();
    trees.push(parser::parse(&library.text, sources.len() as u32, &mut report));
    let mut all: Vec<Source> = sources.to_vec();
    all.push(library);
    let mut compiler = Compiler::new(&all, &trees, cpu, options, report);
    compiler.run();
    let (root, candidates) = (compiler.root(), compiler.candidates());
    let mut globals = crate::interface::globals(&compiler);
    if let Some(root) = root.as_ref().filter(|root| !root.instance.is_empty()) {
        let is_own = |name: &str| {
            name.split(['.', '['])
                .next()
                .is_some_and(|first| crate::syntax::key(first) == crate::syntax::key(&root.instance))
        };
        globals.retain(|variable| !is_own(&variable.name));
    }
    compiler.tell_undeclared();
    let Compiler { report, mut program, .. } = compiler;
    program.files = all.iter().map(|source| source.file.clone()).collect();
    let has_errors = report.has_errors();
    let (errors, warnings) = report.problems(&all);
    if has_errors { Err(errors) } else { Ok(Compiled { program, cpu, root, candidates, globals, warnings }) }
}

/// A block of a source: the source, and its number there.
pub type BlockId = (usize, usize);

/// What is known of something that may depend on itself.
#[derive(Clone, Debug)]
pub enum State<T> {
    /// It is being declared.
    Open,
    /// It is declared.
    Known(T),
}

impl<T> State<T> {
    /// What is known.
    pub fn known(&self) -> Option<&T> {
        match self {
            State::Open => None,
            State::Known(known) => Some(known),
        }
    }
}

/// The state of a translation.
pub struct Compiler<'a> {
    pub sources: &'a [Source],
    pub trees: &'a [Tree],
    pub cpu: Cpu,
    pub options: &'a Options,
    pub report: Report,
    pub program: Program,
    /// The blocks of the sources, by name.
    pub names: HashMap<String, BlockId>,
    /// The blocks of the library, by name.
    pub library: HashMap<String, BlockId>,
    pub types: HashMap<BlockId, State<Type>>,
    pub blocks: Vec<Interface>,
    pub block_of: HashMap<BlockId, State<usize>>,
    pub natives: HashMap<String, usize>,
    pub globals: HashMap<String, State<Global>>,
    /// Which kind of timer or counter a variable of a general type is, by the last name of its path.
    pub kinds: HashMap<String, String>,
    pub undeclared: BTreeMap<String, Undeclared>,
    /// Who calls whom, and where.
    pub calls: Vec<(usize, usize, Span)>,
    /// Bytes of all records, against types that no memory holds.
    pub bytes: usize,
}

impl<'a> Compiler<'a> {
    fn new(sources: &'a [Source], trees: &'a [Tree], cpu: Cpu, options: &'a Options, report: Report) -> Compiler<'a> {
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
            library: HashMap::new(),
            types: HashMap::new(),
            blocks: Vec::new(),
            block_of: HashMap::new(),
            natives: HashMap::new(),
            globals: HashMap::new(),
            kinds: HashMap::new(),
            undeclared: BTreeMap::new(),
            calls: Vec::new(),
            bytes: 0,
        };
        compiler.collect();
        compiler
    }

    /// The number of the library among the sources.
    pub fn library_file(&self) -> usize {
        self.trees.len() - 1
    }

    /// A block of a source.
    pub fn block(&self, (file, index): BlockId) -> &'a Block {
        &self.trees[file].blocks[index]
    }

    /// The expressions of a source.
    pub fn expressions(&self, file: usize) -> &'a Expressions {
        &self.trees[file].expressions
    }

    /// The line of a span.
    pub fn at(&self, span: Span) -> At {
        let line = self.sources[span.file as usize].place(span.range()).line;
        At { file: span.file as u16, line: line as u32 }
    }

    /// The text of a span.
    pub fn text(&self, span: Span) -> &'a str {
        &self.sources[span.file as usize].text[span.range()]
    }

    /// A warning; the library gets none.
    pub fn warn(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        if span.file as usize != self.library_file() {
            self.report.warning(span, message, help);
        }
    }

    /// An error.
    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.report.error(span, message, help);
    }

    fn collect(&mut self) {
        for (file, tree) in self.trees.iter().enumerate() {
            for (index, block) in tree.blocks.iter().enumerate() {
                let is_library = file == self.library_file();
                let names = if is_library { &mut self.library } else { &mut self.names };
                let earlier = names.get(&block.name.key()).copied();
                let Some(earlier) = earlier else {
                    names.insert(block.name.key(), (file, index));
                    continue;
                };
                let place = self.at(self.block(earlier).name.span);
                let name = &block.name.text;
                let message =
                    format!("{name} is declared twice: first in {}:{}", self.sources[earlier.0].file, place.line);
                self.error(block.name.span, message, Some("rename one of them, or leave one file out"));
            }
        }
        self.collect_kinds();
    }

    fn run(&mut self) {
        let own: Vec<BlockId> = (0..self.library_file())
            .flat_map(|file| (0..self.trees[file].blocks.len()).map(move |index| (file, index)))
            .collect();
        for id in &own {
            match self.block(*id).kind {
                BlockKind::Type => drop(self.structure(*id)),
                BlockKind::DataBlock => {}
                _ => drop(self.interface(*id)),
            }
        }
        for id in &own {
            if self.block(*id).kind == BlockKind::DataBlock {
                let name = self.block(*id).name.clone();
                self.global(&name.key());
            }
        }
        // Translating a block may declare blocks of the library.
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
            // What is reached from the block, and from where first.
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

/// Shared by all blocks without symbols.
pub fn nothing<K, V>() -> Rc<HashMap<K, V>> {
    Rc::new(HashMap::new())
}
