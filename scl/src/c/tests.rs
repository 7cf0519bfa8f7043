//! Random programs give the same bits as C and in the machine.

use super::print;
use crate::machine::tests::random::Random;
use crate::machine::{Cause, Code, Machine};
use crate::program::{Program, Scalar, Type, Value};
use std::fmt::Write;
use std::process::Command;
use std::sync::Arc;

/// The calls of each program.
const CALLS: i64 = 4;

/// The statements of each call: some programs do not end before.
const BUDGET: u32 = 3000;

/// Programs in a run of the test; `PLCFMU_PROGRAMS` makes more.
fn programs() -> u64 {
    std::env::var("PLCFMU_PROGRAMS").map_or(12, |programs| programs.parse().expect("PLCFMU_PROGRAMS is a number"))
}

/// What a host adds to a program: it makes the calls and shows the memory after each, and where a call was stopped.
const MAIN: &str = "
#include <stdio.h>
int main(void) {
    memory_t memory, before;
    start(&memory);
    for (int call_number = 0; call_number < CALLS; call_number += 1) {
        call_t call = {call_number * (i64_t)100000000, BUDGET, 0, 0, 0, 0, 0};
        before = memory;
        f0(&call, &memory);
        if (call.stopped != 0) {
            memory = before;
        }
        printf(\"%ld \", (long)call.stopped);
        for (size_t i = 0; i < sizeof memory; i += 1) {
            printf(\"%02x\", ((const unsigned char *)&memory)[i]);
        }
        printf(\"\\n\");
    }
    return 0;
}
";

/// The line at which each call was stopped, or 0, and the memory after it; and whether the budget stopped one.
fn in_machine(program: &Program) -> (Vec<(u32, Vec<u8>)>, bool) {
    let mut machine = Machine::new(Arc::new(Code::compile(program).unwrap()));
    machine.budget = BUDGET;
    let mut is_budget = false;
    let calls = (0..CALLS).map(|call| {
        let line = match machine.call(0, call * 100_000_000) {
            Ok(()) => 0,
            Err(stop) => {
                is_budget |= matches!(stop.cause, Cause::Budget(_));
                stop.line
            }
        };
        (line, machine.state().to_vec())
    });
    (calls.collect(), is_budget)
}

/// The same of the printed program; `None` if there is no compiler.
fn in_c(program: &Program, name: &str, level: &str) -> Option<Vec<(u32, Vec<u8>)>> {
    let folder = std::env::temp_dir().join(format!("plcfmu-c-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (source, binary) = (folder.join("program.c"), folder.join("program"));
    let text = format!("#define CALLS {CALLS}\n#define BUDGET {BUDGET}\n{}{MAIN}", print(program).unwrap());
    std::fs::write(&source, &text).unwrap();
    // What a random program calculates may be of no use.
    let useless = ["-Wno-type-limits", "-Wno-tautological-compare", "-Wno-self-assign"];
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
    assert!(compiled.status.success(), "{}:\n{}", source.display(), String::from_utf8_lossy(&compiled.stderr));
    let output = Command::new(&binary).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let lines = String::from_utf8(output.stdout).unwrap();
    let calls = lines.lines().map(|line| {
        let (stopped, memory) = line.split_once(' ').unwrap();
        let byte = |index: usize| u8::from_str_radix(&memory[2 * index..2 * index + 2], 16).unwrap();
        (stopped.parse().unwrap(), (0..memory.len() / 2).map(byte).collect())
    });
    Some(calls.collect())
}

/// What differs in two variables; what is not a number is the same whatever its bits are.
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

#[test]
fn printed_programs_give_the_bits_of_the_machine() {
    let mut stopped_by_budget = 0;
    for seed in 1..=programs() {
        let program = Random::program(seed * 7919, 0, true);
        let (in_machine, is_budget) = in_machine(&program);
        stopped_by_budget += u64::from(is_budget);
        let level = ["-O0", "-O2"][(seed % 2) as usize];
        let Some(in_c) = in_c(&program, &seed.to_string(), level) else {
            eprintln!("there is no C compiler: nothing was compared");
            return;
        };
        assert_eq!(in_c.len(), in_machine.len());
        for (call, ((stopped_c, c), (stopped, machine))) in in_c.iter().zip(&in_machine).enumerate() {
            let mut found = String::new();
            differences(&program, &Type::Record(program.memory), "memory", (c, machine), &mut found);
            assert!(
                stopped_c == stopped && found.is_empty(),
                "seed {seed}, call {call}, stopped at {stopped_c} in C, at {stopped} in the machine:\n{found}"
            );
        }
    }
    assert!(stopped_by_budget > 0, "no program was stopped by its budget");
}
