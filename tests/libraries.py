"""What a library file exports, read from the file: ELF (Linux) or PE (Windows)."""

import struct

from elftools.elf.elffile import ELFFile


def exports(path):
    """The names that a library exports, or None if it is of a format that is not read here."""
    start = path.read_bytes()[:4]
    if start == b"\x7fELF":
        return elf_exports(path)
    if start[:2] == b"MZ":
        return pe_exports(path.read_bytes())
    return None


def elf_exports(path):
    with path.open("rb") as file:
        symbols = ELFFile(file).get_section_by_name(".dynsym").iter_symbols()
        return {s.name for s in symbols if s["st_shndx"] != "SHN_UNDEF" and s.name}


def pe_exports(content):
    """The names in the export directory, the first of the data directories in the optional header."""

    def number(offset, format="<I"):
        return struct.unpack_from(format, content, offset)[0]

    header = number(0x3C)
    assert content[header : header + 4] == b"PE\0\0"
    sections, optional_size = number(header + 6, "<H"), number(header + 20, "<H")
    optional = header + 24
    directories = optional + {0x10B: 96, 0x20B: 112}[number(optional, "<H")]

    def offset(address):
        """Where in the file stands what is loaded to this address."""
        for section in range(sections):
            place = optional + optional_size + 40 * section
            size, start, size_in_file, start_in_file = struct.unpack_from("<4I", content, place + 8)
            if start <= address < start + max(size, size_in_file):
                return address - start + start_in_file
        raise ValueError(f"no section has the address {address:#x}")

    directory = offset(number(directories))
    count, names = number(directory + 24), offset(number(directory + 32))
    starts = [offset(number(names + 4 * index)) for index in range(count)]
    return {content[start : content.index(b"\0", start)].decode() for start in starts}
