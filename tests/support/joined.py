"""A vehicle with gyro units on its mounts, joined into one system without any coupling: for tests and benchmarks.

    x' = f(x, p),   y = g(x, p)

Each gyro unit is joined to the vehicle's connector of the name it is given: for every bond of the vehicle there, the vehicle's
motion becomes the gyro unit's input, and the gyro unit's effort the vehicle's, by axis. Names of a gyro unit's variables are
"connector.name"; "unit.name" addresses all of them at once. The gyro units' outputs must depend, of the vehicle's signals, on
its states alone. gyro_cosim.accuracy.monolith joins any system of the catalogue; here any components run in equal steps.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from gyro_cosim.component import Component
from gyro_cosim.component.integration import step_function


@dataclass(frozen=True)
class Run:
    """Outputs by name over time: t shape (n,), values shape (n, n_y); `end` the state at the end, shape (n_x,)."""

    t: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray
    end: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[:, self.names.index(name)]


class Joined:
    """See the module's docstring. `state_names`, `parameter_names`, `output_names` are the rows of x, p, y.

    cut : whether steps are cut where the vehicle says how long one may be.
    """

    def __init__(self, vehicle: Component, units: Mapping[str, Component] | None = None, *, cut: bool = True) -> None:
        x, p = ca.SX.sym("x", len(vehicle.states)), ca.SX.sym("p", len(vehicle.parameters))
        rows = {v.name: i for i, v in enumerate(vehicle.outputs)}
        inputs = [v.name for v in vehicle.inputs]
        motions = vehicle.output(x, ca.SX.zeros(len(inputs)), p)
        u = ca.SX(vehicle.start_input)
        xs, ps, rates, outputs = [x], [p], [], []
        self.state_names = [v.name for v in vehicle.states]
        self.parameter_names = [v.name for v in vehicle.parameters]
        self.output_names = [v.name for v in vehicle.outputs]
        starts, values = [vehicle.start_state], [vehicle.start_parameters]
        for connector, unit in (units or {}).items():
            bonds = {bond.axis: bond for bond in vehicle.bonds if bond.connector == connector}
            if not bonds:
                raise ValueError(f"component {vehicle.spec!r} has no connector {connector!r}")
            x_u, p_u = ca.SX.sym("x_u", len(unit.states)), ca.SX.sym("p_u", len(unit.parameters))
            u_u = ca.SX(unit.start_input)
            unit_inputs, unit_outputs = [v.name for v in unit.inputs], [v.name for v in unit.outputs]
            for bond in unit.bonds:
                if bond.axis in bonds:
                    u_u[unit_inputs.index(bond.motion)] = motions[rows[bonds[bond.axis].motion]]
            y_u = unit.output(x_u, u_u, p_u)
            for bond in unit.bonds:
                if bond.axis in bonds:
                    u[inputs.index(bonds[bond.axis].effort)] = y_u[unit_outputs.index(bond.effort)]
            xs.append(x_u)
            ps.append(p_u)
            rates.append(unit.rhs(x_u, u_u, p_u))
            outputs.append(y_u)
            self.state_names += [f"{connector}.{v.name}" for v in unit.states]
            self.parameter_names += [f"{connector}.{v.name}" for v in unit.parameters]
            self.output_names += [f"{connector}.{n}" for n in unit_outputs]
            starts.append(unit.start_state)
            values.append(unit.start_parameters)
        X, P, no_input = ca.vertcat(*xs), ca.vertcat(*ps), ca.SX.sym("u", 0)
        self.f = ca.Function("f", [X, P], [ca.cse(ca.vertcat(vehicle.rhs(x, u, p), *rates))])
        self.g = ca.Function("g", [X, P], [ca.cse(ca.vertcat(vehicle.output(x, u, p), *outputs))])
        self.x0, self.p0 = np.concatenate(starts), np.concatenate(values)
        limit = None
        if cut and vehicle.longest_step is not None:
            limit = ca.Function("longest_step", [X, no_input, P], [vehicle.longest_step(x, u, p)])
        self.step = step_function(ca.Function("rhs", [X, no_input, P], [self.f(X, P)]), vehicle.method, limit)
        self.internal_step = vehicle.internal_step
        self._connectors = tuple(units or {})
        self._loops: dict[int, ca.Function] = {}

    def p(self, values: Mapping[str, float]) -> np.ndarray:
        """The parameters with `values` put in by name."""
        return self._filled(self.p0, self.parameter_names, values)

    def x(self, values: Mapping[str, float]) -> np.ndarray:
        """The start state with `values` put in by name."""
        return self._filled(self.x0, self.state_names, values)

    def _filled(self, base: np.ndarray, names: list[str], values: Mapping[str, float]) -> np.ndarray:
        filled = base.copy()
        for name, value in values.items():
            whole = [f"{c}.{name.removeprefix('unit.')}" for c in self._connectors] if name.startswith("unit.") else [name]
            for n in whole:
                if n not in names:
                    raise ValueError(f"the joined system has no {n!r}")
                filled[names.index(n)] = value
        return filled

    def run(
        self, stop: float, p: np.ndarray, x: np.ndarray | None = None, *, h: float | None = None, every: int = 20,
        until: str | None = None,
    ) -> Run:  # fmt: skip
        """Equal steps of `h` (s, the vehicle's internal step where None) to `stop` (s), outputs at every `every`-th.

        Ends early at the first output where the output `until` is above 0, or a state is not finite.
        """
        x, h = self.x0 if x is None else x, self.internal_step if h is None else h
        if every not in self._loops:
            arguments = [ca.MX.sym("x", self.x0.size), ca.MX.sym("p", self.p0.size), ca.MX.sym("h")]
            one = ca.Function("one", arguments, [self.step(arguments[0], ca.DM.zeros(0, 3), arguments[1], 0, arguments[2])])
            self._loops[every] = one.mapaccum("loop", every)
        loop = self._loops[every]
        parameters = np.tile(p, (every, 1)).T
        t, rows = [0.0], [np.array(self.g(x, p)).ravel()]
        for k in range(round(stop / h / every)):
            x = np.array(loop(x, parameters, h))[:, -1]
            t.append((k + 1) * every * h)
            rows.append(np.array(self.g(x, p)).ravel())
            if not np.all(np.isfinite(x)) or (until is not None and rows[-1][self.output_names.index(until)] > 0.0):
                break
        return Run(np.array(t), tuple(self.output_names), np.array(rows), x)
