//! PLC programs in SCL: files and options to a typed program.

pub mod trial;

use anyhow::{Error, Result, anyhow};
use parameters::{Problems, Source};
use scl::{Compiled, Cpu};
use std::path::{Path, PathBuf};

/// How a program in SCL is read.
#[derive(clap::Args, Clone, Debug, Default, PartialEq)]
#[group(id = "program")]
pub struct Options {
    /// The CPU whose rules hold: 300 (and 400), 1200 or 1500; without it, what the dialect of the sources tells
    #[arg(long, value_parser = cpu)]
    pub cpu: Option<Cpu>,
    /// The function block or the instance that is run; without it, the one that no other block calls
    #[arg(long, value_name = "NAME")]
    pub fb: Option<String>,
    /// A PLC tag that no source declares, such as "Start : Bool"; or a file with a line for each
    #[arg(long, value_name = "NAME : TYPE", value_parser = tags)]
    pub tag: Vec<Tags>,
    /// An instance data block that no source declares, such as "Motor_DB : Motor"; one that a source declares is run, as with --fb
    #[arg(long, value_name = "NAME : BLOCK", value_parser = instance)]
    pub instance: Vec<(String, String)>,
    /// A constant that no source declares, such as MAX=5
    #[arg(long, value_name = "NAME=VALUE", value_parser = constant)]
    pub constant: Vec<(String, String)>,
}

impl Options {
    /// Names that no source declares, with their types.
    pub fn declared(&self) -> Vec<(String, String)> {
        let instances = self.instance.iter().filter(|(_, of)| !of.is_empty());
        self.tag.iter().flatten().chain(instances).cloned().collect()
    }

    /// The function block or the instance that is run, if one is named.
    pub fn block(&self) -> Option<String> {
        let mut instances = self.instance.iter().filter(|(_, of)| of.is_empty()).map(|(name, _)| name);
        self.fb.as_ref().or(instances.next()).cloned()
    }
}

fn cpu(text: &str) -> Result<Cpu, String> {
    match text {
        "300" | "400" => Ok(Cpu::S7300),
        "1200" => Ok(Cpu::S71200),
        "1500" => Ok(Cpu::S71500),
        _ => Err("the CPUs are 300, 400, 1200 and 1500".to_string()),
    }
}

/// Tags by their names, with their types.
pub type Tags = Vec<(String, String)>;

/// One tag, or those of a file.
fn tags(text: &str) -> Result<Tags, String> {
    let one = declaration(text).map(|tag| vec![tag]);
    let path = Path::new(text);
    if !path.is_file() {
        return one;
    }
    let content = std::fs::read_to_string(path).map_err(|error| format!("{text} cannot be read: {error}"))?;
    let lines =
        content.lines().enumerate().map(|(number, line)| (number + 1, line.split("//").next().unwrap_or("").trim()));
    let tag = |(number, line): (usize, &str)| {
        declaration(line).map_err(|error| format!("{text}:{number}: {error}; a list of tags has such a line for each"))
    };
    lines.filter(|(_, line)| !line.is_empty()).map(tag).collect()
}

fn instance(text: &str) -> Result<(String, String), String> {
    if text.contains(':') { declaration(text) } else { Ok((text.trim().trim_matches('"').to_string(), String::new())) }
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
    matches!(ending.as_deref(), Some("scl" | "udt" | "db" | "awl" | "xml"))
}

/// What to say of a file that is no source, to who means one; `None` if its ending tells nothing.
pub fn instead(file: &Path) -> Option<String> {
    let name = file.display();
    if file.is_dir() {
        return Some(format!("{name} is a folder: name the files in it, such as {name}/*.scl"));
    }
    let ending = file.extension()?.to_str()?.to_ascii_lowercase();
    let remedy = match ending.as_str() {
        "st" | "txt" => "rename a source in SCL to .scl",
        "csv" | "xlsx" | "sdf" => "tags are given with --tag, a line NAME : TYPE for each",
        _ => return None,
    };
    Some(format!("{name} is neither an FMU nor a source in SCL (.scl, .udt, .db, .xml, .awl): {remedy}"))
}

/// Whether a file is a source with a block that is executed; else it holds types and data alone, as a parameter file does. The
/// blocks of .awl are in STL.
pub fn has_code(file: &Path) -> bool {
    let is_stl = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("awl"));
    let text = if is_source(file) && !is_stl {
        Source::read(file, None).map(|source| source.text).unwrap_or_default()
    } else {
        String::new()
    };
    let first = |line: &str| line.split_whitespace().next().unwrap_or_default().to_ascii_uppercase();
    let is_begin = |line: &str| {
        matches!(first(line).as_str(), "FUNCTION_BLOCK" | "ORGANIZATION_BLOCK" | "FUNCTION")
            || ["<SW.Blocks.FB", "<SW.Blocks.FC", "<SW.Blocks.OB"].iter().any(|block| line.contains(block))
    };
    text.lines().any(is_begin)
}

/// Reads the sources of a program and translates them.
///
/// # Errors
/// A file cannot be read; or the errors of all sources.
pub fn compile(files: &[PathBuf], options: &Options) -> Result<Result<Compiled, Vec<Problems>>> {
    let read = |file: &PathBuf| Source::read(file, None).map_err(Error::msg);
    let sources = files.iter().map(read).collect::<Result<Vec<Source>>>()?;
    if sources.is_empty() {
        return Err(anyhow!("there is no source: name files that end in .scl, .udt, .db, .xml or .awl"));
    }
    let options = scl::Options {
        cpu: options.cpu,
        block: options.block(),
        declared: options.declared(),
        constants: options.constant.clone(),
        calls: Vec::new(),
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
        let options = Options { tag: vec![vec![("Lamp".into(), "Bool".into())]], ..Options::default() };
        assert_eq!(compile(&[one], &options).unwrap().unwrap().root.unwrap().block, "A");
    }
}
