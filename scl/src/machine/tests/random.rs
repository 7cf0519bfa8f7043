//! Random programs neither panic nor hang.

use super::{Code, Machine};
use crate::c::is_endless;
use crate::ir::{
    Argument, Arm, At, Base, Binary, Body, Call, Convert, Expr, For, Function, Local, Place, Program, Scalar,
    Statement, Step, Type, Unary, Value, What,
};
use crate::{Options, compile};
use parameters::Source;
use proptest::prelude::*;
use std::sync::{Arc, LazyLock};

/// The target of the programs: SCL cannot express some constructs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    Machine,
    C,
    Scl,
}

/// A generator of random programs.
pub(crate) struct Random {
    seed: u64,
    of: Of,
    /// How often a part has the wrong type or does not exist: once in this many parts; never if 0.
    wrong: u64,
    /// Whether the program has loops and jumps.
    has_loops: bool,
    /// Whether the indices of assigned elements may contain calls, too.
    is_deep: bool,
    program: Program,
    /// The library functions that are called.
    library: Vec<usize>,
    /// The first generated function; each calls only earlier ones.
    first: usize,
    /// The function being generated.
    function: usize,
    /// Whether the function writes only to its own locals.
    is_pure: bool,
    line: u32,
    labels: usize,
    /// The variables visible to the function.
    ways: Vec<Way>,
}

/// A reachable variable.
#[derive(Clone)]
struct Way {
    base: Base,
    parts: Vec<Part>,
    ty: Type,
}

#[derive(Clone)]
enum Part {
    Member(usize),
    /// An element, with the inclusive bounds of each dimension.
    Element(Vec<(i32, i32)>),
    Length,
}

/// The form of a generated function.
#[derive(Clone, Copy)]
enum Form {
    /// A function with a value of this type and parameters of these types.
    Value(Scalar, &'static [Scalar]),
    /// A method of a function block.
    Instance,
    /// A function whose parameters are of all kinds.
    Procedure,
    /// An entry point.
    Entry,
}

const FORMS: [Form; 8] = [
    Form::Value(Scalar::F32, &[Scalar::F32, Scalar::I16]),
    Form::Value(Scalar::Bool, &[Scalar::I32]),
    Form::Value(Scalar::I32, &[Scalar::F32, Scalar::Bool]),
    Form::Instance,
    Form::Procedure,
    Form::Procedure,
    Form::Procedure,
    Form::Entry,
];

/// A program with instances of the library's blocks and calls of its functions.
static LIBRARY: LazyLock<Program> = LazyLock::new(|| {
    let source =
        "FUNCTION_BLOCK \"Library\" VAR ton : TON; tof : TOF; tp : TP; tonr : TONR; long : TON_LTIME; up : CTU;
        down : CTD; both : CTUD; wide : CTUD_LINT; rise : R_TRIG; fall : F_TRIG; sr : SR; rs : RS; s : String[9];
        w : WString[5]; i : Int; d : DInt; x : Real; t : Time; l : DTL; END_VAR
        BEGIN
        #ton(IN := TRUE, PT := T#1s); #tof(IN := TRUE, PT := T#1s); #tp(IN := TRUE, PT := T#1s);
        #tonr(IN := TRUE, R := FALSE, PT := T#1s); #long(IN := TRUE, PT := LT#1s);
        #up(CU := TRUE, R := FALSE, PV := 3); #down(CD := TRUE, LD := FALSE, PV := 3);
        #both(CU := TRUE, CD := FALSE, R := FALSE, LD := FALSE, PV := 3);
        #wide(CU := TRUE, CD := FALSE, R := FALSE, LD := FALSE, PV := 3);
        #rise(CLK := TRUE); #fall(CLK := TRUE); #sr(S1 := TRUE, R := FALSE); #rs(S := TRUE, R1 := FALSE);
        #s := CONCAT(IN1 := 'ab', IN2 := LEFT(IN := #s, L := 3)); #i := FIND(IN1 := #s, IN2 := 'b') + LEN(#s);
        #s := REPLACE(IN1 := MID(IN := #s, L := 2, P := 1), IN2 := RIGHT(IN := #s, L := 1), L := 1, P := 1);
        #s := INSERT(IN1 := DELETE(IN := #s, L := 1, P := 1), IN2 := INT_TO_STRING(#i), P := 1);
        #x := STRING_TO_REAL(REAL_TO_STRING(#x)); #d := STRING_TO_DINT(#s); #i := ENCO(DWORD#16#80);
        END_FUNCTION_BLOCK";
    let compiled = compile(&[Source::new("library.scl", source.into())], &Options::default());
    let compiled = compiled.unwrap_or_else(|errors| panic!("{}", errors[0]));
    let mut program = compiled.program;
    // The generated functions call the library themselves, so the bodies of its callers are removed.
    for function in &mut program.functions {
        if function.name == "Library" || function.parameters == 0 && function.instance.is_none() {
            function.body = Body::Code(Vec::new());
        }
    }
    program.docs = Default::default();
    program
});

impl Random {
    /// Generates a program, which is determined by the seed.
    pub(crate) fn program(seed: u64, wrong: u64, of: Of) -> Program {
        Random::of(seed, wrong, of, false)
    }

