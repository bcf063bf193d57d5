/* The component inside an FMU: start values, access by value reference, derivatives. */

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"

#define MOST_SAMPLES 1e15 /* from time 0, so that their number stays exact */

/* ---- messages to the importer --------------------------------------------------------------------------------------- */

static void tell(Instance *m, Status status, unsigned category, const char *format, ...) {
    char text[512];
    va_list arguments;
    int bit = 0;
    if (!m->log || !(m->log_categories & category)) return;
    while (!(category >> bit & 1u)) bit++;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    m->log(m, status, CATEGORIES[bit], text);
}

/* After an error only a reset, restoring a saved state or freeing the instance is allowed. */
static Status fail(Instance *m, const char *function, const char *why) {
    tell(m, ERROR, LOG_ERROR, "%s: %s", function, why);
    m->s.mode = FAILED;
    return ERROR;
}

static Status discard(Instance *m, const char *function, const char *why, const char *what) {
    tell(m, DISCARD, LOG_DISCARD, "%s: %s%s", function, why, what);
    return DISCARD;
}

static int allowed(Instance *m, const char *function, int modes) {
    if (m->s.mode & modes) return 1;
    fail(m, function, "must not be called in this state");
    return 0;
}

/* Chooses the categories that are logged from now on, besides those already chosen: all, or the named ones. */
static Status choose_categories(Instance *m, int on, size_t n, const char *const category[]) {
    if (on && n == 0) m->log_categories = LOG_ALL;
    for (size_t i = 0; i < n; i++) {
        unsigned bit = 0;
        for (unsigned k = 0; k < sizeof CATEGORIES / sizeof *CATEGORIES; k++)
            if (category[i] && strcmp(category[i], CATEGORIES[k]) == 0) bit = 1u << k;
        if (!bit) return fail(m, "SetDebugLogging", "unknown category");
        if (on) m->log_categories |= bit;
    }
    return OK;
}

/* ---- start values -------------------------------------------------------------------------------------------------- */

static void to_start(Instance *m) {
    memset(&m->s, 0, sizeof m->s); /* the padding too, so that equal states have equal bytes */
    m->s.fingerprint = FINGERPRINT;
    m->s.mode = INSTANTIATED;
    m->s.stop = HUGE_VAL;
    memcpy(m->s.x, START_X, N_X * sizeof(double));
    memcpy(m->s.U, START_U, N_U * sizeof(double));
    memcpy(m->s.u_now, START_U, N_U * sizeof(double));
    memcpy(m->s.p, START_P, N_P * sizeof(double));
    m->y_known = m->x_dot_known = m->P_known = 0;
}

static Status set_experiment(Instance *m, const char *function, double start, int stop_defined, double stop) {
    if (!isfinite(start)) return fail(m, function, "startTime must be finite");
#ifdef SAMPLE_PERIOD
    if (fabs(start / SAMPLE_PERIOD) > MOST_SAMPLES) return fail(m, function, "startTime must be within 1e15 samples of 0");
#endif
    if (stop_defined && !(stop >= start)) return fail(m, function, "stopTime must not be before startTime");
    m->s.time = m->s.start = start;
    m->s.stop = stop_defined ? stop : HUGE_VAL;
    return OK;
}

/* Called when initialization ends. The first sample instant is the first multiple of the period at or after the start. */
static void to_initialized(Instance *m) {
    m->last_successful = m->s.time;
    m->s.internal_step_used = m->s.p[INTERNAL_STEP];
#ifdef SAMPLE_PERIOD
    m->s.samples = (int64_t)ceil(m->s.start / SAMPLE_PERIOD - 1e-9);
#endif
}

/* ---- the model's functions ----------------------------------------------------------------------------------------- */

/* Calls a generated function, as call_in does, with any number of results. */
static void call(Instance *m, Function f, int n_in, const double *const in[], int n_out, double *const out[]) {
    for (int i = 0; i < n_in; i++) m->argument[i] = in[i];
    for (int i = 0; i < n_out; i++) m->result[i] = out[i];
    f(m->argument, m->result, m->integers, m->work, 0);
}

