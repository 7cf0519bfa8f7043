//! The physical units that a block's table may use, and their definitions in SI units.

/// The definition of a unit: a value in SI base units is `factor` * value + `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)] // A is the ampere, K the kelvin
pub struct Definition {
    /// Exponent of the kilogram.
    pub kg: i32,
    /// Exponent of the metre.
    pub m: i32,
    /// Exponent of the second.
    pub s: i32,
    /// Exponent of the ampere.
    pub A: i32,
    /// Exponent of the kelvin.
    pub K: i32,
    /// Exponent of the radian.
    pub rad: i32,
    /// The factor by which a value is multiplied.
    pub factor: f64,
    /// The offset added to the product.
    pub offset: f64,
}

/// The dimensionless unit, from which other definitions are derived.
const NONE: Definition = Definition { kg: 0, m: 0, s: 0, A: 0, K: 0, rad: 0, factor: 1.0, offset: 0.0 };

const SECOND: Definition = Definition { s: 1, ..NONE };
const METRE: Definition = Definition { m: 1, ..NONE };
const SQUARE_METRE: Definition = Definition { m: 2, ..NONE };
const CUBIC_METRE: Definition = Definition { m: 3, ..NONE };
const CUBIC_METRE_PER_SECOND: Definition = Definition { m: 3, s: -1, ..NONE };
const METRE_PER_SECOND: Definition = Definition { m: 1, s: -1, ..NONE };
const KILOGRAM: Definition = Definition { kg: 1, ..NONE };
const KILOGRAM_PER_SECOND: Definition = Definition { kg: 1, s: -1, ..NONE };
const KELVIN: Definition = Definition { K: 1, ..NONE };
const KELVIN_PER_SECOND: Definition = Definition { K: 1, s: -1, ..NONE };
const PASCAL: Definition = Definition { kg: 1, m: -1, s: -2, ..NONE };
const NEWTON: Definition = Definition { kg: 1, m: 1, s: -2, ..NONE };
const JOULE: Definition = Definition { kg: 1, m: 2, s: -2, ..NONE };
const WATT: Definition = Definition { kg: 1, m: 2, s: -3, ..NONE };
const AMPERE: Definition = Definition { A: 1, ..NONE };
const VOLT: Definition = Definition { kg: 1, m: 2, s: -3, A: -1, ..NONE };
const OHM: Definition = Definition { kg: 1, m: 2, s: -3, A: -2, ..NONE };
const RADIAN: Definition = Definition { rad: 1, ..NONE };
const RADIAN_PER_SECOND: Definition = Definition { rad: 1, s: -1, ..NONE };
const PER_SECOND: Definition = Definition { s: -1, ..NONE };

const fn times(base: Definition, factor: f64) -> Definition {
    Definition { factor, ..base }
}

