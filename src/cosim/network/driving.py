"""What a network follows besides its connections: time series and scenarios, brought from names to slaves and inputs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import WiringError, unknown
from ..slaves import Signal, Slave, Value
from ..systems import InputSeries, System
from ..systems.courses import Course
from ..systems.quantities import between, meaning
from .scripted import Fault, Input, Tuned, what_happens


@dataclass(frozen=True)
class Driving:
    """What a scenario and time series come to in a network.

    Parameters
    ----------
    courses : mapping
        (slave, place in u) of an open input -> what it follows.
    tuned : tuple of Tuned
        Parameters that change.
    faults : mapping
        (slave, place in u) of a connected input -> what happens to it, in the order of time.
    """

    courses: Mapping[Input, Course] = field(default_factory=dict)
    tuned: tuple[Tuned, ...] = ()
    faults: Mapping[Input, tuple[Fault, ...]] = field(default_factory=dict)

    @property
    def frozen(self) -> int:
        """How many faults there are, each of which may keep a value."""
        return sum(map(len, self.faults.values()))

    def of_slave(self, i: int) -> dict[int, Course]:
        """Place in u -> what that open input of slave i follows."""
        return {j: course for (k, j), course in self.courses.items() if k == i}

    def starts(self, i: int, slave: Slave, t: float) -> dict[str, Value]:
        """The same by name, with the values at t (s)."""
        return {slave.inputs[j].name: course.at(t) for j, course in self.of_slave(i).items()}

    def __bool__(self) -> bool:
        return bool(self.courses or self.tuned or self.faults)


def what_drives(
    system: System, slaves: Sequence[Slave], connected: Mapping[Input, str], values: Sequence[Mapping[str, Value]],
    starts: Sequence[np.ndarray],
) -> Driving:  # fmt: skip
    """What the system's series and scenario come to.

    Parameters
    ----------
    system : System
        With `inputs` and `scenario`.
    slaves : sequence of Slave
        Its components.
    connected : mapping
        (slave, place in u) of every connected input -> the name of its source.
    values, starts : sequence
        Of each slave its start values by name, and those of its inputs.

    Raises
    ------
    ValueError
        Unknown names, values that do not fit, events of one target that meet.
    """
    courses: dict[Input, Course] = {}
    for series in system.inputs:
        i, j, signal = _input(system, slaves, series.target, series.where)
        if (i, j) in connected:
            raise WiringError(
                f"{series.where}: input {series.target} must be open, {connected[i, j]} is connected to it (a scenario can "
                "override it)"
            )
        if (i, j) in courses:
            raise WiringError(f"{series.where}: input {series.target} must have one series, has two")
        courses[i, j] = _course(series, signal)
    if system.scenario is None:
        return Driving(courses)
    return Driving(courses, *what_happens(system, slaves, connected, values, starts, courses))


def _input(system: System, slaves: Sequence[Slave], target: str, where: str) -> tuple[int, int, Signal]:
    full = system.full(target)
    owner = system.owner(full)
    known = [f"{slave.name}.{signal.name}" for slave in slaves for signal in slave.inputs]
    for i, slave in enumerate(slaves):
        for j, signal in enumerate(slave.inputs):
            if slave.name == owner and f"{owner}.{signal.name}" == full:
                return i, j, signal
    raise ValueError(f"{where}: {unknown('input', full, known)}")


def _course(series: InputSeries, signal: Signal) -> Course:
    """What an input follows: lines where it is continuous, else stairs; ValueError where unit or values do not fit."""
    what, values = f"{series.where}: {series.target}", series.values
    if series.unit and series.unit != signal.unit:
        unit = meaning(series.unit)
        if unit is None or (signal.measure is None and any(unit.dimension)):
            rule = f"must be in a unit that is known and fits {signal.unit!r}"
            raise ValueError(f"{what} {rule}, got {series.unit!r}")
        try:
            factor, offset = between(unit, signal.measure) if signal.measure is not None else (unit.factor, 0.0)
        except ValueError as error:
            raise ValueError(f"{what}: {error}") from None
        values = values * factor + offset
    for k in {0, values.size - 1, int(values.argmin()), int(values.argmax())} if signal.type == "real" else range(values.size):
        try:
            signal.value(float(values[k]))
        except ValueError as error:
            raise ValueError(f"{what} at t = {series.t[k]:g} s {error}") from None
    return Course.through(series.t.tolist(), values.tolist(), held=not signal.smooth)
