/* Our mathematics over arrays whose lengths are multiples of LANES, for ctypes and WebAssembly; as a program with -DPROGRAM. */

#include "mathematics.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#define FUNCTIONS(UNARY, BINARY) \
    UNARY(sqrt) UNARY(sin) UNARY(cos) UNARY(tan) UNARY(asin) UNARY(acos) UNARY(atan) UNARY(exp) UNARY(expm1) UNARY(log) \
    UNARY(log1p) UNARY(sinh) UNARY(cosh) UNARY(tanh) UNARY(asinh) UNARY(acosh) UNARY(atanh) UNARY(erf) UNARY(floor) UNARY(ceil) \
    UNARY(fabs) UNARY(sign) UNARY(not) BINARY(atan2) BINARY(pow) BINARY(hypot) BINARY(fmod) BINARY(remainder) BINARY(copysign) \
    BINARY(fmin) BINARY(fmax) BINARY(lt) BINARY(le) BINARY(eq) BINARY(ne) BINARY(and) BINARY(or) BINARY(if)

#define ARRAY(name, call) \
    EXPORT void array_##name(const double *a, const double *b, double *result, __SIZE_TYPE__ n) { \
        for (__SIZE_TYPE__ i = 0; i < n; i += LANES) { \
            real x, y, z; \
            gc_copy(&x, a + i, sizeof x); \
            gc_copy(&y, b + i, sizeof y); \
            z = call; \
            gc_copy(result + i, &z, sizeof z); \
        } \
    }
#define ARRAY_UNARY(name) ARRAY(name, ((void)y, gc_##name(x)))
#define ARRAY_BINARY(name) ARRAY(name, gc_##name(x, y))
FUNCTIONS(ARRAY_UNARY, ARRAY_BINARY)

#if defined(PROGRAM)
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROW(name) {#name, array_##name},
static const struct {
    const char *name;
    void (*call)(const double *, const double *, double *, __SIZE_TYPE__);
} TABLE[] = {FUNCTIONS(ROW, ROW)};

/* PROGRAM NUMBERS RESULTS NAME...: NUMBERS holds n, n first and n second arguments as doubles; the functions' results go to the
   file RESULTS. */
int main(int count, char **arguments) {
    FILE *file = fopen(arguments[1], "rb"), *results = fopen(arguments[2], "wb");
    double size;
    if (!file || !results || fread(&size, sizeof size, 1, file) != 1) return 1;
    size_t n = (size_t)size;
    double *numbers = malloc(3 * n * sizeof size);
    if (!numbers || fread(numbers, sizeof size, 2 * n, file) != 2 * n) return 1;
    for (int i = 3; i < count; i++) {
        for (size_t k = 0; k < sizeof TABLE / sizeof *TABLE; k++) {
            if (strcmp(TABLE[k].name, arguments[i])) continue;
            TABLE[k].call(numbers, numbers + n, numbers + 2 * n, n);
            fwrite(numbers + 2 * n, sizeof size, n, results);
        }
    }
    free(numbers);
    return fclose(file) | fclose(results);
}
#endif
