/* A coupled system as one FMU: what the files of this folder share.

   system_data.h is generated from the system: its components, wires and variables. Every component is an FMU. Its functions
   are either linked in, each with a prefix of its own, or those of a library that the FMU carries among its resources. The
   inner loop is the master's own kernel.c, which calls components through pointers to FMI 2.0 functions; one of FMI 3.0
   stands behind functions of that form (component3.c).
   Nothing here is shared between instances. */

#ifndef SYSTEM_H
#define SYSTEM_H

#ifdef _WIN32 /* windows.h, without what has names that are used here */
#define NOGDI
#define NOUSER
#endif
#define EXPORT static /* kernel.c is a part of this library; it stands first, for what it asks of headers */
#include "kernel.c"

#include <stddef.h>
#include <stdint.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

#define BEFORE 4 /* rows of outputs before a chunk of macro steps, as in the package's master/ways.py */
#define CHUNK 64 /* macro steps that the inner loop does at once */
#define ROWS (BEFORE + CHUNK)
#define DEGREES 3

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status; /* the same numbers as fmi2Status and fmi3Status */
#define GOOD(status) ((unsigned)(status) <= WARNING) /* no number that FMI does not have is good */

typedef enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP = 4, STEP_FAILED = 8, TERMINATED = 16, FAILED = 32 } Mode;

enum { JACOBI = 1, GAUSS_SEIDEL = 2, NEPCE = 3 };

/* The functions that are used, with a parameter that is handed on: a prefix. */
#define FUNCTIONS_2(X, p) \
    X(p, Instantiate) X(p, FreeInstance) X(p, SetupExperiment) X(p, EnterInitializationMode) X(p, ExitInitializationMode) \
    X(p, Terminate) X(p, GetReal) X(p, GetInteger) X(p, GetBoolean) X(p, GetString) X(p, SetReal) X(p, SetInteger) \
    X(p, SetBoolean) \
    X(p, SetString) X(p, SetRealInputDerivatives) X(p, DoStep) X(p, GetBooleanStatus) X(p, GetFMUstate) \
    X(p, SetFMUstate) X(p, FreeFMUstate) X(p, SerializedFMUstateSize) X(p, SerializeFMUstate) X(p, DeSerializeFMUstate) \
    X(p, GetDirectionalDerivative)
#define MEMBER_2(p, name) fmi2##name##TYPE *name;
typedef struct { FUNCTIONS_2(MEMBER_2, ) } Functions2;
#define DECLARATION_2(p, name) fmi2##name##TYPE p##fmi2##name;
#define ADDRESS_2(p, name) p##fmi2##name,

/* What is known of a component when the system is packed. */
typedef struct {
    const char *name, *token;
    int version;              /* of FMI */
    const Functions2 *linked; /* NULL: the library is carried */
    const char *folder;       /* of a carried FMU, below resources/ */
    const char *library;      /* its name, without ending */
    int n_u, n_y, first_wire, first_y; /* connected inputs and outputs, and where they begin in WIRES and in Y */
    int degree;               /* highest degree of an input polynomial that it follows */
    int feeds_through;        /* an output depends directly on a connected input */
    int restores;             /* it can go back to a state */
    int every_length;         /* a step may have any length */
    int event_mode, n_asked, first_asked; /* of FMI 3.0: it has one that is used; inputs that it asks for within a step */
} ComponentData;

/* A connected input; they stand component by component. */
typedef struct {
    uint32_t reference;
    int64_t source; /* place in Y */
    double scale, offset;
} Wire;

typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_STRING } Type;

/* A component's variable of 64 bits, which FMI 2.0 does not have. */
typedef struct {
    int component;
    uint32_t reference;
} Place;

/* A value that the system gives a component before it starts. */
typedef struct {
    int component;
    Type type;
    uint32_t reference;
    double number;
    const char *text;
} Given;

