//! Random programs give the same bits as C and in the machine.

use super::{HEAD, Printer, operations};
use crate::ir::{
    Argument, At, Base, Binary, Body, Call, Expr, Function, Local, Place, Program, Scalar, Statement, Step, Type,
    Value, What,
};
use crate::machine::tests::random::{Of, Random};
use crate::machine::{Cause, Code, Machine, Stop};
use crate::{Options, compile};
use parameters::Source;
use std::fmt::Write;
use std::process::Command;
use std::sync::Arc;

/// The number of calls of each program.
const CALLS: usize = 4;

/// The statement budget of each call: some programs do not terminate without it.
const BUDGET: u32 = 3000;

/// The number of programs compiled together.
const TOGETHER: u64 = 500;

/// Returns the number in an environment variable, or `otherwise`.
fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |it| it.parse().unwrap_or_else(|_| panic!("{name} is not a number")))
}

/// A host that makes the calls of each program and prints, after each call, where and why it was stopped, and the
/// memory.
const MAIN: &str = "
#include <stdio.h>
int main(void) {
    size_t number;
    int i;
    for (number = 0; number < sizeof programs / sizeof *programs; number += 1) {
        memory_t memory, before;
        start(&memory);
        for (i = 0; i < CALLS; i += 1) {
            call_t call = {i * (i64_t)100000000, BUDGET, 0, 0, 0, 0, 0};
            before = memory;
            programs[number](&call, &memory);
            if (call.stopped != 0) {
                memory = before;
            }
            fwrite(&call.stopped, sizeof call - offsetof(call_t, stopped), 1, stdout);
            fwrite(&memory, sizeof memory, 1, stdout);
        }
    }
    return 0;
}
";

/// The size of a [`Stopped`] in C, in bytes.
const STOPPED: usize = 32;

/// Where and why a call was stopped: line, cause, and index with its bounds; all 0 if it was not stopped.
#[derive(Debug, Default, PartialEq, Eq)]
struct Stopped {
    line: u32,
    cause: u32,
    index: [i64; 3],
}

impl Stopped {
    fn in_c(bytes: &[u8]) -> Stopped {
        let number = |at: usize| Value::read(Scalar::I64, &bytes[at..]).bits() as i64;
        let line_and_cause = number(0) as u64;
        // The upper bits hold the source number.
        let line = line_and_cause as u32 & 0xFF_FFFF;
        Stopped { line, cause: (line_and_cause >> 32) as u32, index: [8, 16, 24].map(number) }
    }

    fn in_machine(stop: &Stop) -> Stopped {
        let (cause, index) = match stop.cause {
            Cause::Index { index, low, high } => (1, [index, low, high]),
            Cause::Budget(_) => (2, [0; 3]),
            Cause::Step => (3, [0; 3]),
            Cause::Instance => (4, [0; 3]),
        };
        Stopped { line: stop.line, cause, index }
    }
}

/// The behavior of a program in the machine.
#[derive(Default)]
struct Ran {
    /// Where each call was stopped, and the memory after it.
    calls: Vec<(Stopped, Vec<u8>)>,
    by_budget: bool,
}

impl Ran {
    fn of(program: &Program, entry: usize) -> Ran {
        let mut machine = Machine::new(Arc::new(Code::compile(program).unwrap()));
        machine.budget = BUDGET;
        let mut ran = Ran::default();
        for call in 0..CALLS {
            let stopped = match machine.call(entry, call as i64 * 100_000_000) {
                Ok(()) => Stopped::default(),
                Err(stop) => {
                    ran.by_budget |= matches!(stop.cause, Cause::Budget(_));
                    Stopped::in_machine(&stop)
                }
            };
            ran.calls.push((stopped, machine.state().to_vec()));
        }
        ran
    }
}

