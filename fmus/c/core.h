/* The component inside an FMU, as the interfaces of both FMI versions (fmi2*.c, fmi3*.c) use it.

   model_data.h and the model's code are generated from the component: its table, and its CasADi functions
     MODEL(rhs), MODEL(output)                                  x', y
     MODEL(step)                                                one internal step, uncut; by rk4.c if STEP_BY_RK4
     MODEL(longest_step)                                        up to which it is stable, if LONGEST_STEP
     MODEL(prepare)                                             what depends on parameters alone, if N_Q > 0
     MODEL(rhs_forward), MODEL(output_forward)                  directional derivatives along (dx, du, dp)
     MODEL(rhs_adjoint), MODEL(output_adjoint)                  the same, transposed
     MODEL(output_second)                                       second time derivative of y, if MAX_OUTPUT_ORDER > 1
     MODEL(sample)                                              the sampled part, if SAMPLE_PERIOD > 0
   Nothing here is shared between instances: every function works on the instance it is given. */

#ifndef CORE_H
#define CORE_H

#include <stddef.h>
#include <stdint.h>

#include "mathematics.h"
#include "model_data.h"

#define AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1) /* C has no arrays of length 0 */

/* The same numbers as fmi2Status and fmi3Status. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

typedef enum { TIME, STATE, INPUT, OUTPUT, PARAMETER, DERIVATIVE } Kind;

/* A row of the value reference table; `index` is the place in x, u, y, p or x'. */
typedef struct {
    Kind kind;
    int index;
    int tunable; /* a parameter that may change between steps; a state that is continuous */
    const char *name;
} Variable;

static const Variable VARIABLES[] = {ROWS};

/* The states of FMI 2's and FMI 3's state machines, as bits, so that a call can name all in which it is allowed. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP = 4,
    STEP_FAILED = 8,
    EVENT = 16,
    CONTINUOUS = 32,
    INTERMEDIATE = 64,
    TERMINATED = 128,
    FAILED = 256
} Mode;

/* Everything that a saved FMU state holds. It starts with eight zero bytes: one importer's state files rely on that. */
typedef struct {
    uint64_t zero;
    uint64_t fingerprint; /* of the model: a state of another one is refused */
    int64_t mode;
    int64_t samples;      /* index of the next sample instant */
    double time, start, stop;
    double internal_step_used; /* first length to try with error control, s */
    double x[AT_LEAST_ONE(N_X)];
    double U[3 * AT_LEAST_ONE(N_U)];     /* inputs as set: value, first, second derivative, for the start of the next step */
    double u_now[3 * AT_LEAST_ONE(N_U)]; /* the same at the present time: after a step, the polynomial at its end */
    double p[N_P];                       /* the component's parameters, then internal_step and tolerance */
} State;

typedef struct Instance Instance;

/* Asks the importer for the inputs at `time` (FMI 3, intermediate update), or tells it that an internal step ended there.
   Returns 1 to continue, 0 to end the macro step here (after an internal step only). */
typedef int (*Ask)(Instance *m, double time, int finished);

struct Instance {
    State s;
    int co_simulation;
    double y[AT_LEAST_ONE(N_Y)], x_dot[AT_LEAST_ONE(N_X)];
    int y_known, x_dot_known;
    double P[AT_LEAST_ONE(N_P_MODEL + N_Q)]; /* the component's parameters, then what depends on them alone */
    int P_known;
    double last_successful;
    double x_one[AT_LEAST_ONE(N_X)], x_half[AT_LEAST_ONE(N_X)], x_two[AT_LEAST_ONE(N_X)];
    double U_local[3 * AT_LEAST_ONE(N_U)], u_end[AT_LEAST_ONE(N_U)]; /* inputs of one internal step, with intermediate update */
    const double *argument[WORK_ARGUMENTS];
    double *result[WORK_RESULTS];
    double work[WORK_REALS];
    int integers[WORK_INTEGERS];
    Ask ask;
    /* used by the interfaces of FMI only */
    char *name;
    void *environment;
    const void *callbacks;
    unsigned log_categories;
    void (*log)(Instance *m, Status status, const char *category, const char *text);
    int early_return_allowed, returned_early, get_allowed, set_allowed; /* during intermediate update */
    void (*intermediate_update)(void);
    unsigned char required[N_VARIABLES]; /* variables the importer named for intermediate update */
};

/* Which kinds of variables an importer may touch between communication points. */
#define INTERMEDIATE_UPDATE(kind) ((kind) == INPUT || (kind) == OUTPUT || (kind) == STATE)

enum { LOG_EVENTS = 1, LOG_DISCARD = 2, LOG_ERROR = 4, LOG_WARNING = 8, LOG_ALL = 15 };

static const char *const CATEGORIES[] = {"logEvents", "logStatusDiscard", "logStatusError", "logStatusWarning"};

#endif
