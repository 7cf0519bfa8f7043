#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* The results are those of the PLC only if each operation rounds to its type. */
#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the results of this program"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error "compile for SSE or another unit that rounds each operation: x87 changes the results of this program"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

/* No program uses all operations. */
#if defined(__GNUC__)
#define OPERATION static inline __attribute__((unused))
#else
#define OPERATION static inline
#endif

/* What a host calls; one in the same file makes it static. */
#ifndef PROGRAM
#define PROGRAM
#endif

/* Numbers of 8 bytes lie at multiples of 8 everywhere; i386 would put them at multiples of 4. */
#if defined(__GNUC__) && defined(__i386__)
#define AT_8 __attribute__((aligned(8)))
#else
#define AT_8
#endif

/* A line of one of several sources. */
#define LINE(file, line) ((file) << 24 | (line))

/* A call: its time in nanoseconds, what is left of its budget, and why it was stopped, if it was. */
typedef struct {
    int64_t now;
    int64_t budget;
    int32_t stopped; /* the line, or 0 */
    int32_t cause;
    int64_t index;
    int64_t low;
    int64_t high;
} call_t;

enum { OUT_OF_BOUNDS = 1, OUT_OF_BUDGET = 2, STEP_OF_0 = 3 };

OPERATION void stop(call_t *call, int32_t cause, int32_t line) {
    if (call->stopped == 0) {
        call->stopped = line;
        call->cause = cause;
    }
}

/* How far an index lies behind the lowest one. Outside of its bounds it stops the call, whose memory the caller restores. */
OPERATION size_t index_of(call_t *call, int64_t index, int64_t low, int64_t high, int32_t line) {
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

/* Whether a loop may go on. */
OPERATION int goes_on(call_t *call, int32_t line) {
    call->budget -= 1;
    if (call->budget < 0) {
        stop(call, OUT_OF_BUDGET, line);
    }
    return call->stopped == 0;
}

OPERATION float f32_of(uint32_t bits) {
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

OPERATION double f64_of(uint64_t bits) {
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

OPERATION uint32_t bits_f32(float number) {
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

OPERATION uint64_t bits_f64(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

/* Operations of integers: T is the type, U the unsigned one of its width, W an unsigned one that C does not widen. */
#define INTEGER(t, T, U, W, BITS, MINUS_1, DOWN)                                                                        \
    OPERATION T add_##t(T a, T b) { return (T)(U)((W)a + (W)b); }                                                       \
    OPERATION T sub_##t(T a, T b) { return (T)(U)((W)a - (W)b); }                                                       \
    OPERATION T mul_##t(T a, T b) { return (T)(U)((W)a * (W)b); }                                                       \
    OPERATION T neg_##t(T a) { return (T)(U)((W)0 - (W)a); }                                                            \
    OPERATION T not_##t(T a) { return (T)(U) ~(W)a; }                                                                   \
    OPERATION T and_##t(T a, T b) { return (T)(a & b); }                                                                \
    OPERATION T or_##t(T a, T b) { return (T)(a | b); }                                                                 \
    OPERATION T xor_##t(T a, T b) { return (T)(a ^ b); }                                                                \
    OPERATION T div_##t(T a, T b) { return b == 0 ? (T)0 : MINUS_1 ? neg_##t(a) : (T)(a / b); }                         \
    OPERATION T rem_##t(T a, T b) { return b == 0 || MINUS_1 ? (T)0 : (T)(a % b); }                                     \
    OPERATION T shl_##t(T a, uint32_t n) { return n < BITS ? (T)(U)((W)(U)a << n) : (T)0; }                             \
    OPERATION T shr_##t(T a, uint32_t n) { return (T)((a >> (n < BITS ? n : BITS - 1)) >> (n < BITS ? 0 : 1)); }        \
    OPERATION T rol_##t(T a, uint32_t n) {                                                                              \
        n %= BITS;                                                                                                      \
        return n == 0 ? a : (T)(U)((W)(U)a << n | (W)(U)a >> (BITS - n));                                               \
    }                                                                                                                   \
    OPERATION T ror_##t(T a, uint32_t n) { return rol_##t(a, BITS - n % BITS); }                                        \
    OPERATION T swap_##t(T a) {                                                                                         \
        U from = (U)a, to = 0;                                                                                          \
        for (size_t i = 0; i < sizeof a; i += 1) {                                                                      \
            to = (U)((W)to << (BITS == 8 ? 0 : 8) | (from & 0xFF));                                                     \
            from = (U)(from >> (BITS == 8 ? 0 : 8));                                                                    \
        }                                                                                                               \
        return (T)to;                                                                                                   \
    }                                                                                                                   \
    OPERATION int step_##t(T *a, T step) {                                                                              \
        T sum = add_##t(*a, step);                                                                                      \
        int beyond = DOWN ? sum > *a : sum < *a;                                                                        \
        *a = sum;                                                                                                       \
        return beyond;                                                                                                  \
    }                                                                                                                   \
    ORDERED(t, T)

/* Operations of all numbers: comparisons with what is not a number are FALSE. */
#define ORDERED(t, T)                                                                                                   \
    OPERATION T min_##t(T a, T b) { return b < a ? b : a; }                                                             \
    OPERATION T max_##t(T a, T b) { return b > a ? b : a; }                                                             \
    OPERATION T limit_##t(T low, T x, T high) {                                                                         \
        return high < low ? x : x < low ? low : high < x ? high : x;                                                    \
    }                                                                                                                   \
    OPERATION uint8_t ne_##t(T a, T b) { return a < b || a > b; }                                                       \
    OPERATION T select_##t(uint8_t which, T a, T b) { return which ? a : b; }                                           \
    OPERATION uint8_t same_##t(const void *a, const void *b, size_t count) {                                            \
        T x, y;                                                                                                         \
        for (size_t i = 0; i < count; i += 1) {                                                                         \
            memcpy(&x, (const char *)a + i * sizeof x, sizeof x);                                                       \
            memcpy(&y, (const char *)b + i * sizeof y, sizeof y);                                                       \
            if (!(x == y)) {                                                                                            \
                return 0;                                                                                               \
            }                                                                                                           \
        }                                                                                                               \
        return 1;                                                                                                       \
    }

