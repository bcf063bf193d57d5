"""Events of an FMI 3.0 FMU: what the master remembers of them, and the way through event mode.

An event is one passage through event mode after the start: because doStep asked for it (a state event), because the time has
come that the FMU had announced (a time event), or because a discrete input changes. FMI 2.0 has no such mode in
Co-Simulation: its FMUs deal with their events by themselves, and nobody can count them. Neither do the ticks of a component's
sampled part count, in this process or as an FMU.
"""

import ctypes
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..signal import Text
from ..tick import Tick, carried_tick, read_tick
from .clocks import Timer
from .description import Description
from .library import Library

UPDATES = 1000  # rounds after which the discrete states must have settled


@dataclass(frozen=True)
class EventState:
    """What the master has learnt from an FMU beside its state, saved and restored with it.

    events : handled since the start. due : when the next time event is (s). ends : it wants the run to end.
    discrete : its discrete inputs, as they were set last. texts : names and values of its text inputs, in the same way.
    timers : of its time-based clocks. expected : ticks of input clocks that are to come, in the order of time. ticked : of output
    clocks, which nobody has taken yet.
    """

    events: int = 0
    due: float = float("inf")
    ends: bool = False
    discrete: tuple[float, ...] = ()
    texts: tuple[tuple[str, Text], ...] = ()
    timers: tuple[Timer, ...] = ()
    expected: tuple[Tick, ...] = ()
    ticked: tuple[Tick, ...] = ()

    def packed(self) -> bytes:
        """As bytes, the number of which stands in the last four."""
        texts = [(name, text if isinstance(text, str) else [text.hex()]) for name, text in self.texts]
        timers = [(timer.first, timer.interval, timer.k) for timer in self.timers]
        ticks = [[carried_tick(tick) for tick in some] for some in (self.expected, self.ticked)]
        data = json.dumps([self.events, self.due, self.ends, self.discrete, texts, timers, *ticks]).encode()
        return data + len(data).to_bytes(4, "little")

    @staticmethod
    def split(data: bytes) -> "tuple[bytes, EventState]":
        """What stands before the note of an FMU, and the note."""
        size = int.from_bytes(data[-4:], "little")
        try:
            events, due, ends, discrete, texts, timers, *ticks = json.loads(data[-4 - size : -4])
            expected, ticked = (tuple(read_tick(one) for one in some) for some in ticks)
        except (ValueError, TypeError):
            raise ValueError("a state must end with what the master knew of its FMU, this one does not") from None
        told = tuple((name, text if isinstance(text, str) else bytes.fromhex(text[0])) for name, text in texts)
        known = tuple(Timer(*one) for one in timers)
        return data[: -4 - size], EventState(events, due, ends, tuple(discrete), told, known, expected, ticked)


def used(description: Description) -> bool:
    """Whether event mode is used: where an FMU for Co-Simulation has one."""
    return description.can("hasEventMode") and not description.exchanged


def ticks(description: Description) -> bool:
    """Whether its clocks tick: where it has event mode, which by Model Exchange all have."""
    return description.version == "3" and (used(description) or description.exchanged)


def without_memory(description: Description) -> bool:
    """Whether time and continuous states are all that an FMU for Model Exchange remembers, so that they restore it.

    So it is where nothing of it is discrete, no event can happen, no clock ticks, and it is not told of completed steps.
    """
    if not description.exchanged:
        return False
    discrete = any(
        (row.variability == "discrete" and row.causality != "input") or row.type == "Clock" for row in description.rows
    )
    return not (discrete or description.indicators or hears_of_steps(description))


def hears_of_steps(description: Description) -> bool:
    """Whether an FMU for Model Exchange wants to hear of each completed step of the integrator."""
    if description.version == "2":
        return not description.can("completedIntegratorStepNotNeeded")
    return description.can("needsCompletedIntegratorStep")


class EventMode:
    """The functions that lead into event mode, through it, and back to step mode; `check` raises for a bad status."""

    def __init__(self, library: Library, check: Callable[[int, str, float, float], None]) -> None:
        pointer, boolean = ctypes.c_void_p, ctypes.c_bool
        self._check = check
        self._enter = library.function("fmi3EnterEventMode", pointer)
        self._update = library.function("fmi3UpdateDiscreteStates", pointer, *[pointer] * 6)
        self._step_mode = library.function("fmi3EnterStepMode", pointer)
        self._more, self._ends, self._defined, self._ignored = boolean(), boolean(), boolean(), boolean()
        self._due = ctypes.c_double()
        # nominals and values of continuous states are Model Exchange's business
        told = self._more, self._ends, self._ignored, self._ignored, self._defined, self._due
        self._told = tuple(ctypes.byref(one) for one in told)

    def enter(self, instance: Any, t: float, h: float) -> None:
        """From step mode."""
        self._check(self._enter(instance), "fmi3EnterEventMode", t, h)

    def leave(self, instance: Any, t: float, h: float, look: Callable[[], None]) -> tuple[float, bool, bool]:
        """Update until nothing changes, then to step mode: when the next time event is due (s), whether the FMU wants the run
        to end, and whether the updates came to an end. look : called before the first update and after each."""
        ends = settled = False
        look()
        for _ in range(UPDATES):
            self._check(self._update(instance, *self._told), "fmi3UpdateDiscreteStates", t, h)
            look()
            ends = ends or self._ends.value
            settled = ends or not self._more.value
            if settled:
                break
        self._check(self._step_mode(instance), "fmi3EnterStepMode", t, h)
        return (self._due.value if self._defined.value else float("inf")), ends, settled
