//! Random programs: whatever they are, they neither panic nor hang.

use super::{Code, Machine, function};
use crate::program::{
    Argument, Arm, At, Base, Binary, Body, Call, Convert, Expr, For, Local, Place, Program, Scalar, Statement, Step,
    Type, Unary, Value, What,
};
use proptest::prelude::*;
use std::sync::Arc;

/// Makes random programs.
pub(crate) struct Random {
    seed: u64,
    /// How often a part is of the wrong type or does not exist: once in this many; never if 0.
    wrong: u64,
    /// Without functions that have no text in C.
    printable: bool,
    program: Program,
    /// The function whose statements are made; it calls only later ones.
    function: usize,
    line: u32,
}

const FUNCTIONS: usize = 4;

impl Random {
    /// A program. The same seed gives the same one.
    pub(crate) fn program(seed: u64, wrong: u64, printable: bool) -> Program {
        let mut random = Random { seed: seed | 1, wrong, printable, program: Program::default(), function: 0, line: 0 };
        random.declare();
        for number in 0..FUNCTIONS {
            random.function = number;
            let body = random.statements(3);
            random.program.functions[number].body = Body::Code(body);
        }
        random.program
    }

    fn declare(&mut self) {
        let program = &mut self.program;
        program.files.push("random".to_string());
        program.constants =
            program.add_record("constants", [("text".to_string(), Type::Text { capacity: 3, wide: false })]);
        program.records[0].start[..5].copy_from_slice(&[3, 0, b'a', b'b', b'c']);
        let name = |name: &str, ty: Type| (name.to_string(), ty);
        let array = |ty: Type, bounds: &[(i32, i32)]| Type::Array { of: Box::new(ty), bounds: bounds.to_vec() };
        let pair = program.add_record(
            "pair",
            [
                name("x", Type::Scalar(Scalar::F32)),
                name("a", array(Type::Scalar(Scalar::I16), &[(-1, 2)])),
                name("t", Type::Text { capacity: 4, wide: false }),
            ],
        );
        let mut variables: Vec<_> =
            Scalar::ALL.iter().flat_map(|ty| [0, 1].map(|n| name(&format!("{ty}_{n}"), Type::Scalar(*ty)))).collect();
        variables.push(name("a", array(Type::Scalar(Scalar::I16), &[(-2, 3)])));
        variables.push(name("b", array(Type::Scalar(Scalar::F32), &[(0, 2), (1, 3)])));
        variables.push(name("c", array(Type::Record(pair), &[(0, 1)])));
        variables.push(name("p", Type::Record(pair)));
        program.memory = program.add_record("memory", variables);
        for number in 0..FUNCTIONS {
            let mut made = function(&format!("f{number}"), Vec::new());
            if number > 0 {
                let local = |n: &str, ty, by_reference| Local { name: n.to_string(), ty, by_reference };
                made.locals = vec![
                    local("v", Type::Scalar(Scalar::I32), false),
                    local("p", Type::Record(pair), true),
                    local("o", Type::Open { of: Box::new(Type::Scalar(Scalar::I16)), dimensions: 1 }, true),
                    local("q", Type::Record(pair), false),
                ];
                made.parameters = 4;
            }
            made.locals.extend((0..4).map(|n| {
                let ty = Type::Scalar([Scalar::I16, Scalar::F32, Scalar::Bool, Scalar::I32][n]);
                Local { name: format!("t{n}"), ty, by_reference: false }
            }));
            self.program.functions.push(made);
        }
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

    fn statements(&mut self, depth: usize) -> Vec<Statement> {
        let count = self.below(5);
        (0..count)
            .map(|_| {
                self.line += 1;
                Statement { at: self.at(), what: self.statement(depth) }
            })
            .collect()
    }

    fn statement(&mut self, depth: usize) -> What {
        let choice = if depth == 0 { self.below(7) } else { self.below(13) };
        match choice {
            0..5 => {
                let ty = self.one_of(Scalar::ALL);
                What::Assign(self.place(ty, 1), self.expr(ty, 3))
            }
            5 => What::Copy(self.pair(), self.pair()),
            6 if self.function + 1 < FUNCTIONS => What::Call(self.call()),
            6 => What::Return,
            7 => What::If(self.expr(Scalar::Bool, 2), self.statements(depth - 1), self.statements(depth - 1)),
            8 => {
                let arm = |this: &mut Self| Arm {
                    values: vec![(this.below(9) as i64 - 4, this.below(9) as i64)],
                    body: this.statements(depth - 1),
                };
                What::Case(self.expr(Scalar::I16, 2), vec![arm(self), arm(self)], self.statements(depth - 1))
            }
            9 => What::While(self.expr(Scalar::Bool, 2), self.looped(depth - 1)),
            10 => What::Repeat(self.looped(depth - 1), self.expr(Scalar::Bool, 2)),
            11 => {
                let ty = self.one_of(&[Scalar::I16, Scalar::U8, Scalar::I32, Scalar::U64]);
                What::For(Box::new(For {
                    variable: self.place(ty, 0),
                    first: self.expr(ty, 1),
                    last: self.expr(ty, 1),
                    step: Expr::Const(Value::new(ty, 1 + self.below(3) as u64)),
                    body: self.looped(depth - 1),
                }))
            }
            _ if self.is_wrong() => What::Goto(3),
            _ => What::Assign(self.place(Scalar::Bool, 1), Expr::Same(self.pair(), self.pair())),
        }
    }

    fn looped(&mut self, depth: usize) -> Vec<Statement> {
        let mut body = self.statements(depth);
        if self.below(2) == 0 {
            let what = if self.below(2) == 0 { What::Break } else { What::Continue };
            let condition = self.expr(Scalar::Bool, 1);
            let at = self.at();
            body.push(Statement { at, what: What::If(condition, vec![Statement { at, what }], Vec::new()) });
        }
        body
    }

    fn call(&mut self) -> Call {
        let function = self.function + 1 + self.below(FUNCTIONS - self.function - 1);
        let arguments = vec![
            Argument::Value(self.expr(Scalar::I32, 2)),
            Argument::Reference(self.pair()),
            if self.function > 0 && self.below(2) == 0 {
                Argument::Reference(Place::of(Base::Local(2)))
            } else {
                Argument::Reference(self.memory("a"))
            },
            if self.below(2) == 0 { Argument::Start } else { Argument::Copy(self.pair()) },
        ];
        let outputs = vec![(3, self.pair()), (4, self.place(Scalar::I16, 1))];
        Call { function, instance: None, arguments, outputs }
    }

    fn memory(&self, name: &str) -> Place {
        let members = &self.program.records[self.program.memory].members;
        Place::of(Base::Memory).member(members.iter().position(|member| member.name == name).unwrap())
    }

    /// A place of a number.
    fn place(&mut self, ty: Scalar, depth: usize) -> Place {
        if self.is_wrong() {
            return Place::of(Base::Memory).member(self.below(40));
        }
        match (ty, self.below(4)) {
            (Scalar::I16, 0) if self.function > 0 => {
                let index = self.index(depth);
                with_index(Place::of(Base::Local(2)), index, self.at())
            }
            (Scalar::I16, 1) => {
                let index = self.index(depth);
                with_index(self.memory("a"), index, self.at())
            }
            (Scalar::I16, 2) => {
                let index = self.index(depth);
                with_index(self.pair().member(1), index, self.at())
            }
            (Scalar::U8, 0) => {
                let index = self.index(depth);
                with_index(self.pair().member(2), index, self.at())
            }
            (Scalar::F32, 0) => {
                let indices = vec![self.index(depth), self.index(depth)];
                let mut place = self.memory("b");
                place.steps.push(Step::Index(indices, self.at()));
                place
            }
            (Scalar::F32, 1) => self.pair().member(0),
            (Scalar::I16 | Scalar::F32 | Scalar::Bool | Scalar::I32, 3) => {
                let number = [Scalar::I16, Scalar::F32, Scalar::Bool, Scalar::I32].iter().position(|it| *it == ty);
                let before = if self.function > 0 { 4 } else { 0 };
                Place::of(Base::Local(before + number.unwrap()))
            }
            _ => {
                let n = self.below(2);
                self.memory(&format!("{ty}_{n}"))
            }
        }
    }

    /// A place of a pair.
    fn pair(&mut self) -> Place {
        match self.below(4) {
            0 if self.function > 0 => Place::of(Base::Local(1)),
            1 if self.function > 0 => Place::of(Base::Local(3)),
            2 => {
                let index = self.index(0);
                with_index(self.memory("c"), index, self.at())
            }
            _ => self.memory("p"),
        }
    }

    /// An index, which mostly lies within the bounds.
    fn index(&mut self, depth: usize) -> Expr {
        if depth == 0 || self.below(8) > 0 {
            return Expr::Const(Value::from(self.one_of(&[0_i16, 1, 1, 1, 2])));
        }
        let three = Expr::Const(Value::from(3_i16));
        let at = self.at();
        Expr::Binary(Binary::Rem, Scalar::I16, Box::new(self.expr(Scalar::I16, depth - 1)), Box::new(three), at)
    }

    fn expr(&mut self, ty: Scalar, depth: usize) -> Expr {
        let wrong = self.is_wrong();
        let ty = if wrong { self.one_of(Scalar::ALL) } else { ty };
        if depth == 0 {
            return if self.below(3) > 0 { Expr::Load(ty, self.place(ty, 0)) } else { Expr::Const(self.value(ty)) };
        }
        let at = self.at();
        let choice = self.below(10);
        match (choice, ty) {
            (0, _) => Expr::Load(ty, self.place(ty, depth - 1)),
            (1 | 2, Scalar::Bool) => {
                let of = self.one_of(Scalar::ALL);
                let ops: &[Binary] = match of {
                    Scalar::Bool => &[Binary::Eq, Binary::Ne],
                    _ => &[Binary::Eq, Binary::Ne, Binary::Lt, Binary::Le, Binary::Gt, Binary::Ge],
                };
                Expr::Binary(self.one_of(ops), of, self.boxed(of, depth), self.boxed(of, depth), at)
            }
            (3, Scalar::Bool) => Expr::Texts(Binary::Lt, self.pair().member(2), Place::of(Base::Constants).member(0)),
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
                Expr::Convert(how, from, ty, self.boxed(from, depth), at)
            }
            (7, _) if self.function + 1 < FUNCTIONS && self.below(4) == 0 => {
                let what = What::Call(self.call());
                Expr::After(vec![Statement { at, what }], self.boxed(ty, depth))
            }
            (8, Scalar::I64) => Expr::Now,
            (8, Scalar::I32) if self.function > 0 => Expr::Bound { local: 2, dimension: 0, upper: self.below(2) == 0 },
            (9, _) => {
                let ops =
                    [Unary::Neg, Unary::Not, Unary::Abs, Unary::Swap, Unary::Frac, Unary::Sqrt, Unary::Exp, Unary::Sin];
                let op = self.one_of(&ops);
                let in_c = !matches!(op, Unary::Exp | Unary::Sin);
                if op.function(ty).is_none() || self.printable && !in_c {
                    return Expr::Const(self.value(ty));
                }
                Expr::Unary(op, ty, self.boxed(ty, depth))
            }
            _ => {
                let ops: &[Binary] = match ty {
                    Scalar::Bool => &[Binary::And, Binary::Or, Binary::Xor],
                    Scalar::F32 | Scalar::F64 => {
                        &[Binary::Add, Binary::Sub, Binary::Mul, Binary::Div, Binary::Min, Binary::Max, Binary::Pow]
                    }
                    _ => &[
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
                    ],
                };
                let op = match self.one_of(ops) {
                    Binary::Pow if self.printable => Binary::Mul,
                    op => op,
                };
                let right = if op.shifts() { Scalar::U32 } else { ty };
                Expr::Binary(op, ty, self.boxed(ty, depth), self.boxed(right, depth), at)
            }
        }
    }

