//! Compiles an FMU's C source to a library for this machine.

use crate::build::zig::is_on_path;
use crate::command::output;
use anyhow::{Context, Result};
use fmu::sources::Door;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The C compilers in search order, each with the first argument that it needs, if any.
const COMPILERS: [(&str, Option<&str>); 5] =
    [("cc", None), ("gcc", None), ("clang", None), ("zig", Some("cc")), ("python-zig", Some("cc"))];

/// The compiler command: the words of the environment variable CC, or the first compiler on PATH.
fn compiler() -> Result<Command> {
    if let Some(given) = std::env::var("CC").ok().filter(|given| !given.trim().is_empty()) {
        let mut words = given.split_whitespace();
        let mut command = Command::new(words.next().unwrap_or_default());
        command.args(words);
        return Ok(command);
    }
    let (program, argument) = COMPILERS.into_iter().find(|(program, _)| is_on_path(program)).context(
        "--native compiles a program through C, but no C compiler is on PATH: install gcc, clang or zig (pip install \
         ziglang), or set CC",
    )?;
    let mut command = Command::new(program);
    command.args(argument);
    Ok(command)
}

/// Compiles an FMU's C source, which includes the header of `door`, and `interface`, the library's self-description in
/// JSON, into a library in `folder`.
///
/// # Errors
/// No compiler is found, a file cannot be written, or the compiler rejects the source; the error includes its message.
pub fn compile(source: &Path, door: &Door, interface: &str, folder: &Path, suffix: &str) -> Result<PathBuf> {
    let (header, about) = (folder.join(door.header_name), folder.join("interface.c"));
    fs::write(&header, door.header)?;
    fs::write(&about, told(interface))?;
    let library = folder.join(format!("library{suffix}"));
    let mut command = compiler()?;
    command.args(["-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-DDISABLE_PREFIX"]);
    if !cfg!(windows) {
        command.arg("-fPIC");
    }
    command.arg("-I").arg(folder).arg(source).arg(&about).arg("-o").arg(&library);
    output(&mut command).with_context(|| format!("{} does not compile", source.display()))?;
    Ok(library)
}

/// The C source of the function that returns a library's self-description.
fn told(interface: &str) -> String {
    let mut text = String::from(
        "#include <stddef.h>\n#include <string.h>\n#if defined(_WIN32)\n__declspec(dllexport)\n#else\n\
         __attribute__((visibility(\"default\")))\n#endif\n\
         size_t plcfmu_interface(char *buffer, size_t size);\n\nstatic const unsigned char json[] = {",
    );
    for (index, byte) in interface.bytes().enumerate() {
        let _ = write!(text, "{}{byte},", if index % 32 == 0 { "\n" } else { "" });
    }
    text.push_str(
        "\n};\n\nsize_t plcfmu_interface(char *buffer, size_t size) {\n    if (buffer != NULL) {\n        \
         memcpy(buffer, json, size < sizeof json ? size : sizeof json);\n    }\n    return sizeof json;\n}\n",
    );
    text
}
