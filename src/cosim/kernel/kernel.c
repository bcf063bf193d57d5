/* The inner loop for FMUs under Jacobi, NEPCE and Gauss-Seidel, and the energy meter's arithmetic.
   loop.py and energy.py beside this file are the definition: they say what each array means and each function does, and this
   file repeats them operation by operation, so that all give the same bits (compile without contraction of operations). A test
   holds them to it. Here the march meters each step's energy itself, while the FMUs' next calls wait for memory. */

#define _POSIX_C_SOURCE 200112L /* clock_gettime, and on macOS all of C99 where this is a part of another file */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN /* without sockets, one of whose functions is called send */
#include <windows.h>
#else
#include <time.h>
#endif
#ifndef EXPORT /* it is static where this file is a part of another one, an FMU of a coupled system */
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
#endif

/* Functions of FMI 2.0 and 3.0, by the types that they have in binary. */
typedef int Values2(void *instance, const uint32_t *references, size_t n, double *values);
typedef int Values3(void *instance, const uint32_t *references, size_t n, double *values, size_t n_values);
typedef int Derivatives2(void *instance, const uint32_t *references, size_t n, const int32_t *orders, const double *values);
typedef int Step2(void *instance, double t, double h, int no_set_state);
typedef int Step3(void *instance, double t, double h, _Bool no_set_state, _Bool *event, _Bool *ended, _Bool *early, double *reached);
typedef int Finish(double t, double h, int begun);

/* A row of the table of slaves: ctypes_calls.COLUMNS, each an int64. */
typedef struct {
    int64_t instance, set_real, get_real, do_step, set_derivatives, u_refs, y_refs, du_refs, du_orders, no_set_state, n_u, n_y,
        n_polled, y_first, direct, first, degree, feeds, feeds_polled, version, told, finish;
} Slave;

/* loop.Plan and loop.Data. */
typedef struct {
    const Slave *slaves;
    const int64_t *places, *source;
    const double *scale, *offset;
    const int64_t *fresh, *sequence, *exchange, *stops;
    const double *above;
    const int64_t *bond_inputs;
    int64_t n_slaves, n_stops, n_bond_inputs, degree, sequential;
    double missed;
} Plan;

typedef struct {
    double *Y, *t, *h;
    const uint8_t *whole;
    double *used, *u, *du, *kept, *read;
    int64_t *orders;
    uint8_t *told;
    double *reached, *due, *spent;
    int64_t *failure;
    int64_t n_Y;
} Data;

/* energy.Bonds, energy.Sums and what energy.accumulate knows of the points before. */
typedef struct {
    const int64_t *signals;
    const double *inverse, *offset, *factor;
    double *residual, *exchanged, *peak, *past; /* past: 3 points, newest first */
    double *before;                             /* length of the step before, s */
    int64_t n_bonds, known;                     /* points in past */
} Meter;

enum { SET = 1, SET_DERIVATIVES, DO_STEP, GET };

static double seconds(void) {
#ifdef _WIN32
    LARGE_INTEGER count, frequency;
    QueryPerformanceCounter(&count), QueryPerformanceFrequency(&frequency);
    return (double)count.QuadPart / (double)frequency.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}

static int move(const Slave *s, int64_t address, int64_t references, int64_t n, double *values) {
    const uint32_t *refs = (const uint32_t *)(intptr_t)references;
    if (s->version == 3) return ((Values3 *)(intptr_t)address)((void *)(intptr_t)s->instance, refs, (size_t)n, values, (size_t)n);
    return ((Values2 *)(intptr_t)address)((void *)(intptr_t)s->instance, refs, (size_t)n, values);
}

