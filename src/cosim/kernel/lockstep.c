/* The inner loop of several runs in step with one another: each with its own plan, data and meter, as kernel.c marches them, but
   that a component's steps, and its outputs, are computed for all runs at once. This is the file that is compiled.

   All runs have the same components, stepped in the same order; parameters, steps, algorithm and what is recorded may differ. */

#include "kernel.c"

enum { MOST_LANES = 8 };

/* For several instances, NULL where there is none: doStep, which returns as bits whose failed; and outputs, ready to be got. */
typedef int64_t BatchStep(void *const *instances, const double *t, const double *h);
typedef void BatchOutput(void *const *instances);

typedef struct {
    int64_t step, output; /* addresses */
} Batch;

/* A run in its lane. computed: for each slave whether what is asked of it in whole rows, and in others, is more than states. */
typedef struct {
    const Plan *p;
    const Data *d;
    Meter *meter;
    const uint8_t *computed;
    int64_t row;  /* where it stands */
    int64_t bad;  /* set: its step failed; its row is void, and its slaves are where they were or beyond */
    int64_t over; /* set: a stop condition holds at its newest point */
} Run;

static void *instance(const Run *run, int64_t i) { return (void *)(intptr_t)run->p->slaves[i].instance; }

/* Reads the outputs of slave i of those runs that take part into their rows r. */
static void receive_all(Run *const *runs, int64_t lanes, const Batch *batch, int64_t i, int64_t k, const uint8_t *takes_part) {
    void *instances[MOST_LANES] = {0};
    int computed = 0;
    for (int64_t l = 0; l < lanes; l++) {
        if (!takes_part[l]) continue;
        instances[l] = instance(runs[l], i);
        computed |= runs[l]->computed[2 * i + !runs[l]->d->whole[runs[l]->row + k + 1]];
    }
    if (computed) ((BatchOutput *)(intptr_t)batch[i].output)(instances);
    for (int64_t l = 0; l < lanes; l++) {
        if (!takes_part[l]) continue;
        const int64_t r = runs[l]->row + k + 1;
        if (!receive(runs[l]->p, runs[l]->d, i, r, runs[l]->d->whole[r])) runs[l]->bad = 1;
    }
}

/* The steps of slave i, from the points that the runs stand at. */
static void step_all(Run *const *runs, int64_t lanes, const Batch *batch, int64_t i, int64_t k, int64_t timed) {
    void *instances[MOST_LANES] = {0};
    double t[MOST_LANES] = {0}, h[MOST_LANES] = {0};
    int64_t n = 0;
    for (int64_t l = 0; l < lanes; l++) {
        Run *run = runs[l];
        if (!run || run->bad) continue;
        const Data *d = run->d;
        const int64_t r = run->row + k, degree = run->p->degree;
        t[l] = d->t[r], h[l] = d->h[r + 1];
        extrapolate(run->p, d, i, r, h[l], degree > 0 ? d->t[r - 1] - t[l] : 0.0, degree > 1 ? d->t[r - 2] - t[l] : 0.0);
        if (send(run->p, d, i))
            instances[l] = instance(run, i), n++;
        else
            run->bad = 1;
    }
    if (n == 0) return;
    const double began = timed ? seconds() : 0.0;
    const int64_t failures = ((BatchStep *)(intptr_t)batch[i].step)(instances, t, h);
    const double spent = timed ? (double)timed * (seconds() - began) / (double)n : 0.0;
    for (int64_t l = 0; l < lanes; l++) {
        if (!instances[l]) continue;
        runs[l]->d->spent[i] += spent;
        if (failures >> l & 1) runs[l]->bad = 1;
    }
}

