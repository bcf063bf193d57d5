/* The interface of FMI 3.0: what both kinds share, and Co-Simulation with intermediate update. Model Exchange stands in
   fmi3_exchange.c. */

#include "core.h"
#include "fmi3Functions.h"

#undef ANY
#undef RUNNING
#undef CHECK
#undef NONE
#define ANY (INSTANTIATED | INITIALIZATION | STEP | EVENT | CONTINUOUS | INTERMEDIATE | TERMINATED | FAILED)
#define SETTLED (ANY & ~INTERMEDIATE)
#define RUNNING (INITIALIZATION | STEP | EVENT | CONTINUOUS | TERMINATED | FAILED)
#define CHECK(modes) \
    Instance *m = instance; \
    if (!m) return fmi3Error; \
    if (!allowed(m, __func__, modes)) return fmi3Error

const char *fmi3GetVersion(void) { return fmi3Version; }

static void log_fmi3(Instance *m, Status status, const char *category, const char *text) {
    ((fmi3LogMessageCallback)m->callbacks)(m->environment, (fmi3Status)status, category, text);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String category[]) {
    CHECK(ANY);
    m->log_categories = 0;
    return (fmi3Status)choose_categories(m, on, n, category);
}

static Instance *instantiate(fmi3String name, fmi3String token, int log, void *environment, fmi3LogMessageCallback callback) {
    if (!name || !token || strcmp(token, TOKEN) != 0) {
        if (callback)
            callback(environment, fmi3Error, "logStatusError",
                     "name and instantiationToken must be given, the token as in modelDescription.xml");
        return NULL;
    }
    Instance *m = calloc(1, sizeof *m);
    if (!m || !(m->name = copy_of(name))) {
        free(m);
        return NULL;
    }
    m->environment = environment;
    m->callbacks = (const void *)callback;
    m->log = callback ? log_fmi3 : NULL;
    m->log_categories = log ? LOG_ALL : 0;
    to_start(m);
    return m;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean log, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback callback) {
    (void)resources, (void)visible;
    return instantiate(name, token, log, environment, callback);
}

/* ---- intermediate update ------------------------------------------------------------------------------------------- */

static int ask_importer(Instance *m, double time, int finished) {
    fmi3Boolean requested = fmi3False;
    fmi3Float64 until = time;
    int64_t mode = m->s.mode;
    m->s.mode = INTERMEDIATE;
    m->set_allowed = !finished;
    m->get_allowed = finished;
    ((fmi3IntermediateUpdateCallback)m->intermediate_update)(m->environment, time, !finished, finished, finished,
                                                             finished && m->early_return_allowed, &requested, &until);
    m->s.mode = m->s.mode == FAILED ? FAILED : mode;
    return !(finished && m->early_return_allowed && requested);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean log, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
                                         fmi3IntermediateUpdateCallback intermediate_update) {
    (void)resources, (void)visible, (void)event_mode; /* hasEventMode is false */
    for (size_t i = 0; i < n_required; i++) {
        if (required[i] < N_VARIABLES && INTERMEDIATE_UPDATE(VARIABLES[required[i]].kind)) continue;
        if (callback)
            callback(environment, fmi3Error, "logStatusError",
                     "fmi3InstantiateCoSimulation: a required intermediate variable has no intermediateUpdate");
        return NULL;
    }
    Instance *m = instantiate(name, token, log, environment, callback);
    if (!m) return NULL;
    m->co_simulation = 1;
    m->early_return_allowed = early_return;
    for (size_t i = 0; i < n_required; i++) m->required[required[i]] = 1;
    m->intermediate_update = (void (*)(void))intermediate_update;
    m->ask = intermediate_update && (n_required > 0 || early_return) ? ask_importer : NULL;
    return m;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean log, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback callback, fmi3ClockUpdateCallback clock,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)log, (void)clock, (void)lock, (void)unlock;
    if (callback)
        callback(environment, fmi3Error, "logStatusError", "fmi3InstantiateScheduledExecution: the model has no such interface");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
    Instance *m = instance;
    if (m) free(m->name);
    free(m);
}

