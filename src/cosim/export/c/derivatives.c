/* Directional derivatives of the coupled system, where every component has them.

   At a communication point the outputs y and the derivatives x' of all states x follow from the inputs u of the whole and x:

       y_i = g_i(x_i, u_i),   x_i' = f_i(x_i, u_i),   u_i = connected outputs, with their factors, and inputs of the whole

   with all signals of that point: what the extrapolation over a macro step makes of them is no part of it. So these are the
   derivatives of the system as if it were coupled continuously. There are no algebraic loops, and one pass in the order of
   evaluation is enough. */

#include <string.h>

#include "system.h"

/* The derivatives of component i's variables `unknown` along the seeds; dY: those of the outputs, as far as they are known. */
static Status derive(System *m, const char *function, int i, const uint32_t *known, size_t n_known, const double *seed,
                     const double *dY, const uint32_t *unknown, size_t n_unknown, double *value) {
    Component *c = &m->components[i];
    size_t n = 0;
    memset(value, 0, n_unknown * sizeof(double));
    for (int q = c->data->first_wire; q < c->data->first_wire + c->data->n_u; q++) {
        m->seeds[n] = WIRES[q].scale * dY[WIRES[q].source], m->seeded[n] = WIRES[q].reference;
        if (m->seeds[n] != 0.0) n++;
    }
    for (size_t k = 0; k < n_known; k++) {
        const Variable *v = &VARIABLES[known[k]];
        if (v->component == i && seed[k] != 0.0) m->seeds[n] = seed[k], m->seeded[n++] = v->reference;
    }
    if (n == 0 || n_unknown == 0) return OK;
    return judged(m, i, function, c->f->GetDirectionalDerivative(c->instance, unknown, n_unknown, m->seeded, n, m->seeds, value));
}

static Status sensitivity(System *m, const char *function, const uint32_t *unknown, size_t n_unknown, const uint32_t *known,
                          size_t n_known, const double *seed, double *value) {
    double *dY = m->C; /* free between steps */
    if (!ALL_DERIVE) return fail(m, function, "a component gives no directional derivatives");
    for (size_t k = 0; k < n_known; k++) {
        const int there = known[k] < N_VARIABLES;
        const Kind kind = there ? VARIABLES[known[k]].kind : TIME;
        if (kind != INPUT && kind != OUTPUT && kind != FORWARDED) return fail(m, function, "a known is no state or input");
    }
    if (n_known > N_VARIABLES || n_unknown > N_VARIABLES) return fail(m, function, "there are not so many variables");
    Status status = refresh(m, function);
    if (status == OK) status = consistent(m, function, newest(m)); /* every component gets the inputs of this point */
    memset(dY, 0, N_Y * sizeof(double));
    for (int k = 0; k < N_COMPONENTS && status == OK; k++) {
        const ComponentData *c = &COMPONENTS[ORDER[k]];
        const uint32_t *outputs = Y_REFERENCES + c->first_y;
        status = derive(m, function, (int)ORDER[k], known, n_known, seed, dY, outputs, (size_t)c->n_y, dY + c->first_y);
    }
    for (int i = 0; i < N_COMPONENTS && status == OK; i++) { /* what is no output, component by component */
        size_t n = 0;
        for (size_t k = 0; k < n_unknown; k++) {
            if (unknown[k] >= N_VARIABLES) return fail(m, function, "unknown value reference");
            const Variable *v = &VARIABLES[unknown[k]];
            if (v->kind != OUTPUT && v->kind != FORWARDED && v->kind != DERIVATIVE)
                return fail(m, function, "an unknown is no output or derivative");
            if (v->kind == OUTPUT) value[k] = dY[v->index];
            else if (v->component == i) m->asked[n++] = v->reference;
        }
        if (n == 0) continue;
        status = derive(m, function, i, known, n_known, seed, dY, m->asked, n, m->rates);
        n = 0;
        for (size_t k = 0; k < n_unknown; k++)
            if (VARIABLES[unknown[k]].kind != OUTPUT && VARIABLES[unknown[k]].component == i) value[k] = m->rates[n++];
    }
    return status;
}
