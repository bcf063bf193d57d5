"""Runs of the full vehicle in this process for the tests: alone or with two gyro units joined on, one Runge-Kutta loop."""

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from component import Component
from component.integration import step_function


@dataclass(frozen=True)
class Run:
    """Outputs by name over time: t shape (n,), values shape (n, n_y); `end` the state at the end."""

    t: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray
    end: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[:, self.names.index(name)]


class Joined:
    """A vehicle with a gyro unit on each wheel frame (or none) as one system x' = f(x, p), y = g(x, p)."""

    def __init__(self, vehicle: Component, gyro: Component | None = None) -> None:
        ends = ("front", "rear") if gyro is not None else ()
        x, p = ca.SX.sym("x", len(vehicle.states)), ca.SX.sym("p", len(vehicle.parameters))
        states, inputs = [v.name for v in vehicle.states], [v.name for v in vehicle.inputs]
        u = ca.SX.zeros(len(inputs))
        xs, ps, rates, reported = [x], [p], [], []
        self.state_names, self.start = list(states), [vehicle.start_state]
        self.parameter_names, self.parameters = [v.name for v in vehicle.parameters], [vehicle.start_parameters]
        self.names = [v.name for v in vehicle.outputs]
        for end in ends:
            assert gyro is not None
            x_g, p_g = ca.SX.sym("x_g", len(gyro.states)), ca.SX.sym("p_g", len(gyro.parameters))
            u_g = ca.vertcat(*(x[states.index(f"{end}_{v.name}")] for v in gyro.inputs))
            y_g = gyro.output(x_g, u_g, p_g)
            for i, v in enumerate(gyro.outputs):
                if f"{end}_{v.name}" in inputs:
                    u[inputs.index(f"{end}_{v.name}")] = y_g[i]
            xs.append(x_g)
            ps.append(p_g)
            rates.append(gyro.rhs(x_g, u_g, p_g))
            reported.append(y_g)
            self.state_names += [f"{end}_gyro.{v.name}" for v in gyro.states]
            self.parameter_names += [f"{end}_gyro.{v.name}" for v in gyro.parameters]
            self.names += [f"{end}_gyro.{v.name}" for v in gyro.outputs]
            self.start.append(gyro.start_state)
            self.parameters.append(gyro.start_parameters)
        X, P = ca.vertcat(*xs), ca.vertcat(*ps)
        self.f = ca.Function("f", [X, P], [ca.vertcat(vehicle.rhs(x, u, p), *rates)])
        self.g = ca.Function("g", [X, P], [ca.vertcat(vehicle.output(x, u, p), *reported)])
        self.x0 = np.concatenate(self.start)
        no_input = ca.SX.sym("u", 0)
        self._step = step_function(ca.Function("rhs", [X, no_input, P], [self.f(X, P)]), "rk4")
        self._loops: dict[int, ca.Function] = {}

    def p(self, values: Mapping[str, float]) -> np.ndarray:
        """The parameters with `values` put in by name; "gyro.x" addresses both gyro units."""
        p = np.concatenate(self.parameters)
        for name, value in values.items():
            names = [f"{end}_{name}" for end in ("front", "rear")] if name.startswith("gyro.") else [name]
            for n in names:
                p[self.parameter_names.index(n)] = value
        return p

    def x(self, values: Mapping[str, float]) -> np.ndarray:
        """The start state with `values` put in by name."""
        x = self.x0.copy()
        for name, value in values.items():
            x[self.state_names.index(name)] = value
        return x

    def run(self, stop: float, p: np.ndarray, x: np.ndarray | None = None, h: float = 5e-4, every: int = 20) -> Run:
        """Steps of `h` (s) up to `stop` (s), outputs every `every` steps; ends early where a wheel is derailed."""
        x = self.x0 if x is None else x
        if every not in self._loops:
            a, q, dt = ca.MX.sym("x", self.x0.size), ca.MX.sym("p", p.size), ca.MX.sym("h")
            one = ca.Function("one", [a, q, dt], [self._step(a, ca.DM.zeros(0, 3), q, 0, dt)])
            self._loops[every] = one.mapaccum("loop", every)
        loop = self._loops[every]
        times, rows = [0.0], [np.array(self.g(x, p)).ravel()]
        for k in range(round(stop / h / every)):
            x = np.array(loop(x, np.tile(p, (every, 1)).T, h))[:, -1]
            times.append((k + 1) * every * h)
            rows.append(np.array(self.g(x, p)).ravel())
            if "derailed" in self.names and rows[-1][self.names.index("derailed")] > 0.0:
                break
        return Run(np.array(times), tuple(self.names), np.array(rows), x)