/* receive_stepped of all runs. */
static void receive_stepped_all(Run *const *runs, int64_t lanes, const Batch *batch, int64_t i, int64_t k) {
    uint8_t takes_part[MOST_LANES] = {0}, feeds[MOST_LANES] = {0};
    for (int64_t l = 0; l < lanes; l++) {
        Run *run = runs[l];
        if (!run || run->bad) continue;
        const Data *d = run->d;
        const Slave *s = &run->p->slaves[i];
        const int64_t r = run->row + k + 1, u0 = s->first, n_u = s->n_u;
        feeds[l] = (d->whole[r] ? s->feeds : s->feeds_polled) != 0;
        takes_part[l] = 1;
        if (!feeds[l]) continue;
        for (int64_t j = 0; j < n_u; j++) {
            const int64_t q = u0 + j;
            const double h = d->h[r];
            d->kept[q] = d->u[q];
            d->u[q] = d->u[q] + h * (d->du[2 * u0 + j] + h * d->du[2 * u0 + n_u + j] / 2);
        }
        if (!give_inputs(run->p, d, i)) run->bad = 1, takes_part[l] = 0;
        for (int64_t q = u0; q < u0 + n_u; q++) d->u[q] = d->kept[q];
    }
    receive_all(runs, lanes, batch, i, k, takes_part);
}

/* exchange of all runs. */
static void exchange_all(Run *const *runs, int64_t lanes, const Batch *batch, int64_t i, int64_t k) {
    uint8_t takes_part[MOST_LANES] = {0};
    for (int64_t l = 0; l < lanes; l++) {
        Run *run = runs[l];
        if (!run || run->bad) continue;
        const Plan *p = run->p;
        const Data *d = run->d;
        const Slave *s = &p->slaves[i];
        const int64_t r = run->row + k + 1;
        const double *row = d->Y + r * d->n_Y;
        const int feeds = (d->whole[r] ? s->feeds : s->feeds_polled) != 0;
        takes_part[l] = feeds || !p->sequential;
        if (!feeds) continue;
        for (int64_t q = s->first; q < s->first + s->n_u; q++) d->u[q] = row[p->source[q]] * p->scale[q] + p->offset[q];
        if (!give_inputs(p, d, i)) run->bad = 1, takes_part[l] = 0;
    }
    receive_all(runs, lanes, batch, i, k, takes_part);
}

/* What march does at the end of a step: the inputs of the bonds were noted in `used` before the exchange. */
static void conclude(Run *run, int64_t k) {
    const Plan *p = run->p;
    const Data *d = run->d;
    const int64_t r = run->row + k + 1;
    const double *next = d->Y + r * d->n_Y;
    for (int64_t q = 0; q < p->n_stops; q++) run->over |= next[p->stops[q]] > p->above[q];
    if (run->over && !d->whole[r] && !exchange(p, d, r, 1, 1)) run->bad = 1;
    if (!run->bad) meter_step(run->meter, next, d->h[r], d->used);
}

/* march of several runs, NULL for none: returns how many rows were done by all, the last of which a run that is bad has not. */
EXPORT int64_t march_lanes(Run *const *runs, int64_t lanes, const Batch *batch, int64_t rows, int64_t timed_every) {
    const Run *any = NULL;
    for (int64_t l = 0; l < lanes && !any; l++) any = runs[l];
    if (!any || lanes > MOST_LANES) return 0;
    for (int64_t k = 0; k < rows; k++) {
        const int64_t timed = timed_every > 0 && k % timed_every == 0 ? timed_every : 0;
        int64_t end = 0;
        for (int64_t turn = 0; turn < any->p->n_slaves; turn++) {
            step_all(runs, lanes, batch, any->p->sequence[turn], k, timed);
            if (any->p->sequential) receive_stepped_all(runs, lanes, batch, any->p->sequence[turn], k);
        }
        for (int64_t l = 0; l < lanes; l++)
            if (runs[l] && !runs[l]->bad) note_used(runs[l]->p, runs[l]->d);
        for (int64_t turn = 0; turn < any->p->n_slaves; turn++) exchange_all(runs, lanes, batch, any->p->exchange[turn], k);
        for (int64_t l = 0; l < lanes; l++) {
            if (!runs[l]) continue;
            if (!runs[l]->bad) conclude(runs[l], k);
            end |= runs[l]->bad | runs[l]->over;
        }
        if (end) return k + 1;
    }
    return rows;
}
