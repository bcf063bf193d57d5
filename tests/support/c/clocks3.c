/* An FMI 3.0 FMU with clocks, for Co-Simulation with event mode and for Model Exchange, strict about who does what when.

   every   input clock with an interval of its own, of any kind; each tick samples v into held, x' = held
   go      triggered input clock; each tick adds u to sum; answer is letter backwards, and how often go has ticked
   out     output clock; ticks with each `each`-th tick of every, and with every tick of go

   Clocked inputs may be set where their clock ticks only, clocks in event mode only, and no step may pass a tick of every. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { TIME, EVERY, GO, OUT, U, V, TICKS, GOES, SUM, LAST, HELD, LETTER, ANSWER, EACH, X, DX, INTERVAL, KIND, PLAIN, N };
enum { CONSTANT, FIXED, TUNABLE, CHANGING, COUNTDOWN, FROM_PARAMETERS }; /* the last: fixed, no interval stated */
enum { INSTANTIATED, INITIALIZATION, EVENT, STEP, CONTINUOUS };

typedef struct {
    double v[N], due;
    int exchange, events, mode, every, go, out, changed;
    size_t size;
    unsigned char letter[64], answer[64];
} It;

static It *made(fmi3String token, int exchange, int events) {
    if (strcmp(token, "clocks")) return NULL;
    It *s = calloc(1, sizeof *s);
    s->exchange = exchange, s->events = events, s->v[EACH] = 2, s->v[INTERVAL] = 0.1, s->v[V] = 1;
    return s;
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String a, fmi3String token, fmi3String b, fmi3Boolean d, fmi3Boolean e,
                                         fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference f[], size_t g,
                                         fmi3InstanceEnvironment i, fmi3LogMessageCallback j, fmi3IntermediateUpdateCallback k) {
    (void)a, (void)b, (void)d, (void)e, (void)early, (void)f, (void)g, (void)i, (void)j, (void)k;
#ifdef EVENTS_ONLY
    if (!events) return NULL;
#endif
    return made(token, 0, events);
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String a, fmi3String token, fmi3String b, fmi3Boolean d, fmi3Boolean e,
                                          fmi3InstanceEnvironment f, fmi3LogMessageCallback g) {
    (void)a, (void)b, (void)d, (void)e, (void)f, (void)g;
    return made(token, 1, 1);
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Reset(fmi3Instance c) {
    It *s = c, *fresh = made("clocks", s->exchange, s->events);
    return *s = *fresh, free(fresh), fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }

static void plan(It *s) { /* the next tick, after one now */
    int k = (int)s->v[KIND];
    s->due = s->v[TIME] + s->v[INTERVAL] * (k == CHANGING || k == COUNTDOWN ? s->v[TICKS] : 1), s->changed = 1;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 d, fmi3Float64 start, fmi3Boolean e, fmi3Float64 f) {
    (void)a, (void)d, (void)e, (void)f;
    It *s = c;
    if (s->mode != INSTANTIATED) return fmi3Error;
    s->v[TIME] = start, s->mode = INITIALIZATION, s->changed = 1;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    It *s = c;
    if (s->mode != INITIALIZATION) return fmi3Error;
    int k = (int)s->v[KIND];
    s->due = s->v[TIME] + (k == FIXED ? 0.05 : k == FROM_PARAMETERS ? s->v[INTERVAL] / 2 : k == COUNTDOWN ? s->v[INTERVAL] : 0);
    s->mode = s->events ? EVENT : STEP; /* without event mode no clock ticks */
    if (!s->events) s->due = INFINITY;
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    It *s = c;
    if (!s->events || s->mode != (s->exchange ? CONTINUOUS : STEP)) return fmi3Error;
    s->mode = EVENT;
    return fmi3OK;
}
static fmi3Status leave(It *s, int mode) {
    if (s->mode != EVENT || s->every || s->go || s->out) return fmi3Error; /* an update is wanted first */
    s->mode = mode;
    return fmi3OK;
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return ((It *)c)->exchange ? fmi3Error : leave(c, STEP); }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return ((It *)c)->exchange ? leave(c, CONTINUOUS) : fmi3Error; }

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]) {
    It *s = c;
    if (s->mode != EVENT) return fmi3Error;
    for (size_t i = 0; i < n; i++) {
        if ((vr[i] != EVERY && vr[i] != GO) || !value[i]) return fmi3Error;
        if (vr[i] == EVERY && fabs(s->v[TIME] - s->due) > 1e-9) return fmi3Error; /* not now */
        if (vr[i] == EVERY) s->every = 1; else s->go = 1;
    }
    int each = (int)s->v[EACH];
    s->out = s->go || (s->every && each && ((int)s->v[TICKS] + 1) % each == 0);
    return fmi3OK;
}
fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock value[]) {
    It *s = c;
    if (s->mode != EVENT || n != 1 || vr[0] != OUT) return fmi3Error;
    value[0] = s->out;
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    It *s = c;
    if (s->mode != EVENT) return fmi3Error;
    if (s->every) s->v[TICKS] += 1, s->v[HELD] = s->v[V], s->v[LAST] = s->v[TIME], plan(s);
    if (s->go) s->v[GOES] += 1, s->v[SUM] += s->v[U], s->v[LAST] = s->v[TIME];
    *more = s->every || s->go;
    s->every = s->go = s->out = 0;
    *ends = *nominals = *values = *defined = false, *next = 0;
    return fmi3OK;
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 interval[],
                                  fmi3IntervalQualifier qualifier[]) {
    It *s = c;
    int k = (int)s->v[KIND];
    if (s->mode != (k == FROM_PARAMETERS ? INITIALIZATION : EVENT) || n != 1 || vr[0] != EVERY || k <= FIXED) return fmi3Error;
    if (!s->changed) return qualifier[0] = fmi3IntervalUnchanged, fmi3OK;
    interval[0] = s->v[INTERVAL] * ((k == CHANGING || k == COUNTDOWN) && s->v[TICKS] > 0 ? s->v[TICKS] : 1);
    qualifier[0] = fmi3IntervalChanged, s->changed = 0;
    return fmi3OK;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 shift[]) {
    It *s = c;
    if (s->mode != INITIALIZATION || n != 1 || vr[0] != EVERY || s->v[KIND] != FROM_PARAMETERS) return fmi3Error;
    return shift[0] = s->v[INTERVAL] / 2, fmi3OK;
}
static void retime(It *s, double interval) { /* the interval counts from the last tick on */
    if (s->mode == EVENT) s->due += interval - s->v[INTERVAL], s->changed = 1;
    s->v[INTERVAL] = interval;
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 interval[]) {
    It *s = c;
    int k = (int)s->v[KIND], now = s->mode == INITIALIZATION || (s->mode == EVENT && k == TUNABLE);
    if (!now || n != 1 || vr[0] != EVERY || (k != FIXED && k != TUNABLE) || interval[0] <= 0) return fmi3Error;
    return retime(s, interval[0]), fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    It *s = c;
    *event = *ends = *early = false, *reached = t + h;
    if (s->mode != STEP || h <= 0 || fabs(t - s->v[TIME]) > 1e-9 || t + h > s->due + 1e-9) return fmi3Error;
    s->v[X] += h * s->v[HELD], s->v[TIME] = t + h;
    return fmi3OK;
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) {
    It *s = c;
    if (s->mode != CONTINUOUS || t > s->due + 1e-9) return fmi3Error;
    return s->v[TIME] = t, fmi3OK;
}
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    return n == 1 ? ((It *)c)->v[X] = x[0], fmi3OK : fmi3Error;
}
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { return n == 1 ? x[0] = ((It *)c)->v[X], fmi3OK : fmi3Error; }
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return n == 1 ? x[0] = ((It *)c)->v[HELD], fmi3OK : fmi3Error;
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { return (void)c, n == 1 ? x[0] = 1, fmi3OK : fmi3Error; }
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) { return (void)c, (void)z, n ? fmi3Error : fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { return (void)c, *n = 1, fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { return (void)c, *n = 0, fmi3OK; }
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean a, fmi3Boolean *event, fmi3Boolean *ends) {
    return (void)c, (void)a, *event = *ends = false, fmi3OK;
}

static int may_set(const It *s, fmi3ValueReference vr) {
    if (vr == EACH || vr == KIND) return s->mode < EVENT;
    if (vr == INTERVAL) return s->mode <= EVENT;
    if (vr == PLAIN) return 1;
    if (s->mode < EVENT) return vr != TICKS && vr != GOES && vr != DX; /* start values */
    return s->mode == EVENT && ((vr == V && s->every) || ((vr == U || vr == LETTER) && s->go));
}
static int is_whole(fmi3ValueReference vr) { return vr == TICKS || vr == GOES || vr == EACH || vr == KIND; }
#define ACCESS(Name, type, whole) \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t m) { \
        It *s = c; \
        s->v[DX] = s->v[HELD]; \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= N || n != m || is_whole(vr[i]) != whole) return fmi3Error; \
            value[i] = (type)s->v[vr[i]]; \
        } \
        return fmi3OK; \
    } \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[], size_t m) { \
        It *s = c; \
        for (size_t i = 0; i < n; i++) { \
            if (n != m || is_whole(vr[i]) != whole || !may_set(s, vr[i])) return fmi3Error; \
            if (vr[i] == INTERVAL && s->v[KIND] == TUNABLE) retime(s, (double)value[i]); \
            s->v[vr[i]] = (double)value[i]; \
        } \
        return fmi3OK; \
    }
