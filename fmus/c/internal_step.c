/* One internal step of the model, for one run or for several side by side (LANES): in equal parts where the model says how long
   a step may be. step_function in the package's component/integration.py, operation by operation. */

#define MOST_PARTS 16
#define NEARLY (1 + 1e-9) /* a step so much longer than the longest one is not cut */

/* What the generated functions work in. */
typedef struct {
    const real **argument;
    real **result;
    int *integers;
    real *work;
} Room;

typedef int Function(const real **, real **, int *, real *, int);

/* Calls a generated function; CasADi takes its arguments through an array that it may write to. */
static void call_in(const Room *room, Function f, int n_in, const real *const in[], real *out) {
    for (int i = 0; i < n_in; i++) room->argument[i] = in[i];
    room->result[0] = out;
    f(room->argument, room->result, room->integers, room->work, 0);
}

/* From x at offset tau within the input polynomial U, over h. P: parameters, with what depends on them alone. */
static void internal_step(const Room *room, const real *x, const real *U, const real *P, real tau, real h, real *x_next) {
    real parts = gc_real(1.0), at, part, next[AT_LEAST_ONE(N_X)];
    double most = 1.0;
#ifdef LONGEST_STEP
    real longest;
    call_in(room, MODEL(longest_step), 3, (const real *[]){x, U, P}, &longest);
    longest = longest * NEARLY;
    for (int n = 1; n < MOST_PARTS; n *= 2) parts = gc_blend(gc_less(parts * longest, h), parts + parts, parts);
    for (int i = 0; i < LANES; i++)
        if (gc_lane(parts, i) > most) most = gc_lane(parts, i);
#endif
    for (int i = 0; i < N_X; i++) x_next[i] = x[i];
    for (double k = 0.0; k < most; k++) {
        const bits goes_on = gc_less(gc_real(k), parts); /* the others have all their parts */
        part = h / parts, at = tau + k * h / parts;
        call_in(room, MODEL(step), 5, (const real *[]){x_next, U, P, &at, &part}, next);
        for (int i = 0; i < N_X; i++) x_next[i] = gc_blend(goes_on, next[i], x_next[i]);
    }
}
