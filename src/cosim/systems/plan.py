"""A system: named components, the connections between their signals, parameter values. A plan; it loads nothing."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from ..errors import WiringError, unknown
from . import catalogue
from .elements import Connection, Exchange, PowerBond, StopWhen, SystemComponent
from .scenario import Scenario
from .series import InputSeries
from .swap import check_renaming, dropped, joined_signals, renaming


@dataclass(frozen=True)
class System:
    """A plan of named components and connections; it loads nothing.

    Parameters
    ----------
    name, description : str
        What it is called, and a line about it.
    components : tuple of SystemComponent
        In the order in which they were named.
    connections : tuple of Connection
        Each from an output to an input; an input has one source at most.
    bonds : tuple of PowerBond
        Pairs of connections whose signals' product is a power.
    step, start, stop : float
        Macro step, beginning and end (s) of a run that is told nothing else.
    stop_when : tuple of StopWhen
        What ends a run early.
    exchange : Exchange or None
        What people exchange in it; None where it does not say.
    notes : tuple of str
        What a reader of the system should be told: what a file says and is not followed, what a swap has dropped.
    inputs : tuple of InputSeries
        What open inputs follow.
    scenario : Scenario or None
        What happens during a run by plan.
    tolerance : float or None
        The relative tolerance that every FMU is told; None: that of its own description, where it has one.

    Raises
    ------
    WiringError
        Where names are not there or stand twice, or an input has two sources.
    ValueError
        Where `exchange` names no component, or the tolerance is not positive.
    """

    name: str
    components: tuple[SystemComponent, ...]
    connections: tuple[Connection, ...]
    bonds: tuple[PowerBond, ...] = ()
    step: float = 1e-3
    stop: float = 1.0
    description: str = ""
    stop_when: tuple[StopWhen, ...] = ()
    start: float = 0.0
    exchange: Exchange | None = None
    notes: tuple[str, ...] = ()
    inputs: tuple[InputSeries, ...] = ()
    scenario: Scenario | None = None
    tolerance: float | None = None

    def __post_init__(self) -> None:
        """Refuse names that are not there or stand twice, and inputs with two sources."""
        if self.tolerance is not None and not 0.0 < self.tolerance < float("inf"):
            raise ValueError(f"system {self.name!r}: the tolerance must be positive, got {self.tolerance!r}")
        names = Counter(component.name for component in self.components)
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
        if self.exchange is not None:
            self.addressed(self.exchange.component)

    def addressed(self, name: str) -> tuple[str, ...]:
        """The components that `name` addresses.

        Parameters
        ----------
        name : str
            A component, or the beginning that several share: "gyro" for every `gyro_...` where none is called "gyro".

        Returns
        -------
        tuple of str
            Their names, at least one.

        Raises
        ------
        ValueError
            Where there is none.
        """
        names = [component.name for component in self.components]
        found = tuple(n for n in names if n == name) or tuple(n for n in names if n.startswith(f"{name}_"))
        if not found:
            raise unknown(f"component of system {self.name!r}:", name, names)
        return found

    def exchanged(self, name: str | None = None) -> str:
        """The component to exchange: `name`, or the one that the system names where it is None.

        Raises
        ------
        ValueError
            Where `name` addresses no component, or is None and the system names none.
        """
        if name is None and self.exchange is None:
            raise ValueError(f"system {self.name!r} does not say which component is exchanged: name one (--component NAME)")
        chosen = self.exchange.component if name is None and self.exchange is not None else str(name)
        self.addressed(chosen)
        return chosen

    def owner(self, signal: str) -> str:
        """The component whose signal `component.variable` is, or empty; a component's name may hold dots."""
        return max((c.name for c in self.components if signal.startswith(f"{c.name}.")), key=len, default="")

    def refuse_driven(self, what: str) -> None:
        """ValueError where time series or a scenario belong to the system, of which `what` knows nothing."""
        if self.inputs or self.scenario is not None:
            more = "a scenario" if self.scenario is not None else "time series as inputs"
            raise ValueError(f"{what} must be of a system that runs by itself, {self.name!r} has {more}")

    def full(self, signal: str) -> str:
        """`signal` as `component.variable`: in a system of one component `variable` alone means that component's."""
        only = self.components[0].name if len(self.components) == 1 else ""
        return f"{only}.{signal}" if only and not self.owner(signal) else signal

    def signals_of(self, name: str) -> set[str]:
        """The signals that the system uses of the component(s) that `name` addresses."""
        return joined_signals(self.addressed(name), self.connections, self.stop_when)

    def with_source(self, name: str, source: str, renamed: Mapping[str, str] = MappingProxyType({})) -> "System":
        """The same system with the component(s) that `name` addresses made from another source.

        What the system itself has bound for a part (System files: parameter bindings) stays with variants of the same
        package, as far as they have such variables; any other source takes none of it over, and the notes say so.

        Parameters
        ----------
        name : str
            As addressed() takes it.
        source : str
            A variant of the same package ("nonlinear"), a catalogue name ("gyro_unit:nonlinear"), a Python file, or the path
            of an FMU. A variant of the component that `exchange` names is meant with the ending given there, if there is one
            of that name; `PACKAGE:VARIANT` is taken as it is.
        renamed : mapping of str to str
            What the new source calls a signal -> what the system calls it, for sources with names of their own.

        Raises
        ------
        ValueError
            Where a variant is named and the component, an FMU or a Python file, has none; where `renamed` names a signal
            that the system does not use.
        """
        chosen = self.addressed(name)
        ending = self.exchange.ending if self.exchange and set(chosen) <= set(self.addressed(self.exchange.component)) else ""

        def swapped(component: SystemComponent) -> str:
            if source.endswith((".fmu", ".toml")) or ".py" in source or ":" in source:
                return source
            package = catalogue.described_by(component.source) or component.source.partition(":")[0]
            if package.endswith((".fmu", ".py")):
                what = f"since {component.source!r} has no variants"
                raise ValueError(f"variant {source!r} must be given as PACKAGE:VARIANT, {what}")
            sized = f"{source}{ending}" in catalogue.components().get(package, ())
            return f"{package}:{source}{ending if sized else ''}"

        check_renaming(name, renamed, self.signals_of(name))
        parts, notes = [], list(self.notes)
        for part in self.components:
            if part.name in chosen:
                place = swapped(part)
                lost = dropped([part], place)
                notes += lost
                part = replace(part, source=place, ports={}, implementation="", bound={} if lost else part.bound)
            parts.append(part)
        wires, bonds, stops = renaming(chosen, renamed, self.connections, self.bonds, self.stop_when)
        return replace(self, components=tuple(parts), notes=tuple(notes), connections=wires, bonds=bonds, stop_when=stops)

    def with_implementation(self, name: str, implementation: str) -> "System":
        """The same system with the component(s) that `name` addresses run by another interface of FMI.

        Parameters
        ----------
        name : str
            As addressed() takes it.
        implementation : str
            "CoSimulation" or "ModelExchange".

        Raises
        ------
        ValueError
            Where `name` addresses no component. What the FMU offers is found when the system is opened.
        """
        chosen = self.addressed(name)
        components = tuple(replace(c, implementation=implementation) if c.name in chosen else c for c in self.components)
        return replace(self, components=components)

    def with_value(self, target: str, value: Any) -> "System":
        """The same system with one value set.

        Parameters
        ----------
        target : str
            `component.variable`; the component as addressed() takes it.
        value : number, str or sequence
            In the variable's unit, or text with a unit of its own ("200rpm").

        Raises
        ------
        ValueError
            Where `target` has not that form or addresses no component. The variable is looked up when the system is opened.
        """
        name = self.owner(target) or target.partition(".")[0]
        variable = target[len(name) + 1 :]
        if not (name and variable):
            raise ValueError(f"a value must be set as COMPONENT.PARAMETER=VALUE, got {target!r}")
        chosen = self.addressed(name)
        components = tuple(replace(c, values={**c.values, variable: value}) if c.name in chosen else c for c in self.components)
        return replace(self, components=components)
