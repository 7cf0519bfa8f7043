#include <stddef.h>
#include <string.h>

/* Integer types by size in bits. */
typedef signed char i8_t;
typedef unsigned char u8_t;
typedef short i16_t;
typedef unsigned short u16_t;
typedef int i32_t;
typedef unsigned int u32_t;
typedef long long i64_t;
typedef unsigned long long u64_t;
typedef char integers_have_these_bits[sizeof(i16_t) == 2 && sizeof(i32_t) == 4 && sizeof(i64_t) == 8 ? 1 : -1];
#define I64_MAX ((i64_t)(~(u64_t)0 >> 1))
#define I64_MIN (-I64_MAX - 1)

/* The results match the PLC's only if each operation rounds to its type. */
#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the results of this program"
#endif
#if defined(__ASSOCIATIVE_MATH__)
#error "compile without -fassociative-math: it changes the results of this program"
#endif
#if defined(__RECIPROCAL_MATH__)
#error "compile without -freciprocal-math: it changes the results of this program"
#endif
#if defined(__NO_SIGNED_ZEROS__)
#error "compile without -fno-signed-zeros: it changes the results of this program"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0
#error "compile without -ffinite-math-only: it changes the results of this program"
#endif
/* 16, on processors with instructions for _Float16, differs from 0 only for _Float16. */
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "compile for SSE2 (-msse2 -mfpmath=sse) or a similar unit: x87 changes the results of this program"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

/* The functions that a host calls; a host in the same file makes them static. */
#ifndef PROGRAM
#define PROGRAM
#endif
