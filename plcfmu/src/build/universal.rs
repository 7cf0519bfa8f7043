//! Universal macOS files: one file with a library for each processor.

use anyhow::{Context, Result, ensure};
use object::Endianness;
use object::macho::{FAT_MAGIC, MachHeader64};
use object::read::macho::MachHeader;

/// Each library begins at a multiple of 2 to this power in bytes, the page size of Apple's processors.
const ALIGNMENT: u32 = 14;

/// Joins libraries that are each for a single processor.
///
/// # Errors
/// One of them is not a 64-bit macOS library, or two are for the same processor.
pub fn join(libraries: &[Vec<u8>]) -> Result<Vec<u8>> {
    let page = 1 << ALIGNMENT;
    let mut header = vec![FAT_MAGIC, u32::try_from(libraries.len())?];
    let mut processors = Vec::new();
    let mut content = Vec::new();
    for library in libraries {
        let (processor, subtype) = processor(library)?;
        ensure!(!processors.contains(&processor), "two libraries for the same processor cannot be joined");
        processors.push(processor);
        // The header fits into the first page.
        let start = page + content.len();
        header.extend([processor, subtype, u32::try_from(start)?, u32::try_from(library.len())?, ALIGNMENT]);
        content.extend(library);
        content.resize(content.len().next_multiple_of(page), 0);
    }
    // No padding after the last library.
    let padding = libraries.last().map_or(0, |last| last.len().next_multiple_of(page) - last.len());
    content.truncate(content.len() - padding);
    let mut file: Vec<u8> = header.into_iter().flat_map(u32::to_be_bytes).collect();
    file.resize(page, 0);
    file.extend(content);
    Ok(file)
}

/// The CPU type and subtype in a library's header.
fn processor(library: &[u8]) -> Result<(u32, u32)> {
    let header = MachHeader64::<Endianness>::parse(library, 0);
    let read =
        header.and_then(|header| header.endian().map(|endian| (header.cputype(endian).0, header.cpusubtype(endian).0)));
    read.context("it is not a 64-bit macOS library for one processor")
}

#[cfg(test)]
mod tests {
    use super::*;
    use doubles::macos;
    use host::package::binary::Binary;
    use object::Architecture;

    #[test]
    fn a_universal_file_holds_both_libraries_unchanged_at_pages_of_their_own() {
        let intel = macos(Architecture::X86_64, &["fmiDoStep"]);
        let apple = macos(Architecture::Aarch64, &["fmiDoStep"]);
        let file = join(&[intel.clone(), apple.clone()]).unwrap();
        let binary = Binary::read(&file).unwrap();
        assert_eq!(binary.architectures, ["x86_64", "aarch64"]);
        assert_eq!(binary.functions, ["fmiDoStep"]);
        assert_eq!(file[0x4000..0x4000 + intel.len()], intel);
        assert_eq!(file[0x8000..], apple);
    }

    #[test]
    fn only_libraries_for_different_processors_are_joined() {
        let intel = macos(Architecture::X86_64, &["fmiDoStep"]);
        assert_eq!(
            join(&[intel.clone(), intel]).unwrap_err().to_string(),
            "two libraries for the same processor cannot be joined"
        );
        let error = join(&[b"\x7fELF".to_vec()]).unwrap_err().to_string();
        assert_eq!(error, "it is not a 64-bit macOS library for one processor");
    }
}