/// Prints programs with the same types and start values, and a host that calls this function of each, as one file.
fn file(programs: &[Program], entry: usize) -> String {
    let (mut functions, mut entries) = (String::new(), String::new());
    let mut first = Printer::new(&programs[0]);
    for (number, program) in programs.iter().enumerate() {
        let mut printer = Printer::new(program);
        let text = printer.functions().unwrap();
        first.reads_constants |= printer.reads_constants;
        // Several programs share the names of functions, and a member of one may have such a name.
        let reached = printer.reached.iter().filter(|_| programs.len() > 1);
        let names: Vec<&String> = reached.map(|it| &printer.function_names[*it]).collect();
        names.iter().for_each(|name| functions += &format!("\n#define {name} {name}_{number}"));
        functions += &text;
        names.iter().for_each(|name| functions += &format!("#undef {name}\n"));
        let end = if programs.len() > 1 { format!("_{number}") } else { String::new() };
        let _ = write!(entries, "{}{end}, ", printer.function_names[entry]);
    }
    let (types, values) = first.data();
    let operations = operations::used(&format!("call_t {types}{values}{functions}"));
    format!(
        "#define PROGRAM static\n#define CALLS {CALLS}\n#define BUDGET {BUDGET}\n{HEAD}{operations}{types}{values}{functions}\n\
         static void (*const programs[])(call_t *, memory_t *) = {{{entries}}};\n{MAIN}"
    )
}

