"""The ticks of an instance's clocks on its way: which are due, what is set and read where they happen, what has ticked.

Whoever takes the FMU through event mode calls `initialize` in initialization mode before it, and then, in this order and in
event mode but for due():

    begin   once, at the start of the run
    give    where intervals of clocks are given on the way
    due     when the next tick comes
    tick    those that are due
    look    before and after each update of the discrete states

What changes is a part of the note that is kept beside the FMU's state, see EventState.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..signal import Text, Value
from ..tick import Tick
from .buffers import Group
from .clocks import Clocks, clocked, is_given
from .events import EventState
from .fmu import FmuSlave
from .library import Library
from .rows import TEXTS, Row
from .signals import by_variable, carried, names

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class ClockedGroup:
    """A clocked input, and the names of its clocks."""

    group: Group
    clocks: frozenset[str]


class Ticking:
    """What an FMU does of its clocks in event mode; nothing where it has none.

    listening : whether anybody takes the ticks of its output clocks. intervals : of clocks (s), as they are given for the run.
    periods : names of the clocks whose intervals may be given.
    """

    intervals: Mapping[str, float] = MappingProxyType({})

    def __init__(self, fmu: FmuSlave, library: Library) -> None:
        ticks = fmu.description.counts_events or fmu.model.exchanged
        model = fmu.model if ticks else replace(fmu.model, rows=())
        self._fmu, self._clocks = fmu, Clocks(library, model, fmu.check)
        by_clock, rows = clocked(model), carried(model, "input")
        self._inputs = []
        for row in rows:
            if row.name in by_clock:
                (group,) = fmu.groups(rows, [other.name for other in rows if other is not row])
                self._inputs.append(ClockedGroup(group, frozenset(by_clock[row.name])))
        self._texts = {
            name: frozenset(by_clock[row.name])
            for row in model.rows
            if row.name in by_clock and row.type in TEXTS
            for name in names(row)
        }
        self.periods = frozenset(row.name for row in self._clocks.timed if is_given(row))
        self._rows = {row.name: row for row in model.rows}
        self._active: frozenset[str] = frozenset()
        self._own: tuple[str, ...] = ()  # time-based ones that have ticked, and nobody has looked yet
        self.listening = False

    def initialize(self, intervals: Mapping[str, float], t: float) -> None:
        """In initialization mode at t (s): give clocks these intervals (s), and ask for those that follow from parameters."""
        self.intervals = dict(intervals)
        self._clocks.give(self._fmu.instance, intervals, t)
        self._clocks.ask(self._fmu.instance, t)

    def begin(self, note: EventState, t: float) -> EventState:
        """The run begins at t (s)."""
        return replace(note, timers=self._clocks.timers(self._fmu.instance, self.intervals, t))

    def give(self, note: EventState, intervals: Mapping[str, float], t: float) -> EventState:
        """At t (s): tunable clocks get these intervals (s)."""
        self._clocks.give(self._fmu.instance, intervals, t)
        return replace(note, timers=self._clocks.given(note.timers, intervals))

    def due(self, note: EventState) -> float:
        """When the next input clock ticks (s)."""
        return min((*(timer.due for timer in note.timers), *(tick.t for tick in note.expected[:1])), default=np.inf)

    def own_due(self, note: EventState) -> float:
        """When the next time-based clock ticks (s)."""
        return min((timer.due for timer in note.timers), default=np.inf)

    def tick(self, note: EventState, u: np.ndarray | None, t: float, h: float) -> EventState:
        """At t (s), in or at an end of a step of h (s): tick what is due, with clocked inputs as in u.

        u : None where it is not known yet; the inputs then keep what they have.
        """
        until = t + 2e-9 * h + 8 * EPS * (abs(t) + h)
        due = set(self._clocks.due(note.timers, until))
        own, told = frozenset(due), dict(note.texts)
        values: dict[int, float] = {}
        arrived = [tick for tick in note.expected if tick.t <= until]
        for tick in arrived:
            due |= set(tick.clocks)
            values |= dict(tick.u)
            told |= tick.texts
        self._active, self._own = frozenset(due), tuple(sorted(own))
        if due:
            self._clocks.activate(self._fmu.instance, sorted(due), t, h)
            self._set_inputs(u, values, t, h)
            self._fmu.put_texts(self._due_texts(told), t)
        return replace(
            note, timers=self._clocks.ticked(note.timers, own), expected=note.expected[len(arrived) :],
            texts=tuple(sorted(told.items())),
        )  # fmt: skip

    def _set_inputs(self, u: np.ndarray | None, told: dict[int, float], t: float, h: float) -> None:
        """The clocked inputs whose clocks tick: as told with a tick, else as in u."""
        for one in self._inputs:
            if not one.clocks & self._active:
                continue
            group = one.group
            places = np.arange(len(self._fmu.inputs))[group.places]
            if u is None:
                self._fmu.check(group.get(self._fmu.instance), group.label.replace("Set", "Get"), t, h)
            else:
                group.buffer[:] = u[group.places]
            for k, place in enumerate(places.tolist()):
                if place in told:
                    group.buffer[k] = told[place]
            self._fmu.check(group.set(self._fmu.instance), group.label, t, h)

    def _due_texts(self, told: dict[str, Text]) -> list[tuple[Row, list[Value]]]:
        """The clocked text inputs whose clocks tick, as far as anybody has told what they are."""
        known: dict[str, Value] = {
            name: told[name] for name, clocks in self._texts.items() if name in told and clocks & self._active
        }
        return list(by_variable(self._rows, known))

    def look(self, note: EventState, t: float) -> EventState:
        """At t (s): note output clocks that tick, time-based ones that have ticked, and intervals that change."""
        timers = self._clocks.asked(self._fmu.instance, note.timers, self._active, t)
        clocks = (*self._clocks.ticking(self._fmu.instance, t), *self._own) if self.listening else ()
        self._own = ()
        if not clocks:
            return replace(note, timers=timers) if timers != note.timers else note
        fmu = self._fmu
        texts = dict(zip((s.name for s in fmu.description.text_outputs), fmu.texts(t), strict=True))
        tick = Tick(t, clocks, tuple(fmu.output(np.zeros(0), t).tolist()), (), texts)
        return replace(note, timers=timers, ticked=(*note.ticked, tick))

    def leave(self) -> None:
        """Event mode ends."""
        self._active = frozenset()


def expecting(note: EventState, ticks: tuple[Tick, ...]) -> EventState:
    """The note, with ticks of input clocks that are to come."""
    return replace(note, expected=tuple(sorted((*note.expected, *ticks), key=lambda tick: tick.t)))
