/* exp, log and what is made of them. */

#ifndef EXPONENTIALS_H
#define EXPONENTIALS_H

#include "polynomials.h"
#include "real.h"

#define GC_WHOLE 6755399441055744.0               /* 1.5 2^52: adding it rounds to an integer */
#define GC_WHOLE_BITS INT64_C(0x4338000000000000) /* its bits */
#define GC_LN2 0.6931471805598903                 /* 42 bits of log(2): integers below 2^11 times it are exact */
#define GC_LN2_LOW 5.497923018708371e-14

/* 2^k, k from -1022 to 1023. */
static inline real gc_power_of_two(bits k) { return gc_from_bits(gc_shift_left(k + 1023, 52)); }

/* x + low = k log(2) + r + *r_low, |r| <= log(2) / 2. */
static inline real gc_split_by_ln2(real x, real low, real *r_low, bits *k) {
    real rounded = x * 1.4426950408889634 + GC_WHOLE, n = rounded - GC_WHOLE;
    real high = x - n * GC_LN2, rest = n * GC_LN2_LOW - low, r = high - rest;
    *r_low = (high - r) - rest;
    *k = gc_bits(rounded) - GC_WHOLE_BITS;
    return r;
}

/* exp(x + low) 2^shift; over- and underflows as it must. Two factors, for 2^k alone may be out of range. */
static inline real gc_exp_of(real x, real low, int shift) {
    real top = gc_real(712.0), bottom = gc_real(-747.0), r_low, error;
    bits out = gc_less(top, x) | gc_less(x, bottom), k;
    x = gc_blend(gc_less(top, x), top, gc_blend(gc_less(x, bottom), bottom, x));
    real r = gc_split_by_ln2(x, gc_only(~out, low), &r_low, &k);
    real tail = r * r * gc_polynomial_exp(r) + (r_low + r * r_low);
    real sum = gc_fast_two_sum(gc_real(1.0), r, &error) + (error + tail);
    k = k + shift;
    bits first = gc_shift_right(k + 2048, 1) - 1024;
    return sum * gc_power_of_two(first) * gc_power_of_two(k - first);
}

static inline real gc_exp(real x) { return gc_exp_of(x, gc_real(0.0), 0); }

/* exp(x) - 1 as a sum; beyond 60 as at 60. */
static inline real gc_expm1_parts(real x, real *low) {
    real top = gc_real(60.0), r_low, e_low, error, m_low;
    bits k;
    x = gc_blend(gc_less(top, x), top, gc_blend(gc_less(x, -top), -top, x));
    real r = gc_split_by_ln2(x, gc_real(0.0), &r_low, &k), t = gc_power_of_two(k);
    real e = gc_fast_two_sum(r, r * r * gc_polynomial_exp(r) + (r_low + r * r_low), &e_low);
    real m = gc_two_sum(t, gc_real(-1.0), &m_low); /* 2^k (1 + e) - 1 */
    real sum = gc_two_sum(m, t * e, &error);
    return gc_fast_two_sum(sum, error + (m_low + t * e_low), low);
}

static inline real gc_expm1(real x) {
    real low, a = gc_blend(gc_less(gc_real(40.0), x), gc_exp(x), gc_expm1_parts(x, &low));
    return gc_blend(gc_less(gc_fabs(x), gc_real(5e-17)), x, a);
}

/* x = 2^k m, m from sqrt(1/2) to sqrt(2), for positive finite x; k as a number. */
static inline real gc_split_power(real x, real *k) {
    bits subnormal = gc_less(x, gc_real(2.2250738585072014e-308));
    bits word = gc_bits(gc_blend(subnormal, x * 18014398509481984.0, x)); /* 2^54 */
    bits power = gc_shift_right(word - INT64_C(0x3FE6A09E667F3BCD) + INT64_C(0x4000000000000000), 52) - 1024;
    *k = (gc_from_bits(power + GC_WHOLE_BITS) - GC_WHOLE) - gc_only(subnormal, gc_real(54.0));
    return gc_from_bits(word - gc_shift_left(power, 52));
}

