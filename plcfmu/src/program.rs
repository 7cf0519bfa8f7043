//! PLC programs in SCL: reads the files named by a manifest.

mod folder;
pub mod survey;
pub mod trial;
mod workbook;

use ::program::LARGEST;
use ::program::project;
pub use ::program::project::Parts;
use anyhow::{Context, Error, Result, anyhow};
use folder::Files;
pub use folder::{is_source, test_files};
use manifest::Manifest;
use parameters::Source;
use parameters::problem::drawn;
use parameters::tags::{self, Tags};
use std::path::{Path, PathBuf};

/// The sources, each SIMATIC SD document (`.s7dcl`) followed by its text file (`.s7res`), if it has one.
fn with_texts(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = Vec::new();
    for file in files {
        let texts = file.with_extension("s7res");
        // A link to texts elsewhere is ignored, like the links below a folder.
        let folder_of = |file: &Path| file.canonicalize().ok()?.parent().map(Path::to_path_buf);
        let is_beside = texts.is_file() && folder_of(&texts) == folder_of(file);
        let is_beside = folder::ending(file) == "s7dcl" && is_beside && !files.contains(&texts);
        all.push(file.clone());
        all.extend(is_beside.then_some(texts));
    }
    all
}

/// Whether a file is one of a program's sources: named, or below a named folder.
///
/// # Errors
/// A folder cannot be read, or has no source.
pub fn has_source(manifest: &Manifest, file: &Path) -> Result<bool> {
    let file = file.canonicalize().ok();
    let is_same = |of: &PathBuf| file.is_some() && of.canonicalize().ok() == file;
    Ok(Files::new(&manifest.sources)?.sources.iter().any(is_same))
}

/// The files of a program: its sources and its tag tables, named or below a named folder.
///
/// # Errors
/// A folder cannot be read, or has no source.
pub fn files(manifest: &Manifest) -> Result<Vec<PathBuf>> {
    let Files { sources, tables } = Files::new(&manifest.sources)?;
    Ok([sources, tables].concat())
}

/// The sources and the tag tables below a folder: the files from which `plcfmu run` builds its program.
///
/// # Errors
/// The folder cannot be read, or has no source.
pub fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    files(&Manifest { sources: vec![folder.to_path_buf()], ..Manifest::default() })
}

/// Whether a path belongs to a program: a source, a tag table, or a folder with sources that is not a crate.
pub fn is_part(path: &Path) -> bool {
    match path.is_dir() {
        true => !path.join("Cargo.toml").is_file() && Files::new(&[path.to_path_buf()]).is_ok(),
        false => is_source(path) || folder::is_table(path),
    }
}

/// The message for a path that is neither an FMU nor part of a program; `None` if its extension suggests no remedy.
pub fn instead(file: &Path) -> Option<String> {
    let name = file.display();
    if file.is_dir() {
        return Some(format!("{name} is a folder without program sources (.scl, .udt, .db, .s7dcl, .xml, .awl)"));
    }
    let ending = file.extension()?.to_str()?.to_ascii_lowercase();
    let remedy = match ending.as_str() {
        "st" | "txt" => "rename an SCL source to .scl",
        "xlsx" => "a tag table has a sheet named PLC Tags",
        "csv" => "export the tag table as .xlsx, .xml or .sdf, or declare each tag with --tag 'NAME : TYPE'",
        _ => return None,
    };
    Some(format!(
        "{name} is neither an FMU nor a program source (.scl, .udt, .db, .s7dcl, .xml, .awl) nor a tag table: {remedy}"
    ))
}