static int all_finite(const double *v, int n) {
    for (int i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

/* The component's parameters with what depends on them alone, computed when one has changed. */
static const double *parameters(Instance *m) {
    if (!m->P_known) {
        memcpy(m->P, m->s.p, N_P_MODEL * sizeof(double));
#if N_Q > 0
        call(m, MODEL(prepare), 1, (const double *[]){m->s.p}, 1, (double *[]){m->P + N_P_MODEL});
#endif
        m->P_known = 1;
    }
    return m->P;
}

static const double *outputs(Instance *m) {
    if (!m->y_known) {
        call(m, MODEL(output), 3, (const double *[]){m->s.x, m->s.u_now, parameters(m)}, 1, (double *[]){m->y});
        m->y_known = 1;
    }
    return m->y;
}

static const double *derivatives(Instance *m) {
    if (!m->x_dot_known) {
        call(m, MODEL(rhs), 3, (const double *[]){m->s.x, m->s.u_now, parameters(m)}, 1, (double *[]){m->x_dot});
        m->x_dot_known = 1;
    }
    return m->x_dot;
}

static void forget(Instance *m) { m->y_known = m->x_dot_known = 0; }

/* ---- access by value reference ------------------------------------------------------------------------------------- */

static Status get(Instance *m, const char *function, const uint32_t *vr, size_t n, double *value) {
    Status status = OK;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N_VARIABLES) return fail(m, function, "unknown value reference");
        const Variable *v = &VARIABLES[vr[i]];
        switch (v->kind) {
            case TIME: value[i] = m->s.time; break;
            case STATE: value[i] = m->s.x[v->index]; break;
            case INPUT: value[i] = m->s.U[v->index]; break;
            case OUTPUT: value[i] = outputs(m)[v->index]; break;
            case PARAMETER: value[i] = m->s.p[v->index]; break;
            case DERIVATIVE: value[i] = derivatives(m)[v->index]; break;
        }
        if (!isfinite(value[i])) status = discard(m, function, "no finite value for ", v->name);
    }
    return status;
}

/* Whether a variable may be set in the present mode. */
static int settable(const Instance *m, const Variable *v) {
    switch (v->kind) {
        case INPUT: return 1;
        case PARAMETER: return v->tunable ? !(m->s.mode & (CONTINUOUS | INTERMEDIATE)) : m->s.mode & (INSTANTIATED | INITIALIZATION);
        case STATE: return m->s.mode & (INSTANTIATED | INITIALIZATION) || (m->s.mode == CONTINUOUS && v->tunable);
        default: return 0;
    }
}

/* All values are checked before the first is set, so that a refused call changes nothing. */
static Status set(Instance *m, const char *function, const uint32_t *vr, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N_VARIABLES) return fail(m, function, "unknown value reference");
        const Variable *v = &VARIABLES[vr[i]];
        if (!settable(m, v)) {
            tell(m, ERROR, LOG_ERROR, "%s: %s must not be set in this state", function, v->name);
            m->s.mode = FAILED;
            return ERROR;
        }
        if (!isfinite(value[i])) return discard(m, function, "value must be finite: ", v->name);
        if (v->kind == PARAMETER && !(value[i] >= MIN_P[v->index] && value[i] <= MAX_P[v->index]))
            return discard(m, function, "value must lie within min and max: ", v->name);
    }
    for (size_t i = 0; i < n; i++) {
        const Variable *v = &VARIABLES[vr[i]];
        switch (v->kind) {
            case INPUT:
                m->s.U[v->index] = m->s.u_now[v->index] = value[i];
                m->s.u_now[v->index + N_U] = m->s.u_now[v->index + 2 * N_U] = 0.0;
                break;
            case PARAMETER: m->s.p[v->index] = value[i], m->P_known = 0; break;
            default: m->s.x[v->index] = value[i]; break;
        }
    }
    if (n > 0) forget(m);
    return OK;
}

/* ---- the continuous states, for Model Exchange ---------------------------------------------------------------------- */

static Status get_continuous(Instance *m, const char *function, const double *from, double *value, size_t n) {
    if (n != N_CONTINUOUS) return fail(m, function, "wrong number of continuous states");
    for (int i = 0; i < N_CONTINUOUS; i++) value[i] = from[CONTINUOUS_X[i]];
    return all_finite(value, N_CONTINUOUS) ? OK : discard(m, function, "a value is not finite", "");
}

static Status set_continuous(Instance *m, const char *function, const double *value, size_t n) {
    if (n != N_CONTINUOUS) return fail(m, function, "wrong number of continuous states");
    if (!all_finite(value, N_CONTINUOUS)) return discard(m, function, "states must be finite", "");
    for (int i = 0; i < N_CONTINUOUS; i++) m->s.x[CONTINUOUS_X[i]] = value[i];
    forget(m);
    return OK;
}

/* ---- saved states -------------------------------------------------------------------------------------------------- */

static int fits(const void *bytes) {
    State head;
    memcpy(&head, bytes, sizeof head);
    return head.zero == 0 && head.fingerprint == FINGERPRINT;
}

static void restore(Instance *m, const State *saved) {
    if (memcmp(m->s.p, saved->p, N_P_MODEL * sizeof(double))) m->P_known = 0;
    m->s = *saved;
    m->last_successful = m->s.time;
    forget(m);
}

static char *copy_of(const char *text) {
    size_t n = strlen(text ? text : "") + 1;
    char *copy = malloc(n);
    if (copy) memcpy(copy, text ? text : "", n);
    return copy;
}
