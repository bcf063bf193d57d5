/* An FMI 3.0 slave whose outputs follow its inputs directly: y[i] = 2 x[i] for i up to the structural parameter n, and
   grid[i, j] = 10 i + j, of n rows and 2 columns; said = heard followed by "?", copy = blob backwards. sum is that of w, which
   starts as 1, 2, 3, ... With event mode, heard and blob may be set there and in initialization mode only. */
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

#define MOST 5
enum { TIME, N, X, Y, GRID, W, SUM, HEARD, SAID, BLOB, COPY };
enum { SET_UP, CONFIGURING, INITIALIZING, STEPPING, EVENT };

typedef struct {
    unsigned long long n;
    double x[MOST], w[MOST];
    char heard[100], said[102];
    unsigned char blob[100], copy[100];
    size_t size;
    int mode, events;
} Slave;

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)early, (void)required, (void)n_required, (void)environment;
    (void)log, (void)update;
    if (strcmp(token, "types")) return NULL;
    Slave *s = calloc(1, sizeof *s);
    s->n = 3, s->events = events;
    for (int i = 0; i < MOST; i++) s->w[i] = i + 1;
    return s;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }

#define GO(from, to) ((Slave *)c)->mode == from ? ((Slave *)c)->mode = to, fmi3OK : fmi3Error
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return GO(SET_UP, CONFIGURING); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return GO(CONFIGURING, SET_UP); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 start, fmi3Boolean d, fmi3Float64 e) {
    (void)a, (void)b, (void)start, (void)d, (void)e;
    return GO(SET_UP, INITIALIZING);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return GO(INITIALIZING, ((Slave *)c)->events ? EVENT : STEPPING); }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return GO(STEPPING, EVENT); }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return GO(EVENT, STEPPING); }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *due) {
    *more = *ends = *nominals = *values = *defined = false, *due = 0;
    return ((Slave *)c)->mode == EVENT ? fmi3OK : fmi3Error;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    *event = *terminate = *early = false, *reached = t + h;
    return ((Slave *)c)->mode == STEPPING ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 value[], size_t m) {
    Slave *s = c;
    if (s->mode != CONFIGURING || n != 1 || m != 1 || vr[0] != N || value[0] > MOST) return fmi3Error;
    s->n = value[0];
    return fmi3OK;
}
fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 value[], size_t m) {
    if (n != 1 || m != 1 || vr[0] != N) return fmi3Error;
    return value[0] = ((Slave *)c)->n, fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t m) {
    Slave *s = c;
    size_t done = 0;
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < s->n; i++) {
            if (done == m || (vr[k] != X && vr[k] != W)) return fmi3Error;
            (vr[k] == X ? s->x : s->w)[i] = value[done++];
        }
    return done == m ? fmi3OK : fmi3Error;
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t m) {
    Slave *s = c;
    size_t done = 0;
    for (size_t k = 0; k < n; k++) {
        size_t size = vr[k] == SUM ? 1 : vr[k] == GRID ? 2 * s->n : s->n;
        if (done + size > m) return fmi3Error;
        double *to = value + done;
        if (vr[k] == SUM) to[0] = 0;
        for (size_t i = 0; i < s->n; i++) {
            if (vr[k] == SUM) to[0] += s->w[i];
            else if (vr[k] == GRID) to[2 * i] = 10.0 * (i + 1) + 1, to[2 * i + 1] = 10.0 * (i + 1) + 2;
            else to[i] = vr[k] == X ? s->x[i] : vr[k] == Y ? 2 * s->x[i] : s->w[i];
        }
        done += size;
    }
    return done == m ? fmi3OK : fmi3Error;
}
static int closed(Slave *s) { return s->events && s->mode == STEPPING; }
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t m) {
    Slave *s = c;
    if (n != 1 || m != 1 || vr[0] != HEARD || strlen(value[0]) > 99 || closed(s)) return fmi3Error;
    strcpy(s->heard, value[0]);
    return fmi3OK;
}
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t m) {
    Slave *s = c;
    if (n != 1 || m != 1 || (vr[0] != HEARD && vr[0] != SAID)) return fmi3Error;
    strcat(strcpy(s->said, s->heard), "?");
    value[0] = vr[0] == HEARD ? s->heard : s->said;
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t size[], const fmi3Binary value[],
                         size_t m) {
    Slave *s = c;
    if (n != 1 || m != 1 || vr[0] != BLOB || size[0] > 100 || closed(s)) return fmi3Error;
    memcpy(s->blob, value[0], s->size = size[0]);
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t size[], fmi3Binary value[], size_t m) {
    Slave *s = c;
    if (n != 1 || m != 1 || (vr[0] != BLOB && vr[0] != COPY)) return fmi3Error;
    for (size_t i = 0; i < s->size; i++) s->copy[i] = s->blob[s->size - 1 - i];
    size[0] = s->size, value[0] = vr[0] == BLOB ? s->blob : s->copy;
    return fmi3OK;
}
