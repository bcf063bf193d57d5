"""A component in this process: the same CasADi functions that become the FMU's C code, evaluated here."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from component import Component, Variable
from component.calling import bound
from component.integration import INPUT_DEGREE, substeps
from cosim.errors import SlaveError
from cosim.slaves.base import Signal, Slave


class ComponentSlave(Slave):
    """Runs a Component. Macro steps are cut at sample instants; each piece is done in equal internal steps.

    A sample is taken at the start of the interval that begins at its instant, with the inputs of that moment.
    """

    can_restore = True
    input_degree = INPUT_DEGREE

    def __init__(self, name: str, component: Component) -> None:
        self.name = name
        self._component = component
        self.inputs = tuple(_signal(v, "input") for v in component.inputs)
        self.outputs = tuple(_signal(v, "output") for v in component.outputs)
        step = Signal("internal_step", "parameter", "s", component.internal_step, 1e-9, None, "longest internal step")
        settable = [_signal(v, "state" if v.is_state else v.causality) for v in component.variables if _is_settable(v)]
        self.settable = {s.name: s for s in (*settable, step)}
        self.feedthrough = component.feedthrough
        self._x, self._p = component.start_state, component.start_parameters
        self._u = component.start_input
        self._U = np.zeros((INPUT_DEGREE + 1, len(self.inputs)))  # CasADi reads it column by column: (n_u, 3)
        self._span = np.zeros(2)  # tau, h
        self._y = np.zeros(len(self.outputs))
        self._internal_step = component.internal_step
        self._samples = 0  # how many sample instants have been taken
        self._step = bound(component.step, [self._x, self._U, self._p, self._span[:1], self._span[1:]], self._x)
        self._output = bound(component.output, [self._x, self._u, self._p], self._y)
        self._sample = bound(component.sample, [self._x, self._u, self._p], self._x) if component.sample else None

    def initialize(self, values: Mapping[str, float], t: float, stop: float) -> None:
        self._x[:], self._p[:] = self._component.start_state, self._component.start_parameters
        self._u[:] = self._component.start_input
        self._internal_step = values.get("internal_step", self._component.internal_step)
        tables = self._component.states, self._component.parameters, self._component.inputs
        for rows, target in zip(tables, (self._x, self._p, self._u), strict=True):
            for i, row in enumerate(rows):
                target[i] = values.get(row.name, target[i])
        self._t_start, self._samples = t, 0

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        self._u[:] = u
        self._output()
        if not np.isfinite(self._y.sum()):
            bad = self.outputs[int(np.flatnonzero(~np.isfinite(self._y))[0])].name if not np.isfinite(self._y).all() else "sum"
            raise SlaveError(self.name, t, 0.0, f"output {bad!r} must be finite")
        return self._y.copy()

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._U[:] = U
        if self._sample is None:
            self._integrate(0.0, h)
        else:
            self._step_between_samples(t - self._t_start, h)
        if not np.isfinite(self._x.sum()):
            raise SlaveError(self.name, t, h, "its state must stay finite")

    def _integrate(self, offset: float, length: float) -> None:
        """Equal internal steps over `length` (s) that begin `offset` (s) after the communication point."""
        n = substeps(length, self._internal_step)
        h = self._span[1] = length / n
        for i in range(n):
            self._span[0] = offset + i * h
            self._step()

    def _step_between_samples(self, t: float, h: float) -> None:
        """As step(), with the macro step cut at the instants of the sampled part; t counts from the start of the run."""
        period, sample, offset = self._component.sample_period, self._sample, 0.0
        assert period is not None
        assert sample is not None
        while True:
            instant = self._samples * period - t  # of the next sample, from the communication point
            if instant <= offset + 1e-9 * period:
                self._u[:] = self._U[0] + self._U[1] * offset + self._U[2] * offset**2 / 2
                sample()
                self._samples += 1
                continue
            end = h if instant >= h - 1e-9 * period else instant
            self._integrate(offset, end - offset)
            offset = end
            if end == h:
                return

    def save(self) -> Any:
        return self._x.copy(), self._u.copy(), self._samples

    def restore(self, snapshot: Any) -> None:
        self._x[:], self._u[:], self._samples = snapshot

    def discard(self, snapshot: Any) -> None:
        pass

    def close(self) -> None:
        pass


def _signal(row: Variable, kind: Any) -> Signal:
    return Signal(row.name, kind, row.unit, row.start, row.min, row.max, row.meaning)


def _is_settable(row: Variable) -> bool:
    return row.is_state or row.causality in ("input", "parameter")
