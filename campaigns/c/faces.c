/* Drives every entry of both faces of one of our FMUs in whatever order its input says, with whatever numbers.

   The input is a row of bytes; each call takes what it needs from them. With -DLIBFUZZER the input comes from libFuzzer, else
   from a generator: faces SEED SEQUENCES [THREADS]. What a caller must never do is not done: pointers that lead nowhere, instances
   that are gone. Compiled together with fmu.c, whose TOKEN it knows by the macro. */

#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

enum { HELD = 3, MANY = 6, CALLS = 400 };

typedef struct {
    const uint8_t *at, *end;
} Bytes;

static uint8_t byte(Bytes *b) { return b->at < b->end ? *b->at++ : 0; }

static double number(Bytes *b) {
    static const double odd[] = {0.0, -0.0, 1.0, -1.0, 0.01, 1e-3, 1e-12, 1e-310, 1e300, -1e300, 1e9, 10.0, 5e-324, 0.3};
    uint8_t kind = byte(b);
    if (kind == 255) return NAN;
    if (kind == 254) return INFINITY;
    if (kind == 253) return -INFINITY;
    if (kind < 200) return odd[kind % (sizeof odd / sizeof *odd)];
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++) bits = bits << 8 | byte(b);
    double x;
    memcpy(&x, &bits, 8);
    return x;
}

/* Of a step: what a component is done with in a moment, or refuses at once. */
static double length(Bytes *b) {
    double h = byte(b) % 2 ? 0.01 : number(b);
    return h > 1.0 && h < 1e7 ? 1.0 : h;
}

static uint32_t reference(Bytes *b) {
    uint8_t kind = byte(b);
    return kind < 240 ? kind % 80 : (uint32_t)byte(b) << 24 | (uint32_t)byte(b) << 8 | byte(b);
}

typedef struct {
    uint32_t vr[MANY];
    int32_t order[MANY];
    double value[MANY], more[MANY];
    int boolean[MANY];
    int64_t whole[MANY];
    size_t n, m;
} Arrays;

static Arrays arrays(Bytes *b) {
    Arrays a;
    a.n = byte(b) % (MANY + 1), a.m = byte(b) % 8 == 0 ? byte(b) % (MANY + 1) : a.n;
    for (int i = 0; i < MANY; i++) {
        a.vr[i] = reference(b), a.order[i] = (int8_t)byte(b) / 32, a.value[i] = number(b), a.more[i] = number(b);
        a.boolean[i] = byte(b) % 3, a.whole[i] = (int8_t)byte(b);
    }
    return a;
}

static void quiet2(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)i, (void)s, (void)c;
    if (m) (void)strlen(m);
}

static void quiet3(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String m) { (void)e, (void)s, (void)c, (void)strlen(m); }

static void update(fmi3InstanceEnvironment e, fmi3Float64 t, fmi3Boolean set, fmi3Boolean get, fmi3Boolean done, fmi3Boolean can_return,
                   fmi3Boolean *early, fmi3Float64 *when) {
    (void)e, (void)set, (void)get, (void)done, (void)can_return;
    *early = t > 0.5, *when = t;
}

/* The next thing that a good importer does, so that input by chance gets further than the first wrong call. */
static void onward2(fmi2Component c, int *stage, double *t, Bytes *b) {
    Arrays a = arrays(b);
    switch ((*stage)++) {
    case 0: fmi2SetupExperiment(c, 0, 0.0, *t, byte(b) % 2, 5.0), fmi2EnterInitializationMode(c); break;
    case 1: fmi2ExitInitializationMode(c), fmi2NewDiscreteStates(c, &(fmi2EventInfo){0}), fmi2EnterContinuousTimeMode(c); break;
    default:
        fmi2SetReal(c, a.vr, a.n, a.value), fmi2SetRealInputDerivatives(c, a.vr, a.n, a.order, a.value);
        if (fmi2DoStep(c, *t, 0.01, byte(b) % 2) == fmi2OK) *t += 0.01;
    }
}

static void onward3(fmi3Instance c, int *stage, double *t, Bytes *b) {
    Arrays a = arrays(b);
    bool yes = false, no = false, more = false, other = false, next = false;
    double when = 0.0;
    switch ((*stage)++) {
    case 0: fmi3EnterInitializationMode(c, 0, 0.0, *t, byte(b) % 2, 5.0); break;
    case 1: fmi3ExitInitializationMode(c); break;
    case 2:
        fmi3UpdateDiscreteStates(c, &yes, &no, &more, &other, &next, &when);
        if (byte(b) % 2) fmi3EnterStepMode(c);
        else fmi3EnterContinuousTimeMode(c);
        break;
    default:
        fmi3SetFloat64(c, a.vr, a.n, a.value, a.n);
        if (fmi3DoStep(c, *t, 0.01, byte(b) % 2, &yes, &no, &more, &when) == fmi3OK) *t = when;
        if (yes) fmi3EnterEventMode(c), *stage = 2;
    }
}

