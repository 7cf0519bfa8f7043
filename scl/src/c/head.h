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

/* What a host calls; one in the same file makes it static. */
#ifndef PROGRAM
#define PROGRAM
#endif
