/* A component of FMI 3.0 behind functions of FMI 2.0, so that the rest need not tell them apart: inputs that change within a step
   are given when the FMU asks for them (intermediate update), events are handled within the step at their own time.
   The same as the package's slaves/fmi/fmi3.py, operation by operation, so that both give the same bits. */

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "system.h"

#if defined CARRIES && CARRIES_3

#define STUCK 1000   /* events and early returns at one time after which an FMU counts as stuck */
#define UPDATES 1000 /* rounds after which the discrete states must have settled */

#define FUNCTIONS_3(X) \
    X(InstantiateCoSimulation) X(FreeInstance) X(EnterInitializationMode) X(ExitInitializationMode) X(EnterEventMode) \
    X(EnterStepMode) X(UpdateDiscreteStates) X(Terminate) X(GetFloat64) X(SetFloat64) X(GetInt32) X(SetInt32) X(GetInt64) \
    X(SetInt64) X(GetBoolean) X(SetBoolean) X(GetString) X(SetString) X(DoStep) X(GetFMUState) X(SetFMUState) X(FreeFMUState) \
    X(SerializedFMUStateSize) X(SerializeFMUState) X(DeserializeFMUState) X(GetDirectionalDerivative)

/* What is known of the FMU beside its state. */
typedef struct {
    int64_t events, ends;
    double due; /* the next time event, s */
} Note;

typedef struct {
#define MEMBER_3(name) fmi3##name##TYPE *name;
    FUNCTIONS_3(MEMBER_3)
    Component *component;
    fmi3Instance instance;
    Note note;
    double start, stop, t; /* t: begin of the step */
    int stop_defined, curved, answered; /* whether the inputs change within the step; the worst status of giving them */
    double u[AT_LEAST_ONE(MOST_WIRES)], du[AT_LEAST_ONE(MOST_WIRES)], ddu[AT_LEAST_ONE(MOST_WIRES)];
    double now[AT_LEAST_ONE(MOST_WIRES)];
    fmi3Boolean event, ended, early, no_set_state;
    double reached;
} Fmu3;

typedef struct {
    fmi3FMUState state;
    Note note;
} Saved3;

static const fmi3ValueReference *inputs_of(const Fmu3 *c) {
    return c->component->system->u_refs + c->component->data->first_wire;
}
static size_t n_inputs(const Fmu3 *c) { return (size_t)c->component->data->n_u; }

static void log_3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)category;
    if (environment && message) relay(environment, (int)status, message);
}

static void update_3(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set_requested, fmi3Boolean get_allowed,
                     fmi3Boolean finished, fmi3Boolean can_return, fmi3Boolean *early, fmi3Float64 *early_time) {
    Fmu3 *c = ((Component *)environment)->instance;
    (void)get_allowed, (void)finished, (void)can_return, (void)early_time;
    *early = 0;
    if (!set_requested || !c || !c->curved) return;
    const double s = time - c->t;
    for (size_t j = 0; j < n_inputs(c); j++) c->now[j] = c->u[j] + s * (c->du[j] + s * (c->ddu[j] / 2));
    const int status = (int)c->SetFloat64(c->instance, inputs_of(c), n_inputs(c), c->now, n_inputs(c));
    if (status > c->answered) c->answered = status;
}

static Status says(const Fmu3 *c, const char *what) {
    tell(c->component->system, ERROR, LOG_ERROR, "%s: %s", c->component->data->name, what);
    return ERROR;
}

/* Inputs of the polynomial at offset s of the step, set. */
static int set_at(Fmu3 *c, double s) {
    if (n_inputs(c) == 0) return OK;
    for (size_t j = 0; j < n_inputs(c); j++) c->now[j] = c->u[j] + s * (c->du[j] + s * c->ddu[j] / 2);
    return (int)c->SetFloat64(c->instance, inputs_of(c), n_inputs(c), c->now, n_inputs(c));
}

static int leave_event_mode(Fmu3 *c) {
    fmi3Boolean more = 0, ends = 0, ignored = 0, defined = 0;
    fmi3Float64 due = 0.0;
    int settled = 0;
    for (int k = 0; k < UPDATES && !settled; k++) {
        const int status = (int)c->UpdateDiscreteStates(c->instance, &more, &ends, &ignored, &ignored, &defined, &due);
        if (!GOOD(status)) return status;
        c->note.ends |= ends;
        settled = ends || !more;
    }
    const int status = (int)c->EnterStepMode(c->instance);
    if (!GOOD(status)) return status;
    c->note.due = defined ? due : HUGE_VAL;
    return settled ? OK : says(c, "the discrete states must settle, they do not");
}

static int handle_event(Fmu3 *c, double s) {
    int status = (int)c->EnterEventMode(c->instance);
    if (GOOD(status)) status = set_at(c, s);
    c->note.events++;
    return GOOD(status) ? leave_event_mode(c) : status;
}

/* fmi3DoStep, and what it has answered. */
static int advance_3(Fmu3 *c, double t, double h) {
    const int with_events = c->component->data->event_mode;
    c->reached = t + h, c->event = c->ended = c->early = 0;
    const int status = (int)c->DoStep(c->instance, t, h, c->no_set_state, &c->event, &c->ended, &c->early, &c->reached);
    if (!GOOD(status)) return status;
    if (!GOOD(c->answered)) return c->answered;
    const int is_short = fabs(c->reached - (t + h)) > 1e-9 * (h + fabs(t));
    if (c->ended) {
        c->note.ends = 1;
        return is_short && !with_events ? DISCARD : OK;
    }
    if (is_short && !(with_events && c->early)) return says(c, "the FMU must do the whole step, it returned early");
    return OK;
}

