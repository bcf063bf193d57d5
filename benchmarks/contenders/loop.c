/* Two FMI 2.0 FMUs, one output of each feeding one input of the other, stepped side by side or one after the other with
   held inputs. No checks in the loop but of the status, nothing between the FMUs: the yardstick for masters. */

#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"

typedef struct {
    const char *library, *guid, *resources;
    size_t n_outputs;
    const fmi2ValueReference *outputs;
    fmi2ValueReference source, target;
} End;

typedef struct {
    fmi2Component instance;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2TerminateTYPE *terminate;
    fmi2FreeInstanceTYPE *release;
    void *library;
} Unit;

static void silent(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)m;
}

static const fmi2CallbackFunctions CALLBACKS = {silent, calloc, free, NULL, NULL};

static const char *open_unit(Unit *unit, const End *end, double stop) {
    void *library = unit->library = dlopen(end->library, RTLD_NOW | RTLD_LOCAL);
    if (!library) return dlerror();
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)dlsym(library, "fmi2Instantiate");
    fmi2SetupExperimentTYPE *setup = (fmi2SetupExperimentTYPE *)dlsym(library, "fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter = (fmi2EnterInitializationModeTYPE *)dlsym(library, "fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave = (fmi2ExitInitializationModeTYPE *)dlsym(library, "fmi2ExitInitializationMode");
    unit->set = (fmi2SetRealTYPE *)dlsym(library, "fmi2SetReal");
    unit->get = (fmi2GetRealTYPE *)dlsym(library, "fmi2GetReal");
    unit->step = (fmi2DoStepTYPE *)dlsym(library, "fmi2DoStep");
    unit->terminate = (fmi2TerminateTYPE *)dlsym(library, "fmi2Terminate");
    unit->release = (fmi2FreeInstanceTYPE *)dlsym(library, "fmi2FreeInstance");
    if (!instantiate || !setup || !enter || !leave || !unit->set || !unit->get || !unit->step || !unit->terminate || !unit->release)
        return "the library lacks a function of FMI 2.0";
    unit->instance = instantiate("unit", fmi2CoSimulation, end->guid, end->resources, &CALLBACKS, fmi2False, fmi2False);
    if (!unit->instance) return "instantiation failed";
    if (setup(unit->instance, fmi2False, 0.0, 0.0, fmi2True, stop) > fmi2Warning || enter(unit->instance) > fmi2Warning ||
        leave(unit->instance) > fmi2Warning)
        return "initialization failed";
    return NULL;
}

static int log_row(const Unit *unit, const End *end, double *row) {
    return unit[0].get(unit[0].instance, end[0].outputs, end[0].n_outputs, row) |
           unit[1].get(unit[1].instance, end[1].outputs, end[1].n_outputs, row + end[0].n_outputs);
}

static int jacobi(const Unit *unit, const End *end, double h, long n, double *log) {
    const size_t width = end[0].n_outputs + end[1].n_outputs;
    int bad = log ? log_row(unit, end, log) : 0;
    for (long k = 0; k < n && bad <= fmi2Warning; k++) {
        double a, b;
        bad |= unit[0].get(unit[0].instance, &end[0].source, 1, &a);
        bad |= unit[1].get(unit[1].instance, &end[1].source, 1, &b);
        bad |= unit[0].set(unit[0].instance, &end[0].target, 1, &b);
        bad |= unit[1].set(unit[1].instance, &end[1].target, 1, &a);
        bad |= unit[0].step(unit[0].instance, (double)k * h, h, fmi2True);
        bad |= unit[1].step(unit[1].instance, (double)k * h, h, fmi2True);
        if (log) bad |= log_row(unit, end, log + width * (size_t)(k + 1));
    }
    return bad;
}

static int gauss_seidel(const Unit *unit, const End *end, double h, long n, double *log) {
    const size_t width = end[0].n_outputs + end[1].n_outputs;
    int bad = log ? log_row(unit, end, log) : 0;
    for (long k = 0; k < n && bad <= fmi2Warning; k++) {
        for (int i = 0; i < 2; i++) {
            double y;
            bad |= unit[1 - i].get(unit[1 - i].instance, &end[1 - i].source, 1, &y);
            bad |= unit[i].set(unit[i].instance, &end[i].target, 1, &y);
            bad |= unit[i].step(unit[i].instance, (double)k * h, h, fmi2True);
        }
        if (log) bad |= log_row(unit, end, log + width * (size_t)(k + 1));
    }
    return bad;
}

/* Returns NULL, or what went wrong. `log` holds n + 1 rows or is NULL; `last` one row; `seconds` is of the loop alone. */
__attribute__((visibility("default"))) const char *run(const End *end, int sequential, double h, long n, double *log,
                                                       double *last, double *seconds) {
    Unit unit[2] = {{0}};
    const char *failure = NULL;
    for (int i = 0; i < 2 && !failure; i++) failure = open_unit(&unit[i], &end[i], h * (double)n);
    if (!failure) {
        struct timespec a, b;
        clock_gettime(CLOCK_MONOTONIC, &a);
        int bad = sequential ? gauss_seidel(unit, end, h, n, log) : jacobi(unit, end, h, n, log);
        clock_gettime(CLOCK_MONOTONIC, &b);
        *seconds = (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
        if ((bad | log_row(unit, end, last)) > fmi2Warning) failure = "an FMU refused a call";
    }
    for (int i = 0; i < 2; i++) {
        if (unit[i].instance) {
            unit[i].terminate(unit[i].instance);
            unit[i].release(unit[i].instance);
        }
        if (unit[i].library) dlclose(unit[i].library);
    }
    return failure;
}
