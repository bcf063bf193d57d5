"""One internal step of a component, as a CasADi function that runs here and becomes C code inside the FMU.

    x_next = step(x, U, p, tau, h)

U, shape (n_u, 3), holds value, first and second derivative of the inputs at the start of the macro step; tau (s) is the
time since then at which the internal step starts and h (s) its length:

    u(t) = U0 + U1 t + U2 t^2 / 2,    tau <= t <= tau + h.
"""

import math
from collections.abc import Callable

import casadi as ca

INPUT_DEGREE = 2  # highest degree of the input polynomial


def step_function(rhs: ca.Function, method: str) -> ca.Function:
    """The function `step` of the module's docstring for `rhs(x, u, p)`; `method` is a key of METHODS."""
    n_x, n_u, n_p = (rhs.size1_in(i) for i in range(3))
    U = ca.SX.sym("U", n_u, INPUT_DEGREE + 1)
    x, p, tau, h = ca.SX.sym("x", n_x), ca.SX.sym("p", n_p), ca.SX.sym("tau"), ca.SX.sym("h")
    if n_x == 0:
        return ca.Function("step", [x, U, p, tau, h], [x], ["x", "U", "p", "tau", "h"], ["x_next"])
    s = ca.SX.sym("s")  # 0..1 over the internal step, so that one integrator serves every h
    t = tau + s * h
    u = U[:, 0] + U[:, 1] * t + U[:, 2] * t**2 / 2
    dae = {"x": x, "t": s, "p": ca.veccat(U, p, tau, h), "ode": h * rhs(x, u, p)}
    return METHODS[method](dae, (x, U, p, tau, h))


def _runge_kutta_4(dae: dict[str, ca.SX], arguments: tuple[ca.SX, ...]) -> ca.Function:
    """Classical Runge-Kutta, order 4, stable for h times an eigenvalue down to -2.78: CasADi's fixed-step `rk`."""
    options = {"number_of_finite_elements": 1, "simplify": True}
    integrator = ca.integrator("step", "rk", dae, 0.0, 1.0, options).expand()
    x, U, p, tau, h = arguments
    end = integrator(x0=x, p=ca.veccat(U, p, tau, h))["xf"]
    return ca.Function("step", [x, U, p, tau, h], [end], ["x", "U", "p", "tau", "h"], ["x_next"])


METHODS: dict[str, Callable[[dict[str, ca.SX], tuple[ca.SX, ...]], ca.Function]] = {"rk4": _runge_kutta_4}


def substeps(length: float, internal_step: float) -> int:
    """How many equal internal steps cover `length` (s), none longer than `internal_step` but for rounding."""
    return max(1, math.ceil(length / internal_step - 1e-9))
