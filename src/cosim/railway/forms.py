"""The same railway vehicle with another creep law, its own numbers kept.

`vehicle:lrt` comes with four creep laws, each a variant. A variant that differs from `vehicle:lrt` in numbers only, as
`vehicle:lrt_set_b` does, has the same laws: the other variant with its start values put in.
"""

from collections.abc import Mapping
from dataclasses import replace

from ..systems import System, catalogue

__all__ = ["CREEP_LAWS", "creep_laws", "with_creep_law"]

# Name of a law -> the variant that has it, and how the law is called in a sentence.
CREEP_LAWS: Mapping[str, tuple[str, str]] = {
    "Polach": ("vehicle:lrt", "Polach's creep law"),
    "Shen-Hedrick-Elkins": ("vehicle:lrt_shen_hedrick_elkins", "the creep law of Shen, Hedrick and Elkins"),
    "FASTSIM": ("vehicle:lrt_fastsim", "FASTSIM"),
    "half-space": ("vehicle:lrt_half_space", "the exact theory of rolling contact"),
}
OTHER_NUMBERS = {"vehicle:lrt_set_b": "Polach"}  # variants with the equations of a law, and other start values


def creep_laws(source: str) -> tuple[str, ...]:
    """The laws that a vehicle comes with.

    Parameters
    ----------
    source : str
        Of the component, such as "vehicle:lrt".

    Returns
    -------
    tuple of str
        Names of CREEP_LAWS, its own first; empty for a vehicle of another kind.
    """
    own = OTHER_NUMBERS.get(source) or next((law for law, (variant, _) in CREEP_LAWS.items() if variant == source), "")
    return (own, *(law for law in CREEP_LAWS if law != own)) if own else ()


def with_creep_law(system: System, name: str, law: str) -> System:
    """The system with a vehicle that has another creep law and is otherwise the same.

    Parameters
    ----------
    system : System
        With the vehicle.
    name : str
        Of the vehicle's component.
    law : str
        One of CREEP_LAWS.

    Returns
    -------
    System
        What the system sets of the vehicle goes before what its variant begins with.

    Raises
    ------
    ValueError
        For another law, or a vehicle that does not come with it.
    """
    (component,) = (c for c in system.components if c.name == name)
    known = creep_laws(component.source)
    if law not in known:
        raise ValueError(
            f"creep law of {component.source!r} must be one of {', '.join(known) or 'none that is known'}, got {law!r}"
        )
    if law == known[0]:
        return system
    variant = CREEP_LAWS[law][0]
    values: dict[str, object] = {}
    if component.source in OTHER_NUMBERS:
        other = {v.name: v.start for v in catalogue.component(variant).variables}
        own = catalogue.component(component.source).variables
        values = {v.name: v.start for v in own if v.causality == "parameter" and v.start != other[v.name]}
        values = {n: v for n, v in values.items() if n not in component.bound}
    changed = replace(component, source=variant, values={**values, **component.values})
    return replace(system, components=tuple(changed if c is component else c for c in system.components))
