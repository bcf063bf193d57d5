"""What the paper does not give: every parameter of a system whose row carries an assumed range; draws from all ranges at once.

The ranges come from the components' tables. Springs and dampers of the gimbal are counted by one number n (k = n k_z,
c = n c_z), so both are drawn with the same share of their ranges, as TIED says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...systems import System, SystemComponent, catalogue

TIED = (("gyro.gimbal_stiffness", "gyro.gimbal_damping"),)  # drawn together: the number of springs is that of the dampers


@dataclass(frozen=True)
class Open:
    """An open parameter: what addresses it in the system, its range in its unit, its meaning."""

    target: str
    low: float
    high: float
    unit: str
    meaning: str

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 to 1."""
        return self.low + (self.high - self.low) * share


def every_open_parameter(system: System) -> tuple[Open, ...]:
    """Every parameter with an assumed range, of each component once; components of one source are addressed together."""
    collected = []
    for address, part in addressed(system).items():
        collected += [
            Open(f"{address}.{v.name}", v.assumed[0], v.assumed[1], v.unit, v.meaning)
            for v in catalogue.component(part.source).parameters
            if v.assumed is not None
        ]
    return tuple(collected)


def addressed(system: System) -> dict[str, SystemComponent]:
    """What addresses the components of each source ("gyro" for gyro_front and gyro_rear), and the first of them."""
    firsts: dict[str, SystemComponent] = {}
    for part in system.components:
        alike = [p.name for p in system.components if p.source == part.source]
        firsts.setdefault(part.name if len(alike) == 1 else part.name.partition("_")[0], part)
    return firsts


def values_of(system: System) -> dict[str, float]:
    """Every number of the components' parameters by target, as the system sets them or else as they start."""
    numbers: dict[str, float] = {}
    for address, part in addressed(system).items():
        bound: Mapping[str, Any] = {**part.bound, **part.values}
        variables = catalogue.component(part.source).parameters
        numbers |= {f"{address}.{v.name}": float(bound.get(v.name, v.start)) for v in variables}
    return numbers


def coordinates(parameters: Sequence[Open]) -> list[tuple[str, ...]]:
    """The targets that each dimension of the hypercube moves: one, or those that are tied."""
    known = [parameter.target for parameter in parameters]
    tied = [tuple(target for target in group if target in known) for group in TIED]
    groups = {target: group for group in tied for target in group}
    return list(dict.fromkeys(groups.get(target, (target,)) for target in known))


def draws(parameters: Sequence[Open], count: int, seed: int) -> list[dict[str, float]]:
    """`count` points of a Latin hypercube over all ranges, each as target -> value."""
    from scipy.stats import qmc

    dimensions = coordinates(parameters)
    unit = qmc.LatinHypercube(len(dimensions), seed=np.random.default_rng(seed)).random(count)  # `rng` from scipy 1.15 on
    return [_point(parameters, dimensions, row) for row in unit]


def middle(parameters: Sequence[Open]) -> dict[str, float]:
    """The middle of all ranges."""
    return {parameter.target: parameter.at(0.5) for parameter in parameters}


def _point(parameters: Sequence[Open], dimensions: Sequence[tuple[str, ...]], row: np.ndarray) -> dict[str, float]:
    share = {target: float(x) for group, x in zip(dimensions, row, strict=True) for target in group}
    return {parameter.target: parameter.at(share[parameter.target]) for parameter in parameters}
