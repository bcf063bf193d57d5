"""An FMU for Model Exchange as a slave. How it moves stands in motion.py; here is what the master asks of every slave."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base import Clocked, Counting, Counts, Linearisable, Promised, Serializable, StateSpace, Texting, Tunable
from ..fmi.eventful import EventfulFmu
from ..fmi.events import EventState, without_memory
from ..fmi.fmu import FmuSlave
from ..fmi.log import Log
from ..fmi.ticking import Ticking, expecting
from ..inner_steps import Following, InnerSteps
from ..signal import Signal, Text, Value
from ..tick import Tick
from ..usage import Usage
from .abilities import integrated
from .functions import Functions
from .inputs import Inputs
from .motion import Known, Motion

TOLERANCE = 1e-6  # relative, where neither the FMU nor the run says


class ExchangeSlave(Serializable, Linearisable, Counting, Texting, Tunable, Promised, Clocked, Following):
    """Runs an FMU that is open for Model Exchange, and releases it in close().

    tolerance : relative, of the integration, to be set before begin(); the run's, else that of the FMU's DefaultExperiment, else
        TOLERANCE.

    An FMU that cannot save its state, but remembers nothing beyond time and continuous states, is saved by these.
    """

    def __init__(self, fmu: FmuSlave, tolerance: float | None = None) -> None:
        self._fmu, self.name, self.model = fmu, fmu.name, fmu.model
        self.tolerance = tolerance or fmu.tolerance or TOLERANCE
        self._describe()
        self._motion: Motion | None = None
        self._inner: InnerSteps | None = None
        self._t = 0.0
        self._u: np.ndarray | None = None  # until it moves, as the note is
        self._note = EventState()
        try:
            self._calls, self._inputs = Functions(fmu.library, self.model, fmu.check), Inputs(fmu)
            self._ticking = Ticking(fmu, fmu.library)
        except BaseException:
            fmu.close()
            raise

    @property
    def log(self) -> Log:
        """What the FMU says."""
        return self._fmu.log

    @property
    def file(self) -> tuple[str, str]:
        """Location and instantiation token of the FMU."""
        return self._fmu.file

    # ---- the run

    def promise(self, usage: Usage, values: Mapping[str, Value], t: float, stop: float) -> tuple[str, ...]:
        notes = self._fmu.promise(usage, values, t, stop)
        self.tolerance = self._fmu.tolerance or TOLERANCE
        self._describe()
        return notes

    def _describe(self) -> None:
        able = self._fmu.description
        self._by_states = not able.can_restore and without_memory(self.model)
        self.description = integrated(able, self.model)

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._stand_still()
        self._fmu.begin(values, t, stop)
        self._ticking.initialize(self._fmu.intervals if isinstance(self._fmu, EventfulFmu) else {}, t)
        self._t, self._u, self._note = t, None, EventState()

    def finish(self) -> None:
        self._fmu.finish()
        parts = self._fmu, self._calls, self._inputs, self._ticking
        self._motion = Motion(*parts, self.tolerance, self._t, self._u, self._note)
        if self._inner is not None:
            self._inner.go_back()
            self._motion.reached = self._tell

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        if self._motion is None:  # in initialization mode
            self._u = u.copy()
            return self._fmu.output(u, t)
        if u.size:
            self._motion.offer(u, t)
        return self._fmu.output(u[:0], t)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._moving.step(U, t, h)
        self._t = t + h

    def texts(self, t: float) -> tuple[Text, ...]:
        return self._fmu.texts(t)

    def give_texts(self, texts: Mapping[str, Text], t: float) -> bool:
        self._learn(replace(self._known_note, texts=tuple(sorted({**dict(self._known_note.texts), **texts}.items()))))
        if self._motion is None:
            return self._fmu.give_texts(texts, t)
        rows = self._fmu.changed_texts(texts)
        if rows:
            self._motion.through_event(lambda: self._fmu.put_texts(rows, t), t)
        return bool(rows)

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        """In event mode, as the standard wants it."""
        clocks = {name: float(values[name]) for name in values if name in self._ticking.periods}  # type: ignore[arg-type]

        def change() -> None:
            self._fmu.tune({name: value for name, value in values.items() if name not in clocks}, t)
            if clocks:
                self._learn(self._ticking.give(self._known_note, clocks, t))

        self._moving.through_event(change, t)

    def expect(self, ticks: Sequence[Tick]) -> None:
        self._learn(expecting(self._known_note, tuple(ticks)))

    def take_ticks(self) -> Sequence[Tick]:
        found, self._ticking.listening = self._known_note.ticked, True
        self._learn(replace(self._known_note, ticked=()))
        return found

    @property
    def _known_note(self) -> EventState:
        return self._note if self._motion is None else self._motion.known.note

    def _learn(self, note: EventState) -> None:
        if self._motion is None:
            self._note = note
        else:
            self._motion.learn(note)

    @property
    def _moving(self) -> Motion:
        assert self._motion is not None  # by the order of calls
        return self._motion

    def state_space(self) -> StateSpace | None:
        return self._fmu.state_space()

    @property
    def counts(self) -> Counts:
        return replace(self._fmu.counts, events=0 if self._motion is None else self._motion.known.note.events)

    def close(self) -> None:
        self._stand_still()
        self._fmu.close()

    def _stand_still(self) -> None:
        if self._motion is not None:
            self._motion.close()
            self._motion = None

    # ---- steps of the integrator

    @property
    def inner_signals(self) -> tuple[Signal, ...]:
        return self.outputs

    def follow(self) -> InnerSteps:
        self._inner = InnerSteps(self.outputs)
        return self._inner

    def _tell(self, t: float) -> None:
        if self._inner is not None:
            self._inner.add(t, self._fmu.output(np.empty(0), t).tolist())

    # ---- states

    def save(self) -> Any:
        motion = self._moving
        motion.fresh = True
        held = (self._t, motion.x.copy()) if self._by_states else self._fmu.save()
        return held, motion.known, self._t, None if self._inner is None else self._inner.mark()

    def restore(self, snapshot: Any) -> None:
        held, known, self._t, mark = snapshot
        if self._inner is not None:
            self._inner.go_back(mark)
        if self._by_states:
            self._moving.put_back(*held)
        else:
            self._fmu.restore(held)
        self._moving.back(known, self._t)

    def discard(self, snapshot: Any) -> None:
        if not self._by_states:
            self._fmu.discard(snapshot[0])

    def serialize(self) -> bytes:
        motion = self._moving
        motion.fresh = True
        held = motion.x.tobytes() if self._by_states else self._fmu.serialize()
        return held + motion.known.note.packed() + bytes(motion.known.positive) + struct.pack("<d", self._t)

    def deserialize(self, data: bytes) -> None:
        motion = self._moving
        (self._t,) = struct.unpack("<d", data[-8:])
        n_z, data = len(motion.known.positive), data[:-8]
        positive = tuple(bool(b) for b in data[len(data) - n_z :])
        held, note = EventState.split(data[: len(data) - n_z])
        if self._by_states:
            motion.put_back(self._t, np.frombuffer(held))
        else:
            self._fmu.deserialize(held)
        motion.back(Known(note, positive), self._t)
