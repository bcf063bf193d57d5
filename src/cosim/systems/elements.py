"""What a system is made of: components, connections, power bonds, what ends a run and what people exchange. Values, all of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gyro_cosim.component.units import Unit


@dataclass(frozen=True)
class Port:
    """What a system file says of a connector, to be compared with the component behind it.

    Parameters
    ----------
    kind : str
        "input", "output", "parameter" or "calculatedParameter".
    type : str
        As FMI 3.0 or SSP 1.0 call it; empty where not stated.
    unit : Unit or None
        Its meaning where one is stated and known.
    unit_name : str
        The unit as the file writes it; empty where not stated.
    clocks : tuple of str
        Of a clocked variable, the clocks that the file states.
    """

    kind: str
    type: str = ""
    unit: Unit | None = None
    unit_name: str = ""
    clocks: tuple[str, ...] = ()


@dataclass(frozen=True)
class SystemComponent:
    """A component of a system: its name there, where it comes from, and the start values that differ from its own.

    Parameters
    ----------
    name : str
        May hold "/", which separates the names of nested systems, and any other character.
    source : str
        An FMU, `FILE` or `ARCHIVE#MEMBER`, or a catalogue name ("gyro_unit:linear", "my_gyro.py").
    values : mapping
        Name -> text with an optional unit ("200rpm") or a number in the variable's own unit, or a sequence of them.
    bound : mapping
        The same from parameter files, for those variables that the component has; `values` go first.
    ports : mapping of str to Port
        Connectors as the system file describes them.
    implementation : str
        The interface by which an FMU shall be run, "CoSimulation" or "ModelExchange"; empty: Co-Simulation where it offers that.
    """

    name: str
    source: str
    values: Mapping[str, Any] = field(default_factory=dict)
    bound: Mapping[str, Any] = field(default_factory=dict)
    ports: Mapping[str, Port] = field(default_factory=dict)
    implementation: str = ""

    def __post_init__(self) -> None:
        if self.implementation not in ("", "CoSimulation", "ModelExchange"):
            raise ValueError(f"implementation must be CoSimulation or ModelExchange, got {self.implementation!r}")

    @property
    def given(self) -> dict[str, Any]:
        """All values by name, `values` before `bound`."""
        return {**self.bound, **self.values}


@dataclass(frozen=True)
class Conversion:
    """What happens to a value on its way: target = factor * (source in the target's unit) + offset, or a table of numbers.

    Parameters
    ----------
    start, end : Unit or None
        Units stated at the two connectors.
    factor, offset : float
        The linear transformation, in the target's unit.
    suppress : bool
        Whether there is no conversion between units.
    table : tuple of (float, float)
        (source, target) pairs for numbers that stand for booleans, integers or enumerations.
    explicit : bool
        Whether the linear transformation is stated, even as factor 1 and offset 0: types may then differ.
    items : tuple of (str, str)
        (source, target) pairs of names of enumeration items.
    """

    start: Unit | None = None
    end: Unit | None = None
    factor: float = 1.0
    offset: float = 0.0
    suppress: bool = False
    table: tuple[tuple[float, float], ...] = ()
    explicit: bool = False
    items: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Connection:
    """From an output to an input.

    Parameters
    ----------
    start, end : (str, str)
        Component and variable.
    conversions : tuple of Conversion
        What stands between, one for each connection of the system file that it is made of; none: units are converted.
    """

    start: tuple[str, str]
    end: tuple[str, str]
    conversions: tuple[Conversion, ...] = ()


@dataclass(frozen=True)
class PowerBond:
    """A pair of connections in opposite directions whose signals' product is a power.

    Parameters
    ----------
    motion : (str, str)
        Component and variable of, e.g., a rate, which flows out of the component that `effort` flows into.
    effort : (str, str)
        The same of, e.g., a moment. Motion times effort is the power INTO the component that sends `motion`.
    """

    motion: tuple[str, str]
    effort: tuple[str, str]


@dataclass(frozen=True)
class StopWhen:
    """What ends a run, with all results up to there: an output that rises above a value.

    Parameters
    ----------
    signal : (str, str)
        Component and output.
    above : float
        The value, in the output's unit.
    says : str
        What then has happened.
    """

    signal: tuple[str, str]
    above: float
    says: str


@dataclass(frozen=True)
class Exchange:
    """What people exchange in a system: the default of commands and studies that compare variants of a component.

    Parameters
    ----------
    component : str
        The name that addresses it, as System.addressed() takes it: "gyro" for gyro_front and gyro_rear.
    ending : str
        Ending of the variants that are meant in this system's size, such as "_full": "off" then means "off_full" where there
        is one, so that a small unit is not put on a large vehicle by mistake. Empty: names of variants stand as they are.
    """

    component: str
    ending: str = ""
