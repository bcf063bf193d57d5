/* One macro step: sampled part, internal steps, error control. The same as macro_step in the package's
   component/do_step.py, operation by operation, so that both give the same bits. */

#include "core.h"

#define LEVELS 20       /* with error control the smallest internal step is the piece / 2^LEVELS */
#define MOST_STEPS 1e8  /* internal steps of a macro step */
#define SAME_TIME 1e-9  /* fraction of the sample period within which two instants are one */

typedef enum { DONE, NOT_FINITE, NOT_ACCURATE, RETURNED } Outcome;

/* Value and derivatives of the input polynomial U at offset tau. */
static void polynomial_at(const double *U, double tau, double *u) {
    for (int i = 0; i < N_U; i++) {
        u[i] = U[i] + U[i + N_U] * tau + U[i + 2 * N_U] * (tau * tau) / 2;
        u[i + N_U] = U[i + N_U] + U[i + 2 * N_U] * tau;
        u[i + 2 * N_U] = U[i + 2 * N_U];
    }
}

/* With intermediate update the polynomial of an internal step is the parabola through the importer's inputs at its start,
   middle and end. s.U holds those at the start already, except in the first internal step of a macro step. */
static void ask_parabola(Instance *m, double time, double h) {
    double u_start[AT_LEAST_ONE(N_U)], u_middle[AT_LEAST_ONE(N_U)];
    memcpy(u_start, m->s.U, N_U * sizeof(double));
    m->ask(m, time + h / 2, 0);
    memcpy(u_middle, m->s.U, N_U * sizeof(double));
    m->ask(m, time + h, 0);
    memcpy(m->u_end, m->s.U, N_U * sizeof(double));
    for (int i = 0; i < N_U; i++) {
        m->U_local[i] = u_start[i];
        m->U_local[i + N_U] = (4 * u_middle[i] - 3 * u_start[i] - m->u_end[i]) / h;
        m->U_local[i + 2 * N_U] = 4 * (u_start[i] - 2 * u_middle[i] + m->u_end[i]) / (h * h);
    }
    memcpy(m->s.U, u_start, N_U * sizeof(double)); /* until the internal step is accepted */
}

/* One internal step from x. */
static void take(Instance *m, const double *x, const double *U, double tau, double h, double *x_next) {
    const Room room = {m->argument, m->result, m->integers, m->work};
    internal_step(&room, x, U, parameters(m), tau, h, x_next);
}

/* Makes x the state; with intermediate update the importer sees it. Returns 0 if the importer ends the macro step here. */
static int accept(Instance *m, const double *x, double time, double h) {
    memcpy(m->s.x, x, N_X * sizeof(double));
    if (!m->ask) return 1;
    m->s.time = time;
    polynomial_at(m->U_local, h, m->s.u_now);
    memcpy(m->s.U, m->u_end, N_U * sizeof(double));
    memcpy(m->s.u_now, m->u_end, N_U * sizeof(double));
    forget(m);
    return m->ask(m, time, 1);
}

/* Largest change of a state, relative to nominal value and size, between one internal step and two of half its length. */
static double difference(const Instance *m) {
    double largest = 0.0;
    for (int i = 0; i < N_X; i++) {
        double e = fabs(m->x_two[i] - m->x_one[i]) / (NOMINAL_X[i] + fabs(m->x_two[i]));
        if (!(e <= largest)) largest = e; /* keeps NaN */
    }
    return largest;
}

/* From offset `start` of the macro step that began at t, over `length`, in equal internal steps. */
static Outcome advance_equal(Instance *m, double t, double start, double length) {
    double n = ceil(length / m->s.p[INTERNAL_STEP] - 1e-9);
    if (!(n >= 1.0)) n = 1.0;
    double h = length / n;
    for (double i = 0; i < n; i++) {
        double tau = start + i * h;
        if (m->ask) ask_parabola(m, t + tau, h);
        take(m, m->s.x, m->ask ? m->U_local : m->s.U, m->ask ? 0.0 : tau, h, m->x_one);
        if (!all_finite(m->x_one, N_X)) return NOT_FINITE;
        if (!accept(m, m->x_one, t + (tau + h), h)) return RETURNED;
    }
    return DONE;
}

/* The same with error control: internal steps are length / 2^level, each checked against two of half the length, which
   are kept. The level rises where the difference exceeds the tolerance and falls where it would not at twice the length. */
static Outcome advance_adaptive(Instance *m, double t, double start, double length) {
    double divisor = 1.0, allowed_error = m->s.p[TOLERANCE] * ERROR_DIVISOR;
    int level = 0;
    int64_t done = 0;
    while (length / divisor > m->s.internal_step_used * (1 + 1e-9) && level < LEVELS) level++, divisor *= 2;
    while (done < ((int64_t)1 << level)) {
        double h = length / divisor, tau = start + (double)done * h, half = h / 2;
        if (m->ask) ask_parabola(m, t + tau, h);
        const double *U = m->ask ? m->U_local : m->s.U;
        double at = m->ask ? 0.0 : tau;
        take(m, m->s.x, U, at, h, m->x_one);
        take(m, m->s.x, U, at, half, m->x_half);
        take(m, m->x_half, U, at + half, half, m->x_two);
        double error = difference(m);
        if (error <= allowed_error) {
            int easy = error < allowed_error * EASY;
            m->s.internal_step_used = easy ? 2 * h : h;
            done++;
            if (!accept(m, m->x_two, t + (tau + h), h)) return RETURNED;
            if (easy && level > 0 && done % 2 == 0) level--, divisor /= 2, done /= 2;
        } else {
            if (level == LEVELS) return all_finite(m->x_two, N_X) ? NOT_ACCURATE : NOT_FINITE;
            level++, divisor *= 2, done *= 2;
        }
    }
    return DONE;
}