static void face2(Bytes *b) {
    static const fmi2CallbackFunctions callbacks = {quiet2, calloc, free, NULL, NULL};
    fmi2Component held[HELD] = {0};
    fmi2FMUstate state[HELD] = {0};
    int stage[HELD] = {0};
    double t[HELD] = {0};
    for (int call = 0; call < CALLS && b->at < b->end; call++) {
        int k = byte(b) % HELD, s = byte(b) % HELD;
        fmi2Component c = held[k];
        if (!c) {
            const char *names[] = {"a", "", NULL, "a rather long name with \n in it"}, *tokens[] = {TOKEN, TOKEN, TOKEN, "other", NULL};
            held[k] = fmi2Instantiate(names[byte(b) % 4], byte(b) % 3 ? fmi2CoSimulation : fmi2ModelExchange, tokens[byte(b) % 5], "",
                                      byte(b) % 9 ? &callbacks : NULL, 0, byte(b) % 2);
            stage[k] = 0, t[k] = 0.0;
            continue;
        }
        if (byte(b) % 3 == 0) {
            onward2(c, &stage[k], &t[k], b);
            continue;
        }
        Arrays a = arrays(b);
        fmi2Status status;
        fmi2String text = "";
        size_t size = 0;
        fmi2EventInfo info;
        fmi2Boolean yes, no;
        switch (byte(b) % 40) {
        case 0: fmi2SetDebugLogging(c, byte(b) % 2, 0, NULL); break;
        case 1: fmi2SetupExperiment(c, byte(b) % 2, number(b), number(b), byte(b) % 2, number(b)); break;
        case 2: case 34: fmi2EnterInitializationMode(c); break;
        case 3: case 35: fmi2ExitInitializationMode(c); break;
        case 4: fmi2Terminate(c); break;
        case 5: fmi2Reset(c); break;
        case 6: fmi2GetReal(c, a.vr, a.n, a.value); break;
        case 7: fmi2SetReal(c, a.vr, a.n, a.value); break;
        case 8: fmi2GetInteger(c, a.vr, a.n, a.order); break;
        case 9: fmi2SetInteger(c, a.vr, a.n, a.order); break;
        case 10: fmi2GetBoolean(c, a.vr, a.n, a.boolean); break;
        case 11: fmi2SetBoolean(c, a.vr, a.n, a.boolean); break;
        case 12: fmi2GetString(c, a.vr, a.n ? 1 : 0, &text); break;
        case 13: fmi2SetString(c, a.vr, a.n ? 1 : 0, &text); break;
        case 14: fmi2GetDirectionalDerivative(c, a.vr, a.n / 2, a.vr + 3, a.n / 2, a.value, a.more); break;
        case 15: case 36: fmi2GetFMUstate(c, &state[s]); break;
        case 16: if (state[s]) fmi2SetFMUstate(c, state[s]); break;
        case 17: fmi2FreeFMUstate(c, &state[s]); break;
        case 18:
            if (state[s] && fmi2SerializedFMUstateSize(c, state[s], &size) == fmi2OK && size < 1u << 20) {
                fmi2Byte *bytes = malloc(size + 1);
                fmi2Status done = fmi2SerializeFMUstate(c, state[s], bytes, byte(b) % 4 ? size : size / 2);
                if (done == fmi2OK) {
                    for (int i = byte(b) % 4; i > 0 && size; i--) bytes[(byte(b) * 257u + byte(b)) % size] = (fmi2Byte)byte(b);
                    fmi2FMUstate other = NULL;
                    if (fmi2DeSerializeFMUstate(c, bytes, byte(b) % 4 ? size : size / 2, &other) == fmi2OK) {
                        fmi2SetFMUstate(c, other);
                        fmi2FreeFMUstate(c, &other);
                        free(other); /* which a state of another mode does not let its instance do */
                    }
                }
                free(bytes);
            }
            break;
        case 19: fmi2SetRealInputDerivatives(c, a.vr, a.n, a.order, a.value); break;
        case 20: fmi2GetRealOutputDerivatives(c, a.vr, a.n, a.order, a.value); break;
        case 21: case 37: case 38: fmi2DoStep(c, byte(b) % 2 ? t[k] : number(b), length(b), byte(b) % 2); break;
        case 22: fmi2CancelStep(c); break;
        case 23: fmi2GetStatus(c, byte(b) % 6, &status); break;
        case 24: fmi2GetRealStatus(c, byte(b) % 6, a.value); break;
        case 25: fmi2GetIntegerStatus(c, byte(b) % 6, a.order); break;
        case 26: fmi2GetBooleanStatus(c, byte(b) % 6, a.boolean); break;
        case 27: fmi2GetStringStatus(c, byte(b) % 6, &text); break;
        case 28: fmi2EnterEventMode(c); break;
        case 29: fmi2NewDiscreteStates(c, &info); break;
        case 30: fmi2EnterContinuousTimeMode(c); break;
        case 31: fmi2CompletedIntegratorStep(c, 1, &yes, &no); break;
        case 32: fmi2SetTime(c, number(b)); break;
        case 33: {
            double x[64] = {0};
            for (int i = 0; i < MANY; i++) x[i] = a.value[i];
            size_t n = byte(b) % 4 ? N_CONTINUOUS : byte(b) % 64;
            fmi2SetContinuousStates(c, x, n), fmi2GetContinuousStates(c, x, n), fmi2GetDerivatives(c, x, n);
            fmi2GetNominalsOfContinuousStates(c, x, n), fmi2GetEventIndicators(c, x, 0);
            break;
        }
        default: fmi2FreeInstance(c), held[k] = NULL; break;
        }
    }
    for (int k = 0; k < HELD; k++)
        if (state[k]) free(state[k]); /* ours are one block, and may outlive their instance */
    for (int k = 0; k < HELD; k++)
        if (held[k]) fmi2FreeInstance(held[k]);
}

