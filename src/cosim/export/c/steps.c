/* A step of the whole: the macro steps up to the next communication point. */

#include <math.h>
#include <string.h>

#include "system.h"

#define WHOLE 1e-6 /* of a macro step: what lies closer to a whole number of them is one */

/* The tables of the inner loop that hold addresses within this instance. */
static void prepare_loop(System *m) {
    for (int i = 0; i < N_COMPONENTS; i++) {
        Component *c = &m->components[i];
        const int first = c->data->first_wire, n = c->data->n_u;
        m->jacobi_sequence[i] = i;
        for (int j = 0; j < n; j++) {
            const Wire *w = &WIRES[first + j];
            m->source[first + j] = w->source, m->scale[first + j] = w->scale, m->offset[first + j] = w->offset + 0.0;
            m->u_refs[first + j] = w->reference;
            m->du_refs[2 * first + j] = m->du_refs[2 * first + n + j] = w->reference;
            m->du_orders[2 * first + j] = 1, m->du_orders[2 * first + n + j] = 2;
        }
        m->slaves[i] = (Slave){
            .instance = (int64_t)(intptr_t)c->instance,
            .set_real = (int64_t)(intptr_t)c->f->SetReal,
            .get_real = (int64_t)(intptr_t)c->f->GetReal,
            .do_step = (int64_t)(intptr_t)c->f->DoStep,
            .set_derivatives = (int64_t)(intptr_t)c->f->SetRealInputDerivatives,
            .u_refs = (int64_t)(intptr_t)(m->u_refs + first),
            .y_refs = (int64_t)(intptr_t)(Y_REFERENCES + c->data->first_y),
            .du_refs = (int64_t)(intptr_t)(m->du_refs + 2 * first),
            .du_orders = (int64_t)(intptr_t)(m->du_orders + 2 * first),
            .n_u = n,
            .n_y = c->data->n_y,
            .n_polled = c->data->n_y,
            .y_first = c->data->first_y,
            .direct = 1,
            .first = first,
            .degree = c->data->degree,
            .feeds = c->data->feeds_through,
            .feeds_polled = c->data->feeds_through,
            .version = 2,
        };
    }
    for (int k = 0; k < N_Y; k++) m->places[k] = k;
    memset(m->whole, 1, sizeof m->whole); /* an importer may ask for any output at any time */
    memset(m->fresh, 0, sizeof m->fresh);
    if (m->s.algorithm != GAUSS_SEIDEL) return;
    int64_t turn[AT_LEAST_ONE(N_COMPONENTS)];
    for (int k = 0; k < N_COMPONENTS; k++) turn[SEQUENCE[k]] = k;
    for (int i = 0; i < N_COMPONENTS; i++)
        for (int q = COMPONENTS[i].first_wire; q < COMPONENTS[i].first_wire + COMPONENTS[i].n_u; q++)
            for (int of = 0; of < N_COMPONENTS; of++)
                if (WIRES[q].source >= COMPONENTS[of].first_y && WIRES[q].source < COMPONENTS[of].first_y + COMPONENTS[of].n_y)
                    m->fresh[q] = turn[of] < turn[i];
}

static int looks_back(const System *m) { return (int)m->s.degree + (m->s.algorithm == NEPCE); }

/* Up to `n` macro steps by the inner loop from the newest point, with times and lengths in place; returns how many. */
static int64_t loop(System *m, int64_t n) {
    static const double missed[DEGREES] = {1.0 / 2, 5.0 / 12, 3.0 / 8};
    const Plan plan = {
        .slaves = m->slaves, .places = m->places, .source = m->source, .scale = m->scale, .offset = m->offset, .fresh = m->fresh,
        .sequence = m->s.algorithm == GAUSS_SEIDEL ? SEQUENCE : m->jacobi_sequence, .exchange = ORDER, .stops = STOPS,
        .above = ABOVE, .n_slaves = N_COMPONENTS, .n_stops = N_STOPS, .degree = m->s.degree,
        .sequential = m->s.algorithm == GAUSS_SEIDEL, .missed = m->s.algorithm == NEPCE ? missed[m->s.degree] : 0.0,
    };
    const Data data = {
        .Y = m->Y, .t = m->t, .h = m->h, .whole = m->whole, .u = m->u, .du = m->du, .kept = m->kept, .orders = m->s.orders,
        .spent = m->seconds_spent, .failure = m->failure, .n_Y = N_Y,
    };
    memset(m->failure, 0, sizeof m->failure);
    for (int i = 0; i < N_COMPONENTS; i++) m->slaves[i].no_set_state = m->no_set_state;
    return march(&plan, &data, NULL, m->s.known - 1, n, 0);
}

