/* The first macro steps, which have too few points behind them for the inner loop. The same as coupling/explicit.py with
   coupling/history.py and Network.step of the package, operation by operation, so that both give the same bits. */

#include <string.h>

#include "system.h"

/* History._newton: C, 3 n_Y, value and derivatives at s = 0 of the polynomials through the values Y at the times s. */
static void newton(int points, const double *s, const double *const *Y, double *C) {
    double *slope = C + N_Y, *curvature = C + 2 * N_Y;
    memset(C, 0, 3 * N_Y * sizeof(double));
    memcpy(C, Y[0], N_Y * sizeof(double));
    for (int k = 0; points > 1 && k < N_Y; k++) {
        const double a = (Y[1][k] - Y[0][k]) / (s[1] - s[0]);
        if (points == 2) {
            C[k] = Y[0][k] - a * s[0];
            slope[k] = a;
        } else {
            const double b = ((Y[2][k] - Y[1][k]) / (s[2] - s[1]) - a) / (s[2] - s[0]);
            C[k] = Y[0][k] - a * s[0] + b * (s[0] * s[1]);
            slope[k] = a - b * (s[0] + s[1]);
            curvature[k] = 2.0 * b;
        }
    }
}

/* The polynomials through the newest degree + 1 points; with `next`, through it, h ahead, and the newest `degree` points. */
static void polynomial(const System *m, int degree, double h, const double *next, double *C) {
    const double *Y[DEGREES];
    double s[DEGREES];
    const int64_t row = m->s.known - 1, ahead = next != NULL;
    if (next) s[0] = h, Y[0] = next;
    for (int k = 0; k + ahead <= degree; k++) {
        s[k + ahead] = m->t[row - k] - m->t[row];
        Y[k + ahead] = m->Y + (row - k) * N_Y;
    }
    newton(degree + 1, s, Y, C);
}

/* The input polynomial of component i from C, in m->u and m->du; what it cannot follow is projected on what it can. */
static void inputs_from(System *m, int i, const double *C, double h) {
    const ComponentData *c = &COMPONENTS[i];
    const int first = c->first_wire, n = c->n_u;
    double *u = m->u + first, *slope = m->du + 2 * first, *curvature = slope + n;
    int scaled = 0, shifted = 0, beyond = 0;
    for (int j = 0; j < n; j++) scaled |= WIRES[first + j].scale != 1.0, shifted |= WIRES[first + j].offset != 0.0;
    for (int j = 0; j < n; j++) {
        const Wire *w = &WIRES[first + j];
        u[j] = C[w->source], slope[j] = C[w->source + N_Y], curvature[j] = C[w->source + 2 * N_Y];
        if (scaled) u[j] *= w->scale, slope[j] *= w->scale, curvature[j] *= w->scale;
        u[j] += 0.0, slope[j] += 0.0, curvature[j] += 0.0; /* no -0.0 */
        if (shifted) u[j] += w->offset;
        beyond |= (c->degree < 1 && slope[j] != 0.0) || (c->degree < 2 && curvature[j] != 0.0);
    }
    for (int j = 0; beyond && j < n; j++) {
        u[j] = u[j] - curvature[j] * (h * h / 12), slope[j] = slope[j] + curvature[j] * (h / 2), curvature[j] = 0.0;
        if (c->degree == 0) u[j] = u[j] + slope[j] * (h / 2), slope[j] = 0.0;
    }
}

