from_c! {

# infinite
static double infinite(void) {
    return f64_of(0x7FF0000000000000);
}

# no_number
static double no_number(void) {
    return f64_of(0x7FF8000000000000);
}

# tiny
/* 2^-27: for magnitudes below it, sine, tangent and their inverses round to their argument. */
static double tiny(void) {
    return 7.450580596923828e-9;
}

# exact_sum
/* a + b, exactly. */
static twofold_t exact_sum(double a, double b) {
    double sum = a + b;
    double of_b = sum - a;
    return twofold_of(sum, (a - (sum - of_b)) + (b - of_b));
}

# ordered_sum
/* a + b, exactly, if a is 0 or not less than b in magnitude. */
static twofold_t ordered_sum(double a, double b) {
    double sum = a + b;
    return twofold_of(sum, b - (sum - a));
}

# exact_product
/* a * b, exactly, for magnitudes below 2^500 without underflow: each factor is split into halves of 26 bits, whose products need no
   rounding. */
static twofold_t exact_product(double a, double b) {
    /* 2^27 + 1 */
    double a_shifted = 134217729.0 * a, b_shifted = 134217729.0 * b;
    double a_high = a_shifted - (a_shifted - a), b_high = b_shifted - (b_shifted - b);
    double a_low = a - a_high, b_low = b - b_high;
    double product = a * b;
    return twofold_of(product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low);
}

# twofold_sum
static twofold_t twofold_sum(twofold_t a, twofold_t b) {
    twofold_t high = exact_sum(a.high, b.high), low = exact_sum(a.low, b.low);
    twofold_t first = ordered_sum(high.high, high.low + low.high);
    return ordered_sum(first.high, first.low + low.low);
}

# twofold_product
static twofold_t twofold_product(twofold_t a, twofold_t b) {
    twofold_t high = exact_product(a.high, b.high);
    return ordered_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}

# twofold_quotient
static twofold_t twofold_quotient(twofold_t a, twofold_t b) {
    double quotient = a.high / b.high;
    twofold_t back = twofold_product(b, twofold_of(quotient, 0.0));
    double rest = (a.high - back.high) + (a.low - back.low);
    return ordered_sum(quotient, rest / b.high);
}

# twofold_minus
static twofold_t twofold_minus(twofold_t a) {
    return twofold_of(-a.high, -a.low);
}

# polynomial
/* The value at x of the polynomial with these coefficients, the constant first. The first `wide` terms are computed in twice the
   precision; those of higher powers, which contribute little, in binary64. */
static twofold_t polynomial(twofold_t x, twofolds_t coefficients, size_t count, size_t wide) {
    double narrow = 0.0;
    size_t n = count;
    twofold_t value;
    while (n > wide) {
        n -= 1;
        narrow = narrow * x.high + coefficients[n].high;
    }
    value = twofold_of(narrow, 0.0);
    while (n > 0) {
        n -= 1;
        value = twofold_sum(twofold_product(value, x), coefficients[n]);
    }
    return value;
}

# nearest
/* The whole number nearest to x, ties to even, for magnitudes below 2^51: adding 1.5 * 2^52 leaves no bit for a fraction. */
static double nearest(double x) {
    return (x + 6755399441055744.0) - 6755399441055744.0;
}

# scaled
/* x * 2^k, rounded only once, even if the result is subnormal. */
static double scaled(twofold_t x, i64_t k) {
    double number = x.high;
    if (k < -1021) {
        /* The last bit of a sum with this offset corresponds to that of a subnormal result. */
        double offset = power_of_2(-1022 - k);
        if (number < offset) {
            twofold_t with_offset = exact_sum(offset, number);
            number = ordered_sum(with_offset.high, with_offset.low + x.low).high - offset;
        }
    }
    return number * power_of_2(k / 2) * power_of_2(k - k / 2);
}

# times_ln_2
/* k * ln(2) for a whole k of magnitude below 2^12. Of the three parts of ln(2), the first two have 41 bits, so that their products
   are exact. */
static twofold_t times_ln_2(double k) {
    twofold_t parts = ordered_sum(k * 0.693147180559663, k * 2.8235290563014906e-13);
    return twofold_sum(parts, twofold_of(k * 1.667085920830552e-25, 0.0));
}

# exponential
/* e^x, rounded: x = k ln(2) + r with |r| < 0.35. */
static double exponential(twofold_t x) {
    /* 1 / n! */
    static const twofold_t coefficients[17] = {
        {1.0, 0.0},
        {1.0, 0.0},
        {0.5, 0.0},
        {0.16666666666666666, 9.25185853854297e-18},
        {0.041666666666666664, 2.3129646346357427e-18},
        {0.008333333333333333, 1.1564823173178714e-19},
        {0.001388888888888889, -5.300543954373577e-20},
        {0.0001984126984126984, 1.7209558293420705e-22},
        {2.48015873015873e-05, 2.1511947866775882e-23},
        {2.7557319223985893e-06, -1.858393274046472e-22},
        {2.755731922398589e-07, 2.3767714622250297e-23},
        {2.505210838544172e-08, -1.448814070935912e-24},
        {2.08767569878681e-09, -1.20734505911326e-25},
        {1.6059043836821613e-10, 1.2585294588752098e-26},
        {1.1470745597729725e-11, 2.0655512752830745e-28},
        {7.647163731819816e-13, 7.03872877733453e-30},
        {4.779477332387385e-14, 4.399205485834081e-31}
    };
    double k;
    twofold_t r;
    if (x.high > 710.0) {
        return infinite();
    }
    if (x.high < -746.0) {
        return 0.0;
    }
    /* 1 / ln(2) */
    k = nearest(x.high * 1.4426950408889634);
    r = twofold_sum(x, times_ln_2(-k));
    return scaled(polynomial(r, coefficients, 17, 4), whole_of(k));
}

# odd_polynomial
/* The value at x of the polynomial with the coefficients 1 / (2 n + 1) for n from 0 to `count` - 1. */
static twofold_t odd_polynomial(twofold_t x, size_t count, size_t wide) {
    static const twofold_t coefficients[14] = {
        {1.0, 0.0},
        {0.3333333333333333, 1.850371707708594e-17},
        {0.2, -1.1102230246251566e-17},
        {0.14285714285714285, 7.93016446160826e-18},
        {0.1111111111111111, 6.1679056923619804e-18},
        {0.09090909090909091, -2.523234146875356e-18},
        {0.07692307692307693, -4.270088556250602e-18},
        {0.06666666666666667, 9.251858538542971e-19},
        {0.058823529411764705, 8.163404592832033e-19},
        {0.05263157894736842, 2.921639538487254e-18},
        {0.047619047619047616, 2.64338815386942e-18},
        {0.043478260869565216, 1.206764157201257e-18},
        {0.04, -8.326672684688674e-19},
        {0.037037037037037035, 2.05596856412066e-18}
    };
    return polynomial(x, coefficients, count, wide);
}

# logarithm
/* ln(x) of a finite number above 0: x = 2^k m with m from 0.7 to 1.4, and ln(m) = 2 artanh((m - 1) / (m + 1)). */
static twofold_t logarithm(double x) {
    double k = -1023.0, m;
    twofold_t s, half;
    /* 2^-1022 and 2^54 */
    if (x < 2.2250738585072014e-308) {
        x *= 18014398509481984.0;
        k -= 54.0;
    }
    k += real_of(bits_f64(x) >> 52);
    m = f64_of((bits_f64(x) & 0xFFFFFFFFFFFFF) | 0x3FF0000000000000);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        k += 1.0;
    }
    s = twofold_quotient(twofold_of(m - 1.0, 0.0), exact_sum(m, 1.0));
    half = twofold_product(s, odd_polynomial(twofold_product(s, s), 14, 4));
    return twofold_sum(times_ln_2(k), twofold_of(2.0 * half.high, 2.0 * half.low));
}

