/* An FMI 2.0 slave with a variable of every type that fails on demand; state is one struct.
   y = gain * u as set at the last step; count counts steps while `on`; mode_out = mode; text is logged when it fails. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

enum { U, Y, GAIN, FAULT_AT, N_REAL };
enum { ADD, COUNT, MODE, MODE_OUT, FAULT, N_INTEGER };
enum { ON, ON_OUT, N_BOOLEAN };
enum { NONE, DISCARD, FAIL, FATAL, NOT_A_NUMBER, CRASH, HANG, LEAVE, AT_START, QUIT, WARN };

typedef struct {
    double real[N_REAL];
    int integer[N_INTEGER], boolean[N_BOOLEAN];
    char text[64], name[64];
    double time;
    const fmi2CallbackFunctions *callbacks;
} Slave;

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)type, (void)resources, (void)visible, (void)log;
    if (strcmp(guid, "mixed")) return NULL;
    Slave *s = calloc(1, sizeof *s);
    s->callbacks = callbacks;
    s->real[GAIN] = 2.0, s->integer[MODE] = 1, s->real[FAULT_AT] = 0.05;
    snprintf(s->name, sizeof s->name, "%s", name);
    return s;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Slave *)c)->time = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return ((Slave *)c)->integer[FAULT] == AT_START ? fmi2Error : fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }

#define ACCESS(Name, type, field, n_of) \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= n_of) return fmi2Error; \
            value[i] = ((Slave *)c)->field[vr[i]]; \
        } \
        return fmi2OK; \
    } \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) { \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= n_of) return fmi2Error; \
            ((Slave *)c)->field[vr[i]] = value[i]; \
        } \
        return fmi2OK; \
    }
ACCESS(Real, fmi2Real, real, N_REAL)
ACCESS(Integer, fmi2Integer, integer, N_INTEGER)
ACCESS(Boolean, fmi2Boolean, boolean, N_BOOLEAN)
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr, (void)n;
    snprintf(((Slave *)c)->text, sizeof ((Slave *)c)->text, "%s", value[0]);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set) {
    (void)no_set;
    Slave *s = c;
    s->real[Y] = s->real[GAIN] * s->real[U];
    s->integer[COUNT] += s->boolean[ON] ? 1 + s->integer[ADD] : 0;
    s->integer[MODE_OUT] = s->integer[MODE], s->boolean[ON_OUT] = s->boolean[ON];
    if (t + h < s->real[FAULT_AT] || s->integer[FAULT] == NONE) {
        s->time = t + h;
        return fmi2OK;
    }
    if (s->integer[FAULT] == WARN) {
        s->callbacks->logger(s->callbacks->componentEnvironment, s->name, fmi2Warning, "logStatusWarning", "worn at %g s", t);
        s->time = t + h;
        return fmi2Warning;
    }
    s->callbacks->logger(s->callbacks->componentEnvironment, s->name, fmi2Error, "logStatusError", "it broke at %g s: %s",
                         t, s->text);
    s->time = t + h / 4;
    switch (s->integer[FAULT]) {
        case DISCARD: case QUIT: return fmi2Discard;
        case FAIL: return fmi2Error;
        case FATAL: return fmi2Fatal;
        case NOT_A_NUMBER: s->real[Y] = NAN; return fmi2OK;
        case CRASH: *(volatile int *)16 = 1; return fmi2OK;
        case HANG: for (;;) sleep(1);
        case LEAVE: exit(3);
        default: return fmi2OK;
    }
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    (void)kind;
    *value = ((Slave *)c)->time;
    return fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = kind == fmi2Terminated && ((Slave *)c)->integer[FAULT] == QUIT;
    return fmi2OK;
}
