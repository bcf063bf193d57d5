"""Does a variant keep the tolerances? Yes, no, or it cannot be decided: never yes for want of evidence."""

from collections.abc import Collection, Sequence

import numpy as np

from ..systems import System
from ..trajectory import Trajectory
from .difference import Difference, signal_difference
from .tolerances import Tolerances
from .unit_energy import UnitEnergy

REST = 1e-9  # of the largest signal of a unit, or of 1 in SI: what never exceeds this is at rest


def five_percent(system: System, component: str) -> Tolerances:
    """The tolerances where none are given.

    Parameters
    ----------
    system : System
        What is run.
    component : str
        What is exchanged, as System.addressed() takes it.

    Returns
    -------
    Tolerances
        5 % of rms and peak on every signal of the other components.
    """
    exchanged = system.addressed(component)
    others = [c.name for c in system.components if c.name not in exchanged]
    return Tolerances({f"{name}.*": {"rms": 0.05, "peak": 0.05} for name in others})


def judge(reference: Trajectory, own: Trajectory, tolerances: Tolerances) -> tuple[dict[str, Difference], list[str]]:
    """Compare two runs, signal by signal.

    Parameters
    ----------
    reference, own : Trajectory
        On one time grid.
    tolerances : Tolerances
        The limits. NaN keeps none.

    Returns
    -------
    differences : dict of str to Difference
        Of every signal that both have.
    violations : list of str
        In words, which of them are beyond the tolerances.
    """
    rest = _at_rest(reference)
    found = {
        n: signal_difference(reference.t, reference[n], own[n], rest[reference.unit(n)])
        for n in reference.names
        if n in own.names
    }
    broken = []
    for name, d in found.items():
        limits = tolerances.limits(name)
        for key, value in (("rms", d.rms), ("peak", d.peak), ("shift", abs(d.shift))):
            if key in limits and not value <= limits[key]:
                unit_of = " s" if key == "shift" else ""
                broken.append(f"{name}: {key} {value:.3g}{unit_of} beyond {limits[key]:g}{unit_of}")
    return found, broken


def _at_rest(reference: Trajectory) -> dict[str, float]:
    """Unit -> size up to which a signal in it is at rest."""
    largest: dict[str, float] = {}
    for name, unit in zip(reference.names, reference.units, strict=True):
        largest[unit] = max(largest.get(unit, 1.0), float(np.abs(reference[name]).max()))
    return {unit: REST * size for unit, size in largest.items()}


def reached(system: System, names: Collection[str]) -> set[str]:
    """The components `names` and all that their outputs reach through connections."""
    found = set(names)
    while True:
        more = {c.end[0] for c in system.connections if c.start[0] in found} - found
        if not more:
            return found
        found |= more


def undecided(
    component: str, systems: Sequence[System], reference: Trajectory, own: Trajectory, energies: Sequence[UnitEnergy],
    tolerances: Tolerances,
) -> str:  # fmt: skip
    """Why two runs say nothing about a variant, or empty where they do.

    Parameters
    ----------
    component : str
        What is exchanged.
    systems : sequence of System
        Those of the two runs.
    reference, own : Trajectory
        The runs.
    energies : sequence of UnitEnergy
        At the bonds of the variant.
    tolerances : Tolerances
        The limits.
    """
    if tolerances.created is not None and any(e.created is not None and e.exchanged > 0.0 for e in energies):
        return ""
    limited = []
    for name in reference.names:
        if name in own.names and tolerances.limits(name):
            owners = [(system, system.owner(name)) for system in systems]
            limited += [name] if any(owner in reached(s, s.addressed(component)) for s, owner in owners) else []
    if not limited:
        return f"no output of {component!r} reaches a signal with a limit"
    rest = _at_rest(reference)
    if not any(np.ptp(values[name]) > rest[reference.unit(name)] for name in limited for values in (reference, own)):
        return f"no signal with a limit that {component!r} reaches moves"
    return ""
