/* The interface of FMI 3.0. */

#include "system.h"
#include "fmi3Functions.h"

#undef ANY
#undef RUNNING
#undef CHECK
#define ANY (INSTANTIATED | INITIALIZATION | STEP | STEP_FAILED | TERMINATED | FAILED)
#define RUNNING (INITIALIZATION | STEP | STEP_FAILED | TERMINATED | FAILED)
#define CHECK(modes) \
    System *m = instance; \
    if (!m) return fmi3Error; \
    if (!allowed(m, __func__, modes)) return fmi3Error

const char *fmi3GetVersion(void) { return fmi3Version; }

static void log_fmi3(System *m, Status status, const char *category, const char *text) {
    ((fmi3LogMessageCallback)m->callbacks)(m->environment, (fmi3Status)status, category, text);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String category[]) {
    CHECK(ANY);
    m->log_categories = 0;
    return (fmi3Status)choose_categories(m, on, n, category);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean log, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
                                         fmi3IntermediateUpdateCallback intermediate_update) {
    (void)visible, (void)event_mode, (void)early_return, (void)required, (void)intermediate_update;
    if (!name || !token || strcmp(token, TOKEN) != 0 || n_required > 0) {
        if (callback)
            callback(environment, fmi3Error, "logStatusError",
                     "fmi3InstantiateCoSimulation: name and instantiationToken must be given, the token as in "
                     "modelDescription.xml; there is no intermediate update");
        return NULL;
    }
    System *m = make_system(name, resources);
    if (!m) return NULL;
    m->environment = environment;
    m->callbacks = (const void *)callback;
    m->log = callback ? log_fmi3 : NULL;
    m->log_categories = log ? LOG_ALL : 0;
    if (to_start(m)) return m;
    free_system(m);
    return NULL;
}

#define NO_INTERFACE \
    if (callback) callback(environment, fmi3Error, "logStatusError", "the system is for Co-Simulation only"); \
    return NULL

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean log, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback callback) {
    (void)name, (void)token, (void)resources, (void)visible, (void)log;
    NO_INTERFACE;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean log, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback callback, fmi3ClockUpdateCallback clock,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)log, (void)clock, (void)lock, (void)unlock;
    NO_INTERFACE;
}

void fmi3FreeInstance(fmi3Instance instance) { free_system(instance); }

/* ---- modes --------------------------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    CHECK(INSTANTIATED);
    (void)tolerance_defined, (void)tolerance; /* accuracy is a matter of parameters, so that a run is reproducible */
    Status status = set_experiment(m, __func__, start, stop_defined, stop);
    return (fmi3Status)(status == OK ? enter_initialization(m, __func__) : status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    CHECK(INITIALIZATION);
    Status status = exit_initialization(m, __func__);
    return (fmi3Status)(status == DISCARD ? fail(m, __func__, "no consistent start") : status);
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    CHECK(STEP | STEP_FAILED);
    terminate_components(m);
    m->s.mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    CHECK(ANY);
    return to_start(m) ? fmi3OK : fmi3Fatal;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    CHECK(INITIALIZATION);
    return fmi3OK;
}

#define NEVER(name) \
    fmi3Status name(fmi3Instance instance) { \
        CHECK(0); \
        return fmi3OK; \
    }
NEVER(fmi3EnterEventMode)
NEVER(fmi3EnterStepMode)
NEVER(fmi3EnterContinuousTimeMode)
NEVER(fmi3EnterConfigurationMode)
NEVER(fmi3ExitConfigurationMode)

/* ---- values -------------------------------------------------------------------------------------------------------- */

#define GETTER_3(name, of, ctype) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, ctype value[], size_t n_value) { \
        CHECK(ANY); \
        if (n_value != n) return (fmi3Status)fail(m, __func__, "nValues must equal nValueReferences: all are scalar"); \
        for (size_t i = 0; i < n; i++) { \
            const Variable *v = variable(m, __func__, vr[i], of); \
            double number = 0.0; \
            if (!v) return fmi3Error; \
            Status status = get_one(m, __func__, v, &number); \
            if (status >= ERROR) return (fmi3Status)status; \
            value[i] = (ctype)number; \
        } \
        return fmi3OK; \
    }
GETTER_3(fmi3GetFloat64, TYPE_REAL, fmi3Float64)
GETTER_3(fmi3GetInt32, TYPE_INTEGER, fmi3Int32)
GETTER_3(fmi3GetInt64, TYPE_INTEGER, fmi3Int64) /* enumerations */
GETTER_3(fmi3GetBoolean, TYPE_BOOLEAN, fmi3Boolean)

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t n_value) {
    CHECK(ANY);
    if (n_value != n) return (fmi3Status)fail(m, __func__, "nValues must equal nValueReferences: all are scalar");
    for (size_t i = 0; i < n; i++) {
        const Variable *v = variable(m, __func__, vr[i], TYPE_STRING);
        if (!v) return fmi3Error;
        Status status = get_text(m, __func__, v, &value[i]);
        if (status != OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

#define SETTER_3(name, of, ctype, number, string) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const ctype value[], size_t n_value) { \
        CHECK(INSTANTIATED | INITIALIZATION | STEP); \
        Status status = n_value == n ? OK : fail(m, __func__, "nValues must equal nValueReferences: all are scalar"); \
        for (size_t i = 0; i < n && status == OK; i++) { \
            const Variable *v = variable(m, __func__, vr[i], of); \
            if (!v) return fmi3Error; \
            status = may_set(m, __func__, v, number); \
        } \
        for (size_t i = 0; i < n && status == OK; i++) status = set_one(m, __func__, &VARIABLES[vr[i]], number, string); \
        return (fmi3Status)status; \
    }
SETTER_3(fmi3SetFloat64, TYPE_REAL, fmi3Float64, value[i], NULL)
SETTER_3(fmi3SetInt32, TYPE_INTEGER, fmi3Int32, (double)value[i], NULL)
SETTER_3(fmi3SetInt64, TYPE_INTEGER, fmi3Int64, (double)value[i], NULL)
SETTER_3(fmi3SetBoolean, TYPE_BOOLEAN, fmi3Boolean, (double)value[i], NULL)
SETTER_3(fmi3SetString, TYPE_STRING, fmi3String, 0.0, value[i])

/* The system has no variables of other types, and no clocks. */
#define NONE(name, ...) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) { \
        CHECK(ANY); \
        (void)vr, (void)value; \
        return n == 0 ? fmi3OK : (fmi3Status)fail(m, __func__, "the system has no variable of this type"); \
    }
#define NONE_OF(type) \
    NONE(fmi3Get##type, fmi3##type value[], size_t n_value) \
    NONE(fmi3Set##type, const fmi3##type value[], size_t n_value)
NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF(UInt32)
NONE_OF(UInt64)
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
NONE(fmi3GetOutputDerivatives, const fmi3Int32 order[], fmi3Float64 value[], size_t n_value)
