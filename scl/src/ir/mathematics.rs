//! EXP, LN, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN and `**`, with identical bits on every computer.
//!
//! They use only operations that IEEE 754 defines exactly: + - * / and the square root of binary64, and integer
//! operations. No platform library is called and nothing is contracted. `c/mathematics.h` has the same functions in C,
//! one by one; a test compares the bits of both.
//!
//! Each function reduces its argument, sums a Taylor series in [twice the precision](Twofold), and rounds the result
//! once. The error before rounding is less than 2^-60 of the result, so that it differs from the exact value by less
//! than 0.51 units in the last place. Coefficients are quotients of integers.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E, LOG10_E, SQRT_2};

/// An unevaluated sum of two numbers, with about 106 bits of precision. The second is at most half a unit in the last
/// place of the first, which is therefore the rounded sum.
#[derive(Clone, Copy)]
struct Twofold(f64, f64);

/// a + b, exactly.
fn sum(a: f64, b: f64) -> Twofold {
    let sum = a + b;
    let of_b = sum - a;
    Twofold(sum, (a - (sum - of_b)) + (b - of_b))
}

/// a + b, exactly, if a is 0 or not less than b in magnitude.
fn ordered_sum(a: f64, b: f64) -> Twofold {
    let sum = a + b;
    Twofold(sum, b - (sum - a))
}

