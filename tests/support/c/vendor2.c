/* An FMI 2.0 slave that promises more than it keeps, as parameters say, and tells what it was promised.
   x' = u under the polynomial that it was given, from x = start; y = x.
   accepts: order of input derivatives up to which it does not answer Error
   newstep: it takes noSetFMUStatePriorToCurrentPoint = false for "repeat the step before", as if it were newStep of FMI 1.0
   stateless: fmi2GetFMUstate answers Error. answer: status of doStep from the second step on
   pending: doStep answers Pending, and is asked so often before it has ended
   Outputs: tolerance, stop as they were told, -1 where undefined; revocable: steps that might have been taken back;
   shortest, longest: of the steps. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { U, Y, ACCEPTS, NEWSTEP, STATELESS, ANSWER, PENDING, START, TOLERANCE, STOP, REVOCABLE, SHORTEST, LONGEST, N };

typedef struct {
    double v[N], x, before, du[2], end;
    int polls, steps;
} Slave;

#ifdef ONCE
static int instances; /* it can be instantiated once per process only */
#endif

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)type, (void)resources, (void)visible, (void)log;
    if (strcmp(guid, "vendor")) return NULL;
#ifdef ONCE
    if (instances++) return NULL;
#endif
#ifdef LICENCE
    callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "licence", "no licence for %s found at %d", "Vendor", 27000);
    return NULL;
#else
    (void)callbacks, (void)name;
#endif
    Slave *s = calloc(1, sizeof *s);
    s->v[ACCEPTS] = 2, s->v[TOLERANCE] = s->v[STOP] = -1, s->v[SHORTEST] = 1e9;
    return s;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean given, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends, fmi2Real stop) {
    (void)start;
    Slave *s = c;
    if (given) s->v[TOLERANCE] = tolerance;
    if (ends) s->v[STOP] = stop;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Slave *s = c;
    s->x = s->before = s->v[START];
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Slave *s = c;
    for (size_t i = 0; i < n; i++) s->v[vr[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Slave *s = c;
    s->v[Y] = s->x;
    for (size_t i = 0; i < n; i++) value[i] = s->v[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    Slave *s = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != U || order[i] > s->v[ACCEPTS]) return fmi2Error;
        s->du[order[i] - 1] = value[i];
    }
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set) {
    (void)t;
    Slave *s = c;
    if (s->v[NEWSTEP] && !no_set) s->x = s->before;
    s->before = s->x;
    if (!no_set) s->v[REVOCABLE] += 1;
    if (h < s->v[SHORTEST]) s->v[SHORTEST] = h;
    if (h > s->v[LONGEST]) s->v[LONGEST] = h;
    s->end = s->x + h * (s->v[U] + h * (s->du[0] / 2 + h * s->du[1] / 6));
    s->du[0] = s->du[1] = 0;
    if (s->v[PENDING] > 0) {
        s->polls = (int)s->v[PENDING];
        return fmi2Pending;
    }
    s->x = s->end;
    return s->steps++ ? (fmi2Status)(int)s->v[ANSWER] : fmi2OK;
}
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    Slave *s = c;
    if (kind != fmi2DoStepStatus) return fmi2Discard;
    *value = --s->polls > 0 ? fmi2Pending : fmi2OK;
    if (*value == fmi2OK) s->x = s->end;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Slave *s = c;
    if (s->v[STATELESS]) return fmi2Error;
    if (!*state) *state = malloc(sizeof *s);
    memcpy(*state, s, sizeof *s);
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Slave *s = c;
    double told = s->v[REVOCABLE];
    memcpy(c, state, sizeof(Slave));
    s->v[REVOCABLE] = told;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
