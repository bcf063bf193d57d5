/* The interface of FMI 2.0: what both kinds share, and Co-Simulation. Model Exchange stands in fmi2_exchange.c. */

#include "core.h"
#include "fmi2Functions.h"

#define ANY (INSTANTIATED | INITIALIZATION | STEP | STEP_FAILED | EVENT | CONTINUOUS | TERMINATED | FAILED)
#define RUNNING (INITIALIZATION | STEP | STEP_FAILED | EVENT | CONTINUOUS | TERMINATED | FAILED)
#define CHECK(modes) \
    Instance *m = c; \
    if (!m) return fmi2Error; \
    if (!allowed(m, __func__, modes)) return fmi2Error

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void log_fmi2(Instance *m, Status status, const char *category, const char *text) {
    const fmi2CallbackFunctions *callbacks = m->callbacks;
    /* the text is the format: it holds no per cent sign, and importers not written in C cannot format */
    callbacks->logger(callbacks->componentEnvironment, m->name, (fmi2Status)status, category, text);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String category[]) {
    CHECK(ANY);
    m->log_categories = LOG_ERROR; /* errors are always logged */
    return (fmi2Status)choose_categories(m, on, n, category);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)resources, (void)visible;
    if (!callbacks || !name || !guid || strcmp(guid, TOKEN) != 0) {
        if (callbacks && callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name ? name : "", fmi2Error, "logStatusError",
                              "fmi2Instantiate: name and guid must be given, the guid as in modelDescription.xml");
        return NULL;
    }
    Instance *m = calloc(1, sizeof *m);
    if (!m || !(m->name = copy_of(name))) {
        free(m);
        return NULL;
    }
    m->co_simulation = type == fmi2CoSimulation;
    m->callbacks = callbacks;
    m->log = callbacks->logger ? log_fmi2 : NULL;
    m->log_categories = log ? LOG_ALL : LOG_ERROR;
    to_start(m);
    return m;
}

void fmi2FreeInstance(fmi2Component c) {
    Instance *m = c;
    if (m) free(m->name);
    free(m);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop) {
    CHECK(INSTANTIATED);
    (void)tolerance_defined, (void)tolerance; /* error control is a parameter of the FMU, so that a run is reproducible */
    return (fmi2Status)set_experiment(m, __func__, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    CHECK(INSTANTIATED);
    m->s.mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    CHECK(INITIALIZATION);
    to_initialized(m);
    m->s.mode = m->co_simulation ? STEP : EVENT;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    CHECK(STEP | STEP_FAILED | EVENT | CONTINUOUS);
    m->s.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    CHECK(ANY);
    to_start(m);
    return fmi2OK;
}

/* ---- values -------------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    CHECK(RUNNING);
    Status status = get(m, __func__, vr, n, value);
    /* Co-Simulation knows no fmi2Discard here */
    return status == DISCARD && m->co_simulation ? fmi2Warning : (fmi2Status)status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    CHECK(INSTANTIATED | INITIALIZATION | STEP | EVENT | CONTINUOUS);
    return (fmi2Status)set(m, __func__, vr, n, value);
}

/* The model has real variables only. */
#define NONE(name, type) \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
        CHECK(ANY); \
        (void)vr, (void)value; \
        return n == 0 ? fmi2OK : (fmi2Status)fail(m, __func__, "the model has real variables only"); \
    }
NONE(fmi2GetInteger, fmi2Integer)
NONE(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2GetString, fmi2String)
NONE(fmi2SetInteger, const fmi2Integer)
NONE(fmi2SetBoolean, const fmi2Boolean)
NONE(fmi2SetString, const fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real value[]) {
    CHECK(RUNNING);
    return (fmi2Status)sensitivity(m, __func__, unknown, n_unknown, known, n_known, seed, value, 0);
}

/* ---- the whole state ----------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CHECK(ANY);
    if (!state) return (fmi2Status)fail(m, __func__, "no place for the state");
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return (fmi2Status)fail(m, __func__, "out of memory");
    memcpy(*state, &m->s, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    CHECK(ANY);
    if (!state || !fits(state)) return (fmi2Status)fail(m, __func__, "this is no state of this model");
    restore(m, state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CHECK(ANY);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    CHECK(ANY);
    (void)state;
    *size = sizeof(State);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    CHECK(ANY);
    if (!state || size < sizeof(State)) return (fmi2Status)fail(m, __func__, "too few bytes for the state");
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    CHECK(ANY);
    if (size != sizeof(State) || !fits(bytes)) return (fmi2Status)fail(m, __func__, "these bytes are no state of this model");
    if (!*state) *state = malloc(sizeof(State));
    if (!*state) return (fmi2Status)fail(m, __func__, "out of memory");
    memcpy(*state, bytes, sizeof(State));
    return fmi2OK;
}

/* ---- Co-Simulation ------------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    CHECK(INSTANTIATED | INITIALIZATION | STEP);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N_VARIABLES || VARIABLES[vr[i]].kind != INPUT) return (fmi2Status)fail(m, __func__, "the variable is no input");
        if (order[i] < 1) return (fmi2Status)fail(m, __func__, "order must be at least 1");
        if (order[i] > 2) return (fmi2Status)fail(m, __func__, "order must be at most 2");
        if (!isfinite(value[i])) return (fmi2Status)discard(m, __func__, "value must be finite: ", VARIABLES[vr[i]].name);
    }
    for (size_t i = 0; i < n; i++) {
        int at = VARIABLES[vr[i]].index + order[i] * N_U;
        m->s.U[at] = m->s.u_now[at] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[]) {
    CHECK(STEP | STEP_FAILED | TERMINATED | FAILED);
    return (fmi2Status)output_derivatives(m, __func__, vr, n, order, value);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    CHECK(STEP);
    (void)no_set_state;
    if (!m->co_simulation) return (fmi2Status)fail(m, __func__, "the instance is for Model Exchange");
    Status status = do_step(m, __func__, t, h);
    if (status == DISCARD) m->s.mode = STEP_FAILED;
    return (fmi2Status)status;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    CHECK(0); /* no step is ever in progress */
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    if (kind != fmi2DoStepStatus) return fmi2Discard;
    *value = m->s.mode == STEP_FAILED ? fmi2Discard : fmi2OK;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = m->last_successful;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    if (kind != fmi2PendingStatus) return fmi2Discard;
    *value = "";
    return fmi2OK;
}
