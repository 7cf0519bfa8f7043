//! Numbers that a host passes by mistake, or that lie at a bound.

use std::ffi::c_int;
use tests::Random;

const REALS: [f64; 36] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    2.5,
    20.0,
    100.0,
    -100.0,
    27648.0,
    0.001,
    0.0005,
    0.000499,
    0.01,
    60.0,
    1e5,
    1e-300,
    2147483.647,
    2147483.6475,
    2147483.648,
    -0.001,
    3.4028234663852886e38,
    3.4028235677973362e38,
    3.4028235677973366e38,
    -3.5e38,
    1e30,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    f64::NAN,
    -f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

const INTEGERS: [c_int; 14] =
    [0, 1, -1, 2, 100, 27648, 32767, 32768, -32768, -32769, 65535, 65536, c_int::MAX, c_int::MIN];

/// Any double.
pub(crate) fn any_real(random: &mut Random) -> f64 {
    match random.below(4) {
        0 => f64::from_bits(random.bits()),
        1 => random.between(-150.0, 150.0),
        2 => random.between(0.0, 1.0),
        _ => random.pick(&REALS),
    }
}

/// Any integer; one in four lies at a bound, and half of them are small.
pub(crate) fn any_integer(random: &mut Random) -> c_int {
    match random.below(4) {
        0 => random.pick(&INTEGERS),
        1 => random.bits() as c_int,
        _ => random.below(200) as c_int - 50,
    }
}