/* log(m) + k log(2) + low, f = m - 1. */
static inline real gc_log_of(real f, real k, real low) {
    real s = f / (2.0 + f), z = s * s, half = 0.5 * f * f, error;
    real tail = s * (half + z * gc_polynomial_log(z)) + (k * GC_LN2_LOW + low);
    /* k log(2) + f - half + tail, the large ones with their errors */
    real sum = gc_two_sum(k * GC_LN2, f, &error), sum_low;
    sum = gc_two_sum(sum, -half, &sum_low);
    return sum + ((error + sum_low) + tail);
}

/* What log gives where x is not positive and finite: infinity, NaN, and -infinity at 0. */
static inline real gc_log_edge(real x) {
    bits none = gc_bits(gc_real(0.0));
    real edge = gc_blend(gc_less(x, gc_real(0.0)), gc_from_bits(none + GC_NAN), x);
    return gc_blend(gc_equal(x, gc_real(0.0)), gc_from_bits(none + (GC_INFINITY | GC_SIGN)), edge);
}

static inline bits gc_positive_finite(real x) { return gc_less(gc_real(0.0), x) & gc_less(x - x, gc_real(1.0)); }

static inline real gc_log(real x) {
    real k, m = gc_split_power(x, &k);
    return gc_blend(gc_positive_finite(x), gc_log_of(m - 1.0, k, gc_real(0.0)), gc_log_edge(x));
}

static inline real gc_log1p(real x) {
    real lost, u = gc_two_sum(gc_real(1.0), x, &lost), k, m = gc_split_power(u, &k);
    real a = gc_log_of(m - 1.0, k, lost / u);
    a = gc_blend(gc_positive_finite(u), a, gc_log_edge(u));
    return gc_blend(gc_less(gc_fabs(x), gc_real(5e-17)), x, a);
}

/* ---- pow ------------------------------------------------------------------------------------------------------------ */

/* log(x) as a sum, to about 2^-68 of itself, for positive finite x: 2 atanh(s), s = f / (2 + f), with the two first terms of the
   series behind 2 s in twice the digits. */
static inline real gc_log_twice(real x, real *log_low) {
    real k, f = gc_split_power(x, &k) - 1.0, e;
    real below = 2.0 + f, below_low = f - (below - 2.0), s = f / below, product = gc_two_product(s, below, &e);
    real s_low = (((f - product) - e) - s * below_low) / below;
    real z_low, z = gc_two_product(s, s, &z_low);
    z_low += 2.0 * s * s_low;
    real a_low, a = gc_fast_two_sum(gc_real(0.4), z * gc_polynomial_log_tail(z), &a_low); /* 2/5 + ... */
    a_low -= 2.2204460492503132e-17;
    real b_low, b = gc_two_product(z, a, &b_low), c_low;
    b_low += z * a_low + z_low * a;
    real c = gc_fast_two_sum(gc_real(0.6666666666666666), b, &c_low); /* 2/3 + ... */
    c_low += b_low + 3.700743415417188e-17;
    real d_low, d = gc_two_product(z, c, &d_low), g_low;
    d_low += z * c_low + z_low * c;
    real g = gc_fast_two_sum(gc_real(2.0), d, &g_low); /* 2 + ... */
    g_low += d_low;
    real l_low, l = gc_two_product(s, g, &l_low), sum_low;
    l_low += s * g_low + s_low * g;
    real sum = gc_two_sum(k * GC_LN2, l, &sum_low);
    sum_low += l_low + k * GC_LN2_LOW;
    return gc_fast_two_sum(sum, sum_low, log_low);
}

