/* sin, cos and tan. x = n pi/2 + r, |r| <= pi/4, then polynomials of sin and cos over r.

   Up to FAR the reduction is Cody and Waite's: pi/2 in three parts, of which n times the first two are exact (n < 2^15, parts of
   38 bits), the difference kept with its rounding error. Numbers beyond FAR are rare; they take the long way one by one, by
   Payne and Hanek's method in integers, in lanes as well. So every finite number has a correct sine, and the common way has
   no branch but this one, which is never taken. */

#ifndef TRIGONOMETRY_H
#define TRIGONOMETRY_H

#include "polynomials.h"
#include "real.h"

#define GC_FAR 51000.0                /* less than 2^15 pi/2 */
#define GC_INTEGER 6755399441055744.0 /* 1.5 2^52: adding it rounds to an integer, which then stands in the lowest bits */

/* The bits of 2/pi behind 64 zeros. */
static const uint32_t GC_TWO_OVER_PI[40] = {
    0x00000000u, 0x00000000u, 0xa2f9836eu, 0x4e441529u, 0xfc2757d1u, 0xf534ddc0u, 0xdb629599u, 0x3c439041u, 0xfe5163abu, 0xdebbc561u,
    0xb7246e3au, 0x424dd2e0u, 0x06492eeau, 0x09d1921cu, 0xfe1deb1cu, 0xb129a73eu, 0xe88235f5u, 0x2ebb4484u, 0xe99c7026u, 0xb45f7e41u,
    0x3991d639u, 0x835339f4u, 0x9c845f8bu, 0xbdf9283bu, 0x1ff897ffu, 0xde05980fu, 0xef2f118bu, 0x5a0a6d1fu, 0x6d367ecfu, 0x27cb09b7u,
    0x4f463f66u, 0x9e5fea2du, 0x7527bac7u, 0xebe5f17bu, 0x3d0739f7u, 0x8a5292eau, 0x6bfb5fb1u, 0x1f8d5d08u, 0x56033046u, 0xfc7b6babu,
};

/* One finite x of at least 2^15: r and its error, and n modulo 4. Of x 2/pi / 4 only the fraction counts: 192 bits of it are made
   from x's 53 and those bits of 2/pi that do not give whole turns; at most 62 of them cancel, so more than 120 remain. */
static int gc_reduce_far(double x, double *r, double *r_error) {
    int64_t word;
    gc_copy(&word, &x, sizeof word);
    int position = (int)(word >> 52 & 0x7FF) - 1075 + 62, at = position >> 5, shift = position & 31;
    uint64_t m = ((uint64_t)word & 0xFFFFFFFFFFFFFu) | (uint64_t)1 << 52, m_low = m & 0xFFFFFFFFu, m_high = m >> 32, carry = 0, f[3];
    uint32_t turns[6];
    for (int i = 5; i >= 0; i--) {
        uint64_t pair = (uint64_t)GC_TWO_OVER_PI[at + i] << 32 | GC_TWO_OVER_PI[at + i + 1], part = pair << shift >> 32;
        carry += part * m_low;
        turns[i] = (uint32_t)carry;
        carry >>= 32;
    }
    carry = 0;
    for (int i = 5; i >= 1; i--) {
        uint64_t pair = (uint64_t)GC_TWO_OVER_PI[at + i] << 32 | GC_TWO_OVER_PI[at + i + 1], part = pair << shift >> 32;
        carry += part * m_high + turns[i - 1];
        turns[i - 1] = (uint32_t)carry;
        carry >>= 32;
    }
    for (int i = 0; i < 3; i++) f[i] = (uint64_t)turns[2 * i] << 32 | turns[2 * i + 1];
    int n = (int)(f[0] >> 62), negative;
    for (int i = 0; i < 3; i++) f[i] = f[i] << 2 | (i < 2 ? f[i + 1] >> 62 : 0);
    negative = (int)(f[0] >> 63); /* a fraction of a half and more is one above, less the rest */
    if (negative) {
        f[0] = ~f[0], f[1] = ~f[1], f[2] = ~f[2] + 1;
        if (f[2] == 0 && ++f[1] == 0) f[0]++;
        n++;
    }
    double unit = 1.0 / 9007199254740992.0; /* 2^-53 */
    for (; f[0] >> 63 == 0; unit *= 0.5) f[0] = f[0] << 1 | f[1] >> 63, f[1] = f[1] << 1 | f[2] >> 63, f[2] <<= 1;
    double high = (double)(int64_t)(f[0] >> 11) * unit;
    double low = (double)(int64_t)((f[0] & 0x7FF) << 42 | f[1] >> 22) * unit / 9007199254740992.0;
    /* times pi/2, of which the first 26 bits, the next 27 and the rest */
    double h = high * 134217729.0, h1 = h - (h - high), h0 = high - h1, a1 = 1.5707963407039642, a0 = -1.3909067675399456e-08;
    double product = high * 1.5707963267948966;
    double error = ((h1 * a1 - product) + h1 * a0 + h0 * a1) + h0 * a0;
    error += high * 6.123233995736766e-17 + low * 1.5707963267948966;
    *r = product + error;
    *r_error = (product - *r) + error;
    if (negative != (word < 0)) *r = -*r, *r_error = -*r_error;
    return word < 0 ? -n & 3 : n & 3;
}

