"""A slave behind a delayed, perhaps compensated interface. What the filters mean stands in gyro_cosim.hil.compensation."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyro_cosim.component.variables import BALANCE

from ..slaves.base import Slave, StateSpace
from .compensation import Compensator, Filter, PassivityController, Uncompensated, delay_taps


class DelayedSlave(Slave):
    """`slave`, whose efforts arrive `delay` (s) late; the other outputs (energies, angles) stay as they are.

    pairs : (place in u of the motion, row of y of the effort) of each bond.
    step : the macro step (s), to which the delay is related; a last, shorter step counts as a whole one.
    model : another slave with the same signals, for model-based prediction; it gets the same inputs.
    passive : whether a passivity controller stands at the end.
    """

    can_serialize = False
    raw = None

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
        self.name, self.inputs, self.outputs, self.settable = slave.name, slave.inputs, slave.outputs, slave.settable
        self.excluded, self.input_degree = slave.excluded, slave.input_degree
        self.can_restore = slave.can_restore and (model is None or model.can_restore)
        self.feedthrough = slave.feedthrough.copy()
        self.initial_feedthrough = (slave.feedthrough if slave.initial_feedthrough is None else slave.initial_feedthrough).copy()
        if delay_taps(delay / step)[0] == 0.0 and model is None:
            self.feedthrough[self._rows] = False
        if passive:
            self.feedthrough[np.ix_(self._rows, self._places)] = True
            self.initial_feedthrough[np.ix_(self._rows, self._places)] = True
        if model is not None:
            names = [signal.name for signal in model.outputs]
            self._model_rows = np.array([names.index(slave.outputs[row].name) for row in self._rows], dtype=int)

    def begin(self, values: Mapping[str, Any], t: float, stop: float) -> None:
        self._slave.begin(values, t, stop)
        if self._model is not None:
            self._model.begin({n: v for n, v in values.items() if n in self._model.settable}, t, stop)
        self._start_anew()

    def finish(self) -> None:
        self._slave.finish()
        self.events = self._slave.events
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
        self.events = self._slave.events
        if self._model is not None:
            self._model.step(U, t, h)

    def save(self) -> Any:
        model = None if self._model is None else self._model.save()
        return self._slave.save(), model, self._filters, self._controller, self._now, self._heat

    def restore(self, snapshot: Any) -> None:
        inner, model, self._filters, self._controller, self._now, self._heat = snapshot
        self._slave.restore(inner)
        self.events = self._slave.events
        if self._model is not None:
            self._model.restore(model)

    def discard(self, snapshot: Any) -> None:
        self._slave.discard(snapshot[0])
        if self._model is not None:
            self._model.discard(snapshot[1])

    def serialize(self) -> bytes:
        raise ValueError(f"component {self.name!r} stands behind a delay and cannot serialize its state")

    def deserialize(self, data: bytes) -> None:
        raise ValueError(f"component {self.name!r} stands behind a delay and cannot serialize its state")

    def jacobian(self) -> np.ndarray | None:
        return None

    def state_space(self) -> StateSpace | None:
        return None

    def close(self) -> None:
        self._slave.close()
        if self._model is not None:
            self._model.close()
