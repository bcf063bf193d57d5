/* atan, atan2, asin and acos. */

#ifndef ARCS_H
#define ARCS_H

#include "polynomials.h"
#include "real.h"

#define GC_PI 3.141592653589793
#define GC_PI_LOW 1.2246467991473532e-16

/* atan(y / x) for 0 <= y, 0 <= x, not both 0, from `turn` (a mask) minus that from pi:
   atan(y / x) = atan(c) + atan(u), u = (y - c x) / (x + c y), c = 0, 1/2, 1, 2 or infinity, |u| <= 3/8.
   y - c x is exact: both are within a factor of two of each other. With `exact` the division's rounding error is made good. */
static inline real gc_atan_of(real y, real x, bits turn, int exact) {
    bits half = gc_at_most(0.375 * x, y), one = gc_at_most(0.6875 * x, y), two = gc_at_most(1.5 * x, y);
    bits infinite = gc_at_most(4.0 * x, y);
    real c = gc_blend(two, gc_real(2.0), gc_blend(one, gc_real(1.0), gc_only(half, gc_real(0.5))));
    real base = gc_only(half, gc_real(0.4636476090008061)), base_low = gc_only(half, gc_real(2.2698777452961687e-17));
    base = gc_blend(one, gc_real(0.7853981633974483), base), base_low = gc_blend(one, gc_real(3.061616997868383e-17), base_low);
    base = gc_blend(two, gc_real(1.1071487177940904), base), base_low = gc_blend(two, gc_real(9.40447137356638e-17), base_low);
    base = gc_blend(infinite, gc_real(GC_PI / 2), base), base_low = gc_blend(infinite, gc_real(GC_PI_LOW / 2), base_low);
    real above = gc_blend(infinite, -x, y - c * x), below = gc_blend(infinite, y, x + c * y);
    real u = above / below, error, u_low = gc_real(0.0);
    if (exact) {
        real product = gc_two_product(u, below, &error);
        u_low = ((above - product) - error) / below;
    }
    real z = u * u, rest = u * z * gc_polynomial_atan(z) + u_low;
    bits sign = turn & GC_SIGN;
    u = gc_from_bits(gc_bits(u) ^ sign), rest = gc_from_bits(gc_bits(rest) ^ sign);
    if (exact) { /* the base is pi less itself where it turns */
        real turned = gc_two_sum(gc_real(GC_PI), -base, &error);
        base = gc_blend(turn, turned, base), base_low = gc_blend(turn, GC_PI_LOW - base_low + error, base_low);
    }
    real sum = gc_fast_two_sum(base, u, &error);
    return sum + (error + (rest + base_low));
}

static inline real gc_atan(real x) {
    real size = gc_fabs(x), finite = gc_blend(gc_less(gc_real(1e300), size), gc_real(1e300), size);
    real a = gc_atan_of(finite, gc_real(1.0), gc_bits(gc_real(0.0)), 0);
    return gc_copysign(gc_blend(gc_less(size, gc_real(7.450580596923828e-09)), size, a), x);
}

static inline real gc_atan2(real y, real x) {
    real height = gc_fabs(y), width = gc_fabs(x), zero = gc_real(0.0), one = gc_real(1.0);
    real infinity = gc_from_bits(gc_bits(zero) + GC_INFINITY);
    bits high = gc_equal(height, infinity), wide = gc_equal(width, infinity), at_zero = gc_equal(height + width, zero);
    real h = gc_blend(high, one, gc_only(~wide, height)), w = gc_blend(wide | at_zero, one, gc_only(~high, width));
    real largest = gc_blend(gc_less(h, w), w, h);
    real down = gc_real(2.409919865102884e-181), up = gc_real(4.149515568880993e+180); /* 2^-600, 2^600 */
    real scale = gc_blend(gc_less(gc_real(3.273390607896142e+150), largest), down, one);
    scale = gc_blend(gc_less(largest, gc_real(3.872591914849318e-121)), up, scale);
    bits turn = gc_negative(x);
    real a = gc_atan_of(h * scale, w * scale, turn, 1);
    /* a small angle is the quotient, also where that is subnormal */
    a = gc_blend(gc_less(h, w * 9.313225746154785e-10) & ~turn, h / w, a);
    real sum = x + y; /* NaN if one is; infinite ones may cancel */
    return gc_blend(gc_is_nan(x) | gc_is_nan(y), sum, gc_copysign(a, y));
}

/* Of size = |x|: sqrt((1 - size) / 2) as root + *rest where size >= 1/2, else size and 0; and asin of that less itself. */
static inline real gc_arc_parts(real size, bits large, real *rest, real *tail) {
    real t = 0.5 * (1.0 - size), s = gc_sqrt(t), z = gc_blend(large, t, size * size);
    real root = gc_from_bits(gc_bits(s) & ~INT64_C(0x7FFFFFF)); /* 26 bits: its square is exact */
    real sum = s + root;
    real correction = (t - root * root) / gc_blend(gc_equal(sum, gc_real(0.0)), gc_real(1.0), sum);
    *rest = gc_only(large, correction);
    *tail = gc_blend(large, s, size) * (z * gc_polynomial_asin(z));
    return gc_blend(large, root, size);
}

static inline real gc_asin(real x) {
    real size = gc_fabs(x), rest, tail;
    bits large = gc_at_most(gc_real(0.5), size);
    real root = gc_arc_parts(size, large, &rest, &tail);
    real a = GC_PI / 4 - ((2.0 * tail - (GC_PI_LOW / 2 - 2.0 * rest)) - (GC_PI / 4 - 2.0 * root));
    return gc_copysign(gc_blend(large, a, root + tail), x);
}

static inline real gc_acos(real x) {
    real size = gc_fabs(x), rest, tail, error;
    bits large = gc_at_most(gc_real(0.5), size), negative = gc_less(x, gc_real(0.0));
    real root = gc_arc_parts(size, large, &rest, &tail);
    real beside_one = 2.0 * (root + (rest + tail));
    real from_pi = gc_two_sum(gc_real(GC_PI), -2.0 * root, &error);
    real beside_minus_one = from_pi + (error + (GC_PI_LOW - 2.0 * (rest + tail)));
    real signed_root = gc_copysign(root, x), signed_tail = gc_copysign(tail, x);
    real from_quarter = gc_two_sum(gc_real(GC_PI / 2), -signed_root, &error);
    real between = from_quarter + (error + (GC_PI_LOW / 2 - signed_tail));
    return gc_blend(large, gc_blend(negative, beside_minus_one, beside_one), between);
}

#endif
