//! PLC programs in SCL: files and options to a typed program.

pub mod trial;

use anyhow::{Error, Result, anyhow};
use parameters::{Problems, Source};
use scl::{Compiled, Cpu};
use std::path::{Path, PathBuf};

/// How a program in SCL is read.
#[derive(clap::Args, Clone, Debug, Default)]
#[group(id = "program")]
pub struct Options {
    /// The CPU whose rules hold: 300 (and 400), 1200 or 1500; without it, what the dialect of the sources tells
    #[arg(long, value_parser = cpu)]
    pub cpu: Option<Cpu>,
    /// The function block or the instance that is run; without it, the one that no other block calls
    #[arg(long, value_name = "NAME")]
    pub fb: Option<String>,
    /// A PLC tag that no source declares, such as "Start : Bool"
    #[arg(long, value_name = "NAME : TYPE", value_parser = declaration)]
    pub tag: Vec<(String, String)>,
    /// An instance data block that no source declares, such as "Motor_DB : Motor"
    #[arg(long, value_name = "NAME : BLOCK", value_parser = declaration)]
    pub instance: Vec<(String, String)>,
    /// A constant that no source declares, such as MAX=5
    #[arg(long, value_name = "NAME=VALUE", value_parser = constant)]
    pub constant: Vec<(String, String)>,
}

fn cpu(text: &str) -> Result<Cpu, String> {
    match text {
        "300" | "400" => Ok(Cpu::S7300),
        "1200" => Ok(Cpu::S71200),
        "1500" => Ok(Cpu::S71500),
        _ => Err("the CPUs are 300, 400, 1200 and 1500".to_string()),
    }
}

fn declaration(text: &str) -> Result<(String, String), String> {
    halves(text, ':').ok_or_else(|| "write a name, a colon and a type: Start : Bool".to_string())
}

fn constant(text: &str) -> Result<(String, String), String> {
    halves(text, '=').ok_or_else(|| "write a name, an equals sign and a value: MAX=5".to_string())
}

fn halves(text: &str, between: char) -> Option<(String, String)> {
    let (name, value) = text.split_once(between)?;
    let half = |half: &str| half.trim().trim_matches('"').to_string();
    Some((half(name), half(value))).filter(|(name, value)| !name.is_empty() && !value.is_empty())
}

/// Whether a file is a source of a program, by its ending.
pub fn is_source(file: &Path) -> bool {
    let ending = file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    matches!(ending.as_deref(), Some("scl" | "udt" | "db"))
}

/// Reads the sources of a program and translates them.
///
/// # Errors
/// A file cannot be read; or the errors of all sources.
pub fn compile(files: &[PathBuf], options: &Options) -> Result<Result<Compiled, Vec<Problems>>> {
    let read = |file: &PathBuf| Source::read(file, None).map_err(Error::msg);
    let sources = files.iter().map(read).collect::<Result<Vec<Source>>>()?;
    if sources.is_empty() {
        return Err(anyhow!("there is no source: name files that end in .scl, .udt or .db"));
    }
    let options = scl::Options {
        cpu: options.cpu,
        block: options.fb.clone(),
        declared: options.tag.iter().chain(&options.instance).cloned().collect(),
        constants: options.constant.clone(),
    };
    Ok(scl::compile(&sources, &options))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_options_may_have_quotation_marks() {
        assert_eq!(declaration("\"Start\" : Bool"), Ok(("Start".into(), "Bool".into())));
        assert_eq!(constant("MAX = 5"), Ok(("MAX".into(), "5".into())));
        assert!(declaration("Start").is_err() && constant("=5").is_err());
    }

    #[test]
    fn the_errors_of_all_files_come_together() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (folder.path().join("one.scl"), folder.path().join("other.UDT"));
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nVAR x : \"B\"; END_VAR\nBEGIN\n#y := 1;\nEND_FUNCTION_BLOCK")
            .unwrap();
        std::fs::write(&other, "TYPE \"B\"\nSTRUCT z : Variant; END_STRUCT;\nEND_TYPE").unwrap();
        assert!(is_source(&one) && is_source(&other) && !is_source(Path::new("a.fmu")));
        let errors = compile(&[one.clone(), other], &Options::default()).unwrap().unwrap_err();
        assert_eq!(errors.len(), 2);
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nBEGIN\n\"Lamp\" := TRUE;\nEND_FUNCTION_BLOCK").unwrap();
        assert!(compile(std::slice::from_ref(&one), &Options::default()).unwrap().is_err());
        let options = Options { tag: vec![("Lamp".into(), "Bool".into())], ..Options::default() };
        assert_eq!(compile(&[one], &options).unwrap().unwrap().root.unwrap().block, "A");
    }
}
