/* One internal step of a large model by the classical Runge-Kutta method, with calls of rhs: runge_kutta_4 in the package's
   component/methods.py, operation by operation. A small model's step is generated as one run of operations instead. */

/* The inputs at time t of the polynomial U. */
static void inputs_at(const real *U, real t, real *u) {
    for (int i = 0; i < N_U; i++) u[i] = U[i] + U[i + N_U] * t + U[i + 2 * N_U] * (t * t) / 2;
}

/* k = h f(x, u, P) */
static void slope(const real *x, const real *u, const real *P, real h, real *k) {
    const real *arg[] = {x, u, P};
    real *res[] = {k};
    MODEL(rhs)(arg, res, 0, 0, 0);
    for (int i = 0; i < N_X; i++) k[i] = h * k[i];
}

/* arg: x, U, P, tau, h; res: x at tau + h. */
static int MODEL(step)(const real **arg, real **res, int *integers, real *work, int memory) {
    const real *x = arg[0], *U = arg[1], *P = arg[2], tau = *arg[3], h = *arg[4];
    real u[AT_LEAST_ONE(N_U)], at[N_X], k1[N_X], k2[N_X], k3[N_X], k4[N_X];
    (void)integers, (void)work, (void)memory;
    inputs_at(U, tau, u);
    slope(x, u, P, h, k1);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + k1[i] / 2;
    inputs_at(U, tau + h / 2, u);
    slope(at, u, P, h, k2);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + k2[i] / 2;
    slope(at, u, P, h, k3);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + k3[i];
    inputs_at(U, tau + h, u);
    slope(at, u, P, h, k4);
    for (int i = 0; i < N_X; i++) {
        real end = x[i] + (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) / 6;
        res[0][i] = gc_blend(gc_less(gc_fabs(end), gc_real(AT_REST)), gc_real(0.0), end);
    }
    return 0;
}