/* An input that nothing is connected to, with what it has at the start. */
typedef struct {
    int component;
    uint32_t reference;
    double start;
} External;

typedef enum { TIME, ALGORITHM, DEGREE, MACRO_STEP, INPUT, OUTPUT, DERIVATIVE, FORWARDED } Kind;

/* A row of the value reference table. FORWARDED: a variable of a component, which is asked itself. */
typedef struct {
    Kind kind;
    Type type;
    int component;
    uint32_t reference; /* in the component */
    int index;          /* place among the external inputs, or in Y */
    int settable;       /* bits of Mode in which it may be set */
    const char *name;
} Variable;

#include "system_data.h"

#define N_Y N_Y_REFERENCES

#define AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1) /* C has no arrays of length 0 */

typedef struct System System;

/* A component of an instance. */
typedef struct {
    System *system;
    const ComponentData *data;
    const Functions2 *f;
    void *instance;
    void *library; /* of the operating system, if it is carried */
    Functions2 loaded;
    char *name, *resources;
    fmi2CallbackFunctions callbacks;
    int dead; /* it answered fatal and must not be called any more */
} Component;

/* Everything of a saved state but what the components save themselves. It starts with eight zero bytes: one importer's state
   files rely on that. */
typedef struct {
    uint64_t zero, fingerprint;
    int64_t mode, algorithm, degree;
    int64_t done;    /* macro steps of full length since `origin` */
    int64_t known;   /* points in Y, at most BEFORE */
    int64_t changed; /* something was set since Y was read */
    int64_t ended;   /* a stop condition holds, or a component wants to end */
    int64_t orders[AT_LEAST_ONE(N_COMPONENTS)]; /* highest input derivative sent so far */
    double step, start, stop, origin, last_successful;
    int64_t stop_defined;
    double t[BEFORE], Y[BEFORE * AT_LEAST_ONE(N_Y)];
    double external[AT_LEAST_ONE(N_EXTERNALS)];
} State;

struct System {
    State s; /* its Y and t are those of the last points, newest last */
    Component components[AT_LEAST_ONE(N_COMPONENTS)];
    double Y[ROWS * AT_LEAST_ONE(N_Y)], t[ROWS], h[ROWS];
    double u[N_WIRES + 1], du[2 * N_WIRES + 1], kept[N_WIRES + 1];
    double C[6 * AT_LEAST_ONE(N_Y)]; /* polynomials of all outputs: of the step, and through what it has reached */
    int64_t source[N_WIRES + 1], fresh[N_WIRES + 1], places[AT_LEAST_ONE(N_Y)];
    uint8_t whole[ROWS];
    double scale[N_WIRES + 1], offset[N_WIRES + 1];
    uint32_t u_refs[N_WIRES + 1], du_refs[2 * N_WIRES + 1];
    int32_t du_orders[2 * N_WIRES + 1];
    Slave slaves[AT_LEAST_ONE(N_COMPONENTS)];
    int64_t jacobi_sequence[AT_LEAST_ONE(N_COMPONENTS)];
    double seconds_spent[AT_LEAST_ONE(N_COMPONENTS)];
    int64_t failure[3];
    int no_set_state; /* what components are promised for a step: nobody goes back behind its begin */
    double seeds[N_VARIABLES + N_WIRES], rates[N_VARIABLES]; /* of directional derivatives */
    uint32_t seeded[N_VARIABLES + N_WIRES], asked[N_VARIABLES];
    /* used by the interfaces of FMI only */
    char *name, *resources;
    const void *callbacks;
    void *environment;
    unsigned log_categories;
    void (*log)(System *m, Status status, const char *category, const char *text);
};

enum { LOG_EVENTS = 1, LOG_DISCARD = 2, LOG_ERROR = 4, LOG_WARNING = 8, LOG_ALL = 15 };

static const char *const CATEGORIES[] = {"logEvents", "logStatusDiscard", "logStatusError", "logStatusWarning"};

#endif
