//! Takes the plants in. Each is a crate of type `cdylib` alone, so that cargo optimizes its FMU as a whole, and such a crate
//! cannot be a dependency: so their sources are taken, without the line that makes an FMU of them. A file that has that line
//! is a plant; nothing else has to be said.

use std::path::Path;
use std::{env, fs};

fn main() {
    let plants = Path::new(&env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("../../examples/plants");
    let out = env::var("OUT_DIR").expect("cargo sets it");
    println!("cargo::rerun-if-changed={}", plants.display());
    let mut names: Vec<String> = fs::read_dir(&plants)
        .expect("examples/plants is there")
        .map(|entry| entry.expect("it can be read").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let mut modules = String::new();
    for name in names {
        let file = plants.join(&name).join("src/lib.rs");
        let text = fs::read_to_string(&file).unwrap_or_default();
        if !text.contains("\nfmu::export!(") {
            continue;
        }
        // The unit tests stay with the plant, and so do its inner documentation and what follows the last line of an FMU.
        let code = text.split("\n#[cfg(test)]\n").next().unwrap_or_default();
        let code: Vec<&str> =
            code.lines().filter(|line| !line.starts_with("//!") && !line.starts_with("fmu::export!(")).collect();
        fs::write(Path::new(&out).join(format!("{name}.rs")), code.join("\n")).expect("OUT_DIR can be written");
        modules += &format!(
            "/// `examples/plants/{name}`\npub mod {name} {{\n    include!(concat!(env!(\"OUT_DIR\"), \"/{name}.rs\"));\n}}\n"
        );
    }
    fs::write(Path::new(&out).join("plants.rs"), modules).expect("OUT_DIR can be written");
}