/* Why a march has stopped at the step to row `row`. */
static Status stopped(System *m, int64_t row) {
    static const char *const calls[] = {"", "SetReal", "SetRealInputDerivatives", "DoStep", "GetReal"};
    for (int i = 0; m->failure[1] == 0 && i < N_COMPONENTS; i++)
        if (!outputs_finite(m, "DoStep", i, m->Y + row * N_Y)) return DISCARD;
    const int i = (int)m->failure[0];
    Status status = judged(m, i, calls[m->failure[1]], (int)m->failure[2]);
    if (m->failure[1] == DO_STEP && status == DISCARD) {
        fmi2Boolean wants = fmi2False;
        Component *c = &m->components[i];
        if (!c->f->GetBooleanStatus) return status;
        if (c->f->GetBooleanStatus(c->instance, fmi2Terminated, &wants) == fmi2OK && wants) m->s.ended = 1;
    }
    return status;
}

/* Keeps the newest points in the first rows, after `n` more have been reached. */
static void keep_newest(System *m, int64_t n) {
    const int64_t known = m->s.known + n, kept = known < BEFORE ? known : BEFORE, from = known - kept;
    if (from > 0) {
        memmove(m->Y, m->Y + from * N_Y, (size_t)kept * N_Y * sizeof(double));
        memmove(m->t, m->t + from, (size_t)kept * sizeof(double));
    }
    m->s.known = kept;
    m->s.last_successful = m->t[kept - 1];
}

/* `n` macro steps of h, at most CHUNK; *reached: how many were done. */
static Status steps(System *m, int64_t n, double h, int64_t *reached) {
    const int64_t row = m->s.known - 1;
    Status status = OK;
    *reached = 0;
    m->h[row + 1] = h;
    if (row < looks_back(m)) {
        if ((status = cold_step(m, h)) != OK) return status;
        *reached = 1;
    } else {
        for (int64_t k = 1; k <= n; k++) m->h[row + k] = h;
        *reached = loop(m, n);
    }
    for (int64_t k = 1; k <= *reached; k++)
        for (int i = 0; i < N_COMPONENTS; i++)
            if (!outputs_finite(m, "DoStep", i, m->Y + (row + k) * N_Y)) return *reached = k - 1, DISCARD;
    for (int k = 0; k < N_STOPS && *reached > 0; k++)
        if (m->Y[(row + *reached) * N_Y + STOPS[k]] > ABOVE[k]) {
            m->s.ended = 1;
            tell(m, OK, LOG_EVENTS, "%s at t = %.6g s", STOP_SAYS[k], m->t[row + *reached]);
        }
    if (m->s.ended || row < looks_back(m) || *reached == n) return OK;
    return stopped(m, row + *reached + 1);
}

/* From t to t + length: macro steps of full length from the time of the last shorter one on, then a shorter one for what is
   left. Where the system wants to end before that, `ended` is set and the status is DISCARD. */
static Status do_step(System *m, const char *function, double t, double length) {
    const double now = m->s.last_successful, step = m->s.step;
    if (!(length > 0.0) || !isfinite(length)) return fail(m, function, "communicationStepSize must be positive and finite");
    if (!(fabs(t - now) <= 1e-3 * (length < step ? length : step) + 1e-9 * fabs(t)))
        return fail(m, function, "currentCommunicationPoint must be the time reached");
    if (m->s.stop_defined && t + length > m->s.stop + 1e-9 * (fabs(m->s.stop) + length))
        return fail(m, function, "the step ends behind the stop time");
    if (m->s.ended) return DISCARD;
    double whole = floor(length / step + 0.5), rest = 0.0;
    if (!(fabs(length - whole * step) <= WHOLE * step && whole >= 1.0)) {
        whole = floor(length / step), rest = length - whole * step;
        if (!EVERY_LENGTH) return discard(m, function, "communicationStepSize must be a whole number of macro steps", "");
    }
    Status status = refresh(m, function);
    while (status == OK && (whole > 0.0 || rest > 0.0) && !m->s.ended) {
        const int64_t row = m->s.known - 1;
        const int64_t n = row < looks_back(m) || whole < 1.0 ? 1 : whole < CHUNK ? (int64_t)whole : CHUNK;
        int64_t reached;
        for (int64_t k = 1; k <= n; k++) m->t[row + k] = m->s.origin + (double)(m->s.done + k) * step;
        if (whole < 1.0) m->t[row + 1] = m->t[row] + rest;
        status = steps(m, n, whole < 1.0 ? rest : step, &reached);
        if (whole >= 1.0) m->s.done += reached, whole -= (double)reached;
        else if (reached > 0) rest = 0.0, m->s.origin = m->t[row + 1], m->s.done = 0;
        keep_newest(m, reached);
    }
    return status == OK && (whole > 0.0 || rest > 0.0) ? DISCARD : status;
}
