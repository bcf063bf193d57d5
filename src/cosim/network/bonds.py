"""Power bonds in terms of a network: where their signals stand among all outputs and which inputs they feed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gyro_cosim.component.units import power_pair, unit

from ..errors import WiringError, unknown
from ..systems import Connection, PowerBond, System


@dataclass(frozen=True)
class Bond:
    """A power bond in terms of the network: places of its two signals in Y, and of the inputs they feed.

    motion, effort : places in Y; motion times effort is the power into the slave that sends `motion`.
    motion_input, effort_input : (slave, place in its u) that each of them feeds.
    """

    name: str
    motion: int
    effort: int
    motion_input: tuple[int, int]
    effort_input: tuple[int, int]


def power_bonds(
    system: System, where: Mapping[str, int], units: Sequence[str], feeds: Mapping[int, Sequence[tuple[int, int]]]
) -> tuple[Bond, ...]:
    """The system's power bonds; where it states none, the pairs of connections whose units leave no doubt.

    where : name of an output -> its place in Y. units : of Y. feeds : place in Y -> the (slave, place in u) it feeds.
    """
    slave = {part.name: i for i, part in enumerate(system.components)}
    stated = system.bonds or _detected(system, {name: units[k] for name, k in where.items()})
    located = []
    for bond in stated:
        ends = {}
        for role, signal, other in (("motion", bond.motion, bond.effort), ("effort", bond.effort, bond.motion)):
            name = ".".join(signal)
            if name not in where:
                raise unknown("signal of a power bond:", name, where)
            k = where[name]
            target = [t for t in feeds.get(k, []) if t[0] == slave.get(other[0])]
            if not target:
                raise WiringError(f"power bond: {role} {name} must be connected to {other[0]!r}")
            ends[role] = (k, target[0])
        (motion, motion_input), (effort, effort_input) = ends["motion"], ends["effort"]
        label = f"{bond.motion[0]}.{bond.motion[1]} x {bond.effort[0]}.{bond.effort[1]}"
        located.append(Bond(label, motion, effort, motion_input, effort_input))
    return tuple(located)


def watts(bond: Bond, units: Sequence[str]) -> float:
    """The factor from the product of the bond's two signals, in their own units, to W; a signal without a unit counts as SI."""
    factor = 1.0
    for k in (bond.motion, bond.effort):
        if units[k]:
            factor *= unit(units[k]).factor
    return factor


def _detected(system: System, units: Mapping[str, str]) -> tuple[PowerBond, ...]:
    """Bonds between two components that are joined by just one connection each way whose units multiply to a power."""
    detected = []
    between: dict[tuple[str, str], list[Connection]] = {}
    for wire in system.connections:
        between.setdefault((wire.start[0], wire.end[0]), []).append(wire)
    for (a, b), there in between.items():
        back = between.get((b, a), [])
        if a < b or len(there) != 1 or len(back) != 1:
            continue
        units_of = [units.get(".".join(wire.start), "") for wire in (there[0], back[0])]
        try:
            fits = all(units_of) and power_pair(*units_of)
        except ValueError:  # a foreign unit says nothing
            continue
        if fits:
            motion_first = unit(units_of[0]).dimension[0] == 0  # a motion has no mass in its unit
            motion, effort = (there[0], back[0]) if motion_first else (back[0], there[0])
            detected.append(PowerBond(motion.start, effort.start))
    return tuple(detected)