/* ---- modes --------------------------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    CHECK(INSTANTIATED);
    (void)tolerance_defined, (void)tolerance; /* error control is a parameter of the FMU, so that a run is reproducible */
    Status status = set_experiment(m, __func__, start, stop_defined, stop);
    if (status == OK) m->s.mode = INITIALIZATION;
    return (fmi3Status)status;
}

#define TRANSITION(name, from, action) \
    fmi3Status name(fmi3Instance instance) { \
        CHECK(from); \
        action; \
        return fmi3OK; \
    }
TRANSITION(fmi3ExitInitializationMode, INITIALIZATION, (to_initialized(m), m->s.mode = m->co_simulation ? STEP : EVENT))
TRANSITION(fmi3EnterEventMode, CONTINUOUS, m->s.mode = EVENT)
TRANSITION(fmi3EnterContinuousTimeMode, EVENT, m->s.mode = CONTINUOUS)
TRANSITION(fmi3Terminate, STEP | EVENT | CONTINUOUS, m->s.mode = TERMINATED)
TRANSITION(fmi3Reset, SETTLED, to_start(m))
TRANSITION(fmi3EvaluateDiscreteStates, INITIALIZATION | EVENT, (void)m)
TRANSITION(fmi3EnterStepMode, 0, (void)m)          /* only with event mode in Co-Simulation */
TRANSITION(fmi3EnterConfigurationMode, 0, (void)m) /* only with structural parameters */
TRANSITION(fmi3ExitConfigurationMode, 0, (void)m)

/* ---- values -------------------------------------------------------------------------------------------------------- */

/* During intermediate update: only the variables that the importer required, and only to be set or only to be read. */
static int open_to_importer(const Instance *m, const fmi3ValueReference vr[], size_t n, int direction) {
    if (m->s.mode != INTERMEDIATE) return 1;
    for (size_t i = 0; i < n; i++)
        if (!direction || vr[i] >= N_VARIABLES || !m->required[vr[i]]) return 0;
    return 1;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t n_value) {
    CHECK(ANY);
    if (n_value != n) return (fmi3Status)fail(m, __func__, "nValues must equal nValueReferences: all variables are scalar");
    if (!open_to_importer(m, vr, n, m->get_allowed)) return (fmi3Status)fail(m, __func__, "not open in intermediate update");
    return (fmi3Status)get(m, __func__, vr, n, value);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[],
                          size_t n_value) {
    CHECK(INSTANTIATED | INITIALIZATION | STEP | EVENT | CONTINUOUS | INTERMEDIATE);
    if (n_value != n) return (fmi3Status)fail(m, __func__, "nValues must equal nValueReferences: all variables are scalar");
    if (!open_to_importer(m, vr, n, m->set_allowed)) return (fmi3Status)fail(m, __func__, "not open in intermediate update");
    return (fmi3Status)set(m, __func__, vr, n, value);
}

/* The model has Float64 variables only, and no clocks. */
#define NONE(name, ...) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) { \
        CHECK(ANY); \
        (void)vr, (void)value; \
        return n == 0 ? fmi3OK : (fmi3Status)fail(m, __func__, "the model has no variable of this type"); \
    }
