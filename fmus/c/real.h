/* The number that models compute with, and branch-free primitives: one source for one run and for several side by side.

   LANES undefined or 1: `real` is double, in plain C99. LANES 2, 4 or 8: `real` holds that many doubles and every operation
   works on each (vector extensions of gcc and clang). A lane gets the bits that a double would: both run the same IEEE 754
   operations in the same order, and none may be contracted or reordered. Truth values are 1.0 and 0.0, as CasADi has them;
   inside, a condition is a mask of all ones or all zeros. */

#ifndef REAL_H
#define REAL_H

#include <stdint.h>

#if defined(__GNUC__) /* with what stands in the compiler no library is needed, not even C's */
#define gc_copy __builtin_memcpy
#define gc_root __builtin_sqrt
#else
#include <math.h>
#include <string.h>
#define gc_copy memcpy
#define gc_root sqrt
#endif

#if defined(__GNUC__)
#define GC_APART __attribute__((noinline)) /* a part of a long function: together the compiler would take minutes */
#else
#define GC_APART
#endif

#if defined(_MSC_VER)
#pragma fp_contract(off)
#elif defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#endif /* gcc does not contract with -std=c99 */

#ifndef LANES
#define LANES 1
#endif

#if LANES == 1
typedef double real;
typedef int64_t bits;
#elif LANES == 2 || LANES == 4 || LANES == 8
typedef double real __attribute__((vector_size(8 * LANES)));
typedef int64_t bits __attribute__((vector_size(8 * LANES)));
typedef uint64_t unsigned_bits __attribute__((vector_size(8 * LANES)));
#else
#error "LANES must be 1, 2, 4 or 8"
#endif

#define GC_INFINITY INT64_C(0x7FF0000000000000) /* the bits of infinity, of NaN, of 1.0 and of the sign */
#define GC_NAN INT64_C(0x7FF8000000000000)
#define GC_ONE INT64_C(0x3FF0000000000000)
#define GC_SIGN INT64_MIN

/* ---- a number and its bits ------------------------------------------------------------------------------------------ */

#if LANES == 1
static inline real gc_real(double c) { return c; }
static inline bits gc_bits(real a) {
    bits b;
    gc_copy(&b, &a, sizeof b);
    return b;
}
static inline real gc_from_bits(bits b) {
    real a;
    gc_copy(&a, &b, sizeof a);
    return a;
}
static inline bits gc_shift_right(bits a, int n) { return (bits)((uint64_t)a >> n); }
static inline bits gc_shift_left(bits a, int n) { return (bits)((uint64_t)a << n); }
static inline double gc_lane(real a, int i) { return (void)i, a; }
static inline void gc_set_lane(real *a, int i, double value) { (void)i, *a = value; }
static inline int gc_any(bits condition) { return condition != 0; }
#define GC_MASK(condition) (-(bits)(condition))
#else
static inline real gc_real(double c) { return c - (real){0}; } /* the same in all lanes; keeps -0 */
static inline bits gc_bits(real a) { return (bits)a; }
static inline real gc_from_bits(bits b) { return (real)b; }
static inline bits gc_shift_right(bits a, int n) { return (bits)((unsigned_bits)a >> n); }
static inline bits gc_shift_left(bits a, int n) { return (bits)((unsigned_bits)a << n); }
static inline double gc_lane(real a, int i) { return a[i]; }
static inline void gc_set_lane(real *a, int i, double value) { (*a)[i] = value; }
static inline int gc_any(bits condition) {
    int64_t any = 0;
    for (int i = 0; i < LANES; i++) any |= condition[i];
    return any != 0;
}
#define GC_MASK(condition) ((bits)(condition))
#endif

/* ---- conditions ----------------------------------------------------------------------------------------------------- */

static inline bits gc_less(real a, real b) { return GC_MASK(a < b); }
static inline bits gc_at_most(real a, real b) { return GC_MASK(a <= b); }
static inline bits gc_equal(real a, real b) { return GC_MASK(a == b); }
static inline bits gc_unequal(real a, real b) { return GC_MASK(a != b); }
static inline bits gc_is_nan(real a) { return GC_MASK(a != a); }
static inline bits gc_true(real a) { return GC_MASK(a != gc_real(0.0)); } /* NaN is true, as in C */
static inline bits gc_negative(real a) { return -gc_shift_right(gc_bits(a), 63); } /* by the sign: -0, too */

