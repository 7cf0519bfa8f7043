//! Puts files into the command, as lists of (path, text): the sources of `blocks` and `fmu`, for `plcfmu new`, in `sources.rs`;
//! those of the parameter tool's page in `web.rs`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("..").canonicalize()?;
    let mut files = Vec::new();
    for library in ["blocks", "fmu"] {
        let folder = root.join(library).join("src");
        println!("cargo::rerun-if-changed={}", folder.display());
        // Rust, and what it includes: the documentation of the blocks, the door in C.
        let is_source =
            |path: &Path| path.extension().is_some_and(|of| ["rs", "md", "c", "h"].iter().any(|wanted| of == *wanted));
        collect(&folder, &is_source, &mut files)?;
    }
    write("sources.rs", &root, files)?;
    let web = root.join("tool/web");
    let mut files = Vec::new();
    for folder in [web.clone(), web.join("src"), web.join("vendor")] {
        println!("cargo::rerun-if-changed={}", folder.display());
        for entry in fs::read_dir(folder)? {
            files.extend(Some(entry?.path()).filter(|path| path.is_file() && is_of_page(path)));
        }
    }
    write("web.rs", &web, files)
}

/// Whether a file is part of the page.
fn is_of_page(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["html", "css", "js"].iter().any(|of| extension == *of))
        || path.file_name().is_some_and(|name| name == "LICENSE")
}

/// Writes a list of files, with paths from `root`.
fn write(name: &str, root: &Path, mut files: Vec<PathBuf>) -> io::Result<()> {
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        // A path in a crate is written with `/` on every system.
        let path: Vec<_> = file.strip_prefix(root).unwrap_or(&file).iter().map(|part| part.to_string_lossy()).collect();
        let _ = writeln!(list, "    ({:?}, include_str!({:?})),", path.join("/"), file.display().to_string());
    }
    list.push_str("]\n");
    fs::write(PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join(name), list)
}

/// Adds the files of a folder and of those below it that are wanted.
fn collect(folder: &Path, is_wanted: &dyn Fn(&Path) -> bool, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, is_wanted, files)?;
        } else if is_wanted(&path) {
            files.push(path);
        }
    }
    Ok(())
}