/// a * b, exactly, for magnitudes below 2^500 and without underflow: the 26-bit halves of the factors have exact
/// products.
fn product(a: f64, b: f64) -> Twofold {
    // 2^27 + 1
    let (a_shifted, b_shifted) = (134217729.0 * a, 134217729.0 * b);
    let (a_high, b_high) = (a_shifted - (a_shifted - a), b_shifted - (b_shifted - b));
    let (a_low, b_low) = (a - a_high, b - b_high);
    let product = a * b;
    Twofold(product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

fn add(a: Twofold, b: Twofold) -> Twofold {
    let (high, low) = (sum(a.0, b.0), sum(a.1, b.1));
    let first = ordered_sum(high.0, high.1 + low.0);
    ordered_sum(first.0, first.1 + low.1)
}

fn multiply(a: Twofold, b: Twofold) -> Twofold {
    let high = product(a.0, b.0);
    ordered_sum(high.0, high.1 + (a.0 * b.1 + a.1 * b.0))
}

fn divide(a: Twofold, b: Twofold) -> Twofold {
    let quotient = a.0 / b.0;
    let back = multiply(b, Twofold(quotient, 0.0));
    let rest = (a.0 - back.0) + (a.1 - back.1);
    ordered_sum(quotient, rest / b.0)
}

fn minus(a: Twofold) -> Twofold {
    Twofold(-a.0, -a.1)
}

/// Evaluates the polynomial with these coefficients, constant term first: the first `wide` of them in twice the
/// precision, the higher powers, which contribute little, in binary64.
fn polynomial(x: Twofold, coefficients: &[Twofold], wide: usize) -> Twofold {
    let mut narrow = 0.0;
    for coefficient in coefficients[wide..].iter().rev() {
        narrow = narrow * x.0 + coefficient.0;
    }
    let mut value = Twofold(narrow, 0.0);
    for coefficient in coefficients[..wide].iter().rev() {
        value = add(multiply(value, x), *coefficient);
    }
    value
}

/// Rounds a number below 2^51 to the nearest integer, ties to even: adding 1.5 * 2^52 leaves no bits for a fraction.
fn nearest(x: f64) -> f64 {
    (x + 6755399441055744.0) - 6755399441055744.0
}

/// 2^k for k from -1022 to 1023.
fn power_of_2(k: i64) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

/// x times 2^k, rounded once, even if the result is subnormal, below 2^-1022.
fn scaled(x: Twofold, k: i64) -> f64 {
    let mut number = x.0;
    if k < -1021 {
        // Adding this number aligns the last bit with that of the smallest subnormal number.
        let offset = power_of_2(-1022 - k);
        if number < offset {
            let with_offset = sum(offset, number);
            number = ordered_sum(with_offset.0, with_offset.1 + x.1).0 - offset;
        }
    }
    number * power_of_2(k / 2) * power_of_2(k - k / 2)
}

/// ln(2) in three parts, of which the first two have 41 bits: their products with integers below 2^12 are exact.
const LN_2: [f64; 3] = [0.693147180559663, 2.8235290563014906e-13, 1.667085920830552e-25];

/// k * ln(2) for an integer k below 2^12.
fn times_ln_2(k: f64) -> Twofold {
    let parts = ordered_sum(k * LN_2[0], k * LN_2[1]);
    add(parts, Twofold(k * LN_2[2], 0.0))
}

/// 1 / n!
const EXPONENTIAL: [Twofold; 17] = [
    Twofold(1.0, 0.0),
    Twofold(1.0, 0.0),
    Twofold(0.5, 0.0),
    Twofold(0.16666666666666666, 9.25185853854297e-18),
    Twofold(0.041666666666666664, 2.3129646346357427e-18),
    Twofold(0.008333333333333333, 1.1564823173178714e-19),
    Twofold(0.001388888888888889, -5.300543954373577e-20),
    Twofold(0.0001984126984126984, 1.7209558293420705e-22),
    Twofold(2.48015873015873e-05, 2.1511947866775882e-23),
    Twofold(2.7557319223985893e-06, -1.858393274046472e-22),
    Twofold(2.755731922398589e-07, 2.3767714622250297e-23),
    Twofold(2.505210838544172e-08, -1.448814070935912e-24),
    Twofold(2.08767569878681e-09, -1.20734505911326e-25),
    Twofold(1.6059043836821613e-10, 1.2585294588752098e-26),
    Twofold(1.1470745597729725e-11, 2.0655512752830745e-28),
    Twofold(7.647163731819816e-13, 7.03872877733453e-30),
    Twofold(4.779477332387385e-14, 4.399205485834081e-31),
];

/// e^x, rounded: x = k ln(2) + r with |r| at most 0.35.
fn exponential(x: Twofold) -> f64 {
    if x.0 > 710.0 {
        return f64::INFINITY;
    }
    if x.0 < -746.0 {
        return 0.0;
    }
    let k = nearest(x.0 * LOG2_E);
    let r = add(x, times_ln_2(-k));
    scaled(polynomial(r, &EXPONENTIAL, 4), k as i64)
}

/// 1 / (2 n + 1)
const ODD: [Twofold; 14] = [
    Twofold(1.0, 0.0),
    Twofold(0.3333333333333333, 1.850371707708594e-17),
    Twofold(0.2, -1.1102230246251566e-17),
    Twofold(0.14285714285714285, 7.93016446160826e-18),
    Twofold(0.1111111111111111, 6.1679056923619804e-18),
    Twofold(0.09090909090909091, -2.523234146875356e-18),
    Twofold(0.07692307692307693, -4.270088556250602e-18),
    Twofold(0.06666666666666667, 9.251858538542971e-19),
    Twofold(0.058823529411764705, 8.163404592832033e-19),
    Twofold(0.05263157894736842, 2.921639538487254e-18),
    Twofold(0.047619047619047616, 2.64338815386942e-18),
    Twofold(0.043478260869565216, 1.206764157201257e-18),
    Twofold(0.04, -8.326672684688674e-19),
    Twofold(0.037037037037037035, 2.05596856412066e-18),
];

/// ln(x) of a finite number above 0: x = 2^k m with m from 0.7 to 1.4, and ln(m) = 2 artanh((m - 1) / (m + 1)).
fn logarithm(x: f64) -> Twofold {
    // 2^-1022 and 2^54
    let (x, shift) = if x < 2.2250738585072014e-308 { (x * 18014398509481984.0, 54) } else { (x, 0) };
    let mut k = (x.to_bits() >> 52) as i64 - 1023 - shift;
    let mut m = f64::from_bits((x.to_bits() & 0xF_FFFF_FFFF_FFFF) | 0x3FF0_0000_0000_0000);
    if m > SQRT_2 {
        m *= 0.5;
        k += 1;
    }
    let s = divide(Twofold(m - 1.0, 0.0), sum(m, 1.0));
    let half = multiply(s, polynomial(multiply(s, s), &ODD, 4));
    add(times_ln_2(k as f64), Twofold(2.0 * half.0, 2.0 * half.1))
}

/// 2 / pi as base-2^32 digits.
const TWO_BY_PI: [u32; 38] = [
    0xA2F9_836E,
    0x4E44_1529,
    0xFC27_57D1,
    0xF534_DDC0,
    0xDB62_9599,
    0x3C43_9041,
    0xFE51_63AB,
    0xDEBB_C561,
    0xB724_6E3A,
    0x424D_D2E0,
    0x0649_2EEA,
    0x09D1_921C,
    0xFE1D_EB1C,
    0xB129_A73E,
    0xE882_35F5,
    0x2EBB_4484,
    0xE99C_7026,
    0xB45F_7E41,
    0x3991_D639,
    0x8353_39F4,
    0x9C84_5F8B,
    0xBDF9_283B,
    0x1FF8_97FF,
    0xDE05_980F,
    0xEF2F_118B,
    0x5A0A_6D1F,
    0x6D36_7ECF,
    0x27CB_09B7,
    0x4F46_3F66,
    0x9E5F_EA2D,
    0x7527_BAC7,
    0xEBE5_F17B,
    0x3D07_39F7,
    0x8A52_92EA,
    0x6BFB_5FB1,
    0x1F8D_5D08,
    0x5603_3046,
    0xFC7B_6BAB,
];

/// pi / 2
const HALF_PI: Twofold = Twofold(FRAC_PI_2, 6.123233995736766e-17);

/// The quadrant of a finite non-negative angle, and its distance from the axis in the middle of that quadrant, from
/// -pi/4 to pi/4. The integer mantissa of the angle is multiplied by as many digits of 2/pi as needed.
fn quadrant(x: f64) -> (u64, Twofold) {
    if x <= FRAC_PI_4 {
        return (0, Twofold(x, 0.0));
    }
    // x = mantissa * 2^exponent
    let mantissa = (x.to_bits() & 0xF_FFFF_FFFF_FFFF) | 0x10_0000_0000_0000;
    let exponent = (x.to_bits() >> 52) as i64 - 1075;
    // Earlier digits contribute only whole turns.
    let first = if exponent < 2 { 0 } else { (exponent - 2) / 32 };
    // The product, lowest digit first. Its binary point is before the bit of this number.
    let mut digits = [0_u64; 10];
    for (n, digit) in digits.iter_mut().take(8).enumerate() {
        *digit = u64::from(TWO_BY_PI[first as usize + 7 - n]);
    }
    let point = 32 * (first + 8) - exponent;
    let (low, high) = (mantissa & 0xFFFF_FFFF, mantissa >> 32);
    let (mut carry, mut before) = (0, 0);
    for digit in &mut digits {
        let both = *digit * low + carry;
        let sum = before * high + (both & 0xFFFF_FFFF);
        (carry, before) = ((both >> 32) + (sum >> 32), *digit);
        *digit = sum & 0xFFFF_FFFF;
    }
    // The 32 bits of the product starting at this one.
    let digit = |bit: i64| {
        let n = (bit / 32) as usize;
        let above = if n < 9 { digits[n + 1] } else { 0 };
        ((above << 32 | digits[n]) >> (bit % 32)) & 0xFFFF_FFFF
    };
    let quadrant = digit(point) & 3;
    // Beyond one half, the next quadrant is nearer, and the distance to it is the complement.
    let beyond = digit(point - 32) >> 31;
    let mut fraction = Twofold(0.0, 0.0);
    let mut weight = 1.0;
    for n in 1..=6 {
        let part = digit(point - 32 * n);
        let part = if beyond == 1 { part ^ 0xFFFF_FFFF } else { part };
        // 2^-32
        weight *= 2.3283064365386963e-10;
        fraction = add(fraction, Twofold(part as f64 * weight, 0.0));
    }
    let angle = multiply(fraction, HALF_PI);
    ((quadrant + beyond) & 3, if beyond == 1 { minus(angle) } else { angle })
}

/// (-1)^n / (2 n + 1)!
const SINE: [Twofold; 10] = [
    Twofold(1.0, 0.0),
    Twofold(-0.16666666666666666, -9.25185853854297e-18),
    Twofold(0.008333333333333333, 1.1564823173178714e-19),
    Twofold(-0.0001984126984126984, -1.7209558293420705e-22),
    Twofold(2.7557319223985893e-06, -1.858393274046472e-22),
    Twofold(-2.505210838544172e-08, 1.448814070935912e-24),
    Twofold(1.6059043836821613e-10, 1.2585294588752098e-26),
    Twofold(-7.647163731819816e-13, -7.03872877733453e-30),
    Twofold(2.8114572543455206e-15, 1.6508842730861433e-31),
    Twofold(-8.22063524662433e-18, -2.2141894119604265e-34),
];

/// The sine of an angle of magnitude at most pi/4.
fn sine(x: Twofold) -> Twofold {
    multiply(x, polynomial(multiply(x, x), &SINE, 3))
}

/// (-1)^n / (2 n)!
const COSINE: [Twofold; 11] = [
    Twofold(1.0, 0.0),
    Twofold(-0.5, 0.0),
    Twofold(0.041666666666666664, 2.3129646346357427e-18),
    Twofold(-0.001388888888888889, 5.300543954373577e-20),
    Twofold(2.48015873015873e-05, 2.1511947866775882e-23),
    Twofold(-2.755731922398589e-07, -2.3767714622250297e-23),
    Twofold(2.08767569878681e-09, -1.20734505911326e-25),
    Twofold(-1.1470745597729725e-11, -2.0655512752830745e-28),
    Twofold(4.779477332387385e-14, 4.399205485834081e-31),
    Twofold(-1.5619206968586225e-16, -1.1910679660273754e-32),
    Twofold(4.110317623312165e-19, 1.4412973378659527e-36),
];

/// The cosine of an angle of magnitude at most pi/4.
fn cosine(x: Twofold) -> Twofold {
    polynomial(multiply(x, x), &COSINE, 3)
}

/// arctan(n / 8)
const ARC_TANGENT: [Twofold; 9] = [
    Twofold(0.0, 0.0),
    Twofold(0.12435499454676144, -3.1253241424539383e-18),
    Twofold(0.24497866312686414, 1.0698755618734451e-17),
    Twofold(0.35877067027057225, -2.4623815582638635e-17),
    Twofold(0.4636476090008061, 2.2698777452961687e-17),
    Twofold(0.5585993153435624, -5.4556305485916264e-18),
    Twofold(0.6435011087932844, 1.5834785051444286e-17),
    Twofold(0.7188299996216245, -2.1478388444456983e-17),
    Twofold(FRAC_PI_4, 3.061616997868383e-17),
];

/// The angle, from 0 to pi/2, of a right triangle with these non-negative legs: subtracts the nearest n / 8 with a
/// known arc tangent.
fn angle(y: Twofold, x: Twofold) -> Twofold {
    let is_steep = y.0 > x.0;
    let (y, x) = if is_steep { (x, y) } else { (y, x) };
    let n = nearest(8.0 * y.0 / x.0);
    let known = Twofold(n / 8.0, 0.0);
    let z = divide(add(y, minus(multiply(x, known))), add(x, multiply(y, known)));
    let rest = multiply(z, polynomial(minus(multiply(z, z)), &ODD[..9], 2));
    let angle = add(ARC_TANGENT[n as usize], rest);
    if is_steep { add(HALF_PI, minus(angle)) } else { angle }
}

/// The second leg of a right triangle with hypotenuse 1: the square root of 1 - x^2.
fn other_leg(x: f64) -> Twofold {
    let square = product(x, x);
    let square = add(sum(1.0, -square.0), Twofold(-square.1, 0.0));
    if square.0 <= 0.0 {
        return Twofold(0.0, 0.0);
    }
    let root = square.0.sqrt();
    let rest = add(square, minus(product(root, root)));
    ordered_sum(root, rest.0 / (2.0 * root))
}

/// The number with the sign of `of`.
fn with_sign(number: f64, of: f64) -> f64 {
    if of < 0.0 { -number } else { number }
}

/// Below 2^-27, sine, tangent and their inverses round to their argument.
const SMALL: f64 = 7.450580596923828e-9;

/// e^x.
pub(crate) fn exp(x: f64) -> f64 {
    if x.is_nan() { x } else { exponential(Twofold(x, 0.0)) }
}

/// The natural logarithm: -infinity for 0, NaN for negative numbers.
pub(crate) fn ln(x: f64) -> f64 {
    if x == 0.0 {
        return f64::NEG_INFINITY;
    }
    if !(x > 0.0 && x < f64::INFINITY) {
        return if x > 0.0 { x } else { f64::NAN };
    }
    logarithm(x).0
}

/// The base-10 logarithm.
pub(crate) fn log(x: f64) -> f64 {
    if !(x > 0.0 && x < f64::INFINITY) {
        return ln(x);
    }
    multiply(logarithm(x), Twofold(LOG10_E, 1.098319650216765e-17)).0
}

/// The sine of an angle in radians.
pub(crate) fn sin(x: f64) -> f64 {
    if !x.is_finite() {
        return f64::NAN;
    }
    if x.abs() < SMALL {
        return x;
    }
    let (quadrant, rest) = quadrant(x.abs());
    let y = if quadrant & 1 == 0 { sine(rest) } else { cosine(rest) };
    with_sign(if quadrant & 2 == 0 { y.0 } else { -y.0 }, x)
}

/// The cosine of an angle in radians.
pub(crate) fn cos(x: f64) -> f64 {
    if !x.is_finite() {
        return f64::NAN;
    }
    let (quadrant, rest) = quadrant(x.abs());
    let y = if quadrant & 1 == 0 { cosine(rest) } else { sine(rest) };
    if quadrant == 1 || quadrant == 2 { -y.0 } else { y.0 }
}

/// The tangent of an angle in radians.
pub(crate) fn tan(x: f64) -> f64 {
    if !x.is_finite() {
        return f64::NAN;
    }
    if x.abs() < SMALL {
        return x;
    }
    let (quadrant, rest) = quadrant(x.abs());
    let (sine, cosine) = (sine(rest), cosine(rest));
    with_sign(if quadrant & 1 == 0 { divide(sine, cosine).0 } else { -divide(cosine, sine).0 }, x)
}

/// The arc sine, from -pi/2 to pi/2; NaN beyond magnitude 1.
pub(crate) fn asin(x: f64) -> f64 {
    if x.is_nan() || x.abs() > 1.0 {
        return f64::NAN;
    }
    if x.abs() < SMALL {
        return x;
    }
    with_sign(angle(Twofold(x.abs(), 0.0), other_leg(x)).0, x)
}

/// The arc cosine, from 0 to pi; NaN beyond magnitude 1.
pub(crate) fn acos(x: f64) -> f64 {
    if x.is_nan() || x.abs() > 1.0 {
        return f64::NAN;
    }
    let angle = angle(other_leg(x), Twofold(x.abs(), 0.0));
    if x < 0.0 { add(Twofold(2.0 * HALF_PI.0, 2.0 * HALF_PI.1), minus(angle)).0 } else { angle.0 }
}

/// The arc tangent, from -pi/2 to pi/2.
pub(crate) fn atan(x: f64) -> f64 {
    if x.is_nan() || x.abs() < SMALL {
        return x;
    }
    // 2^64
    if x.abs() > 18446744073709551616.0 {
        return with_sign(HALF_PI.0, x);
    }
    with_sign(angle(Twofold(x.abs(), 0.0), Twofold(1.0, 0.0)).0, x)
}

/// x to the power of y. A negative x requires an integer y; x^0 and 1^y are 1, even for NaN.
pub(crate) fn pow(x: f64, y: f64) -> f64 {
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    let (base, size) = (x.abs(), y.abs());
    let is_whole = y.trunc() == y;
    // From 2^53 on, all floating-point numbers are even.
    let is_odd = is_whole && (y / 2.0).trunc() != y / 2.0;
    let sign = if x.is_sign_negative() && is_odd { -1.0 } else { 1.0 };
    if base == 0.0 || base == f64::INFINITY {
        return sign * if (base == 0.0) == (y < 0.0) { f64::INFINITY } else { 0.0 };
    }
    if x < 0.0 && !is_whole {
        return f64::NAN;
    }
    // 2^64: overflow or underflow for every base but 1.
    if base == 1.0 || size > 18446744073709551616.0 {
        return sign
            * if base == 1.0 {
                1.0
            } else if (base > 1.0) == (y > 0.0) {
                f64::INFINITY
            } else {
                0.0
            };
    }
    // 2^-70: the exponential of anything smaller rounds to 1.
    if size < 8.470329472543003e-22 {
        return 1.0;
    }
    sign * exponential(multiply(logarithm(base), Twofold(y, 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Function = fn(f64) -> f64;

    /// Arguments whose exact result lies close to the midpoint of two numbers, or whose reduction needs all digits of 2
    /// / pi; the expected results are correctly rounded, by mpmath 1.3 with 1400 bits.
    #[test]
    fn results_are_the_exact_ones_rounded_once() {
        let cases: [(Function, u64, u64); 90] = [
            (exp, 0x407B_0449_26B5_FCE4, 0x66E8_C5E3_6F79_80C7),
            (exp, 0x4069_F871_372E_E764, 0x52AA_B83F_C978_A754),
            (exp, 0xC040_C6D7_12EF_D270, 0x3CE8_20B3_4781_C991),
            (exp, 0xC086_D159_21B6_75EC, 0x0000_0000_0018_1356),
            (exp, 0x3FD3_BE32_E2B5_AED8, 0x3FF5_C820_DE78_CB2E),
            (exp, 0xC086_1FD2_EB6F_3386, 0x0018_502D_6F65_84A9),
            (exp, 0x407E_9DE3_481A_6140, 0x6C1A_8A57_5C61_5DF3),
            (exp, 0x4059_2DCD_5F9D_B5F8, 0x4903_B9B4_54A6_90BC),
            (exp, 0xC086_F70D_8B2E_8DF5, 0x0000_0000_0000_3754),
            (ln, 0x3FEF_FFFF_FFFF_FFFE, 0xBCB0_0000_0000_0001),
            (ln, 0x47C9_808C_C4A3_5555, 0x4055_C703_384E_3477),
            (ln, 0x3FE2_FB5B_BA1F_067C, 0xBFE0_B649_24B2_935D),
            (ln, 0x3FF8_0D98_798E_2AE7, 0x3FDA_175A_EFEC_EA77),
            (ln, 0x6366_25C8_9C6A_AA87, 0x4078_956E_F771_0D37),
            (ln, 0x55D6_43A2_9466_C419, 0x406E_5DD2_294D_09B4),
            (ln, 0x1DAE_120F_11D2_33D1, 0xC077_BE82_6FB5_0409),
            (ln, 0x3FF0_0000_0000_0001, 0x3CAF_FFFF_FFFF_FFFF),
            (ln, 0x3FF0_0000_0000_0001, 0x3CAF_FFFF_FFFF_FFFF),
            (log, 0x3FFF_E916_0AC5_1D52, 0x3FD3_3025_11CC_0C72),
            (log, 0x3FEF_FFFF_DDDC_7F69, 0xBE5D_A709_15FE_2715),
            (log, 0x6776_DE9C_893D_4F7C, 0x4067_CCFE_BBC2_D860),
            (log, 0x3FE6_7813_B74B_F137, 0xBFC3_A806_B236_B580),
            (log, 0x3FEF_FFFF_ADBF_7078, 0xBE71_DC5F_D8E7_91DD),
            (log, 0x7105_CA67_48C1_06F6, 0x406D_8E2A_91FE_ED06),
            (log, 0x3FED_4B01_297C_5CD2, 0xBFA3_A75F_6769_196F),
            (log, 0x4237_4876_E800_0000, 0x4026_0000_0000_0000),
            (log, 0x430C_6BF5_2634_0000, 0x402E_0000_0000_0000),
            (sin, 0xC227_1680_87CF_A669, 0xBE9A_31D5_C4E1_02F5),
            (sin, 0xC17E_8A66_1519_D60C, 0x3FDC_11D0_A104_2F9D),
            (sin, 0xC021_E83D_B285_C4F2, 0xBFDD_0D5A_741E_B253),
            (sin, 0xC197_E5CF_F312_E0EC, 0xBFEF_FFBE_4811_DEE8),
            (sin, 0xC3B4_E79C_B991_0F57, 0xBFE9_EB1B_D1D7_8F87),
            (sin, 0x40AE_4922_3EB9_ADB4, 0xBFC4_3261_D388_C27D),
            (sin, 0xC157_8357_BF3D_ECC0, 0xBFE9_D675_769C_740E),
            (sin, 0x0C62_15C9_8D98_2DAB, 0x0C62_15C9_8D98_2DAB),
            (sin, 0x10E8_72E2_D1AF_016E, 0x10E8_72E2_D1AF_016E),
            (sin, 0x7506_AC5B_262C_A1FF, 0x3FF0_0000_0000_0000),
            (sin, 0x7FEF_FFFF_FFFF_FFFF, 0x3F74_52FC_98B3_4E97),
            (sin, 0x7FE0_0000_0000_0000, 0x3FE2_0524_8CBD_B760),
            (cos, 0x4274_417D_A449_689E, 0xBFEF_FFFF_FD8A_B0C7),
            (cos, 0x438C_FD87_1F13_AFC1, 0xBFE1_EFC7_8ED4_8B35),
            (cos, 0xBFEA_A03B_3D44_B6C0, 0x3FE5_8C1E_DDD6_62F9),
            (cos, 0x3EFE_64E5_66B2_C7D4, 0x3FEF_FFFF_FFC6_4327),
            (cos, 0xC1AE_70F3_BABA_5792, 0xBFBD_13F7_926F_4815),
            (cos, 0x6455_F197_7D91_82D7, 0x3FBC_687C_287D_7C7E),
            (cos, 0x4013_25BB_E032_14A6, 0x3FB3_0B56_31AF_2822),
            (cos, 0x1162_AAAC_C803_6A86, 0x3FF0_0000_0000_0000),
            (cos, 0x13A5_E302_CAED_C52A, 0x3FF0_0000_0000_0000),
            (cos, 0x7506_AC5B_262C_A1FF, 0xBC21_4AE7_2E6B_A22F),
            (cos, 0x7FEF_FFFF_FFFF_FFFF, 0xBFEF_FFE6_2ECF_AB75),
            (cos, 0x7FE0_0000_0000_0000, 0xBFEA_719F_26C2_32BF),
            (tan, 0x4133_F5DC_9F99_79BB, 0x3DA8_7F86_0DB8_25E8),
            (tan, 0xC025_FDBB_E9BB_A775, 0xC320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x41C4_D7F6_516A_6579, 0xC009_8B21_7E03_2977),
            (tan, 0x0E08_8A51_3C6E_C5DE, 0x0E08_8A51_3C6E_C5DE),
            (tan, 0x0F83_7834_5F4D_DAD8, 0x0F83_7834_5F4D_DAD8),
            (tan, 0x7506_AC5B_262C_A1FF, 0xC3BD_9BA9_A797_5636),
            (tan, 0x7FEF_FFFF_FFFF_FFFF, 0xBF74_530C_FE72_9484),
            (tan, 0x7FE0_0000_0000_0000, 0xBFE5_CE6B_4C0D_02A3),
            (asin, 0x3FEE_0208_C72F_940E, 0x3FF3_751A_2F16_D276),
            (asin, 0xBFEF_D85D_1744_5343, 0xBFF7_8EE4_42F3_F29F),
            (asin, 0x3FA1_3872_A660_0160, 0x3FA1_3947_8932_B1EC),
            (asin, 0x3FEF_FFFF_FFF0_E5FA, 0x3FF9_21EB_C8EA_6591),
            (asin, 0xBFEF_FFFF_FFC4_1DDC, 0xBFF9_21DC_601C_1DAB),
            (asin, 0x3FBB_13C9_4539_BFA0, 0x3FBB_20C6_CADF_FF2B),
            (asin, 0xBFEC_7197_2E88_DB00, 0xBFF1_8490_50B7_E37C),
            (asin, 0xBDF8_F0EB_ED89_01A0, 0xBDF8_F0EB_ED89_01A0),
            (asin, 0xBDEC_B121_08AC_FBB0, 0xBDEC_B121_08AC_FBB0),
            (acos, 0xBFDC_3B13_9BC9_CFFC, 0x4000_3894_5BD6_E49E),
            (acos, 0xBFE7_BD02_989A_CC64, 0x4003_40AD_37AF_04C2),
            (acos, 0x3FDB_65F8_1081_5DF4, 0x3FF2_0DF6_01EC_18E0),
            (acos, 0xBFEF_E2BE_50CA_0CF3, 0x4008_74D8_2264_017A),
            (acos, 0x3FEF_FFFF_045F_13B2, 0x3F4F_B9C1_C116_406C),
            (acos, 0xBFEF_FFFF_FFFF_FF12, 0x4009_21FB_3569_6CC3),
            (acos, 0xBFB9_5472_8AB0_4450, 0x3FFA_B7EC_86DE_D451),
            (acos, 0xBFB0_B8CC_7BE1_3124, 0x3FFA_2DB8_E8C5_2526),
            (acos, 0x3EA3_37D0_2068_CE48, 0x3FF9_21FA_BA85_AC15),
            (atan, 0xBFF2_D665_27BF_C1E8, 0xBFEB_BBBE_3902_0F7E),
            (atan, 0x3FF4_4E07_FAF9_9D48, 0x3FEC_E8D3_84D5_C7D4),
            (atan, 0x3F9E_4B7A_770F_5580, 0x3F9E_4937_855D_2740),
            (atan, 0x4014_A01A_F8B8_DA52, 0x3FF6_115C_A308_160F),
            (atan, 0xBFB2_F4CD_7D22_C200, 0xBFB2_EBF6_5990_3951),
            (atan, 0xC11C_70E5_8371_FB90, 0xBFF9_21F9_1432_5431),
            (atan, 0x4080_82FD_4F3B_2128, 0x3FF9_1A3A_CBF2_D19E),
            (atan, 0x37C2_0F34_0BE1_FC4B, 0x37C2_0F34_0BE1_FC4B),
            (atan, 0x3807_1BD7_C330_D20F, 0x3807_1BD7_C330_D20F),
        ];
        for (function, x, y) in cases {
            let (x, y) = (f64::from_bits(x), f64::from_bits(y));
            assert_eq!(function(x).to_bits(), y.to_bits(), "of {x:?}: {:?} instead of {y:?}", function(x));
        }
        let powers: [(u64, u64, u64); 20] = [
            (0x4055_7C31_47C9_8742, 0xC00C_62D4_1800_8914, 0x3E82_65FE_4E33_B92D),
            (0x42CF_B494_5EC2_E402, 0xBFE0_EDFE_7BAF_B040, 0x3E69_780C_84F2_5E0F),
            (0x25F7_BC31_9D50_722F, 0x4001_1B52_5331_83B9, 0x0869_671F_BB6B_45BB),
            (0x403A_268A_4C98_05D1, 0xC012_CA9A_1674_35D2, 0x3E8D_6C64_2289_230E),
            (0x4020_C99A_7716_BF8D, 0x4047_C000_0000_0000, 0x490B_B6C4_B802_3BFE),
            (0x401E_8A23_ADC1_4A8E, 0xC042_0000_0000_0000, 0x3955_7F33_0062_FB05),
            (0x4003_4735_B58D_1069, 0x4050_0000_0000_0000, 0x4502_7F94_07A0_09CE),
            (0x4057_A45A_0A8C_3CB3, 0x4008_3526_507D_F2D0, 0x412D_0B46_8A03_5522),
            (0x4049_F100_5BCB_2415, 0xC01B_0FB7_7BA5_81AA, 0x3D85_F4CB_31E8_457F),
            (0x3FF0_0000_0000_05BF, 0x4309_02F3_7469_CE38, 0x59D9_B559_76B6_8340),
            (0x3FF0_24D8_E44F_1D9C, 0x40F2_05BB_92D3_F1E1, 0x7B8B_5EF4_8BA9_061E),
            (0x4049_DC24_01EB_2940, 0xC020_AABE_5FB8_586B, 0x3CF7_9864_0021_459B),
            (0x4050_41EE_5011_4E34, 0xC012_850B_7C1A_B14C, 0x3E31_501D_2A07_C7DC),
            (0x4057_D6A9_569A_9703, 0xC01F_AD3F_BAEC_C360, 0x3CAE_79B1_26EF_CBAB),
            (0x4044_1ABB_773F_08FF, 0xC01E_5E16_F2AD_7234, 0x3D67_4168_1CB9_7F60),
            (0x3FF0_0000_0000_001D, 0xC379_525D_E27F_2EA2, 0x0000_0000_0000_5FFF),
            (0x470E_CFB9_3B5E_B300, 0x4012_E919_B254_14FE, 0x6199_DB51_C3C0_30D1),
            (0x15EE_E4AE_FD10_CFC2, 0xBFF5_D14B_5FD3_774D, 0x7935_3584_B52C_3CA9),
            (0x4046_3D47_1573_7BCA, 0x4015_BB3F_064E_352C, 0x41CA_D16C_8371_C2C9),
            (0x4047_18E0_2B6F_0A02, 0x400E_A05B_12FA_631C, 0x4141_FD76_02AE_C681),
        ];
        for (x, y, power) in powers {
            let [x, y, power] = [x, y, power].map(f64::from_bits);
            assert_eq!(pow(x, y).to_bits(), power.to_bits(), "{x:?} ** {y:?}: {:?} instead of {power:?}", pow(x, y));
        }
    }

    #[test]
    fn whole_results_are_exact() {
        for n in -1074..=1023 {
            assert_eq!(pow(2.0, f64::from(n)), scaled(Twofold(1.0, 0.0), i64::from(n)), "2 ** {n}");
        }
        for n in 0..=22 {
            assert_eq!(log(pow(10.0, f64::from(n))), f64::from(n));
        }
        for n in 1..=5 {
            assert_eq!(pow(-7.0, f64::from(n)), f64::from((-7_i32).pow(n)));
        }
        assert_eq!([exp(0.0), cos(0.0), acos(1.0), ln(1.0), tan(0.0)], [1.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_has_no_result_is_no_number_and_signs_of_0_stay() {
        let (infinity, nan) = (f64::INFINITY, f64::NAN);
        for it in [
            ln(-1.0),
            log(-1e-300),
            sin(infinity),
            cos(-infinity),
            tan(infinity),
            asin(1.5),
            acos(-1.5),
            pow(-8.0, 0.5),
        ] {
            assert!(it.is_nan());
        }
        for function in [exp, ln, log, sin, cos, tan, asin, acos, atan] {
            assert!(function(nan).is_nan());
        }
        for function in [sin, tan, asin, atan] {
            assert_eq!(function(-0.0).to_bits(), (-0.0_f64).to_bits());
        }
        assert_eq!([exp(infinity), exp(-infinity), exp(710.0), exp(-746.0)], [infinity, 0.0, infinity, 0.0]);
        assert_eq!([ln(0.0), ln(-0.0), log(0.0), ln(infinity)], [-infinity, -infinity, -infinity, infinity]);
        assert_eq!([atan(infinity), atan(-1e300)], [FRAC_PI_2, -FRAC_PI_2]);
        assert_eq!([pow(nan, 0.0), pow(1.0, nan), pow(-1.0, infinity)], [1.0, 1.0, 1.0]);
        assert_eq!([pow(0.0, -1.0), pow(-0.0, -1.0), pow(-0.0, 2.0)], [infinity, -infinity, 0.0]);
        assert_eq!([pow(0.5, infinity), pow(0.5, -1e300), pow(-infinity, 3.0)], [0.0, infinity, -infinity]);
    }
}
