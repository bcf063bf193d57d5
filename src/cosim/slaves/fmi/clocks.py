"""Clocks of an FMU with event mode: when its time-based input clocks tick, and what is asked and told in event mode.

constant            at start + shift + k interval, as the description says
fixed, tunable      the same where the description states an interval: whoever runs the FMU may give it another one, of a fixed
                    clock before the run, of a tunable one also on the way. Where it states none, the FMU says in initialization
                    mode what follows from its parameters, and in event mode where tunable ones have changed
changing            each tick says how long it is to the next
countdown           the FMU says in event mode that a tick comes after an interval, once
triggered           input: where another component's clock ticks it; output: the FMU says in event mode whether it ticks

An interval that has changed counts from the last tick on.
"""

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

from .description import Description
from .library import POINTER, REFERENCES, SIZE, Library
from .rows import Row

UNCHANGED, CHANGED = 1, 2  # of fmi3IntervalQualifier


@dataclass(frozen=True)
class Timer:
    """When a clock ticks next: at first + k interval (s); first is inf while that is not known."""

    first: float = inf
    interval: float = 0.0
    k: int = 0

    @property
    def due(self) -> float:
        """s."""
        return self.first + self.k * self.interval


def time_based(model: Description) -> list[Row]:
    """The input clocks that the master ticks by itself."""
    return [row for row in _clocks(model, "input") if row.timing.get("intervalVariability") != "triggered"]


def triggered(model: Description) -> list[Row]:
    """The input clocks that other components tick."""
    return [row for row in _clocks(model, "input") if row.timing.get("intervalVariability") == "triggered"]


def announced(model: Description) -> list[Row]:
    """The output clocks."""
    return _clocks(model, "output")


def is_given(row: Row) -> bool:
    """Whether a clock has an interval that whoever runs the FMU may give."""
    periodic = row.causality == "input" and row.timing.get("intervalVariability") in ("fixed", "tunable")
    return row.type == "Clock" and periodic and "intervalDecimal" in row.timing


def clocked(model: Description) -> dict[str, tuple[str, ...]]:
    """The names of the clocks of each clocked input."""
    names = {row.reference: row.name for row in reversed(model.rows) if row.type == "Clock"}
    rows = [row for row in model.rows if row.causality == "input" and row.type != "Clock" and row.clocks]
    return {row.name: tuple(names[reference] for reference in row.clocks if reference in names) for row in rows}


def _clocks(model: Description, causality: str) -> list[Row]:
    return [row for row in model.rows if row.type == "Clock" and row.causality == causality]


