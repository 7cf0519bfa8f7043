//! What a library's file says: which functions it exports, and what it asks of the system it is loaded in. Nothing is
//! loaded.

use crate::host::library::FUNCTIONS;
use object::elf;
use object::read::elf::{ElfFile32, ElfFile64, FileHeader};
use object::read::macho::FatArch;
use object::{Endianness, FileKind, NameOrOrdinal, Object};

/// What a library exports and needs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Binary {
    /// The exported functions of FMI, sorted.
    pub functions: Vec<String>,
    /// The newest glibc whose symbols a Linux library needs, such as `2.14`.
    pub glibc: Option<String>,
    /// The libraries that a Linux library needs.
    pub needed: Vec<String>,
}

impl Binary {
    /// Reads a library of Linux, Windows or macOS.
    ///
    /// # Errors
    /// The bytes are no such library.
    pub fn read(bytes: &[u8]) -> Result<Binary, String> {
        parse(bytes).map_err(|error| format!("it is no library of Linux, Windows or macOS: {error}"))
    }

    /// The functions of co-simulation that are missing, with commas between; `None` if all are there.
    pub fn missing(&self) -> Option<String> {
        let missing: Vec<_> =
            FUNCTIONS.iter().copied().filter(|name| !self.functions.iter().any(|own| own == name)).collect();
        (!missing.is_empty()).then(|| missing.join(", "))
    }

    /// Checks that the 34 functions are exported and no other of FMI.
    ///
    /// # Errors
    /// The functions that are missing or too many.
    pub fn check_functions(&self) -> Result<(), String> {
        if let Some(missing) = self.missing() {
            return Err(format!("it does not export {missing}"));
        }
        match self.functions.iter().find(|name| !FUNCTIONS.contains(&name.as_str())) {
            Some(name) => Err(format!("it exports {name}, which is no function of FMI 2.0 for co-simulation")),
            None => Ok(()),
        }
    }

    /// Checks that a Linux library runs where there is a glibc of this version and nothing else.
    ///
    /// # Errors
    /// The version or library that it needs beyond that.
    pub fn check_portable(&self, glibc: &str) -> Result<(), String> {
        if let Some(own) = self.glibc.as_deref().filter(|own| version(own) > version(glibc)) {
            return Err(format!("it needs glibc {own}; a portable library needs none newer than {glibc}"));
        }
        match self.needed.iter().find(|library| library.starts_with("libgcc_s")) {
            Some(library) => Err(format!("it needs {library}, which not every Linux has")),
            None => Ok(()),
        }
    }
}

/// A version such as `2.17`, to compare: 2.4 is older than 2.17.
pub(crate) fn version(text: &str) -> Vec<u32> {
    text.split('.').map(|part| part.parse().unwrap_or(u32::MAX)).collect()
}

fn parse(bytes: &[u8]) -> Result<Binary, String> {
    let text = |error: object::Error| error.to_string();
    let kind = FileKind::parse(bytes).map_err(text)?;
    // A universal file of macOS holds a library for each processor; the first speaks for all.
    let bytes = match kind {
        FileKind::MachOFat32 => {
            let fat = object::read::macho::MachOFatFile32::parse(bytes).map_err(text)?;
            fat.arches().first().ok_or("it is empty")?.data(bytes).map_err(text)?
        }
        _ => bytes,
    };
    let file = object::File::parse(bytes).map_err(text)?;
    let mut binary = Binary::default();
    for export in file.exports().map_err(text)? {
        if let NameOrOrdinal::Name(name) = export.map_err(text)?.name() {
            // macOS puts an underscore in front of C's names.
            let name = String::from_utf8_lossy(name);
            let name = name.strip_prefix('_').unwrap_or(&name);
            if name.starts_with("fmi") {
                binary.functions.push(name.to_string());
            }
        }
    }
    binary.functions.sort();
    match kind {
        FileKind::Elf64 => {
            let file = ElfFile64::<Endianness>::parse(bytes).map_err(text)?;
            linux(&mut binary, file.elf_header(), bytes).map_err(text)?;
        }
        FileKind::Elf32 => {
            let file = ElfFile32::<Endianness>::parse(bytes).map_err(text)?;
            linux(&mut binary, file.elf_header(), bytes).map_err(text)?;
        }
        _ => {}
    }
    Ok(binary)
}

