//! Formats bytes as hexadecimal digits.

/// Two lower-case hexadecimal digits for each byte.
pub fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn each_byte_has_two_digits() {
        assert_eq!(super::digits(&[0, 9, 0xab, 255]), "0009abff");
    }
}
