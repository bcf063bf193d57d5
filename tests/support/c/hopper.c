/* An FMU of FMI 2.0 and 3.0 for Model Exchange, strict about the order of calls: a ball that flies and bounces,

       h' = v,  v' = u - 9.81,  speck' = -speck,

   with every kind of event: impacts (h = 0: v -> -e v, and speck, with its nominal value, shrinks by 1e-6), ticks every `period` s
   that are announced, step events after every `every`-th step of the integrator (nudges), a discrete input (v += change of kick),
   and `above`, which follows u > 0.5 in event mode only. Event mode wants two updates. It wants the run to end after `last`
   impacts. Faults, from 0.2 s on: 1 error and 2 discard of the derivatives, 3 NaN; 4 updates never end; 5 a tick is always
   due; 6 completedIntegratorStep wants the end; 7 derivatives are discarded below h = 0.5, where it never may be. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

enum { TIME, H, V, SPECK, DH, DV, DSPECK, U, E, PERIOD, LAST, EVERY, FAULT, KICK, IMPACTS, TICKS, NUDGES, ABOVE, N };
enum { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS };
enum { OK, WARNING, DISCARD, ERROR };

typedef struct {
    double v[N], kicked, told;
    int mode, rounds, steps, nudge;
    const fmi2CallbackFunctions *two;
    fmi3LogMessageCallback three;
    void *environment;
} Hopper;

static Hopper *instantiate(const char *token) {
    if (strcmp(token, "hopper")) return NULL;
    Hopper *b = calloc(1, sizeof *b);
    b->v[H] = 1.0, b->v[SPECK] = 1e-6, b->v[E] = 0.7, b->told = NAN;
    return b;
}
static int says(Hopper *b, int status, const char *words) {
    if (b->two) b->two->logger(b->environment, "hopper", (fmi2Status)status, "logStatusError", "%s", words);
    if (b->three) b->three(b->environment, (fmi3Status)status, "logStatusError", words);
    return status;
}
static int faulty(const Hopper *b, int fault) { return b->v[FAULT] == fault && b->v[TIME] >= 0.2; }
static double due(const Hopper *b) {
    return faulty(b, 5) ? b->v[TIME] : b->v[PERIOD] > 0 ? (b->v[TICKS] + 1) * b->v[PERIOD] : INFINITY;
}
static double scale(const Hopper *b) { return pow(1e-6, 1 + b->v[IMPACTS]); }

static int enter(Hopper *b, double start) {
    if (b->mode != INSTANTIATED) return says(b, ERROR, "initialization comes first");
    b->v[TIME] = start, b->mode = INITIALIZATION;
    return OK;
}
static int leave(Hopper *b) {
    if (b->mode != INITIALIZATION) return says(b, ERROR, "it is not in initialization mode");
    b->mode = EVENT, b->rounds = 0, b->kicked = b->v[KICK];
    return OK;
}
static int set_time(Hopper *b, double t) {
    if (b->mode != CONTINUOUS) return says(b, ERROR, "time passes in continuous-time mode only");
    b->v[TIME] = t;
    return OK;
}
static int set_states(Hopper *b, const double x[], size_t n) {
    if (b->mode != CONTINUOUS || n != 3) return says(b, ERROR, "three states are set in continuous-time mode");
    memcpy(b->v + H, x, 3 * sizeof *x);
    return OK;
}
static int get_states(Hopper *b, double x[], size_t n) {
    if (b->mode < EVENT || n != 3) return says(b, ERROR, "there are three states");
    memcpy(x, b->v + H, 3 * sizeof *x);
    return OK;
}
static int rates(Hopper *b, double dx[], size_t n) {
    if (b->mode != CONTINUOUS || n != 3) return says(b, ERROR, "there are three derivatives, in continuous-time mode");
    if (faulty(b, 1)) return says(b, ERROR, "the air is too thin");
    if (faulty(b, 2) || (b->v[FAULT] == 7 && b->v[H] < 0.5)) return DISCARD;
    dx[0] = b->v[V], dx[1] = faulty(b, 3) ? NAN : b->v[U] - 9.81, dx[2] = -b->v[SPECK];
    return OK;
}
static int indicators(Hopper *b, double z[], size_t n) {
    if (b->mode < EVENT || n != 2) return says(b, ERROR, "there are two event indicators");
    z[0] = b->v[H], z[1] = b->v[U] - 0.5;
    return OK;
}
static int nominals(Hopper *b, double x[], size_t n) {
    if (b->mode < EVENT || n != 3) return says(b, ERROR, "there are three nominal values");
    x[0] = x[1] = 1.0, x[2] = scale(b);
    return OK;
}
static int completed(Hopper *b, int *event, int *ends) {
    if (b->mode != CONTINUOUS) return says(b, ERROR, "steps are completed in continuous-time mode");
    if (b->v[TIME] > due(b)) return says(b, ERROR, "a tick was passed");
    b->told = b->v[TIME], b->steps++;
    b->nudge = b->v[EVERY] > 0 && b->steps % (int)b->v[EVERY] == 0;
    *event = b->nudge, *ends = faulty(b, 6);
    return OK;
}
static int enter_event(Hopper *b) {
    if (b->mode != CONTINUOUS) return says(b, ERROR, "events come in continuous-time mode");
    b->mode = EVENT, b->rounds = 0;
    return OK;
}
static int update(Hopper *b, int *more, int *ends, int *new_nominals, int *values, int *defined, double *next) {
    if (b->mode != EVENT) return says(b, ERROR, "updates are in event mode");
    *new_nominals = *values = 0;
    if (b->v[H] <= 0 && b->v[V] < 0) {
        b->v[IMPACTS] += 1, b->v[SPECK] *= 1e-6, *new_nominals = *values = 1;
        b->v[H] = 0.0, b->v[V] *= -b->v[E];
    }
    if (b->v[TIME] == due(b) || b->v[TIME] > due(b) + 1e-6) b->v[TICKS] += 1; /* to the last bit, or overdue */
    if (b->nudge) b->v[NUDGES] += 1, b->nudge = 0;
    if (b->v[KICK] != b->kicked) b->v[V] += b->v[KICK] - b->kicked, b->kicked = b->v[KICK], *values = 1;
    b->v[ABOVE] = b->v[U] > 0.5;
    *more = faulty(b, 4) || ++b->rounds < 2;
    *ends = b->v[LAST] && b->v[IMPACTS] >= b->v[LAST];
    *defined = isfinite(due(b)), *next = due(b);
    return OK;
}
static int go_on(Hopper *b) {
    if (b->mode != EVENT || b->rounds < 2) return says(b, ERROR, "event mode wants two updates");
    b->mode = CONTINUOUS;
    return OK;
}
static int get(Hopper *b, const unsigned vr[], size_t n, double value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N) return says(b, ERROR, "there is no such variable");
        b->v[DH] = b->v[V], b->v[DV] = b->v[U] - 9.81, b->v[DSPECK] = -b->v[SPECK];
        value[i] = b->v[vr[i]];
    }
    return OK;
}
static int set(Hopper *b, const unsigned vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        int now = vr[i] == U ? 1 : vr[i] == KICK ? b->mode != CONTINUOUS : b->mode == INSTANTIATED;
        if (vr[i] >= IMPACTS || !now) return says(b, ERROR, "this cannot be set now");
        b->v[vr[i]] = value[i];
    }
    return OK;
}

