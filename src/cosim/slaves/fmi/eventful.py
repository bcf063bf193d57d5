"""What an FMI 3.0 FMU does in event mode, where it has one: discrete inputs, texts, clocks and tunable parameters change there.

How it comes there within a step stands in fmi3.py; what is remembered of it in events.py, of its clocks in ticking.py.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from ...errors import SlaveError
from ..base import Clocked
from ..description import SlaveDescription
from ..signal import Text, Value
from ..tick import Tick
from . import events
from .buffers import present
from .rows import Row
from .ticking import Ticking, expecting
from .told_steps import SteppingFmu


class EventfulFmu(SteppingFmu, Clocked):
    """Leads an FMU through event mode.

    _discrete : places of the inputs that change there only. _inputs_known : whether the inputs at the start have been told.
    intervals : of its clocks (s), as far as they are given for the run.
    """

    _discrete: np.ndarray
    _event_mode: events.EventMode | None
    _inputs_known: bool
    ticking: Ticking
    intervals: Mapping[str, float] = MappingProxyType({})

    def _adopt(self, description: SlaveDescription) -> None:
        """With event mode or without."""
        super()._adopt(description)
        if bool(description.clocked) != bool(self.by_clock):
            self._describe()
        self._discrete = np.flatnonzero([not s.smooth and s.name not in description.clocked for s in self.inputs])
        with_events, self.ticking = description.counts_events, Ticking(self, self._opened.library)
        self._event_mode = events.EventMode(self._opened.library, self.check) if with_events else None
        self._put = self._put_with_events if with_events and (self._discrete.size or self.by_clock) else self._set_inputs

    def _set_starts(self, rows: Sequence[tuple[Row, list[Value]]], t: float) -> None:
        """Those of clocks are their intervals, which are given in initialization mode."""
        clocks = {row.name: float(value) for row, (value, *_) in rows if row.type == "Clock"}  # type: ignore[arg-type]
        if clocks and not self.ticking.periods:
            raise SlaveError(self.name, t, 0.0, f"clock {min(clocks)!r} ticks in event mode only, in which the FMU cannot be run")
        self.intervals = {**self.intervals, **clocks}
        super()._set_starts([(row, values) for row, values in rows if row.name not in clocks], t)

    def _first_events(self, t: float) -> None:
        """At the end of initialization mode, where the FMU is in event mode if it has one: at the start of the run, t (s)."""
        if self._event_mode is None:
            return
        if self._discrete.size:
            u = present(self._input_groups, self._instance, np.zeros(self._u.size), self.check, t)
            self._learn(replace(self._note, discrete=tuple(u[self._discrete].tolist())))
        u0 = self._u if self._inputs_known else None
        self._learn(self.ticking.tick(self.ticking.begin(self._note, t), u0, t, 0.0))
        self._leave_event_mode(t, 0.0)

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        """In event mode where the FMU has one, as the standard wants it there."""
        if self._event_mode is None:
            super().tune(values, t)
        else:
            self._through_event(partial(self._tune, values, t), t)

    def _tune(self, values: Mapping[str, Value], t: float) -> None:
        """In event mode; what is given to a tunable clock is its interval."""
        clocks = {name: float(values[name]) for name in values if name in self.ticking.periods}  # type: ignore[arg-type]
        super().tune({name: value for name, value in values.items() if name not in clocks}, t)
        if clocks:
            self._learn(self.ticking.give(self._note, clocks, t))

    def give_texts(self, texts: Mapping[str, Text], t: float) -> bool:
        """They are discrete inputs, too."""
        rows = self.changed_texts(texts)
        if rows and self._event_mode is not None and not self._mode:
            self._through_event(partial(self.put_texts, rows, t), t)
        elif rows:
            self.put_texts(rows, t)
        return bool(rows)

    def _put_with_events(self, u: np.ndarray, t: float, h: float) -> None:
        """Discrete inputs of an FMU with event mode change there only; before that it sets them in initialization mode."""
        self._u[:], self._inputs_known = u, True
        if self._mode or tuple(u[self._discrete].tolist()) == self._note.discrete:
            self._set_inputs(u, t, h)
        else:
            self._handle_event(u, t, h)

    def _handle_event(self, u: np.ndarray, t: float, h: float) -> None:
        """Through event mode at t (s), where the inputs are u."""

        def happen() -> None:
            self._set_inputs(u, t, h)
            self._learn(self.ticking.tick(replace(self._note, discrete=tuple(u[self._discrete].tolist())), u, t, h))

        self._through_event(happen, t, h)

    def _through_event(self, change: Callable[[], None], t: float, h: float = 0.0) -> None:
        """Through event mode at t (s), where `change` is done."""
        assert self._event_mode is not None
        self._event_mode.enter(self._instance, t, h)
        change()
        self._learn(replace(self._note, events=self._note.events + 1))
        self._leave_event_mode(t, h)

    def expect(self, ticks: Sequence[Tick]) -> None:
        self._learn(expecting(self._note, tuple(ticks)))

    def take_ticks(self) -> Sequence[Tick]:
        found, self.ticking.listening = self._note.ticked, True
        self._learn(replace(self._note, ticked=()))
        return found

    def _leave_event_mode(self, t: float, h: float) -> None:
        assert self._event_mode is not None
        look = partial(self.ticking.look, t=t)
        due, ends, settled = self._event_mode.leave(self._instance, t, h, lambda: self._learn(look(self._note)))
        self.ticking.leave()
        self._learn(replace(self._note, due=due, ends=self._note.ends or ends))
        if not settled:
            self._fails(f"the discrete states must settle, they do not in {events.UPDATES} updates", t, h)

    def _fails(self, reason: str, t: float, h: float) -> None:
        self._running = False
        raise SlaveError(self.name, t, h, reason, self.log.said())
