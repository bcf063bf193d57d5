/* How all outputs become consistent with the inputs that they cause: in initialization mode, and at communication points.
   The same as Network.initialize and Network.outputs, operation by operation, so that both give the same bits. */

#include <float.h>
#include <math.h>
#include <string.h>

#include "system.h"

#define EXCHANGES 50     /* rounds after which inputs and outputs at the start must agree */
#define AGREEMENT 1e-10  /* relative */

/* The outputs of the newest point. */
static double *newest(System *m) { return m->Y + (m->s.known - 1) * N_Y; }

/* Gives component i its connected inputs. */
static int set_inputs(System *m, int i, const double *u) {
    Component *c = &m->components[i];
    const int n = c->data->n_u;
    if (n == 0) return OK;
    return c->f->SetReal(c->instance, m->u_refs + c->data->first_wire, (size_t)n, u);
}

static int get_outputs(System *m, int i, double *Y) {
    Component *c = &m->components[i];
    if (c->data->n_y == 0) return OK;
    return c->f->GetReal(c->instance, Y_REFERENCES + c->data->first_y, (size_t)c->data->n_y, Y + c->data->first_y);
}

/* Whether every output of component i is finite; says so where one is not. */
static int outputs_finite(System *m, const char *function, int i, const double *Y) {
    for (int k = COMPONENTS[i].first_y; k < COMPONENTS[i].first_y + COMPONENTS[i].n_y; k++) {
        if (fabs(Y[k]) <= DBL_MAX) continue;
        discard(m, function, "no finite value for ", Y_NAMES[k]);
        return 0;
    }
    return 1;
}

/* The outputs of component i for the inputs that Y gives it, written into Y. */
static Status evaluate(System *m, const char *function, int i, double *Y, int with_inputs) {
    double *u = m->u + COMPONENTS[i].first_wire;
    if (with_inputs) {
        for (int j = 0; j < COMPONENTS[i].n_u; j++) {
            const Wire *w = &WIRES[COMPONENTS[i].first_wire + j];
            u[j] = Y[w->source] * w->scale + w->offset;
        }
        Status status = judged(m, i, "SetReal", set_inputs(m, i, u));
        if (status != OK) return status;
    }
    Status status = judged(m, i, "GetReal", get_outputs(m, i, Y));
    if (status != OK) return status;
    return outputs_finite(m, function, i, Y) ? OK : DISCARD;
}

/* All outputs, consistent with the inputs they cause; Y, which may be old, is written in place. */
static Status consistent(System *m, const char *function, double *Y) {
    for (int k = 0; k < N_COMPONENTS; k++) {
        Status status = evaluate(m, function, ORDER[k], Y, 1);
        if (status != OK) return status;
    }
    return OK;
}

/* Inputs that nothing is connected to. */
static Status set_external(System *m) {
    for (int k = 0; k < N_EXTERNALS; k++) {
        Status status = give(m, "SetReal", EXTERNALS[k].component, TYPE_REAL, EXTERNALS[k].reference, m->s.external[k], NULL);
        if (status != OK) return status;
    }
    return OK;
}

/* In initialization mode: rounds of exchange until one changes nothing. */
static Status settle(System *m, const char *function) {
    static const double zero[AT_LEAST_ONE(N_Y)];
    double *Y = m->Y, *before = m->C; /* free until the first step */
    int changed = N_EXCHANGE > 0, where = 0;
    memcpy(Y, zero, sizeof zero);
    m->s.known = 1;
    for (int round = 0; round < EXCHANGES && changed; round++) {
        memcpy(before, Y, N_Y * sizeof(double));
        for (int k = 0; k < N_EXCHANGE; k++) {
            Status status = evaluate(m, function, EXCHANGE[k], Y, 1);
            if (status != OK) return status;
        }
        changed = 0;
        for (int k = 0; k < N_Y; k++) {
            const double size = fabs(Y[k]) > 1.0 ? fabs(Y[k]) : 1.0;
            if (fabs(Y[k] - before[k]) > AGREEMENT * size) changed = 1, where = k;
        }
    }
    if (!changed) return OK;
    return discard(m, function, "inputs and outputs must agree in initialization mode, this still changes: ", Y_NAMES[where]);
}

/* Makes the outputs of the present point those of what has been set since they were read. */
static Status refresh(System *m, const char *function) {
    Status status = OK;
    if (!m->s.changed) return OK;
    if (m->s.mode == INITIALIZATION) {
        status = settle(m, function);
        for (int i = 0; status == OK && i < N_COMPONENTS; i++) /* of those that nothing is connected to as well */
            status = evaluate(m, function, i, m->Y, 0);
    } else {
        status = consistent(m, function, newest(m));
    }
    if (status == OK) m->s.changed = 0;
    return status;
}
