//! How a PLC program is built from its sources: one type shared by command options, loop descriptions, messages of the
//! parameter tool and FMU resources.
//!
//! - `written`: the serde form used in loops and messages; keys are named after the options of `plcfmu build`.
//! - `text`: the `KEY = VALUE` lines in an FMU's resources, on which its GUID is based.

mod text;
#[cfg(feature = "serde")]
mod written;

use parameters::literal;
use parameters::tags::{self, Declared, Tag};
use std::path::PathBuf;
pub use text::FILE;

/// The CPU whose rules apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cpu {
    /// S7-300 and S7-400.
    S7300,
    /// S7-1200.
    S71200,
    /// S7-1500.
    S71500,
}

/// The CPUs by name.
const CPUS: [(&str, Cpu); 4] = [("300", Cpu::S7300), ("400", Cpu::S7300), ("1200", Cpu::S71200), ("1500", Cpu::S71500)];

impl Cpu {
    /// The name of its family: `300` also for S7-400.
    pub fn name(self) -> &'static str {
        CPUS.iter().find(|(_, cpu)| *cpu == self).map_or("", |(name, _)| name)
    }
}

impl std::str::FromStr for Cpu {
    type Err = String;

    fn from_str(text: &str) -> Result<Cpu, String> {
        let found = CPUS.iter().find(|(name, _)| *name == text);
        found.map(|(_, cpu)| *cpu).ok_or_else(|| format!("the CPU must be 300, 400, 1200 or 1500, not {text:?}"))
    }
}

/// How a program is built from its sources.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct Manifest {
    /// The name of the FMU, a C identifier; by default the name of the block.
    pub name: Option<String>,
    /// The sources, in order; in the resources of an FMU, the names of files in the same folder.
    #[cfg_attr(feature = "typescript", ts(skip))]
    pub sources: Vec<PathBuf>,
    /// The time between two calls in milliseconds, at least 1: a number of seconds in a message, a string with a unit
    /// in a file. Required for an FMU.
    pub cycle: Option<u32>,
    /// The block to run, or its instance data block; by default the block that no other block uses.
    #[cfg_attr(feature = "typescript", ts(rename = "run"))]
    pub block: Option<String>,
    /// The CPU, `300`, `1200` or `1500`; by default the one implied by the sources' dialect.
    #[cfg_attr(feature = "typescript", ts(as = "Option<String>"))]
    pub cpu: Option<Cpu>,
    /// The maximum number of statements per call; one million by default.
    pub budget: Option<u32>,
    /// Inputs to expose as tunable parameters.
    pub parameters: Vec<String>,
    /// Parameters and locals to expose as inputs.
    pub inputs: Vec<String>,
    /// Locals to expose as outputs.
    pub outputs: Vec<String>,
    /// The calls to make instead of running a single block: organization blocks, functions, instances.
    #[cfg_attr(feature = "typescript", ts(skip))]
    pub calls: Vec<Task>,
    /// Names that no source declares, and their types: PLC tags and instances. The first entry for a name wins.
    #[cfg_attr(feature = "typescript", ts(rename = "tags", as = "Vec<(String, String)>"))]
    pub declared: Vec<Tag>,
    /// Constants that no source declares, and their values as literals.
    pub constants: Vec<(String, String)>,
    /// Blocks reduced to their interface: their inputs become outputs, and their outputs inputs.
    #[cfg_attr(feature = "typescript", ts(skip))]
    pub stubs: Vec<String>,
}

/// A periodic call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// The name of the organization block, function, function block or instance data block.
    pub name: String,
    /// The time between two calls in ms; 0 for every cycle.
    pub period: u32,
}

impl Manifest {
    /// Sets the calls and their periods: one period for all, or one for each in order. The cycle becomes the greatest
    /// common divisor of the periods; without periods, it is left unset.
    ///
    /// # Errors
    /// There is more than one period, but not one for each call.
    pub fn set_calls(&mut self, calls: Vec<String>, cycles: &[u32]) -> Result<(), String> {
        if cycles.len() > 1 && cycles.len() != calls.len() {
            return Err(format!(
                "the numbers of cycles ({}) and calls ({}) differ: specify one for all calls, or one for each, \
                 in order",
                cycles.len(),
                calls.len()
            ));
        }
        let divisor = |mut one: u32, mut other: u32| {
            while other > 0 {
                (one, other) = (other, one % other);
            }
            one
        };
        self.cycle = cycles.iter().copied().reduce(divisor);
        let periods = cycles.iter().map(|of| if Some(*of) == self.cycle { 0 } else { *of });
        let tasks = calls.into_iter().zip(periods.chain(std::iter::repeat(0)));
        self.calls = tasks.map(|(name, period)| Task { name, period }).collect();
        Ok(())
    }