/// Whether a path is a source with an executable block, or a folder with sources. Any other source contains only types
/// and data, like a parameter file. Blocks in .awl do not count: they are STL, which is not executed.
pub fn has_code(file: &Path) -> bool {
    if file.is_dir() {
        return is_part(file);
    }
    let text = if is_source(file) && folder::ending(file) != "awl" {
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

/// Reads the sources and the tag tables of a program: the files of the manifest, and those below its folders.
///
/// # Errors
/// A file cannot be read, a tag table is faulty, or two of them declare a name differently.
pub fn parts(manifest: &Manifest) -> Result<Parts> {
    let Files { sources: files, tables } = Files::new(&manifest.sources)?;
    let read = |file: &PathBuf| Source::read(file, None).map_err(Error::msg);
    let sources = with_texts(&files).iter().map(read).collect::<Result<Vec<Source>>>()?;
    if sources.is_empty() {
        return Err(anyhow!("no source: specify files that end in .scl, .udt, .db, .s7dcl, .xml or .awl"));
    }
    let tables = tables.iter().map(|file| Ok((file.display().to_string(), table(file)?)));
    let tables = tables.collect::<Result<Vec<(String, Tags)>>>()?;
    project::parts(&Manifest { sources: files, ..manifest.clone() }, sources, tables).map_err(Error::msg)
}

/// Reads a tag table: XML, a workbook, a STEP 7 table, or a list with one tag per line.
///
/// # Errors
/// It cannot be read, or is faulty.
pub fn table(file: &Path) -> Result<Tags> {
    let (name, bytes) = Source::load(file, LARGEST).map_err(Error::msg)?;
    if folder::ending(file) == "xlsx" {
        return workbook::read(bytes).with_context(|| name);
    }
    tags::read(&Source::new(name, bytes)).map_err(|wrong| anyhow!("{}", drawn(&wrong).trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use parameters::Problems;
    use parameters::tags::Tag;
    use scl::Compiled;

    fn compile(manifest: &Manifest) -> Result<Result<Compiled, Vec<Problems>>> {
        let Parts { sources, manifest, .. } = parts(manifest)?;
        Ok(scl::compile(&sources, &manifest))
    }

    #[test]
    fn tables_may_declare_a_name_twice_but_not_differently() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("a.scl", "FUNCTION_BLOCK \"A\"\nBEGIN\n\"Lamp\" := TRUE;\nEND_FUNCTION_BLOCK");
        write(
            "a.sdf",
            "\"Lamp\",\"%Q0.0\",\"Bool\",\"\",\"\",\"\",\"signal\",\"\",\"\"\n\"MAX\",\"CONSTANT\",\"Int\",\"\",\"\",\"\",\"\",\"5\",\"\"\n",
        );
        write("b.sdf", "\"LAMP\",\"%Q0.0\",\"BOOL\",\"again\"\n");
        let manifest = Manifest { sources: vec![folder.path().into()], ..Manifest::default() };
        let found = parts(&manifest).unwrap();
        let lines: Vec<String> = found.manifest.declared.iter().map(ToString::to_string).collect();
        assert_eq!(lines, ["\"Lamp\" AT %Q0.0 : Bool // signal"]);
        assert_eq!(found.manifest.constants, [("MAX".to_string(), "Int#5".to_string())]);
        assert_eq!(
            found.tables.iter().map(|(_, tags, constants)| (*tags, *constants)).collect::<Vec<_>>(),
            [(1, 1), (1, 0)]
        );
        // Manual declarations come first and take precedence.
        let own = Manifest { declared: vec![Tag::new("Lamp", "Int")], ..manifest.clone() };
        assert_eq!(parts(&own).unwrap().manifest.declared[0].of, "Int");
        write("b.sdf", "\"LAMP\",\"%Q0.1\",\"BOOL\",\"\"\n");
        let wrong = parts(&manifest).err().unwrap().to_string();
        assert!(wrong.contains("a.sdf and ") && wrong.contains("b.sdf declare \"LAMP\" differently"), "{wrong}");
    }

    #[test]
    fn the_errors_of_all_files_come_together() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (folder.path().join("one.scl"), folder.path().join("other.UDT"));
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nVAR x : \"B\"; END_VAR\nBEGIN\n#y := 1;\nEND_FUNCTION_BLOCK")
            .unwrap();
        std::fs::write(&other, "TYPE \"B\"\nSTRUCT z : Variant; END_STRUCT;\nEND_TYPE").unwrap();
        assert!(is_source(&one) && is_source(&other) && !is_source(Path::new("a.fmu")));
        let of = |sources: &[&PathBuf]| Manifest {
            sources: sources.iter().copied().cloned().collect(),
            ..Manifest::default()
        };
        let errors = compile(&of(&[&one, &other])).unwrap().unwrap_err();
        assert_eq!(errors.len(), 2);
        std::fs::write(&one, "FUNCTION_BLOCK \"A\"\nBEGIN\n\"Lamp\" := TRUE;\nEND_FUNCTION_BLOCK").unwrap();
        assert!(compile(&of(&[&one])).unwrap().is_err());
        let manifest = Manifest { declared: vec![Tag::new("Lamp", "Bool")], ..of(&[&one]) };
        assert_eq!(compile(&manifest).unwrap().unwrap().root.unwrap().block, "A");
    }
}
