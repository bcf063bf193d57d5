/* An FMI 3.0 slave with arrays and a variable of every type. After a step: y = gain * u element by element; total is their
   sum; the small integer outputs repeat their inputs; label and blob, set at the start, give length = strlen + bytes;
   2^53 gives huge_out = 2^53 + 1, which a float64 does not hold; with `leave_early` doStep returns before its end. */
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

#define N 3
enum { TIME, U, Y, GAIN, TOTAL, SINGLE, SINGLE_OUT, TINY, TINY_OUT, HUGE_IN, HUGE_OUT, ON, ON_OUT, MODE, MODE_OUT,
       LABEL, BLOB, LENGTH, LEAVE_EARLY, ASK_END, TICK, BEYOND };

typedef struct {
    double time, u[N], y[N], gain[N], total;
    float single, single_out;
    signed char tiny, tiny_out;
    unsigned long long huge, huge_out;
    bool on, on_out, leave_early, ask_end, beyond;
    long long mode, mode_out;
    int length, label_length, blob_length;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Slave;

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n_required, (void)update;
    if (strcmp(token, "arrays") || events || early) {
        log(environment, fmi3Error, "logStatusError", "this token is not mine");
        return NULL;
    }
    Slave *s = calloc(1, sizeof *s);
    s->log = log, s->environment = environment, s->mode = 1;
    for (int i = 0; i < N; i++) s->gain[i] = 1.0;
    return s;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 start, fmi3Boolean d, fmi3Float64 e) {
    (void)a, (void)b, (void)d, (void)e;
    ((Slave *)c)->time = start;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }

static void *place(Slave *s, fmi3ValueReference vr, size_t *n) {
    *n = vr == U || vr == Y || vr == GAIN ? N : 1;
    switch (vr) {
        case TIME: return &s->time;
        case U: return s->u;
        case Y: return s->y;
        case GAIN: return s->gain;
        case TOTAL: return &s->total;
        case SINGLE: return &s->single;
        case SINGLE_OUT: return &s->single_out;
        case TINY: return &s->tiny;
        case TINY_OUT: return &s->tiny_out;
        case HUGE_IN: return &s->huge;
        case HUGE_OUT: return &s->huge_out;
        case ON: return &s->on;
        case ON_OUT: return &s->on_out;
        case MODE: return &s->mode;
        case MODE_OUT: return &s->mode_out;
        case LENGTH: return &s->length;
        case LEAVE_EARLY: return &s->leave_early;
        case ASK_END: return &s->ask_end;
        case BEYOND: return &s->beyond;
        default: return NULL;
    }
}
#define ACCESS(Name, type) \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t n_values) { \
        size_t done = 0, m; \
        for (size_t i = 0; i < n; i++, done += m) { \
            void *from = place(c, vr[i], &m); \
            if (!from || done + m > n_values) return fmi3Error; \
            memcpy(value + done, from, m * sizeof(type)); \
        } \
        return done == n_values ? fmi3OK : fmi3Error; \
    } \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[], size_t n_values) { \
        size_t done = 0, m; \
        for (size_t i = 0; i < n; i++, done += m) { \
            void *to = place(c, vr[i], &m); \
            if (!to || done + m > n_values) return fmi3Error; \
            memcpy(to, value + done, m * sizeof(type)); \
        } \
        return done == n_values ? fmi3OK : fmi3Error; \
    }
ACCESS(Float64, fmi3Float64)
ACCESS(Float32, fmi3Float32)
ACCESS(Int8, fmi3Int8)
ACCESS(Int32, fmi3Int32)
ACCESS(Int64, fmi3Int64)
ACCESS(UInt64, fmi3UInt64)
ACCESS(Boolean, fmi3Boolean)
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t n_values) {
    (void)vr, (void)n;
    ((Slave *)c)->label_length = 0;
    for (size_t i = 0; i < n_values; i++) ((Slave *)c)->label_length += (int)strlen(value[i]);
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t size[], const fmi3Binary value[],
                         size_t n_values) {
    (void)vr, (void)n, (void)value, (void)n_values;
    ((Slave *)c)->blob_length = (int)size[0];
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    Slave *s = c;
    *event = false, *terminate = s->ask_end, *early = s->leave_early;
    *reached = s->time = s->leave_early ? t + h / 2 : t + h;
    if (s->beyond) *reached += 1e-4 * h;
    s->total = 0;
    for (int i = 0; i < N; i++) s->total += s->y[i] = s->gain[i] * s->u[i];
    s->single_out = s->single, s->tiny_out = s->tiny, s->huge_out = s->huge + (s->huge == 1ULL << 53), s->on_out = s->on, s->mode_out = s->mode;
    s->length = s->label_length + s->blob_length;
    return fmi3OK;
}
