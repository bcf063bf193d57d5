/* Time of fmi2DoStep through C: do_step LIBRARY GUID VALUE_REFERENCE_OF_AN_INPUT STEP COUNT. Prints seconds per call of
   fmi2DoStep alone, of SetReal + DoStep + GetReal, and of GetFMUstate + SetFMUstate. */

#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"

static void quiet(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)m;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#define FUNCTION(name) name##TYPE *f##name = (name##TYPE *)dlsym(library, #name)

int main(int argc, char **argv) {
    if (argc != 6) return 2;
    void *library = dlopen(argv[1], RTLD_NOW);
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 1;
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2GetFMUstate);
    FUNCTION(fmi2SetFMUstate);
    FUNCTION(fmi2FreeFMUstate);
    FUNCTION(fmi2FreeInstance);
    fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};
    fmi2Component c = ffmi2Instantiate("bench", fmi2CoSimulation, argv[2], "", &callbacks, fmi2False, fmi2False);
    if (!c) return 1;
    ffmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
    ffmi2EnterInitializationMode(c);
    ffmi2ExitInitializationMode(c);
    fmi2ValueReference input = (fmi2ValueReference)atoi(argv[3]), outputs[2] = {input + 3, input + 4};
    double h = atof(argv[4]), u = 0.1, y[2] = {0, 0}, start = now();
    long n = atol(argv[5]), i = 0, status = 0;
    ffmi2SetReal(c, &input, 1, &u);
    for (; i < n; i++) status |= ffmi2DoStep(c, (double)i * h, h, fmi2True);
    double alone = (now() - start) / (double)n;
    start = now();
    for (; i < 2 * n; i++) {
        u = 0.1 - 1e-9 * y[0];
        status |= ffmi2SetReal(c, &input, 1, &u);
        status |= ffmi2DoStep(c, (double)i * h, h, fmi2True);
        status |= ffmi2GetReal(c, outputs, 2, y);
    }
    double whole = (now() - start) / (double)n;
    fmi2FMUstate state = NULL;
    start = now();
    for (long k = 0; k < n; k++) {
        status |= ffmi2GetFMUstate(c, &state);
        status |= ffmi2SetFMUstate(c, state);
    }
    double rollback = (now() - start) / (double)n;
    ffmi2FreeFMUstate(c, &state);
    ffmi2FreeInstance(c);
    printf("%.4g %.4g %.4g %ld %.17g\n", alone, whole, rollback, status, y[0]);
    return status != 0;
}