static void face3(Bytes *b) {
    fmi3Instance held[HELD] = {0};
    fmi3FMUState state[HELD] = {0};
    int stage[HELD] = {0};
    double t[HELD] = {0};
    for (int call = 0; call < CALLS && b->at < b->end; call++) {
        int k = byte(b) % HELD, s = byte(b) % HELD;
        fmi3Instance c = held[k];
        if (!c) {
            const char *names[] = {"a", "", NULL, "%s%n"}, *tokens[] = {TOKEN, TOKEN, TOKEN, "other", NULL};
            const char *name = names[byte(b) % 4], *token = tokens[byte(b) % 5];
            fmi3LogMessageCallback log = byte(b) % 9 ? quiet3 : NULL;
            switch (byte(b) % 5) {
            case 0: held[k] = fmi3InstantiateModelExchange(name, token, NULL, 0, byte(b) % 2, NULL, log); break;
            case 1: held[k] = fmi3InstantiateScheduledExecution(name, token, NULL, 0, 0, NULL, log, NULL, NULL, NULL); break;
            default:
                held[k] = fmi3InstantiateCoSimulation(name, token, NULL, 0, byte(b) % 2, byte(b) % 2, byte(b) % 2, NULL, 0, NULL, log,
                                                      byte(b) % 2 ? update : NULL);
            }
            stage[k] = 0, t[k] = 0.0;
            continue;
        }
        if (byte(b) % 3 == 0) {
            onward3(c, &stage[k], &t[k], b);
            continue;
        }
        Arrays a = arrays(b);
        size_t size = 0;
        bool yes = false, no = false, more = false, other = false, next = false;
        double when = 0.0;
        switch (byte(b) % 44) {
        case 0: fmi3SetDebugLogging(c, byte(b) % 2, 0, NULL); break;
        case 1: case 34: fmi3EnterInitializationMode(c, byte(b) % 2, number(b), number(b), byte(b) % 2, number(b)); break;
        case 2: case 35: fmi3ExitInitializationMode(c); break;
        case 3: fmi3EnterEventMode(c); break;
        case 4: fmi3Terminate(c); break;
        case 5: fmi3Reset(c); break;
        case 6: fmi3GetFloat64(c, a.vr, a.n, a.value, a.m); break;
        case 7: fmi3SetFloat64(c, a.vr, a.n, a.value, a.m); break;
        case 8: fmi3GetInt64(c, a.vr, a.n, a.whole, a.m); break;
        case 9: fmi3SetInt64(c, a.vr, a.n, a.whole, a.m); break;
        case 10: fmi3GetInt32(c, a.vr, a.n, a.order, a.m); break;
        case 11: fmi3SetInt32(c, a.vr, a.n, a.order, a.m); break;
        case 12: fmi3EnterConfigurationMode(c); break;
        case 13: fmi3ExitConfigurationMode(c); break;
        case 14: fmi3GetDirectionalDerivative(c, a.vr, a.n / 2, a.vr + 3, a.n / 2, a.value, a.m / 2, a.more, a.m / 2); break;
        case 15: fmi3GetAdjointDerivative(c, a.vr, a.n / 2, a.vr + 3, a.n / 2, a.value, a.m / 2, a.more, a.m / 2); break;
        case 16: case 36: fmi3GetFMUState(c, &state[s]); break;
        case 17: if (state[s]) fmi3SetFMUState(c, state[s]); break;
        case 18: fmi3FreeFMUState(c, &state[s]); break;
        case 19:
            if (state[s] && fmi3SerializedFMUStateSize(c, state[s], &size) == fmi3OK && size < 1u << 20) {
                fmi3Byte *bytes = malloc(size + 1);
                if (fmi3SerializeFMUState(c, state[s], bytes, byte(b) % 4 ? size : size / 2) == fmi3OK) {
                    for (int i = byte(b) % 4; i > 0 && size; i--) bytes[(byte(b) * 257u + byte(b)) % size] = byte(b);
                    fmi3FMUState again = NULL;
                    if (fmi3DeserializeFMUState(c, bytes, byte(b) % 4 ? size : size / 2, &again) == fmi3OK) {
                        fmi3SetFMUState(c, again);
                        fmi3FreeFMUState(c, &again);
                        free(again);
                    }
                }
                free(bytes);
            }
            break;
        case 20: fmi3GetOutputDerivatives(c, a.vr, a.n, a.order, a.value, a.m); break;
        case 21: case 37: case 38: case 39:
            fmi3DoStep(c, byte(b) % 2 ? t[k] : number(b), length(b), byte(b) % 2, &yes, &no, &more, &when);
            break;
        case 22: fmi3ActivateModelPartition(c, reference(b), number(b)); break;
        case 23: fmi3UpdateDiscreteStates(c, &yes, &no, &more, &other, &next, &when); break;
        case 24: fmi3EnterContinuousTimeMode(c); break;
        case 25: fmi3EnterStepMode(c); break;
        case 26: fmi3CompletedIntegratorStep(c, 1, &yes, &no); break;
        case 27: fmi3SetTime(c, number(b)); break;
        case 28: {
            double x[64] = {0};
            for (int i = 0; i < MANY; i++) x[i] = a.value[i];
            size_t n = byte(b) % 4 ? N_CONTINUOUS : byte(b) % 64;
            fmi3SetContinuousStates(c, x, n), fmi3GetContinuousStates(c, x, n), fmi3GetContinuousStateDerivatives(c, x, n);
            fmi3GetNominalsOfContinuousStates(c, x, n), fmi3GetEventIndicators(c, x, 0);
            break;
        }
        case 29: fmi3GetNumberOfVariableDependencies(c, reference(b), &size); break;
        case 30: fmi3GetNumberOfEventIndicators(c, &size), fmi3GetNumberOfContinuousStates(c, &size); break;
        case 31: fmi3EvaluateDiscreteStates(c); break;
        case 32: fmi3GetClock(c, a.vr, a.n, (fmi3Clock *)a.boolean); break;
        case 33: fmi3GetFloat32(c, a.vr, a.n, (fmi3Float32 *)a.value, a.m); break;
        default: fmi3FreeInstance(c), held[k] = NULL; break;
        }
    }
    for (int k = 0; k < HELD; k++)
        if (state[k]) free(state[k]);
    for (int k = 0; k < HELD; k++)
        if (held[k]) fmi3FreeInstance(held[k]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 2) return 0;
    Bytes b = {data + 1, data + size};
    if (*data % 2) face2(&b);
    else face3(&b);
    return 0;
}

