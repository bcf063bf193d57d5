/* Steps of several instances of this FMU at once, each in a lane of a vector register (LANES), with the bits that each has alone.
   Compiled apart from the FMU, for the processor at hand, from the sources that the FMU carries; INSTANTIATION_TOKEN tells whether
   both are of one model. The instances are the FMU's own: what is done to them between steps goes through FMI. One call at a time. */

#include <math.h>

#include "core.h"

#ifdef NO_LANES
#error "a model with a sampled part or an implicit method does not run in lanes"
#endif

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

EXPORT const char INSTANTIATION_TOKEN[] = TOKEN;

static real P[N_P_MODEL + N_Q + 1]; /* of all lanes: the parameters with what depends on them alone */
static int P_known;

/* The numbers of all lanes, of a quantity one after another; a lane without an instance repeats another's. */
#define GATHER(to, n, from)                                                                     \
    for (int lane = 0; lane < LANES; lane++) {                                                  \
        const Instance *m = of[lane] ? of[lane] : any;                                          \
        for (int i = 0; i < (n); i++) gc_set_lane(&(to)[i], lane, (from)[i]);                   \
    }

static const Instance *first_of(Instance *const *of) {
    const Instance *any = NULL;
    for (int lane = 0; lane < LANES && !any; lane++) any = of[lane];
    return any;
}

/* To be called when other instances come into the lanes, or parameters have changed. */
EXPORT void batch_forget(void) { P_known = 0; }

static void gather_parameters(Instance *const *of, const Instance *any) {
    if (P_known) return;
    GATHER(P, N_P_MODEL, m->s.p)
#if N_Q > 0
    const real *argument[] = {P};
    real *result[] = {P + N_P_MODEL};
    MODEL(prepare)(argument, result, NULL, NULL, 0);
#endif
    P_known = 1;
}

/* Whether one of the variables is computed, and no state, parameter or input. */
EXPORT int batch_computed(const uint32_t *vr, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] < N_VARIABLES && VARIABLES[vr[i]].kind == OUTPUT) return 1;
    return 0;
}

/* doStep of each instance, NULL for none, from its t over its h: as macro_step in step.c with equal internal steps. Returns, as a
   bit for each lane, those that cannot: they come to no finite state, say; their instances are as before. */
EXPORT int64_t batch_step(Instance *const *of, const double *t, const double *h) {
    const real *argument[WORK_ARGUMENTS];
    real *result[WORK_RESULTS];
    const Room room = {argument, result, NULL, NULL};
    real x[AT_LEAST_ONE(N_X)], next[AT_LEAST_ONE(N_X)], U[3 * AT_LEAST_ONE(N_U)], length, n;
    const Instance *any = first_of(of);
    double most = 1.0, h_any = 1.0; /* an empty lane does the same as another, so that it costs nothing more */
    int64_t bad = 0;
    bits lost = gc_less(gc_real(0.0), gc_real(0.0));
    for (int lane = LANES - 1; lane >= 0; lane--)
        if (of[lane]) h_any = h[lane];
    gather_parameters(of, any);
    GATHER(x, N_X, m->s.x)
    GATHER(U, 3 * N_U, m->s.U)
    for (int lane = 0; lane < LANES; lane++) {
        const Instance *m = of[lane] ? of[lane] : any;
        double whole = of[lane] ? h[lane] : h_any, parts = ceil(whole / m->s.p[INTERNAL_STEP] - 1e-9);
        if (!(parts >= 1.0)) parts = 1.0;
        if (parts > most) most = parts;
        gc_set_lane(&length, lane, whole / parts), gc_set_lane(&n, lane, parts);
    }
    for (double k = 0.0; k < most; k++) {
        const bits goes_on = gc_less(gc_real(k), n);
        internal_step(&room, x, U, P, k * length, length, next);
        for (int i = 0; i < N_X; i++) {
            x[i] = gc_blend(goes_on, next[i], x[i]);
            lost |= ~gc_less(gc_fabs(x[i]), gc_from_bits(gc_bits(gc_real(0.0)) + GC_INFINITY));
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        Instance *m = of[lane];
        if (!m) continue;
        if (gc_lane(gc_truth(lost), lane) != 0.0 || m->s.p[TOLERANCE] > 0.0) { /* no error control here: that is done alone */
            bad |= (int64_t)1 << lane;
            continue;
        }
        double *u = m->s.u_now, step = h[lane];
        for (int i = 0; i < N_X; i++) m->s.x[i] = gc_lane(x[i], lane);
        for (int i = 0; i < N_U; i++) {
            const double *c = m->s.U;
            u[i] = c[i] + c[i + N_U] * step + c[i + 2 * N_U] * (step * step) / 2;
            u[i + N_U] = c[i + N_U] + c[i + 2 * N_U] * step;
            u[i + 2 * N_U] = c[i + 2 * N_U];
        }
        for (int i = N_U; i < 3 * N_U; i++) m->s.U[i] = 0.0;
        m->s.time = m->last_successful = t[lane] + step;
        m->y_known = m->x_dot_known = 0;
    }
    return bad;
}

/* The outputs of each instance, where they are not known; FMI's getters then find them. */
EXPORT void batch_output(Instance *const *of) {
    real x[AT_LEAST_ONE(N_X)], u[AT_LEAST_ONE(N_U)], y[AT_LEAST_ONE(N_Y)];
    const real *argument[] = {x, u, P};
    real *result[] = {y};
    const Instance *any = first_of(of);
    gather_parameters(of, any);
    GATHER(x, N_X, m->s.x)
    GATHER(u, N_U, m->s.u_now)
    MODEL(output)(argument, result, NULL, NULL, 0);
    for (int lane = 0; lane < LANES; lane++) {
        if (!of[lane]) continue;
        for (int i = 0; i < N_Y; i++) of[lane]->y[i] = gc_lane(y[i], lane);
        of[lane]->y_known = 1;
    }
}