    /// Generates a program for C in which the indices of assigned elements may contain calls, too.
    pub(crate) fn deep_program(seed: u64) -> Program {
        Random::of(seed, 0, Of::C, true)
    }

    fn of(seed: u64, wrong: u64, of: Of, is_deep: bool) -> Program {
        let library = if of == Of::Scl { Program::default() } else { LIBRARY.clone() };
        let mut random = Random {
            seed: seed | 1,
            of,
            wrong,
            has_loops: true,
            is_deep,
            first: library.functions.len(),
            library: Vec::new(),
            program: library,
            function: 0,
            is_pure: false,
            line: 1,
            labels: 0,
            ways: Vec::new(),
        };
        random.has_loops = of == Of::Scl || random.below(2) == 0;
        random.declare();
        for (number, form) in FORMS.into_iter().enumerate() {
            random.make(random.first + number, form);
        }
        random.program
    }

    /// Returns the entry point of a program.
    pub(crate) fn entry(program: &Program) -> usize {
        program.functions.len() - 1
    }

    fn declare(&mut self) {
        let program = &mut self.program;
        if self.of == Of::Scl {
            program.files.push("random".to_string());
            program.constants = program.add_record("constants", []);
            program.memory = program.add_record("memory", []);
        }
        let text = |capacity, wide| Type::Text { capacity, wide };
        let (constants, number) = (program.constants, program.records[program.constants].members.len());
        program.extend_record(constants, "text", text(3, false));
        let offset = program.records[constants].members[number].offset;
        program.records[constants].start[offset..offset + 5].copy_from_slice(&[3, 0, b'a', b'b', b'c']);
        let name = |name: &str, ty: Type| (name.to_string(), ty);
        let array = |ty: Type, bounds: &[(i32, i32)]| Type::Array { of: Box::new(ty), bounds: bounds.to_vec() };
        let pair = program.add_record(
            "pair",
            [
                name("x", Type::Scalar(Scalar::F32)),
                name("a", array(Type::Scalar(Scalar::I16), &[(-1, 2)])),
                name("t", text(4, false)),
            ],
        );
        let memory = program.memory;
        for ty in Scalar::ALL {
            for n in [0, 1] {
                program.extend_record(memory, format!("{ty}_{n}"), Type::Scalar(*ty));
            }
        }
        program.extend_record(memory, "a", array(Type::Scalar(Scalar::I16), &[(-2, 3)]));
        program.extend_record(memory, "b", array(Type::Scalar(Scalar::F32), &[(0, 2), (1, 3)]));
        program.extend_record(memory, "c", array(Type::Record(pair), &[(0, 1)]));
        program.extend_record(memory, "p", Type::Record(pair));
        if self.of != Of::Scl {
            let block = program.add_record(
                "block",
                [
                    name("n", Type::Scalar(Scalar::I16)),
                    name("on", Type::Scalar(Scalar::Bool)),
                    name("y", Type::Scalar(Scalar::F32)),
                    name("k", Type::Scalar(Scalar::I64)),
                    name("p", Type::Record(pair)),
                    name("w", text(3, true)),
                ],
            );
            program.extend_record(memory, "g", Type::Record(block));
            program.extend_record(memory, "h", array(Type::Record(block), &[(1, 2)]));
            program.extend_record(memory, "m", array(text(2, false), &[(0, 1)]));
        }
        let has_loops = self.has_loops;
        let is_called = |number: &usize| {
            let function = &self.program.functions[*number];
            let is_own = function.name == "Library" || function.parameters == 0 && function.instance.is_none();
            !is_own && (has_loops || !is_endless(&self.program, *number))
        };
        self.library = (0..self.first).filter(is_called).collect();
    }

