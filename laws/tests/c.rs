//! The laws as C have the same bits as the typed programs, with all installed compilers, and compile without warnings.

#![allow(clippy::unwrap_used)]

use blocks::{Block, EachBlock, Kind, for_each_block};
use laws::{Law, Sources};
use scl::ir::{Program, Scalar, Type, Value};
use scl::machine::{Code, Machine};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

/// Reads the number of a function and the memory before its call, and writes the memory after it, until the end of the
/// input.
const MAIN: &str = "
#include <stdio.h>
int main(void) {
    int which;
    while ((which = getchar()) != EOF) {
        call_t call = {0, 1000000, 0, 0, 0, 0, 0};
        memory_t memory;
        start(&memory);
        if (which != 2 && fread(&memory, sizeof memory, 1, stdin) != 1) {
            return 1;
        }
        if (which == 0) {
            restart(&call, &memory);
        } else if (which == 1) {
            cycle(&call, &memory);
        }
        fwrite(&memory, sizeof memory, 1, stdout);
    }
    return 0;
}
";

/// Compilers with their options; those not installed are skipped, but at least one must be.
const COMPILERS: [(&str, &[&str]); 7] = [
    ("gcc", &["-std=c99", "-O0", "-x", "c"]),
    ("gcc", &["-std=gnu99", "-O2", "-march=native", "-x", "c"]),
    ("gcc", &["-std=c++11", "-O2", "-x", "c++"]),
    ("clang", &["-std=c99", "-O0", "-x", "c"]),
    ("clang", &["-std=c99", "-O2", "-march=native", "-x", "c"]),
    ("clang", &["-std=c++11", "-O2", "-x", "c++"]),
    ("x86_64-w64-mingw32-gcc", &["-std=c99", "-O2", "-x", "c", "-c"]),
];

const WARNINGS: [&str; 5] = ["-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"];

struct Random(u64);

impl Random {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % count
    }

    fn bits(&mut self, kind: Kind) -> u64 {
        const ODD: [f32; 8] = [f32::NAN, f32::INFINITY, -0.0, 1e-45, f32::MAX, f32::MIN, 3e9, -2.5];
        match (kind, self.below(8)) {
            (Kind::Real, 0) => u64::from(ODD[self.below(8) as usize].to_bits()),
            (Kind::Real, _) => u64::from((self.below(20_000) as f32 / 50.0 - 150.0).to_bits()),
            (Kind::Time, 0) => self.below(1 << 32),
            (Kind::Time, _) => self.below(30_000),
            (Kind::Bool, _) => self.below(2),
            (Kind::Int, 1..) => self.below(50),
            _ => self.below(1 << 16),
        }
    }
}

/// Returns the memory before and after each call, computed by the machine.
fn tape<B: Block>(law: &Law, calls: usize) -> (Vec<u8>, Vec<u8>) {
    let mut machine = Machine::new(Arc::new(Code::compile(&law.program).unwrap()));
    let mut random = Random(7);
    let (mut before, mut after) = (vec![2], machine.state().to_vec());
    let mut settable = Vec::new();
    for row in B::TABLE.rows.iter().filter(|row| row.role.is_settable()) {
        match law.program.find(&format!("{}.{}", law.name, row.name)) {
            Some((offset, Type::Scalar(ty))) => settable.push((row, offset, ty)),
            other => panic!("{}: {other:?}", row.name),
        }
    }
    for call in 0..calls {
        for (row, offset, ty) in &settable {
            if random.below(10) == 0 {
                let is_rare = row.name.ends_with("COM_RST") && random.below(10) > 0;
                let bits = if is_rare { 0 } else { random.bits(row.kind) };
                machine.set(Value::new(*ty, bits), *offset);
            }
        }
        let restarts = call % 500 == 0;
        before.push(u8::from(!restarts));
        before.extend(machine.state());
        machine.call(if restarts { law.restart } else { law.call }, 0).unwrap();
        after.extend(machine.state());
    }
    (before, after)
}

