//! The `KEY = VALUE` lines in the resources of an FMU.

use crate::{Manifest, Task, tag};
use std::fmt;

/// The name of the file in the resources.
pub const FILE: &str = "program.txt";

/// Its first line.
const FIRST: &str = "plcfmu program 1";

impl Manifest {
    /// Reads the text that [`fmt::Display`] writes.
    ///
    /// # Errors
    /// A line does not belong to such a text, or the time between two calls is missing or too long.
    pub fn parse(text: &str) -> Result<Manifest, String> {
        let mut lines = text.lines();
        if lines.next() != Some(FIRST) {
            return Err(format!("the first line is not {FIRST:?}"));
        }
        let mut manifest = Manifest::default();
        for line in lines {
            let wrong = || format!("unexpected line {line:?}");
            let (key, value) = line.split_once(" = ").ok_or_else(wrong)?;
            let pair =
                || value.split_once(" : ").map(|(name, of)| (name.to_string(), of.to_string())).ok_or_else(wrong);
            let number = || value.parse().map_err(|_| wrong());
            match key {
                "name" => manifest.name = Some(value.into()),
                // Only files in the same folder are read.
                "source" if !value.contains(['/', '\\', ':']) && !value.starts_with('.') => {
                    manifest.sources.push(value.into());
                }
                "cycle" => manifest.cycle = Some(number()?),
                "block" => manifest.block = Some(value.into()),
                "cpu" => manifest.cpu = Some(value.parse().map_err(|_| wrong())?),
                "budget" => manifest.budget = Some(number()?),
                "parameter" => manifest.parameters.push(value.into()),
                "input" => manifest.inputs.push(value.into()),
                "output" => manifest.outputs.push(value.into()),
                "call" => {
                    let (name, period) = value.rsplit_once(" : ").ok_or_else(wrong)?;
                    let period = period.parse().map_err(|_| wrong())?;
                    manifest.calls.push(Task { name: name.into(), period });
                }
                "tag" => manifest.declared.push(tag(value).map_err(|_| wrong())?),
                "stub" => manifest.stubs.push(value.into()),
                "constant" => manifest.constants.push(pair()?),
                _ => return Err(wrong()),
            }
        }
        match manifest.cycle {
            None | Some(0) => Err("the time between two calls is missing".into()),
            Some(cycle) if i32::try_from(cycle).is_err() => Err(format!("cycle = {cycle}: the limit is 2147483647 ms")),
            Some(_) => Ok(manifest),
        }
    }
}

impl fmt::Display for Manifest {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        writeln!(formatter, "{FIRST}")?;
        let mut line = |key: &str, value: &dyn fmt::Display| writeln!(formatter, "{key} = {value}");
        self.name.iter().try_for_each(|name| line("name", name))?;
        self.sources.iter().try_for_each(|source| line("source", &source.display()))?;
        self.cycle.iter().try_for_each(|cycle| line("cycle", cycle))?;
        self.block.iter().try_for_each(|block| line("block", block))?;
        self.cpu.iter().try_for_each(|cpu| line("cpu", &cpu.name()))?;
        self.budget.iter().try_for_each(|budget| line("budget", budget))?;
        self.parameters.iter().try_for_each(|name| line("parameter", name))?;
        self.inputs.iter().try_for_each(|name| line("input", name))?;
        self.outputs.iter().try_for_each(|name| line("output", name))?;
        let mut calls = self.calls.iter();
        calls.try_for_each(|task| line("call", &format_args!("{} : {}", task.name, task.period)))?;
        self.declared.iter().try_for_each(|tag| line("tag", tag))?;
        self.stubs.iter().try_for_each(|name| line("stub", name))?;
        self.constants.iter().try_for_each(|(name, value)| line("constant", &format_args!("{name} : {value}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cpu;

    #[test]
    fn the_text_reads_back_and_a_line_of_none_is_refused() {
        let manifest = Manifest {
            name: Some("PUMP".into()),
            sources: vec!["pump.scl".into(), "types.udt".into()],
            cycle: Some(100),
            block: Some("Pump".into()),
            cpu: Some(Cpu::S71200),
            budget: Some(5000),
            parameters: vec!["limit".into()],
            inputs: vec!["setpoint".into()],
            outputs: vec!["Plant.level".into()],
            calls: [("Main", 0), ("Cyclic : 2", 500)].map(|(name, period)| Task { name: name.into(), period }).into(),
            declared: vec![tag("\"Start : 1\" AT %I0.0 : Bool // Start button").unwrap()],
            constants: vec![("MAX".into(), "5".into())],
            stubs: vec!["TSEND_C".into()],
        };
        assert_eq!(Manifest::parse(&manifest.to_string()), Ok(manifest.clone()));
        let wrong = |from: &str, to: &str| Manifest::parse(&manifest.to_string().replace(from, to)).unwrap_err();
        assert_eq!(wrong("pump.scl", "../pump.scl"), "unexpected line \"source = ../pump.scl\"");
        assert_eq!(wrong("cycle = 100\n", ""), "the time between two calls is missing");
        assert!(wrong("program 1", "program 2").contains("first line"));
    }
}
