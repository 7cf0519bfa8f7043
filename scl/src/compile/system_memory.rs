//! System and clock memory: bit memory tags written by the CPU, not by the program. TIA Portal uses the same names for
//! them in every project.

use crate::check::compiler::Compiler;
use crate::check::types::Type;
use crate::ir::{At, Binary, Convert, Expr, Place, Scalar, Statement, What};
use parameters::tags::Area;

/// The clocks from bit 0 upwards: name, and half the period in milliseconds.
const CLOCKS: [(&str, i64); 8] = [
    ("CLOCK_10HZ", 50),
    ("CLOCK_5HZ", 100),
    ("CLOCK_2.5HZ", 200),
    ("CLOCK_2HZ", 250),
    ("CLOCK_1.25HZ", 400),
    ("CLOCK_1HZ", 500),
    ("CLOCK_0.625HZ", 800),
    ("CLOCK_0.5HZ", 1000),
];

/// The system memory from bit 0 upwards. Diagnostic events never occur here.
const SYSTEM: [&str; 4] = ["FIRSTSCAN", "DIAGSTATUSUPDATE", "ALWAYSTRUE", "ALWAYSFALSE"];

const CLOCK_BYTE: &str = "CLOCK_BYTE";
const SYSTEM_BYTE: &str = "SYSTEM_BYTE";

/// The address that TIA Portal proposes for a system or clock memory tag, and the tag's type.
pub(crate) fn proposed(name: &str) -> Option<(String, &'static str)> {
    if let Some(bit) = CLOCKS.iter().position(|(of, _)| *of == name) {
        return Some((format!("%M0.{bit}"), "BOOL"));
    }
    match SYSTEM.iter().position(|of| *of == name) {
        Some(bit) => Some((format!("%M1.{bit}"), "BOOL")),
        None if name == CLOCK_BYTE => Some(("%MB0".into(), "BYTE")),
        None if name == SYSTEM_BYTE => Some(("%MB1".into(), "BYTE")),
        None => None,
    }
}

/// The value of a tag in a cycle, as an integer whose low bits are used. A clock starts with FALSE.
fn value(name: &str, is_startup: bool) -> Option<Expr> {
    let binary =
        |operation, one, other| Expr::Binary(operation, Scalar::I64, Box::new(one), Box::new(other), At::default());
    let constant = |value: i64| Expr::Const(value.into());
    let clock = |half: i64| binary(Binary::Div, Expr::Now, constant(half * 1_000_000));
    let bit = |of: Expr, bit: usize| binary(Binary::Mul, binary(Binary::And, of, constant(1)), constant(1 << bit));
    let system = |number: usize| match number {
        0 if is_startup => constant(0),
        0 => {
            let is_first =
                Expr::Binary(Binary::Eq, Scalar::I64, Box::new(Expr::Now), Box::new(constant(0)), At::default());
            Expr::Convert(Convert::Value, Scalar::Bool, Scalar::I64, Box::new(is_first), At::default())
        }
        2 => constant(1),
        _ => constant(0),
    };
    let byte = |bits: Vec<Expr>| {
        let bits = bits.into_iter().enumerate().map(|(number, of)| bit(of, number));
        bits.reduce(|one, other| binary(Binary::Add, one, other))
    };
    match name {
        CLOCK_BYTE => byte(CLOCKS.iter().map(|(_, half)| clock(*half)).collect()),
        SYSTEM_BYTE => byte((0..SYSTEM.len()).map(system).collect()),
        _ => match CLOCKS.iter().find(|(clock, _)| *clock == name) {
            Some((_, half)) => Some(clock(*half)),
            None => SYSTEM.iter().position(|of| *of == name).map(system),
        },
    }
}

/// A tag that the CPU writes: its upper-case name, its place and its type.
pub struct SystemTag {
    name: &'static str,
    place: Place,
    of: Scalar,
}

impl SystemTag {
    /// The statement that writes it, as the CPU does before each cycle.
    pub fn write(&self, is_startup: bool) -> Option<Statement> {
        let value = Box::new(value(self.name, is_startup)?);
        let value = Expr::Convert(Convert::Value, Scalar::I64, self.of, value, At::default());
        Some(Statement { at: At::default(), what: What::Assign(self.place.clone(), value) })
    }
}

impl Compiler<'_> {
    /// The tags of system and clock memory that the program uses and does not write itself.
    pub fn system_tags(&self) -> Vec<SystemTag> {
        let written = crate::compile::interface::written(self);
        let names = CLOCKS.iter().map(|(name, _)| *name).chain(SYSTEM).chain([CLOCK_BYTE, SYSTEM_BYTE]);
        let tag = |name: &'static str| {
            let global = self.globals.get(name)?.known()?;
            let Type::Elementary(of) = global.of else { return None };
            let is_memory = matches!(self.tag(name), Some((Some(Area::Memory), _)));
            let bits = if name.ends_with("_BYTE") { 8 } else { 1 };
            let offset = self.program.records[self.program.memory].members[global.member].offset;
            let is_it = is_memory && of.bits() == bits && !written.contains(offset);
            is_it.then(|| SystemTag { name, place: global.place(), of: of.scalar() })
        };
        names.filter_map(tag).collect()
    }
}