static void extrapolate(const Plan *p, const Data *d, int64_t i, int64_t r, double step, double s1, double s2) {
    const Slave *s = &p->slaves[i];
    const int64_t u0 = s->first, n_u = s->n_u, n_Y = d->n_Y;
    const double *now = d->Y + r * n_Y, *next = now + n_Y, *before = now - n_Y, *older = before - n_Y;
    for (int64_t j = 0; j < n_u; j++) {
        const int64_t q = u0 + j, at = p->source[q];
        const double y0 = now[at], scale = p->scale[q], offset = p->offset[q];
        double value = y0, slope, curvature = 0.0;
        if (p->degree == 0) {
            if (p->fresh[q]) value = next[at];
            if (p->missed > 0.0) value = value + p->missed * (value - before[at]);
            d->u[q] = value * scale + offset;
            continue;
        }
        if (p->fresh[q] > 0) {
            const double yn = next[at], a = (y0 - yn) / (0.0 - step);
            value = yn - a * step, slope = a;
            if (p->degree > 1) {
                const double b = ((before[at] - y0) / (s1 - 0.0) - a) / (s1 - step);
                value = yn - a * step + b * (step * 0.0);
                slope = a - b * (step + 0.0);
                curvature = 2.0 * b;
            }
        } else {
            const double a = (before[at] - y0) / s1;
            slope = a;
            if (p->degree > 1) {
                const double b = ((older[at] - before[at]) / (s2 - s1) - a) / s2;
                slope = a - b * s1;
                curvature = 2.0 * b;
            }
        }
        if (p->missed > 0.0) {
            const double first = y0 - before[at], second = before[at] - older[at];
            double difference = first - second;
            if (p->degree > 1) difference = difference - (second - (older[at] - older[at - n_Y]));
            value = value + p->missed * difference;
        }
        value = value * scale + offset, slope = slope * scale + 0.0, curvature = curvature * scale + 0.0;
        if (s->degree < 2) {
            value -= curvature * (step * step / 12);
            slope += curvature * (step / 2);
            curvature = 0.0;
            if (s->degree == 0) {
                value += slope * (step / 2);
                slope = 0.0;
            }
        }
        d->u[q] = value, d->du[2 * u0 + j] = slope, d->du[2 * u0 + n_u + j] = curvature;
        if (s->degree > 0 && d->orders[i] < 2) {
            if (curvature != 0.0) d->orders[i] = 2;
            else if (slope != 0.0 && d->orders[i] < 1) d->orders[i] = 1;
        }
    }
}

static int failed(const Data *d, int64_t i, int64_t call, int status) {
    if ((unsigned)status <= 1) return 0; /* one that FMI does not know is an error */
    d->failure[0] = i, d->failure[1] = call, d->failure[2] = status;
    return 1;
}

static int give_inputs(const Plan *p, const Data *d, int64_t i) {
    const Slave *s = &p->slaves[i];
    return !failed(d, i, SET, move(s, s->set_real, s->u_refs, s->n_u, d->u + s->first));
}

static int send(const Plan *p, const Data *d, int64_t i) {
    const Slave *s = &p->slaves[i];
    if (s->n_u == 0) return 1;
    if (!give_inputs(p, d, i)) return 0;
    if (d->orders[i] == 0) return 1;
    const int status = ((Derivatives2 *)(intptr_t)s->set_derivatives)(
        (void *)(intptr_t)s->instance, (const uint32_t *)(intptr_t)s->du_refs, (size_t)(d->orders[i] * s->n_u),
        (const int32_t *)(intptr_t)s->du_orders, d->du + 2 * s->first);
    return !failed(d, i, SET_DERIVATIVES, status);
}

