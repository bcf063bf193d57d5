"""A scenario in a network: from names and texts to slaves, inputs, and what they follow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from gyro_cosim.component.units import quantity

from ..errors import unknown
from ..slaves import Signal, Slave, Value, tunable
from ..systems import Event, System
from ..systems.courses import Course, Piece
from ..systems.quantities import Quantity, between, parsed
from ..systems.scenario import OF_CONNECTIONS

Input = tuple[int, int]  # slave, place in its u


@dataclass(frozen=True)
class Tuned:
    """A parameter that changes: of slave `i`, by its name; `course` in its own unit."""

    i: int
    name: str
    course: Course


@dataclass(frozen=True)
class Fault:
    """From `at` (s) on a connected input is factor * what comes + value; value NaN: what it is then, which it keeps.

    place : among all faults of the network.
    """

    at: float
    factor: float
    value: float
    place: int


def what_happens(
    system: System, slaves: Sequence[Slave], connected: Mapping[Input, str], values: Sequence[Mapping[str, Value]],
    starts: Sequence[np.ndarray], courses: dict[Input, Course],
) -> tuple[tuple[Tuned, ...], dict[Input, tuple[Fault, ...]]]:  # fmt: skip
    """What the system's scenario comes to: parameters that change, and faults of connections; parameters see what_drives().

    courses : (slave, place in u) of an open input -> what it follows, to be filled and changed.
    """
    assert system.scenario is not None
    where = system.scenario.where
    of_target: dict[tuple[int, str], list[Event]] = {}
    for event in system.scenario.events:
        for i, name in _targets(system, slaves, event, where):
            of_target.setdefault((i, name), []).append(event)
    tuned: list[Tuned] = []
    faults: dict[Input, tuple[Fault, ...]] = {}
    count = 0
    for (i, name), events in of_target.items():
        slave, target = slaves[i], f"{slaves[i].name}.{name}"
        _refuse_meetings(events, target, where)
        names = [signal.name for signal in slave.inputs]
        j = names.index(name) if name in names else -1
        _check_kinds(events, target, connected.get((i, j), ""), is_input=j >= 0, where=where)
        if (i, j) in connected:
            made = []
            for event in events:
                made.append(_fault(event, slave.inputs[j], float(starts[i][j]), count, f"{where}: {target}"))
                count += 1
            faults[i, j] = tuple(made)
        elif j >= 0:
            base = courses.get((i, j), Course.constant(float(starts[i][j])))
            courses[i, j] = _followed(base, events, slave.inputs[j], f"{where}: {target}")
        else:
            signal = _tunable(slave, name, target, where)
            given = values[i].get(name, signal.start)
            if not isinstance(given, int | float):
                raise ValueError(f"{where}: {target} must have a start value that is a number, got {given!r}")
            tuned.append(Tuned(i, name, _followed(Course.constant(float(given)), events, signal, f"{where}: {target}")))
    return tuple(tuned), faults


def _targets(system: System, slaves: Sequence[Slave], event: Event, where: str) -> list[tuple[int, str]]:
    """The slaves and variables that an event means; ValueError with the nearest name where there are none."""
    full = system.full(event.target)
    name = system.owner(full) or full.partition(".")[0]
    variable = full[len(name) + 1 :]
    try:
        meant = system.addressed(name)
    except ValueError as error:
        raise ValueError(f"{where}: {event.does} at t = {event.at:g} s: {error}") from None
    found = [(i, variable) for i, slave in enumerate(slaves) if slave.name in meant]
    for i, _ in found:
        known = {s.name for s in slaves[i].inputs} | {
            n for n, s in slaves[i].description.settable.items() if s.kind == "parameter"
        }
        if variable not in known:
            outputs = [s.name for s in slaves[i].outputs]
            feeds = [".".join(c.end) for c in system.connections if c.start == (slaves[i].name, variable)]
            if variable in outputs and feeds:
                raise ValueError(f"{where}: {full} is an output: name the input of its connection, {' or '.join(feeds)}")
            raise ValueError(f"{where}: {unknown(f'input or parameter of {slaves[i].name!r}:', variable, known)}")
    return found


def _refuse_meetings(events: Sequence[Event], target: str, where: str) -> None:
    for before, after in pairwise(events):
        if after.at < before.end or after.at == before.at:
            until = f" to {before.end:g} s" if before.over else ""
            raise ValueError(
                f"{where}: events of {target} must follow one another, {before.does} at t = {before.at:g} s{until} and "
                f"{after.does} at t = {after.at:g} s meet"
            )


def _check_kinds(events: Sequence[Event], target: str, source: str, *, is_input: bool, where: str) -> None:
    for event in events:
        if event.does == "restore":
            continue
        of_connection = event.does in OF_CONNECTIONS
        if of_connection and not source:
            what = "an input that nothing is connected to" if is_input else "a parameter"
            raise ValueError(f"{where}: {event.does} is for connections, {target} is {what}: use set or ramp")
        if not of_connection and source:
            raise ValueError(f"{where}: {event.does} is for parameters and open inputs, {source} feeds {target}: use override")


def _fault(event: Event, signal: Signal, start: float, place: int, where: str) -> Fault:
    if event.does in ("offset", "scale") and signal.type != "real":
        raise ValueError(f"{where}: {event.does} must be of a real input, it is of type {signal.type}")
    if event.does == "override":
        return Fault(event.at, 0.0, _number(event, signal, where), place)
    if event.does == "offset":
        return Fault(event.at, 1.0, _difference(event.value, signal, where), place)
    if event.does == "scale":
        return Fault(event.at, _factor(event.value, where), 0.0, place)
    if event.does == "drop":
        return Fault(event.at, 0.0, start, place)
    return Fault(event.at, 0.0 if event.does == "freeze" else 1.0, np.nan if event.does == "freeze" else 0.0, place)


def _number(event: Event, signal: Signal, where: str) -> float:
    given: Any = str(event.value).lower() if isinstance(event.value, bool) else event.value
    try:
        value = signal.value(given)
    except ValueError as error:
        raise ValueError(f"{where} at t = {event.at:g} s {error}") from None
    if not isinstance(value, float | int):
        raise ValueError(f"{where} must be a single number to change in a run, it is of type {signal.type}")
    return float(value)


def _difference(given: Any, signal: Signal, where: str) -> float:
    """A difference in the signal's unit."""
    try:
        given_as = parsed(given, signal.unit, signal.measure) if isinstance(given, str) else Quantity(float(given))
        value = given_as.value * between(given_as.unit, signal.measure)[0]
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: offset must be by a number: {error}") from None
    if not np.isfinite(value):
        raise ValueError(f"{where}: offset must be by a finite number, got {given!r}")
    return value


