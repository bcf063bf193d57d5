"""What of a unit's inertia rides on the body that carries it: said by the unit's connector, held by a parameter of the carrier.

No acceleration crosses the interface, so a unit that has a state for an inertia keeps it, and all the rest must be in the
carrier's own: none lost, none counted twice. `inertia_on_carriers` compares the two, `settled` gives the carrier what its
units say.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from gyro_cosim.component.units import quantity

from . import catalogue
from .elements import SystemComponent
from .plan import System
from .quantities import Quantity, meaning

if TYPE_CHECKING:  # at run time they would load CasADi, which a run of built FMUs does without
    from gyro_cosim.component import Component, Variable

__all__ = ["Riding", "inertia_on_carriers", "settled"]

SAME = 1e-9  # of an inertia


@dataclass(frozen=True)
class Riding:
    """One axis of one mount.

    Attributes
    ----------
    carrier, mount, unit : str
        The component that carries, its connector, and the component that rides.
    axis : str
        "roll", "pitch" or "yaw".
    parameter : str
        Of the carrier, that holds the inertia.
    carried, rides : float
        What it holds, and what it must hold (kg m2).
    """

    carrier: str
    mount: str
    unit: str
    axis: str
    parameter: str
    carried: float
    rides: float

    @property
    def right(self) -> bool:
        """Whether nothing is lost and nothing counted twice."""
        return abs(self.carried - self.rides) <= SAME * max(abs(self.carried), abs(self.rides))

    def words(self) -> str:
        """One line."""
        what = f"{self.carrier} carries {self.carried:g} kg m2 of {self.unit} about {self.axis} at {self.mount}"
        if self.right:
            return what
        wrong = "counted twice" if self.carried > self.rides else "lost"
        return f"{what}, {self.rides:g} ride there: {abs(self.carried - self.rides):g} {wrong} ({self.carrier}.{self.parameter})"


def inertia_on_carriers(plan: System) -> tuple[Riding, ...]:
    """Every axis of every mount of which carrier and unit both say something; components of the catalogue and vehicle files.

    FMUs and Python files are not opened: of these nothing is said.
    """
    parts = {part.name: part for part in plan.components}
    made: dict[str, Component | None] = {}

    def component(name: str) -> "Component | None":
        if name not in made:
            source = parts[name].source
            known = source.partition(":")[0] in catalogue.components() or source.endswith(".toml")
            made[name] = catalogue.component(source) if known else None
        return made[name]

    found = []
    for wire in plan.connections:
        if not (wire.start[1].endswith("_moment") and component(wire.start[0])):
            continue
        unit, carrier = component(wire.start[0]), component(wire.end[0])
        if unit is None or carrier is None:
            continue
        said = {bond.effort: bond for bond in unit.bonds if bond.inertia}.get(wire.start[1])
        held = {bond.effort: bond for bond in carrier.bonds if bond.inertia}.get(wire.end[1])
        if said is not None and held is not None:
            carried = _number(held.inertia, carrier, parts[wire.end[0]])
            rides = _number(said.inertia, unit, parts[wire.start[0]])
            found.append(Riding(wire.end[0], held.connector, wire.start[0], held.axis, held.inertia, carried, rides))
    return tuple(found)


def settled(plan: System) -> System:
    """The plan with every carrier holding what its units say; what a user has set stays as it is, and the notes say all.

    Raises
    ------
    ValueError
        Where units that ride on one parameter want different values of it.
    """
    wanted: dict[tuple[str, str], Riding] = {}
    notes = list(plan.notes)
    set_by_user = {part.name: part.values for part in plan.components}
    for one in inertia_on_carriers(plan):
        key = (one.carrier, one.parameter)
        if one.parameter in set_by_user[one.carrier]:
            notes += [] if one.right else [one.words()]
            continue
        if key in wanted and abs(wanted[key].rides - one.rides) > SAME * abs(one.rides):
            raise ValueError(f"{one.carrier}.{one.parameter} must hold what rides at {wanted[key].mount} and at {one.mount}: "
                             f"{wanted[key].rides:g} and {one.rides:g} kg m2")  # fmt: skip
        wanted[key] = one
    changed = {key: one for key, one in wanted.items() if not one.right}
    notes += [f"{name}.{parameter} = {one.rides:g} kg m2: what of {one.unit} turns with {one.mount}"
              for (name, parameter), one in changed.items()]  # fmt: skip
    components = tuple(
        replace(part, bound={**part.bound, **{p: one.rides for (name, p), one in changed.items() if name == part.name}})
        for part in plan.components
    )
    return replace(plan, components=components, notes=tuple(dict.fromkeys(notes))) if notes != list(plan.notes) else plan


def _number(text: str, made: "Component", part: SystemComponent) -> float:
    """A parameter's value in this system (SI), or the number that the text is."""
    row = next((v for v in made.parameters if v.name == text), None)
    return float(text) if row is None else _given(part.given, row)


def _given(values: Mapping[str, Any], row: "Variable") -> float:
    value = values.get(row.name, row.start)
    if isinstance(value, Quantity):
        return value.expressed(meaning(row.unit))
    return quantity(value, row.unit) if isinstance(value, str) else float(value)
