//! Compiles a typed program to instructions.

mod expr;
mod place;
mod statement;

use super::code::{Code, Native, Op, Part, Register, Target, ZERO};
use crate::ir::walk::{self, Look};
use crate::ir::{At, Body, Function, Program, Scalar, Statement, Type, align};
use blocks::{Block, EachBlock, for_each_block};
use std::collections::BTreeSet;

/// The maximum memory size of a program, in bytes.
const LARGEST_MEMORY: usize = 64 << 20;

/// The maximum depth of nested calls.
const DEEPEST: usize = 256;

impl Code {
    /// Compiles a program.
    ///
    /// # Errors
    /// The program is too large or inconsistent, or a function calls itself.
    pub fn compile(program: &Program) -> Result<Code, String> {
        let memory = program.records.get(program.memory).ok_or("the program has no memory")?;
        let constants = program.records.get(program.constants).ok_or("the program has no constants")?;
        let mut code = Code { files: program.files.clone(), state: memory.start.len(), ..Code::default() };
        code.start.clone_from(&memory.start);
        code.start.resize(align(code.state, 8), 0);
        let constants_at = code.start.len();
        code.start.extend(&constants.start);
        code.start.resize(align(code.start.len(), 8), 0);
        let frames = code.start.len();
        let count = program.functions.len();
        code.entries = vec![Target::MAX; count];
        code.callable = program.functions.iter().map(|it| it.parameters == 0 && it.instance.is_none()).collect();
        let mut compiler = Compiler {
            program,
            code,
            constants: constants_at,
            spaces: vec![Space { registers: usize::from(ZERO) + 1, memory: frames, depth: 0 }; count],
            homes: vec![(ZERO, Vec::new()); count],
            begun: vec![false; count],
            natives: Vec::new(),
        };
        for function in 0..count {
            compiler.function(function, 0)?;
        }
        let Compiler { mut code, spaces, natives, homes, .. } = compiler;
        let register = |home: &Home| match home {
            Home::Register(register) => Some(*register),
            Home::Reference(_) | Home::Memory(_) => None,
        };
        code.locals = homes.iter().map(|(_, homes)| homes.iter().map(register).collect()).collect();
        let instance = |(of, function): (&(Register, _), &Function)| function.instance.map(|_| of.0);
        code.instances = homes.iter().zip(&program.functions).map(instance).collect();
        let ends = |end: fn(&Space) -> usize, least| spaces.iter().map(end).max().unwrap_or(0).max(least);
        code.registers = ends(|space| space.registers, 1);
        code.depth = ends(|space| space.depth, 0);
        code.start.resize(ends(|space| space.memory, frames), 0);
        code.natives = natives.into_iter().map(|(_, law, size)| (law, size)).collect();
        if code.start.len() > LARGEST_MEMORY {
            return Err(format!(
                "the program needs {} MB of memory; the limit is {} MB",
                code.start.len() >> 20,
                LARGEST_MEMORY >> 20
            ));
        }
        Ok(code)
    }
}

/// What a function and its callees use: the registers and bytes below these numbers, and the depth of nested calls.
#[derive(Clone, Copy)]
struct Space {
    registers: usize,
    memory: usize,
    depth: usize,
}

struct Compiler<'a> {
    program: &'a Program,
    code: Code,
    /// The address of the constants in memory.
    constants: usize,
    /// The space used by each compiled function.
    spaces: Vec<Space>,
    /// For each compiled function, the register with its instance address and the homes of its locals.
    homes: Vec<(Register, Vec<Home>)>,
    begun: Vec<bool>,
    natives: Vec<(&'static str, Native, usize)>,
}

/// Where a local is stored.
#[derive(Clone, Debug)]
enum Home {
    /// A number: its register.
    Register(Register),
    /// A parameter passed by reference: the register with its address. For a [`Type::Open`], the bounds follow in the
    /// next registers.
    Reference(Register),
    /// Any other variable: its address in memory.
    Memory(usize),
}

/// State of the function being compiled.
struct Scope<'a> {
    function: &'a Function,
    /// The register with the instance address.
    instance: Register,
    homes: Vec<Home>,
    /// The next free register.
    next: usize,
    /// The highest value that `next` has had.
    most: usize,
    /// The instruction at each label, `None` until it is placed: labels of the program, then those of the compiler.
    labels: Vec<Option<Target>>,
    /// The labels to which `Break` and `Continue` jump, for each enclosing loop.
    loops: Vec<(usize, usize)>,
    /// The source line being compiled.
    at: At,
    /// The current run of statements, and the index of its [`Op::Mark`].
    run: Option<(u32, usize)>,
}

