//! The time of a call of CONT_C as C, relative to its law in Rust: `cargo bench -p laws`. Both run alternately, so that
//! other load on the machine affects both; the median ratio is reported. It should be at most 1.1.

use blocks::{Block, ContC, Law};
use std::process::Command;
use std::time::Instant;

const CALLS: u32 = 2_000_000;
const TURNS: usize = 15;

const MAIN: &str = "
#include <stdio.h>
#include <time.h>
int main(void) {
    call_t call = {0, 1000000, 0, 0, 0, 0, 0};
    memory_t memory;
    struct timespec begin, end;
    int i;
    start(&memory);
    memory.CONT_C.MAN_ON = 0;
    memory.CONT_C.D_SEL = 1;
    restart(&call, &memory);
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (i = 0; i < CALLS; i += 1) {
        memory.CONT_C.SP_INT = (float)(i & 63);
        memory.CONT_C.PV_IN = memory.CONT_C.LMN * 0.5f;
        cycle(&call, &memory);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    printf(\"%.0f %.9g\", (double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec), memory.CONT_C.LMN);
    return 0;
}
";

/// Returns the nanoseconds of all calls, and LMN after the last one.
fn rust() -> (f64, f32) {
    let mut block = ContC { man_on: false, d_sel: true, ..ContC::default() };
    block.restart();
    let begin = Instant::now();
    for i in 0..CALLS {
        block.sp_int = (i & 63) as f32;
        block.pv_in = block.lmn * 0.5;
        std::hint::black_box(&mut block).call();
    }
    (begin.elapsed().as_nanos() as f64, block.lmn)
}

fn main() {
    let law = laws::read(&laws::Sources::of_blocks(), ContC::TABLE.name).unwrap_or_else(|error| panic!("{error}"));
    let folder = std::env::temp_dir().join(format!("plcfmu-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the C");
    let (source, binary) = (folder.join("law.c"), folder.join("law"));
    let head = format!("#define _POSIX_C_SOURCE 199309L\n#define CALLS {CALLS}\n");
    let text = scl::c::print(&law.program).unwrap_or_else(|error| panic!("{error}"));
    std::fs::write(&source, head + &text + MAIN).expect("the C is written");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let compiled = Command::new(&compiler).args(["-std=c99", "-O2"]).arg(&source).arg("-o").arg(&binary).status();
    assert!(compiled.is_ok_and(|status| status.success()), "{compiler} compiles the law");
    let mut ratios = Vec::new();
    for _ in 0..TURNS {
        let (in_rust, lmn) = rust();
        let said = String::from_utf8(Command::new(&binary).output().expect("the law runs").stdout).expect("text");
        let (in_c, found) = said.split_once(' ').expect("a time and a value");
        let (in_c, found): (f64, f32) = (in_c.parse().expect("a time"), found.parse().expect("a value"));
        assert_eq!(found.to_bits(), lmn.to_bits(), "LMN after the last call");
        ratios.push((in_c / in_rust, in_rust / f64::from(CALLS), in_c / f64::from(CALLS)));
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (ratio, in_rust, in_c) = ratios[TURNS / 2];
    println!("CONT_C: {in_rust:.1} ns a call in Rust, {in_c:.1} ns in C ({compiler} -O2): {ratio:.2} times");
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}