# digit_from
/* 32 bits, from this bit upward, of a number with ten 32-bit digits, lowest first. */
static u64_t digit_from(digits_t digits, i64_t bit) {
    size_t n = place_of(bit / 32);
    u64_t above = 0;
    if (n < 9) {
        above = digits[n + 1];
    }
    return ((above << 32 | digits[n]) >> (bit % 32)) & 0xFFFFFFFF;
}

# half_pi
static twofold_t half_pi(void) {
    return twofold_of(1.5707963267948966, 6.123233995736766e-17);
}

# quadrant
/* The quadrant of a finite, non-negative angle, and the offset of the angle from the quadrant's axis, from -pi/4 to pi/4: 2/pi is
   multiplied by the angle's mantissa, with as many digits as necessary. */
static turn_t quadrant(double x) {
    /* 2 / pi */
    static const u64_t two_by_pi[38] = {
        0xA2F9836E, 0x4E441529, 0xFC2757D1, 0xF534DDC0, 0xDB629599, 0x3C439041, 0xFE5163AB, 0xDEBBC561,
        0xB7246E3A, 0x424DD2E0, 0x06492EEA, 0x09D1921C, 0xFE1DEB1C, 0xB129A73E, 0xE88235F5, 0x2EBB4484,
        0xE99C7026, 0xB45F7E41, 0x3991D639, 0x835339F4, 0x9C845F8B, 0xBDF9283B, 0x1FF897FF, 0xDE05980F,
        0xEF2F118B, 0x5A0A6D1F, 0x6D367ECF, 0x27CB09B7, 0x4F463F66, 0x9E5FEA2D, 0x7527BAC7, 0xEBE5F17B,
        0x3D0739F7, 0x8A5292EA, 0x6BFB5FB1, 0x1F8D5D08, 0x56033046, 0xFC7B6BAB
    };
    u64_t digits[10] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    u64_t mantissa = (bits_f64(x) & 0xFFFFFFFFFFFFF) | 0x10000000000000;
    u64_t low = mantissa & 0xFFFFFFFF, high = mantissa >> 32;
    u64_t carry = 0, before = 0, beyond, part;
    /* x = mantissa * 2^exponent */
    i64_t exponent = whole_of(real_of(bits_f64(x) >> 52)) - 1075;
    i64_t first = 0, point, bit;
    twofold_t rest = twofold_of(0.0, 0.0);
    double weight = 1.0;
    size_t n = 0;
    if (x <= 0.7853981633974483) {
        return turn_of(0, twofold_of(x, 0.0));
    }
    /* Digits of 2/pi before the first one used contribute only whole turns. */
    if (exponent >= 2) {
        first = (exponent - 2) / 32;
    }
    while (n < 8) {
        digits[n] = two_by_pi[place_of(first) + 7 - n];
        n += 1;
    }
    /* The product, lowest digit first. Its binary point is at this bit. */
    point = 32 * (first + 8) - exponent;
    n = 0;
    while (n < 10) {
        u64_t both = digits[n] * low + carry;
        u64_t sum = before * high + (both & 0xFFFFFFFF);
        carry = (both >> 32) + (sum >> 32);
        before = digits[n];
        digits[n] = sum & 0xFFFFFFFF;
        n += 1;
    }
    /* Beyond one half, the next quadrant is nearer, and the complement to 1 is used: its bits are inverted. */
    beyond = digit_from(digits, point - 32) >> 31;
    bit = point;
    while (bit > point - 192) {
        bit -= 32;
        part = digit_from(digits, bit);
        if (beyond == 1) {
            part ^= 0xFFFFFFFF;
        }
        /* 2^-32 */
        weight *= 2.3283064365386963e-10;
        rest = twofold_sum(rest, twofold_of(real_of(part) * weight, 0.0));
    }
    rest = twofold_product(rest, half_pi());
    if (beyond == 1) {
        rest = twofold_minus(rest);
    }
    return turn_of((digit_from(digits, point) + beyond) & 3, rest);
}

