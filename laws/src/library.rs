// Rust's number functions that need more than one operation of the typed program. This file is read like a law; a test
// compares it with Rust.

/// The greater of two numbers; if one is NaN, the other one.
pub(crate) fn max_real(a: Real, b: Real) -> Real {
    if a.is_nan() || b > a { b } else { a }
}

/// The lesser of two numbers; if one is NaN, the other one.
pub(crate) fn min_real(a: Real, b: Real) -> Real {
    if a.is_nan() || b < a { b } else { a }
}

/// The greater of two numbers; if one is NaN, the other one.
pub(crate) fn max_lreal(a: LReal, b: LReal) -> LReal {
    if a.is_nan() || b > a { b } else { a }
}

/// The lesser of two numbers; if one is NaN, the other one.
pub(crate) fn min_lreal(a: LReal, b: LReal) -> LReal {
    if a.is_nan() || b < a { b } else { a }
}

/// `a - b`, limited to the range of `i32`.
pub(crate) fn sub_saturating(a: i32, b: i32) -> i32 {
    let difference = a.wrapping_sub(b);
    if b > 0 && difference > a {
        i32::MIN
    } else if b < 0 && difference < a {
        i32::MAX
    } else {
        difference
    }
}

/// `a + b`, limited to the range of `i32`.
pub(crate) fn add_saturating(a: i32, b: i32) -> i32 {
    let sum = a.wrapping_add(b);
    if b > 0 && sum < a {
        i32::MAX
    } else if b < 0 && sum > a {
        i32::MIN
    } else {
        sum
    }
}

/// The sign of `x`: 1, 0 or -1.
pub(crate) fn sign(x: i32) -> i32 {
    if x > 0 {
        1
    } else if x < 0 {
        -1
    } else {
        0
    }
}

/// RND: the nearest integer, ties to even. Outside the 32-bit range, the bits of the REAL; -1 for NaN.
pub(crate) fn rnd(x: Real) -> i32 {
    const TWO_TO_31: Real = 2_147_483_648.0;
    if x.is_nan() {
        -1
    } else if (-TWO_TO_31..TWO_TO_31).contains(&x) {
        x.round_ties_even() as i64 as i32
    } else {
        x.to_bits() as i32
    }
}
