/* Directional and adjoint derivatives of the model, and the time derivatives of its outputs. */

#include "core.h"

/* Jacobian of `unknown` with respect to `known` times `seed` (forward), or its transpose times `seed` (adjoint). A state
   may be among the unknowns (an output that is a state) as well as among the knowns. */
static Status sensitivity(Instance *m, const char *function, const uint32_t *unknown, size_t n_unknown, const uint32_t *known,
                          size_t n_known, const double *seed, double *value, int adjoint) {
    double x[AT_LEAST_ONE(N_X)] = {0}, u[AT_LEAST_ONE(N_U)] = {0}, p[AT_LEAST_ONE(N_P)] = {0};
    double y[AT_LEAST_ONE(N_Y)] = {0}, x_dot[AT_LEAST_ONE(N_X)] = {0};
    double more_x[AT_LEAST_ONE(N_X)], more_u[AT_LEAST_ONE(N_U)], more_p[AT_LEAST_ONE(N_P)];
    int need_y = 0, need_x_dot = 0;
    for (size_t i = 0; i < n_unknown; i++) {
        if (unknown[i] >= N_VARIABLES) return fail(m, function, "unknown value reference");
        Kind kind = VARIABLES[unknown[i]].kind;
        if (kind != OUTPUT && kind != DERIVATIVE && kind != STATE) return fail(m, function, "an unknown is no output or derivative");
        need_y |= kind == OUTPUT;
        need_x_dot |= kind == DERIVATIVE;
    }
    for (size_t i = 0; i < n_known; i++) {
        if (known[i] >= N_VARIABLES) return fail(m, function, "unknown value reference");
        const Variable *v = &VARIABLES[known[i]];
        if (!(v->kind == STATE || v->kind == INPUT || (v->kind == PARAMETER && v->index < N_P_MODEL)))
            return fail(m, function, "a known is no state, input or parameter of the model");
        if (adjoint) continue;
        (v->kind == STATE ? x : v->kind == INPUT ? u : p)[v->index] += seed[i];
    }
    if (!adjoint) {
        const double *in[] = {m->s.x, m->s.u_now, m->s.p, x, u, p};
        if (need_y) call(m, MODEL(output_forward), 6, in, 1, (double *[]){y});
        if (need_x_dot) call(m, MODEL(rhs_forward), 6, in, 1, (double *[]){x_dot});
        for (size_t i = 0; i < n_unknown; i++) {
            const Variable *v = &VARIABLES[unknown[i]];
            value[i] = (v->kind == OUTPUT ? y : v->kind == DERIVATIVE ? x_dot : x)[v->index];
        }
        return OK;
    }
    for (size_t i = 0; i < n_unknown; i++) {
        const Variable *v = &VARIABLES[unknown[i]];
        (v->kind == OUTPUT ? y : v->kind == DERIVATIVE ? x_dot : x)[v->index] += seed[i];
    }
    for (int pass = 0; pass < 2; pass++) {
        if (pass == 0 ? !need_y : !need_x_dot) continue;
        call(m, pass == 0 ? MODEL(output_adjoint) : MODEL(rhs_adjoint), 4,
             (const double *[]){m->s.x, m->s.u_now, m->s.p, pass == 0 ? y : x_dot}, 3, (double *[]){more_x, more_u, more_p});
        for (int i = 0; i < N_X; i++) x[i] += more_x[i];
        for (int i = 0; i < N_U; i++) u[i] += more_u[i];
        for (int i = 0; i < N_P_MODEL; i++) p[i] += more_p[i];
    }
    for (size_t i = 0; i < n_known; i++) {
        const Variable *v = &VARIABLES[known[i]];
        value[i] = (v->kind == STATE ? x : v->kind == INPUT ? u : p)[v->index];
    }
    return OK;
}

/* Time derivative of the outputs at the present time, of `order` 1 or 2, with the inputs' present derivatives. */
static void output_rates(Instance *m, int order, double *rate) {
    static const double none[AT_LEAST_ONE(N_P)] = {0};
    const double *u1 = m->s.u_now + N_U;
    if (order == 1)
        call(m, MODEL(output_forward), 6, (const double *[]){m->s.x, m->s.u_now, m->s.p, derivatives(m), u1, none}, 1,
             (double *[]){rate});
#if MAX_OUTPUT_ORDER > 1
    else
        call(m, MODEL(output_second), 5, (const double *[]){m->s.x, m->s.u_now, m->s.p, u1, u1 + N_U}, 1, (double *[]){rate});
#endif
}

static Status output_derivatives(Instance *m, const char *function, const uint32_t *vr, size_t n, const int32_t *order,
                                 double *value) {
    double rate[AT_LEAST_ONE(N_Y)];
    int computed = 0;
    for (size_t i = 0; i < n; i++) {
        int row = -1;
        if (vr[i] < N_VARIABLES && VARIABLES[vr[i]].kind == OUTPUT) row = VARIABLES[vr[i]].index;
        for (int k = 0; k < N_Y; k++)
            if (vr[i] < N_VARIABLES && VARIABLES[vr[i]].kind == STATE && OUTPUT_STATE[k] == VARIABLES[vr[i]].index) row = k;
        if (row < 0) return fail(m, function, "the variable is no output");
        if (order[i] < 1 || order[i] > MAX_OUTPUT_ORDER) return fail(m, function, "order must be between 1 and maxOutputDerivativeOrder");
        if (computed != order[i]) output_rates(m, computed = order[i], rate);
        value[i] = rate[row];
    }
    return OK;
}
