/* An FMI 1.0 slave with a variable of every type. x' = gain u under the polynomial that it was given, from x = start + u as it
   is at initialization; y = x. count = add + steps done; on_out = on.
   It fails with `answer` from the second step on, saying `text`.
   told: steps with newStep true; stop: the stop time, -1 where undefined. */
#include <stdlib.h>
#include <string.h>

#include "fmi1Functions.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { U, Y, GAIN, START, TOLD, STOP, N_REAL };
enum { ADD, COUNT, ANSWER, N_INTEGER };
enum { ON, ON_OUT, N_BOOLEAN };

typedef struct {
    double real[N_REAL], x, du[2], time;
    int integer[N_INTEGER], steps, polls;
    char boolean[N_BOOLEAN], text[64], name[64];
    fmi1CallbackFunctions functions;
} Slave;

EXPORT fmi1Component vendor_fmiInstantiateSlave(fmi1String name, fmi1String guid, fmi1String location, fmi1String mime,
                                                fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive,
                                                fmi1CallbackFunctions functions, fmi1Boolean log) {
    (void)timeout, (void)visible, (void)interactive, (void)log;
    if (strcmp(guid, "vendor") || strncmp(location, "file://", 7) || strcmp(mime, "application/x-fmu-sharedlibrary")) return NULL;
    Slave *s = functions.allocateMemory(1, sizeof *s);
    s->functions = functions, s->real[GAIN] = 1;
    strncpy(s->name, name, sizeof s->name - 1);
    return s;
}
EXPORT fmi1Status vendor_fmiInitializeSlave(fmi1Component c, fmi1Real start, fmi1Boolean ends, fmi1Real stop) {
    Slave *s = c;
    s->x = s->real[START] + s->real[U], s->real[STOP] = ends ? stop : -1, s->time = start;
    return fmi1OK;
}
EXPORT fmi1Status vendor_fmiTerminateSlave(fmi1Component c) { return (void)c, fmi1OK; }
EXPORT void vendor_fmiFreeSlaveInstance(fmi1Component c) { ((Slave *)c)->functions.freeMemory(c); }

#define ACCESS(Name, type, field, n_of) \
    EXPORT fmi1Status vendor_fmiGet##Name(fmi1Component c, const fmi1ValueReference vr[], size_t n, type value[]) { \
        Slave *s = c; \
        s->real[Y] = s->x, s->integer[COUNT] = s->integer[ADD] + s->steps, s->boolean[ON_OUT] = s->boolean[ON]; \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= n_of) return fmi1Error; \
            value[i] = s->field[vr[i]]; \
        } \
        return fmi1OK; \
    } \
    EXPORT fmi1Status vendor_fmiSet##Name(fmi1Component c, const fmi1ValueReference vr[], size_t n, const type value[]) { \
        for (size_t i = 0; i < n; i++) { \
            if (vr[i] >= n_of) return fmi1Error; \
            ((Slave *)c)->field[vr[i]] = value[i]; \
        } \
        return fmi1OK; \
    }
ACCESS(Real, fmi1Real, real, N_REAL)
ACCESS(Integer, fmi1Integer, integer, N_INTEGER)
ACCESS(Boolean, fmi1Boolean, boolean, N_BOOLEAN)

EXPORT fmi1Status vendor_fmiSetString(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1String value[]) {
    if (n != 1 || vr[0]) return fmi1Error;
    strncpy(((Slave *)c)->text, value[0], sizeof ((Slave *)c)->text - 1);
    return fmi1OK;
}
EXPORT fmi1Status vendor_fmiSetRealInputDerivatives(fmi1Component c, const fmi1ValueReference vr[], size_t n,
                                                    const fmi1Integer order[], const fmi1Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != U || order[i] > 2) return fmi1Error;
        ((Slave *)c)->du[order[i] - 1] = value[i];
    }
    return fmi1OK;
}
EXPORT fmi1Status vendor_fmiDoStep(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean new_step) {
    Slave *s = c;
    if (s->steps && s->integer[ANSWER]) {
        s->functions.logger(c, s->name, s->integer[ANSWER], "solver", "%s at %g", s->text, t);
        return s->integer[ANSWER];
    }
    s->x += s->real[GAIN] * h * (s->real[U] + h * (s->du[0] / 2 + h * s->du[1] / 6));
    s->du[0] = s->du[1] = 0;
    s->real[TOLD] += new_step == 1;
    s->steps++, s->time = t + h;
    return fmi1OK;
}
EXPORT fmi1Status vendor_fmiGetRealStatus(fmi1Component c, const fmi1StatusKind kind, fmi1Real *value) {
    if (kind != fmi1LastSuccessfulTime) return fmi1Discard;
    *value = ((Slave *)c)->time;
    return fmi1OK;
}
