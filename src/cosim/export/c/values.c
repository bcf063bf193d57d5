/* Access by value reference, and the way from one mode to the next. */

#include <math.h>
#include <string.h>

#include "system.h"

/* A number of any type but text. */
static Status get_one(System *m, const char *function, const Variable *v, double *value) {
    Component *c = &m->components[v->component];
    fmi2Integer integer = 0;
    Status status = OK;
    switch (v->kind) {
        case TIME: *value = m->s.mode == INSTANTIATED ? m->s.start : m->s.last_successful; return OK;
        case ALGORITHM: *value = (double)m->s.algorithm; return OK;
        case DEGREE: *value = (double)m->s.degree; return OK;
        case MACRO_STEP: *value = m->s.step; return OK;
        case INPUT: *value = m->s.external[v->index]; return OK;
        case OUTPUT:
            if (m->s.mode == INSTANTIATED) break;
            if (m->s.mode != FAILED && m->s.mode != STEP_FAILED) status = refresh(m, function);
            *value = newest(m)[v->index];
            return status;
        case DERIVATIVE: /* for the inputs of this point, which the component may not have been given yet */
            if (m->s.mode == INSTANTIATED || m->s.mode == FAILED || m->s.mode == STEP_FAILED) break;
            if ((status = refresh(m, function)) == OK) status = evaluate(m, function, v->component, newest(m), 1);
            if (status != OK) return status;
            break;
        case FORWARDED: break;
    }
    switch (v->type) {
        case TYPE_REAL: status = judged(m, v->component, function, c->f->GetReal(c->instance, &v->reference, 1, value)); break;
        case TYPE_INTEGER:
        case TYPE_BOOLEAN: {
            fmi2GetIntegerTYPE *get = v->type == TYPE_INTEGER ? c->f->GetInteger : c->f->GetBoolean;
            status = judged(m, v->component, function, get ? get(c->instance, &v->reference, 1, &integer) : ERROR);
            break;
        }
        case TYPE_STRING: return fail(m, function, "a text is no number");
    }
    if (v->type != TYPE_REAL) *value = (double)integer;
    return status;
}

static Status get_text(System *m, const char *function, const Variable *v, const char **value) {
    Component *c = &m->components[v->component];
    return judged(m, v->component, function, c->f->GetString ? c->f->GetString(c->instance, &v->reference, 1, value) : ERROR);
}

static const Variable *variable(System *m, const char *function, uint32_t reference, Type type) {
    if (reference >= N_VARIABLES || VARIABLES[reference].type != type) {
        fail(m, function, "unknown value reference");
        return NULL;
    }
    return &VARIABLES[reference];
}

/* Whether a value may be set, so that a call that is refused changes nothing; what belongs to a component it checks itself. */
static Status may_set(System *m, const char *function, const Variable *v, double value) {
    if (!(v->settable & m->s.mode)) {
        tell(m, ERROR, LOG_ERROR, "%s: %s must not be set in this state", function, v->name);
        m->s.mode = FAILED;
        return ERROR;
    }
    if (v->type == TYPE_STRING) return OK;
    if (!isfinite(value)) return discard(m, function, "value must be finite: ", v->name);
    const double low = v->kind == ALGORITHM ? JACOBI : v->kind == DEGREE ? 0.0 : MIN_STEP;
    const double high = v->kind == ALGORITHM ? NEPCE : v->kind == DEGREE ? MAX_DEGREE : HUGE_VAL;
    const int of_the_coupling = v->kind == ALGORITHM || v->kind == DEGREE || v->kind == MACRO_STEP;
    if (of_the_coupling && !(value >= low && value <= high))
        return discard(m, function, "value must lie within min and max: ", v->name);
    return OK;
}

static Status set_one(System *m, const char *function, const Variable *v, double value, const char *text) {
    switch (v->kind) {
        case ALGORITHM: m->s.algorithm = (int64_t)value; return OK;
        case DEGREE: m->s.degree = (int64_t)value; return OK;
        case MACRO_STEP: m->s.step = value; return OK;
        case INPUT:
            if (m->s.external[v->index] == value) return OK; /* nothing changes, nor do the outputs */
            m->s.external[v->index] = value;
            break;
        default: break;
    }
    m->s.changed = 1;
    return give(m, function, v->component, v->type, v->reference, value, text);
}

/* ---- modes ---------------------------------------------------------------------------------------------------------- */

static Status set_experiment(System *m, const char *function, double start, int stop_defined, double stop) {
    if (!isfinite(start)) return fail(m, function, "startTime must be finite");
    if (stop_defined && !(stop >= start)) return fail(m, function, "stopTime must not be before startTime");
    m->s.start = m->s.origin = m->s.last_successful = start;
    m->s.stop = stop_defined ? stop : 0.0;
    m->s.stop_defined = stop_defined;
    return OK;
}

static Status enter_initialization(System *m, const char *function) {
    for (int i = 0; i < N_COMPONENTS; i++) {
        Component *c = &m->components[i];
        int status = c->f->SetupExperiment(c->instance, fmi2False, 0.0, m->s.start, (fmi2Boolean)m->s.stop_defined, m->s.stop);
        if (GOOD(status)) status = c->f->EnterInitializationMode(c->instance);
        Status answer = judged(m, i, function, status);
        if (answer != OK) return answer;
    }
    prepare_loop(m);
    m->s.mode = INITIALIZATION;
    m->s.changed = 1;
    m->s.known = 1, m->t[0] = m->s.start;
    return set_external(m);
}

static Status exit_initialization(System *m, const char *function) {
    Status status = settle(m, function);
    for (int i = 0; i < N_COMPONENTS && status == OK; i++)
        status = judged(m, i, function, m->components[i].f->ExitInitializationMode(m->components[i].instance));
    if (status != OK) return status;
    prepare_loop(m);
    m->s.mode = STEP;
    m->s.changed = 0;
    return consistent(m, function, m->Y);
}
