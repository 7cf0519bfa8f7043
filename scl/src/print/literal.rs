//! Prints constants.

use super::Dialect;
use crate::check::types::{Class, Elementary};
use crate::ir::Value;

/// A constant of a type. If `is_bare`, it is printed without a type where possible: the context determines it.
///
/// A floating-point number is printed as the shortest decimal that reads back as the same bits; infinity, NaN and
/// negative zero are printed as bits.
///
/// # Errors
/// The dialect does not have the type.
pub(crate) fn literal(value: Value, of: Elementary, is_bare: bool, dialect: Dialect) -> Result<String, String> {
    dialect.check(of)?;
    // A bit string is unsigned, even if its scalar is signed.
    let is_signed = value.ty().is_signed() && of.class() != Class::Bits;
    let value = if is_signed { value } else { Value::new(of.scalar(), value.bits()) };
    let whole: i128 = if is_signed { i128::from(value.bits() as i64) } else { i128::from(value.bits()) };
    Ok(match of.class() {
        Class::Bool => if value.bits() != 0 { "TRUE" } else { "FALSE" }.to_string(),
        Class::Real => real(value, of, is_bare),
        Class::Time => duration(whole, of),
        Class::Bits if is_bare => {
            if whole < 10 {
                whole.to_string()
            } else {
                format!("16#{whole:X}")
            }
        }
        Class::Bits => {
            let prefix = match of {
                Elementary::Byte => "B",
                Elementary::Word => "W",
                Elementary::DWord => "DW",
                _ => "LW",
            };
            format!("{prefix}#16#{whole:X}")
        }
        // The lowest number cannot be written bare: its magnitude is out of range.
        _ if is_bare && whole > of.range().0 => whole.to_string(),
        Class::Character => format!("{}#16#{whole:X}", bits_of(of).name()),
        _ => format!("{}#{whole}", of.name()),
    })
}

fn bits_of(of: Elementary) -> Elementary {
    Elementary::bit_string(of.bits())
}

fn real(value: Value, of: Elementary, is_bare: bool) -> String {
    let number = value.number();
    let is_negative_zero = number == 0.0 && number.is_sign_negative();
    if !number.is_finite() || is_negative_zero {
        return match of {
            Elementary::Real => format!("DWORD_TO_REAL(DW#16#{:08X})", value.bits()),
            _ => format!("LWORD_TO_LREAL(LW#16#{:016X})", value.bits()),
        };
    }
    // Debug always prints a point or an exponent; SCL requires the point even with an exponent.
    let magnitude = number.abs();
    let is_long = magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude);
    let text = match (of, is_long) {
        (Elementary::Real, true) => format!("{:E}", number as f32),
        (Elementary::Real, false) => format!("{:?}", number as f32),
        (_, true) => format!("{number:E}"),
        (_, false) => format!("{number:?}"),
    };
    let text = match text.split_once('E') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.0E{exponent}"),
        _ => text,
    };
    if is_bare { text } else { format!("{}#{text}", of.name()) }
}

/// A duration such as `T#1m30s`.
fn duration(count: i128, of: Elementary) -> String {
    let (prefix, units): (&str, &[(&str, i128)]) = match of {
        Elementary::Time => ("T", &[("d", 86_400_000), ("h", 3_600_000), ("m", 60_000), ("s", 1000), ("ms", 1)]),
        _ => (
            "LT",
            &[
                ("d", 86_400_000_000_000),
                ("h", 3_600_000_000_000),
                ("m", 60_000_000_000),
                ("s", 1_000_000_000),
                ("ms", 1_000_000),
                ("us", 1000),
                ("ns", 1),
            ],
        ),
    };
    let mut rest = count.abs();
    let mut text = String::new();
    for (name, size) in units {
        if rest >= *size {
            text += &format!("{}{name}", rest / size);
            rest %= size;
        }
    }
    if text.is_empty() {
        text = if of == Elementary::Time { "0ms" } else { "0ns" }.to_string();
    }
    format!("{prefix}#{}{text}", if count < 0 { "-" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::constant::{self, Literal};

    #[test]
    fn reals_are_the_shortest_decimals_that_are_read_as_the_same_bits() {
        let of = |number: f32| literal(number.into(), Elementary::Real, true, Dialect::Tia).unwrap();
        assert_eq!(of(0.1), "0.1");
        assert_eq!(of(100.0), "100.0");
        assert_eq!(of(2_147_483_648.0), "2.1474836E9");
        assert_eq!(of(1e-30), "1.0E-30");
        assert_eq!(of(f32::NEG_INFINITY), "DWORD_TO_REAL(DW#16#FF800000)");
        assert_eq!(of(-0.0), "DWORD_TO_REAL(DW#16#80000000)");
        for exponent in 0..255_u32 {
            for mantissa in [0, 1, 0x2A_AAAA, 0x55_5555, 0x7F_FFFF] {
                let number = f32::from_bits(exponent << 23 | mantissa);
                if number.is_finite() {
                    let Ok(Literal::Fraction(_, read, None)) = constant::read(&of(number)) else { panic!("{number}") };
                    assert_eq!(read.to_bits(), number.to_bits(), "{}", of(number));
                }
            }
        }
    }

    #[test]
    fn durations_are_written_in_their_units() {
        let of = |count: i32| literal(count.into(), Elementary::Time, true, Dialect::Step7).unwrap();
        assert_eq!(of(20_000), "T#20s");
        assert_eq!(of(90_500), "T#1m30s500ms");
        assert_eq!(of(0), "T#0ms");
        assert_eq!(of(i32::MIN), "T#-24d20h31m23s648ms");
        for count in [0, 1, -1, 20_000, i32::MAX, i32::MIN] {
            let Ok(Literal::Whole(read, _)) = constant::read(&of(count)) else { panic!("{count}") };
            assert_eq!(read, i128::from(count));
        }
    }

    #[test]
    fn numbers_have_their_type_where_nothing_else_tells_it() {
        let of = |value: Value, of, is_bare| literal(value, of, is_bare, Dialect::Tia).unwrap();
        assert_eq!(of(5_i16.into(), Elementary::Int, true), "5");
        assert_eq!(of(5_i16.into(), Elementary::Int, false), "INT#5");
        assert_eq!(of(i32::MIN.into(), Elementary::DInt, true), "DINT#-2147483648");
        assert_eq!(of(0x6C00_u16.into(), Elementary::Word, false), "W#16#6C00");
        assert_eq!(of(0.5_f32.into(), Elementary::Real, false), "REAL#0.5");
        let refused = literal(0.5_f64.into(), Elementary::LReal, true, Dialect::Step7).unwrap_err();
        assert!(refused.contains("LREAL"), "{refused}");
    }
}
