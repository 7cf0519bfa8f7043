//! Tests of programs built directly as typed programs, without SCL.

use super::{Cause, Code, Machine};
use crate::ir::{
    Argument, Arm, At, Base, Binary, Body, Call, Convert, Expr, For, Function, Local, Place, Program, Scalar,
    Statement, Step, Type, Unary, Value, What,
};
use std::sync::Arc;

pub(crate) mod random;

/// Builds a program whose memory has these variables, with a function without locals.
fn program(variables: &[(&str, Type)], body: Vec<Statement>) -> Program {
    let mut program = Program { files: vec!["test.scl".to_string()], ..Program::default() };
    program.constants = program.add_record("constants", []);
    program.memory = program.add_record("memory", variables.iter().map(|(name, ty)| (name.to_string(), ty.clone())));
    program.functions.push(function("cycle", body));
    program
}

fn function(name: &str, body: Vec<Statement>) -> Function {
    Function { name: name.to_string(), instance: None, locals: Vec::new(), parameters: 0, body: Body::Code(body) }
}

fn machine(program: &Program) -> Machine {
    Machine::new(Arc::new(Code::compile(program).unwrap()))
}

/// Builds a statement on a line.
fn on(line: u32, what: What) -> Statement {
    Statement { at: At { file: 0, line }, what }
}

fn variable(number: usize) -> Place {
    Place::new(Base::Memory).member(number)
}

fn load(ty: Scalar, number: usize) -> Expr {
    Expr::Load(ty, variable(number))
}

fn constant(value: impl Into<Value>) -> Expr {
    Expr::Const(value.into())
}

fn binary(op: Binary, ty: Scalar, a: Expr, b: Expr) -> Expr {
    Expr::Binary(op, ty, Box::new(a), Box::new(b), At { file: 0, line: 7 })
}

fn element(number: usize, index: Expr) -> Place {
    let mut place = variable(number);
    place.steps.push(Step::Index(vec![index], At { file: 0, line: 5 }));
    place
}

const I16: Type = Type::Scalar(Scalar::I16);
const I32: Type = Type::Scalar(Scalar::I32);

#[test]
fn an_index_outside_stops_with_its_line_and_leaves_the_memory_as_it_was() {
    let array = Type::Array { of: Box::new(I16), bounds: vec![(-1, 3)] };
    let body = vec![
        on(4, What::Assign(element(0, load(Scalar::I16, 1)), constant(9_i16))),
        on(
            6,
            What::Assign(
                element(0, binary(Binary::Add, Scalar::I16, load(Scalar::I16, 1), constant(2_i16))),
                constant(9_i16),
            ),
        ),
    ];
    let mut machine = machine(&program(&[("a", array), ("i", I16)], body));
    machine.set(2_i16.into(), 10);
    let before = machine.state().to_vec();
    let stop = machine.call(0, 0).unwrap_err();
    assert_eq!((stop.line, &stop.cause), (5, &Cause::Index { index: 4, low: -1, high: 3 }));
    assert_eq!(stop.to_string(), "test.scl:5: index 4 is outside -1..3");
    assert_eq!(machine.state(), before);

    machine.set((-1_i16).into(), 10);
    machine.call(0, 0).unwrap();
    assert_eq!(machine.state(), [9, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0xFF, 0xFF]);
}

#[test]
fn a_loop_without_end_stops_at_its_line_even_if_it_has_no_statement() {
    for body in [vec![], vec![on(3, What::Assign(variable(0), constant(1_i16)))]] {
        let mut machine = machine(&program(&[("i", I16)], vec![on(2, What::While(constant(true), body))]));
        machine.budget = 1000;
        let stop = machine.call(0, 0).unwrap_err();
        assert_eq!((stop.line, stop.cause), (2, Cause::Budget(1000)));
        assert_eq!(machine.get(Scalar::I16, 0), 0_i16.into());
    }
}