/// Collects differences; all NaNs are equal, and padding between members is ignored.
fn differences(program: &Program, ty: &Type, path: &str, c: &[u8], machine: &[u8], found: &mut Vec<String>) {
    match ty {
        Type::Scalar(ty) => {
            let (c, machine) = (Value::read(*ty, c), Value::read(*ty, machine));
            let both_nan = matches!(ty, Scalar::F32 | Scalar::F64) && c.number().is_nan() && machine.number().is_nan();
            if c != machine && !both_nan {
                found.push(format!("{path} is {c} in C, {machine} in the machine"));
            }
        }
        Type::Record(record) => {
            for member in &program.records[*record].members {
                let path = format!("{path}.{}", member.name);
                differences(program, &member.ty, &path, &c[member.offset..], &machine[member.offset..], found);
            }
        }
        Type::Array { of, .. } => {
            let size = program.size(of);
            for index in 0..program.size(ty) / size {
                let path = format!("{path}[{index}]");
                differences(program, of, &path, &c[index * size..], &machine[index * size..], found);
            }
        }
        other => panic!("{other:?}"),
    }
}

struct Compare {
    folder: std::path::PathBuf,
    blocks: usize,
}

impl EachBlock for Compare {
    fn block<B: Block>(&mut self) {
        let law = laws::read(&Sources::of_blocks(), B::TABLE.name).unwrap_or_else(|error| panic!("{error}"));
        let (before, after) = tape::<B>(&law, 5000);
        let text = format!("{}{MAIN}", scl::c::print(&law.program).unwrap());
        let source = self.folder.join(format!("{}.c", law.name));
        std::fs::write(&source, text).unwrap();
        compare(&law.name, &law.program, &source, (&before, &after));
        self.blocks += 1;
    }
}

/// Compares the memory after each call of the C code with the expected memory, for all installed compilers.
fn compare(name: &str, program: &Program, source: &Path, (before, after): (&[u8], &[u8])) {
    let mut compared = 0;
    for (compiler, options) in COMPILERS {
        let Some(binary) = compiled(compiler, options, source) else { continue };
        compared += 1;
        if compiler.contains("mingw") {
            continue;
        }
        let memory = program.records[program.memory].start.len();
        let found = given(&binary, before);
        assert_eq!(found.len(), after.len(), "{name} with {compiler} {options:?}");
        for (call, (c, machine)) in found.chunks(memory).zip(after.chunks(memory)).enumerate() {
            let mut differ = Vec::new();
            differences(program, &Type::Record(program.memory), "", c, machine, &mut differ);
            assert!(differ.is_empty(), "{name} with {compiler} {options:?}, call {call}: {differ:?}");
        }
    }
    if compared == 0 {
        eprintln!("there is no C compiler: {name} was not compared");
    }
}

/// Compiles a source; `None` if the compiler is not installed.
fn compiled(compiler: &str, options: &[&str], source: &Path) -> Option<std::path::PathBuf> {
    let binary = source.with_extension("bin");
    let mut command = Command::new(compiler);
    command.args(options).args(WARNINGS).arg(source).arg("-o").arg(&binary);
    let output = command.output().ok()?;
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{compiler} {options:?}\n{said}");
    Some(binary)
}

/// Returns the output of a program for this input.
fn given(binary: &Path, input: &[u8]) -> Vec<u8> {
    let mut child = Command::new(binary).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(move || stdin.write_all(input).unwrap());
        child.wait_with_output().unwrap().stdout
    })
}

