"""The reference: the same CasADi functions joined into one system without any coupling.

    x' = f(x, q),   y = g(x, q)

q holds the few parameters that stay free (none where none is named); the others have the system's values. Where f is
linear (a constant plus a matrix times x) the matrix exponential gives the solution exactly; else a Runge-Kutta method of
order 8 with tight tolerances.
"""

from collections.abc import Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from gyro_cosim.component import Component
from gyro_cosim.component.calling import bound

from ..network import Network
from ..slaves.in_process import ComponentSlave
from ..systems import System, catalogue
from ..trajectory import Trajectory


def with_equations(system: System) -> list[Component]:
    """The components of a system, all of which must have their equations here.

    Parameters
    ----------
    system
        Of catalogue components.

    Returns
    -------
    components
        In the order of the system's.

    Raises
    ------
    ValueError
        Where a component is an FMU, or has a sampled part, which no equation describes.
    """
    for part in system.components:
        if part.source.endswith(".fmu"):
            raise ValueError(f"component {part.name!r} must be a component of the catalogue, got {part.source!r}")
    components: list[Component] = [catalogue.component(part.source) for part in system.components]
    for part, component in zip(system.components, components, strict=True):
        if component.sample is not None:
            raise ValueError(f"component {part.name!r} must have no sampled part, {component.spec} has one")
    return components


class Monolith:
    """A system of catalogue components as one.

    Parameters
    ----------
    system
        Its components have equations here and nothing sampled.
    free
        The parameters q, as `component.parameter`.

    Attributes
    ----------
    states, x0
        Names as `component.state`, and start values, shape (n_x,).
    free, q0
        The names of the free parameters, and the system's values of them, shape (n_q,).
    f, g
        CasADi functions of (x, q): the rates, shape (n_x,), and the outputs of all components, shape (n_y,).

    Raises
    ------
    ValueError
        Where a component is an FMU or has a sampled part, or a free parameter is no parameter of the system.
    """

    def __init__(self, system: System, free: Sequence[str] = ()) -> None:
        self.free = tuple(free)
        q = ca.SX.sym("q", len(self.free))
        q0 = np.full(len(self.free), np.nan)
        system.refuse_driven("a monolith")
        components = with_equations(system)
        slaves = [ComponentSlave(part.name, c) for part, c in zip(system.components, components, strict=True)]
        network = Network(system, slaves)
        self.names, self.units = network.names, network.units
        self.states: tuple[str, ...] = ()
        x_parts, p_parts, start = [], [], []
        for slave, component, values in zip(slaves, components, network.values, strict=True):
            self.states += tuple(f"{slave.name}.{v.name}" for v in component.states)
            x_parts.append(ca.SX.sym(slave.name, len(component.states)))
            p = ca.SX([values.get(v.name, v.start) for v in component.parameters])
            for row, v in enumerate(component.parameters):
                if f"{slave.name}.{v.name}" in self.free:
                    k = self.free.index(f"{slave.name}.{v.name}")
                    q0[k], p[row] = float(p[row]), q[k]
            p_parts.append(p)
            start += [values.get(v.name, v.start) for v in component.states]
        self.x0, self.q0 = np.array(start), q0
        for name, value in zip(self.free, q0, strict=True):
            if np.isnan(value):
                raise ValueError(f"free parameter {name!r} must be a parameter of the system")
        Y = ca.SX.zeros(len(network.names), 1)
        for i in network.order:
            Y[network.slices[i]] = components[i].output(x_parts[i], self._input(network, i, Y), p_parts[i])
        rates = [c.rhs(x_parts[i], self._input(network, i, Y), p_parts[i]) for i, c in enumerate(components)]
        x = ca.vertcat(*x_parts)
        self.f = ca.Function("f", [x, q], [ca.vertcat(*rates)], ["x", "q"], ["x_dot"])
        self.g = ca.Function("g", [x, q], [Y], ["x", "q"], ["Y"])

    @staticmethod
    def _input(network: Network, i: int, Y: ca.SX) -> ca.SX:
        """u of slave i, in its units, from the outputs of all."""
        u = ca.SX(network.start_inputs(i))
        for k, j, scale, offset in network.wires(i):
            u[j] = Y[k] * scale + offset
        return u

    @cached_property
    def jacobian(self) -> ca.Function:
        """df/dx as a function of (x, q)."""
        x, q = ca.SX.sym("x", self.x0.size), ca.SX.sym("q", self.q0.size)
        return ca.Function("jacobian", [x, q], [ca.jacobian(self.f(x, q), x)])

    @cached_property
    def is_linear(self) -> bool:
        """Whether f is a constant plus a matrix times x."""
        x = ca.SX.sym("x", self.x0.size)
        return not any(ca.which_depends(self.f(x, self.q0), x, 2, True))

    def matrix(self, q: np.ndarray | None = None, x: np.ndarray | None = None) -> np.ndarray:
        """df/dx at a point.

        Parameters
        ----------
        q
            The free parameters, shape (n_q,); the system's values where None.
        x
            The states, shape (n_x,); the origin where None.

        Returns
        -------
        A
            Shape (n_x, n_x).
        """
        return np.array(self.jacobian(np.zeros_like(self.x0) if x is None else x, self.q0 if q is None else q))

    def solve(self, t: np.ndarray) -> Trajectory:
        """The reference, exact to rounding where the system is linear.

        Parameters
        ----------
        t
            Times, s, increasing from 0, shape (n,).

        Returns
        -------
        Trajectory
            Of all outputs.

        Raises
        ------
        RuntimeError
            Where the integration does not reach the end.
        """
        x = self._exponential(t) if self.is_linear else self._integrated(t)
        values = np.array(self.g(x.T, self.q0)).T
        return Trajectory(t, self.names, self.units, values)

    def _exponential(self, t: np.ndarray) -> np.ndarray:
        """x at every t, shape (n, n_x), by the exponential of the matrix augmented with the constant part."""
        from scipy.linalg import expm

        n = self.x0.size
        A = np.zeros((n + 1, n + 1))
        A[:n, :n] = self.matrix()
        A[:n, n] = np.array(self.f(np.zeros(n), self.q0)).ravel()
        start = np.append(self.x0, 1.0)
        return np.array([(expm(A * ti) @ start)[:n] for ti in t])

    def _integrated(self, t: np.ndarray) -> np.ndarray:
        """x at every t, shape (n, n_x), by DOP853 at a relative tolerance of 1e-12."""
        from scipy.integrate import solve_ivp

        argument, result = np.zeros(self.x0.size), np.zeros(self.x0.size)
        call = bound(self.f, [argument, self.q0], result)

        def rhs(_: float, x: np.ndarray) -> np.ndarray:
            argument[:] = x
            call()
            return result.copy()

        solution = solve_ivp(rhs, (t[0], t[-1]), self.x0, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-15)
        if not solution.success:
            raise RuntimeError(f"the reference must reach t = {t[-1]:g} s: {solution.message}")
        return np.asarray(solution.y.T)