INTEGER(i8, int8_t, uint8_t, uint32_t, 8u, b == -1, step < 0)
INTEGER(i16, int16_t, uint16_t, uint32_t, 16u, b == -1, step < 0)
INTEGER(i32, int32_t, uint32_t, uint32_t, 32u, b == -1, step < 0)
INTEGER(i64, int64_t, uint64_t, uint64_t, 64u, b == -1, step < 0)
INTEGER(u8, uint8_t, uint8_t, uint32_t, 8u, 0, 0)
INTEGER(u16, uint16_t, uint16_t, uint32_t, 16u, 0, 0)
INTEGER(u32, uint32_t, uint32_t, uint32_t, 32u, 0, 0)
INTEGER(u64, uint64_t, uint64_t, uint64_t, 64u, 0, 0)
ORDERED(f32, float)
ORDERED(f64, double)
ORDERED(bool, uint8_t)

/* Both sides are always calculated, as on the PLC. */
OPERATION uint8_t and_bool(uint8_t a, uint8_t b) { return a & b; }
OPERATION uint8_t or_bool(uint8_t a, uint8_t b) { return a | b; }
OPERATION uint8_t xor_bool(uint8_t a, uint8_t b) { return a ^ b; }

OPERATION int8_t abs_i8(int8_t a) { return a < 0 ? neg_i8(a) : a; }
OPERATION int16_t abs_i16(int16_t a) { return a < 0 ? neg_i16(a) : a; }
OPERATION int32_t abs_i32(int32_t a) { return a < 0 ? neg_i32(a) : a; }
OPERATION int64_t abs_i64(int64_t a) { return a < 0 ? neg_i64(a) : a; }
OPERATION float abs_f32(float a) { return f32_of(bits_f32(a) & 0x7FFFFFFFu); }
OPERATION double abs_f64(double a) { return f64_of(bits_f64(a) & 0x7FFFFFFFFFFFFFFFu); }
OPERATION float neg_f32(float a) { return -a; }
OPERATION double neg_f64(double a) { return -a; }