static Outcome advance(Instance *m, double t, double start, double length) {
    return m->s.p[TOLERANCE] > 0.0 ? advance_adaptive(m, t, start, length) : advance_equal(m, t, start, length);
}

#ifdef SAMPLE_PERIOD
/* The sampled part at offset tau, with the inputs there. */
static Outcome sample_at(Instance *m, double t, double tau) {
    if (m->ask)
        memcpy(m->s.u_now, m->s.U, N_U * sizeof(double));
    else
        polynomial_at(m->s.U, tau, m->s.u_now);
    call(m, MODEL(sample), 3, (const double *[]){m->s.x, m->s.u_now, m->s.p}, 1, (double *[]){m->x_one});
    if (!all_finite(m->x_one, N_X)) return NOT_FINITE;
    memcpy(m->s.x, m->x_one, N_X * sizeof(double));
    m->s.samples++;
    forget(m);
    tell(m, OK, LOG_EVENTS, "sample %lld at %.9g s", (long long)(m->s.samples - 1), t + tau);
    return DONE;
}
#endif

/* From t to t + h. Unless DONE or RETURNED the instance is as before. Only what the step may have changed by then is kept for
   that: to copy a small component's whole state takes as long as its step. */
static Outcome macro_step(Instance *m, double t, double h) {
#ifdef SAMPLE_PERIOD
    const int all = 1;
#else
    const int all = m->ask != NULL;
#endif
    State before;
    if (all) before = m->s;
    else {
        memcpy(before.x, m->s.x, N_X * sizeof(double));
        before.internal_step_used = m->s.internal_step_used;
    }
    Outcome outcome = DONE;
    if (m->ask) m->ask(m, t, 0);
#ifdef SAMPLE_PERIOD
    double done = 0.0;
    while (outcome == DONE && done < h) {
        double instant = (double)m->s.samples * SAMPLE_PERIOD - t, near = SAME_TIME * SAMPLE_PERIOD;
        if (instant <= done + near) {
            outcome = sample_at(m, t, done);
        } else {
            double end = instant < h - near ? instant : h;
            outcome = advance(m, t, done, end - done);
            done = end;
        }
    }
#else
    outcome = advance(m, t, 0.0, h);
#endif
    forget(m);
    if (outcome == NOT_FINITE || outcome == NOT_ACCURATE) {
        if (all) m->s = before;
        else {
            memcpy(m->s.x, before.x, N_X * sizeof(double));
            m->s.internal_step_used = before.internal_step_used;
        }
        return outcome;
    }
    m->returned_early = outcome == RETURNED;
    if (outcome == DONE) {
        m->s.time = t + h;
        if (!m->ask) polynomial_at(m->s.U, h, m->s.u_now);
    }
    memset(m->s.U + N_U, 0, 2 * N_U * sizeof(double)); /* input derivatives hold for one step */
    return outcome;
}

/* What a macro step is divided into at the least, s: one that needs more than MOST_STEPS of them would not come back. */
static double shortest(const Instance *m) {
#ifdef SAMPLE_PERIOD
    return SAMPLE_PERIOD < m->s.p[INTERNAL_STEP] ? SAMPLE_PERIOD : m->s.p[INTERNAL_STEP];
#else
    return m->s.p[INTERNAL_STEP];
#endif
}

/* What doStep of both FMI versions does: checks, the step, and the message if it fails. */
static Status do_step(Instance *m, const char *function, double t, double h) {
    if (!(h > 0.0) || !isfinite(h)) return fail(m, function, "communicationStepSize must be positive and finite");
    if (h > MOST_STEPS * shortest(m)) return fail(m, function, "communicationStepSize must take at most 1e8 internal steps");
    if (!(fabs(t - m->s.time) <= 1e-3 * h + 1e-9 * fabs(t)))
        return fail(m, function, "currentCommunicationPoint must be the time reached");
    if (t + h > m->s.stop + 1e-9 * (fabs(m->s.stop) + h)) return fail(m, function, "the step ends behind the stop time");
    switch (macro_step(m, t, h)) {
        case NOT_FINITE: return discard(m, function, "the step gives no finite state", "");
        case NOT_ACCURATE: return discard(m, function, "the tolerance cannot be met", "");
        default: m->last_successful = m->s.time; return m->s.mode == FAILED ? ERROR : OK;
    }
}

/* ---- events of Model Exchange -------------------------------------------------------------------------------------- */

/* Runs the sampled part if its instant has come. Returns whether x changed. */
static int update_discrete_states(Instance *m) {
#ifdef SAMPLE_PERIOD
    if ((double)m->s.samples * SAMPLE_PERIOD <= m->s.time + SAME_TIME * SAMPLE_PERIOD) {
        memcpy(m->x_half, m->s.x, N_X * sizeof(double));
        m->s.samples++;
        call(m, MODEL(sample), 3, (const double *[]){m->s.x, m->s.u_now, m->s.p}, 1, (double *[]){m->x_one});
        memcpy(m->s.x, m->x_one, N_X * sizeof(double));
        forget(m);
        tell(m, OK, LOG_EVENTS, "sample %lld at %.9g s", (long long)(m->s.samples - 1), m->s.time);
        return memcmp(m->x_half, m->s.x, N_X * sizeof(double)) != 0;
    }
#endif
    (void)m;
    return 0;
}

/* The next time event, or 0 if there is none. */
static int next_event(const Instance *m, double *time) {
#ifdef SAMPLE_PERIOD
    *time = (double)m->s.samples * SAMPLE_PERIOD;
    return 1;
#else
    *time = 0.0 * m->s.time;
    return 0;
#endif
}
