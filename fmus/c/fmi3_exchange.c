/* Model Exchange of FMI 3.0; follows fmi3.c, whose macros it uses. */

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                    fmi3Boolean *next_event_defined, fmi3Float64 *next_event_time) {
    CHECK(EVENT);
    *again = *terminate = *nominals_changed = fmi3False;
    *values_changed = update_discrete_states(m);
    *next_event_defined = next_event(m, next_event_time);
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_state, fmi3Boolean *event,
                                       fmi3Boolean *terminate) {
    CHECK(CONTINUOUS);
    (void)no_set_state;
    *event = *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    CHECK(CONTINUOUS);
    m->s.time = time;
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n) {
    CHECK(CONTINUOUS);
    return (fmi3Status)set_continuous(m, __func__, x, n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    CHECK(RUNNING);
    return (fmi3Status)get_continuous(m, __func__, m->s.x, x, n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 x_dot[], size_t n) {
    CHECK(RUNNING);
    return (fmi3Status)get_continuous(m, __func__, derivatives(m), x_dot, n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominal[], size_t n) {
    CHECK(SETTLED);
    return (fmi3Status)get_continuous(m, __func__, NOMINAL_X, nominal, n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 z[], size_t n) {
    CHECK(RUNNING);
    (void)z;
    return n == 0 ? fmi3OK : (fmi3Status)fail(m, __func__, "the model has no event indicators");
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n) {
    CHECK(ANY);
    *n = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n) {
    CHECK(ANY);
    *n = N_CONTINUOUS;
    return fmi3OK;
}
