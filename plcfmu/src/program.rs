//! PLC programs in SCL: files and a manifest to a typed program.

pub mod trial;

use anyhow::{Error, Result, anyhow};
use manifest::Manifest;
use parameters::{Problems, Source};
use scl::Compiled;
use std::path::{Path, PathBuf};

/// Whether a file is a source of a program, by its ending.
pub fn is_source(file: &Path) -> bool {
    let ending = file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    matches!(ending.as_deref(), Some("scl" | "udt" | "db" | "awl" | "xml" | "s7dcl" | "s7res"))
}

/// The sources, and beside each document in SIMATIC SD (`.s7dcl`) the file with its texts (`.s7res`), where there is one.
pub fn with_texts(files: &[PathBuf]) -> Vec<PathBuf> {
    let is_document = |file: &Path| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("s7dcl"));
    let mut all: Vec<PathBuf> = Vec::new();
    for file in files {
        let texts = file.with_extension("s7res");
        let is_beside = is_document(file) && texts.is_file() && !files.contains(&texts);
        all.push(file.clone());
        all.extend(is_beside.then_some(texts));
    }
    all
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
    Some(format!("{name} is neither an FMU nor a source of a program (.scl, .udt, .db, .s7dcl, .xml, .awl): {remedy}"))
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
pub fn compile(files: &[PathBuf], manifest: &Manifest) -> Result<Result<Compiled, Vec<Problems>>> {
    let read = |file: &PathBuf| Source::read(file, None).map_err(Error::msg);
    let sources = with_texts(files).iter().map(read).collect::<Result<Vec<Source>>>()?;
    if sources.is_empty() {
        return Err(anyhow!("there is no source: name files that end in .scl, .udt, .db, .s7dcl, .xml or .awl"));
    }
    Ok(scl::compile(&sources, manifest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_errors_of_all_files_come_together() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (folder.path().join("one.scl"), folder.path().join("other.UDT"));
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nVAR x : \"B\"; END_VAR\nBEGIN\n#y := 1;\nEND_FUNCTION_BLOCK")
            .unwrap();
        std::fs::write(&other, "TYPE \"B\"\nSTRUCT z : Variant; END_STRUCT;\nEND_TYPE").unwrap();
        assert!(is_source(&one) && is_source(&other) && !is_source(Path::new("a.fmu")));
        let errors = compile(&[one.clone(), other], &Manifest::default()).unwrap().unwrap_err();
        assert_eq!(errors.len(), 2);
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nBEGIN\n\"Lamp\" := TRUE;\nEND_FUNCTION_BLOCK").unwrap();
        assert!(compile(std::slice::from_ref(&one), &Manifest::default()).unwrap().is_err());
        let manifest = Manifest { declared: vec![("Lamp".into(), "Bool".into())], ..Manifest::default() };
        assert_eq!(compile(&[one], &manifest).unwrap().unwrap().root.unwrap().block, "A");
    }
}