    /// Generates a function.
    fn make(&mut self, number: usize, form: Form) {
        let record = |name: &str| self.program.records.iter().position(|record| record.name == name);
        let pair = Type::Record(record("pair").unwrap());
        let local = |name: &str, ty: Type, by_reference| Local { name: name.to_string(), ty, by_reference };
        let mut locals = Vec::new();
        match form {
            Form::Value(_, parameters) => {
                let named = parameters.iter().zip(["a", "b"]);
                locals.extend(named.map(|(ty, name)| local(name, Type::Scalar(*ty), false)));
            }
            Form::Instance => {
                locals.push(local("v", Type::Scalar(Scalar::I32), false));
                locals.push(local("s", Type::Text { capacity: 4, wide: false }, false));
            }
            Form::Procedure => {
                locals.push(local("v", Type::Scalar(Scalar::I32), false));
                locals.push(local("p", pair.clone(), true));
                let (of, dimensions) = match number % 2 {
                    0 if self.of != Of::Scl => (Scalar::F32, 2),
                    _ => (Scalar::I16, 1),
                };
                locals.push(local("o", Type::Open { of: Box::new(Type::Scalar(of)), dimensions }, true));
                locals.push(local("q", pair, false));
                if self.of != Of::Scl {
                    locals.push(local("r", Type::Scalar(Scalar::F64), true));
                    let bounds = vec![(0, 1)];
                    locals.push(local("e", Type::Array { of: Box::new(Type::Scalar(Scalar::I16)), bounds }, false));
                }
            }
            Form::Entry => {}
        }
        let parameters = locals.len();
        if let Form::Value(result, _) = form {
            locals.push(local("result", Type::Scalar(result), false));
        }
        for (n, ty) in [Scalar::I16, Scalar::F32, Scalar::Bool, Scalar::I32].into_iter().enumerate() {
            locals.push(local(&format!("t{n}"), Type::Scalar(ty), false));
        }
        let instance = if matches!(form, Form::Instance) { record("block") } else { None };
        let name = format!("f{}", self.first + FORMS.len() - 1 - number);
        self.program.functions.push(Function { name, instance, locals, parameters, body: Body::Code(Vec::new()) });
        self.function = number;
        self.is_pure = matches!(form, Form::Value(..)) && self.below(2) == 0;
        self.see();
        let depth = if matches!(form, Form::Value(..)) { 2 } else { 3 };
        let mut body = self.statements(depth);
        if let Form::Value(ty, parameters) = form {
            let result = Place::new(Base::Local(parameters.len()));
            self.line += 1;
            let at = self.at();
            let assign = |value| Statement { at, what: What::Assign(result.clone(), value) };
            if self.below(2) == 0 {
                let leave = vec![assign(self.expr(ty, 2)), Statement { at, what: What::Return }];
                let condition = self.expr(Scalar::Bool, 1);
                body.push(Statement { at, what: What::If(condition, leave, Vec::new()) });
            }
            body.push(assign(self.expr(ty, 3)));
        }
        self.program.functions[number].body = Body::Code(body);
    }

