//! Selects the blocks called in a cycle: one function block, or organization blocks and other named blocks.

use super::interface::{Shown, Variable};
use crate::check::compiler::{Compiler, Global, Interface, Parameter, Slot, State};
use crate::check::types::{Elementary, Type};
use crate::front::lexer::Span;
use crate::front::syntax::{BlockKind, EVENT, attribute, key};
use crate::ir::{Argument, At, Binary, Body, Call, Expr, Function, Place, Scalar, Statement, Value, What};
use manifest::Task;

/// The names of the organization blocks called once before the first cycle.
const STARTUP: [&str; 2] = ["OB100", "STARTUP"];

/// The names of the organization block with the lowest priority: others due in the same cycle run before it.
const MAIN: [&str; 2] = ["OB1", "MAIN"];

/// The kinds of organization blocks called cyclically, by their names in SimaticML.
const CYCLIC: [&str; 3] = [PROGRAM_CYCLE, "CyclicInterrupt", "SynchronousCycle"];

const PROGRAM_CYCLE: &str = "ProgramCycle";

/// Event-driven organization blocks: the names that TIA Portal gives them, or prefixes of these names.
const EVENTS: [&str; 12] = [
    "TIME OF DAY",
    "TIME DELAY",
    "HARDWARE INTERRUPT",
    "STATUS",
    "UPDATE",
    "PROFILE",
    "TIME ERROR",
    "DIAGNOSTIC ERROR",
    "PULL OR PLUG",
    "RACK OR STATION",
    "PROGRAMMING ERROR",
    "IO ACCESS ERROR",
];

/// The entry points of a program.
#[derive(Clone, Debug)]
pub struct Root {
    /// The index of the function called in each cycle.
    pub cycle: usize,
    /// The index of the function called once before the first cycle, if any.
    pub startup: Option<usize>,
    /// The name of the block, or of the first of several.
    pub block: String,
    /// The member of memory that holds its instance; empty unless a single instance is run.
    pub instance: String,
    /// The variables of the instance, with names relative to it.
    pub variables: Vec<Variable>,
}

/// A callable that a name denotes.
#[derive(Clone)]
enum Target {
    /// The name of an instance, and the index of its block.
    Instance(String, usize),
    /// The index of a function or an organization block.
    Function(usize),
}

/// The arguments of a call, and the outputs copied after it.
type Passed = (Vec<Argument>, Vec<(usize, Place)>);

