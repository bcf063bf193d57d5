/* An FMU of FMI 2.0 and 3.0 that computes its initial state from its input: x(0) = gain u + bias, then x' = -decay x, y = x.
   y is x(0) already in initialization mode; seen is the input as it was when that mode was left.
   silent = 1: outputs cannot be read in initialization mode; silent = 2: they are not numbers there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

enum { U, GAIN, BIAS, DECAY, SILENT, Y, SEEN, N };
enum { INSTANTIATED, INITIALIZATION, STEP };
enum { OK = 0, ERROR = 3 };

typedef struct {
    double v[N];
    int mode;
} Follower;

static Follower *instantiate(const char *token) {
    if (strcmp(token, "follower")) return NULL;
    Follower *f = calloc(1, sizeof *f);
    f->v[GAIN] = 1.0, f->v[DECAY] = 1.0;
    return f;
}
static int enter(Follower *f) {
    if (f->mode != INSTANTIATED) return ERROR;
    f->mode = INITIALIZATION;
    return OK;
}
static int leave(Follower *f) {
    if (f->mode != INITIALIZATION) return ERROR;
    f->v[Y] = f->v[GAIN] * f->v[U] + f->v[BIAS], f->v[SEEN] = f->v[U];
    f->mode = STEP;
    return OK;
}
static int get(Follower *f, const unsigned vr[], size_t n, double value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N) return ERROR;
        value[i] = f->v[vr[i]];
        if (f->mode == INITIALIZATION && vr[i] >= Y) {
            if (f->v[SILENT] == 1.0) return ERROR;
            value[i] = f->v[SILENT] == 2.0 ? NAN : vr[i] == Y ? f->v[GAIN] * f->v[U] + f->v[BIAS] : f->v[U];
        }
    }
    return OK;
}
static int set(Follower *f, const unsigned vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= Y || (f->mode != INSTANTIATED && vr[i] != U)) return ERROR;
        f->v[vr[i]] = value[i];
    }
    return OK;
}
static int step(Follower *f, double h) {
    if (f->mode != STEP) return ERROR;
    f->v[Y] *= exp(-f->v[DECAY] * h);
    return OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)name, (void)type, (void)resources, (void)callbacks, (void)visible, (void)log;
    return instantiate(guid);
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean d, fmi2Real e) {
    (void)c, (void)a, (void)b, (void)start, (void)d, (void)e;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return enter(c); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return leave(c); }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) { return get(c, vr, n, v); }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) { return set(c, vr, n, v); }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean n) { return (void)t, (void)n, step(c, h); }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n_required, (void)environment, (void)log;
    (void)update;
    return events || early ? NULL : instantiate(token);
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 start, fmi3Boolean d, fmi3Float64 e) {
    (void)a, (void)b, (void)start, (void)d, (void)e;
    return enter(c);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return leave(c); }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t m) {
    return m == n ? get(c, vr, n, v) : fmi3Error;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t m) {
    return m == n ? set(c, vr, n, v) : fmi3Error;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    *event = *terminate = *early = false;
    *reached = t + h;
    return step(c, h);
}
