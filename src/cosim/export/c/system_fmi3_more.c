/* The interface of FMI 3.0, second part: states, steps, and what the system does not have. */

#include "system.h"
#include "fmi3Functions.h"

#define ABSENT(name, why, ...) \
    fmi3Status name(fmi3Instance instance, __VA_ARGS__) { \
        CHECK(ANY); \
        return (fmi3Status)fail(m, __func__, why); \
    }
ABSENT(fmi3GetNumberOfVariableDependencies, "dependencies stand in modelDescription.xml", fmi3ValueReference vr, size_t *n)
ABSENT(fmi3GetVariableDependencies, "dependencies stand in modelDescription.xml", fmi3ValueReference vr, size_t element[],
       fmi3ValueReference independent[], size_t independent_element[], fmi3DependencyKind kind[], size_t n)
ABSENT(fmi3GetAdjointDerivative, "the system gives no adjoint derivatives", const fmi3ValueReference unknown[], size_t n_unknown,
       const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed, fmi3Float64 value[],
       size_t n_value)
ABSENT(fmi3UpdateDiscreteStates, "there is no event mode", fmi3Boolean *more, fmi3Boolean *ends, fmi3Boolean *nominals,
       fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next)
ABSENT(fmi3CompletedIntegratorStep, "the system is for Co-Simulation only", fmi3Boolean no_set, fmi3Boolean *event,
       fmi3Boolean *ends)
ABSENT(fmi3SetTime, "the system is for Co-Simulation only", fmi3Float64 time)
ABSENT(fmi3SetContinuousStates, "the system is for Co-Simulation only", const fmi3Float64 x[], size_t n)
ABSENT(fmi3GetContinuousStateDerivatives, "the system is for Co-Simulation only", fmi3Float64 x[], size_t n)
ABSENT(fmi3GetEventIndicators, "the system is for Co-Simulation only", fmi3Float64 z[], size_t n)
ABSENT(fmi3GetContinuousStates, "the system is for Co-Simulation only", fmi3Float64 x[], size_t n)
ABSENT(fmi3GetNominalsOfContinuousStates, "the system is for Co-Simulation only", fmi3Float64 x[], size_t n)
ABSENT(fmi3GetNumberOfEventIndicators, "the system is for Co-Simulation only", size_t *n)
ABSENT(fmi3GetNumberOfContinuousStates, "the system is for Co-Simulation only", size_t *n)
ABSENT(fmi3ActivateModelPartition, "the system has no clocks", fmi3ValueReference clock, fmi3Float64 time)

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown,
                                        const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
                                        fmi3Float64 value[], size_t n_value) {
    CHECK(RUNNING);
    if (n_seed != n_known || n_value != n_unknown) return (fmi3Status)fail(m, __func__, "wrong number of seeds or sensitivities");
    return (fmi3Status)sensitivity(m, __func__, unknown, n_unknown, known, n_known, seed, value);
}

/* ---- the whole state ----------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    CHECK(ANY);
    return (fmi3Status)save(m, __func__, state);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    CHECK(ANY);
    return (fmi3Status)restore(m, __func__, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    CHECK(ANY);
    discard_state(m, state);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    CHECK(ANY);
    return (fmi3Status)serialized_size(m, __func__, state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    CHECK(ANY);
    return (fmi3Status)serialize(m, __func__, state, (unsigned char *)bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    CHECK(ANY);
    return (fmi3Status)deserialize(m, __func__, (const unsigned char *)bytes, size, state);
}

/* ---- Co-Simulation ------------------------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    CHECK(STEP);
    m->no_set_state = no_set_state != 0; /* what the importer promises is promised to every component */
    *event = *terminate = *early = fmi3False;
    Status status = do_step(m, __func__, t, h);
    *reached = m->s.last_successful;
    *terminate = m->s.ended != 0;
    if (status == DISCARD && m->s.ended) return fmi3OK; /* it got as far as it wants to go */
    if (status == DISCARD) m->s.mode = STEP_FAILED;
    return (fmi3Status)status;
}