#ifndef LIBFUZZER
typedef struct {
    uint64_t seed;
    long sequences;
} Task;

static void *drive(void *given) {
    Task *task = given;
    uint64_t x = task->seed * 0x9E3779B97F4A7C15u + 1;
    static const size_t longest = 12000;
    uint8_t *data = malloc(longest);
    for (long n = 0; n < task->sequences; n++) {
        size_t size = 2 + (size_t)(x % (longest - 2));
        for (size_t i = 0; i < size; i++) {
            x ^= x << 13, x ^= x >> 7, x ^= x << 17;
            data[i] = (uint8_t)(x >> 24);
        }
        LLVMFuzzerTestOneInput(data, size);
    }
    free(data);
    return NULL;
}

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    int threads = argc > 3 ? atoi(argv[3]) : 1;
    pthread_t made[16];
    Task task[16];
    for (int k = 0; k < threads && k < 16; k++) {
        task[k] = (Task){strtoull(argv[1], NULL, 10) + (uint64_t)k, atol(argv[2])};
        pthread_create(&made[k], NULL, drive, &task[k]);
    }
    for (int k = 0; k < threads && k < 16; k++) pthread_join(made[k], NULL);
    printf("%ld sequences\n", task[0].sequences * threads);
    return 0;
}
#endif