#[test]
fn calls_that_double_at_each_level_stop_too() {
    let mut program = program(&[("i", I16)], Vec::new());
    for level in 0..40 {
        let call = || Call { function: level + 2, instance: None, arguments: Vec::new(), outputs: Vec::new() };
        let body = vec![on(1, What::Call(call())), on(2, What::Call(call()))];
        program.functions.push(function(&format!("level {level}"), body));
    }
    program.functions.push(function("last", vec![on(3, What::Assign(variable(0), constant(1_i16)))]));
    program.functions[0].body = Body::Code(vec![on(
        9,
        What::Call(Call { function: 1, instance: None, arguments: Vec::new(), outputs: Vec::new() }),
    )]);
    let stop = machine(&program).call(0, 0).unwrap_err();
    assert_eq!(stop.cause, Cause::Budget(Machine::BUDGET));
}

#[test]
fn a_function_that_calls_itself_is_refused() {
    let mut program = program(&[("i", I16)], Vec::new());
    let call = Call { function: 0, instance: None, arguments: Vec::new(), outputs: Vec::new() };
    program.functions[0].body = Body::Code(vec![on(1, What::Call(call))]);
    assert_eq!(Code::compile(&program).err(), Some("cycle calls itself".to_string()));
}

#[test]
fn a_division_by_0_gives_0_and_warns_once_for_each_place() {
    let divide = |op| on(7, What::Assign(variable(1), binary(op, Scalar::I16, load(Scalar::I16, 0), constant(0_i16))));
    let mut machine = machine(&program(&[("i", I16), ("q", I16)], vec![divide(Binary::Div), divide(Binary::Rem)]));
    machine.set(7_i16.into(), 0);
    machine.set(5_i16.into(), 2);
    machine.call(0, 0).unwrap();
    machine.call(0, 0).unwrap();
    assert_eq!(machine.get(Scalar::I16, 2), 0_i16.into());
    let warnings: Vec<String> = machine.take_warnings().iter().map(ToString::to_string).collect();
    assert_eq!(warnings, ["test.scl:7: division by 0: the result is 0"; 2]);
}

#[test]
fn a_loop_ends_at_the_last_number_of_its_type() {
    let count = What::For(Box::new(For {
        variable: variable(0),
        first: constant(32760_i16),
        last: constant(32767_i16),
        step: constant(3_i16),
        body: vec![on(
            3,
            What::Assign(variable(1), binary(Binary::Add, Scalar::I16, load(Scalar::I16, 1), constant(1_i16))),
        )],
    }));
    let mut machine = machine(&program(&[("i", I16), ("n", I16)], vec![on(2, count)]));
    machine.call(0, 0).unwrap();
    // 32760, 32763, 32766, then 32769 - 65536.
    assert_eq!((machine.get(Scalar::I16, 2), machine.get(Scalar::I16, 0)), (3_i16.into(), (-32767_i16).into()));
}

#[test]
fn an_argument_may_call_the_function_that_it_is_passed_to() {
    // f(a, b) = 10 a + b; cycle: r := f(f(1, 2), f(3, f(4, 5)))
    let mut program = program(&[("r", I16)], Vec::new());
    let local = |name: &str| Local { name: name.to_string(), ty: I16, by_reference: false };
    let value = |number| Expr::Load(Scalar::I16, Place::new(Base::Local(number)));
    let sum = binary(Binary::Add, Scalar::I16, binary(Binary::Mul, Scalar::I16, value(0), constant(10_i16)), value(1));
    program.functions.push(Function {
        name: "f".to_string(),
        instance: None,
        locals: vec![local("a"), local("b"), local("f")],
        parameters: 2,
        body: Body::Code(vec![on(1, What::Assign(Place::new(Base::Local(2)), sum))]),
    });
    let mut temporaries = 0;
    let mut f = |a: Expr, b: Expr| {
        let to = Place::new(Base::Local(temporaries));
        temporaries += 1;
        let arguments = vec![Argument::Value(a), Argument::Value(b)];
        let call = Call { function: 1, instance: None, arguments, outputs: vec![(2, to.clone())] };
        Expr::After(vec![on(2, What::Call(call))], Box::new(Expr::Load(Scalar::I16, to)))
    };
    let inner = f(constant(4_i16), constant(5_i16));
    let (left, right) = (f(constant(1_i16), constant(2_i16)), f(constant(3_i16), inner));
    let all = f(left, right);
    program.functions[0].locals = (0..temporaries).map(|number| local(&format!("t{number}"))).collect();
    program.functions[0].body = Body::Code(vec![on(2, What::Assign(variable(0), all))]);
    let mut machine = machine(&program);
    machine.call(0, 0).unwrap();
    assert_eq!(machine.get(Scalar::I16, 0), (10 * 12 + (3 * 10 + 45) as i16).into());
    assert_eq!(
        program.text(1),
        "function f\n  parameter a: i16\n  parameter b: i16\n  local f: i16\n  f := ((a *.i16 10) +.i16 b)\n"
    );
}