impl Compiler<'_> {
    /// Selects the entry points; `None` on errors, if no block can be run, or if several can and none has been chosen.
    pub fn root(&mut self) -> Option<Root> {
        if self.report.has_errors() {
            return None;
        }
        let targets: Vec<(Target, u32)> = match (&self.options.block, self.options.calls.as_slice()) {
            (Some(_), [_, ..]) => {
                self.error(Span::default(), "both a block and calls are specified: specify only one of them", None);
                return None;
            }
            (Some(name), []) => vec![(self.target(&name.clone(), "function block")?, 0)],
            (None, []) => self.targets()?.into_iter().map(|target| (target, 0)).collect(),
            (None, calls) => {
                let (main, first): (Vec<&Task>, Vec<&Task>) =
                    calls.iter().partition(|call| MAIN.contains(&key(&call.name).as_str()));
                let target = |call: &Task| Some((self.target(&call.name, "block")?, call.period));
                first.into_iter().chain(main).map(target).collect::<Option<_>>()?
            }
        };
        let startup = self.organization_blocks().find(|block| self.is_startup(*block));
        let system = self.system_tags();
        let written = |is_startup| system.iter().filter_map(|tag| tag.write(is_startup)).collect();
        let startup = startup.and_then(|block| self.called(written(true), &[(Target::Function(block), 0)], "startup"));
        let cycle = self.called(written(false), &targets, "cycle")?;
        let (instance, variables) = match targets.as_slice() {
            [(Target::Instance(name, of), _)] => {
                let offset = self
                    .globals
                    .get(&key(name))
                    .and_then(State::known)
                    .map_or(0, |global| self.program.records[self.program.memory].members[global.member].offset);
                let shown = crate::compile::interface::variables(self, *of, offset);
                (name.clone(), self.told(shown, self.name_of(*of))?)
            }
            _ => (String::new(), Vec::new()),
        };
        // The first of the calls that the user has specified names the program; by default, the last one, Main, does.
        let named = if self.options.calls.is_empty() { targets.last() } else { targets.first() };
        let (Target::Instance(_, of) | Target::Function(of), _) = named?;
        let block = self.blocks[*of].name.clone();
        Some(Root { cycle, startup, block, instance, variables })
    }

    /// Returns the variables to expose; reports notes and errors at `span`.
    pub fn told(&mut self, shown: Result<Shown, String>, span: Span) -> Option<Vec<Variable>> {
        match shown {
            Ok(shown) => {
                shown.notes.into_iter().for_each(|(note, help)| self.warn(span, note, Some(help)));
                Some(shown.variables)
            }
            Err(message) => {
                let help = "keep large arrays in the block or in a data block, and pass only the parts that are used";
                self.error(span, message, Some(help));
                None
            }
        }
    }

    /// The names of the blocks that could be run, for the user to choose from.
    pub fn candidates(&self) -> Vec<String> {
        let cyclic = self.organization_blocks().filter(|block| !self.is_startup(*block));
        cyclic.chain(self.unused()).map(|block| self.blocks[block].name.clone()).collect()
    }

    /// Adds a function without parameters that runs `code` and then calls the targets in order.
    fn called(&mut self, mut code: Vec<Statement>, targets: &[(Target, u32)], name: &str) -> Option<usize> {
        for (target, period) in targets {
            let call = match target {
                Target::Instance(name, of) => {
                    let place = match self.globals.get(&key(name)) {
                        Some(State::Known(global)) => global.place(),
                        _ => self.add_global(name, Type::Instance(*of)).place(),
                    };
                    let function = self.blocks[*of].function;
                    let (arguments, outputs) = self.in_outs(name, *of)?;
                    Call { function, instance: Some(place), arguments, outputs }
                }
                Target::Function(of) => self.call_without_parameters(*of)?,
            };
            let call = Statement { at: At::default(), what: What::Call(call) };
            code.push(match period {
                0 => call,
                period => {
                    let period = Expr::Const(Value::from(i64::from(*period) * 1_000_000));
                    let rest = is(Binary::Rem, Expr::Now, period);
                    let is_due = is(Binary::Eq, rest, Expr::Const(0i64.into()));
                    Statement { at: At::default(), what: What::If(is_due, vec![call], Vec::new()) }
                }
            });
        }
        self.program.functions.push(Function {
            name: name.to_string(),
            instance: None,
            locals: Vec::new(),
            parameters: 0,
            body: Body::Code(code),
        });
        Some(self.program.functions.len() - 1)
    }

    /// The location of a block's name in its declaration.
    fn name_of(&self, block: usize) -> Span {
        self.blocks[block].source.map_or(Span::default(), |id| self.block(id).name.span)
    }

    /// Creates global variables to pass as the structured in-out parameters of an instance that no other block calls.
    fn in_outs(&mut self, instance: &str, of: usize) -> Option<Passed> {
        let (mut arguments, mut outputs) = (Vec::new(), Vec::new());
        let function = self.blocks[of].function;
        for number in 0..self.program.functions[function].parameters {
            let is_it = |member: &&Parameter| member.slot == Slot::Local(number);
            let Parameter { name, of: ty, .. } = self.blocks[of].members.iter().find(is_it)?.clone();
            if let Type::Open(..) = ty {
                let span = self.name_of(of);
                let message = format!(
                    "the bounds of the parameter {name} come from the caller: this block cannot run on its own"
                );
                self.warn(span, message, Some("call it from another block"));
                return None;
            }
            let is_free = !self.globals.contains_key(&key(&name)) && !self.names.contains_key(&key(&name));
            let parameter = Some(name.clone());
            let name = if is_free { name } else { format!("{instance}_{name}") };
            let place = match self.globals.get(&key(&name)) {
                Some(State::Known(global)) if global.of == ty => global.place(),
                _ => {
                    let global = Global { parameter, ..self.add_global(&name, ty) };
                    self.globals.insert(key(&name), State::Known(global.clone()));
                    global.place()
                }
            };
            if self.program.functions[function].locals[number].by_reference {
                arguments.push(Argument::Reference(place));
            } else {
                arguments.push(Argument::Copy(place.clone()));
                outputs.push((number, place));
            }
        }
        Some((arguments, outputs))
    }

    /// The call to an organization block, whose parameters the system supplies, or to a function without parameters.
    fn call_without_parameters(&mut self, of: usize) -> Option<Call> {
        let Interface { kind, function, name, .. } = &self.blocks[of];
        let (kind, function, name) = (*kind, *function, name.clone());
        let called = &self.program.functions[function];
        let first = |local: &crate::ir::Local| match local.name.to_ascii_uppercase().as_str() {
            // TRUE in the first call only.
            "INITIAL_CALL" if local.ty == crate::ir::Type::Scalar(Elementary::Bool.scalar()) => {
                Argument::Value(is(Binary::Eq, Expr::Now, Expr::Const(0i64.into())))
            }
            _ => Argument::Start,
        };
        let arguments: Vec<Argument> = called.locals[..called.parameters].iter().map(first).collect();
        if kind != BlockKind::OrganizationBlock && !arguments.is_empty() {
            let message = format!("{name} cannot be called on its own: it has parameters");
            let help = "call it from an organization block or a function block, and specify that block instead";
            self.error(Span::default(), message, Some(help));
            return None;
        }
        Some(Call { function, instance: None, arguments, outputs: Vec::new() })
    }

    /// The callable that a name denotes.
    fn target(&mut self, name: &str, what: &str) -> Option<Target> {
        if let Some(State::Known(Global { of: Type::Instance(of), .. })) = self.globals.get(&key(name)) {
            return Some(Target::Instance(name.to_string(), *of));
        }
        let is_own = |interface: &&Interface| interface.source.is_some_and(|(file, _)| file != self.library_file());
        let found = (0..self.blocks.len())
            .find(|block| Some(&self.blocks[*block]).filter(is_own).is_some_and(|of| key(&of.name) == key(name)));
        match found.map(|block| (block, self.blocks[block].kind)) {
            // A function block gets a new instance with its start values; data blocks are found above.
            Some((block, BlockKind::FunctionBlock)) => Some(Target::Instance(self.blocks[block].name.clone(), block)),
            Some((block, BlockKind::OrganizationBlock | BlockKind::Function)) if what == "block" => {
                Some(Target::Function(block))
            }
            _ => {
                let names = self.blocks.iter().filter(is_own).filter(|of| {
                    of.kind == BlockKind::FunctionBlock || what == "block" && of.kind == BlockKind::OrganizationBlock
                });
                let names: Vec<&str> = names.map(|of| of.name.as_str()).collect();
                let message = match names.is_empty() {
                    true => format!("no {what} named {name}: the sources declare none"),
                    false => format!("no {what} named {name}; available: {}", names.join(", ")),
                };
                self.error(Span::default(), message, None);
                None
            }
        }
    }

    /// The default entry points: the only cyclic organization block, or all cyclic ones with Main last. If there is
    /// none, the only event-driven one; without organization blocks, the only function block that no other block calls.
    fn targets(&mut self) -> Option<Vec<Target>> {
        let all: Vec<usize> = self.organization_blocks().filter(|block| !self.is_startup(*block)).collect();
        let (mut cyclic, events): (Vec<usize>, Vec<usize>) =
            all.iter().copied().partition(|block| !self.is_event(*block));
        if cyclic.is_empty() {
            let unused: Vec<usize> = self.unused().collect();
            return match (all.as_slice(), unused.as_slice()) {
                ([block], _) => Some(vec![Target::Function(*block)]),
                ([], [block]) => Some(vec![self.instance_of(*block)]),
                _ => None,
            };
        }
        let is_main = |block: &usize| MAIN.contains(&key(&self.blocks[*block].name).as_str());
        let main = cyclic.iter().copied().find(is_main);
        if cyclic.len() > 1 {
            let main = main?;
            cyclic.retain(|block| *block != main);
            // On a CPU, too, blocks of the program cycle event are called as often as Main.
            let others = cyclic.iter().copied().filter(|block| self.event(*block) != Some(PROGRAM_CYCLE));
            for block in others.collect::<Vec<_>>() {
                let message = format!(
                    "{} is called as often as {}: the sources do not specify its period",
                    self.blocks[block].name, self.blocks[main].name
                );
                self.warn(self.name_of(block), message, Some("specify both blocks as calls, each with its cycle"));
            }
            cyclic.push(main);
        }
        for block in events {
            let message = format!("{} is not called: its event never occurs here", self.blocks[block].name);
            self.warn(self.name_of(block), message, Some("if it is needed, specify it as one of the calls"));
        }
        Some(cyclic.into_iter().map(Target::Function).collect())
    }

    /// Whether an organization block is event-driven, according to its export or its name.
    fn is_event(&self, block: usize) -> bool {
        let Interface { name, .. } = &self.blocks[block];
        match self.event(block) {
            Some(kind) => !CYCLIC.contains(&kind),
            None => {
                let name = key(name);
                let number = name.strip_prefix("OB").and_then(|number| number.parse::<u32>().ok());
                // OB 30 to 38 are cyclic interrupts, OB 61 to 64 synchronous cycle interrupts.
                let is_number = |number| matches!(number, 10..=29 | 40..=60 | 65..=99 | 121 | 122);
                number.is_some_and(is_number) || EVENTS.iter().any(|event| name.starts_with(event))
            }
        }
    }

    /// The instance of a block: its only data block in the sources, with that block's start values, or a new instance.
    fn instance_of(&self, block: usize) -> Target {
        let name = self.only_instance(block).unwrap_or_else(|| self.blocks[block].name.clone());
        Target::Instance(name, block)
    }

    /// The name of a function block's instance among the data blocks; `None` if there is none or more than one.
    pub fn only_instance(&self, block: usize) -> Option<String> {
        let mut all = self.globals.values().filter_map(State::known).filter(|of| of.of == Type::Instance(block));
        let only = all.next().filter(|_| all.next().is_none())?;
        Some(self.program.records[self.program.memory].members[only.member].name.clone())
    }

    pub fn is_startup(&self, block: usize) -> bool {
        self.event(block) == Some("Startup") || STARTUP.contains(&key(&self.blocks[block].name).as_str())
    }

    /// The event that calls an organization block, if its export states it.
    fn event(&self, block: usize) -> Option<&str> {
        attribute(&self.block(self.blocks[block].source?).attributes, EVENT)
    }

    pub fn organization_blocks(&self) -> impl Iterator<Item = usize> {
        (0..self.blocks.len()).filter(|block| self.blocks[*block].kind == BlockKind::OrganizationBlock)
    }

    /// The function blocks of the sources that no other block calls.
    pub fn unused(&self) -> impl Iterator<Item = usize> {
        self.uncalled(BlockKind::FunctionBlock)
    }

    /// The blocks of a kind in the sources that no other block calls.
    pub fn uncalled(&self, kind: BlockKind) -> impl Iterator<Item = usize> {
        let is_own = |of: &Interface| of.source.is_some_and(|(file, _)| file != self.library_file());
        let is_called =
            |block: usize| self.calls.iter().any(|(caller, callee, _)| *callee == block && *caller != block);
        let blocks = self.blocks.iter().enumerate();
        blocks
            .filter(move |(block, of)| of.kind == kind && !of.is_stub && is_own(of) && !is_called(*block))
            .map(|(block, _)| block)
    }
}

fn is(operation: Binary, left: Expr, right: Expr) -> Expr {
    Expr::Binary(operation, Scalar::I64, Box::new(left), Box::new(right), At::default())
}
