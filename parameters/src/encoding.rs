//! Text encodings: the defaults of PLC tools and, with the feature `encodings`, any encoding the user names.

#[cfg(feature = "encodings")]
use encoding_rs::Encoding as Named;

/// A text encoding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    Utf8,
    Utf16Le,
    Utf16Be,
    /// The encoding that STEP 7 writes.
    Windows1252,
    #[cfg(feature = "encodings")]
    Named(&'static Named),
}

/// The characters of Windows-1252 from 0x80 to 0x9F; all other bytes are their own code points.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘', '’',
    '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

impl Encoding {
    /// The encoding indicated by a byte order mark at the start of the bytes, and the length of the mark.
    pub(crate) fn of_mark(bytes: &[u8]) -> Option<(Encoding, usize)> {
        match bytes {
            [0xEF, 0xBB, 0xBF, ..] => Some((Encoding::Utf8, 3)),
            [0xFF, 0xFE, ..] => Some((Encoding::Utf16Le, 2)),
            [0xFE, 0xFF, ..] => Some((Encoding::Utf16Be, 2)),
            _ => None,
        }
    }

    /// The encoding with this name, as used by browsers.
    pub(crate) fn named(name: &str) -> Option<Encoding> {
        #[cfg(feature = "encodings")]
        return Named::for_label(name.as_bytes()).map(Encoding::Named);
        #[cfg(not(feature = "encodings"))]
        match name.to_ascii_lowercase().as_str() {
            "utf-8" => Some(Encoding::Utf8),
            "utf-16le" => Some(Encoding::Utf16Le),
            "utf-16be" => Some(Encoding::Utf16Be),
            "windows-1252" => Some(Encoding::Windows1252),
            _ => None,
        }
    }

    /// Decodes bytes without a byte order mark; invalid sequences become U+FFFD.
    pub(crate) fn decode(self, bytes: &[u8]) -> String {
        let wide = |unit: fn([u8; 2]) -> u16| {
            let pairs = bytes.chunks_exact(2);
            let is_odd = !pairs.remainder().is_empty();
            let mut units: Vec<u16> = pairs.map(|pair| unit([pair[0], pair[1]])).collect();
            if is_odd && units.last().is_none_or(|last| !(0xD800..0xDC00).contains(last)) {
                // The odd byte at the end: an unpaired surrogate takes its place, which becomes U+FFFD below.
                units.push(0xD800);
            }
            char::decode_utf16(units).map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
        };
        match self {
            Encoding::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
            Encoding::Utf16Le => wide(u16::from_le_bytes),
            Encoding::Utf16Be => wide(u16::from_be_bytes),
            Encoding::Windows1252 => bytes.iter().map(|byte| of_byte(*byte)).collect(),
            #[cfg(feature = "encodings")]
            Encoding::Named(encoding) => encoding.decode_without_bom_handling(bytes).0.into_owned(),
        }
    }

    /// Encodes a string; `None` if the encoding lacks one of its characters.
    pub(crate) fn encode(self, text: &str) -> Option<Vec<u8>> {
        match self {
            Encoding::Utf8 => Some(text.as_bytes().to_vec()),
            Encoding::Utf16Le => Some(text.encode_utf16().flat_map(u16::to_le_bytes).collect()),
            Encoding::Utf16Be => Some(text.encode_utf16().flat_map(u16::to_be_bytes).collect()),
            Encoding::Windows1252 => text.chars().map(to_byte).collect(),
            #[cfg(feature = "encodings")]
            Encoding::Named(encoding) => match encoding.encode(text) {
                // For some encodings, such as UTF-16, the encoder writes UTF-8 instead, as browsers do.
                (bytes, written, false) if written == encoding => Some(bytes.into_owned()),
                _ => None,
            },
        }
    }
}

fn of_byte(byte: u8) -> char {
    match byte {
        0x80..=0x9F => WINDOWS_1252[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn to_byte(character: char) -> Option<u8> {
    let place = WINDOWS_1252.iter().position(|other| *other == character);
    let of_place = place.and_then(|place| u8::try_from(0x80 + place).ok());
    of_place.or_else(|| u8::try_from(u32::from(character)).ok().filter(|byte| !(0x80..=0x9F).contains(byte)))
}

#[cfg(all(test, feature = "encodings"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SAME: [(Encoding, &str); 4] = [
        (Encoding::Utf8, "utf-8"),
        (Encoding::Utf16Le, "utf-16le"),
        (Encoding::Utf16Be, "utf-16be"),
        (Encoding::Windows1252, "windows-1252"),
    ];

    proptest! {
        #[test]
        fn any_bytes_are_read_as_browsers_do(bytes: Vec<u8>) {
            for (own, name) in SAME {
                prop_assert_eq!(own.decode(&bytes), Encoding::named(name).unwrap().decode(&bytes), "{}", name);
            }
        }
    }

    #[test]
    fn windows_1252_is_written_as_browsers_do() {
        let named = Encoding::named("windows-1252").unwrap();
        for character in ('\0'..='\u{17f}').chain(['€', '…', 'Ж', '\u{1f600}']) {
            let text = character.to_string();
            assert_eq!(Encoding::Windows1252.encode(&text), named.encode(&text), "{character:?}");
        }
    }
}
