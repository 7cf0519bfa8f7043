//! Serialization of values as bytes, little-endian on every machine, for saved FMU states.

use crate::table::{Time, Word};

/// A value that can be serialized and restored bit for bit.
pub trait Stored: Sized {
    /// Appends the value's bytes.
    fn write(&self, bytes: &mut Vec<u8>);

    /// Reads a value from the front; `None` if there are too few bytes, or they are not a valid value.
    fn read(bytes: &mut &[u8]) -> Option<Self>;
}

macro_rules! stored_numbers {
    ($($number:ty)*) => { $(
        impl Stored for $number {
            fn write(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }

            fn read(bytes: &mut &[u8]) -> Option<Self> {
                let (number, rest) = bytes.split_first_chunk()?;
                *bytes = rest;
                Some(<$number>::from_le_bytes(*number))
            }
        }
    )* };
}

stored_numbers!(u8 i8 u16 i16 u32 i32 u64 i64 f32 f64);

impl Stored for bool {
    fn write(&self, bytes: &mut Vec<u8>) {
        u8::from(*self).write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        match u8::read(bytes)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl Stored for Time {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.milliseconds().write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        i32::read(bytes).map(Time::ms)
    }
}

impl Stored for Word {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.value().write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        i16::read(bytes).map(Word::new)
    }
}

impl<T: Stored> Stored for Option<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.is_some().write(bytes);
        if let Some(value) = self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        if bool::read(bytes)? { T::read(bytes).map(Some) } else { Some(None) }
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.len() as u64).write(bytes);
        for value in self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let length = u64::read(bytes)?;
        // Every value takes at least one byte: a length beyond the remaining bytes means corruption, so no memory is
        // reserved for it.
        if length > bytes.len() as u64 {
            return None;
        }
        (0..length).map(|_| T::read(bytes)).collect()
    }
}

impl<T: Stored + Default + Copy, const N: usize> Stored for [T; N] {
    fn write(&self, bytes: &mut Vec<u8>) {
        for value in self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::read(bytes)?;
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_of(value: &impl Stored) -> Vec<u8> {
        let mut bytes = Vec::new();
        value.write(&mut bytes);
        bytes
    }

    #[test]
    fn numbers_are_little_endian_and_come_back_bit_for_bit() {
        assert_eq!(bytes_of(&0x0102_0304_u32), [4, 3, 2, 1]);
        let nan = f32::from_bits(0x7FC0_1234);
        let bytes = bytes_of(&nan);
        assert_eq!(f32::read(&mut &bytes[..]).unwrap().to_bits(), nan.to_bits());
        assert_eq!(f64::read(&mut &bytes_of(&-0.0)[..]).unwrap().to_bits(), (-0.0f64).to_bits());
    }

    #[test]
    fn too_few_bytes_and_values_that_a_type_does_not_have_are_refused() {
        assert_eq!(u32::read(&mut &[1, 2, 3][..]), None);
        assert_eq!(bool::read(&mut &[2][..]), None);
        assert_eq!(<[i16; 2]>::read(&mut &[0, 0, 0][..]), None);
    }

    #[test]
    fn a_list_with_a_damaged_length_is_refused_before_memory_is_reserved() {
        let bytes = bytes_of(&u64::MAX);
        assert_eq!(Vec::<f64>::read(&mut &bytes[..]), None);
        let list = vec![1.5, -2.5];
        assert_eq!(Vec::<f64>::read(&mut &bytes_of(&list)[..]), Some(list));
    }

    #[test]
    fn a_list_takes_its_length_and_nothing_behind_it() {
        let mut bytes = bytes_of(&vec![7_u8, 8, 9]);
        assert_eq!(Vec::<u8>::read(&mut &bytes[..]), Some(vec![7, 8, 9]));
        bytes.push(10);
        let mut rest = &bytes[..];
        assert_eq!((Vec::<u8>::read(&mut rest), rest), (Some(vec![7, 8, 9]), &[10][..]));
    }

    #[test]
    fn a_value_that_may_be_missing_comes_back_missing_or_not() {
        for value in [None, Some(5_i16)] {
            let bytes = bytes_of(&value);
            let mut rest = &bytes[..];
            assert_eq!((Option::<i16>::read(&mut rest), rest.len()), (Some(value), 0));
        }
    }
}
