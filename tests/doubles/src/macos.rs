//! A library of macOS.

use object::write::{self, Symbol, SymbolSection};
use object::{Architecture, BinaryFormat, SymbolFlags, SymbolKind, SymbolScope};

/// A small file of macOS with these functions.
pub fn macos(architecture: Architecture, functions: &[&str]) -> Vec<u8> {
    let mut object = write::Object::new(BinaryFormat::MachO, architecture, object::Endianness::Little);
    let section = object.section_id(write::StandardSection::Text);
    for name in functions {
        let symbol = object.add_symbol(Symbol {
            name: name.as_bytes().to_vec(),
            value: 0,
            size: 0,
            kind: SymbolKind::Text,
            scope: SymbolScope::Dynamic,
            weak: false,
            section: SymbolSection::Undefined,
            flags: SymbolFlags::None,
        });
        object.add_symbol_data(symbol, section, &[0; 4], 4);
    }
    object.write().unwrap()
}