    /// Collects the variables visible to the function.
    fn see(&mut self) {
        fn add(program: &Program, base: Base, ty: &Type, parts: &mut Vec<Part>, into: &mut Vec<Way>) {
            into.push(Way { base, parts: parts.clone(), ty: ty.clone() });
            let mut go = |part: Part, ty: &Type| {
                parts.push(part);
                add(program, base, ty, parts, into);
                parts.pop();
            };
            match ty {
                Type::Scalar(_) => {}
                Type::Text { capacity, wide } => {
                    let character = if *wide { Scalar::U16 } else { Scalar::U8 };
                    go(Part::Element(vec![(1, i32::from(*capacity))]), &Type::Scalar(character));
                    go(Part::Length, &Type::Scalar(Scalar::U16));
                }
                Type::Array { of, bounds } => go(Part::Element(bounds.clone()), of),
                Type::Open { of, dimensions } => go(Part::Element(vec![(1, 1); *dimensions]), of),
                Type::Record(record) => {
                    for (number, member) in program.records[*record].members.iter().enumerate() {
                        go(Part::Member(number), &member.ty);
                    }
                }
            }
        }
        let (program, mut ways) = (&self.program, Vec::new());
        let mut all = |base: Base, ty: &Type| add(program, base, ty, &mut Vec::new(), &mut ways);
        all(Base::Memory, &Type::Record(program.memory));
        all(Base::Constants, &Type::Record(program.constants));
        let function = &program.functions[self.function];
        // The function's own variables are chosen more often than those in the memory.
        for _ in 0..4 {
            for (number, local) in function.locals.iter().enumerate() {
                all(Base::Local(number), &local.ty);
            }
            function.instance.iter().for_each(|record| all(Base::Instance, &Type::Record(*record)));
        }
        self.ways = ways;
    }

