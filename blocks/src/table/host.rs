//! The host types of PLC values.

use super::fingerprint::{BASIS, hash};
use super::kind::Kind;

named! {
    /// The types presented to a host.
    Types {
        /// The PLC's own types, and arrays.
        Native "native";
        /// The few types that every host supports: doubles for floating-point numbers and durations, 32-bit integers
        /// for types that fit into them, 64-bit integers for the others, and one variable per array element.
        Wide "wide";
    }
}

impl Types {
    /// Returns the host type for the values of a PLC type; a WORD may be an analog value, which is signed.
    pub const fn host_type(self, kind: Kind, is_analog: bool) -> &'static str {
        match (self, kind) {
            (Types::Native, Kind::Word) if is_analog => "Int16",
            (_, Kind::Bool) => "Boolean",
            (Types::Native, Kind::Real) => "Float32",
            (_, Kind::Real | Kind::LReal) => "Float64",
            (Types::Wide, Kind::Time | Kind::LTime) => "Float64",
            (Types::Native, Kind::Time | Kind::DInt) => "Int32",
            (Types::Native, Kind::Int) => "Int16",
            (Types::Native, Kind::SInt) => "Int8",
            (Types::Native, Kind::USInt | Kind::Byte) => "UInt8",
            (Types::Native, Kind::UInt | Kind::Word) => "UInt16",
            (Types::Native, Kind::UDInt | Kind::DWord) => "UInt32",
            (_, Kind::ULInt | Kind::LWord) => "UInt64",
            (_, Kind::LInt | Kind::LTime) | (Types::Wide, Kind::UDInt) => "Int64",
            (Types::Wide, _) => "Int32",
        }
    }

    /// Whether an array is a single variable.
    pub const fn has_arrays(self) -> bool {
        matches!(self, Types::Native)
    }

    /// Returns the unit, ms or ns, of a duration that these host types represent as an integer; `None` for any other
    /// type.
    pub const fn unit(self, kind: Kind) -> Option<&'static str> {
        match (self, kind) {
            (Types::Native, Kind::Time) => Some("ms"),
            (Types::Native, Kind::LTime) => Some("ns"),
            _ => None,
        }
    }

    /// Returns the hash from which the instantiation token is formed: derived from the hash `of` the interface, and
    /// different for each choice of types.
    pub const fn token(self, of: u128) -> u128 {
        hash(hash(hash(BASIS, &of.to_be_bytes()), b"3"), self.name().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_plc_type_has_the_type_of_its_width_or_one_that_holds_it() {
        for kind in Kind::ALL {
            for is_analog in [false, true] {
                let native = Types::Native.host_type(*kind, is_analog);
                let bits: usize = native.trim_start_matches(|one: char| one.is_ascii_alphabetic()).parse().unwrap_or(0);
                assert_eq!(bits, kind.width() * 8, "{}", kind.name());
                let wide = Types::Wide.host_type(*kind, is_analog);
                assert!(["Float64", "Int32", "Int64", "UInt64", "Boolean"].contains(&wide));
            }
        }
        assert_eq!([false, true].map(|is_analog| Types::Native.host_type(Kind::Word, is_analog)), ["UInt16", "Int16"]);
    }

    #[test]
    fn each_choice_of_types_has_a_token_of_its_own() {
        let all = [1, 2].map(|hash| [hash, Types::Native.token(hash), Types::Wide.token(hash)]).concat();
        for (place, one) in all.iter().enumerate() {
            assert!(!all[..place].contains(one));
        }
    }
}
