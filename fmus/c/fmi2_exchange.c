/* Model Exchange of FMI 2.0; follows fmi2.c, whose macros it uses. */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    CHECK(EVENT | CONTINUOUS);
    m->s.mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    CHECK(EVENT);
    info->newDiscreteStatesNeeded = info->terminateSimulation = info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = update_discrete_states(m) ? fmi2True : fmi2False;
    info->nextEventTimeDefined = next_event(m, &info->nextEventTime) ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    CHECK(EVENT);
    m->s.mode = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state, fmi2Boolean *event, fmi2Boolean *terminate) {
    CHECK(CONTINUOUS);
    (void)no_set_state;
    *event = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    CHECK(EVENT | CONTINUOUS);
    m->s.time = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    CHECK(CONTINUOUS);
    return (fmi2Status)set_continuous(m, __func__, x, n);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    CHECK(RUNNING);
    return (fmi2Status)get_continuous(m, __func__, m->s.x, x, n);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x_dot[], size_t n) {
    CHECK(RUNNING);
    return (fmi2Status)get_continuous(m, __func__, derivatives(m), x_dot, n);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominal[], size_t n) {
    CHECK(ANY);
    return (fmi2Status)get_continuous(m, __func__, NOMINAL_X, nominal, n);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    CHECK(RUNNING);
    (void)z;
    return n == 0 ? fmi2OK : (fmi2Status)fail(m, __func__, "the model has no event indicators");
}