#[test]
fn an_array_by_reference_brings_its_bounds_along() {
    let array = Type::Array { of: Box::new(I16), bounds: vec![(-2, 2), (1, 3)] };
    let open = Type::Open { of: Box::new(I16), dimensions: 2 };
    let mut program = program(&[("a", array), ("high", I32)], Vec::new());
    let mut place = Place::new(Base::Local(0));
    place.steps.push(Step::Index(vec![constant(2_i16), constant(3_i32)], At::default()));
    program.functions.push(Function {
        name: "fill".to_string(),
        instance: None,
        locals: vec![Local { name: "a".to_string(), ty: open, by_reference: true }],
        parameters: 1,
        body: Body::Code(vec![
            on(1, What::Assign(place, constant(9_i16))),
            on(2, What::Assign(variable(1), Expr::Bound { local: 0, dimension: 1, upper: true })),
        ]),
    });
    let call = Call { function: 1, instance: None, arguments: vec![Argument::Reference(variable(0))], outputs: vec![] };
    program.functions[0].body = Body::Code(vec![on(1, What::Call(call))]);
    let mut machine = machine(&program);
    machine.call(0, 0).unwrap();
    let (offset, _) = program.find("a[2,3]").unwrap();
    assert_eq!((offset, machine.get(Scalar::I16, offset)), (28, 9_i16.into()));
    assert_eq!(machine.get(Scalar::I32, program.find("high").unwrap().0), 3_i32.into());
}

#[test]
fn a_text_is_cut_to_the_capacity_and_compared_by_its_characters() {
    let text = |capacity| Type::Text { capacity, wide: false };
    let mut program = program(&[("short", text(3)), ("less", Type::Scalar(Scalar::Bool))], Vec::new());
    let constants = program.constants;
    program.extend_record(constants, "'valve'", text(5));
    program.records[constants].start.copy_from_slice(&[5, 0, b'v', b'a', b'l', b'v', b'e', 0]);
    let long = Place::new(Base::Constants).member(0);
    program.functions[0].body = Body::Code(vec![
        on(1, What::Copy(variable(0), long.clone())),
        on(2, What::Assign(variable(1), Expr::Texts(Binary::Lt, variable(0), long))),
    ]);
    let mut machine = machine(&program);
    machine.call(0, 0).unwrap();
    assert_eq!(machine.state(), [3, 0, b'v', b'a', b'l', 0, 1, 0]);
}

#[test]
fn a_case_takes_the_first_arm_and_coverage_shows_which_statements_ran() {
    let arm = |values: &[(i64, i64)], line, number: i16| Arm {
        values: values.to_vec(),
        body: vec![on(line, What::Assign(variable(1), constant(number)))],
    };
    let case = What::Case(
        load(Scalar::I16, 0),
        vec![arm(&[(1, 1), (3, 5)], 3, 10), arm(&[(5, 9)], 5, 20)],
        vec![on(7, What::Assign(variable(1), constant(30_i16)))],
    );
    let mut machine = machine(&program(&[("v", I16), ("t", I16)], vec![on(1, case)]));
    for (value, expected) in [(1_i16, 10_i16), (5, 10), (2, 30)] {
        machine.set(value.into(), 0);
        machine.call(0, 0).unwrap();
        assert_eq!(machine.get(Scalar::I16, 2), expected.into(), "{value}");
    }
    let mut lines: Vec<(u32, bool)> = machine.coverage().map(|(at, ran)| (at.line, ran)).collect();
    lines.sort_unstable();
    assert_eq!(lines, [(1, true), (3, true), (5, false), (7, true)]);
}

