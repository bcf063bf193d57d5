/* erf. */

#ifndef ERROR_FUNCTION_H
#define ERROR_FUNCTION_H

#include "exponentials.h"
#include "polynomials.h"
#include "real.h"

/* x + x P(x^2) up to 1; 1 - exp(-x^2) Q beyond; 1 from 6 on. */
static inline real gc_erf(real x) {
    real size = gc_fabs(x), six = gc_real(6.0), bounded = gc_blend(gc_less(six, size), six, size), z = x * x, low;
    real near_zero = size + size * gc_polynomial_erf(gc_blend(gc_less(size, gc_real(1.0)), z, gc_real(1.0)));
    real square = gc_two_product(bounded, bounded, &low), t = (bounded - 1.0) / (bounded + 2.0);
    real beyond = 1.0 - gc_exp_of(-square, -low, 0) * gc_polynomial_erfc(t);
    return gc_copysign(gc_blend(gc_less(size, gc_real(1.0)), near_zero, beyond), x);
}

#endif
