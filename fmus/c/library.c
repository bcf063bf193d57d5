/* The model's functions for who runs a component without an FMU (the package's fmus/library.py). One call at a time. */

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

EXPORT const int SIZES[] = {N_P_MODEL, N_Q};

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
