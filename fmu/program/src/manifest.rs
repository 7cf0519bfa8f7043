//! What is made of the sources in an FMU: a text of lines `KEY = VALUE`.

use scl::Cpu;
use std::fmt;

/// The file in the resources.
pub const FILE: &str = "program.txt";

/// What the first line says.
const FIRST: &str = "plcfmu program 1";

/// How a program is made of its sources.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifest {
    /// The name of the FMU, an identifier of C; that of the block without it.
    pub name: Option<String>,
    /// The files in the resources, in order.
    pub sources: Vec<String>,
    /// The time between two calls in milliseconds, at least 1.
    pub cycle: u32,
    /// The block that becomes the program; the one that no other block uses without it.
    pub block: Option<String>,
    /// The CPU; that of the sources' dialect without it.
    pub cpu: Option<Cpu>,
    /// The most statements in a call; a million without it.
    pub budget: Option<u32>,
    /// Inputs that are tunable parameters.
    pub parameters: Vec<String>,
    /// Parameters and locals that are inputs.
    pub inputs: Vec<String>,
    /// Locals that are outputs.
    pub outputs: Vec<String>,
    /// What is called in place of one block, and the time between two calls in milliseconds; 0 for every cycle.
    pub calls: Vec<(String, u32)>,
    /// Names that no source declares, with their types.
    pub declared: Vec<(String, String)>,
    /// Constants that no source declares, with their values.
    pub constants: Vec<(String, String)>,
}

/// The CPUs by name.
pub const CPUS: [(&str, Cpu); 3] = [("300", Cpu::S7300), ("1200", Cpu::S71200), ("1500", Cpu::S71500)];

impl Manifest {
    /// Reads the text that [`fmt::Display`] writes.
    ///
    /// # Errors
    /// The line that is not one of such a text.
    pub fn parse(text: &str) -> Result<Manifest, String> {
        let mut lines = text.lines();
        if lines.next() != Some(FIRST) {
            return Err(format!("its first line is not {FIRST:?}"));
        }
        let mut manifest = Manifest::default();
        for line in lines {
            let wrong = || format!("the line {line:?} does not belong to a program");
            let (key, value) = line.split_once(" = ").ok_or_else(wrong)?;
            let pair =
                || value.split_once(" : ").map(|(name, of)| (name.to_string(), of.to_string())).ok_or_else(wrong);
            let number = || value.parse().map_err(|_| wrong());
            match key {
                "name" => manifest.name = Some(value.into()),
                // Only files beside this one are read.
                "source" if !value.contains(['/', '\\', ':']) && !value.starts_with('.') => {
                    manifest.sources.push(value.into());
                }
                "cycle" => manifest.cycle = number()?,
                "block" => manifest.block = Some(value.into()),
                "cpu" => {
                    let named = CPUS.iter().find(|(name, _)| *name == value);
                    manifest.cpu = Some(named.ok_or_else(wrong)?.1);
                }
                "budget" => manifest.budget = Some(number()?),
                "parameter" => manifest.parameters.push(value.into()),
                "input" => manifest.inputs.push(value.into()),
                "output" => manifest.outputs.push(value.into()),
                "call" => {
                    let (name, period) = value.rsplit_once(" : ").ok_or_else(wrong)?;
                    manifest.calls.push((name.into(), period.parse().map_err(|_| wrong())?));
                }
                "tag" => manifest.declared.push(pair()?),
                "constant" => manifest.constants.push(pair()?),
                _ => return Err(wrong()),
            }
        }
        match manifest {
            Manifest { cycle: 0, .. } => Err("it has no time between two calls".into()),
            Manifest { cycle, .. } if i32::try_from(cycle).is_err() => Err(format!("cycle = {cycle}: too long")),
            manifest => Ok(manifest),
        }
    }
}

impl fmt::Display for Manifest {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        writeln!(formatter, "{FIRST}")?;
        let mut line = |key: &str, value: &dyn fmt::Display| writeln!(formatter, "{key} = {value}");
        self.name.iter().try_for_each(|name| line("name", name))?;
        self.sources.iter().try_for_each(|source| line("source", source))?;
        line("cycle", &self.cycle)?;
        self.block.iter().try_for_each(|block| line("block", block))?;
        let cpu = CPUS.iter().find(|(_, cpu)| Some(*cpu) == self.cpu);
        cpu.iter().try_for_each(|(name, _)| line("cpu", name))?;
        self.budget.iter().try_for_each(|budget| line("budget", budget))?;
        self.parameters.iter().try_for_each(|name| line("parameter", name))?;
        self.inputs.iter().try_for_each(|name| line("input", name))?;
        self.outputs.iter().try_for_each(|name| line("output", name))?;
        let mut calls = self.calls.iter();
        calls.try_for_each(|(name, period)| line("call", &format_args!("{name} : {period}")))?;
        self.declared.iter().try_for_each(|(name, of)| line("tag", &format_args!("{name} : {of}")))?;
        self.constants.iter().try_for_each(|(name, value)| line("constant", &format_args!("{name} : {value}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_reads_back_and_a_line_of_none_is_refused() {
        let manifest = Manifest {
            name: Some("PUMP".into()),
            sources: vec!["pump.scl".into(), "types.udt".into()],
            cycle: 100,
            block: Some("Pump".into()),
            cpu: Some(Cpu::S71200),
            budget: Some(5000),
            parameters: vec!["limit".into()],
            inputs: vec!["setpoint".into()],
            outputs: vec!["Plant.level".into()],
            calls: vec![("Main".into(), 0), ("Cyclic : 2".into(), 500)],
            declared: vec![("Start".into(), "Bool".into())],
            constants: vec![("MAX".into(), "5".into())],
        };
        assert_eq!(Manifest::parse(&manifest.to_string()), Ok(manifest.clone()));
        let wrong = |from: &str, to: &str| Manifest::parse(&manifest.to_string().replace(from, to)).unwrap_err();
        assert_eq!(wrong("pump.scl", "../pump.scl"), "the line \"source = ../pump.scl\" does not belong to a program");
        assert_eq!(wrong("cycle = 100\n", ""), "it has no time between two calls");
        assert!(wrong("program 1", "program 2").contains("first line"));
    }
}
