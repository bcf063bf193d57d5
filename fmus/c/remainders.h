/* hypot, fmod and remainder. */

#ifndef REMAINDERS_H
#define REMAINDERS_H

#include "real.h"

/* sqrt(x^2 + y^2) without overflow on the way: the squares in twice the digits, and one step of Newton's. */
static inline real gc_hypot(real x, real y) {
    real a = gc_fabs(x), b = gc_fabs(y), zero = gc_real(0.0), infinity = gc_from_bits(gc_bits(zero) + GC_INFINITY);
    real large = gc_blend(gc_less(a, b), b, a), small = gc_blend(gc_less(a, b), a, b);
    bits high = gc_less(gc_real(3.273390607896142e+150), large), low = gc_less(large, gc_real(3.872591914849318e-121));
    real down = gc_real(2.409919865102884e-181), up = gc_real(4.149515568880993e+180), one = gc_real(1.0); /* 2^-600, 2^600 */
    real scale = gc_blend(high, down, gc_blend(low, up, one)), back = gc_blend(high, up, gc_blend(low, down, one));
    real p_low, q_low, s_low, r_low, p = large * scale, q = small * scale;
    p = gc_two_product(p, p, &p_low), q = gc_two_product(q, q, &q_low);
    real sum = gc_fast_two_sum(p, q, &s_low), root = gc_sqrt(sum), square = gc_two_product(root, root, &r_low);
    real correction = ((sum - square) - r_low + (s_low + (p_low + q_low))) / (2.0 * root);
    real h = gc_blend(gc_equal(large, zero), zero, (root + correction) * back);
    h = gc_blend(gc_is_nan(x) | gc_is_nan(y), x + y, h);
    return gc_blend(gc_equal(a, infinity) | gc_equal(b, infinity), infinity, h);
}

/* One remainder, exact: a long division, ten bits of the quotient at a time. *odd: whether the quotient is. */
static double gc_divide(double x, double y, int *odd) {
    uint64_t a, b, sign, mask = ((uint64_t)1 << 52) - 1, quotient;
    gc_copy(&a, &x, sizeof a);
    gc_copy(&b, &y, sizeof b);
    sign = a >> 63 << 63, a &= ~((uint64_t)1 << 63), b &= ~((uint64_t)1 << 63);
    *odd = 0;
    if (b == 0 || a >= (uint64_t)GC_INFINITY || b > (uint64_t)GC_INFINITY) return (x * y) / (x * y) - (x - x) / (x - x);
    if (a < b) return x;
    int ea = (int)(a >> 52), eb = (int)(b >> 52);
    a = ea ? (a & mask) | (mask + 1) : a, b = eb ? (b & mask) | (mask + 1) : b;
    ea += !ea, eb += !eb;
    quotient = a / b, a %= b;
    for (int left = ea - eb; left > 0; left -= 10) {
        int n = left < 10 ? left : 10;
        quotient = (a << n) / b, a = (a << n) % b;
    }
    *odd = (int)(quotient & 1);
    if (a == 0) return sign ? -0.0 : 0.0;
    for (; !(a >> 52) && eb > 1; eb--) a <<= 1;
    a = a >> 52 ? (a & mask) | (uint64_t)eb << 52 : a;
    a |= sign;
    gc_copy(&x, &a, sizeof x);
    return x;
}

/* Lane by lane: how long the division is depends on the numbers. */
static inline real gc_fmod(real x, real y) {
    real result = x;
    int odd;
    for (int i = 0; i < LANES; i++) gc_set_lane(&result, i, gc_divide(gc_lane(x, i), gc_lane(y, i), &odd));
    return result;
}

/* To the nearest multiple of y, of two the even one. */
static inline real gc_remainder(real x, real y) {
    real result = x;
    for (int i = 0; i < LANES; i++) {
        double of = gc_lane(y, i), size = of < 0.0 ? -of : of;
        int odd;
        double rest = gc_divide(gc_lane(x, i), of, &odd), distance = rest < 0.0 ? -rest : rest;
        int beyond = distance > size - distance || (distance == size - distance && odd);
        if (beyond && size - size == 0.0) rest = rest < 0.0 ? -(distance - size) : distance - size;
        gc_set_lane(&result, i, rest);
    }
    return result;
}

#endif