ACCESS(Float64, fmi3Float64, 0)
ACCESS(Int32, fmi3Int32, 1)

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary value[], size_t m) {
    It *s = c;
    if (n != 1 || m != 1 || vr[0] != LETTER || sizes[0] > 60 || !may_set(s, LETTER)) return fmi3Error;
    s->size = sizes[0];
    memcpy(s->letter, value[0], sizes[0]);
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary value[], size_t m) {
    It *s = c;
    if (n != 1 || m != 1 || vr[0] != ANSWER) return fmi3Error;
    for (size_t i = 0; i < s->size; i++) s->answer[i] = s->letter[s->size - 1 - i];
    s->answer[s->size] = (unsigned char)('0' + s->v[GOES]);
    sizes[0] = s->size + 1, value[0] = s->answer;
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    if (!*state) *state = malloc(sizeof(It));
    memcpy(*state, c, sizeof(It));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return memcpy(c, state, sizeof(It)), fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return (void)c, free(*state), *state = NULL, fmi3OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    return (void)c, (void)state, *size = sizeof(It), fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte data[], size_t size) {
    return (void)c, memcpy(data, state, size), fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte data[], size_t size, fmi3FMUState *state) {
    (void)c;
    *state = malloc(size);
    return memcpy(*state, data, size), fmi3OK;
}