    fn below(&mut self, count: usize) -> usize {
        // xorshift64*
        self.seed ^= self.seed >> 12;
        self.seed ^= self.seed << 25;
        self.seed ^= self.seed >> 27;
        ((self.seed.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) % count as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    fn is_wrong(&mut self) -> bool {
        self.wrong > 0 && self.below(self.wrong as usize) == 0
    }

    fn at(&mut self) -> At {
        At { file: 0, line: self.line }
    }

    fn on(&mut self, what: What) -> Statement {
        Statement { at: self.at(), what }
    }

    fn statements(&mut self, depth: usize) -> Vec<Statement> {
        let count = self.below(5);
        let mut list = Vec::new();
        for _ in 0..count {
            self.line += 1;
            let what = self.statement(depth);
            list.push(self.on(what));
        }
        if self.of != Of::Scl && self.has_loops && self.below(12) == 0 {
            self.labels += 1;
            let label = self.labels;
            let condition = self.expr(Scalar::Bool, 1);
            let jump = vec![self.on(What::Goto(label))];
            let jump = self.on(What::If(condition, jump, Vec::new()));
            for statement in [self.on(What::Label(label)), jump] {
                let place = self.below(list.len() + 1);
                list.insert(place, statement);
            }
        }
        list
    }

    fn statement(&mut self, depth: usize) -> What {
        let count = if depth == 0 { 9 } else { 15 };
        match self.below(count) {
            5 => self.copy(),
            6 => match self.call() {
                Some(call) => What::Call(call),
                None => self.assign(),
            },
            7 if self.below(3) == 0 => What::Return,
            8 if self.of != Of::Scl && self.below(3) == 0 => What::Comment("a comment /* in */ it".to_string()),
            9 => What::If(self.expr(Scalar::Bool, 2), self.statements(depth - 1), self.statements(depth - 1)),
            10 => {
                let of = self.one_of(&[Scalar::I16, Scalar::U8, Scalar::I64, Scalar::U32]);
                let arm = |this: &mut Self| Arm {
                    values: (0..1 + this.below(2)).map(|_| (this.below(9) as i64 - 4, this.below(9) as i64)).collect(),
                    body: this.statements(depth - 1),
                };
                let arms = (0..self.below(3)).map(|_| arm(self)).collect();
                What::Case(self.expr(of, 2), arms, self.statements(depth - 1))
            }
            11 if self.has_loops => What::While(self.expr(Scalar::Bool, 2), self.looped(depth - 1)),
            12 if self.has_loops => What::Repeat(self.looped(depth - 1), self.expr(Scalar::Bool, 2)),
            13 if self.has_loops => self.count(depth),
            14 if self.is_wrong() => What::Goto(999),
            _ => self.assign(),
        }
    }

    fn assign(&mut self) -> What {
        let ty = self.one_of(Scalar::ALL);
        What::Assign(self.written(ty, self.depth()), self.expr(ty, 3))
    }

    fn copy(&mut self) -> What {
        let to = self.find(|ty| !matches!(ty, Type::Scalar(_) | Type::Open { .. }), self.depth(), true);
        let Some((to, ty)) = to else { return self.assign() };
        match self.find(|from| is_copied(from, &ty), self.depth(), false) {
            Some((from, _)) => What::Copy(to, from),
            None => self.assign(),
        }
    }

    fn count(&mut self, depth: usize) -> What {
        let ty = self.one_of(&[Scalar::I16, Scalar::U8, Scalar::I32, Scalar::U64, Scalar::I8]);
        let step = match self.below(8) {
            0 if self.of != Of::Scl => self.expr(ty, 1),
            1 | 2 if ty.is_signed() => Expr::Const(Value::new(ty, (1 + self.below(3) as u64).wrapping_neg())),
            _ => Expr::Const(Value::new(ty, 1 + self.below(3) as u64)),
        };
        What::For(Box::new(For {
            variable: self.written(ty, 0),
            first: self.expr(ty, 1),
            last: self.expr(ty, 1),
            step,
            body: self.looped(depth - 1),
        }))
    }

    fn looped(&mut self, depth: usize) -> Vec<Statement> {
        let mut body = self.statements(depth);
        if self.below(2) == 0 {
            let what = if self.below(2) == 0 { What::Break } else { What::Continue };
            let condition = self.expr(Scalar::Bool, 1);
            let then = vec![self.on(what)];
            let leave = self.on(What::If(condition, then, Vec::new()));
            let place = self.below(body.len() + 1);
            body.insert(place, leave);
        }
        body
    }

    /// Generates a call to an earlier function; `None` if none fits.
    fn call(&mut self) -> Option<Call> {
        let own = self.function - self.first;
        if self.is_pure || own == 0 && self.library.is_empty() {
            return None;
        }
        let function = match self.below(3) {
            0 if !self.library.is_empty() => {
                let number = self.below(self.library.len());
                self.library[number]
            }
            _ if own == 0 => return None,
            _ => self.first + self.below(own),
        };
        let callee = self.program.functions[function].clone();
        let instance = match callee.instance {
            Some(record) => Some(self.find(|ty| *ty == Type::Record(record), self.depth(), true)?.0),
            None => None,
        };
        let mut arguments = Vec::new();
        for parameter in &callee.locals[..callee.parameters] {
            arguments.push(self.argument(parameter)?);
        }
        let mut outputs = Vec::new();
        if let Some(Form::Value(..)) = self.form(function) {
            if self.below(4) > 0 {
                let Type::Scalar(ty) = callee.locals[callee.parameters].ty else { return None };
                outputs.push((callee.parameters, self.written(ty, self.depth())));
            }
        } else {
            for _ in 0..self.below(4) {
                let output = self.below(callee.locals.len().max(1));
                let Some(local) = callee.locals.get(output).filter(|local| !local.by_reference) else { continue };
                if outputs.iter().all(|(other, _)| *other != output)
                    && let Some((to, _)) = self.find(|ty| is_copied(&local.ty, ty), self.depth(), true)
                {
                    outputs.push((output, to));
                }
            }
        }
        Some(Call { function, instance, arguments, outputs })
    }

    /// Generates an argument for a parameter; `None` if there is no suitable variable.
    fn argument(&mut self, parameter: &Local) -> Option<Argument> {
        if parameter.by_reference {
            let fits = |ty: &Type| match (&parameter.ty, ty) {
                (Type::Open { of, dimensions }, Type::Array { of: found, bounds }) => {
                    of == found && *dimensions == bounds.len()
                }
                (parameter, ty) => parameter == ty,
            };
            return self.find(fits, self.depth(), true).map(|(place, _)| Argument::Reference(place));
        }
        Some(match &parameter.ty {
            _ if self.below(8) == 0 => Argument::Start,
            Type::Scalar(ty) => Argument::Value(self.expr(*ty, 2)),
            ty => Argument::Copy(self.find(|from| is_copied(from, ty), self.depth(), false)?.0),
        })
    }

    fn form(&self, function: usize) -> Option<Form> {
        function.checked_sub(self.first).map(|own| FORMS[own])
    }

    /// Generates a call to an earlier function for its value.
    fn value_of(&mut self, ty: Scalar) -> Option<Expr> {
        let function =
            (self.first..self.function).find(|it| matches!(self.form(*it), Some(Form::Value(of, _)) if of == ty))?;
        if self.is_pure && self.of != Of::Machine {
            return None;
        }
        let callee = self.program.functions[function].clone();
        let mut arguments = Vec::new();
        for parameter in &callee.locals[..callee.parameters] {
            arguments.push(self.argument(parameter)?);
        }
        let locals = &mut self.program.functions[self.function].locals;
        let to = Place::new(Base::Local(locals.len()));
        let name = format!("r{}", locals.len());
        locals.push(Local { name, ty: Type::Scalar(ty), by_reference: false });
        let outputs = vec![(callee.parameters, to.clone())];
        let call = self.on(What::Call(Call { function, instance: None, arguments, outputs }));
        Some(Expr::After(vec![call], Box::new(Expr::Load(ty, to))))
    }

    /// Returns the nesting depth of indices in assignments and arguments.
    fn depth(&self) -> usize {
        if self.is_deep { 2 } else { 1 }
    }

    /// Selects a variable with a suitable type, and returns its type too.
    fn find(&mut self, fits: impl Fn(&Type) -> bool, depth: usize, is_written: bool) -> Option<(Place, Type)> {
        let function = &self.program.functions[self.function];
        let is_own = |base: Base| match base {
            Base::Local(local) => !function.locals[local].by_reference,
            _ => false,
        };
        let may = |way: &Way| {
            fits(&way.ty) && (!is_written || if self.is_pure { is_own(way.base) } else { way.base != Base::Constants })
        };
        let found: Vec<usize> = (0..self.ways.len()).filter(|number| may(&self.ways[*number])).collect();
        if found.is_empty() {
            return None;
        }
        let number = self.one_of(&found);
        let way = self.ways[number].clone();
        let mut place = Place::new(way.base);
        for part in way.parts {
            let step = match part {
                Part::Member(member) => Step::Member(member),
                Part::Length => Step::Length,
                Part::Element(bounds) => {
                    let indices = bounds.into_iter().map(|bounds| self.index(bounds, depth)).collect();
                    Step::Index(indices, self.at())
                }
            };
            place.steps.push(step);
        }
        Some((place, way.ty))
    }

    /// Selects a number to be assigned to.
    fn written(&mut self, ty: Scalar, depth: usize) -> Place {
        self.number(ty, depth, true)
    }

    fn number(&mut self, ty: Scalar, depth: usize, is_written: bool) -> Place {
        if self.is_wrong() {
            return Place::new(Base::Memory).member(self.below(40));
        }
        if let Some((place, _)) = self.find(|it| *it == Type::Scalar(ty), depth, is_written) {
            return place;
        }
        // A function that writes only to its own locals is given a new one.
        let locals = &mut self.program.functions[self.function].locals;
        locals.push(Local { name: format!("l{}", locals.len()), ty: Type::Scalar(ty), by_reference: false });
        let base = Base::Local(locals.len() - 1);
        self.ways.push(Way { base, parts: Vec::new(), ty: Type::Scalar(ty) });
        Place::new(base)
    }

    /// Generates an index, usually within the bounds.
    fn index(&mut self, (low, high): (i32, i32), depth: usize) -> Expr {
        let ty = self.one_of(&[Scalar::I16, Scalar::I32, Scalar::I64]);
        let count = (high - low + 1).max(1) as usize;
        let within = low + self.below(count) as i32;
        match self.below(60) {
            0 => Expr::Const(Value::new(ty, (high + 1) as u64)),
            1..5 if depth > 0 => {
                let (count, low) = (Value::new(ty, count as u64), Value::new(ty, i64::from(low) as u64));
                let at = self.at();
                let rest = Expr::Binary(Binary::Rem, ty, self.boxed(ty, depth), Box::new(Expr::Const(count)), at);
                Expr::Binary(Binary::Add, ty, Box::new(rest), Box::new(Expr::Const(low)), at)
            }
            _ => Expr::Const(Value::new(ty, i64::from(within) as u64)),
        }
    }

    fn load(&mut self, ty: Scalar, depth: usize) -> Expr {
        Expr::Load(ty, self.number(ty, depth, false))
    }

    fn expr(&mut self, ty: Scalar, depth: usize) -> Expr {
        let wrong = self.is_wrong();
        let ty = if wrong { self.one_of(Scalar::ALL) } else { ty };
        if depth == 0 {
            return if self.below(3) > 0 { self.load(ty, 0) } else { Expr::Const(self.value(ty)) };
        }
        let at = self.at();
        let choice = self.below(11);
        match (choice, ty) {
            (0, _) => self.load(ty, depth - 1),
            (1 | 2, Scalar::Bool) => {
                let of = self.one_of(Scalar::ALL);
                let ops: &[Binary] = if of == Scalar::Bool { &COMPARISONS[..2] } else { &COMPARISONS };
                Expr::Binary(self.one_of(ops), of, self.boxed(of, depth), self.boxed(of, depth), at)
            }
            (3, Scalar::Bool) => self.comparison(depth).unwrap_or_else(|| self.load(ty, depth - 1)),
            (4, _) => Expr::Select(
                ty,
                Box::new([self.expr(Scalar::Bool, depth - 1), self.expr(ty, depth - 1), self.expr(ty, depth - 1)]),
            ),
            (5, _) if ty != Scalar::Bool => Expr::Limit(ty, Box::new([(); 3].map(|()| self.expr(ty, depth - 1)))),
            (6, _) => {
                let from = self.one_of(Scalar::ALL);
                let how = self.one_of(&[Convert::Value, Convert::Trunc, Convert::Ceil, Convert::Floor, Convert::Bits]);
                let how = if how.function(from, ty).is_some() { how } else { Convert::Value };
                if how.function(from, ty).is_none() {
                    return Expr::Const(self.value(ty));
                }
                let a = self.boxed(from, depth);
                let bits = Expr::Convert(how, from, ty, a.clone(), at);
                if self.of != Of::C || how != Convert::Bits || !from.is_float() {
                    return bits;
                }
                // The bits of a NaN depend on the processor, and compilers may choose others.
                let is_number = Expr::Binary(Binary::Eq, from, a.clone(), a, at);
                Expr::Select(ty, Box::new([is_number, bits, Expr::Const(Value::new(ty, 0))]))
            }
            (7, _) if self.below(6) == 0 => match self.call() {
                Some(call) => Expr::After(vec![Statement { at, what: What::Call(call) }], self.boxed(ty, depth)),
                None => self.load(ty, depth - 1),
            },
            (7 | 8, Scalar::F32 | Scalar::Bool | Scalar::I32) if self.below(2) == 0 => {
                self.value_of(ty).unwrap_or_else(|| self.load(ty, depth - 1))
            }
            (8, Scalar::I64) => Expr::Now,
            (8, Scalar::I32) => self.bound().unwrap_or_else(|| self.load(ty, depth - 1)),
            (9, _) => {
                let op = self.one_of(&UNARIES);
                let has_none = op.function(ty).is_none();
                if has_none || self.of == Of::Scl && UNARIES[6..].contains(&op) {
                    return Expr::Const(self.value(ty));
                }
                Expr::Unary(op, ty, self.boxed(ty, depth))
            }
            _ => {
                let ops: &[Binary] = match ty {
                    Scalar::Bool => &[Binary::And, Binary::Or, Binary::Xor],
                    Scalar::F32 | Scalar::F64 => &OF_FLOATS,
                    _ => &OF_INTEGERS,
                };
                let op = match self.one_of(ops) {
                    Binary::Pow if self.of == Of::Scl => Binary::Mul,
                    op => op,
                };
                let right = if op.shifts() { Scalar::U32 } else { ty };
                Expr::Binary(op, ty, self.boxed(ty, depth), self.boxed(right, depth), at)
            }
        }
    }

    /// Generates a comparison of texts, structures or arrays.
    fn comparison(&mut self, depth: usize) -> Option<Expr> {
        if self.below(2) == 0 {
            let (a, ty) = self.find(|ty| matches!(ty, Type::Text { .. }), depth - 1, false)?;
            let (b, _) = self.find(|other| is_copied(other, &ty), depth - 1, false)?;
            return Some(Expr::Texts(self.one_of(&COMPARISONS), a, b));
        }
        let is_whole = |ty: &Type| matches!(ty, Type::Record(_) | Type::Array { .. });
        let (a, ty) = self.find(is_whole, depth - 1, false)?;
        let (b, _) = self.find(|other| *other == ty, depth - 1, false)?;
        Some(Expr::Same(a, b))
    }

    /// Generates a bound of an array whose bounds come from the caller.
    fn bound(&mut self) -> Option<Expr> {
        let locals = &self.program.functions[self.function].locals;
        let (local, dimensions) = locals.iter().enumerate().find_map(|(number, local)| match local.ty {
            Type::Open { dimensions, .. } => Some((number, dimensions)),
            _ => None,
        })?;
        Some(Expr::Bound { local, dimension: self.below(dimensions), upper: self.below(2) == 0 })
    }

    fn boxed(&mut self, ty: Scalar, depth: usize) -> Box<Expr> {
        Box::new(self.expr(ty, depth - 1))
    }

    /// Generates a number, often at an end of its type's range.
    fn value(&mut self, ty: Scalar) -> Value {
        match (ty, self.below(6)) {
            (Scalar::F32, choice) => Value::from([0.5, -0.0, f32::INFINITY, -3e9, 1e-45, 7.25][choice]),
            (Scalar::F64, choice) => Value::from([0.5, 1e300, f64::NEG_INFINITY, 1e-9, -0.0, -123.456][choice]),
            (_, 0) => Value::new(ty, u64::MAX),
            (_, 1) => Value::new(ty, 1 << (8 * ty.size() - 1)),
            (_, 2) => Value::new(ty, (1 << (8 * ty.size() - 1)) - 1),
            (_, _) => Value::new(ty, self.below(40) as u64),
        }
    }
}

const COMPARISONS: [Binary; 6] = [Binary::Eq, Binary::Ne, Binary::Lt, Binary::Le, Binary::Gt, Binary::Ge];

/// Unary operations, those that can be printed as SCL first.
const UNARIES: [Unary; 15] = [
    Unary::Neg,
    Unary::Not,
    Unary::Abs,
    Unary::Swap,
    Unary::Frac,
    Unary::Sqrt,
    Unary::Exp,
    Unary::Ln,
    Unary::Log,
    Unary::Sin,
    Unary::Cos,
    Unary::Tan,
    Unary::Asin,
    Unary::Acos,
    Unary::Atan,
];

const OF_FLOATS: [Binary; 7] =
    [Binary::Add, Binary::Sub, Binary::Mul, Binary::Div, Binary::Min, Binary::Max, Binary::Pow];

const OF_INTEGERS: [Binary; 14] = [
    Binary::Add,
    Binary::Sub,
    Binary::Mul,
    Binary::Div,
    Binary::Rem,
    Binary::And,
    Binary::Or,
    Binary::Xor,
    Binary::Shl,
    Binary::Shr,
    Binary::Rol,
    Binary::Ror,
    Binary::Min,
    Binary::Max,
];

/// Whether a variable may be copied as a whole to a variable of a different type.
fn is_copied(from: &Type, to: &Type) -> bool {
    match (from, to) {
        (Type::Text { wide: a, .. }, Type::Text { wide: b, .. }) => a == b,
        (from, to) => from == to && !matches!(from, Type::Open { .. }),
    }
}

/// Runs a program for some calls, starting from random bytes if given.
fn run(program: &Program, bytes: &[u8]) -> Option<bool> {
    let mut machine = Machine::new(Arc::new(Code::compile(program).ok()?));
    machine.budget = 2000;
    let length = machine.state().len().min(bytes.len());
    machine.state_mut()[..length].copy_from_slice(&bytes[..length]);
    Some((0..3).all(|call| {
        let before = machine.state().to_vec();
        let done = machine.call(Random::entry(program), call * 100_000_000);
        assert!(done.is_ok() || machine.state() == before);
        done.is_ok()
    }))
}

proptest! {
    #[test]
    fn random_programs_run_or_stop(seed in any::<u64>(), bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let program = Random::program(seed, 0, Of::Machine);
        program.text(Random::entry(&program));
        // Every program without wrong parts compiles.
        prop_assert!(Code::compile(&program).is_ok(), "{:?}", Code::compile(&program).err());
        run(&program, &bytes);
    }

    #[test]
    fn damaged_programs_are_refused_or_run(seed in any::<u64>(), wrong in 5_u64..200) {
        run(&Random::program(seed, wrong, Of::Machine), &[]);
    }
}

#[test]
fn most_random_programs_run_to_their_end() {
    let done =
        (0..200).filter(|seed| run(&Random::program(*seed * 7919 + 1, 0, Of::Machine), &[]) == Some(true)).count();
    assert!(done > 50, "{done} of 200");
}