/* FMI 2.0 */
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)resources, (void)visible, (void)logging;
    Hopper *b = type == fmi2ModelExchange ? instantiate(guid) : NULL;
    if (b) b->two = functions, b->environment = functions->componentEnvironment;
    return b;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real d, fmi2Real start, fmi2Boolean e, fmi2Real f) {
    (void)a, (void)d, (void)e, (void)f;
    return ((Hopper *)c)->v[TIME] = start, fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (fmi2Status)enter(c, ((Hopper *)c)->v[TIME]); }
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Hopper));
    return memcpy(*state, c, sizeof(Hopper)), fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { return memcpy(c, state, sizeof(Hopper)), fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { return (void)c, free(*state), *state = NULL, fmi2OK; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    return (fmi2Status)update(c, &info->newDiscreteStatesNeeded, &info->terminateSimulation,
                              &info->nominalsOfContinuousStatesChanged, &info->valuesOfContinuousStatesChanged,
                              &info->nextEventTimeDefined, &info->nextEventTime);
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set, fmi2Boolean *event, fmi2Boolean *ends) {
    return (void)no_set, (fmi2Status)completed(c, event, ends);
}
#define ACCESS2(Name, type) \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
        int status = OK; \
        for (size_t i = 0; i < n; i++) { \
            double v = 0.0; \
            status |= get(c, vr + i, 1, &v), value[i] = (type)v; \
        } \
        return (fmi2Status)status; \
    } \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) { \
        int status = OK; \
        for (size_t i = 0; i < n; i++) { \
            double v = (double)value[i]; \
            status |= set(c, vr + i, 1, &v); \
        } \
        return (fmi2Status)status; \
    }
