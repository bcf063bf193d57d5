"""A slave behind a delayed, perhaps compensated interface. What the filters mean stands in gyro_cosim.hil.compensation."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gyro_cosim.component.variables import BALANCE

from ..slaves.base import Counting, Counts, Promised, Restorable, Slave, counts, restorable
from ..slaves.usage import Usage, promise
from .compensation import Compensator, Filter, PassivityController, Uncompensated, delay_taps

__all__ = ["DelayedSlave"]


class DelayedSlave(Restorable, Counting, Promised):
    """A slave whose efforts arrive late; the other outputs (energies, angles) stay as they are.

    Parameters
    ----------
    slave
        The one behind the interface.
    pairs
        For each bond the place in u of the motion, and the row of y of the effort.
    step
        The macro step, s; a last, shorter step counts as a whole one.
    delay
        In s.
    compensator
        What stands at the receiving end.
    model
        Another slave with the same signals, for model-based prediction; it gets the same inputs.
    passive
        Whether a passivity controller stands at the end.
    """

    def __init__(
        self, slave: Slave, pairs: Sequence[tuple[int, int]], *, step: float, delay: float,
        compensator: Compensator = Uncompensated(), model: Slave | None = None,  # noqa: B008 (frozen)
        passive: bool = False,
    ) -> None:  # fmt: skip
        self._slave, self._model, self._step_length = slave, model, step
        self._places, self._rows = (np.array([pair[k] for pair in pairs], dtype=int) for k in (0, 1))
        self._taps = compensator.taps(delay / step)
        self._plain = Uncompensated().taps(delay / step)  # the model's own answer is delayed as the unit's
        self._passive = passive
        rows = {signal.name: row for row, signal in enumerate(slave.outputs)}
        self._balance = tuple(rows.get(name) for name in BALANCE)
        self.name = slave.name
        feedthrough, initial = slave.description.feedthrough.copy(), slave.description.initial_feedthrough.copy()
        if delay_taps(delay / step)[0] == 0.0 and model is None:
            feedthrough[self._rows] = False
        if passive:
            feedthrough[np.ix_(self._rows, self._places)] = True
            initial[np.ix_(self._rows, self._places)] = True
        self._inside = [restorable(one) for one in (slave, model) if one is not None]
        self.description = replace(
            slave.description, feedthrough=feedthrough, initial_feedthrough=initial, can_restore=None not in self._inside,
            can_serialize=False,
        )  # fmt: skip
        if model is not None:
            names = [signal.name for signal in model.outputs]
            self._model_rows = np.array([names.index(slave.outputs[row].name) for row in self._rows], dtype=int)

    def promise(self, usage: Usage, values: Mapping[str, Any], t: float, stop: float) -> tuple[str, ...]:
        told = promise(self._slave, usage, values, t, stop)
        if self._model is not None:
            own = {n: v for n, v in values.items() if n in self._model.description.settable}
            promise(self._model, usage, own, t, stop)
        degree = self._slave.description.input_degree
        self._inside = [restorable(one) for one in (self._slave, self._model) if one is not None]
        self.description = replace(self.description, input_degree=degree, can_restore=None not in self._inside)
        return told

    def begin(self, values: Mapping[str, Any], t: float, stop: float) -> None:
        self._slave.begin(values, t, stop)
        if self._model is not None:
            self._model.begin({n: v for n, v in values.items() if n in self._model.description.settable}, t, stop)
        self._start_anew()

    def finish(self) -> None:
        self._slave.finish()
        if self._model is not None:
            self._model.finish()
        self._start_anew()  # what arrived before was on the way to the start

    def _start_anew(self) -> None:
        self._filters: list[Filter] | None = None
        self._controller = PassivityController()
        self._now: tuple[list[np.ndarray], PassivityController, float] | None = None
        self._stored_first: float | None = None
        self._heat = 0.0

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        y = self._slave.output(u, t)
        signals = [y[self._rows]]
        if self._model is not None:
            signals.append(self._model.output(u, t)[self._model_rows])
        if self._filters is None:
            self._filters = [Filter(self._taps, signals[0]), *(Filter(self._plain, s) for s in signals[1:])]
        w, heat = self._filters[0].value(signals[0]), 0.0
        if self._model is not None:
            w = w + signals[1] - self._filters[1].value(signals[1])
        controller = self._controller
        if self._passive:
            required, heat = self._required(y)
            w, controller = controller.corrected(u[self._places], w, self._step_length, required)
        self._now = signals, controller, heat
        y[self._rows] = w
        return y

    def _required(self, y: np.ndarray) -> tuple[float, float]:
        """What the unit must have absorbed by now (J), and the heat so far, a step's more each time."""
        stored, lost, motor = self._balance
        if stored is None or lost is None:
            return 0.0, 0.0
        if self._stored_first is None:
            self._stored_first = float(y[stored])
        heat = self._heat + self._step_length * float(y[lost] - (y[motor] if motor is not None else 0.0))
        return float(y[stored]) - self._stored_first + heat, heat

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        if self._now is None or self._filters is None:
            self.output(U[0], t)
        assert self._now is not None
        assert self._filters is not None
        signals, self._controller, self._heat = self._now
        self._filters = [f.copy() for f in self._filters]
        for one, v in zip(self._filters, signals, strict=True):
            one.push(v)
        self._slave.step(U, t, h)
        if self._model is not None:
            self._model.step(U, t, h)

    @property
    def counts(self) -> Counts:
        return counts(self._slave)

    def save(self) -> Any:
        inside = [one.save() for one in self._inside if one is not None]
        return inside, self._filters, self._controller, self._now, self._heat

    def restore(self, snapshot: Any) -> None:
        inside, self._filters, self._controller, self._now, self._heat = snapshot
        for one, state in zip(self._inside, inside, strict=True):
            if one is not None:
                one.restore(state)

    def discard(self, snapshot: Any) -> None:
        for one, state in zip(self._inside, snapshot[0], strict=True):
            if one is not None:
                one.discard(state)

    def close(self) -> None:
        self._slave.close()
        if self._model is not None:
            self._model.close()