def _factor(given: Any, where: str) -> float:
    try:
        value = quantity(given, "1") if isinstance(given, str) else float(given)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: scale must be by a plain number: {error}") from None
    if not np.isfinite(value):
        raise ValueError(f"{where}: scale must be by a finite number, got {given!r}")
    return value


def _tunable(slave: Slave, name: str, target: str, where: str) -> Signal:
    able = tunable(slave)
    known = frozenset() if able is None else able.description.tunable
    if name not in known:
        can = ", ".join(sorted(known)) or "none"
        raise ValueError(f"{where}: parameter {target} must be tunable to change in a run; tunable are: {can}")
    return slave.description.settable[name]


def _followed(base: Course, events: Sequence[Event], signal: Signal, where: str) -> Course:
    """The course `base` with events of values put over it, each until the next."""
    course = base
    for event in events:
        if event.does == "restore":
            pieces = base.after(event.at)
        elif event.does == "set":
            value = _number(event, signal, where)
            pieces = [Piece(event.at, np.inf, value, value)]
        else:
            if (not signal.smooth and signal.kind != "parameter") or signal.type != "real":
                raise ValueError(f"{where}: a ramp must be of a continuous number, use set")
            value, first = _number(event, signal, where), course.at(event.at)
            pieces = [Piece(event.at, event.end, first, value), Piece(event.end, np.inf, value, value)]
        course = course.followed_by(event.at, pieces)
    return course
