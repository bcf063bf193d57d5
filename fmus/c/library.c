/* The model as a library for who runs a component without an FMU (the package's fmus/library.py): one run, or LANES of them side
   by side. Arrays hold `real`: of each quantity the numbers of all runs, one after another. Not to be entered twice at a time. */

#include "core.h"

#include "model.c"
#include "equations.c"
#ifdef STEP_BY_RK4
#include "rk4.c"
#endif
#include "internal_step.c"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

static const real *argument[WORK_ARGUMENTS];
static real *result[WORK_RESULTS], work[WORK_REALS];
static int integers[WORK_INTEGERS];
static const Room ROOM = {argument, result, integers, work};

EXPORT const int SIZES[] = {LANES, N_X, N_U, N_Y, N_P_MODEL, N_Q};

/* P: the parameters p, then what depends on them alone. */
EXPORT void prepare(const real *p, real *P) {
    for (int i = 0; i < N_P_MODEL; i++) P[i] = p[i];
#if N_Q > 0
    call_in(&ROOM, MODEL(prepare), 1, (const real *[]){p}, P + N_P_MODEL);
#endif
}

EXPORT void rhs(const real *x, const real *u, const real *P, real *x_dot) {
    call_in(&ROOM, MODEL(rhs), 3, (const real *[]){x, u, P}, x_dot);
}

EXPORT void output(const real *x, const real *u, const real *P, real *y) {
    call_in(&ROOM, MODEL(output), 3, (const real *[]){x, u, P}, y);
}

#ifdef SAMPLE_PERIOD
EXPORT void sample(const real *x, const real *u, const real *P, real *x_next) {
    call_in(&ROOM, MODEL(sample), 3, (const real *[]){x, u, P}, x_next);
}
#endif

EXPORT void step(const real *x, const real *U, const real *P, const real *tau, const real *h, real *x_next) {
    internal_step(&ROOM, x, U, P, *tau, *h, x_next);
}

/* A macro step of h in equal internal steps, none longer than `longest`: x is moved. U as in step(): value, first and second
   derivative of the inputs at its start; as at its end afterwards. Returns all ones for a run whose state is finite no more. */
EXPORT void advance(real *x, real *U, const real *P, const real *h, const real *longest, bits *lost) {
    real next[AT_LEAST_ONE(N_X)], n = gc_ceil(*h / *longest - 1e-9);
    double most = 1.0;
    n = gc_blend(gc_at_most(gc_real(1.0), n), n, gc_real(1.0));
    for (int i = 0; i < LANES; i++)
        if (gc_lane(n, i) > most) most = gc_lane(n, i);
    const real part = *h / n;
    *lost = gc_less(gc_real(1.0), gc_real(0.0));
    for (double k = 0.0; k < most; k++) {
        const bits goes_on = gc_less(gc_real(k), n);
        internal_step(&ROOM, x, U, P, k * part, part, next);
        for (int i = 0; i < N_X; i++) {
            x[i] = gc_blend(goes_on, next[i], x[i]);
            *lost |= ~gc_less(gc_fabs(x[i]), gc_from_bits(gc_bits(gc_real(0.0)) + GC_INFINITY));
        }
    }
    for (int i = 0; i < N_U; i++) {
        U[i] = U[i] + U[i + N_U] * *h + U[i + 2 * N_U] * (*h * *h) / 2;
        U[i + N_U] = U[i + 2 * N_U] = gc_real(0.0);
    }
}
