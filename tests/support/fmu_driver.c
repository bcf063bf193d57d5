/* Runs an FMI 2.0 FMU on any platform: fmu_driver LIBRARY GUID N_INPUTS N_OUTPUTS INPUT... OUTPUT...; prints the outputs
   after each of 50 steps of 10 ms with inputs and input derivatives that depend on the step. For the tests. */

#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(name) (void *)LoadLibraryA(name)
#define FIND(library, name) (void *)GetProcAddress((HMODULE)library, name)
#else
#include <dlfcn.h>
#define OPEN(name) dlopen(name, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

static void quiet(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)m;
}

#define FUNCTION(name) name##TYPE *f##name = (name##TYPE *)FIND(library, #name)

int main(int argc, char **argv) {
    if (argc < 5) return 2;
    void *library = OPEN(argv[1]);
    if (!library) return 3;
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2SetRealInputDerivatives);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2GetFMUstate);
    FUNCTION(fmi2SetFMUstate);
    FUNCTION(fmi2FreeFMUstate);
    FUNCTION(fmi2GetDirectionalDerivative);
    FUNCTION(fmi2FreeInstance);
    int n_u = atoi(argv[3]), n_y = atoi(argv[4]), status = 0;
    fmi2ValueReference u[64], y[128];
    for (int i = 0; i < n_u; i++) u[i] = (fmi2ValueReference)atoi(argv[5 + i]);
    for (int i = 0; i < n_y; i++) y[i] = (fmi2ValueReference)atoi(argv[5 + n_u + i]);
    fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};
    fmi2Component c = ffmi2Instantiate("driver", fmi2CoSimulation, argv[2], "", &callbacks, fmi2False, fmi2False);
    if (!c) return 4;
    status |= ffmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
    status |= ffmi2EnterInitializationMode(c);
    status |= ffmi2ExitInitializationMode(c);
    for (int k = 0; k < 50; k++) {
        fmi2FMUstate state = NULL;
        double value[128], seed[64];
        fmi2Integer order[64];
        for (int i = 0; i < n_u; i++) {
            value[i] = 0.3 * ((k * 7 + i * 3) % 11 - 5);
            seed[i] = 1.0;
            order[i] = 1 + k % 2;
        }
        status |= ffmi2SetReal(c, u, (size_t)n_u, value);
        status |= ffmi2SetRealInputDerivatives(c, u, (size_t)n_u, order, value);
        status |= ffmi2GetFMUstate(c, &state);
        status |= ffmi2DoStep(c, k * 0.01, 0.01, fmi2False);
        status |= ffmi2SetFMUstate(c, state);
        status |= ffmi2DoStep(c, k * 0.01, 0.01, fmi2False);
        status |= ffmi2FreeFMUstate(c, &state);
        if (n_u > 0) status |= ffmi2GetDirectionalDerivative(c, y, (size_t)n_y, u, (size_t)n_u, seed, value);
        status |= ffmi2GetReal(c, y, (size_t)n_y, value);
        for (int i = 0; i < n_y; i++) printf("%.17g ", value[i]);
        printf("\n");
    }
    ffmi2FreeInstance(c);
    return status;
}
