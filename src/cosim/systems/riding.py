"""What of a unit's inertia rides on the body that carries it: said by the unit's connector, held by a parameter of the carrier.

No acceleration crosses the interface, so a unit that has a state for an inertia keeps it, and all the rest must be in the
carrier's own: none lost, none counted twice. `inertia_on_carriers` compares the two, `settled` gives the carrier what its
units say, `held_with` tells what that is for each choice of variants.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

from gyro_cosim.component.units import quantity

from . import catalogue
from .elements import SystemComponent
from .plan import System
from .quantities import Quantity, meaning

if TYPE_CHECKING:  # at run time they would load CasADi, which a run of built FMUs does without
    from gyro_cosim.component import Component, Variable

__all__ = ["Riding", "held_with", "inertia_on_carriers", "settled"]

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
    made = {name: _component(part.source) for name, part in parts.items()}
    found = []
    for wire in plan.connections:
        unit, carrier = made[wire.start[0]], made[wire.end[0]]
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

    Where units that ride on one parameter want different values of it, none can be right for all: it stays, and the notes tell
    what is lost or counted twice.
    """
    values = {part.name: part.values for part in plan.components}
    wanted: dict[tuple[str, str], list[Riding]] = {}
    for one in inertia_on_carriers(plan):
        wanted.setdefault((one.carrier, one.parameter), []).append(one)
    notes, bound = list(plan.notes), {part.name: dict(part.bound) for part in plan.components}
    for (carrier, parameter), riding in wanted.items():
        if all(one.right for one in riding):
            continue
        first = riding[0]
        if parameter in values[carrier] or any(not replace(one, carried=first.rides).right for one in riding):
            notes += [one.words() for one in riding if not one.right]
            continue
        bound[carrier][parameter] = first.rides
        units, mounts = (", ".join(getattr(one, of) for one in riding) for of in ("unit", "mount"))
        notes.append(f"{carrier}.{parameter} = {first.rides:g} kg m2: what of {units} turns with {mounts}")
    if notes == list(plan.notes):
        return plan
    parts = tuple(replace(part, bound=bound[part.name]) for part in plan.components)
    return replace(plan, components=parts, notes=tuple(dict.fromkeys(notes)))


def held_with(plan: System, variants: Mapping[str, Sequence[str]]) -> dict[tuple[str, ...], dict[str, dict[str, float]]]:
    """What settled() gives carriers with each choice of variants: variant of each target -> component -> parameter -> kg m2."""
    found = {}
    for names in product(*variants.values()):
        varied = plan
        for target, name in zip(variants, names, strict=True):
            varied = varied.with_source(target, name)
        pairs = zip(varied.components, settled(varied).components, strict=True)
        given = {of.name: {k: v for k, v in held.bound.items() if of.bound.get(k) != v} for of, held in pairs}
        found[names] = {name: values for name, values in given.items() if values}
    return found


def _component(source: str) -> "Component | None":
    """What a source describes; None of what would have to be opened or run to know it."""
    if source.endswith(".toml"):
        return catalogue.component(source)  # type: ignore[no-any-return]
    return _of_catalogue(source) if source.partition(":")[0] in catalogue.components() else None


@lru_cache(maxsize=64)
def _of_catalogue(source: str) -> "Component":
    return catalogue.component(source)  # type: ignore[no-any-return]


def _number(text: str, made: "Component", part: SystemComponent) -> float:
    """A parameter's value in this system (SI), or the number that the text is."""
    row = next((v for v in made.parameters if v.name == text), None)
    return float(text) if row is None else _given(part.given, row)


def _given(values: Mapping[str, Any], row: "Variable") -> float:
    value = values.get(row.name, row.start)
    if isinstance(value, Quantity):
        return value.expressed(meaning(row.unit))
    return quantity(value, row.unit) if isinstance(value, str) else float(value)