#define NONE_OF(type) \
    NONE(fmi3Get##type, fmi3##type value[], size_t n_value) \
    NONE(fmi3Set##type, const fmi3##type value[], size_t n_value)
NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF(Int32)
NONE_OF(UInt32)
NONE_OF(Int64)
NONE_OF(UInt64)
NONE_OF(Boolean)
NONE_OF(String)
NONE(fmi3GetBinary, size_t size[], fmi3Binary value[], size_t n_value)
NONE(fmi3SetBinary, const size_t size[], const fmi3Binary value[], size_t n_value)
NONE(fmi3GetClock, fmi3Clock value[])
NONE(fmi3SetClock, const fmi3Clock value[])
NONE(fmi3GetIntervalDecimal, fmi3Float64 value[], fmi3IntervalQualifier qualifier[])
NONE(fmi3GetIntervalFraction, fmi3UInt64 value[], fmi3UInt64 resolution[], fmi3IntervalQualifier qualifier[])
NONE(fmi3GetShiftDecimal, fmi3Float64 value[])
NONE(fmi3GetShiftFraction, fmi3UInt64 value[], fmi3UInt64 resolution[])
NONE(fmi3SetIntervalDecimal, const fmi3Float64 value[])
NONE(fmi3SetIntervalFraction, const fmi3UInt64 value[], const fmi3UInt64 resolution[])
NONE(fmi3SetShiftDecimal, const fmi3Float64 value[])
NONE(fmi3SetShiftFraction, const fmi3UInt64 value[], const fmi3UInt64 resolution[])

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t *n) {
    CHECK(SETTLED);
    (void)vr, (void)n;
    return (fmi3Status)fail(m, __func__, "dependencies stand in modelDescription.xml");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t element[],
                                       fmi3ValueReference independent[], size_t independent_element[],
                                       fmi3DependencyKind kind[], size_t n) {
    CHECK(SETTLED);
    (void)vr, (void)element, (void)independent, (void)independent_element, (void)kind, (void)n;
    return (fmi3Status)fail(m, __func__, "dependencies stand in modelDescription.xml");
}

#define SENSITIVITY(name, n_in, n_out, adjoint) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown, \
                    const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed, \
                    fmi3Float64 value[], size_t n_value) { \
        CHECK(RUNNING); \
        if (n_seed != n_in || n_value != n_out) return (fmi3Status)fail(m, __func__, "wrong number of seeds or sensitivities"); \
        return (fmi3Status)sensitivity(m, __func__, unknown, n_unknown, known, n_known, seed, value, adjoint); \
    }
SENSITIVITY(fmi3GetDirectionalDerivative, n_known, n_unknown, 0)
SENSITIVITY(fmi3GetAdjointDerivative, n_unknown, n_known, 1)

/* ---- the whole state ----------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    CHECK(SETTLED);
    if (!state) return (fmi3Status)fail(m, __func__, "no place for the state");
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return (fmi3Status)fail(m, __func__, "out of memory");
    memcpy(*state, &m->s, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    CHECK(SETTLED);
    if (!state || !fits(state)) return (fmi3Status)fail(m, __func__, "this is no state of this model");
    restore(m, state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    CHECK(SETTLED);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    CHECK(SETTLED);
    (void)state;
    *size = sizeof(State);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    CHECK(SETTLED);
    if (!state || size < sizeof(State)) return (fmi3Status)fail(m, __func__, "too few bytes for the state");
    memcpy(bytes, state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    CHECK(SETTLED);
    if (size != sizeof(State) || !fits(bytes)) return (fmi3Status)fail(m, __func__, "these bytes are no state of this model");
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return (fmi3Status)fail(m, __func__, "out of memory");
    memcpy(*state, bytes, sizeof(State));
    return fmi3OK;
}

/* ---- Co-Simulation ------------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Int32 order[],
                                    fmi3Float64 value[], size_t n_value) {
    CHECK(STEP | INTERMEDIATE | TERMINATED | FAILED);
    if (n_value != n) return (fmi3Status)fail(m, __func__, "nValues must equal nValueReferences: all variables are scalar");
    if (!open_to_importer(m, vr, n, m->get_allowed)) return (fmi3Status)fail(m, __func__, "not open in intermediate update");
    return (fmi3Status)output_derivatives(m, __func__, vr, n, order, value);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    CHECK(STEP);
    (void)no_set_state;
    *event = *terminate = *early = fmi3False;
    *reached = m->s.time;
    Status status = do_step(m, __func__, t, h);
    *reached = m->last_successful;
    *early = status == OK && m->returned_early;
    return (fmi3Status)status;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
    CHECK(0); /* Scheduled Execution only */
    (void)clock, (void)time;
    return fmi3OK;
}