static int advance(const Plan *p, const Data *d, int64_t i, double t, double h) {
    const Slave *s = &p->slaves[i];
    int status;
    if (s->version != 3) {
        status = ((Step2 *)(intptr_t)s->do_step)((void *)(intptr_t)s->instance, t, h, (int)s->no_set_state);
    } else if (d->due[i] <= t + 1.000001 * h) { /* not far behind the step: whoever finishes it looks closer */
        status = ((Finish *)(intptr_t)s->finish)(t, h, 0);
    } else {
        uint8_t *told = d->told + 16 * i;
        double *reached = d->reached + 2 * i + 1;
        told[0] = told[1] = told[2] = 0, *reached = t + h;
        status = ((Step3 *)(intptr_t)s->do_step)((void *)(intptr_t)s->instance, t, h, s->no_set_state != 0, (_Bool *)told,
                                                 (_Bool *)(told + 1), (_Bool *)(told + 2), reached);
        const int shortened = fabs(*reached - (t + h)) > 1e-9 * (h + fabs(t));
        if ((unsigned)status <= 1 && (shortened || told[0] + told[1] + told[2] > 0)) status = ((Finish *)(intptr_t)s->finish)(t, h, 1);
    }
    return !failed(d, i, DO_STEP, status);
}

static int receive(const Plan *p, const Data *d, int64_t i, int64_t r, int whole) {
    const Slave *s = &p->slaves[i];
    const int64_t n = whole ? s->n_y : s->n_polled, *places = p->places + s->y_first;
    double *row = d->Y + r * d->n_Y;
    int good = 1;
    if (n == 0) return 1;
    double *read = s->direct ? row + places[0] : d->read;
    if (failed(d, i, GET, move(s, s->get_real, s->y_refs, n, read))) return 0;
    for (int64_t j = 0; j < n; j++) good &= fabs(read[j]) <= DBL_MAX;
    if (!s->direct)
        for (int64_t j = 0; j < n; j++) row[places[j]] = read[j];
    return good;
}

static int receive_stepped(const Plan *p, const Data *d, int64_t i, int64_t r, double h, int whole) {
    const Slave *s = &p->slaves[i];
    const int64_t u0 = s->first, n_u = s->n_u;
    if (!(whole ? s->feeds : s->feeds_polled)) return receive(p, d, i, r, whole);
    for (int64_t j = 0; j < n_u; j++) {
        const int64_t q = u0 + j;
        d->kept[q] = d->u[q];
        d->u[q] = d->u[q] + h * (d->du[2 * u0 + j] + h * d->du[2 * u0 + n_u + j] / 2);
    }
    const int good = give_inputs(p, d, i);
    for (int64_t q = u0; q < u0 + n_u; q++) d->u[q] = d->kept[q];
    return good && receive(p, d, i, r, whole);
}

static int exchange(const Plan *p, const Data *d, int64_t r, int whole, int again) {
    const double *row = d->Y + r * d->n_Y;
    for (int64_t turn = 0; turn < p->n_slaves; turn++) {
        const int64_t i = d->failure[4] = p->exchange[turn];
        const Slave *s = &p->slaves[i];
        const int feeds = (whole ? s->feeds : s->feeds_polled) != 0;
        if (feeds) {
            for (int64_t q = s->first; q < s->first + s->n_u; q++) d->u[q] = row[p->source[q]] * p->scale[q] + p->offset[q];
            if (!give_inputs(p, d, i)) return 0;
        }
        if ((feeds || again) && !receive(p, d, i, r, whole)) return 0;
    }
    return 1;
}