/* a where the condition holds, else b; and a or 0. Of one double a compiler knows best how to choose. */
#if LANES == 1
static inline real gc_blend(bits condition, real a, real b) { return condition ? a : b; }
static inline real gc_only(bits condition, real a) { return condition ? a : 0.0; }
#else
static inline real gc_blend(bits condition, real a, real b) {
    return gc_from_bits((condition & gc_bits(a)) | (~condition & gc_bits(b)));
}
static inline real gc_only(bits condition, real a) { return gc_from_bits(condition & gc_bits(a)); }
#endif

static inline real gc_truth(bits condition) { return gc_from_bits(condition & GC_ONE); }

/* ---- CasADi's logic ------------------------------------------------------------------------------------------------- */

static inline real gc_lt(real a, real b) { return gc_truth(gc_less(a, b)); }
static inline real gc_le(real a, real b) { return gc_truth(gc_at_most(a, b)); }
static inline real gc_eq(real a, real b) { return gc_truth(gc_equal(a, b)); }
static inline real gc_ne(real a, real b) { return gc_truth(gc_unequal(a, b)); }
static inline real gc_and(real a, real b) { return gc_truth(gc_true(a) & gc_true(b)); }
static inline real gc_or(real a, real b) { return gc_truth(gc_true(a) | gc_true(b)); }
static inline real gc_not(real a) { return gc_truth(~gc_true(a)); }

/* a where c is true, else 0, whatever a is: CasADi's if_else_zero. */
static inline real gc_if(real c, real a) { return gc_only(gc_true(c), a); }

/* ---- exact functions ------------------------------------------------------------------------------------------------ */

static inline real gc_fabs(real a) { return gc_from_bits(gc_bits(a) & INT64_MAX); }

static inline real gc_copysign(real a, real b) { return gc_from_bits((gc_bits(a) & INT64_MAX) | (gc_bits(b) & GC_SIGN)); }

/* -1, 1 or a itself if it is a zero or NaN. */
static inline real gc_sign(real a) {
    return gc_blend(gc_less(gc_real(0.0), gc_fabs(a)), gc_copysign(gc_real(1.0), a), a);
}

/* The other one if one is NaN. */
static inline real gc_fmin(real a, real b) { return gc_blend(gc_less(a, b) | gc_is_nan(b), a, b); }
static inline real gc_fmax(real a, real b) { return gc_blend(gc_less(b, a) | gc_is_nan(b), a, b); }

/* The nearest integer, the even one of two, for numbers below 2^52; larger ones are integers. */
static inline real gc_round(real a) {
    real size = gc_fabs(a), rounded = (size + 4503599627370496.0) - 4503599627370496.0;
    return gc_copysign(gc_blend(gc_less(size, gc_real(4503599627370496.0)), rounded, size), a);
}

static inline real gc_floor(real a) {
    real rounded = gc_round(a);
    return gc_copysign(rounded - gc_truth(gc_less(a, rounded)), a);
}

static inline real gc_ceil(real a) {
    real rounded = gc_round(a);
    return gc_copysign(rounded + gc_truth(gc_less(rounded, a)), a);
}

/* Correctly rounded by IEEE 754: the instruction. -fno-math-errno spares the call that sets errno. */
static inline real gc_sqrt(real a) {
#if LANES > 1
    real root;
    for (int i = 0; i < LANES; i++) root[i] = gc_root(a[i]);
    return root;
#else
    return gc_root(a);
#endif
}

/* ---- sums and products with their rounding errors ------------------------------------------------------------------- */

/* a + b = sum + *error exactly (Knuth). */
static inline real gc_two_sum(real a, real b, real *error) {
    real sum = a + b, from_b = sum - a;
    *error = (a - (sum - from_b)) + (b - from_b);
    return sum;
}

/* The same where |a| >= |b| or a = 0 (Dekker). */
static inline real gc_fast_two_sum(real a, real b, real *error) {
    real sum = a + b;
    *error = (a - sum) + b;
    return sum;
}

/* a b = product + *error exactly, if nothing over- or underflows (Dekker, Veltkamp). */
static inline real gc_two_product(real a, real b, real *error) {
    real p = a * 134217729.0, q = b * 134217729.0; /* 2^27 + 1 */
    real a_high = p - (p - a), b_high = q - (q - b), a_low = a - a_high, b_low = b - b_high, product = a * b;
    *error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return product;
}

#endif