/// Returns the output of the file when it is compiled and run with this input; `None` without a compiler.
fn in_c(text: &str, name: &str, level: &str, input: &[u8]) -> Option<Vec<u8>> {
    let folder = std::env::temp_dir().join(format!("plcfmu-c-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (source, binary) = (folder.join("programs.c"), folder.join("programs"));
    std::fs::write(&source, text).unwrap();
    // Random programs contain useless computations, which each compiler reports under different names.
    let useless = [
        "-Wno-type-limits",
        "-Wno-tautological-compare",
        "-Wno-unknown-warning-option",
        "-Wno-bool-compare",
        "-Wno-self-assign",
        "-Wno-unused-function",
    ];
    let options = ["-std=c99", level, "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"];
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let compiler = if variable("CC").is_empty() { "cc".to_string() } else { variable("CC") };
    let more = variable("CFLAGS");
    let compiled = Command::new(compiler)
        .args(options)
        .args(useless)
        .args(more.split_whitespace())
        .arg(&source)
        .arg("-o")
        .arg(&binary)
        .output()
        .ok()?;
    let said = String::from_utf8_lossy(&compiled.stderr);
    assert!(
        compiled.status.success(),
        "{}:\n{}",
        source.display(),
        said.lines().take(40).collect::<Vec<_>>().join("\n")
    );
    let given = folder.join("input");
    std::fs::write(&given, input).unwrap();
    let given = std::fs::File::open(given).unwrap();
    let output = Command::new(&binary).stdin(given).output().unwrap();
    assert!(output.status.success(), "{}: {}", binary.display(), output.status);
    std::fs::remove_dir_all(&folder).unwrap();
    Some(output.stdout)
}

/// Collects the differences between two variables; all NaNs are equal, whatever their bits.
fn differences(program: &Program, ty: &Type, name: &str, (c, machine): (&[u8], &[u8]), found: &mut String) {
    match ty {
        Type::Scalar(ty) => {
            let (c, machine) = (Value::read(*ty, c), Value::read(*ty, machine));
            let no_number = |value: Value| matches!(ty, Scalar::F32 | Scalar::F64) && value.number().is_nan();
            if c != machine && !(no_number(c) && no_number(machine)) {
                let _ = writeln!(found, "{name} is {c} in C, {machine} in the machine");
            }
        }
        Type::Array { of, .. } => {
            let size = program.size(of);
            for (index, parts) in c.chunks(size).zip(machine.chunks(size)).enumerate() {
                differences(program, of, &format!("{name}[{index}]"), parts, found);
            }
        }
        Type::Record(record) => {
            for member in &program.records[*record].members {
                let range = member.offset..member.offset + program.size(&member.ty);
                let parts = (&c[range.clone()], &machine[range]);
                differences(program, &member.ty, &format!("{name}.{}", member.name), parts, found);
            }
        }
        _ if c != machine => {
            let _ = writeln!(found, "{name} is {c:?} in C, {machine:?} in the machine");
        }
        _ => {}
    }
}

/// Seeds of programs that once revealed a difference between machine and C: a local that the function returns and
/// through which the value of a call passes, an instance selected before the arguments are computed, two outputs
/// assigned to one local (four seeds), which of two out-of-bounds indices stops the call, and a number passed before an
/// index calls another function.
const FOUND: [u64; 8] = [1_107_116, 1_405_429, 1_427_833, 1_349_431, 1_518_423, 1_626_016, 1_723_388, 2_981_130];

/// Tests some random programs in each run; `PLCFMU_PROGRAMS=1000000 PLCFMU_SEED=5000` tests a million from the seed
/// 5000 on.
#[test]
fn printed_programs_give_the_bits_of_the_machine() {
    let (first, count) = (number("PLCFMU_SEED", 1), number("PLCFMU_PROGRAMS", 300));
    let together = TOGETHER.min(count.div_ceil(2));
    let (mut ended, mut by_budget) = (0, 0);
    let all: Vec<u64> = FOUND.into_iter().chain(first..first + count).collect();
    for (bundle, seeds) in all.chunks(together as usize).enumerate() {
        let programs: Vec<Program> = seeds
            .iter()
            .map(|seed| match seed % 4 {
                2 => Random::deep_program(seed * 7919),
                _ => Random::program(seed * 7919, 0, Of::C),
            })
            .collect();
        // All programs have the same functions.
        let entry = Random::entry(&programs[0]);
        let level = ["-O0", "-O2"][bundle % if count > 10_000 { 1 } else { 2 }];
        let Some(written) = in_c(&file(&programs, entry), &seeds[0].to_string(), level, &[]) else {
            eprintln!("there is no C compiler: nothing was compared");
            return;
        };
        let memory = programs[0].records[programs[0].memory].start.len();
        let mut calls = written.chunks(STOPPED + memory);
        for (seed, program) in seeds.iter().zip(&programs) {
            let ran = Ran::of(program, entry);
            by_budget += u64::from(ran.by_budget);
            ended += u64::from(ran.calls.iter().all(|(stopped, _)| *stopped == Stopped::default()));
            for (call, (stopped, machine)) in ran.calls.iter().enumerate() {
                let (stopped_c, c) = calls.next().unwrap().split_at(STOPPED);
                let stopped_c = Stopped::in_c(stopped_c);
                let mut found = String::new();
                if c != machine {
                    let ty = Type::Record(program.memory);
                    differences(program, &ty, "memory", (c, machine), &mut found);
                }
                if stopped_c != *stopped || !found.is_empty() {
                    let alone = std::env::temp_dir().join(format!("plcfmu-program-{seed}.c"));
                    std::fs::write(&alone, file(std::slice::from_ref(program), entry)).unwrap();
                    let alone = alone.display();
                    panic!(
                        "seed {seed} ({alone}), call {call}, {level}: {stopped_c:?} in C, {stopped:?} in the machine\n{found}"
                    );
                }
            }
        }
        assert!(calls.next().is_none());
        if count > 10_000 {
            eprintln!(
                "{} programs agree, {ended} of them ended, {by_budget} were stopped by their budget",
                bundle * together as usize + seeds.len()
            );
        }
    }
    assert!(ended > count / 3 && by_budget > 0, "{ended} of {count} ended, {by_budget} were stopped by their budget");
}

/// Indexed elements are evaluated in textual order, even if a later part contains a call that changes the index.
const ORDER: &str = r#"
TYPE "Pair" STRUCT x : Int; k : Array[0..9] of Int; END_STRUCT; END_TYPE
FUNCTION "Next" : Int VAR_IN_OUT i : Int; END_VAR
BEGIN #i := #i + 1; #Next := #i; END_FUNCTION
FUNCTION "Give" : Void VAR_INPUT v : Int; END_VAR VAR_IN_OUT p : "Pair"; END_VAR VAR_OUTPUT q : Int; END_VAR
BEGIN #p.x := #v; #q := 10 * #v; END_FUNCTION
FUNCTION "Take" : Void VAR_INPUT p : "Pair"; v : Int; END_VAR VAR_OUTPUT q : Int; END_VAR
BEGIN #q := #p.k[0] + #v; END_FUNCTION
FUNCTION_BLOCK "Counter" VAR_INPUT v : Int; END_VAR VAR n : Int; END_VAR
BEGIN #n := #v; END_FUNCTION_BLOCK
FUNCTION_BLOCK "Order"
VAR i : Int; a : Array[0..9] of "Pair"; n : Array[0..9] of Int; q : Array[0..9] of Int; r : Int; c : Array[0..9] of "Counter"; END_VAR
BEGIN
#i := 0;
"Give"(p := #a[#i], v := "Next"(i := #i), q => #q[#i]);
#n["Next"(i := #i)] := #i;
#a[#i].k["Next"(i := #i)] := 7;
#a[5].k[0] := 50;
#i := 4;
#a[#i] := #a["Next"(i := #i)];
#i := 5;
"Take"(p := #a[#i], v := "Next"(i := #i), q => #r);
#c[#i](v := "Next"(i := #i));
END_FUNCTION_BLOCK
"#;

#[test]
fn what_an_index_finds_is_found_in_the_order_of_the_text() {
    let compiled = compile(&[Source::new("order.scl", ORDER.into())], &Options::default());
    let compiled = compiled.unwrap_or_else(|errors| panic!("{}", errors[0]));
    let (program, root) = (compiled.program, compiled.root.unwrap());
    let value = |memory: &[u8], path: &str| {
        let (offset, _) = program.find(&format!("{}.{path}", root.instance)).unwrap_or_else(|| panic!("{path}"));
        Value::read(Scalar::I16, &memory[offset..]).bits() as i16
    };
    for (name, memory) in memories(&program, root.cycle, "order") {
        let all = ["a[0].x", "q[1]", "n[2]", "a[2].k[3]", "a[5].k[0]", "r", "c[6].n"].map(|path| value(&memory, path));
        assert_eq!(all, [1, 10, 1, 7, 50, 56, 7], "in {name}");
    }
}

/// Returns the memory after one call, in the machine and, if there is a compiler, in C.
fn memories(program: &Program, entry: usize, name: &str) -> Vec<(&'static str, Vec<u8>)> {
    let (stopped, machine) = Ran::of(program, entry).calls.swap_remove(0);
    assert_eq!(stopped, Stopped::default());
    let written = in_c(&file(std::slice::from_ref(program), entry), name, "-O2", &[]);
    let in_c = written.map(|it| ("C", it[STOPPED..][..machine.len()].to_vec()));
    in_c.into_iter().chain([("the machine", machine)]).collect()
}

/// SCL selects such an element beforehand; a program from another source need not.
#[test]
fn a_variable_by_reference_is_chosen_before_a_later_argument_changes_its_index() {
    let number = Type::Scalar(Scalar::I32);
    let mut program = Program { files: vec!["made".to_string()], ..Program::default() };
    program.constants = program.add_record("constants", []);
    let pair = Type::Record(program.add_record("pair", [("x".to_string(), number.clone())]));
    let pairs = Type::Array { of: Box::new(pair.clone()), bounds: vec![(0, 3)] };
    program.memory = program.add_record("memory", [("i".to_string(), number.clone()), ("a".to_string(), pairs)]);
    let at = At { file: 0, line: 1 };
    let on = |what: What| Statement { at, what };
    let load = |place: &Place| Expr::Load(Scalar::I32, place.clone());
    let (i, own) = (Place::new(Base::Memory).member(0), |local: usize| Place::new(Base::Local(local)));
    let local = |ty: &Type, by_reference| Local { name: "l".to_string(), ty: ty.clone(), by_reference };
    let mut add = |name: &str, locals: Vec<Local>, parameters: usize, body: Vec<Statement>| {
        let name = name.to_string();
        program.functions.push(Function { name, instance: None, locals, parameters, body: Body::Code(body) });
        program.functions.len() - 1
    };
    let one = Box::new(Expr::Const(Value::new(Scalar::I32, 1)));
    let sum = Expr::Binary(Binary::Add, Scalar::I32, Box::new(load(&i)), one, at);
    let counts = vec![on(What::Assign(i.clone(), sum)), on(What::Assign(own(0), load(&i)))];
    let next = add("next", vec![local(&number, false)], 0, counts);
    let gives = vec![on(What::Assign(own(0).member(0), load(&own(1))))];
    let give = add("give", vec![local(&pair, true), local(&number, false)], 2, gives);
    let mut element = Place::new(Base::Memory).member(1);
    element.steps.push(Step::Index(vec![load(&i)], at));
    let called = Call { function: next, instance: None, arguments: Vec::new(), outputs: vec![(0, own(0))] };
    let value = Expr::After(vec![on(What::Call(called))], Box::new(load(&own(0))));
    let arguments = vec![Argument::Reference(element), Argument::Value(value)];
    let given = on(What::Call(Call { function: give, instance: None, arguments, outputs: Vec::new() }));
    let zero = on(What::Assign(i, Expr::Const(Value::new(Scalar::I32, 0))));
    let entry = add("entry", vec![local(&number, false)], 0, vec![zero, given]);
    for (name, memory) in memories(&program, entry, "reference") {
        let numbers: Vec<u64> = memory.chunks(4).map(|bytes| Value::read(Scalar::I32, bytes).bits()).collect();
        // i, then x of each element.
        assert_eq!(numbers, [1, 1, 0, 0, 0], "in {name}");
    }
}

/// A host that reads numbers and prints the result of each function; a power takes two consecutive numbers.
const FUNCTIONS: &str = "
#include <stdio.h>
int main(void) {
    double x, before = 1.0;
    while (fread(&x, sizeof x, 1, stdin) == 1) {
        double all[10] = {0};
        float power;
        all[0] = exp_f64(x), all[1] = ln_f64(x), all[2] = log_f64(x), all[3] = sin_f64(x), all[4] = cos_f64(x);
        all[5] = tan_f64(x), all[6] = asin_f64(x), all[7] = acos_f64(x), all[8] = atan_f64(x), all[9] = pow_f64(before, x);
        power = pow_f32((float)before, (float)x);
        fwrite(all, sizeof all, 1, stdout);
        fwrite(&power, sizeof power, 1, stdout);
        before = x;
    }
    return 0;
}
";

/// Returns numbers of every magnitude, the boundary values of the functions, multiples of pi/2, and their neighbours.
fn arguments() -> Vec<f64> {
    let at = [
        0.0,
        5e-324,
        2.2250738585072014e-308,
        7.450580596923828e-9,
        0.125,
        0.3,
        0.5,
        1.0,
        std::f64::consts::SQRT_2,
        2.0,
        3.0,
        10.0,
        709.782712893384,
        745.1332191019411,
        9007199254740991.0,
        1.8446744073709552e19,
        1.7e308,
        f64::INFINITY,
        f64::NAN,
    ];
    let halves = (1..200).map(|n| f64::from(n) * std::f64::consts::FRAC_PI_4);
    let near = at.into_iter().chain(halves).flat_map(|it| [it, it.next_up(), it.next_down()]);
    let mut all: Vec<f64> = near.flat_map(|it| [it, -it]).collect();
    let mut seed = 1_u64;
    for n in 0..30_000 {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        let one = (seed >> 11) as f64 / (1_u64 << 53) as f64;
        let scale = [2.0, 20.0, 1500.0, 1e6][n % 4];
        all.push(if n % 5 == 0 { f64::from_bits(seed) } else { (one - 0.5) * scale });
    }
    all
}

#[test]
fn exp_and_its_relatives_give_the_bits_of_the_machine() {
    use crate::ir::Unary;
    let text = format!("{HEAD}{}{FUNCTIONS}", operations::used(FUNCTIONS));
    let arguments = arguments();
    let bytes: Vec<u8> = arguments.iter().flat_map(|it| it.to_le_bytes()).collect();
    let functions =
        [Unary::Exp, Unary::Ln, Unary::Log, Unary::Sin, Unary::Cos, Unary::Tan, Unary::Asin, Unary::Acos, Unary::Atan];
    for level in ["-O0", "-O2"] {
        let Some(written) = in_c(&text, &format!("functions{level}"), level, &bytes) else {
            eprintln!("there is no C compiler: nothing was compared");
            return;
        };
        assert_eq!(written.len(), 84 * arguments.len());
        let mut before = 1.0_f64;
        for (x, written) in arguments.iter().zip(written.chunks(84)) {
            let power = |a: Value, b: Value| Binary::Pow.fold(a, b).unwrap().0;
            let (wide, narrow) = (power(before.into(), (*x).into()), power((before as f32).into(), (*x as f32).into()));
            let results = functions.iter().map(|it| it.fold((*x).into()).unwrap()).chain([wide, narrow]);
            for (number, (result, c)) in results.zip(written.chunks(8)).enumerate() {
                let c = Value::read(result.ty(), c);
                let same = c == result || c.number().is_nan() && result.number().is_nan();
                assert!(
                    same,
                    "function {number} of {x:?} ({before:?} before): {c} in C, {result} in the machine, {level}"
                );
            }
            before = *x;
        }
    }
}
