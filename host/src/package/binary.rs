//! Examines a library file without loading it: the functions it exports and its system requirements.

use anyhow::{Context, Result, anyhow, bail, ensure};
use object::read::elf::FileHeader;
use object::read::macho::{FatArch, LoadCommandVariant, MachHeader, MachOFatFile32, MachOFatFile64, MachOFile};
use object::{Architecture, BinaryFormat, Endianness, File, FileKind, NameOrOrdinal, Object};

/// The function, exported in addition to the FMI functions, that returns the table of a library built with
/// `fmu::export!`.
const TABLE: &str = "plcfmu_interface";

/// The maximum number of architectures in a macOS universal binary.
const MOST_ARCHITECTURES: usize = 8;

/// The exports and requirements of a library.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Binary {
    /// The target operating system: `Linux`, `Windows` or `macOS`.
    pub system: &'static str,
    /// The target processors, such as `x86_64`: one, or several in a macOS universal binary.
    pub architectures: Vec<String>,
    /// The exported FMI functions, sorted.
    pub functions: Vec<String>,
    /// Whether it exports a block's table, like every library built by this tool.
    pub has_table: bool,
    /// The newest glibc version whose symbols a Linux library needs, such as `2.14`.
    pub glibc: Option<String>,
    /// The libraries it depends on: shared objects on Linux, DLLs on Windows, dylibs on macOS.
    pub needed: Vec<String>,
    /// The install names of a macOS dylib, which may differ between the parts of a universal binary.
    pub install_names: Vec<String>,
}

impl Binary {
    /// Reads a library for Linux, Windows or macOS.
    ///
    /// # Errors
    /// The bytes are not a library, or the parts of a macOS universal binary differ.
    pub fn read(bytes: &[u8]) -> Result<Binary> {
        let what = || "it is not a library for Linux, Windows or macOS";
        match FileKind::parse(bytes).with_context(what)? {
            FileKind::MachOFat32 => universal(bytes, MachOFatFile32::parse(bytes).with_context(what)?.arches()),
            FileKind::MachOFat64 => universal(bytes, MachOFatFile64::parse(bytes).with_context(what)?.arches()),
            _ => single(bytes).with_context(what),
        }
    }

    /// Those of `functions` that are missing, separated by commas; `None` if all are exported.
    pub fn missing(&self, functions: &[&str]) -> Option<String> {
        let missing: Vec<_> =
            functions.iter().copied().filter(|name| !self.functions.iter().any(|own| own == name)).collect();
        (!missing.is_empty()).then(|| missing.join(", "))
    }

    /// Checks that exactly these FMI functions are exported.
    ///
    /// # Errors
    /// Functions are missing, or there is an additional one.
    pub fn check_functions(&self, functions: &[&str]) -> Result<()> {
        if let Some(missing) = self.missing(functions) {
            bail!("it does not export {missing}");
        }
        match self.functions.iter().find(|name| !functions.contains(&name.as_str())) {
            Some(name) => Err(anyhow!("it exports {name}, which is not an FMI co-simulation function")),
            None => Ok(()),
        }
    }

    /// Checks that it depends only on libraries that every system of its kind has.
    ///
    /// # Errors
    /// It needs another library; the message names the first one.
    pub fn check_needed(&self) -> Result<()> {
        match self.needed.iter().find(|library| !is_everywhere(self.system, library)) {
            Some(library) => Err(anyhow!("it needs {library}, which not every {} system has", self.system)),
            None => Ok(()),
        }
    }

    /// Checks that a Linux library needs no newer glibc than this version, and not libgcc_s.
    ///
    /// # Errors
    /// It needs one of them.
    pub fn check_portable(&self, glibc: &str) -> Result<()> {
        if let Some(own) = self.glibc.as_deref().filter(|own| version(own) > version(glibc)) {
            bail!("it needs glibc {own}; a portable library needs {glibc} or older");
        }
        match self.needed.iter().find(|library| library.starts_with("libgcc_s")) {
            Some(library) => Err(anyhow!("it needs {library}, which not every Linux system has")),
            None => Ok(()),
        }
    }
}

/// Whether every system of this kind has the library: glibc and GCC's runtime on Linux, parts of the operating system
/// on Windows and macOS.
fn is_everywhere(system: &str, needed: &str) -> bool {
    const LINUX: [&str; 7] =
        ["libc.so.", "libm.so.", "libdl.so.", "libpthread.so.", "librt.so.", "ld-linux", "libgcc_s.so."];
    match system {
        "Linux" => LINUX.iter().any(|name| needed.starts_with(name)),
        "Windows" => {
            let needed = needed.to_lowercase();
            ["kernel32.dll", "msvcrt.dll", "ntdll.dll"].contains(&needed.as_str())
                || needed.starts_with("api-ms-win-core-")
        }
        _ => needed == "/usr/lib/libSystem.B.dylib",
    }
}

/// Splits a version such as `2.17` for comparison: 2.4 is older than 2.17.
pub fn version(text: &str) -> Vec<u32> {
    text.split('.').map(|part| part.parse().unwrap_or(u32::MAX)).collect()
}