/* Steps component i from t over h under the polynomials C of all outputs. */
static Status step_component(System *m, int i, const double *C, double t, double h) {
    Component *c = &m->components[i];
    const int first = c->data->first_wire, n = c->data->n_u;
    inputs_from(m, i, C, h);
    Status status = judged(m, i, "SetReal", set_inputs(m, i, m->u + first));
    if (status != OK) return status;
    const double *slope = m->du + 2 * first, *curvature = slope + n;
    for (int j = 0; c->data->degree > 0 && j < n; j++) { /* it hears of a derivative from when it first differs from zero */
        if (curvature[j] != 0.0) m->s.orders[i] = 2;
        else if (slope[j] != 0.0 && m->s.orders[i] < 1) m->s.orders[i] = 1;
    }
    if (m->s.orders[i] > 0) {
        status = judged(m, i, "SetRealInputDerivatives",
                        c->f->SetRealInputDerivatives(c->instance, m->du_refs + 2 * first, (size_t)(m->s.orders[i] * n),
                                                      m->du_orders + 2 * first, slope));
        if (status != OK) return status;
    }
    return judged(m, i, "DoStep", c->f->DoStep(c->instance, t, h, m->no_set_state));
}

static Status step_all(System *m, const double *C, double t, double h) {
    Status status = OK;
    for (int i = 0; i < N_COMPONENTS && status == OK; i++) status = step_component(m, i, C, t, h);
    return status;
}

/* One macro step with extrapolations of `degree` to the row after the newest. */
static Status sweep(System *m, double h, int degree) {
    const double t = m->t[m->s.known - 1], *Y0 = newest(m);
    double *C = m->C, *Y = m->Y + m->s.known * N_Y;
    polynomial(m, degree, h, NULL, C);
    if (m->s.algorithm != GAUSS_SEIDEL) {
        if (m->s.algorithm == NEPCE)
            for (int k = 0; k < N_Y; k++) C[k] += 0.0; /* nothing is known of what was missed yet */
        memcpy(Y, Y0, N_Y * sizeof(double));
        return step_all(m, C, t, h);
    }
    double *through = m->C + 3 * N_Y;
    const int known = (int)m->s.known, points = m->s.degree < known ? (int)m->s.degree : known;
    for (int k = 0; k < N_Y; k++) Y[k] = C[k] + h * (C[k + N_Y] + h * C[k + 2 * N_Y] / 2); /* a guess */
    for (int turn = 0; turn < N_COMPONENTS; turn++) {
        const int i = (int)SEQUENCE[turn], first = COMPONENTS[i].first_wire, n = COMPONENTS[i].n_u;
        Status status = step_component(m, i, C, t, h);
        if (status != OK) return status;
        double *u = m->u + first, *slope = m->du + 2 * first;
        for (int j = 0; j < n; j++) u[j] = u[j] + h * (slope[j] + h * slope[j + n] / 2);
        status = judged(m, i, "SetReal", set_inputs(m, i, u));
        if (status == OK) status = evaluate(m, "DoStep", i, Y, 0);
        if (status != OK) return status;
        polynomial(m, points, h, Y, through);
        for (int k = COMPONENTS[i].first_y; k < COMPONENTS[i].first_y + COMPONENTS[i].n_y; k++)
            for (int order = 0; order < DEGREES; order++) C[k + order * N_Y] = through[k + order * N_Y];
    }
    return OK;
}

/* One macro step of h. Where the components can go back it is done twice: extrapolate, go back, interpolate the outcome. */
static Status cold_step(System *m, double h) {
    const int known = (int)m->s.known, degree = m->s.degree < known - 1 ? (int)m->s.degree : known - 1;
    const double t = m->t[known - 1];
    double *Y = m->Y + known * N_Y;
    if (degree == m->s.degree || !ALL_RESTORE) {
        Status status = sweep(m, h, degree);
        return status == OK ? consistent(m, "DoStep", Y) : status;
    }
    void *saved[AT_LEAST_ONE(N_COMPONENTS)] = {0};
    Status status = save_components(m, saved);
    if (status == OK) status = sweep(m, h, degree);
    if (status == OK) status = consistent(m, "DoStep", Y);
    if (status == OK) status = restore_components(m, saved);
    discard_components(m, saved);
    if (status != OK) return status;
    polynomial(m, degree + 1, h, Y, m->C);
    status = step_all(m, m->C, t, h);
    return status == OK ? consistent(m, "DoStep", Y) : status;
}
