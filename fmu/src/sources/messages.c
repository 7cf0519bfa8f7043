
/* --- Messages --------------------------------------------------------------------------------------------------------- */

static void plcfmu_say(plcfmu_text_t *text, const char *more) {
    size_t length = strlen(more), room = sizeof text->text - 1 - text->length;
    length = length < room ? length : room;
    memcpy(text->text + text->length, more, length);
    text->length += length;
    text->text[text->length] = '\0';
}

static void plcfmu_say_whole(plcfmu_text_t *text, i64_t number) {
    char digits[24];
    size_t at = sizeof digits - 1;
    u64_t rest = number < 0 ? 0u - (u64_t)number : (u64_t)number;
    digits[at] = '\0';
    do {
        at -= 1;
        digits[at] = (char)('0' + (int)(rest % 10u));
        rest /= 10u;
    } while (rest != 0);
    plcfmu_say(text, number < 0 ? "-" : "");
    plcfmu_say(text, digits + at);
}

static void plcfmu_say_size(plcfmu_text_t *text, size_t count) {
    if ((u64_t)count > (u64_t)I64_MAX) {
        plcfmu_say_whole(text, (i64_t)(count / 10u));
        plcfmu_say_whole(text, (i64_t)(count % 10u));
    } else {
        plcfmu_say_whole(text, (i64_t)count);
    }
}

/* A string from the host in quotes, truncated to 200 bytes, with control characters escaped. */
static void plcfmu_say_quoted(plcfmu_text_t *text, const char *given) {
    static const char hex[] = "0123456789abcdef";
    size_t i;
    plcfmu_say(text, "\"");
    for (i = 0; given[i] != '\0' && i < 200; i += 1) {
        char one[3] = {'\\', 0, 0};
        unsigned char byte = (unsigned char)given[i];
        if (byte == '"' || byte == '\\' || byte == '\n' || byte == '\r' || byte == '\t') {
            one[1] = byte == '\n' ? 'n' : byte == '\r' ? 'r' : byte == '\t' ? 't' : given[i];
            plcfmu_say(text, one);
        } else if (byte < 0x20 || byte == 0x7f) {
            one[0] = hex[byte & 15];
            plcfmu_say(text, byte < 0x10 ? "\\u{" : byte < 0x20 ? "\\u{1" : "\\u{7");
            plcfmu_say(text, one);
            plcfmu_say(text, "}");
        } else {
            one[0] = given[i];
            plcfmu_say(text, one);
        }
    }
    plcfmu_say(text, given[i] == '\0' ? "\"" : "...\"");
}

/* 1280-bit numbers, enough for all digits of a double. */
#define PLCFMU_LIMBS 40
typedef struct {
    u32_t limbs[PLCFMU_LIMBS];
} plcfmu_big_t;

static void plcfmu_big_times(plcfmu_big_t *a, u32_t factor) {
    u64_t carry = 0;
    int i;
    for (i = 0; i < PLCFMU_LIMBS; i += 1) {
        carry += (u64_t)a->limbs[i] * factor;
        a->limbs[i] = (u32_t)carry;
        carry >>= 32;
    }
}

static void plcfmu_big_power(plcfmu_big_t *a, u32_t base, int exponent) {
    for (; exponent > 0; exponent -= 1) {
        plcfmu_big_times(a, base);
    }
}

/* a + sign * b */
static plcfmu_big_t plcfmu_big_sum(const plcfmu_big_t *a, const plcfmu_big_t *b, int sign) {
    plcfmu_big_t sum;
    i64_t carry = 0;
    int i;
    for (i = 0; i < PLCFMU_LIMBS; i += 1) {
        carry += (i64_t)a->limbs[i] + sign * (i64_t)b->limbs[i];
        sum.limbs[i] = (u32_t)(u64_t)carry;
        carry = carry < 0 ? -1 : carry >> 32;
    }
    return sum;
}

static int plcfmu_big_compare(const plcfmu_big_t *a, const plcfmu_big_t *b) {
    int i;
    for (i = PLCFMU_LIMBS - 1; i >= 0; i -= 1) {
        if (a->limbs[i] != b->limbs[i]) {
            return a->limbs[i] < b->limbs[i] ? -1 : 1;
        }
    }
    return 0;
}

/* The shortest digits that uniquely identify the number, which must be finite and positive: number = 0.DIGITS *
   10^result. */