# sine
/* The sine of an angle of magnitude at most pi/4. */
static twofold_t sine(twofold_t x) {
    /* (-1)^n / (2 n + 1)! */
    static const twofold_t coefficients[10] = {
        {1.0, 0.0},
        {-0.16666666666666666, -9.25185853854297e-18},
        {0.008333333333333333, 1.1564823173178714e-19},
        {-0.0001984126984126984, -1.7209558293420705e-22},
        {2.7557319223985893e-06, -1.858393274046472e-22},
        {-2.505210838544172e-08, 1.448814070935912e-24},
        {1.6059043836821613e-10, 1.2585294588752098e-26},
        {-7.647163731819816e-13, -7.03872877733453e-30},
        {2.8114572543455206e-15, 1.6508842730861433e-31},
        {-8.22063524662433e-18, -2.2141894119604265e-34}
    };
    return twofold_product(x, polynomial(twofold_product(x, x), coefficients, 10, 3));
}

# cosine
/* The cosine of an angle of magnitude at most pi/4. */
static twofold_t cosine(twofold_t x) {
    /* (-1)^n / (2 n)! */
    static const twofold_t coefficients[11] = {
        {1.0, 0.0},
        {-0.5, 0.0},
        {0.041666666666666664, 2.3129646346357427e-18},
        {-0.001388888888888889, 5.300543954373577e-20},
        {2.48015873015873e-05, 2.1511947866775882e-23},
        {-2.755731922398589e-07, -2.3767714622250297e-23},
        {2.08767569878681e-09, -1.20734505911326e-25},
        {-1.1470745597729725e-11, -2.0655512752830745e-28},
        {4.779477332387385e-14, 4.399205485834081e-31},
        {-1.5619206968586225e-16, -1.1910679660273754e-32},
        {4.110317623312165e-19, 1.4412973378659527e-36}
    };
    return polynomial(twofold_product(x, x), coefficients, 11, 3);
}