/* From 2^52 on every number is whole. */
OPERATION int is_whole(double x) { return !(x > -4503599627370496.0 && x < 4503599627370496.0); }
OPERATION double trunc_f64(double x) { return is_whole(x) || x == 0.0 ? x : (double)(int64_t)x; }
OPERATION double round_f64(double x) {
    return is_whole(x) ? x : x < 0.0 ? (x - 4503599627370496.0) + 4503599627370496.0
                                     : (x + 4503599627370496.0) - 4503599627370496.0;
}
OPERATION double floor_f64(double x) { return trunc_f64(x) > x ? trunc_f64(x) - 1.0 : trunc_f64(x); }
OPERATION double ceil_f64(double x) { return trunc_f64(x) < x ? trunc_f64(x) + 1.0 : trunc_f64(x); }
OPERATION float frac_f32(float x) { return x - (float)trunc_f64((double)x); }
OPERATION double frac_f64(double x) { return x - trunc_f64(x); }

/* A whole number as an integer: the last one beyond 64 bits, 0 for what is not a number. */
OPERATION int64_t whole_i64(double x) {
    return x != x ? 0 : x >= 9223372036854775808.0 ? INT64_MAX : x < -9223372036854775808.0 ? INT64_MIN : (int64_t)x;
}
OPERATION uint64_t whole_u64(double x) {
    return !(x > 0.0) ? (uint64_t)whole_i64(x) : x >= 18446744073709551616.0 ? UINT64_MAX : (uint64_t)x;
}

/* The square root, digit by digit and rounded to the nearest number; two bits of the mantissa give one of the root. */
OPERATION double sqrt_f64(double x) {
    uint64_t mantissa = bits_f64(x) & 0xFFFFFFFFFFFFFu, root = 0, rest = 0;
    int64_t exponent = (int64_t)(bits_f64(x) >> 52);
    if (!(x > 0.0) || exponent == 0x7FF) {
        return x < 0.0 ? f64_of(0x7FF8000000000000u) : x;
    }
    if (exponent == 0) {
        exponent = 1;
        while (mantissa < 0x10000000000000u) {
            mantissa <<= 1;
            exponent -= 1;
        }
    }
    mantissa |= 0x10000000000000u;
    exponent -= 1023;
    mantissa <<= (exponent & 1) != 0 ? 11 : 10;
    for (int i = 0; i < 54; i += 1) {
        uint64_t next = root << 2 | 1;
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
    return f64_of(((uint64_t)exponent << 52) + (root - 0x10000000000000u));
}
OPERATION float sqrt_f32(float x) { return (float)sqrt_f64((double)x); }

/* Texts: a length, then characters of one or two bytes. */
OPERATION size_t length_of(const void *text, size_t capacity) {
    uint16_t length;
    memcpy(&length, text, sizeof length);
    return length < capacity ? length : capacity;
}
OPERATION void copy_text(void *to, size_t to_capacity, const void *from, size_t from_capacity, size_t width) {
    size_t length = length_of(from, from_capacity);
    uint16_t kept = (uint16_t)(length < to_capacity ? length : to_capacity);
    memmove((char *)to + 2, (const char *)from + 2, kept * width);
    memcpy(to, &kept, sizeof kept);
}
OPERATION int compare_text(const void *a, size_t a_capacity, const void *b, size_t b_capacity, size_t width) {
    size_t a_length = length_of(a, a_capacity), b_length = length_of(b, b_capacity);
    const unsigned char *x = (const unsigned char *)a + 2, *y = (const unsigned char *)b + 2;
    for (size_t i = 0; i < a_length && i < b_length; i += 1) {
        int p = width == 1 ? x[i] : x[2 * i] | x[2 * i + 1] << 8;
        int q = width == 1 ? y[i] : y[2 * i] | y[2 * i + 1] << 8;
        if (p != q) {
            return p < q ? -1 : 1;
        }
    }
    return a_length < b_length ? -1 : a_length > b_length;
}
