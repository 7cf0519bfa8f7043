//! Embeds the block sources in the library, so that it can read them without the repository.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let manifest = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("Cargo sets CARGO_MANIFEST_DIR"));
    let blocks = manifest.join("../blocks/src").canonicalize()?;
    println!("cargo::rerun-if-changed={}", blocks.display());
    let mut files = Vec::new();
    collect(&blocks, &mut files)?;
    files.sort();
    let mut text = String::from("&[\n");
    for file in files {
        let name = file.strip_prefix(&blocks).expect("it lies below").to_string_lossy().replace('\\', "/");
        let _ = writeln!(text, "    ({:?}, include_str!({file:?})),", format!("blocks/src/{name}"));
    }
    text.push_str("]\n");
    fs::write(PathBuf::from(env::var("OUT_DIR").expect("Cargo sets OUT_DIR")).join("blocks.rs"), text)
}

/// Collects the sources that a law may consist of: the Rust files that are not compiled only under `#[cfg(test)]`, and
/// the documentation files `page.md`.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let declares = |name: &str| fs::read_to_string(folder.join(name)).unwrap_or_default();
    let declared = declares("mod.rs") + &declares("lib.rs");
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let module = name.strip_suffix(".rs");
        let is_hidden = module.is_some_and(|module| declared.contains(&format!("#[cfg(test)]\nmod {module};")));
        if path.is_dir() {
            collect(&path, files)?;
        } else if module.is_some() && !is_hidden || name == "page.md" {
            files.push(path);
        }
    }
    Ok(())
}
