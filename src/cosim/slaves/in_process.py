"""A component in this process: the same machine code that its FMU has, or CasADi's interpreter where there is no compiler."""

import struct
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from gyro_cosim.component import Component, Variable
from gyro_cosim.component.calling import bound
from gyro_cosim.component.do_step import error_control
from gyro_cosim.component.integration import INPUT_DEGREE, Progress, StepError, advance, first_sample, input_at, pieces

from ..errors import OutputError, SlaveError
from .base import Linearisable, Serializable, StateSpace, Tunable
from .description import SlaveDescription
from .machine_code import compiled_component
from .signal import Signal, Value


class ComponentSlave(Serializable, Linearisable, Tunable):
    """Runs a Component as component/do_step.py defines it, on arrays that are bound once."""

    def __init__(self, name: str, component: Component) -> None:
        self.name = name
        self._component = component
        rows = (*component.variables, *component.integration_parameters)
        settable = [_signal(v, "state" if v.is_state else v.causality) for v in rows if _is_settable(v)]
        self.description = SlaveDescription(
            inputs=tuple(_signal(v, "input") for v in component.inputs),
            outputs=tuple(_signal(v, "output") for v in component.outputs),
            settable={s.name: s for s in settable},
            feedthrough=component.feedthrough,
            input_degree=INPUT_DEGREE,
            can_restore=True,
            can_serialize=True,
            tunable=frozenset(v.name for v in component.parameters if v.variability == "tunable"),
        )
        self._x, self._p = component.start_state, component.start_parameters
        self._u = component.start_input
        self._U = np.zeros((INPUT_DEGREE + 1, len(self.inputs)))  # CasADi reads it column by column: (n_u, 3)
        self._tau, self._h = np.zeros(1), np.zeros(1)
        self._y, self._next = np.zeros(len(self.outputs)), self._x.copy()
        code = compiled_component(component)
        self._P = np.zeros(self._p.size if code is None else code.prepared)  # parameters, and what depends on them alone
        functions: dict[str, ca.Function | None] = {n: getattr(component, n) for n in ("step", "output", "sample")}

        def ready(name: str, arguments: list[np.ndarray], result: np.ndarray) -> Callable[[], None]:
            return bound(functions[name], arguments, result) if code is None else code.bound(name, arguments, result)

        self._prepare = self._copy_parameters if code is None else code.bound("prepare", [self._p], self._P)
        self._step = ready("step", [self._x, self._U, self._P, self._tau, self._h], self._next)
        self._output = ready("output", [self._x, self._u, self._P], self._y)
        self._sample = ready("sample", [self._x, self._u, self._P], self._x) if component.sample else None

    def _copy_parameters(self) -> None:
        self._P[:] = self._p

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        numbers = {name: float(value) for name, value in values.items() if isinstance(value, float | int)}
        self._x[:], self._p[:] = self._component.start_state, self._component.start_parameters
        self._u[:] = self._component.start_input
        self._internal_step = numbers.get("internal_step", self._component.internal_step)
        tables = self._component.states, self._component.parameters, self._component.inputs
        for rows, target in zip(tables, (self._x, self._p, self._u), strict=True):
            for i, row in enumerate(rows):
                target[i] = numbers.get(row.name, target[i])
        self._prepare()
        self._control = error_control(self._component, numbers.get("tolerance", 0.0))
        self._progress = Progress(first_sample(self._component.sample_period, t))

    def finish(self) -> None:
        pass

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        for i, row in enumerate(self._component.parameters):
            value = values.get(row.name)
            if isinstance(value, float | int):
                self._p[i] = value
        self._prepare()

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        self._u[:] = u
        self._output()
        if not np.isfinite(self._y).all():
            for signal, value in zip(self.outputs, self._y, strict=True):
                if not np.isfinite(value):
                    raise OutputError(self.name, t, 0.0, f"output {signal.name!r} must be finite, got {value}")
        return self._y.copy()

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._U[:] = U
        samples, first = self._progress.samples, self._progress.step
        for offset, length, due in pieces(t, h, self._component.sample_period, samples):
            for _ in range(due):
                self._u[:] = input_at(U.T, offset)
                if self._sample is not None:
                    self._sample()
            samples += due
            try:
                self._x[:], first = advance(
                    self._one, self._x, offset, length,
                    internal_step=self._internal_step, control=self._control, first=first,
                )  # fmt: skip
            except StepError as error:
                raise SlaveError(self.name, t, h, str(error)) from error
        self._progress = Progress(samples, first)

    def _one(self, x: np.ndarray, tau: float, h: float) -> np.ndarray:
        """One internal step of the component from x."""
        self._x[:] = x
        self._tau[0], self._h[0] = tau, h
        self._step()
        return self._next.copy()

    def save(self) -> Any:
        return self._x.copy(), self._u.copy(), self._progress

    def restore(self, snapshot: Any) -> None:
        self._x[:], self._u[:], self._progress = snapshot

    def discard(self, snapshot: Any) -> None:
        pass

    def serialize(self) -> bytes:
        numbers = np.concatenate([self._x, self._u, self._p, [self._progress.step]])
        return struct.pack("<q", self._progress.samples) + numbers.astype("<f8").tobytes()

    def deserialize(self, data: bytes) -> None:
        if len(data) != 8 * (2 + self._x.size + self._u.size + self._p.size):
            raise ValueError(f"{self.name}: {len(data)} bytes are no state of {self._component.spec!r}")
        numbers = np.frombuffer(data, "<f8", offset=8)
        self._x[:], self._u[:], self._p[:] = np.split(numbers[:-1], [self._x.size, self._x.size + self._u.size])
        self._prepare()
        self._progress = Progress(struct.unpack_from("<q", data)[0], float(numbers[-1]))

    def state_space(self) -> StateSpace | None:
        if self._component.sample is not None:
            return None  # what a sampled part does to the states is no derivative
        return StateSpace(*(np.array(M) for M in self._linear(self._x, self._u, self._p)))

    @cached_property
    def _linear(self) -> ca.Function:
        """A, B, C, D as a function of (x, u, p)."""
        c = self._component
        x, u, p = (ca.MX.sym(name, size) for name, size in zip("xup", (self._x.size, self._u.size, self._p.size), strict=True))
        rates, outputs = c.rhs(x, u, p), c.output(x, u, p)
        matrices = [ca.densify(ca.jacobian(f, by)) for f in (rates, outputs) for by in (x, u)]
        return ca.Function("linear", [x, u, p], matrices)

    def close(self) -> None:
        pass


def _signal(row: Variable, kind: Any) -> Signal:
    start = None if kind == "output" and not row.is_state else row.start  # what is computed starts as it is computed
    shown = row.display_unit or ""
    return Signal(row.name, kind, row.unit, start, row.min, row.max, row.meaning, display=shown, nominal=row.nominal)


def _is_settable(row: Variable) -> bool:
    return row.is_state or row.causality in ("input", "parameter")
