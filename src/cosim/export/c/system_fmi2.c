/* The interface of FMI 2.0. */

#include "system.h"
#include "fmi2Functions.h"

#define ANY (INSTANTIATED | INITIALIZATION | STEP | STEP_FAILED | TERMINATED | FAILED)
#define RUNNING (INITIALIZATION | STEP | STEP_FAILED | TERMINATED | FAILED)
#define CHECK(modes) \
    System *m = c; \
    if (!m) return fmi2Error; \
    if (!allowed(m, __func__, modes)) return fmi2Error

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void log_fmi2(System *m, Status status, const char *category, const char *text) {
    const fmi2CallbackFunctions *callbacks = m->callbacks;
    callbacks->logger(callbacks->componentEnvironment, m->name, (fmi2Status)status, category, text);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String category[]) {
    CHECK(ANY);
    m->log_categories = LOG_ERROR; /* errors are always logged */
    return (fmi2Status)choose_categories(m, on, n, category);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log) {
    (void)visible;
    if (!callbacks || !name || !guid || strcmp(guid, TOKEN) != 0 || type != fmi2CoSimulation) {
        if (callbacks && callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name ? name : "", fmi2Error, "logStatusError",
                              "fmi2Instantiate: for Co-Simulation; name and guid must be given, the guid as in "
                              "modelDescription.xml");
        return NULL;
    }
    System *m = make_system(name, resources);
    if (!m) return NULL;
    m->callbacks = callbacks;
    m->log = callbacks->logger ? log_fmi2 : NULL;
    m->log_categories = log ? LOG_ALL : LOG_ERROR;
    if (to_start(m)) return m;
    free_system(m);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) { free_system(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop) {
    CHECK(INSTANTIATED);
    (void)tolerance_defined, (void)tolerance; /* accuracy is a matter of parameters, so that a run is reproducible */
    return (fmi2Status)set_experiment(m, __func__, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    CHECK(INSTANTIATED);
    return (fmi2Status)enter_initialization(m, __func__);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    CHECK(INITIALIZATION);
    Status status = exit_initialization(m, __func__);
    return status == DISCARD ? (fmi2Status)fail(m, __func__, "no consistent start") : (fmi2Status)status;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    CHECK(STEP | STEP_FAILED);
    terminate_components(m);
    m->s.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    CHECK(ANY);
    return to_start(m) ? fmi2OK : fmi2Fatal;
}

/* ---- values -------------------------------------------------------------------------------------------------------- */

#define GETTER(name, of, ctype) \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, ctype value[]) { \
        CHECK(RUNNING); \
        for (size_t i = 0; i < n; i++) { \
            const Variable *v = variable(m, __func__, vr[i], of); \
            double number = 0.0; \
            if (!v) return fmi2Error; \
            Status status = get_one(m, __func__, v, &number); \
            if (status >= ERROR) return (fmi2Status)status; \
            value[i] = (ctype)number; \
        } \
        return fmi2OK; \
    }
GETTER(fmi2GetReal, TYPE_REAL, fmi2Real)
GETTER(fmi2GetInteger, TYPE_INTEGER, fmi2Integer)
GETTER(fmi2GetBoolean, TYPE_BOOLEAN, fmi2Boolean)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    CHECK(RUNNING);
    for (size_t i = 0; i < n; i++) {
        const Variable *v = variable(m, __func__, vr[i], TYPE_STRING);
        if (!v) return fmi2Error;
        Status status = get_text(m, __func__, v, &value[i]);
        if (status != OK) return (fmi2Status)status;
    }
    return fmi2OK;
}

#define SETTER(name, of, ctype, number, string) \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const ctype value[]) { \
        CHECK(INSTANTIATED | INITIALIZATION | STEP); \
        Status status = OK; \
        for (size_t i = 0; i < n && status == OK; i++) { \
            const Variable *v = variable(m, __func__, vr[i], of); \
            if (!v) return fmi2Error; \
            status = may_set(m, __func__, v, number); \
        } \
        for (size_t i = 0; i < n && status == OK; i++) status = set_one(m, __func__, &VARIABLES[vr[i]], number, string); \
        return (fmi2Status)status; \
    }
SETTER(fmi2SetReal, TYPE_REAL, fmi2Real, value[i], NULL)
SETTER(fmi2SetInteger, TYPE_INTEGER, fmi2Integer, (double)value[i], NULL)
SETTER(fmi2SetBoolean, TYPE_BOOLEAN, fmi2Boolean, (double)value[i], NULL)
SETTER(fmi2SetString, TYPE_STRING, fmi2String, 0.0, value[i])

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real value[]) {
    CHECK(RUNNING);
    return (fmi2Status)sensitivity(m, __func__, unknown, n_unknown, known, n_known, seed, value);
}

/* ---- the whole state ----------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CHECK(ANY);
    return (fmi2Status)save(m, __func__, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    CHECK(ANY);
    return (fmi2Status)restore(m, __func__, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    CHECK(ANY);
    discard_state(m, state);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    CHECK(ANY);
    return (fmi2Status)serialized_size(m, __func__, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    CHECK(ANY);
    return (fmi2Status)serialize(m, __func__, state, (unsigned char *)bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    CHECK(ANY);
    return (fmi2Status)deserialize(m, __func__, (const unsigned char *)bytes, size, state);
}

/* ---- Co-Simulation ------------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    CHECK(INSTANTIATED | INITIALIZATION | STEP);
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : (fmi2Status)fail(m, __func__, "inputs are held over a step (canInterpolateInputs is false)");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[]) {
    CHECK(STEP | STEP_FAILED | TERMINATED | FAILED);
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : (fmi2Status)fail(m, __func__, "outputs have no derivatives (maxOutputDerivativeOrder is 0)");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    CHECK(STEP);
    m->no_set_state = no_set_state != 0; /* what the importer promises is promised to every component */
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
    *value = m->s.last_successful;
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
    *value = m->s.ended != 0;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    CHECK(STEP | STEP_FAILED | TERMINATED);
    if (kind != fmi2PendingStatus) return fmi2Discard;
    *value = "";
    return fmi2OK;
}
