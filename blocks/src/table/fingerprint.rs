//! Fingerprints: 128-bit hashes and their text form.

/// The hash of empty input.
pub const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;

const PRIME: u128 = (1 << 88) + 0x13b;

/// Extends `hash` by `bytes`: 128-bit FNV-1a (Fowler, Noll, Vo). Each step is a bijection, so changing any one byte
/// changes the hash.
pub const fn hash(mut hash: u128, bytes: &[u8]) -> u128 {
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u128).wrapping_mul(PRIME);
        i += 1;
    }
    hash
}

/// Returns the hash of `bytes`.
pub const fn checksum(bytes: &[u8]) -> u128 {
    hash(BASIS, bytes)
}

/// Formats the hash as hexadecimal digits: `{00000000-0000-0000-0000-000000000000}`.
pub const fn text(hash: u128) -> [u8; 38] {
    const DIGITS: [u8; 16] = *b"0123456789abcdef";
    const PLACES: [usize; 16] = [1, 3, 5, 7, 10, 12, 15, 17, 20, 22, 25, 27, 29, 31, 33, 35];
    let bytes = hash.to_be_bytes();
    let mut text = *b"{00000000-0000-0000-0000-000000000000}";
    let mut i = 0;
    while i < 16 {
        text[PLACES[i]] = DIGITS[(bytes[i] >> 4) as usize];
        text[PLACES[i] + 1] = DIGITS[(bytes[i] & 15) as usize];
        i += 1;
    }
    text
}

/// Parses the text produced by [`text`]; `None` for any other string.
pub fn parse(of: &str) -> Option<u128> {
    let digits = of.strip_prefix('{')?.strip_suffix('}')?.replace('-', "");
    u128::from_str_radix(&digits, 16).ok().filter(|hash| text(*hash) == of.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv_1a_with_128_bits() {
        // The authors' test vectors.
        assert_eq!(checksum(b""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(checksum(b"a"), 0xd228cb696f1a8caf78912b704e4a8964);
        assert_eq!(checksum(b"foobar"), 0x343e1662793c64bf6f0d3597ba446f18);
    }

    #[test]
    fn a_hash_is_written_byte_by_byte_in_hexadecimal_digits() {
        assert_eq!(&text(0x0123_4567_89ab_cdef_fedc_ba98_7654_3210), b"{01234567-89ab-cdef-fedc-ba9876543210}");
        assert_eq!(parse("{01234567-89ab-cdef-fedc-ba9876543210}"), Some(0x0123_4567_89ab_cdef_fedc_ba98_7654_3210));
        assert_eq!([parse("{1}"), parse("{+1234567-89ab-cdef-fedc-ba9876543210}"), parse("")], [None; 3]);
    }
}
