"""A system: named components, the connections between their signals, parameter values. A plan; it loads nothing."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from cosim.catalogue import unknown
from cosim.errors import WiringError


@dataclass(frozen=True)
class Part:
    """A component of a system: its name there, where it comes from, and the start values that differ from its own.

    source : path of an FMU, or a catalogue name ("gyro_unit:linear", "my_gyro.py").
    values : name -> text with an optional unit ("200rpm") or a number in the variable's own unit.
    """

    name: str
    source: str
    values: Mapping[str, str | float] = field(default_factory=dict)


@dataclass(frozen=True)
class Connection:
    """From the output `start` = (component, variable) to the input `end`."""

    start: tuple[str, str]
    end: tuple[str, str]


@dataclass(frozen=True)
class PowerBond:
    """A pair of connections in opposite directions whose signals' product is a power.

    motion : (component, variable), e.g. a rate, flowing out of the component that `effort` flows into.
    effort : (component, variable), e.g. a moment. motion times effort is the power INTO the component that sends `motion`.
    """

    motion: tuple[str, str]
    effort: tuple[str, str]


@dataclass(frozen=True)
class System:
    """See the module's docstring. `step` and `stop` (s) are what a run takes where it is told nothing else."""

    name: str
    parts: tuple[Part, ...]
    connections: tuple[Connection, ...]
    bonds: tuple[PowerBond, ...] = ()
    step: float = 1e-3
    stop: float = 1.0
    description: str = ""

    def __post_init__(self) -> None:
        """Refuse names that are not there or stand twice, and inputs with two sources."""
        names = [part.name for part in self.parts]
        for name in names:
            if names.count(name) > 1:
                raise WiringError(f"system {self.name!r}: component names must differ, got {name!r} twice")
        ends = [connection.end for connection in self.connections]
        for connection in self.connections:
            for component, _ in (connection.start, connection.end):
                if component not in names:
                    raise WiringError(f"system {self.name!r}: a connection names component {component!r}, which is not there")
            if ends.count(connection.end) > 1:
                raise WiringError(f"system {self.name!r}: input {'.'.join(connection.end)} must have one source, has two")

    def members(self, name: str) -> tuple[str, ...]:
        """The components that `name` addresses: itself, or every `name_...` ("gyro": gyro_front and gyro_rear)."""
        names = [part.name for part in self.parts]
        found = tuple(n for n in names if n == name) or tuple(n for n in names if n.startswith(f"{name}_"))
        if not found:
            raise unknown(f"component of system {self.name!r}:", name, names)
        return found

    def with_source(self, name: str, source: str) -> "System":
        """The same system with another unit in the place of the component(s) that `name` addresses.

        `source` : a variant of the same package ("nonlinear"), a catalogue name, a Python file, or the path of an FMU.
        """
        members = self.members(name)

        def swapped(part: Part) -> str:
            if source.endswith(".fmu") or ".py" in source or ":" in source:
                return source
            package = part.source.partition(":")[0]
            if package.endswith((".fmu", ".py")):
                raise ValueError(f"variant {source!r} must be given as PACKAGE:VARIANT, since {part.source!r} has no variants")
            return f"{package}:{source}"

        parts = tuple(replace(p, source=swapped(p)) if p.name in members else p for p in self.parts)
        return replace(self, parts=parts)

    def with_value(self, target: str, value: str | float) -> "System":
        """The same system with `component.variable` set to `value`, a number or text with a unit ("200rpm")."""
        name, dot, variable = target.partition(".")
        if not (name and dot and variable):
            raise ValueError(f"a value must be set as COMPONENT.PARAMETER=VALUE, got {target!r}")
        members = self.members(name)
        parts = tuple(replace(p, values={**p.values, variable: value}) if p.name in members else p for p in self.parts)
        return replace(self, parts=parts)