    /// Whether it has only sources and no other entries.
    pub fn is_bare(&self) -> bool {
        *self == Manifest { sources: self.sources.clone(), ..Manifest::default() }
    }
}

/// Parses a duration such as `100ms`, `0.5s` or `1m30s`; returns milliseconds.
///
/// # Errors
/// The string is not a duration, not a whole number of milliseconds, shorter than 1 ms or longer than 24 days.
pub fn milliseconds(text: &str) -> Result<u32, String> {
    let nanoseconds =
        literal::duration(text, 1).map_err(|_| format!("{text:?} is not a duration: write 2s, 100ms or 1m30s"))?;
    let milliseconds = i32::try_from(nanoseconds / 1_000_000).ok().filter(|time| *time >= 1);
    let milliseconds = milliseconds.filter(|_| nanoseconds % 1_000_000 == 0);
    let milliseconds = milliseconds.map(i32::unsigned_abs);
    milliseconds.ok_or_else(|| {
        format!(
            "{text:?} is not a valid time between two calls: \
             write a whole number of milliseconds, at least 1, such as 100ms, 0.5s or 2s"
        )
    })
}

/// Parses a tag: `Start : Bool`, `"Level" AT %IW64 : Int // unit: mm`.
///
/// # Errors
/// The string is not a tag, or is a constant.
pub fn tag(text: &str) -> Result<Tag, String> {
    match tags::declaration(text) {
        Ok(Declared::Tag(tag)) => Ok(tag),
        Ok(Declared::Constant(constant)) => {
            Err(format!("{text:?}: {} has a value: declare it as a constant", constant.name))
        }
        Err(wrong) => Err(format!("{text:?}: {wrong}")),
    }
}

/// Parses a name and its type: `Start : Bool`.
///
/// # Errors
/// One of the two is missing.
pub fn declaration(text: &str) -> Result<(String, String), String> {
    halves(text, ':').ok_or_else(|| format!("{text:?}: write a name, a colon and a type, such as Start : Bool"))
}

/// Parses a name and its value: `MAX=5`.
///
/// # Errors
/// One of the two is missing.
pub fn constant(text: &str) -> Result<(String, String), String> {
    halves(text, '=').ok_or_else(|| format!("{text:?}: write a name, an equals sign and a value, such as MAX=5"))
}

fn halves(text: &str, between: char) -> Option<(String, String)> {
    let (name, value) = text.split_once(between)?;
    let half = |half: &str| unquoted(half).to_string();
    Some((half(name), half(value))).filter(|(name, value)| !name.is_empty() && !value.is_empty())
}

/// A name without surrounding blanks and quotation marks.
pub fn unquoted(name: &str) -> &str {
    name.trim().trim_matches('"')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_have_quotation_marks_and_both_halves_are_there() {
        assert_eq!(declaration("\"Start\" : Bool"), Ok(("Start".into(), "Bool".into())));
        assert_eq!(constant("MAX = 5"), Ok(("MAX".into(), "5".into())));
        assert!(declaration("Start").is_err() && constant("=5").is_err());
    }

    #[test]
    fn a_time_between_two_calls_is_in_whole_milliseconds() {
        assert_eq!((milliseconds("0.5s"), milliseconds("1m30s")), (Ok(500), Ok(90_000)));
        for wrong in ["", "10", "0ms", "1.5ms", "30d"] {
            assert!(milliseconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_cycle_is_the_greatest_common_divisor_of_the_periods() {
        let mut manifest = Manifest::default();
        let names = || vec!["Fast".to_string(), "Slow".to_string()];
        let task = |name: &str, period| Task { name: name.into(), period };
        manifest.set_calls(names(), &[4, 6]).unwrap();
        assert_eq!((manifest.cycle, &manifest.calls[..]), (Some(2), &[task("Fast", 4), task("Slow", 6)][..]));
        manifest.set_calls(names(), &[10, 20]).unwrap();
        assert_eq!((manifest.cycle, &manifest.calls[..]), (Some(10), &[task("Fast", 0), task("Slow", 20)][..]));
        manifest.set_calls(names(), &[50]).unwrap();
        assert_eq!((manifest.cycle, &manifest.calls[..]), (Some(50), &[task("Fast", 0), task("Slow", 0)][..]));
        let wrong = manifest.set_calls(names(), &[1, 2, 3]).unwrap_err();
        assert_eq!(
            wrong,
            "the numbers of cycles (3) and calls (2) differ: specify one for all calls, or one for each, in order"
        );
        assert!(manifest.set_calls(Vec::new(), &[1, 2]).is_err());
    }
}
