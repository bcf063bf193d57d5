"""Integration methods: one internal step each, of a stated order, as CasADi functions that also become C code.

A method gets a problem over the internal step, scaled to s = 0..1, so that one function serves every length:

    dx/ds = ode(x, s, q),   a dictionary with the symbols "x", "t" (s), "p" (q) and the expression "ode",

and returns the function (x, q) -> x at s = 1. One that fails to converge returns NaN: generated code has no other way.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca

__all__ = ["METHODS", "Method", "Problem"]

Problem = dict[str, Any]

RESIDUAL = 1e-9  # of the stage equations, relative to the size of the right-hand side; beyond it the step has failed


@dataclass(frozen=True)
class Method:
    """A method of integration.

    Attributes
    ----------
    order : int
        The error over one step of length h is of the size h^(order + 1).
    step : callable
        Gets a problem, returns the function (x, q) -> x at s = 1, shapes (n_x,), (n_q,) -> (n_x,); see the module's docstring.
    """

    order: int
    step: Callable[[Problem], ca.Function]


def runge_kutta_4(problem: Problem) -> ca.Function:
    """Classical Runge-Kutta, explicit, order 4. Stable for h times an eigenvalue down to -2.78.

    fmus/c/rk4.c repeats it, operation by operation.
    """
    x, s, q, ode = (problem[key] for key in ("x", "t", "p", "ode"))
    f = ca.Function("f", [x, s, q], [ode])
    x, q = ca.MX.sym("x", x.numel()), ca.MX.sym("q", q.numel())
    k1 = f(x, 0.0, q)
    k2 = f(x + k1 / 2, 0.5, q)
    k3 = f(x + k2 / 2, 0.5, q)
    k4 = f(x + k3, 1.0, q)
    return ca.Function("step", [x, q], [x + (k1 + 2 * k2 + 2 * k3 + k4) / 6])


def rosenbrock_3(problem: Problem) -> ca.Function:
    """RODAS3: linearly implicit, four stages, order 3, L-stable and stiffly accurate; one linear system per stage.

    With J = d ode/dx and g = 1/2:  (I/g - J) k_i = ode(x + sum a_ij k_j, c_i) + sum b_ij k_j + d_i d ode/ds,  x + sum m_i k_i.

    References
    ----------
    Hairer, Wanner: Solving Ordinary Differential Equations II, section IV.7.
    Sandu et al. 1997, Atmospheric Environment 31, p. 3459 (coefficients).
    """
    x, s, q, ode = (problem[key] for key in ("x", "t", "p", "ode"))
    n = x.numel()
    f = ca.Function("f", [x, s, q], [ode])
    slope = ca.Function("slope", [x, q], [ca.substitute(ca.jacobian(ode, s), s, 0)])
    matrix = ca.Function("matrix", [x, q], [2 * ca.DM.eye(n) - ca.substitute(ca.jacobian(ode, x), s, 0)])

    x, q = ca.MX.sym("x", n), ca.MX.sym("q", q.numel())
    A, d = matrix(x, q), slope(x, q)
    f0 = f(x, 0, q)
    k1 = ca.solve(A, f0 + d / 2, "qr")
    k2 = ca.solve(A, f0 + 4 * k1 + 3 * d / 2, "qr")
    k3 = ca.solve(A, f(x + 2 * k1, 1, q) + k1 - k2, "qr")
    k4 = ca.solve(A, f(x + 2 * k1 + k3, 1, q) + k1 - k2 - 8 * k3 / 3, "qr")
    return ca.Function("step", [x, q], [x + 2 * k1 + k3 + k4])


def radau_3(problem: Problem) -> ca.Function:
    """Radau IIA with two stages: implicit, order 3, L-stable; Newton iterations on both stages together.

    Stages k_1, k_2 at s = 1/3 and 1; the last stage is the step's end. The unknowns are scaled by the size of the right-hand
    side, so that the tolerances are relative. A Newton iteration that does not converge gives NaN.

    References
    ----------
    Hairer, Wanner: Solving Ordinary Differential Equations II, section IV.5, table 5.5.
    """
    x, s, q, ode = (problem[key] for key in ("x", "t", "p", "ode"))
    n = x.numel()
    f = ca.Function("f", [x, s, q], [ode])
    x, q, size = ca.MX.sym("x", n), ca.MX.sym("q", q.numel()), ca.MX.sym("size")
    k = ca.MX.sym("k", 2 * n)  # divided by size
    k1, k2 = k[:n] * size, k[n:] * size
    first = f(x + (5 * k1 - k2) / 12, 1.0 / 3.0, q)
    second = f(x + (3 * k1 + k2) / 4, 1, q)
    residual = k - ca.vertcat(first, second) / size
    equations = {"x": k, "p": ca.vertcat(x, q, size), "g": residual}
    options = {"abstol": 1e-12, "abstolStep": 1e-12, "max_iter": 25, "error_on_fail": False}
    newton = ca.rootfinder("newton", "fast_newton", equations, options)
    remainder = ca.Function("remainder", [k, equations["p"]], [ca.norm_inf(residual)])

    x, q = ca.MX.sym("x", n), ca.MX.sym("q", q.numel())
    f0 = f(x, 0, q)
    size = 1e-30 + ca.norm_inf(f0) + ca.norm_inf(f(x, 1, q))
    known = ca.vertcat(x, q, size)
    k = newton(x0=ca.vertcat(f0, f0) / size, p=known)["x"]
    end = x + size * (3 * k[:n] + k[n:]) / 4
    converged = remainder(k, known) <= RESIDUAL
    return ca.Function("step", [x, q], [ca.if_else(converged, end, ca.DM.nan(n))])


METHODS: dict[str, Method] = {
    "rk4": Method(4, runge_kutta_4),
    "rosenbrock": Method(3, rosenbrock_3),
    "radau": Method(3, radau_3),
}