/// Reads a macOS universal binary, which contains a library for each processor. The libraries must agree, so that the
/// FMU is the same on all of them.
fn universal(bytes: &[u8], parts: &[impl FatArch]) -> Result<Binary> {
    ensure!(
        (1..=MOST_ARCHITECTURES).contains(&parts.len()),
        "it is a universal binary for {} processors; 1 to {MOST_ARCHITECTURES} are accepted",
        parts.len()
    );
    let mut all: Option<Binary> = None;
    for part in parts {
        let name = name(part.architecture());
        let part = part.data(bytes).and_then(single).with_context(|| format!("its part for {name} is damaged"))?;
        let Some(first) = &mut all else {
            all = Some(part);
            continue;
        };
        ensure!(
            part.functions == first.functions && part.has_table == first.has_table,
            "its parts for {} and {name} export different functions",
            first.architectures[0]
        );
        first.architectures.extend(part.architectures);
        add(&mut first.needed, part.needed);
        add(&mut first.install_names, part.install_names);
    }
    all.context("it is empty")
}

/// Adds to `texts` the strings of `further` that it does not contain.
fn add(texts: &mut Vec<String>, further: Vec<String>) {
    for text in further {
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
}

/// Reads a library for one processor.
fn single(bytes: &[u8]) -> object::Result<Binary> {
    let file = File::parse(bytes)?;
    let system = match file.format() {
        BinaryFormat::Elf => "Linux",
        BinaryFormat::Pe => "Windows",
        _ => "macOS",
    };
    let mut binary = Binary { system, architectures: vec![name(file.architecture())], ..Binary::default() };
    for export in file.exports()? {
        if let NameOrOrdinal::Name(name) = export?.name() {
            // macOS prefixes C names with an underscore.
            let name = text(name);
            let name = name.strip_prefix('_').unwrap_or(&name);
            binary.has_table |= name == TABLE;
            if name.starts_with("fmi") {
                binary.functions.push(name.to_string());
            }
        }
    }
    binary.functions.sort();
    for library in file.import_libraries()? {
        binary.needed.push(text(library?.name()));
    }
    match &file {
        File::Elf32(elf) => binary.glibc = glibc(elf.elf_header(), bytes)?,
        File::Elf64(elf) => binary.glibc = glibc(elf.elf_header(), bytes)?,
        File::MachO32(macho) => binary.install_names.extend(install_name(macho)?),
        File::MachO64(macho) => binary.install_names.extend(install_name(macho)?),
        _ => {}
    }
    Ok(binary)
}

fn name(architecture: Architecture) -> String {
    match architecture {
        Architecture::I386 => "i686".to_string(),
        other => format!("{other:?}").to_lowercase(),
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The newest glibc version whose symbols a Linux library needs.
fn glibc<Elf: FileHeader<Endian = Endianness>>(header: &Elf, bytes: &[u8]) -> object::Result<Option<String>> {
    let endian = header.endian()?;
    let sections = header.sections(endian, bytes)?;
    let mut newest: Option<String> = None;
    if let Some((mut libraries, strings)) = sections.gnu_verneed(endian, bytes)? {
        let strings = sections.strings(endian, bytes, strings)?;
        while let Some((_, mut versions)) = libraries.next()? {
            while let Some(entry) = versions.next()? {
                let name = text(entry.name(endian, strings)?);
                if let Some(glibc) = name.strip_prefix("GLIBC_")
                    && newest.as_deref().is_none_or(|newest| version(newest) < version(glibc))
                {
                    newest = Some(glibc.to_string());
                }
            }
        }
    }
    Ok(newest)
}

/// The install name of a dylib.
fn install_name<Mach: MachHeader>(file: &MachOFile<'_, Mach>) -> object::Result<Option<String>> {
    let mut commands = file.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        if let LoadCommandVariant::IdDylib(dylib) = command.variant()? {
            return Ok(Some(text(command.string(file.endian(), dylib.dylib.name)?)));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use doubles::macos;

    const FUNCTIONS: [&str; 3] = ["fmiDoStep", "fmiInstantiate", "fmiReset"];

    fn binary() -> Binary {
        Binary {
            functions: FUNCTIONS.map(str::to_string).to_vec(),
            glibc: Some("2.16".into()),
            needed: vec!["libc.so.6".into()],
            ..Binary::default()
        }
    }

    fn sentence<T>(result: Result<T>) -> String {
        format!("{:#}", result.map(|_| ()).unwrap_err())
    }

    #[test]
    fn all_functions_and_no_other_of_fmi_are_exported() {
        assert!(binary().check_functions(&FUNCTIONS).is_ok());
        let mut binary = binary();
        binary.functions.push("fmiNewDiscreteStates".into());
        assert_eq!(
            sentence(binary.check_functions(&FUNCTIONS)),
            "it exports fmiNewDiscreteStates, which is not an FMI co-simulation function"
        );
        binary.functions.retain(|name| name != "fmiDoStep" && name != "fmiReset");
        assert_eq!(sentence(binary.check_functions(&FUNCTIONS)), "it does not export fmiDoStep, fmiReset");
    }

    #[test]
    fn a_portable_library_needs_an_old_glibc_and_nothing_else() {
        let mut binary = binary();
        assert!(binary.check_portable("2.17").is_ok());
        binary.glibc = Some("2.17".into());
        assert!(binary.check_portable("2.17").is_ok());
        for newer in ["2.18", "2.34", "2.17.1", "3"] {
            binary.glibc = Some(newer.into());
            assert_eq!(
                sentence(binary.check_portable("2.17")),
                format!("it needs glibc {newer}; a portable library needs 2.17 or older")
            );
        }
        // 2.4 is older than 2.17, though 4 is more than 1.
        binary.glibc = Some("2.4".into());
        assert!(binary.check_portable("2.17").is_ok());
        binary.needed.push("libgcc_s.so.1".into());
        assert_eq!(sentence(binary.check_portable("2.17")), "it needs libgcc_s.so.1, which not every Linux system has");
    }

    #[test]
    fn a_library_needs_what_belongs_to_its_system_and_nothing_else() {
        let needed = |system, library: &str| {
            let binary = Binary { system, needed: vec![library.into()], ..Binary::default() };
            binary.check_needed().map_err(|error| error.to_string())
        };
        for (system, library) in [
            ("Windows", "KERNEL32.dll"),
            ("Windows", "api-ms-win-core-synch-l1-2-0.dll"),
            ("Linux", "libm.so.6"),
            ("Linux", "ld-linux-aarch64.so.1"),
            ("macOS", "/usr/lib/libSystem.B.dylib"),
        ] {
            assert_eq!(needed(system, library), Ok(()));
        }
        for (system, library) in [
            ("Windows", "VCRUNTIME140.dll"),
            ("Windows", "libgcc_s_seh-1.dll"),
            ("Linux", "libz.so.1"),
            ("macOS", "/usr/lib/libiconv.2.dylib"),
        ] {
            assert_eq!(
                needed(system, library),
                Err(format!("it needs {library}, which not every {system} system has"))
            );
        }
    }

    #[test]
    fn what_is_not_a_library_is_refused() {
        for bytes in [&b""[..], b"hello", b"\x7fELF\x02\x01\x01", b"\xca\xfe\xba\xbe\0\0\0\x02"] {
            assert!(sentence(Binary::read(bytes)).starts_with("it is not a library for Linux, Windows or macOS: "));
        }
    }

    #[test]
    fn the_test_program_itself_can_be_read() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let binary = Binary::read(&program).unwrap();
        assert_eq!(binary.functions, [""; 0]);
        assert!(!binary.has_table);
        assert_eq!(binary.architectures.len(), 1);
        if cfg!(target_os = "linux") {
            assert!(binary.glibc.is_some());
            assert!(binary.needed.iter().any(|library| library.starts_with("libc.so")));
        }
    }

    /// A universal file: the processors' numbers in macOS and what is for them.
    fn universal_file(parts: &[(u32, Vec<u8>)]) -> Vec<u8> {
        let mut header = vec![0xca_fe_ba_be, parts.len() as u32];
        let mut content = Vec::new();
        for (processor, part) in parts {
            let start = 4096 + content.len() as u32;
            header.extend([*processor, 0, start, part.len() as u32, 3]);
            content.extend(part);
            content.resize(content.len().next_multiple_of(8), 0);
        }
        let mut bytes: Vec<u8> = header.iter().flat_map(|number: &u32| number.to_be_bytes()).collect();
        bytes.resize(4096, 0);
        bytes.extend(content);
        bytes
    }

    const X86_64: u32 = 0x0100_0007;
    const ARM64: u32 = 0x0100_000c;

    #[test]
    fn both_parts_of_a_universal_file_are_read() {
        let file = universal_file(&[
            (X86_64, macos(Architecture::X86_64, &["fmiDoStep", "plcfmu_interface"])),
            (ARM64, macos(Architecture::Aarch64, &["fmiDoStep", "plcfmu_interface"])),
        ]);
        let binary = Binary::read(&file).unwrap();
        assert_eq!(binary.architectures, ["x86_64", "aarch64"]);
        assert_eq!(binary.functions, ["fmiDoStep"]);
        assert!(binary.has_table);
    }

    #[test]
    fn the_parts_of_a_universal_file_must_agree() {
        let first = macos(Architecture::X86_64, &["fmiDoStep", "fmiReset"]);
        let second = macos(Architecture::Aarch64, &["fmiDoStep"]);
        let file = universal_file(&[(X86_64, first.clone()), (ARM64, second)]);
        assert_eq!(sentence(Binary::read(&file)), "its parts for x86_64 and aarch64 export different functions");
        let file = universal_file(&[(X86_64, first), (ARM64, b"nothing".to_vec())]);
        assert!(sentence(Binary::read(&file)).starts_with("its part for aarch64 is damaged: "));
        let file = universal_file(&[]);
        assert_eq!(sentence(Binary::read(&file)), "it is a universal binary for 0 processors; 1 to 8 are accepted");
    }
}