/// What a Linux library needs.
fn linux<Elf: FileHeader<Endian = Endianness>>(binary: &mut Binary, header: &Elf, bytes: &[u8]) -> object::Result<()> {
    let endian = header.endian()?;
    let sections = header.sections(endian, bytes)?;
    let dynamic = sections.dynamic_table(endian, bytes)?;
    for entry in &dynamic {
        if entry.tag == elf::DT_NEEDED {
            binary.needed.push(String::from_utf8_lossy(dynamic.string(entry)?).into_owned());
        }
    }
    if let Some((mut libraries, strings)) = sections.gnu_verneed(endian, bytes)? {
        let strings = sections.strings(endian, bytes, strings)?;
        while let Some((_, mut versions)) = libraries.next()? {
            while let Some(entry) = versions.next()? {
                let name = String::from_utf8_lossy(entry.name(endian, strings)?);
                if let Some(glibc) = name.strip_prefix("GLIBC_")
                    && binary.glibc.as_deref().is_none_or(|newest| version(newest) < version(glibc))
                {
                    binary.glibc = Some(glibc.to_string());
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary() -> Binary {
        let mut functions: Vec<String> = FUNCTIONS.iter().map(|name| name.to_string()).collect();
        functions.sort();
        Binary { functions, glibc: Some("2.16".into()), needed: vec!["libc.so.6".into()] }
    }

    #[test]
    fn all_functions_and_no_other_of_fmi_are_exported() {
        assert_eq!(binary().check_functions(), Ok(()));
        let mut binary = binary();
        binary.functions.push("fmi2NewDiscreteStates".into());
        assert_eq!(
            binary.check_functions().unwrap_err(),
            "it exports fmi2NewDiscreteStates, which is no function of FMI 2.0 for co-simulation"
        );
        binary.functions.retain(|name| name != "fmi2DoStep" && name != "fmi2Reset");
        assert_eq!(binary.check_functions().unwrap_err(), "it does not export fmi2Reset, fmi2DoStep");
    }

    #[test]
    fn a_portable_library_needs_an_old_glibc_and_nothing_else() {
        let mut binary = binary();
        assert_eq!(binary.check_portable("2.17"), Ok(()));
        binary.glibc = Some("2.17".into());
        assert_eq!(binary.check_portable("2.17"), Ok(()));
        for newer in ["2.18", "2.34", "2.17.1", "3"] {
            binary.glibc = Some(newer.into());
            assert_eq!(
                binary.check_portable("2.17").unwrap_err(),
                format!("it needs glibc {newer}; a portable library needs none newer than 2.17")
            );
        }
        // 2.4 is older than 2.17, though 4 is more than 1.
        binary.glibc = Some("2.4".into());
        assert_eq!(binary.check_portable("2.17"), Ok(()));
        binary.needed.push("libgcc_s.so.1".into());
        assert_eq!(binary.check_portable("2.17").unwrap_err(), "it needs libgcc_s.so.1, which not every Linux has");
    }

    #[test]
    fn what_is_no_library_is_refused() {
        for bytes in [&b""[..], b"hello", b"\x7fELF\x02\x01\x01"] {
            assert!(Binary::read(bytes).unwrap_err().starts_with("it is no library of Linux, Windows or macOS: "));
        }
    }

    #[test]
    fn the_test_program_itself_can_be_read() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let binary = Binary::read(&program).unwrap();
        assert_eq!(binary.functions, [""; 0]);
        if cfg!(target_os = "linux") {
            assert!(binary.glibc.is_some());
            assert!(binary.needed.iter().any(|library| library.starts_with("libc.so")));
        }
    }
}