impl<'a> Compiler<'a> {
    /// Compiles the callees of a function, then the function itself, unless it has already been compiled.
    fn function(&mut self, number: usize, depth: usize) -> Result<(), String> {
        if self.code.entries[number] != Target::MAX {
            return Ok(());
        }
        let program = self.program;
        let function = &program.functions[number];
        if self.begun[number] {
            return Err(format!("{} calls itself", function.name));
        }
        if depth > DEEPEST {
            return Err(format!(
                "the calls that lead to {} are nested more than {DEEPEST} deep; reduce the nesting",
                function.name
            ));
        }
        self.begun[number] = true;
        let Body::Code(body) = &function.body else {
            // A native block has no code.
            self.code.entries[number] = 0;
            self.code.callable[number] = false;
            return Ok(());
        };
        let mut space = self.spaces[number];
        for callee in callees(body) {
            if callee >= program.functions.len() {
                return Err(format!("{} calls a function that does not exist", function.name));
            }
            self.function(callee, depth + 1)?;
            let below = self.spaces[callee];
            space.registers = space.registers.max(below.registers);
            space.memory = space.memory.max(below.memory);
            space.depth = space.depth.max(below.depth + 1);
        }
        let first = self.code.ops.len();
        let mut scope = self.scope(function, body, space)?;
        self.code.entries[number] = first as Target;
        self.code.owners.push((first as Target, number));
        self.prologue(&scope);
        self.statements(&mut scope, body).map_err(|error| {
            let file = program.files.get(usize::from(scope.at.file)).map_or("", String::as_str);
            format!("{file}:{}: {}: {error}", scope.at.line, function.name)
        })?;
        self.emit(&scope, Op::Return);
        self.resolve(first, &scope)?;
        // Callers use the registers and bytes above those of this function.
        space.registers = scope.most;
        space.memory = self.frame(function, space.memory, function.locals.len());
        self.spaces[number] = space;
        self.homes[number] = (scope.instance, scope.homes);
        Ok(())
    }

