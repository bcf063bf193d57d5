/* Our mathematics over arrays whose lengths are multiples of LANES, for ctypes, WebAssembly and emulators. */

#include "mathematics.h"

#include <stddef.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#define UNARY(name) \
    EXPORT void array_##name(const double *a, const double *b, double *result, size_t n) { \
        (void)b; \
        for (size_t i = 0; i < n; i += LANES) { \
            real x, y; \
            memcpy(&x, a + i, sizeof x); \
            y = gc_##name(x); \
            memcpy(result + i, &y, sizeof y); \
        } \
    }
#define BINARY(name) \
    EXPORT void array_##name(const double *a, const double *b, double *result, size_t n) { \
        for (size_t i = 0; i < n; i += LANES) { \
            real x, y, z; \
            memcpy(&x, a + i, sizeof x); \
            memcpy(&y, b + i, sizeof y); \
            z = gc_##name(x, y); \
            memcpy(result + i, &z, sizeof z); \
        } \
    }

UNARY(sqrt)
UNARY(sin)
UNARY(cos)
UNARY(tan)
UNARY(asin)
UNARY(acos)
UNARY(atan)
UNARY(exp)
UNARY(expm1)
UNARY(log)
UNARY(log1p)
UNARY(sinh)
UNARY(cosh)
UNARY(tanh)
UNARY(asinh)
UNARY(acosh)
UNARY(atanh)
UNARY(erf)
UNARY(floor)
UNARY(ceil)
UNARY(fabs)
UNARY(sign)
UNARY(not)
BINARY(atan2)
BINARY(pow)
BINARY(hypot)
BINARY(fmod)
BINARY(remainder)
BINARY(copysign)
BINARY(fmin)
BINARY(fmax)
BINARY(lt)
BINARY(le)
BINARY(eq)
BINARY(ne)
BINARY(and)
BINARY(or)
BINARY(if)