/// The known units: name and definition.
const UNITS: &[(&str, Definition)] = &[
    ("1", NONE),
    ("%", times(NONE, 0.01)),
    ("%/s", times(PER_SECOND, 0.01)),
    ("s", SECOND),
    ("ms", times(SECOND, 0.001)),
    ("min", times(SECOND, 60.0)),
    ("h", times(SECOND, 3600.0)),
    ("1/s", PER_SECOND),
    ("Hz", PER_SECOND),
    ("m", METRE),
    ("mm", times(METRE, 0.001)),
    ("cm", times(METRE, 0.01)),
    ("m/s", METRE_PER_SECOND),
    ("m/s2", Definition { m: 1, s: -2, ..NONE }),
    ("m2", SQUARE_METRE),
    ("cm2", times(SQUARE_METRE, 0.0001)),
    ("mm2", times(SQUARE_METRE, 0.000_001)),
    ("m3", CUBIC_METRE),
    ("l", times(CUBIC_METRE, 0.001)),
    ("m3/s", CUBIC_METRE_PER_SECOND),
    ("m3/h", times(CUBIC_METRE_PER_SECOND, 1.0 / 3600.0)),
    ("l/s", times(CUBIC_METRE_PER_SECOND, 0.001)),
    ("l/min", times(CUBIC_METRE_PER_SECOND, 0.001 / 60.0)),
    ("kg", KILOGRAM),
    ("kg/s", KILOGRAM_PER_SECOND),
    ("kg/h", times(KILOGRAM_PER_SECOND, 1.0 / 3600.0)),
    ("kg/m3", Definition { kg: 1, m: -3, ..NONE }),
    ("kg.m2", Definition { kg: 1, m: 2, ..NONE }),
    ("K", KELVIN),
    ("degC", Definition { K: 1, offset: 273.15, ..NONE }),
    ("K/s", KELVIN_PER_SECOND),
    ("K/min", times(KELVIN_PER_SECOND, 1.0 / 60.0)),
    ("Pa", PASCAL),
    ("kPa", times(PASCAL, 1000.0)),
    ("mbar", times(PASCAL, 100.0)),
    ("bar", times(PASCAL, 100_000.0)),
    ("N", NEWTON),
    ("N.m", JOULE),
    ("J", JOULE),
    ("kJ", times(JOULE, 1000.0)),
    ("kW.h", times(JOULE, 3_600_000.0)),
    ("W", WATT),
    ("kW", times(WATT, 1000.0)),
    ("J/K", Definition { K: -1, ..JOULE }),
    ("W/K", Definition { K: -1, ..WATT }),
    ("J/(kg.K)", Definition { m: 2, s: -2, K: -1, ..NONE }),
    ("W/(m2.K)", Definition { kg: 1, s: -3, K: -1, ..NONE }),
    ("A", AMPERE),
    ("mA", times(AMPERE, 0.001)),
    ("V", VOLT),
    ("mV", times(VOLT, 0.001)),
    ("Ohm", OHM),
    ("rad", RADIAN),
    ("deg", times(RADIAN, std::f64::consts::PI / 180.0)),
    ("rad/s", RADIAN_PER_SECOND),
    ("rad/s2", Definition { rad: 1, s: -2, ..NONE }),
    ("rpm", times(RADIAN_PER_SECOND, std::f64::consts::PI / 30.0)),
];

/// The names of all units, grouped by quantity.
pub fn names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|(name, _)| *name)
}

/// The definition of the unit with this name.
pub fn definition(name: &str) -> Option<Definition> {
    UNITS.iter().find(|(known, _)| *known == name).map(|(_, definition)| *definition)
}

/// A unit, or a text containing units, in typographic notation, which FMI does not allow: degC becomes °C, m2 becomes
/// m², m3 becomes m³.
pub fn shown(text: &str) -> String {
    text.replace("degC", "°C").split_inclusive(|one: char| !one.is_ascii_alphanumeric()).map(in_print).collect()
}

/// A product of units in typographic notation: `K^2 s` becomes K²·s.
pub fn product(text: &str) -> String {
    shown(&text.replace("^2", "²").replace(' ', "·"))
}

