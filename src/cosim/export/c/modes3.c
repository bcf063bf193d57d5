/* A component of FMI 3.0 behind functions of FMI 2.0, second part: its modes and states, and all functions in one table. */

#include <stdlib.h>
#include <string.h>

#include "system.h"

#if defined CARRIES && CARRIES_3

static fmi2Status setup_3(fmi2Component it, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                          fmi2Boolean stop_defined, fmi2Real stop) {
    Fmu3 *c = it;
    (void)tolerance_defined, (void)tolerance;
    c->start = start, c->stop = stop, c->stop_defined = stop_defined;
    c->note = (Note){0, 0, HUGE_VAL};
    return fmi2OK;
}

static fmi2Status enter_3(fmi2Component it) {
    Fmu3 *c = it;
    return (fmi2Status)c->EnterInitializationMode(c->instance, 0, 0.0, c->start, c->stop_defined != 0, c->stop);
}

static fmi2Status exit_3(fmi2Component it) {
    Fmu3 *c = it;
    const int status = (int)c->ExitInitializationMode(c->instance);
    return (fmi2Status)(GOOD(status) && c->component->data->event_mode ? leave_event_mode(c) : status);
}

static fmi2Status terminate_3(fmi2Component it) { return (fmi2Status)((Fmu3 *)it)->Terminate(((Fmu3 *)it)->instance); }

static void free_3(fmi2Component it) {
    Fmu3 *c = it;
    c->FreeInstance(c->instance);
    free(c);
}

static fmi2Status status_3(fmi2Component it, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = kind == fmi2Terminated && ((Fmu3 *)it)->note.ends != 0;
    return fmi2OK;
}

static fmi2Status get_state_3(fmi2Component it, fmi2FMUstate *state) {
    Fmu3 *c = it;
    if (!*state) *state = calloc(1, sizeof(Saved3));
    if (!*state) return fmi2Error;
    ((Saved3 *)*state)->note = c->note;
    return (fmi2Status)c->GetFMUState(c->instance, &((Saved3 *)*state)->state);
}

static fmi2Status set_state_3(fmi2Component it, fmi2FMUstate state) {
    Fmu3 *c = it;
    c->note = ((Saved3 *)state)->note;
    return (fmi2Status)c->SetFMUState(c->instance, ((Saved3 *)state)->state);
}

static fmi2Status free_state_3(fmi2Component it, fmi2FMUstate *state) {
    Fmu3 *c = it;
    const int status = (int)c->FreeFMUState(c->instance, &((Saved3 *)*state)->state);
    free(*state);
    *state = NULL;
    return (fmi2Status)status;
}

static fmi2Status size_3(fmi2Component it, fmi2FMUstate state, size_t *size) {
    Fmu3 *c = it;
    const int status = (int)c->SerializedFMUStateSize(c->instance, ((Saved3 *)state)->state, size);
    *size += sizeof(Note);
    return (fmi2Status)status;
}

static fmi2Status serialize_3(fmi2Component it, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    Fmu3 *c = it;
    memcpy(bytes, &((Saved3 *)state)->note, sizeof(Note));
    fmi3Byte *rest = (fmi3Byte *)bytes + sizeof(Note);
    return (fmi2Status)c->SerializeFMUState(c->instance, ((Saved3 *)state)->state, rest, size - sizeof(Note));
}

static fmi2Status deserialize_3(fmi2Component it, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    Fmu3 *c = it;
    if (size < sizeof(Note)) return fmi2Error;
    if (!*state) *state = calloc(1, sizeof(Saved3));
    if (!*state) return fmi2Error;
    memcpy(&((Saved3 *)*state)->note, bytes, sizeof(Note));
    return (fmi2Status)c->DeserializeFMUState(c->instance, (const fmi3Byte *)bytes + sizeof(Note), size - sizeof(Note),
                                              &((Saved3 *)*state)->state);
}

static fmi2Status derivative_3(fmi2Component it, const fmi2ValueReference unknown[], size_t n_unknown,
                               const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[], fmi2Real value[]) {
    Fmu3 *c = it;
    if (!c->GetDirectionalDerivative) return fmi2Error;
    return (fmi2Status)c->GetDirectionalDerivative(c->instance, unknown, n_unknown, known, n_known, seed, n_known, value,
                                                   n_unknown);
}

static const Functions2 FUNCTIONS_OF_3 = {
    .FreeInstance = free_3, .SetupExperiment = setup_3, .EnterInitializationMode = enter_3, .ExitInitializationMode = exit_3,
    .Terminate = terminate_3, .GetReal = get_real_3, .GetInteger = get_integer_3, .GetBoolean = get_boolean_3,
    .GetString = get_string_3, .SetReal = set_real_3, .SetInteger = set_integer_3, .SetBoolean = set_boolean_3,
    .SetString = set_string_3, .SetRealInputDerivatives = set_derivatives_3, .DoStep = step_3, .GetBooleanStatus = status_3,
    .GetFMUstate = get_state_3, .SetFMUstate = set_state_3, .FreeFMUstate = free_state_3, .SerializedFMUstateSize = size_3,
    .SerializeFMUstate = serialize_3, .DeSerializeFMUstate = deserialize_3, .GetDirectionalDerivative = derivative_3,
};

/* An instance of the loaded library of component `c`. */
static int make_3(System *m, Component *c) {
    const ComponentData *data = c->data;
    Fmu3 *fmu = calloc(1, sizeof *fmu);
    if (!fmu) return 0;
#define FIND_3(of) *(void **)&fmu->of = symbol(c->library, "fmi3" #of);
    FUNCTIONS_3(FIND_3)
    const int basic = fmu->InstantiateCoSimulation && fmu->FreeInstance && fmu->EnterInitializationMode &&
                      fmu->ExitInitializationMode && fmu->Terminate && fmu->GetFloat64 && fmu->SetFloat64 && fmu->DoStep;
    const int events = fmu->EnterEventMode && fmu->EnterStepMode && fmu->UpdateDiscreteStates;
    const int states = fmu->GetFMUState && fmu->SetFMUState && fmu->FreeFMUState;
    const int written = fmu->SerializedFMUStateSize && fmu->SerializeFMUState && fmu->DeserializeFMUState;
    if (!basic || (data->event_mode && !events) || (data->restores && !states) || (ALL_SERIALIZE && !written)) {
        tell(m, ERROR, LOG_ERROR, "component %s: its library lacks a function of FMI 3.0", data->name);
        free(fmu);
        return 0;
    }
    fmu->component = c;
    fmu->instance = fmu->InstantiateCoSimulation(
        c->name, data->token, c->resources, 0, 1, data->event_mode != 0, data->event_mode != 0, ASKED + data->first_asked,
        (size_t)data->n_asked, c, log_3, data->n_asked ? update_3 : NULL);
    if (!fmu->instance) {
        free(fmu);
        return 0;
    }
    c->instance = fmu, c->f = &FUNCTIONS_OF_3;
    return 1;
}

#endif
