"""Energy that a unit takes from the rest of its system, and what the interface between them creates.

From the motions w and efforts M of its bonds at the communication points (trapezoidal rule):

    absorbed(t) = -int M w dt                                   what the unit has taken from the rest of the system
    created     = stored(t) - stored(0) + int (dissipated - motor) dt - absorbed(t)

A passive unit has absorbed(t) >= -stored(0): the least value of absorbed is the passivity observer of Hannaford and Ryu (2002).
Where a unit reports its energy (component.variables.BALANCE), `created` is exactly what stands between it and the rest:
delays, sensors, the coupling itself; negative where they take energy away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyro_cosim.component.variables import BALANCE

from ..network import Network
from ..network.bonds import watts
from ..trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class UnitEnergy:
    """Energy (J) at the power bonds of one gyro unit, or any component, at the end of a run; see the module's docstring.

    Parameters
    ----------
    unit : str
        The component.
    absorbed, least : float
        What it has absorbed, and the smallest value of that on the way.
    exchanged : float
        Integral of the size of the power.
    created : float or None
        None where the component reports no energy.
    course : ndarray, shape (n,)
        Absorbed over time.
    """

    unit: str
    absorbed: float
    least: float
    exchanged: float
    created: float | None
    course: np.ndarray

    @property
    def share(self) -> float | None:
        """Created over exchanged energy; 0 where nothing was exchanged."""
        if self.created is None:
            return None
        return self.created / self.exchanged if self.exchanged > 0.0 else 0.0


def energies(network: Network, components: Sequence[str], trajectory: Trajectory) -> tuple[UnitEnergy, ...]:
    """The energy of every one of `components` that has power bonds."""
    t, Y = trajectory.t, trajectory.values
    found = []
    for component in components:
        power = np.zeros(t.size)
        bonds = [b for b in network.bonds if network.slaves[b.motion_input[0]].name == component]
        for bond in bonds:
            power -= watts(bond, network.units) * Y[:, bond.motion] * Y[:, bond.effort]
        if bonds:
            course = integral(t, power)
            exchanged = float(integral(t, np.abs(power))[-1])
            created = _created(trajectory, component, float(course[-1]))
            found.append(UnitEnergy(component, float(course[-1]), float(course.min()), exchanged, created, course))
    return tuple(found)


def _created(trajectory: Trajectory, component: str, absorbed: float) -> float | None:
    stored, lost, motor = (f"{component}.{name}" for name in BALANCE)
    if stored not in trajectory.names or lost not in trajectory.names:
        return None
    heat = trajectory[lost] - (trajectory[motor] if motor in trajectory.names else 0.0)
    E = trajectory[stored]
    return float(E[-1] - E[0] + integral(trajectory.t, heat)[-1] - absorbed)


def integral(t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The running integral of y over t by the trapezoidal rule, shape (n,), from 0."""
    return np.concatenate([[0.0], np.cumsum(np.diff(t) * (y[1:] + y[:-1]) / 2)])