# angle_of
/* The angle, from 0 to pi/2, whose tangent is y / x, both non-negative: the known arc tangent of the nearest n / 8, plus that of
   the remaining rotation. */
static twofold_t angle_of(twofold_t y, twofold_t x) {
    /* arctan(n / 8) */
    static const twofold_t arc_tangent[9] = {
        {0.0, 0.0},
        {0.12435499454676144, -3.1253241424539383e-18},
        {0.24497866312686414, 1.0698755618734451e-17},
        {0.35877067027057225, -2.4623815582638635e-17},
        {0.4636476090008061, 2.2698777452961687e-17},
        {0.5585993153435624, -5.4556305485916264e-18},
        {0.6435011087932844, 1.5834785051444286e-17},
        {0.7188299996216245, -2.1478388444456983e-17},
        {0.7853981633974483, 3.061616997868383e-17}
    };
    twofold_t known, z, rest;
    double n;
    if (y.high > x.high) {
        return twofold_sum(half_pi(), twofold_minus(angle_of(x, y)));
    }
    n = nearest(8.0 * y.high / x.high);
    known = twofold_of(n / 8.0, 0.0);
    z = twofold_sum(y, twofold_minus(twofold_product(x, known)));
    z = twofold_quotient(z, twofold_sum(x, twofold_product(y, known)));
    rest = twofold_product(z, odd_polynomial(twofold_minus(twofold_product(z, z)), 9, 2));
    return twofold_sum(arc_tangent[place_of(whole_of(n))], rest);
}

# other_leg
/* The other leg of a triangle whose hypotenuse is 1: the square root of 1 - x^2. */
static twofold_t other_leg(double x) {
    twofold_t square = exact_product(x, x), rest;
    double root;
    square = twofold_sum(exact_sum(1.0, -square.high), twofold_of(-square.low, 0.0));
    if (square.high <= 0.0) {
        return twofold_of(0.0, 0.0);
    }
    root = sqrt_f64(square.high);
    rest = twofold_sum(square, twofold_minus(exact_product(root, root)));
    return ordered_sum(root, rest.high / (2.0 * root));
}

# with_sign
/* The number, negated if the other one is negative. */
static double with_sign(double number, double other) {
    if (other < 0.0) {
        return -number;
    }
    return number;
}

# exp_f64
/* e^x. */
static double exp_f64(double x) {
    if (x == x) {
        return exponential(twofold_of(x, 0.0));
    }
    return x;
}

# ln_f64
/* The natural logarithm: -infinity for 0, NaN for negative numbers. */
static double ln_f64(double x) {
    if (x == 0.0) {
        return -infinite();
    }
    if (x > 0.0 && x < infinite()) {
        return logarithm(x).high;
    }
    if (x > 0.0) {
        return x;
    }
    return no_number();
}

# log_f64
/* The logarithm to base 10. */
static double log_f64(double x) {
    if (!(x > 0.0 && x < infinite())) {
        return ln_f64(x);
    }
    /* 1 / ln(10) */
    return twofold_product(logarithm(x), twofold_of(0.4342944819032518, 1.098319650216765e-17)).high;
}

