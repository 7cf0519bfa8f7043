//! Sets `PLCFMU_CODE` to a hash of the crate's own sources. A program that links a block compares it with the hash in
//! an FMU's library to find out whether both were compiled from the same code. This is the build script of all crates
//! that determine what an FMU computes.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut files = vec![root.join("Cargo.toml")];
    println!("cargo::rerun-if-changed=Cargo.toml");
    println!("cargo::rerun-if-changed=src");
    collect(&root.join("src"), &mut files)?;
    // FNV-1a with 128 bits, as in `table::fingerprint`.
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    let mut add = |byte: u8| hash = (hash ^ u128::from(byte)).wrapping_mul((1 << 88) + 0x13b);
    for (name, path) in ordered(&root, files) {
        name.bytes().for_each(&mut add);
        add(0);
        // Some checkouts have CR LF line endings.
        fs::read(path)?.into_iter().filter(|byte| *byte != b'\r').for_each(&mut add);
        add(0);
    }
    println!("cargo::rustc-env=PLCFMU_CODE={hash:032x}");
    Ok(())
}

/// Returns the files with their names, in an order that is the same on all systems.
fn ordered(root: &Path, files: Vec<PathBuf>) -> Vec<(String, PathBuf)> {
    let name = |file: &Path| {
        let parts = file.strip_prefix(root).unwrap_or(file).iter().map(|part| part.to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    };
    let mut named: Vec<_> = files.into_iter().map(|file| (name(&file), file)).collect();
    named.sort();
    named
}

/// Adds the Rust files of a folder and its subfolders.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
