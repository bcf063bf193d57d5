/* A whole run of an FMU that is linked in: same_bits GUID STEPS STEP EVERY N OUTPUT... PARAMETER VALUE ...; prints the bits of
   the N outputs after every EVERY-th step. For benchmarks/same_bits.py. */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

static void loud(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String message, ...) {
    (void)e, (void)i, (void)c;
    if (s > fmi2Warning) fprintf(stderr, "%s\n", message);
}

int main(int argc, char **argv) {
    if (argc < 6) return 2;
    int steps = atoi(argv[2]), every = atoi(argv[4]), n = atoi(argv[5]), status = 0;
    double step = atof(argv[3]), value;
    fmi2CallbackFunctions callbacks = {loud, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("run", fmi2CoSimulation, argv[1], "", &callbacks, fmi2False, fmi2False);
    if (!c) return 3;
    for (int i = 6 + n; i + 1 < argc; i += 2) {
        fmi2ValueReference parameter = (fmi2ValueReference)atoi(argv[i]);
        value = atof(argv[i + 1]);
        status |= fmi2SetReal(c, &parameter, 1, &value);
    }
    status |= fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
    status |= fmi2EnterInitializationMode(c);
    status |= fmi2ExitInitializationMode(c);
    for (int k = 0; k < steps && status == 0; k++) {
        status |= fmi2DoStep(c, k * step, step, fmi2True);
        for (int i = 0; i < n && (k + 1) % every == 0; i++) {
            fmi2ValueReference output = (fmi2ValueReference)atoi(argv[6 + i]);
            uint64_t bits;
            status |= fmi2GetReal(c, &output, 1, &value);
            memcpy(&bits, &value, sizeof bits);
            printf("%016" PRIx64 "%c", bits, i + 1 < n ? ' ' : '\n');
        }
    }
    fmi2FreeInstance(c);
    return status;
}