static fmi2Status step_3(fmi2Component it, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    Fmu3 *c = it;
    const double end = t + h, close = 1e-9 * h + 4 * DBL_EPSILON * fabs(end);
    double now = t;
    int status, stuck = 0;
    c->t = t, c->answered = OK, c->no_set_state = no_set_state != 0;
    if (c->note.ends) return fmi2Discard;
    if (!c->component->data->event_mode) {
        status = advance_3(c, t, h);
        if (status == OK && c->early && !c->ended) status = says(c, "the FMU must do the whole step, it returned early");
        return (fmi2Status)status;
    }
    while (end - now > close) {
        if (c->note.due > now + close) {
            const int cut = c->note.due < end - close && c->component->data->every_length;
            if ((status = advance_3(c, now, (cut ? c->note.due : end) - now)) != OK) return (fmi2Status)status;
            stuck = c->reached > now + close ? 0 : stuck + 1;
            now = c->reached;
        } else {
            c->event = 1, stuck++;
        }
        if (c->event || c->note.due <= now + close) status = handle_event(c, now - t), c->event = 0;
        else status = end - now > close ? set_at(c, now - t) : OK; /* it came back for another reason */
        if (!GOOD(status)) return (fmi2Status)status;
        if (c->note.ends && end - now > close) return fmi2Discard;
        if (stuck > STUCK) return (fmi2Status)says(c, "the FMU must get on, it stays at one time");
    }
    return fmi2OK;
}

static fmi2Status set_real_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Fmu3 *c = it;
    if (vr == inputs_of(c)) {
        memcpy(c->u, value, n * sizeof(double));
        memset(c->du, 0, n * sizeof(double)), memset(c->ddu, 0, n * sizeof(double));
        c->curved = 0;
    }
    return (fmi2Status)c->SetFloat64(c->instance, vr, n, value, n);
}

static fmi2Status set_derivatives_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                    const fmi2Real value[]) {
    Fmu3 *c = it;
    (void)vr;
    for (size_t k = 0; k < n; k++) {
        (order[k] == 1 ? c->du : c->ddu)[k % n_inputs(c)] = value[k];
        c->curved |= value[k] != 0.0;
    }
    return fmi2OK;
}

static fmi2Status get_real_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    return (fmi2Status)((Fmu3 *)it)->GetFloat64(((Fmu3 *)it)->instance, vr, n, value, n);
}

static int is_wide(const Fmu3 *c, fmi3ValueReference reference) {
    for (int k = 0; k < N_WIDE; k++)
        if (&COMPONENTS[WIDE[k].component] == c->component->data && WIDE[k].reference == reference) return 1;
    return 0;
}

static fmi2Status get_integer_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    Fmu3 *c = it;
    int status = OK;
    for (size_t k = 0; k < n && GOOD(status); k++) {
        fmi3Int64 wide = 0;
        fmi3Int32 narrow = 0;
        if (is_wide(c, vr[k])) status = c->GetInt64 ? (int)c->GetInt64(c->instance, &vr[k], 1, &wide, 1) : ERROR;
        else status = c->GetInt32 ? (int)c->GetInt32(c->instance, &vr[k], 1, &narrow, 1) : ERROR, wide = narrow;
        value[k] = (fmi2Integer)wide;
    }
    return (fmi2Status)status;
}

static fmi2Status set_integer_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    Fmu3 *c = it;
    int status = OK;
    for (size_t k = 0; k < n && GOOD(status); k++) {
        const fmi3Int64 wide = value[k];
        const fmi3Int32 narrow = value[k];
        if (is_wide(c, vr[k])) status = c->SetInt64 ? (int)c->SetInt64(c->instance, &vr[k], 1, &wide, 1) : ERROR;
        else status = c->SetInt32 ? (int)c->SetInt32(c->instance, &vr[k], 1, &narrow, 1) : ERROR;
    }
    return (fmi2Status)status;
}

static fmi2Status get_boolean_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    Fmu3 *c = it;
    int status = c->GetBoolean ? OK : ERROR;
    for (size_t k = 0; k < n && GOOD(status); k++) {
        fmi3Boolean one = 0;
        status = (int)c->GetBoolean(c->instance, &vr[k], 1, &one, 1);
        value[k] = one;
    }
    return (fmi2Status)status;
}

static fmi2Status set_boolean_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    Fmu3 *c = it;
    int status = c->SetBoolean ? OK : ERROR;
    for (size_t k = 0; k < n && GOOD(status); k++) {
        const fmi3Boolean one = value[k] != 0;
        status = (int)c->SetBoolean(c->instance, &vr[k], 1, &one, 1);
    }
    return (fmi2Status)status;
}

static fmi2Status get_string_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    Fmu3 *c = it;
    return c->GetString ? (fmi2Status)c->GetString(c->instance, vr, n, value, n) : fmi2Error;
}

static fmi2Status set_string_3(fmi2Component it, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    Fmu3 *c = it;
    return c->SetString ? (fmi2Status)c->SetString(c->instance, vr, n, value, n) : fmi2Error;
}
#endif
