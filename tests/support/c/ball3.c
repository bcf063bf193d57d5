/* An FMI 3.0 ball that bounces: flight by its formula, impacts at their own time, v -> -e v at each. It keeps to the letter of
   event mode: impacts are returned early where that is allowed, ticks (every `period` s) are announced and must not be
   passed, both want two updates, and the discrete input kick (v += change of kick) may change in event mode only.
   Without event mode it does all that by itself. It wants the run to end after `last` impacts; with `restless` updates never end,
   with `stubborn` an impact is reported again and again. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { TIME, H, V, E, PERIOD, LAST, RESTLESS, STUBBORN, KICK, IMPACTS, TICKS, N };
enum { INSTANTIATED, INITIALIZATION, EVENT, STEP };

typedef struct {
    double v[N], kicked;
    int mode, events, early, impact, rounds;
} Ball;

static const double G = 9.81;

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n_required, (void)environment, (void)log;
    (void)update;
    if (strcmp(token, "ball")) return NULL;
#ifdef REFUSES /* the event mode that its description has */
    if (events) return NULL;
#endif
    Ball *b = calloc(1, sizeof *b);
    b->v[H] = 1.0, b->v[E] = 0.7, b->events = events, b->early = early;
    return b;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 d, fmi3Float64 start, fmi3Boolean e, fmi3Float64 f) {
    (void)a, (void)d, (void)e, (void)f;
    Ball *b = c;
    if (b->mode != INSTANTIATED) return fmi3Error;
    b->v[TIME] = start, b->mode = INITIALIZATION;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    Ball *b = c;
    if (b->mode != INITIALIZATION) return fmi3Error;
    b->mode = b->events ? EVENT : STEP;
    b->kicked = b->v[KICK];
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) { return ((Ball *)c)->mode >= EVENT ? fmi3OK : fmi3Error; }

static double flight(const Ball *b) { /* until the next impact, s */
    return (b->v[V] + sqrt(b->v[V] * b->v[V] + 2 * G * b->v[H])) / G;
}
static double due(const Ball *b) { return b->v[PERIOD] > 0 ? (b->v[TICKS] + 1) * b->v[PERIOD] : INFINITY; }
static void fly(Ball *b, double s) {
    b->v[H] += s * (b->v[V] - G * s / 2), b->v[V] -= G * s, b->v[TIME] += s;
}
static void happen(Ball *b) { /* what an event does */
    if (b->impact && !b->v[STUBBORN]) b->v[H] = 0.0, b->v[V] *= -b->v[E], b->v[IMPACTS] += 1, b->impact = 0;
    if (b->v[TIME] >= due(b) - 1e-12) b->v[TICKS] += 1;
    b->v[V] += b->v[KICK] - b->kicked, b->kicked = b->v[KICK];
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    Ball *b = c;
    if (b->mode != STEP || !b->events) return fmi3Error;
    b->mode = EVENT, b->rounds = 0;
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    Ball *b = c;
    if (b->mode != EVENT) return fmi3Error;
    happen(b);
    b->rounds++;
    *more = b->v[RESTLESS] || b->rounds < 2;
    *terminate = b->v[LAST] && b->v[IMPACTS] >= b->v[LAST];
    *nominals = *values = true; /* nonsense in Co-Simulation, to be ignored */
    *defined = isfinite(due(b)), *next = due(b);
    return fmi3OK;
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    Ball *b = c;
    if (b->mode != EVENT || b->rounds < (b->v[LAST] && b->v[IMPACTS] >= b->v[LAST] ? 1 : 2)) return fmi3Error;
    b->mode = STEP;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    Ball *b = c;
    *event = *terminate = *early = false;
    if (b->mode != STEP || h <= 0 || fabs(t - b->v[TIME]) > 1e-9) return fmi3Error;
    if (b->events && t + h > due(b) + 1e-9) return fmi3Error; /* past the time that it had announced */
    b->v[TIME] = t;
    if (!b->events) happen(b); /* a kick */
    double end = t + h;
    while (b->v[TIME] < end) {
        double left = end - b->v[TIME], impact = flight(b), tick = b->events ? INFINITY : due(b) - b->v[TIME];
        double part = fmin(left, fmin(impact, tick));
        fly(b, part);
        if (part == left) b->v[TIME] = end;
        if (part == impact) b->impact = 1;
        if (b->impact && b->events) {
            if (!b->early) return fmi3Error;
            *event = *early = true, *reached = b->v[TIME];
            return fmi3OK;
        }
        if (part == impact || part == tick) happen(b);
    }
    *reached = b->v[TIME];
    return fmi3OK;
}

#define ACCESS(Name, type, numbers) \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t m) { \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= N || n != m || numbers != (vr[i] < LAST)) return fmi3Error; \
            value[i] = (type)((Ball *)c)->v[vr[i]]; \
        } \
        return fmi3OK; \
    } \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[], size_t m) { \
        Ball *b = c; \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] > KICK || n != m || numbers != (vr[i] < LAST)) return fmi3Error; \
            if (b->mode >= EVENT && vr[i] != KICK) return fmi3Error; \
            if (b->mode == STEP && b->events && b->v[KICK] != (double)value[i]) return fmi3Error; \
            b->v[vr[i]] = (double)value[i]; \
        } \
        return fmi3OK; \
    }
ACCESS(Float64, fmi3Float64, 1)
ACCESS(Int32, fmi3Int32, 0)

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    if (!*state) *state = malloc(sizeof(Ball));
    memcpy(*state, c, sizeof(Ball));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return memcpy(c, state, sizeof(Ball)), fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return (void)c, free(*state), *state = NULL, fmi3OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    return (void)c, (void)state, *size = sizeof(Ball), fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte data[], size_t size) {
    return (void)c, memcpy(data, state, size), fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte data[], size_t size, fmi3FMUState *state) {
    (void)c;
    *state = malloc(size);
    return memcpy(*state, data, size), fmi3OK;
}