static int plcfmu_digits(double number, char *digits) {
    u64_t bits, mantissa;
    int exponent, is_even, power, low = 0, high = 0;
    plcfmu_big_t rest = {{0}}, scale = {{0}}, above = {{0}}, below, sum;
    memcpy(&bits, &number, sizeof bits);
    mantissa = bits & 0xFFFFFFFFFFFFFull;
    exponent = (int)(bits >> 52) & 0x7FF;
    mantissa |= exponent > 0 ? 0x10000000000000ull : 0u;
    exponent = (exponent > 0 ? exponent : 1) - 1075;
    is_even = (mantissa & 1u) == 0;
    /* The number is rest / scale; half the distance to the next higher one is above / scale, to the next lower one
       below / scale. */
    rest.limbs[0] = (u32_t)mantissa;
    rest.limbs[1] = (u32_t)(mantissa >> 32);
    scale.limbs[0] = above.limbs[0] = 1;
    plcfmu_big_power(&rest, 2, exponent > 0 ? exponent + 1 : 1);
    plcfmu_big_power(&above, 2, exponent > 0 ? exponent : 0);
    plcfmu_big_power(&scale, 2, exponent > 0 ? 1 : 1 - exponent);
    below = above;
    if (mantissa == 0x10000000000000ull && exponent > -1074) {
        /* Below a power of 2, doubles are twice as dense. */
        plcfmu_big_times(&rest, 2);
        plcfmu_big_times(&scale, 2);
        plcfmu_big_times(&above, 2);
    }
    for (power = 0;; power += 1) {
        sum = plcfmu_big_sum(&rest, &above, 1);
        if (plcfmu_big_compare(&sum, &scale) < (is_even ? 0 : 1)) {
            break;
        }
        plcfmu_big_times(&scale, 10);
    }
    for (; power <= 0; power -= 1) {
        plcfmu_big_t next = plcfmu_big_sum(&rest, &above, 1);
        plcfmu_big_times(&next, 10);
        if (plcfmu_big_compare(&next, &scale) >= (is_even ? 0 : 1)) {
            break;
        }
        plcfmu_big_times(&rest, 10);
        plcfmu_big_times(&above, 10);
        plcfmu_big_times(&below, 10);
    }
    while (!low && !high) {
        int digit = 0;
        plcfmu_big_times(&rest, 10);
        plcfmu_big_times(&above, 10);
        plcfmu_big_times(&below, 10);
        while (plcfmu_big_compare(&rest, &scale) >= 0) {
            rest = plcfmu_big_sum(&rest, &scale, -1);
            digit += 1;
        }
        low = plcfmu_big_compare(&rest, &below) < (is_even ? 1 : 0);
        sum = plcfmu_big_sum(&rest, &above, 1);
        high = plcfmu_big_compare(&sum, &scale) > (is_even ? -1 : 0);
        if (low || high) {
            plcfmu_big_times(&rest, 2);
            digit += high && (!low || plcfmu_big_compare(&rest, &scale) >= 0) ? 1 : 0;
        }
        *digits = (char)('0' + digit);
        digits += 1;
    }
    *digits = '\0';
    return power;
}

/* A number with as few digits as possible: 0.1, 5.0, 1e300; without ".0" if `plain`. */
static void plcfmu_say_number(plcfmu_text_t *text, double number, int plain) {
    char digits[32], one[2] = {0, 0};
    int count, power, i;
    if (number != number) {
        plcfmu_say(text, "NaN");
        return;
    }
    plcfmu_say(text, plcfmu_bits_f64(number) >> 63 ? "-" : "");
    number = plcfmu_abs_f64(number);
    if (number > 1.7976931348623157e308) {
        plcfmu_say(text, "inf");
        return;
    }
    if (number == 0.0) {
        plcfmu_say(text, plain ? "0" : "0.0");
        return;
    }
    power = plcfmu_digits(number, digits);
    count = (int)strlen(digits);
    if (number < 1e-5 || number >= 1e16) {
        one[0] = digits[0];
        plcfmu_say(text, one);
        plcfmu_say(text, count > 1 ? "." : "");
        plcfmu_say(text, digits + 1);
        plcfmu_say(text, "e");
        plcfmu_say_whole(text, power - 1);
        return;
    }
    plcfmu_say(text, power <= 0 ? "0." : "");
    for (i = power; i < 0; i += 1) {
        plcfmu_say(text, "0");
    }
    for (i = 0; i < count || i < power; i += 1) {
        one[0] = i < count ? digits[i] : '0';
        plcfmu_say(text, i == power && i > 0 ? "." : "");
        plcfmu_say(text, one);
    }
    plcfmu_say(text, count <= power && !plain ? ".0" : "");
}

/* Refuses a call with a complete sentence. */
static plcfmu_status_t plcfmu_refuse(plcfmu_text_t *text, const char *sentence) {
    plcfmu_say(text, sentence);
    return PLCFMU_REFUSED;
}