#[test]
fn laws_in_c_give_the_same_bits_with_every_compiler_and_no_warning() {
    let folder = std::env::temp_dir().join(format!("plcfmu-laws-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut compare = Compare { folder, blocks: 0 };
    for_each_block(&mut compare);
    assert!(compare.blocks >= 5);
    std::fs::remove_dir_all(&compare.folder).unwrap();
}

#[test]
fn an_engineer_finds_the_clauses_of_the_manual_page_in_the_c() {
    struct Clauses;
    impl EachBlock for Clauses {
        fn block<B: Block>(&mut self) {
            let law = laws::read(&Sources::of_blocks(), B::TABLE.name).unwrap();
            let text = scl::c::print(&law.program).unwrap();
            let (head, code) = text.split_once("#include").unwrap();
            assert!(head.contains(&format!("{}: ", law.name)) && head.contains(" * 1. "), "{head}");
            assert!(head.contains("algorithm is written in blocks/src/"), "{head}");
            assert!(head.contains(" *   manual: the vendor's manual of this block"), "{head}");
            assert!(code.to_lowercase().contains("clause"), "no clause in the code of {}", law.name);
        }
    }
    for_each_block(&mut Clauses);
    let law = laws::read(&Sources::of_blocks(), "CONT_C").unwrap();
    let text = scl::c::print(&law.program).unwrap();
    let behind = text.split("Clause 6. */").nth(1).unwrap().trim_start();
    let trapezoid = "float q = (((t / ti) * (e + self->memory.e)) * 0.5f) + self->memory.rest;";
    assert!(behind.starts_with(trapezoid), "{behind}");
}

/// Every block as an instance, after a BOOL and in an array, so that no number is aligned to its size; and a loop, so
/// that statements are counted, which those of a block are not.
fn program_of_instances() -> (Program, usize, String) {
    struct Instances(String, String, String);
    impl EachBlock for Instances {
        fn block<B: Block>(&mut self) {
            let name = B::TABLE.name;
            self.0 += &format!("odd_{name} : Bool; it_{name} : {name}; many_{name} : Array[0..1] of {name};\n");
            for row in B::TABLE.rows.iter().filter(|row| row.role == blocks::Role::Output) {
                let (output, kind) = (row.name, row.kind.name());
                self.2 += &format!("{output}_{name} : {kind};\n");
                self.1 += &format!("#{output}_{name} := #it_{name}.{output};\n");
            }
            self.1 += &format!("#it_{name}();\nFOR #i := 0 TO 1 DO #many_{name}[#i](); END_FOR;\n");
        }
    }
    let mut instances = Instances(String::new(), String::new(), String::new());
    for_each_block(&mut instances);
    let Instances(members, calls, outputs) = instances;
    let source = format!(
        "FUNCTION_BLOCK \"Plant\"\nVAR_OUTPUT {outputs} END_VAR\nVAR {members} i : Int; END_VAR\nBEGIN\n{calls}END_FUNCTION_BLOCK"
    );
    let sources = [parameters::Source::new("plant.scl", source.into_bytes())];
    let compiled = scl::compile(&sources, &scl::Options::default()).unwrap_or_else(|errors| panic!("{}", errors[0]));
    let root = compiled.root.unwrap();
    (compiled.program, root.cycle, root.instance)
}

#[test]
fn blocks_as_instances_in_a_program_give_the_same_bits_in_c() {
    struct Settable(String, Vec<(String, Kind)>);
    impl EachBlock for Settable {
        fn block<B: Block>(&mut self) {
            let name = B::TABLE.name;
            for row in B::TABLE.rows.iter().filter(|row| row.role.is_settable() && !row.name.ends_with("COM_RST")) {
                for instance in [format!("it_{name}"), format!("many_{name}[1]")] {
                    self.1.push((format!("{}.{instance}.{}", self.0, row.name), row.kind));
                }
            }
        }
    }
    let (program, cycle, instance) = program_of_instances();
    let mut settable = Settable(instance, Vec::new());
    for_each_block(&mut settable);
    assert_eq!(scl::c::print(&program).unwrap_err(), "CONT_C cannot be printed as C");
    let linked = laws::with_laws(&program).unwrap();
    let mut machine = Machine::new(Arc::new(Code::compile(&program).unwrap()));
    let mut random = Random(11);
    let (mut before, mut after) = (vec![2], machine.state().to_vec());
    for _ in 0..2000 {
        for (path, kind) in &settable.1 {
            // The path of a member may lead through an array element.
            if random.below(10) == 0
                && let Some((offset, Type::Scalar(ty))) = program.find(path)
            {
                machine.set(Value::new(ty, random.bits(*kind)), offset);
            }
        }
        before.push(1);
        before.extend(machine.state());
        machine.call(cycle, 0).unwrap();
        after.extend(machine.state());
    }
    let moved = machine.state().iter().zip(&after[..]).filter(|(last, first)| last != first).count();
    assert!(moved > 200, "{moved} bytes have changed");
    let folder = std::env::temp_dir().join(format!("plcfmu-instances-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let source = folder.join("plant.c");
    let main =
        MAIN.replace("restart(&call, &memory);", "").replace("cycle(", &format!("{}(", scl::c::name(&linked, cycle)));
    std::fs::write(&source, scl::c::print(&linked).unwrap() + &main).unwrap();
    compare("Plant", &program, &source, (&before, &after));
    std::fs::remove_dir_all(&folder).unwrap();
}
