"""A system: named components, the connections between their signals, parameter values. A plan; it loads nothing."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from gyro_cosim.component.units import Unit

from ..errors import WiringError, unknown
from . import catalogue


@dataclass(frozen=True)
class Port:
    """What a system file says of a connector, to be compared with the component behind it.

    kind : "input", "output", "parameter" or "calculatedParameter". type : as FMI 3.0 or SSP 1.0 call it; "" where not stated.
    unit : its meaning where one is stated.
    """

    kind: str
    type: str = ""
    unit: Unit | None = None


@dataclass(frozen=True)
class SystemComponent:
    """A component of a system: its name there, where it comes from, and the start values that differ from its own.

    name : may hold "/", which separates the names of nested systems, and any other character.
    source : an FMU, `FILE` or `ARCHIVE#MEMBER`, or a catalogue name ("gyro_unit:linear", "my_gyro.py").
    values : name -> text with an optional unit ("200rpm") or a number in the variable's own unit, or a sequence of them.
    bound : the same from parameter files, for those variables that the component has; `values` go first.
    ports : connectors as the system file describes them.
    """

    name: str
    source: str
    values: Mapping[str, Any] = field(default_factory=dict)
    bound: Mapping[str, Any] = field(default_factory=dict)
    ports: Mapping[str, Port] = field(default_factory=dict)


@dataclass(frozen=True)
class Conversion:
    """What happens to a value on its way: target = factor * (source in the target's unit) + offset, or a table of numbers.

    start, end : units stated at the two connectors, None where none are. suppress : no conversion between units.
    table : (source, target) pairs for numbers that stand for booleans, integers or enumerations.
    """

    start: Unit | None = None
    end: Unit | None = None
    factor: float = 1.0
    offset: float = 0.0
    suppress: bool = False
    table: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Connection:
    """From the output `start` = (component, variable) to the input `end`.

    conversions : what stands between, one for each connection of the system file that it is made of; none: units are converted.
    """

    start: tuple[str, str]
    end: tuple[str, str]
    conversions: tuple[Conversion, ...] = ()


@dataclass(frozen=True)
class PowerBond:
    """A pair of connections in opposite directions whose signals' product is a power.

    motion : (component, variable), e.g. a rate, flowing out of the component that `effort` flows into.
    effort : (component, variable), e.g. a moment. motion times effort is the power INTO the component that sends `motion`.
    """

    motion: tuple[str, str]
    effort: tuple[str, str]


@dataclass(frozen=True)
class StopWhen:
    """End a run, with all results up to there, when an output rises above a value: `says` is what then has happened."""

    signal: tuple[str, str]
    above: float
    says: str


@dataclass(frozen=True)
class System:
    """See the module's docstring. `step`, `start` and `stop` (s) are what a run takes where it is told nothing else."""

    name: str
    components: tuple[SystemComponent, ...]
    connections: tuple[Connection, ...]
    bonds: tuple[PowerBond, ...] = ()
    step: float = 1e-3
    stop: float = 1.0
    description: str = ""
    stop_when: tuple[StopWhen, ...] = ()
    start: float = 0.0

    def __post_init__(self) -> None:
        """Refuse names that are not there or stand twice, and inputs with two sources."""
        names = Counter(part.name for part in self.components)
        for name, times in names.items():
            if times > 1:
                raise WiringError(f"system {self.name!r}: component names must differ, got {name!r} twice")
        ends = Counter(connection.end for connection in self.connections)
        for connection in self.connections:
            for component, _ in (connection.start, connection.end):
                if component not in names:
                    raise WiringError(f"system {self.name!r}: a connection names component {component!r}, which is not there")
            if ends[connection.end] > 1:
                sources = " and ".join(".".join(c.start) for c in self.connections if c.end == connection.end)
                end = ".".join(connection.end)
                raise WiringError(f"system {self.name!r}: input {end} must have one source, has two: {sources}")

    def members(self, name: str) -> tuple[str, ...]:
        """The components that `name` addresses: itself, or every `name_...` ("gyro": gyro_front and gyro_rear)."""
        names = [part.name for part in self.components]
        found = tuple(n for n in names if n == name) or tuple(n for n in names if n.startswith(f"{name}_"))
        if not found:
            raise unknown(f"component of system {self.name!r}:", name, names)
        return found

    def with_source(self, name: str, source: str) -> "System":
        """The same system with another unit in the place of the component(s) that `name` addresses.

        `source` : a variant of the same package ("nonlinear"), a catalogue name, a Python file, or the path of an FMU.
        A variant's name keeps the ending that tells the parameter set: where "nonlinear_full" stands, "off" means "off_full"
        if there is one, so that a small unit is not put on a large vehicle by mistake; `PACKAGE:VARIANT` is taken as it is.
        """
        members = self.members(name)

        def swapped(part: SystemComponent) -> str:
            if source.endswith(".fmu") or ".py" in source or ":" in source:
                return source
            package = part.source.partition(":")[0]
            if package.endswith((".fmu", ".py")):
                raise ValueError(f"variant {source!r} must be given as PACKAGE:VARIANT, since {part.source!r} has no variants")
            _, mark, ending = part.source.partition(":")[2].rpartition("_")
            sized = f"{source}{mark}{ending}"
            return f"{package}:{sized if mark and sized in catalogue.components().get(package, ()) else source}"

        components = tuple(replace(p, source=swapped(p), ports={}) if p.name in members else p for p in self.components)
        return replace(self, components=components)

    def with_value(self, target: str, value: Any) -> "System":
        """The same system with `component.variable` set to `value`, a number or text with a unit ("200rpm")."""
        whole = [p.name for p in self.components if target.startswith(f"{p.name}.")]  # a component's name may hold dots
        name = max(whole, key=len, default=target.partition(".")[0])
        variable = target[len(name) + 1 :]
        if not (name and variable):
            raise ValueError(f"a value must be set as COMPONENT.PARAMETER=VALUE, got {target!r}")
        members = self.members(name)
        components = tuple(replace(p, values={**p.values, variable: value}) if p.name in members else p for p in self.components)
        return replace(self, components=components)