# sine_from
/* The sine of an angle plus this many quadrants. */
static double sine_from(turn_t turn, u64_t quadrants) {
    u64_t number = (turn.quadrant + quadrants) & 3;
    double y;
    if ((number & 1) == 0) {
        y = sine(turn.rest).high;
    } else {
        y = cosine(turn.rest).high;
    }
    if (number >= 2) {
        return -y;
    }
    return y;
}

# sin_f64
/* The sine of an angle in radians. */
static double sin_f64(double x) {
    if (!(abs_f64(x) < infinite())) {
        return no_number();
    }
    if (abs_f64(x) < tiny()) {
        return x;
    }
    return with_sign(sine_from(quadrant(abs_f64(x)), 0), x);
}

# cos_f64
/* The cosine of an angle in radians. */
static double cos_f64(double x) {
    if (!(abs_f64(x) < infinite())) {
        return no_number();
    }
    return sine_from(quadrant(abs_f64(x)), 1);
}

# tan_f64
/* The tangent of an angle in radians. */
static double tan_f64(double x) {
    turn_t turn;
    if (!(abs_f64(x) < infinite())) {
        return no_number();
    }
    if (abs_f64(x) < tiny()) {
        return x;
    }
    turn = quadrant(abs_f64(x));
    if ((turn.quadrant & 1) == 0) {
        return with_sign(twofold_quotient(sine(turn.rest), cosine(turn.rest)).high, x);
    }
    return with_sign(-twofold_quotient(cosine(turn.rest), sine(turn.rest)).high, x);
}

# asin_f64
/* The angle from -pi/2 to pi/2 whose sine is x; NaN if x is not from -1 to 1. */
static double asin_f64(double x) {
    if (!(abs_f64(x) <= 1.0)) {
        return no_number();
    }
    if (abs_f64(x) < tiny()) {
        return x;
    }
    return with_sign(angle_of(twofold_of(abs_f64(x), 0.0), other_leg(x)).high, x);
}

# acos_f64
/* The angle from 0 to pi whose cosine is x; NaN if x is not from -1 to 1. */
static double acos_f64(double x) {
    twofold_t angle;
    if (!(abs_f64(x) <= 1.0)) {
        return no_number();
    }
    angle = angle_of(other_leg(x), twofold_of(abs_f64(x), 0.0));
    if (x < 0.0) {
        angle = twofold_sum(twofold_of(2.0 * half_pi().high, 2.0 * half_pi().low), twofold_minus(angle));
    }
    return angle.high;
}

# atan_f64
/* The angle from -pi/2 to pi/2 whose tangent is x. */
static double atan_f64(double x) {
    if (!(abs_f64(x) >= tiny())) {
        return x;
    }
    /* 2^64 */
    if (abs_f64(x) > 18446744073709551616.0) {
        return with_sign(half_pi().high, x);
    }
    return with_sign(angle_of(twofold_of(abs_f64(x), 0.0), twofold_of(1.0, 0.0)).high, x);
}

# pow_f64
/* x to the power of y. A negative x requires a whole y; x^0 and 1^y are 1, even for NaN. */
static double pow_f64(double x, double y) {
    double base = abs_f64(x), size = abs_f64(y), sign = 1.0;
    if (y == 0.0 || x == 1.0) {
        return 1.0;
    }
    if (!(x == x && y == y)) {
        return no_number();
    }
    /* The result is negative if x is negative (or -0) and y is odd; from 2^53 upward, all numbers are even. */
    if (trunc_f64(y) == y && trunc_f64(y / 2.0) != y / 2.0 && bits_f64(x) >> 63 == 1) {
        sign = -1.0;
    }
    if (base == 0.0 || base == infinite()) {
        if ((base == 0.0) == (y < 0.0)) {
            return sign * infinite();
        }
        return sign * 0.0;
    }
    if (x < 0.0 && trunc_f64(y) != y) {
        return no_number();
    }
    if (base == 1.0) {
        return sign;
    }
    /* 2^64: overflows or underflows for every base except 1. */
    if (size > 18446744073709551616.0) {
        if ((base > 1.0) == (y > 0.0)) {
            return sign * infinite();
        }
        return sign * 0.0;
    }
    /* 2^-70: for a smaller exponent, the result rounds to 1. */
    if (size < 8.470329472543003e-22) {
        return 1.0;
    }
    return sign * exponential(twofold_product(logarithm(base), twofold_of(y, 0.0)));
}

}