#[test]
fn operations_have_the_results_of_the_cpu() {
    let two = |op: Binary, a: Value, b: Value| op.fold(a, b).unwrap();
    assert_eq!(two(Binary::Add, 32767_i16.into(), 1_i16.into()), ((-32768_i16).into(), true));
    assert_eq!(two(Binary::Mul, 300_i16.into(), 300_i16.into()), (24464_i16.into(), true));
    assert_eq!(two(Binary::Rem, (-7_i16).into(), 2_i16.into()), ((-1_i16).into(), false));
    assert_eq!(two(Binary::Div, i64::MIN.into(), (-1_i64).into()), (i64::MIN.into(), true));
    assert_eq!(two(Binary::Shr, (-8_i16).into(), 20_u32.into()).0, (-1_i16).into());
    assert_eq!(two(Binary::Shl, 0xFFFF_u16.into(), 16_u32.into()).0, 0_u16.into());
    assert_eq!(two(Binary::Ror, 0x0F95_u16.into(), 5_u32.into()).0, 0xA87C_u16.into());
    assert_eq!(two(Binary::Ne, f32::NAN.into(), 1_f32.into()).0, false.into());
    assert_eq!(two(Binary::Max, (-0.0_f32).into(), 0.0_f32.into()).0, (-0.0_f32).into());
    // A square is exact where it is representable.
    for base in [3.0_f32, -1.5, 4097.0, 1e-3] {
        let square = (f64::from(base) * f64::from(base)) as f32;
        assert_eq!(two(Binary::Pow, base.into(), 2.0_f32.into()).0, square.into(), "{base}");
    }
    assert_eq!(two(Binary::Pow, (-8.0_f64).into(), 3.0_f64.into()).0, (-512.0_f64).into());
    assert!(two(Binary::Pow, (-8.0_f64).into(), 0.5_f64.into()).0.number().is_nan());

    let one = |op: Unary, a: Value| op.fold(a).unwrap();
    assert_eq!(one(Unary::Abs, i16::MIN.into()), i16::MIN.into());
    assert_eq!(one(Unary::Not, 0x0F_u8.into()), 0xF0_u8.into());
    assert_eq!(one(Unary::Swap, 0x0F55_u16.into()), 0x550F_u16.into());
    assert_eq!(one(Unary::Frac, (-2.75_f32).into()), (-0.75_f32).into());
    // In binary64, rounded once: 2.718281828459045 is 16#402D_F854.
    assert_eq!(one(Unary::Exp, 1.0_f32.into()), f32::from_bits(0x402D_F854).into());

    let convert = |how: Convert, a: Value, to| how.fold(a, to).unwrap();
    assert_eq!(convert(Convert::Value, 305.5_f32.into(), Scalar::U8), (50_u8.into(), true));
    assert_eq!(convert(Convert::Value, (-2.5_f32).into(), Scalar::U8), (254_u8.into(), true));
    assert_eq!(convert(Convert::Value, 10.5_f64.into(), Scalar::I32), (10_i32.into(), false));
    assert_eq!(convert(Convert::Value, 1e30_f64.into(), Scalar::I64), (i64::MAX.into(), true));
    assert_eq!(convert(Convert::Value, 1e19_f64.into(), Scalar::U64), (10_000_000_000_000_000_000_u64.into(), false));
    assert_eq!(convert(Convert::Value, f32::NAN.into(), Scalar::I32), (0_i32.into(), true));
    assert_eq!(convert(Convert::Ceil, (-1.5_f32).into(), Scalar::I32), ((-1_i32).into(), false));
    assert_eq!(convert(Convert::Bits, 1.0_f32.into(), Scalar::U32), (0x3F80_0000_u32.into(), false));
    assert_eq!(convert(Convert::Value, (-1_i16).into(), Scalar::U32), (u32::MAX.into(), false));
    assert_eq!(convert(Convert::Value, 2_i16.into(), Scalar::Bool), (false.into(), false));
    // One rounding: through binary64 it would be 2^60.
    let number = (1_i64 << 60) + (1 << 36) + 1;
    assert_eq!(convert(Convert::Value, number.into(), Scalar::F32).0, (2_f32.powi(60) + 2_f32.powi(37)).into());
}
