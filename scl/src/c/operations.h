# AT_8
/* 8-byte numbers are 8-byte aligned on every platform; by default, i386 aligns them to 4 bytes. */
#if defined(__GNUC__) && defined(__i386__)
#define AT_8 __attribute__((aligned(8)))
#else
#define AT_8
#endif

# LINE
/* A line in the source file with this number. */
#define LINE(file, line) ((file) << 24 | (line))

# call_t
/* A call: its time in nanoseconds, the remaining budget and, if it was stopped, the reason. */
typedef struct {
    i64_t now;
    i64_t budget;
    i32_t stopped; /* the line where it was stopped, or 0 */
    i32_t cause;
    i64_t index;
    i64_t low;
    i64_t high;
} call_t;

enum { OUT_OF_BOUNDS = 1, OUT_OF_BUDGET = 2, STEP_OF_0 = 3 };

# stop
/* Stops a call: its results are discarded, and the caller restores the memory. Only the first cause is kept. */
static void stop(call_t *call, i32_t cause, i32_t line) {
    if (call->stopped == 0) {
        call->stopped = line;
        call->cause = cause;
    }
}

# index_of
/* The zero-based position of an index; stops the call if the index is out of bounds. */
static size_t index_of(call_t *call, i64_t index, i64_t low, i64_t high, i32_t line) {
    if (index >= low && index <= high) {
        return (size_t)(index - low);
    }
    if (call->stopped == 0) {
        call->index = index;
        call->low = low;
        call->high = high;
    }
    stop(call, OUT_OF_BOUNDS, line);
    return 0;
}

# goes_on
/* Whether a loop may continue; stops the call if the budget is exceeded. */
static int goes_on(call_t *call, i32_t line) {
    call->budget -= 1;
    if (call->budget < 0) {
        stop(call, OUT_OF_BUDGET, line);
    }
    return call->stopped == 0;
}

# goes_in
/* Whether a function may be called; stops the call if the budget is exceeded. */
static int goes_in(call_t *call, i32_t line) {
    if (call->budget < 0) {
        stop(call, OUT_OF_BUDGET, line);
    }
    return call->stopped == 0;
}