    fn boxed(&mut self, ty: Scalar, depth: usize) -> Box<Expr> {
        Box::new(self.expr(ty, depth - 1))
    }

    /// A number, often one at an end of its type.
    fn value(&mut self, ty: Scalar) -> Value {
        match (ty, self.below(4)) {
            (Scalar::F32, choice) => Value::from([0.5, -0.0, f32::INFINITY, -3e9][choice]),
            (Scalar::F64, choice) => Value::from([0.5, 1e300, f64::NEG_INFINITY, 1e-9][choice]),
            (_, 0) => Value::new(ty, u64::MAX),
            (_, 1) => Value::new(ty, 1 << (8 * ty.size() - 1)),
            (_, 2) => Value::new(ty, (1 << (8 * ty.size() - 1)) - 1),
            (_, _) => Value::new(ty, self.below(40) as u64),
        }
    }
}

fn with_index(mut place: Place, index: Expr, at: At) -> Place {
    place.steps.push(Step::Index(vec![index], at));
    place
}

/// Runs a program for some calls, from random bytes on if it is said.
fn run(program: &Program, bytes: &[u8]) -> Option<bool> {
    let mut machine = Machine::new(Arc::new(Code::compile(program).ok()?));
    machine.budget = 2000;
    let length = machine.state().len().min(bytes.len());
    machine.state_mut()[..length].copy_from_slice(&bytes[..length]);
    Some((0..3).all(|call| {
        let before = machine.state().to_vec();
        let done = machine.call(0, call * 100_000_000);
        assert!(done.is_ok() || machine.state() == before);
        done.is_ok()
    }))
}

proptest! {
    #[test]
    fn random_programs_run_or_stop(seed in any::<u64>(), bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let program = Random::program(seed, 0, false);
        program.text(1);
        // Without wrong parts every program compiles.
        prop_assert!(Code::compile(&program).is_ok(), "{:?}", Code::compile(&program).err());
        run(&program, &bytes);
    }

    #[test]
    fn damaged_programs_are_refused_or_run(seed in any::<u64>(), wrong in 5_u64..200) {
        run(&Random::program(seed, wrong, false), &[]);
    }
}

#[test]
fn most_random_programs_run_to_their_end() {
    let done = (0..200).filter(|seed| run(&Random::program(*seed * 7919 + 1, 0, false), &[]) == Some(true)).count();
    assert!(done > 50, "{done} of 200");
}