/* energy.accumulate for one step that reached Y under the inputs `used`. */
static void meter_step(Meter *m, const double *Y, double step, const double *used) {
    const int64_t width = 2 * m->n_bonds;
    const int uneven = fabs(step - *m->before) > 1e-9 * step;
    for (int64_t b = 0; b < m->n_bonds; b++) {
        double *p1 = m->past + 2 * b, *p2 = p1 + width, *p3 = p2 + width;
        const double w1 = p1[0], M1 = p1[1], w2 = p2[0], M2 = p2[1], w3 = p3[0], M3 = p3[1];
        const double w = Y[m->signals[2 * b]], M = Y[m->signals[2 * b + 1]], factor = m->factor[b];
        const double c_w = m->inverse[2 * b], c_M = m->inverse[2 * b + 1];
        double w_half, M_half, highest = m->peak[b];
        if (m->known >= 3 && !uneven) {
            w_half = (5 * w + 15 * w1 - 5 * w2 + w3) / 16, M_half = (5 * M + 15 * M1 - 5 * M2 + M3) / 16;
        } else if (m->known == 2 && !uneven) {
            w_half = (3 * w + 6 * w1 - w2) / 8, M_half = (3 * M + 6 * M1 - M2) / 8;
        } else {
            w_half = (w + w1) / 2, M_half = (M + M1) / 2;
        }
        const double *of_w = used + 6 * b, *of_M = of_w + 3;
        const double u_w = of_w[0] - m->offset[2 * b], u_M = of_M[0] - m->offset[2 * b + 1], half = step / 2;
        const double s_w = of_w[1], s_M = of_M[1], q_w = of_w[2] / 2, q_M = of_M[2] / 2;
        const double start = (u_M * c_M * w1 - M1 * (u_w * c_w)) * factor;
        const double middle =
            ((u_M + half * (s_M + half * q_M)) * c_M * w_half - M_half * ((u_w + half * (s_w + half * q_w)) * c_w)) * factor;
        const double end = ((u_M + step * (s_M + step * q_M)) * c_M * w - M * ((u_w + step * (s_w + step * q_w)) * c_w)) * factor;
        m->residual[b] += step / 6 * (start + 4 * middle + end);
        m->exchanged[b] += step / 6 * (fabs(M1 * w1 * factor) + 4 * fabs(M_half * w_half * factor) + fabs(M * w * factor));
        if (fabs(start) > highest) highest = fabs(start); /* fmax() is a call */
        if (fabs(middle) > highest) highest = fabs(middle);
        if (fabs(end) > highest) highest = fabs(end);
        m->peak[b] = highest;
        p3[0] = w2, p3[1] = M2, p2[0] = w1, p2[1] = M1, p1[0] = w, p1[1] = M;
    }
    *m->before = step;
    if (m->known < 3) m->known++;
}

/* The inputs of the power bonds in the step just taken, for the meter, which takes them over at once. */
static void note_used(const Plan *p, const Data *d) {
    for (int64_t q = 0; q < p->n_bond_inputs; q++) {
        double *used = d->used + 3 * q;
        used[0] = d->u[p->bond_inputs[3 * q]];
        if (p->degree > 0) used[1] = d->du[p->bond_inputs[3 * q + 1]], used[2] = d->du[p->bond_inputs[3 * q + 2]];
    }
}
EXPORT int64_t march(const Plan *p, const Data *d, Meter *meter, int64_t row, int64_t rows, int64_t timed_every) {
    for (int64_t k = 0; k < rows; k++) {
        const int64_t r = row + (d->failure[3] = k);
        const double h = d->h[r + 1], t = d->t[r];
        const double s1 = p->degree > 0 ? d->t[r - 1] - t : 0.0, s2 = p->degree > 1 ? d->t[r - 2] - t : 0.0;
        const int whole = d->whole[r + 1], timed = timed_every > 0 && k % timed_every == 0;
        for (int64_t turn = 0; turn < p->n_slaves; turn++) {
            const int64_t i = d->failure[4] = p->sequence[turn];
            extrapolate(p, d, i, r, h, s1, s2);
            if (!send(p, d, i)) return k;
            const double began = timed ? seconds() : 0.0;
            const int good = advance(p, d, i, t, h);
            if (timed) d->spent[i] += (double)timed_every * (seconds() - began);
            if (!good || (p->sequential && !receive_stepped(p, d, i, r + 1, h, whole))) return k;
        }
        note_used(p, d);
        if (!exchange(p, d, r + 1, whole, !p->sequential)) return k;
        const double *next = d->Y + (r + 1) * d->n_Y;
        int over = 0;
        for (int64_t q = 0; q < p->n_stops; q++) over |= next[p->stops[q]] > p->above[q];
        if (over && !whole && !exchange(p, d, r + 1, 1, 1)) return k;
        if (meter) meter_step(meter, next, h, d->used);
        if (over) return k + 1;
    }
    return rows;
}
