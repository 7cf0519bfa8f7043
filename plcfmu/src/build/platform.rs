//! The platforms for which FMUs have libraries.

use crate::command::output;
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// A platform: a processor and an operating system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// FMI's name: the folder below `binaries`, such as `linux64`.
    pub folder: &'static str,
    /// The name in FMI 3.0, such as `x86_64-linux`.
    pub newer: &'static str,
    /// Rust's name, such as `x86_64-unknown-linux-gnu`.
    pub target: &'static str,
    /// The suffix of a library's file name, such as `.so`.
    pub suffix: &'static str,
}

/// All platforms. FMI 2.0 defines the first five folder names; the others are named as in FMI 3.0.
const PLATFORMS: [Platform; 10] = [
    Platform { folder: "linux64", newer: "x86_64-linux", target: "x86_64-unknown-linux-gnu", suffix: ".so" },
    Platform { folder: "linux32", newer: "x86-linux", target: "i686-unknown-linux-gnu", suffix: ".so" },
    Platform { folder: "win64", newer: "x86_64-windows", target: "x86_64-pc-windows-gnu", suffix: ".dll" },
    Platform { folder: "win64", newer: "x86_64-windows", target: "x86_64-pc-windows-msvc", suffix: ".dll" },
    Platform { folder: "win32", newer: "x86-windows", target: "i686-pc-windows-gnu", suffix: ".dll" },
    Platform { folder: "win32", newer: "x86-windows", target: "i686-pc-windows-msvc", suffix: ".dll" },
    Platform { folder: "darwin64", newer: "x86_64-darwin", target: "x86_64-apple-darwin", suffix: ".dylib" },
    Platform { folder: "darwin64", newer: "aarch64-darwin", target: "aarch64-apple-darwin", suffix: ".dylib" },
    Platform { folder: "aarch64-linux", newer: "aarch64-linux", target: "aarch64-unknown-linux-gnu", suffix: ".so" },
    Platform {
        folder: "aarch32-linux",
        newer: "aarch32-linux",
        target: "armv7-unknown-linux-gnueabihf",
        suffix: ".so",
    },
];

/// An alias: Rust's name of this processor is better known than FMI's.
const ALIAS: (&str, &str) = ("armv7", "aarch32-linux");

impl Platform {
    /// This machine's platform: the default target of rustc in a workspace's folder.
    ///
    /// # Errors
    /// rustc cannot be run, or FMI has no name for this machine.
    pub fn host(root: &Path) -> Result<Platform> {
        let version = output(rustc(root).arg("-vV"))?;
        let target = version.lines().find_map(|line| line.strip_prefix("host: "));
        Platform::find(target.with_context(|| format!("rustc -vV does not name its host: {version}"))?)
    }

    /// The platform of a Rust target.
    ///
    /// # Errors
    /// FMI has no name for it.
    pub fn find(target: &str) -> Result<Platform> {
        PLATFORMS.into_iter().find(|platform| platform.target == target).with_context(|| {
            let known: Vec<_> = PLATFORMS.iter().map(|platform| platform.target).collect();
            format!("FMUs cannot be built for {target}, only for {}", known.join(", "))
        })
    }

    /// The platforms to build on `host` for an FMI folder: for macOS, both processors; for Windows, one C runtime:
    /// MSVC's if the host uses it, otherwise GNU's.
    pub fn of_folder(folder: &str, host: &Platform) -> Vec<Platform> {
        let mut platforms: Vec<_> = PLATFORMS.into_iter().filter(|platform| platform.folder == folder).collect();
        if platforms.iter().any(Platform::is_windows) {
            let is_msvc = host.target.ends_with("-msvc");
            platforms.retain(|platform| platform.target.ends_with("-msvc") == is_msvc);
        }
        platforms
    }

    /// Whether the operating system is Linux, where the version of the C library (glibc) differs between machines.
    pub fn is_linux(&self) -> bool {
        self.target.contains("-linux-")
    }

    /// Whether the operating system is Windows.
    pub fn is_windows(&self) -> bool {
        self.target.contains("-windows-")
    }

    /// Whether the operating system is macOS.
    pub fn is_macos(&self) -> bool {
        self.target.ends_with("-apple-darwin")
    }

    /// The processor, as [`Binary`](host::package::binary::Binary) names it.
    pub fn architecture(&self) -> &'static str {
        match self.target.split('-').next() {
            Some("armv7") => "arm",
            Some(architecture) => architecture,
            None => "",
        }
    }
}