static inline real gc_pow(real x, real y) {
    real zero = gc_real(0.0), one = gc_real(1.0), size = gc_fabs(x), large = gc_real(1.1805916207174113e+21); /* 2^70 */
    real infinity = gc_from_bits(gc_bits(zero) + GC_INFINITY), not_a_number = gc_from_bits(gc_bits(zero) + GC_NAN);
    real power = gc_blend(gc_less(large, gc_fabs(y)), gc_copysign(large, y), y), log_low, low;
    real log_high = gc_log_twice(size, &log_low), exponent = gc_two_product(power, log_high, &low);
    real result = gc_exp_of(exponent, low + power * log_low, 0);
    bits at_zero = gc_equal(size, zero), whole = gc_equal(gc_floor(y), y), odd = whole & gc_unequal(2.0 * gc_floor(0.5 * y), y);
    bits rises = gc_less(zero, y);
    result = gc_blend(at_zero, gc_blend(rises, zero, infinity), result);
    result = gc_blend(gc_equal(size, infinity), gc_blend(rises, infinity, zero), result);
    result = gc_blend(gc_less(x, zero) & ~whole & gc_less(size, infinity), not_a_number, result);
    result = gc_blend(gc_negative(x) & odd, -result, result);
    result = gc_blend(gc_is_nan(x) | gc_is_nan(y), x + y, result);
    return gc_blend(gc_equal(x, one) | gc_equal(y, zero), one, result);
}

/* ---- hyperbolic functions ------------------------------------------------------------------------------------------- */

/* (e + e / (e + 1)) / 2, e = exp(x) - 1. */
static inline real gc_sinh(real x) {
    real size = gc_fabs(x), low, e = gc_expm1_parts(size, &low), quotient = e / (e + 1.0), rest = 1.0 - quotient;
    real a = 0.5 * (e + (quotient + low * (1.0 + rest * rest)));
    a = gc_blend(gc_less(gc_real(20.0), size), gc_exp_of(size, gc_real(0.0), -1), a);
    return gc_copysign(gc_blend(gc_less(size, gc_real(1e-9)), size, a), x);
}

static inline real gc_cosh(real x) {
    real half = gc_exp_of(gc_fabs(x), gc_real(0.0), -1);
    return half + 0.25 / half;
}

/* e / (e + 2), e = exp(2 x) - 1. */
static inline real gc_tanh(real x) {
    real size = gc_fabs(x), low, error, e = gc_expm1_parts(2.0 * size, &low), below = gc_two_sum(e, gc_real(2.0), &error);
    real quotient = e / below, a = quotient + (low - quotient * (error + low)) / below;
    return gc_copysign(gc_blend(gc_less(size, gc_real(1e-9)), size, a), x);
}

/* log1p(x + x^2 / (1 + sqrt(1 + x^2))), log(2 x) for large x. */
static inline real gc_asinh(real x) {
    real size = gc_fabs(x), square = size * size;
    bits large = gc_less(gc_real(1e9), size);
    real a = gc_log1p(gc_blend(large, size - 1.0, size + square / (1.0 + gc_sqrt(1.0 + square))));
    a = a + gc_only(large, gc_real(0.6931471805599453));
    return gc_copysign(gc_blend(gc_less(size, gc_real(1e-9)), size, a), x);
}

/* log1p(t + sqrt(2 t + t^2)), t = x - 1, log(2 x) for large x. */
static inline real gc_acosh(real x) {
    real t = x - 1.0;
    bits large = gc_less(gc_real(1e9), x);
    real a = gc_log1p(gc_blend(large, t, t + gc_sqrt(2.0 * t + t * t))) + gc_only(large, gc_real(0.6931471805599453));
    return gc_blend(gc_less(x, gc_real(1.0)), (x - x) / (x - x), a);
}

static inline real gc_atanh(real x) {
    real size = gc_fabs(x), a = 0.5 * gc_log1p(2.0 * size / (1.0 - size));
    return gc_copysign(gc_blend(gc_less(size, gc_real(1e-9)), size, a), x);
}

#endif