/// A word in typographic notation, including the punctuation after it.
fn in_print(word: &str) -> String {
    let name = word.trim_end_matches(|one: char| !one.is_ascii_alphanumeric());
    match name {
        "m2" => word.replace("m2", "m²"),
        "m3" => word.replace("m3", "m³"),
        _ => word.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A value in a unit as a value in SI base units.
    fn in_si(value: f64, unit: &str) -> f64 {
        let base = definition(unit).unwrap();
        base.factor * value + base.offset
    }

    fn exponents(unit: &str) -> [i32; 6] {
        let base = definition(unit).unwrap();
        [base.kg, base.m, base.s, base.A, base.K, base.rad]
    }

    #[test]
    fn units_have_their_signs_in_print() {
        assert_eq!(shown("1 m3/h through 2 m2, PRM2 at 20 degC"), "1 m³/h through 2 m², PRM2 at 20 °C");
    }

    #[test]
    fn values_in_every_scaled_unit_are_what_they_are_in_si_units() {
        let table = [
            (50.0, "%", 0.5),
            (50.0, "%/s", 0.5),
            (250.0, "ms", 0.25),
            (1.5, "min", 90.0),
            (2.0, "h", 7200.0),
            (5.0, "mm", 0.005),
            (5.0, "cm", 0.05),
            (25.0, "cm2", 0.0025),
            (25.0, "mm2", 0.000_025),
            (3.0, "l", 0.003),
            (7.2, "m3/h", 0.002),
            (4.0, "l/s", 0.004),
            (90.0, "l/min", 0.0015),
            (3600.0, "kg/h", 1.0),
            (20.0, "degC", 293.15),
            (-273.15, "degC", 0.0),
            (30.0, "K/min", 0.5),
            (101.325, "kPa", 101_325.0),
            (1013.25, "mbar", 101_325.0),
            (4.0, "bar", 400_000.0),
            (2.0, "kJ", 2000.0),
            (0.5, "kW.h", 1_800_000.0),
            (2.5, "kW", 2500.0),
            (20.0, "mA", 0.02),
            (50.0, "mV", 0.05),
            (180.0, "deg", std::f64::consts::PI),
            (60.0, "rpm", std::f64::consts::TAU),
        ];
        for (value, unit, expected) in table {
            let si = in_si(value, unit);
            assert!((si - expected).abs() <= 1e-15 * expected.abs().max(1.0), "{value} {unit} = {si}");
        }
        let scaled = UNITS.iter().filter(|(_, base)| base.factor != 1.0 || base.offset != 0.0).map(|(name, _)| *name);
        assert!(
            scaled.clone().all(|name| table.iter().any(|(_, unit, _)| *unit == name)),
            "{:?}",
            scaled.collect::<Vec<_>>()
        );
    }

    #[test]
    fn every_unit_is_the_product_that_physics_says() {
        // kg, m, s, A, K, rad
        let product = |a: [i32; 6], b: [i32; 6], sign: i32| std::array::from_fn::<i32, 6, _>(|i| a[i] + sign * b[i]);
        let times = |a, b| product(exponents(a), exponents(b), 1);
        let per = |a, b| product(exponents(a), exponents(b), -1);
        for (unit, expected) in [
            ("1", [0; 6]),
            ("%", [0; 6]),
            ("s", [0, 0, 1, 0, 0, 0]),
            ("m", [0, 1, 0, 0, 0, 0]),
            ("kg", [1, 0, 0, 0, 0, 0]),
            ("A", [0, 0, 0, 1, 0, 0]),
            ("K", [0, 0, 0, 0, 1, 0]),
            ("rad", [0, 0, 0, 0, 0, 1]),
            ("ms", exponents("s")),
            ("min", exponents("s")),
            ("h", exponents("s")),
            ("1/s", per("1", "s")),
            ("Hz", per("1", "s")),
            ("%/s", per("1", "s")),
            ("mm", exponents("m")),
            ("cm", exponents("m")),
            ("m/s", per("m", "s")),
            ("m/s2", per("m/s", "s")),
            ("m2", times("m", "m")),
            ("cm2", times("m", "m")),
            ("mm2", times("m", "m")),
            ("m3", times("m2", "m")),
            ("l", times("m2", "m")),
            ("m3/s", per("m3", "s")),
            ("m3/h", per("m3", "s")),
            ("l/s", per("m3", "s")),
            ("l/min", per("m3", "s")),
            ("kg/s", per("kg", "s")),
            ("kg/h", per("kg", "s")),
            ("kg/m3", per("kg", "m3")),
            ("kg.m2", times("kg", "m2")),
            ("degC", exponents("K")),
            ("K/s", per("K", "s")),
            ("K/min", per("K", "s")),
            ("N", times("kg", "m/s2")),
            ("Pa", per("N", "m2")),
            ("kPa", exponents("Pa")),
            ("mbar", exponents("Pa")),
            ("bar", exponents("Pa")),
            ("N.m", times("N", "m")),
            ("J", times("N", "m")),
            ("kJ", exponents("J")),
            ("kW.h", exponents("J")),
            ("W", per("J", "s")),
            ("kW", exponents("W")),
            ("J/K", per("J", "K")),
            ("W/K", per("W", "K")),
            ("J/(kg.K)", per("J/K", "kg")),
            ("W/(m2.K)", per("W/K", "m2")),
            ("mA", exponents("A")),
            ("V", per("W", "A")),
            ("mV", exponents("V")),
            ("Ohm", per("V", "A")),
            ("deg", exponents("rad")),
            ("rad/s", per("rad", "s")),
            ("rad/s2", per("rad/s", "s")),
            ("rpm", per("rad", "s")),
        ] {
            assert_eq!(exponents(unit), expected, "{unit}");
        }
    }

    #[test]
    fn no_unit_is_defined_twice() {
        for (i, name) in names().enumerate() {
            assert_eq!(names().position(|other| other == name), Some(i), "{name}");
        }
    }
}