/// FMI's name of a platform, from the user's name for it.
///
/// # Errors
/// No platform has this name; the error lists the available names.
pub fn folder(name: &str) -> Result<&'static str> {
    let name = if name == ALIAS.0 { ALIAS.1 } else { name };
    let found = PLATFORMS.iter().find(|platform| platform.folder == name).map(|platform| platform.folder);
    found.with_context(|| format!("available: {}", folders().join(", ")))
}

/// The processors of a platform's libraries; empty if FMI has no such platform.
pub fn architectures(folder: &str) -> Vec<&'static str> {
    let mut architectures: Vec<_> = in_folder(folder).map(Platform::architecture).collect();
    architectures.dedup();
    architectures
}

/// The operating system of a platform, and the suffix of its libraries.
pub fn system(folder: &str) -> Option<(&'static str, &'static str)> {
    let platform = in_folder(folder).next()?;
    let system = match platform {
        _ if platform.is_linux() => "Linux",
        _ if platform.is_windows() => "Windows",
        _ => "macOS",
    };
    Some((system, platform.suffix))
}

fn in_folder(folder: &str) -> impl Iterator<Item = &'static Platform> {
    PLATFORMS.iter().filter(move |platform| platform.folder == folder || platform.newer == folder)
}

/// The FMI 3.0 folders for an FMI 2.0 folder: two for a macOS file for both processors.
pub fn newer(folder: &str) -> Vec<&'static str> {
    let mut folders: Vec<_> = in_folder(folder).map(|platform| platform.newer).collect();
    folders.dedup();
    folders
}

/// The FMI folder names of all platforms, without duplicates.
pub fn folders() -> Vec<&'static str> {
    let mut folders: Vec<_> = PLATFORMS.iter().map(|platform| platform.folder).collect();
    folders.dedup();
    folders
}

/// The compiler that cargo calls in a workspace's folder, unless configured otherwise. Like cargo, it is started in
/// that folder, because rustup chooses the toolchain by the current folder, which may even contain it.
pub fn rustc(root: &Path) -> Command {
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.current_dir(root);
    rustc
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fmi_has_a_folder_for_each_platform() {
        let folder = |target| Platform::find(target).map(|platform| (platform.folder, platform.suffix)).unwrap();
        assert_eq!(folder("x86_64-unknown-linux-gnu"), ("linux64", ".so"));
        assert_eq!(folder("aarch64-unknown-linux-gnu"), ("aarch64-linux", ".so"));
        assert_eq!(folder("x86_64-pc-windows-msvc"), ("win64", ".dll"));
        assert_eq!(folder("aarch64-apple-darwin"), ("darwin64", ".dylib"));
        let error = Platform::find("riscv64gc-unknown-linux-gnu").unwrap_err().to_string();
        assert!(error.starts_with("FMUs cannot be built for riscv64gc-unknown-linux-gnu, only for x86_64-"), "{error}");
    }

    #[test]
    fn a_platform_has_one_name_and_the_processors_that_are_built_for_it() {
        let targets = |folder: &str, host: &str| -> Vec<&str> {
            let host = Platform::find(host).unwrap();
            Platform::of_folder(folder, &host).into_iter().map(|platform| platform.target).collect()
        };
        let linux = "x86_64-unknown-linux-gnu";
        assert_eq!(targets("linux64", linux), [linux]);
        assert_eq!(targets("darwin64", linux), ["x86_64-apple-darwin", "aarch64-apple-darwin"]);
        assert_eq!(targets("win64", linux), ["x86_64-pc-windows-gnu"]);
        assert_eq!(targets("win64", "x86_64-pc-windows-msvc"), ["x86_64-pc-windows-msvc"]);
        assert_eq!(targets("win32", "x86_64-pc-windows-gnu"), ["i686-pc-windows-gnu"]);
        assert_eq!(targets(folder("armv7").unwrap(), linux), ["armv7-unknown-linux-gnueabihf"]);
        assert_eq!(architectures("darwin64"), ["x86_64", "aarch64"]);
        assert_eq!(architectures("win32"), ["i686"]);
        assert_eq!(architectures("aarch32-linux"), ["arm"]);
        assert_eq!(system("darwin64"), Some(("macOS", ".dylib")));
        assert_eq!(
            folder("win128").unwrap_err().to_string(),
            "available: linux64, linux32, win64, win32, darwin64, aarch64-linux, aarch32-linux"
        );
    }

    #[test]
    fn this_machine_is_one_of_the_platforms() {
        let host = Platform::host(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        assert_eq!(host.suffix, std::env::consts::DLL_SUFFIX);
        assert_eq!(host.is_linux(), cfg!(target_os = "linux"));
    }
}