class Clocks:
    """The clocks of an instance's FMU; `check` raises for a bad status."""

    def __init__(self, library: Library, model: Description, check: Callable[[int, str, float, float], None]) -> None:
        self._library, self._check = library, check
        self.timed, self._announced = time_based(model), announced(model)
        self._references = {row.name: row.reference for row in (*self.timed, *triggered(model))}
        self._flags = (ctypes.c_bool * len(self._announced))()
        self._outputs = (ctypes.c_uint * len(self._announced))(*(row.reference for row in self._announced))
        self._said: dict[str, tuple[float, float]] = {}  # interval and shift (s), of those whose description states none

    def ask(self, instance: Any, t: float) -> None:
        """In initialization mode at t (s): what follows from the parameters of the run."""
        get = ("fmi3GetShiftDecimal", POINTER, REFERENCES, SIZE, POINTER)
        for row in self.timed:
            if row.timing["intervalVariability"] in ("fixed", "tunable") and _stated(row, "interval") is None:
                _, interval = self._interval(instance, row, t)
                shift = ctypes.c_double()
                status = self._library.function(*get)(instance, _one(row), 1, ctypes.byref(shift))
                self._check(status, f"fmi3GetShiftDecimal of {row.name!r}", t, 0.0)
                self._said[row.name] = interval, shift.value

    def give(self, instance: Any, intervals: Mapping[str, float], t: float) -> None:
        """In initialization mode or event mode at t (s): intervals (s) of clocks as whoever runs the FMU wants them."""
        for name, interval in intervals.items():
            put = self._library.function("fmi3SetIntervalDecimal", POINTER, REFERENCES, SIZE, POINTER)
            status = put(instance, (ctypes.c_uint * 1)(self._references[name]), 1, ctypes.byref(ctypes.c_double(interval)))
            self._check(status, f"fmi3SetIntervalDecimal of {name!r} to {interval:g} s", t, 0.0)

    def timers(self, instance: Any, given: Mapping[str, float], t: float) -> tuple[Timer, ...]:
        """From the start of the run at t (s), in the first event mode. given : intervals (s) that whoever runs it gives."""
        return tuple(self._timer(instance, row, given, t) for row in self.timed)

    def _timer(self, instance: Any, row: Row, given: Mapping[str, float], t: float) -> Timer:
        kind = row.timing["intervalVariability"]
        if kind == "countdown":
            return self._asked(instance, row, Timer(), t, ticked=False)
        who = "the FMU" if row.name in self._said else "the description"
        interval, shift = self._said.get(row.name, (_stated(row, "interval"), _stated(row, "shift")))
        interval = given.get(row.name, interval)
        if kind in ("constant", "fixed") or row.name in self._said:
            if interval is None or not 0.0 < interval < inf:
                raise ValueError(f"clock {row.name!r} must have an interval above 0, {who} says {interval}")
            return Timer(t + (shift or 0.0), interval)
        qualifier, asked = self._interval(instance, row, t)
        if row.name not in given and (qualifier == CHANGED or (qualifier == UNCHANGED and interval is None)):
            interval = asked
        return Timer() if interval is None or interval <= 0.0 else Timer(t + (shift or 0.0), interval)

    def _interval(self, instance: Any, row: Row, t: float) -> tuple[int, float]:
        """Qualifier and interval (s) that the FMU tells at t (s)."""
        value, qualifier = ctypes.c_double(), ctypes.c_int()
        get = self._library.function("fmi3GetIntervalDecimal", POINTER, REFERENCES, SIZE, POINTER, POINTER)
        status = get(instance, _one(row), 1, ctypes.byref(value), ctypes.byref(qualifier))
        self._check(status, f"fmi3GetIntervalDecimal of {row.name!r}", t, 0.0)
        return qualifier.value, value.value

    def activate(self, instance: Any, names: Collection[str], t: float, h: float) -> None:
        """In event mode: these input clocks tick at t (s)."""
        if names:
            n, activate = len(names), self._library.function("fmi3SetClock", POINTER, REFERENCES, SIZE, POINTER)
            references = (ctypes.c_uint * n)(*(self._references[name] for name in names))
            self._check(activate(instance, references, n, (ctypes.c_bool * n)(*[True] * n)), "fmi3SetClock", t, h)

    def due(self, timers: Sequence[Timer], until: float) -> list[str]:
        """The time-based clocks that tick not later than `until` (s)."""
        return [row.name for row, timer in zip(self.timed, timers, strict=True) if timer.due <= until]

    def ticking(self, instance: Any, t: float) -> tuple[str, ...]:
        """In event mode: the output clocks that tick at t (s)."""
        if not self._announced:
            return ()
        get = self._library.function("fmi3GetClock", POINTER, REFERENCES, SIZE, POINTER)
        self._check(get(instance, self._outputs, len(self._flags), self._flags), "fmi3GetClock", t, 0.0)
        return tuple(row.name for row, ticks in zip(self._announced, self._flags, strict=True) if ticks)

    def ticked(self, timers: Sequence[Timer], names: Collection[str]) -> tuple[Timer, ...]:
        """After these clocks have ticked; what is not periodic has to be asked for."""
        found = []
        for row, timer in zip(self.timed, timers, strict=True):
            once = row.timing["intervalVariability"] == "countdown"
            after = Timer() if once else replace(timer, k=timer.k + 1)
            found.append(after if row.name in names else timer)
        return tuple(found)

    def asked(self, instance: Any, timers: Sequence[Timer], names: Collection[str], t: float) -> tuple[Timer, ...]:
        """In event mode at t (s), where `names` have ticked: what the FMU says of intervals that are not fixed."""
        return tuple(
            self._asked(instance, row, timer, t, ticked=row.name in names)
            if row.timing["intervalVariability"] not in ("constant", "fixed")
            else timer
            for row, timer in zip(self.timed, timers, strict=True)
        )

    def given(self, timers: Sequence[Timer], intervals: Mapping[str, float]) -> tuple[Timer, ...]:
        """Where intervals (s) of tunable clocks have been given on the way."""
        return tuple(
            _from_last_tick(timer, intervals[row.name]) if row.name in intervals else timer
            for row, timer in zip(self.timed, timers, strict=True)
        )

    def _asked(self, instance: Any, row: Row, timer: Timer, t: float, *, ticked: bool) -> Timer:
        qualifier, interval = self._interval(instance, row, t)
        kind = row.timing["intervalVariability"]
        if kind == "countdown":
            return Timer(t + interval) if qualifier == CHANGED else timer
        if qualifier != CHANGED or interval <= 0.0:
            return timer
        if timer.first == inf or ticked:  # from here on
            return Timer(t, interval, 1)
        return _from_last_tick(timer, interval) if kind == "tunable" and interval != timer.interval else timer


def _from_last_tick(timer: Timer, interval: float) -> Timer:
    """With another interval (s), which counts from its last tick on; before the first one it is where it was."""
    return Timer(timer.due - timer.interval, interval, 1) if timer.k > 0 else Timer(timer.first, interval)


def _stated(row: Row, what: str) -> float | None:
    """Interval or shift (s) as the description states it."""
    if f"{what}Decimal" in row.timing:
        return float(row.timing[f"{what}Decimal"])
    if f"{what}Counter" in row.timing and "resolution" in row.timing:
        return float(row.timing[f"{what}Counter"]) / float(row.timing["resolution"])
    return None


def _one(row: Row) -> Any:
    return (ctypes.c_uint * 1)(row.reference)
