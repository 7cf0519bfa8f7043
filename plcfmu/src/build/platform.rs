//! The platforms that FMUs have libraries for.

use crate::command::output;
use anyhow::{Context, Result};
use std::process::Command;

/// A platform: a processor with an operating system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// FMI's name: the folder below `binaries`, such as `linux64`.
    pub folder: &'static str,
    /// Rust's name, such as `x86_64-unknown-linux-gnu`.
    pub target: &'static str,
    /// How the file name of a library ends, such as `.so`.
    pub suffix: &'static str,
}

/// All of them. FMI 2.0 names the first five folders; the others have their names from FMI 3.0.
const PLATFORMS: [Platform; 10] = [
    Platform { folder: "linux64", target: "x86_64-unknown-linux-gnu", suffix: ".so" },
    Platform { folder: "linux32", target: "i686-unknown-linux-gnu", suffix: ".so" },
    Platform { folder: "win64", target: "x86_64-pc-windows-msvc", suffix: ".dll" },
    Platform { folder: "win64", target: "x86_64-pc-windows-gnu", suffix: ".dll" },
    Platform { folder: "win32", target: "i686-pc-windows-msvc", suffix: ".dll" },
    Platform { folder: "win32", target: "i686-pc-windows-gnu", suffix: ".dll" },
    Platform { folder: "darwin64", target: "x86_64-apple-darwin", suffix: ".dylib" },
    Platform { folder: "darwin64", target: "aarch64-apple-darwin", suffix: ".dylib" },
    Platform { folder: "aarch64-linux", target: "aarch64-unknown-linux-gnu", suffix: ".so" },
    Platform { folder: "aarch32-linux", target: "armv7-unknown-linux-gnueabihf", suffix: ".so" },
];

impl Platform {
    /// This machine: what rustc builds for when it is not told.
    ///
    /// # Errors
    /// rustc cannot be run, or FMI has no name for this machine.
    pub fn host() -> Result<Platform> {
        let version = output(Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())).arg("-vV"))?;
        let target = version.lines().find_map(|line| line.strip_prefix("host: "));
        Platform::of(target.with_context(|| format!("rustc -vV does not name its host: {version}"))?)
    }

    /// The platform of a Rust target.
    ///
    /// # Errors
    /// FMI has no name for it.
    pub fn of(target: &str) -> Result<Platform> {
        PLATFORMS.into_iter().find(|platform| platform.target == target).with_context(|| {
            let known: Vec<_> = PLATFORMS.iter().map(|platform| platform.target).collect();
            format!("FMUs cannot be built for {target}; they can for {}", known.join(", "))
        })
    }

    /// Whether it is Linux, where each system has a C library (glibc) of its own version.
    pub fn is_linux(&self) -> bool {
        self.target.contains("-linux-")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fmi_has_a_folder_for_each_platform() {
        let folder = |target| Platform::of(target).map(|platform| (platform.folder, platform.suffix)).unwrap();
        assert_eq!(folder("x86_64-unknown-linux-gnu"), ("linux64", ".so"));
        assert_eq!(folder("aarch64-unknown-linux-gnu"), ("aarch64-linux", ".so"));
        assert_eq!(folder("x86_64-pc-windows-msvc"), ("win64", ".dll"));
        assert_eq!(folder("aarch64-apple-darwin"), ("darwin64", ".dylib"));
        let error = Platform::of("riscv64gc-unknown-linux-gnu").unwrap_err().to_string();
        assert!(
            error.starts_with("FMUs cannot be built for riscv64gc-unknown-linux-gnu; they can for x86_64-"),
            "{error}"
        );
    }

    #[test]
    fn this_machine_is_one_of_the_platforms() {
        let host = Platform::host().unwrap();
        assert_eq!(host.suffix, std::env::consts::DLL_SUFFIX);
        assert_eq!(host.is_linux(), cfg!(target_os = "linux"));
    }
}
