/* An FMI 2.0 slave whose outputs follow its inputs directly: s[i] = i x[i], level_out = level, whole_out = whole, on_out = on,
   said = heard followed by "!", length = strlen(heard). news is the number of steps in words of digits, steps as a number. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { X, S = 3, LEVEL = 6, LEVEL_OUT, N_REAL };
enum { WHOLE, WHOLE_OUT, LENGTH, STEPS, N_INTEGER };
enum { ON, ON_OUT, N_BOOLEAN };
enum { HEARD, SAID, NEWS };

typedef struct {
    double real[N_REAL];
    int integer[N_INTEGER], boolean[N_BOOLEAN];
    char heard[200], said[202], news[16];
} Slave;

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)name, (void)type, (void)resources, (void)callbacks, (void)visible, (void)log;
    return strcmp(guid, "types") ? NULL : calloc(1, sizeof(Slave));
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    return (void)c, (void)a, (void)b, (void)start, (void)d, (void)e, fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }

static void follow(Slave *s) {
    for (int i = 0; i < 3; i++) s->real[S + i] = (i + 1) * s->real[X + i];
    s->real[LEVEL_OUT] = s->real[LEVEL], s->integer[WHOLE_OUT] = s->integer[WHOLE], s->boolean[ON_OUT] = s->boolean[ON];
    s->integer[LENGTH] = (int)strlen(s->heard);
    snprintf(s->said, sizeof s->said, "%s!", s->heard);
    snprintf(s->news, sizeof s->news, "%d", s->integer[STEPS]);
}
#define ACCESS(Name, type, field) \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
        follow(c); \
        for (size_t i = 0; i < n; i++) value[i] = ((Slave *)c)->field[vr[i]]; \
        return fmi2OK; \
    } \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) { \
        for (size_t i = 0; i < n; i++) ((Slave *)c)->field[vr[i]] = value[i]; \
        return fmi2OK; \
    }
ACCESS(Real, fmi2Real, real)
ACCESS(Integer, fmi2Integer, integer)
ACCESS(Boolean, fmi2Boolean, boolean)
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    Slave *s = c;
    follow(s);
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == HEARD ? s->heard : vr[i] == SAID ? s->said : s->news;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    if (n != 1 || vr[0] != HEARD) return fmi2Error;
    snprintf(((Slave *)c)->heard, sizeof ((Slave *)c)->heard, "%s", value[0]);
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set) {
    (void)t, (void)h, (void)no_set;
    ((Slave *)c)->integer[STEPS]++;
    return fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Slave));
    memcpy(*state, c, sizeof(Slave));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { return memcpy(c, state, sizeof(Slave)), fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { return (void)c, free(*state), *state = NULL, fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    return (void)c, (void)state, *size = sizeof(Slave), fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte data[], size_t size) {
    return (void)c, memcpy(data, state, size), fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte data[], size_t size, fmi2FMUstate *state) {
    (void)c;
    *state = malloc(size);
    return memcpy(*state, data, size), fmi2OK;
}
