"""What happens during a run by plan: values set or ramped, connections that fail and are mended. A plan; it does nothing.

    [[event]]
    at = "10 s"
    set = "gyro.gimbal_damping"       # a tunable parameter, or an input that nothing is connected to
    to = 0.01                         # in its own unit, or "0.01 N.m.s/rad"

    [[event]]
    at = "12 s"
    ramp = "vehicle.speed"            # the same in a line,
    to = "12 m/s"
    over = "5 s"                      # that takes so long

    [[event]]
    at = "20 s"
    freeze = "vehicle.yaw_moment"     # a connection, named by the input where it ends

    [[event]]
    at = "21 s"
    restore = "vehicle.yaw_moment"    # as if nothing had happened

`override` (with `to`) gives a connected input a value, `offset` and `scale` (with `by`) add to it and multiply it, `freeze` keeps
the value that it has, `drop` gives it its start value, as if nothing were connected. A later event of the same target takes
the place of the one before.
"""

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gyro_cosim.component.units import quantity

from ..errors import unknown

OF_VALUES = ("set", "ramp")  # parameters and open inputs
OF_CONNECTIONS = ("override", "freeze", "drop", "offset", "scale")
DEEDS = (*OF_VALUES, *OF_CONNECTIONS, "restore")
_WANTS = {"set": "to", "ramp": "to", "override": "to", "offset": "by", "scale": "by"}


@dataclass(frozen=True)
class Event:
    """Something that happens at a time.

    Parameters
    ----------
    at : float
        When, s.
    does : str
        One of DEEDS.
    target : str
        `component.variable`; the component as System.addressed() takes it.
    value : number, str or None
        What `to` or `by` says, in the target's unit where it says none.
    over : float
        How long a ramp takes, s.
    """

    at: float
    does: str
    target: str
    value: Any = None
    over: float = 0.0

    def __post_init__(self) -> None:
        if self.does not in DEEDS:
            raise unknown("event:", self.does, DEEDS)
        if not (self.at == self.at and abs(self.at) != float("inf")):
            raise ValueError(f"{self.does} {self.target}: the time must be finite, got {self.at:g} s")
        wants = _WANTS.get(self.does)
        if (self.value is None) != (wants is None):
            rule = f"must say `{wants}` which value" if wants else "takes no value"
            raise ValueError(f"{self.does} {self.target} at t = {self.at:g} s {rule}")
        if self.does == "ramp" and not 0.0 < self.over < float("inf"):
            raise ValueError(f"ramp {self.target} at t = {self.at:g} s must take a positive time, got {self.over:g} s")
        if self.does != "ramp" and self.over:
            raise ValueError(f"{self.does} {self.target} at t = {self.at:g} s takes no time, only a ramp has `over`")

    @property
    def end(self) -> float:
        """When it is complete, s."""
        return self.at + self.over


@dataclass(frozen=True)
class Scenario:
    """Events in the order of their times.

    Parameters
    ----------
    events : tuple of Event
        At least one.
    where : str
        Where they come from, for messages.
    """

    events: tuple[Event, ...]
    where: str = field(default="scenario", compare=False)

    def __post_init__(self) -> None:
        if not self.events:
            raise ValueError(f"{self.where} must hold an [[event]] at least")
        object.__setattr__(self, "events", tuple(sorted(self.events, key=lambda event: event.at)))

    @property
    def has_faults(self) -> bool:
        """Whether a connection is interfered with."""
        return any(event.does in OF_CONNECTIONS for event in self.events)


def read_scenario(file: str | Path) -> Scenario:
    """The scenario in a TOML file; ValueError names file, event, key and rule."""
    where = f"scenario {str(file)!r}"
    document = read_toml(file, where)
    for key in document:
        if key != "event":
            raise ValueError(f"{where}: {unknown('key', key, ('event',))}")
    tables = document.get("event", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise ValueError(f"{where}: events must be tables [[event]]")
    return Scenario(tuple(_event(table, f"{where}, event {k}") for k, table in enumerate(tables, 1)), where)


def written(scenario: Scenario) -> str:
    """The text of a scenario's TOML file, from which the same comes back."""
    return "\n".join(_table(event) for event in scenario.events)


def _table(event: Event) -> str:
    lines = ["[[event]]", f"at = {_toml(event.at)}", f"{event.does} = {_toml(event.target)}"]
    wants = _WANTS.get(event.does)
    lines += [f"{wants} = {_toml(event.value)}"] if wants else []
    lines += [f"over = {_toml(event.over)}"] if event.over else []
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    """A number with all its digits, or a text: JSON's way of writing both is TOML's, too."""
    return repr(float(value)) if isinstance(value, int | float) and not isinstance(value, bool) else json.dumps(value)


def read_toml(file: str | Path, where: str) -> dict[str, Any]:
    """The document in a TOML file; ValueError begins with `where`."""
    try:
        return tomllib.loads(Path(file).read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{where} cannot be read: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{where} must be TOML: {error}") from None
    except RecursionError:
        raise ValueError(f"{where} must be TOML that is nested less deeply") from None


def _event(table: dict[str, Any], where: str) -> Event:
    for key in table:
        if key not in (*DEEDS, "at", "to", "by", "over"):
            raise ValueError(f"{where}: {unknown('key', key, (*DEEDS, 'at', 'to', 'by', 'over'))}")
    deeds = [key for key in table if key in DEEDS]
    if len(deeds) != 1:
        raise ValueError(f"{where} must do one of {', '.join(DEEDS)}, got {', '.join(deeds) or 'none'}")
    does = deeds[0]
    if not isinstance(table[does], str):
        raise ValueError(f"{where}: {does} must name COMPONENT.VARIABLE, got {table[does]!r}")
    if "at" not in table:
        raise ValueError(f"{where} must say `at` which time")
    other = {"to": "by", "by": "to"}.get(_WANTS.get(does, ""))
    if other in table or (does not in _WANTS and {"to", "by"} & set(table)):
        wants = _WANTS.get(does)
        raise ValueError(f"{where}: {does} takes {f'`{wants}`' if wants else 'no value'}, got {other or 'one'!r}")
    over = seconds(table["over"], where, "over") if "over" in table else 0.0
    try:
        return Event(seconds(table["at"], where, "at"), does, table[does], table.get(_WANTS.get(does, "")), over)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def seconds(given: Any, where: str, key: str) -> float:
    """A time (s) in a TOML file: a number, or text with a unit."""
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError(f"{where}: {key} must be a time, got {given!r}")
    try:
        return quantity(given, "s") if isinstance(given, str) else float(given)
    except ValueError as error:
        raise ValueError(f"{where}: {key} {error}") from None