    /// Assigns homes to the locals of a function.
    fn scope(&self, function: &'a Function, body: &[Statement], space: Space) -> Result<Scope<'a>, String> {
        let mut next = space.registers;
        let mut take = |count: usize| {
            next += count;
            Register::try_from(next)
                .map(|_| (next - count) as Register)
                .map_err(|_| format!("{} has too many variables, or its calls are nested too deeply", function.name))
        };
        let instance = take(1)?;
        let mut homes = Vec::new();
        for (number, local) in function.locals.iter().enumerate() {
            self.check(&local.ty, 0)?;
            homes.push(match &local.ty {
                Type::Open { dimensions, .. } if local.by_reference => Home::Reference(take(1 + 2 * dimensions)?),
                Type::Open { .. } => return Err(format!("{}: an open array must be passed by reference", local.name)),
                _ if local.by_reference => Home::Reference(take(1)?),
                Type::Scalar(_) => Home::Register(take(1)?),
                _ => Home::Memory(self.frame(function, space.memory, number)),
            });
            if local.by_reference && number >= function.parameters {
                return Err(format!("{} is passed by reference but is not a parameter", local.name));
            }
        }
        let mut labels = Labels::default();
        walk::statements(body, &mut labels);
        if labels.0 > body.len() + 100_000 {
            return Err(format!("{}: a label number is too large", function.name));
        }
        let labels = vec![None; labels.0];
        Ok(Scope {
            function,
            instance,
            homes,
            next,
            most: next,
            labels,
            loops: Vec::new(),
            at: At::default(),
            run: None,
        })
    }

    /// The aligned address of local `number` in a function frame at `start`; for the number after the last local, the
    /// end of the frame.
    fn frame(&self, function: &Function, start: usize, number: usize) -> usize {
        let mut address = start;
        for (index, local) in function.locals.iter().enumerate() {
            if local.by_reference || matches!(local.ty, Type::Scalar(_)) {
                continue;
            }
            address = align(address, self.program.align(&local.ty));
            if index >= number {
                return address;
            }
            address = address.saturating_add(self.program.size(&local.ty));
        }
        align(address, 8)
    }

    /// Rejects a type that refers to a missing record, has no elements, is too large or has too many dimensions.
    fn check(&self, ty: &Type, depth: usize) -> Result<(), String> {
        match ty {
            Type::Record(record) if *record >= self.program.records.len() => Err("a record does not exist".to_string()),
            Type::Array { of, bounds } => {
                if bounds.is_empty() || bounds.iter().any(|(low, high)| low > high) || depth > 16 {
                    return Err("an array has no elements".to_string());
                }
                if self.program.size(ty) > LARGEST_MEMORY {
                    return Err(format!("an array is larger than {} MB", LARGEST_MEMORY >> 20));
                }
                self.check(of, depth + 1)
            }
            Type::Open { of, dimensions } if (1..=6).contains(dimensions) => self.check(of, depth + 1),
            Type::Open { .. } => Err("an open array must have 1 to 6 dimensions".to_string()),
            _ => Ok(()),
        }
    }

    /// Emits the instructions that initialize the locals other than the parameters.
    fn prologue(&mut self, scope: &Scope) {
        let function = scope.function;
        let (mut first, mut count) = (ZERO, 0);
        for (number, local) in function.locals.iter().enumerate().skip(function.parameters) {
            match scope.homes[number] {
                Home::Register(register) => {
                    first = if count == 0 { register } else { first };
                    count += 1;
                }
                Home::Memory(address) => self.start_values(scope, address, &local.ty),
                Home::Reference(_) => {}
            }
        }
        if count > 0 {
            // The numeric locals have consecutive registers, because there are no parameters among them.
            self.emit(scope, Op::Clear { from: first, count });
        }
    }

    /// Emits an instruction that copies a type's start values to an address.
    fn start_values(&mut self, scope: &Scope, address: usize, ty: &Type) {
        let image = self.program.start(ty);
        let (from, size) = (self.code.images.len() as u32, image.len() as u32);
        self.code.images.extend(image);
        self.emit(scope, Op::Image { to: address as u32, from, size });
    }

    /// Replaces the labels in a function's jumps with instruction indices.
    fn resolve(&mut self, first: usize, scope: &Scope) -> Result<(), String> {
        for op in &mut self.code.ops[first..] {
            if let Op::Jump { to }
            | Op::Back { to }
            | Op::JumpIf { to, .. }
            | Op::JumpUnless { to, .. }
            | Op::JumpInside { to, .. }
            | Op::ForTest { to, .. } = op
            {
                let target = scope.labels.get(*to as usize).copied().flatten();
                *to = target.ok_or_else(|| format!("{}: the label of a jump is missing", scope.function.name))?;
            }
        }
        Ok(())
    }

    fn emit(&mut self, scope: &Scope, op: Op) {
        self.code.ops.push(op);
        self.code.lines.push(scope.at);
    }

    /// Appends the parts of a type that a comparison of two variables must cover.
    fn parts(&self, ty: &Type, offset: usize, parts: &mut Vec<Part>) -> Result<(), String> {
        const MOST: usize = 10_000;
        match ty {
            Type::Scalar(ty) => parts.push(Part::Numbers { ty: *ty, offset: offset as u32, count: 1 }),
            Type::Text { capacity, wide } => {
                parts.push(Part::Text { offset: offset as u32, capacity: *capacity, wide: *wide });
            }
            Type::Array { of, .. } => {
                let size = self.program.size(of).max(1);
                let count = self.program.size(ty) / size;
                if let Type::Scalar(ty) = **of {
                    parts.push(Part::Numbers { ty, offset: offset as u32, count: count as u32 });
                } else {
                    for index in 0..count {
                        self.parts(of, offset + index * size, parts)?;
                    }
                }
            }
            Type::Record(record) => {
                for member in &self.program.records[*record].members {
                    self.parts(&member.ty, offset + member.offset, parts)?;
                }
            }
            Type::Open { .. } => return Err("an open array cannot be compared".to_string()),
        }
        if parts.len() > MOST {
            Err(format!("a comparison covers more than {MOST} members; compare smaller parts"))
        } else {
            Ok(())
        }
    }

    /// The index of a block's law, and the size of its instance.
    fn native(&mut self, name: &'static str) -> Result<(u16, usize), String> {
        let known = self.natives.iter().position(|(known, ..)| *known == name);
        let number = match known {
            Some(number) => number,
            None => {
                let (law, size) = law(name).ok_or_else(|| format!("the block {name} does not exist"))?;
                self.natives.push((name, law, size));
                self.natives.len() - 1
            }
        };
        Ok((number as u16, self.natives[number].2))
    }
}

/// Finds the number of labels in statements: the highest label + 1.
#[derive(Default)]
struct Labels(usize);

impl Look for Labels {
    fn statement(&mut self, statement: &Statement) {
        use crate::ir::What;
        if let What::Label(label) | What::Goto(label) = statement.what {
            self.0 = self.0.max(label.saturating_add(1));
        }
    }
}

/// The functions that statements call directly.
fn callees(body: &[Statement]) -> BTreeSet<usize> {
    let mut callees = BTreeSet::new();
    walk::each_call(body, &mut |call| {
        callees.insert(call.function);
    });
    callees
}

/// The law of the named block, and the size of its instance.
fn law(name: &str) -> Option<(Native, usize)> {
    fn call<B: Block>(instance: &mut [u8], room: &mut Vec<u8>) -> bool {
        let Some(mut block) = B::read(&mut &*instance) else { return false };
        block.call();
        room.clear();
        block.write(room);
        instance.copy_from_slice(room);
        true
    }
    struct Find<'a>(&'a str, Option<(Native, usize)>);
    impl EachBlock for Find<'_> {
        fn block<B: Block>(&mut self) {
            if B::TABLE.name == self.0 {
                let mut instance = Vec::new();
                B::default().write(&mut instance);
                self.1 = Some((call::<B>, instance.len()));
            }
        }
    }
    let mut find = Find(name, None);
    for_each_block(&mut find);
    find.1
}

fn wrong_type(expected: impl std::fmt::Display, found: impl std::fmt::Display) -> String {
    format!("expected {expected}, found {found}")
}

/// The warning of an operation: a division by 0 or an overflow.
fn warning(by_zero: bool, ty: Scalar) -> String {
    match (by_zero, ty.is_float()) {
        (true, false) => "division by 0: the result is 0".to_string(),
        (true, true) => "division by 0: the result is infinite or not a number".to_string(),
        (false, _) => format!("overflow: the result is outside the range of {ty}; its low bits are kept"),
    }
}