# f32_of
static float f32_of(u32_t bits) {
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

# f64_of
static double f64_of(u64_t bits) {
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

# bits_f32
static u32_t bits_f32(float number) {
    u32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

# bits_f64
static u64_t bits_f64(double number) {
    u64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

# add_* integer
/* a + b; wraps. */
static $T add_$t($T a, $T b) {
    return ($T)($U)(($W)a + ($W)b);
}

# sub_* integer
/* a - b; wraps. */
static $T sub_$t($T a, $T b) {
    return ($T)($U)(($W)a - ($W)b);
}

# mul_* integer
/* a * b; wraps. */
static $T mul_$t($T a, $T b) {
    return ($T)($U)(($W)a * ($W)b);
}

# neg_* integer
/* -a; wraps. */
static $T neg_$t($T a) {
    return ($T)($U)(($W)0 - ($W)a);
}

# not_* integer
static $T not_$t($T a) {
    return ($T)($U) ~($W)a;
}

# and_* integer
static $T and_$t($T a, $T b) {
    return ($T)(a & b);
}

# or_* integer
static $T or_$t($T a, $T b) {
    return ($T)(a | b);
}

# xor_* integer
static $T xor_$t($T a, $T b) {
    return ($T)(a ^ b);
}

# div_* signed
/* a / b, truncated; 0 if b is 0; wraps. */
static $T div_$t($T a, $T b) {
    return b == 0 ? ($T)0 : b == -1 ? neg_$t(a) : ($T)(a / b);
}

# rem_* signed
/* The remainder of a / b with the sign of a; 0 if b is 0. */
static $T rem_$t($T a, $T b) {
    return b == 0 || b == -1 ? ($T)0 : ($T)(a % b);
}

# div_* unsigned
/* a / b, truncated; 0 if b is 0. */
static $T div_$t($T a, $T b) {
    return b == 0 ? ($T)0 : ($T)(a / b);
}

# rem_* unsigned
/* The remainder of a / b; 0 if b is 0. */
static $T rem_$t($T a, $T b) {
    return b == 0 ? ($T)0 : ($T)(a % b);
}

# shl_* integer
static $T shl_$t($T a, u32_t n) {
    return n < $Bu ? ($T)($U)(($W)($U)a << n) : ($T)0;
}

# shr_* integer
static $T shr_$t($T a, u32_t n) {
    return ($T)((a >> (n < $Bu ? n : $Bu - 1u)) >> (n < $Bu ? 0 : 1));
}

# rol_* integer
static $T rol_$t($T a, u32_t n) {
    n %= $Bu;
    return n == 0 ? a : ($T)($U)(($W)($U)a << n | ($W)($U)a >> ($Bu - n));
}

# ror_* integer
static $T ror_$t($T a, u32_t n) {
    return rol_$t(a, $Bu - n % $Bu);
}

# swap_i8
static i8_t swap_i8(i8_t a) {
    return a;
}

# swap_u8
static u8_t swap_u8(u8_t a) {
    return a;
}

# swap_* integer
/* The bytes in reverse order. */
static $T swap_$t($T a) {
    $U from = ($U)a, to = 0;
    size_t i;
    for (i = 0; i < sizeof a; i += 1) {
        to = ($U)(($W)to << 8 | (from & 0xFFu));
        from = ($U)(from >> 8);
    }
    return ($T)to;
}

# step_* signed
/* Adds the step to a loop counter; returns whether the sum overflows the type. */
static int step_$t($T *a, $T step) {
    $T sum = add_$t(*a, step);
    int beyond = step < 0 ? sum > *a : sum < *a;
    *a = sum;
    return beyond;
}

# step_* unsigned
/* Adds the step to a loop counter; returns whether the sum overflows the type. */
static int step_$t($T *a, $T step) {
    $T sum = add_$t(*a, step);
    int beyond = sum < *a;
    *a = sum;
    return beyond;
}

# min_*
/* The lesser number; a if neither is less. */
static $T min_$t($T a, $T b) {
    return b < a ? b : a;
}

# max_*
/* The greater number; a if neither is greater. */
static $T max_$t($T a, $T b) {
    return b > a ? b : a;
}

# limit_*
/* x, limited to low..high; x itself if low is above high, or if x is NaN. */
static $T limit_$t($T low, $T x, $T high) {
    return high < low ? x : x < low ? low : high < x ? high : x;
}

# ne_*
/* Whether one of the numbers is greater than the other: false if one is NaN. */
static u8_t ne_$t($T a, $T b) {
    return (u8_t)(a < b || a > b);
}

# select_*
static $T select_$t(u8_t which, $T a, $T b) {
    return which ? a : b;
}

# same_*
static u8_t same_$t(const void *a, const void *b, size_t count) {
    size_t i;
    for (i = 0; i < count; i += 1) {
        $T x, y;
        memcpy(&x, (const char *)a + i * sizeof x, sizeof x);
        memcpy(&y, (const char *)b + i * sizeof y, sizeof y);
        if (!(x == y)) {
            return 0;
        }
    }
    return 1;
}

# and_bool
/* Both sides are evaluated, as on the PLC. */
static u8_t and_bool(u8_t a, u8_t b) {
    return a && b;
}

# or_bool
/* Both sides are evaluated, as on the PLC. */
static u8_t or_bool(u8_t a, u8_t b) {
    return a || b;
}

# abs_f32
static float abs_f32(float a) {
    return f32_of(bits_f32(a) & 0x7FFFFFFFu);
}

# abs_f64
static double abs_f64(double a) {
    return f64_of(bits_f64(a) & 0x7FFFFFFFFFFFFFFFull);
}

# abs_* signed
/* The absolute value; wraps. */
static $T abs_$t($T a) {
    return a < 0 ? neg_$t(a) : a;
}

# is_whole
/* Whether x is whole because its magnitude is at least 2^52; NaN counts as whole. */
static int is_whole(double x) {
    return !(x > -4503599627370496.0 && x < 4503599627370496.0);
}

# trunc_f64
static double trunc_f64(double x) {
    double whole;
    if (is_whole(x)) {
        return x;
    }
    whole = (double)(i64_t)x;
    return whole == 0.0 ? f64_of(bits_f64(x) & 0x8000000000000000ull) : whole;
}

# round_f64
/* The nearest whole number, ties to even. */
static double round_f64(double x) {
    if (is_whole(x)) {
        return x;
    }
    return x < 0.0 ? (x - 4503599627370496.0) + 4503599627370496.0 : (x + 4503599627370496.0) - 4503599627370496.0;
}

# floor_f64
static double floor_f64(double x) {
    return trunc_f64(x) > x ? trunc_f64(x) - 1.0 : trunc_f64(x);
}

# ceil_f64
static double ceil_f64(double x) {
    return trunc_f64(x) < x ? trunc_f64(x) + 1.0 : trunc_f64(x);
}

# frac_f32
static float frac_f32(float x) {
    return x - (float)trunc_f64((double)x);
}

# frac_f64
static double frac_f64(double x) {
    return x - trunc_f64(x);
}

# whole_i64
/* A whole number as an integer: saturated beyond 64 bits, 0 for NaN. */
static i64_t whole_i64(double x) {
    if (!(x == x)) {
        return 0;
    }
    return x >= 9223372036854775808.0 ? I64_MAX : x < -9223372036854775808.0 ? I64_MIN : (i64_t)x;
}

# whole_u64
static u64_t whole_u64(double x) {
    return !(x > 0.0) ? (u64_t)whole_i64(x) : x >= 18446744073709551616.0 ? (u64_t)-1 : (u64_t)x;
}

# round_i32
/* The nearest integer, ties to even: adding 1.5 * 2^52 leaves no bit for a fraction. Beyond 32 bits, the low bits are used. */
static i32_t round_i32(double x) {
    if (x >= -2147483648.0 && x <= 2147483647.0) {
        return (i32_t)((x + 6755399441055744.0) - 6755399441055744.0);
    }
    return (i32_t)whole_i64(round_f64(x));
}

# sqrt_f64
/* The square root, digit by digit, rounded to nearest: two bits of the mantissa yield one bit of the root. */
static double sqrt_f64(double x) {
    u64_t mantissa = bits_f64(x) & 0xFFFFFFFFFFFFFull, root = 0, rest = 0;
    i64_t exponent = (i64_t)(bits_f64(x) >> 52);
    int i;
    if (!(x > 0.0) || exponent == 0x7FF) {
        return x < 0.0 ? f64_of(0x7FF8000000000000ull) : x;
    }
    if (exponent == 0) {
        exponent = 1;
        while (mantissa < 0x10000000000000ull) {
            mantissa <<= 1;
            exponent -= 1;
        }
    }
    mantissa |= 0x10000000000000ull;
    exponent -= 1023;
    mantissa <<= (exponent & 1) != 0 ? 11 : 10;
    for (i = 0; i < 54; i += 1) {
        u64_t next = root << 2 | 1;
        rest = rest << 2 | mantissa >> 62;
        mantissa <<= 2;
        root <<= 1;
        if (rest >= next) {
            rest -= next;
            root |= 1;
        }
    }
    root = (root >> 1) + (root & 1);
    exponent = (exponent - (exponent & 1)) / 2 + 1023;
    return f64_of(((u64_t)exponent << 52) + (root - 0x10000000000000ull));
}

# length_of
/* The length of a string, at most its capacity. A string is a 16-bit length, then characters of one or two bytes. */
static size_t length_of(const void *text, size_t capacity) {
    u16_t length;
    memcpy(&length, text, sizeof length);
    return length < capacity ? length : capacity;
}

# copy_text
static void copy_text(void *to, size_t to_capacity, const void *from, size_t from_capacity, size_t width) {
    size_t length = length_of(from, from_capacity);
    u16_t kept = (u16_t)(length < to_capacity ? length : to_capacity);
    memmove((char *)to + 2, (const char *)from + 2, kept * width);
    memcpy(to, &kept, sizeof kept);
}

# compare_text
static int compare_text(const void *a, size_t a_capacity, const void *b, size_t b_capacity, size_t width) {
    size_t a_length = length_of(a, a_capacity), b_length = length_of(b, b_capacity), i;
    const unsigned char *x = (const unsigned char *)a + 2, *y = (const unsigned char *)b + 2;
    for (i = 0; i < a_length && i < b_length; i += 1) {
        int p = width == 1 ? x[i] : x[2 * i] | x[2 * i + 1] << 8;
        int q = width == 1 ? y[i] : y[2 * i] | y[2 * i + 1] << 8;
        if (p != q) {
            return p < q ? -1 : 1;
        }
    }
    return a_length < b_length ? -1 : a_length > b_length;
}

# twofold_t
/* An unevaluated sum of two numbers, with about 106 bits. The second is at most half a unit in the last place of the first, which is
   therefore the rounded sum. */
typedef struct {
    double high;
    double low;
} twofold_t;

# twofold_of
static twofold_t twofold_of(double high, double low) {
    twofold_t number;
    number.high = high;
    number.low = low;
    return number;
}

# power_of_2
/* 2^k for -1022 to 1023. */
static double power_of_2(i64_t k) {
    return f64_of((u64_t)(k + 1023) << 52);
}

# twofolds_t
typedef const twofold_t *twofolds_t;

# digits_t
typedef const u64_t *digits_t;

# turn_t
/* An angle, as a quadrant and the offset from the quadrant's axis. */
typedef struct {
    u64_t quadrant;
    twofold_t rest;
} turn_t;

# turn_of
static turn_t turn_of(u64_t quadrant, twofold_t rest) {
    turn_t turn;
    turn.quadrant = quadrant;
    turn.rest = rest;
    return turn;
}

# whole_of
static i64_t whole_of(double x) {
    return (i64_t)x;
}

# real_of
static double real_of(u64_t x) {
    return (double)x;
}

# place_of
static size_t place_of(i64_t x) {
    return (size_t)x;
}

# pow_f32
static float pow_f32(float x, float y) {
    return (float)pow_f64((double)x, (double)y);
}

# *_f32
static float $F_f32(float x) {
    return (float)$F_f64((double)x);
}