/* r + *r_error = x - n pi/2 within 2^-115; n, of which the two lowest bits hold. Infinite x gives NaN. */
static inline real gc_reduce(real x, real *r_error, bits *n) {
    real rounded = x * 0.6366197723675814 + GC_INTEGER, whole = rounded - GC_INTEGER;
    real error, first = x - whole * 1.5707963267923333;
    real second = gc_two_sum(first, -(whole * 2.5633441515839558e-12), &error);
    real rest = whole * 1.0562999066987428e-23 - error, r = second - rest;
    bits far = gc_less(gc_real(GC_FAR), gc_fabs(x));
    *r_error = (second - r) - rest;
    *n = gc_bits(rounded);
    if (gc_any(far)) {
        for (int i = 0; i < LANES; i++) {
            double one = gc_lane(x, i), high, low;
            if (!(one > GC_FAR || one < -GC_FAR)) continue;
            if (one - one != 0.0) {
                gc_set_lane(&r, i, one - one);
                continue;
            }
            gc_set_lane(&rounded, i, (double)gc_reduce_far(one, &high, &low) + GC_INTEGER);
            gc_set_lane(&r, i, high);
            gc_set_lane(r_error, i, low);
        }
        *n = gc_bits(rounded);
    }
    return r;
}

/* sin(r + e) and cos(r + e) as sums: what is returned, which is rounded last, and *low. */
static inline real gc_sin_parts(real r, real e, real *low) {
    real z = r * r;
    *low = (z * r) * gc_polynomial_sin(z) + (e - 0.5 * z * e);
    return r;
}

static inline real gc_cos_parts(real r, real e, real *low) {
    real z = r * r, half = 0.5 * z, one = 1.0 - half;
    *low = ((1.0 - one) - half) + (z * z * gc_polynomial_cos(z) - r * e);
    return one;
}

/* Both at once: they share nearly all. */
static inline void gc_sincos(real x, real *sine, real *cosine) {
    real e, s_low, c_low;
    bits n;
    real r = gc_reduce(x, &e, &n), s = gc_sin_parts(r, e, &s_low), c = gc_cos_parts(r, e, &c_low);
    s += s_low, c += c_low;
    bits odd = -(n & 1);
    *sine = gc_from_bits(gc_bits(gc_blend(odd, c, s)) ^ gc_shift_left(n & 2, 62));
    *sine = gc_blend(gc_less(gc_fabs(x), gc_real(7.450580596923828e-09)), x, *sine); /* keeps -0 */
    *cosine = gc_from_bits(gc_bits(gc_blend(odd, s, c)) ^ gc_shift_left((n + 1) & 2, 62));
}

static inline real gc_sin(real x) {
    real s, c;
    gc_sincos(x, &s, &c);
    return s;
}

static inline real gc_cos(real x) {
    real s, c;
    gc_sincos(x, &s, &c);
    return c;
}

/* The quotient of sin and cos as sums, with the rest of the division. */
static inline real gc_tan(real x) {
    real e, s_low, c_low, error;
    bits n;
    real r = gc_reduce(x, &e, &n), s = gc_sin_parts(r, e, &s_low), c = gc_cos_parts(r, e, &c_low);
    s = gc_fast_two_sum(s, s_low, &s_low), c = gc_fast_two_sum(c, c_low, &c_low);
    bits odd = -(n & 1);
    real above = gc_blend(odd, -c, s), above_low = gc_blend(odd, -c_low, s_low);
    real below = gc_blend(odd, s, c), below_low = gc_blend(odd, s_low, c_low);
    real quotient = above / below, product = gc_two_product(quotient, below, &error);
    real t = quotient + (((above - product) - error) + above_low - quotient * below_low) / below;
    return gc_blend(gc_less(gc_fabs(x), gc_real(7.450580596923828e-09)), x, t);
}

#endif
