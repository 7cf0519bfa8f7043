//! Sources to a typed program.

use crate::declare::{Global, Interface};
use crate::lexer::Span;
use crate::parser;
use crate::program::{At, Body, Function, Program};
use crate::report::Report;
use crate::syntax::{Block, BlockKind, Expressions, Tree, key};
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
    /// The variables that all blocks see: tags and the members of data blocks, by their paths in the memory.
    pub globals: Vec<crate::interface::Variable>,
    /// What the author should know.
    pub warnings: Vec<Problems>,
}

/// What is run.
#[derive(Clone, Debug)]
pub struct Root {
    /// The function of a cycle.
    pub cycle: usize,
    /// The name of the block.
    pub block: String,
    /// Its instance: a member of the memory.
    pub instance: String,
    /// Its variables, by their paths in the instance.
    pub variables: Vec<crate::interface::Variable>,
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
    let globals = crate::interface::globals(&compiler);
    let root = compiler.root();
    compiler.tell_undeclared();
    let Compiler { report, mut program, .. } = compiler;
    program.files = all.iter().map(|source| source.file.clone()).collect();
    let has_errors = report.has_errors();
    let (errors, warnings) = report.problems(&all);
    if has_errors { Err(errors) } else { Ok(Compiled { program, cpu, root, globals, warnings }) }
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
                self.error(block.name.span, message, Some("rename one of them, or leave one file away"));
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

    /// The block that is run.
    fn root(&mut self) -> Option<Root> {
        if self.report.has_errors() {
            return None;
        }
        let (name, of) = self.root_instance()?;
        let instance = if self.globals.contains_key(&key(&name)) {
            name.clone()
        } else {
            self.add_global(&name, Type::Instance(of));
            name.clone()
        };
        let Some(State::Known(global)) = self.globals.get(&key(&instance)) else { return None };
        let place = global.place();
        let function = self.blocks[of].function;
        let call = crate::program::Call { function, instance: Some(place), arguments: Vec::new(), outputs: Vec::new() };
        let statement = crate::program::Statement { at: At::default(), what: crate::program::What::Call(call) };
        self.program.functions.push(Function {
            name: "cycle".to_string(),
            instance: None,
            locals: Vec::new(),
            parameters: 0,
            body: Body::Code(vec![statement]),
        });
        let variables = crate::interface::variables(self, of);
        let block = self.blocks[of].name.clone();
        Some(Root { cycle: self.program.functions.len() - 1, block, instance, variables })
    }

    /// The name of the instance that is run, and its block.
    fn root_instance(&mut self) -> Option<(String, usize)> {
        let is_candidate = |interface: &Interface| {
            interface.kind == BlockKind::FunctionBlock
                && interface.source.is_some_and(|(file, _)| file != self.library_file())
        };
        let candidates: Vec<usize> =
            (0..self.blocks.len()).filter(|block| is_candidate(&self.blocks[*block])).collect();
        let start = Span::default();
        if let Some(wanted) = &self.options.block {
            if let Some(State::Known(Global { of: Type::Instance(of), .. })) = self.globals.get(&key(wanted)) {
                return Some((wanted.clone(), *of));
            }
            let found = candidates.iter().find(|block| key(&self.blocks[**block].name) == key(wanted));
            if found.is_none() {
                let names: Vec<&str> = candidates.iter().map(|block| self.blocks[*block].name.as_str()).collect();
                let message = format!("there is no function block {wanted}; there are {}", names.join(", "));
                self.error(start, message, None);
            }
            return found.map(|block| (self.blocks[*block].name.clone(), *block));
        }
        let is_used =
            |block: &&usize| self.calls.iter().any(|(caller, callee, _)| callee == *block && caller != *block);
        let unused: Vec<usize> = candidates.iter().filter(|block| !is_used(block)).copied().collect();
        match unused.as_slice() {
            [block] => Some((self.blocks[*block].name.clone(), *block)),
            _ => None,
        }
    }
}

/// Shared by all blocks without symbols.
pub fn nothing<K, V>() -> Rc<HashMap<K, V>> {
    Rc::new(HashMap::new())
}