ACCESS2(Real, fmi2Real)
ACCESS2(Integer, fmi2Integer)

/* FMI 3.0 */
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    (void)name, (void)resources, (void)visible, (void)logging;
    Hopper *b = instantiate(token);
    if (b) b->three = log, b->environment = environment;
    return b;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 d, fmi3Float64 start, fmi3Boolean e, fmi3Float64 f) {
    (void)a, (void)d, (void)e, (void)f;
    return (fmi3Status)enter(c, start);
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2GetFMUstate(c, state); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return (fmi3Status)fmi2SetFMUstate(c, state); }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2FreeFMUstate(c, state); }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { return (void)c, *n = 3, fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { return (void)c, *n = 2, fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *ends, fmi3Boolean *new_nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    int told[5];
    int status = update(c, told, told + 1, told + 2, told + 3, told + 4, next);
    *more = told[0], *ends = told[1], *new_nominals = told[2], *values = told[3], *defined = told[4];
    return (fmi3Status)status;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set, fmi3Boolean *event, fmi3Boolean *ends) {
    int told[2];
    int status = completed(c, told, told + 1);
    return (void)no_set, *event = told[0], *ends = told[1], (fmi3Status)status;
}
#define ACCESS3(Name, type) \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t m) { \
        int status = n == m ? OK : ERROR; \
        for (size_t i = 0; i < n; i++) { \
            double v = 0.0; \
            status |= get(c, vr + i, 1, &v), value[i] = (type)v; \
        } \
        return (fmi3Status)status; \
    } \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[], size_t m) { \
        int status = n == m ? OK : ERROR; \
        for (size_t i = 0; i < n; i++) { \
            double v = (double)value[i]; \
            status |= set(c, vr + i, 1, &v); \
        } \
        return (fmi3Status)status; \
    }
ACCESS3(Float64, fmi3Float64)
ACCESS3(Int32, fmi3Int32)

#define BOTH(Two, Three, types, ...) \
    fmi2Status fmi2##Two types { return (fmi2Status)__VA_ARGS__; } \
    fmi3Status fmi3##Three types { return (fmi3Status)__VA_ARGS__; }
BOTH(ExitInitializationMode, ExitInitializationMode, (void *c), leave(c))
BOTH(Terminate, Terminate, (void *c), (((Hopper *)c)->mode >= EVENT ? OK : ERROR))
BOTH(SetTime, SetTime, (void *c, double t), set_time(c, t))
BOTH(SetContinuousStates, SetContinuousStates, (void *c, const double x[], size_t n), set_states(c, x, n))
BOTH(GetContinuousStates, GetContinuousStates, (void *c, double x[], size_t n), get_states(c, x, n))
BOTH(GetDerivatives, GetContinuousStateDerivatives, (void *c, double dx[], size_t n), rates(c, dx, n))
BOTH(GetEventIndicators, GetEventIndicators, (void *c, double z[], size_t n), indicators(c, z, n))
BOTH(GetNominalsOfContinuousStates, GetNominalsOfContinuousStates, (void *c, double x[], size_t n), nominals(c, x, n))
BOTH(EnterEventMode, EnterEventMode, (void *c), enter_event(c))
BOTH(EnterContinuousTimeMode, EnterContinuousTimeMode, (void *c), go_on(c))
