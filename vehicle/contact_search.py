"""Where a wheel meets a rail in space, both given by points: the search along the contact locus. SI units.

One side in the axes of the LEFT side: x forward, y outwards from the track's middle, z up from the rails' running surface; the
right side is mirrored before it comes here. The rail is prismatic along x, the wheel a surface of revolution of radius R(u)
about the axle line C + u a. A contact needs a wheel normal without a part along x, and the normal of a circle of the wheel,

    n ~ e_rho - R'(u) a,   e_rho = cos(t) d + sin(t) e      d, e square to a, d without a part along x, downwards

has none at just one place of the lower half:  sin(t) = R' a_x / e_x. These places over u are the contact locus; seen along the
track it is the wheel's outline, so that contact in space is contact of two curves in the plane (y, z): exact for any yaw.

The contacts are the local minima of the gap between outline and rail, upwards. The normal gap is the vertical one times the
cosine of the contact angle, since the tangents there agree.
"""

from dataclasses import dataclass
from math import atan, sqrt

import numpy as np

from .section import Profile

__all__ = ["GAUGE_DEPTH", "Gap", "Outline", "gap_over", "outline", "placed_rail"]

GAUGE_DEPTH = 0.014  # m under the running surface, where the gauge is measured
GRID = 2.5e-5  # m
NEAR = 3e-4  # m; a local minimum further than this above the least gap is no contact at any load
RIDGE = 1e-7  # m; two minima parted by less are one, on the roughness of tables


@dataclass(frozen=True)
class Outline:
    """A wheel as the rail sees it: its contact locus, y increasing, and the wheel's own coordinates along it.

    Attributes
    ----------
    x, y, z : array, shape (n,)
        The locus (m).
    place, radius, slope : array, shape (n,)
        The profile's y there (m), the rolling radius (m), and dR/du (1).
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    place: np.ndarray
    radius: np.ndarray
    slope: np.ndarray


@dataclass(frozen=True)
class Gap:
    """The distance of outline and rail, upwards, over the axes' y, for a wheel whose axle's middle is at height 0.

    Attributes
    ----------
    y, gap : array, shape (n,)
        Across, in even steps, and the distance (m).
    slope : array, shape (n,)
        dz/dy of the rail (1).
    wheel : Outline
        The outline.
    """

    y: np.ndarray
    gap: np.ndarray
    slope: np.ndarray
    wheel: Outline

    def minima(self, near: float = NEAR) -> list[int]:
        """Indices of the local minima less than `near` (m) above the least, those that a ridge parts, in the order of y."""
        inner = self.gap[1:-1]
        low = (inner <= self.gap[:-2]) & (inner < self.gap[2:]) & (inner < self.gap.min() + near)
        found = np.flatnonzero(low) + 1
        if found.size == 0:  # an end touches: a profile too short for this place
            found = np.array([int(np.argmin(self.gap))])
        kept: list[int] = []
        for i in found:
            if kept and self.gap[kept[-1] : i + 1].max() - max(self.gap[kept[-1]], self.gap[i]) < RIDGE:
                if self.gap[i] < self.gap[kept[-1]]:
                    kept[-1] = int(i)
            else:
                kept.append(int(i))
        return kept


def placed_rail(rail: Profile, gauge: float, inclination: float) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Lay a rail at its gauge: (y, z) in the axes of the side, and the shift (y, z) (m) after its turn.

    Parameters
    ----------
    rail : Profile
        Its section, upright or as `inclination` 0 wants it.
    gauge : float
        Distance of the inner faces, the least within GAUGE_DEPTH under the running surface (m).
    inclination : float
        The head leans inwards by atan(inclination), 1/40 say (1).

    Raises
    ------
    ValueError
        If the section does not reach down to where the gauge is measured.
    """
    y, z = rail.turned(atan(inclination))
    up = float(z.max())
    if up - z[: int(np.argmax(z)) + 1].min() < GAUGE_DEPTH:
        raise ValueError(
            f"a rail profile must reach {1e3 * GAUGE_DEPTH:g} mm under its top on the gauge side, where the gauge is measured,"
            f" got {1e3 * (up - z[: int(np.argmax(z)) + 1].min()):.3g} mm"
        )
    face = float(y[z >= up - GAUGE_DEPTH].min())
    across = gauge / 2 - face
    return y + across, z - up, across, -up


def outline(wheel: Profile, rolling_radius: float, tape_distance: float, lateral: float, yaw: float, roll: float) -> Outline:
    """Compute the contact locus of a wheel whose axle's middle is at height 0.

    Parameters
    ----------
    wheel : Profile
        Its section.
    rolling_radius, tape_distance : float
        r0, and the distance of the tape line from the axle's middle (m).
    lateral, yaw, roll : float
        Of the wheelset, in the axes of the side: outwards (m), turning this wheel backwards, raising it (rad).
    """
    across, z, slope = wheel.fine
    u, R, R_u = tape_distance + across, rolling_radius - z, -slope
    a = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    n = sqrt(a[1] ** 2 + a[2] ** 2)
    d = np.array([0.0, a[2], -a[1]]) / n
    e = -np.cross(a, d)  # forward: e_x = n
    sine = R_u * a[0] / n
    there = np.abs(sine) < 0.9
    sine, u, R = sine[there], u[there], R[there]
    cosine = np.sqrt(1.0 - sine**2)
    x, y, z = (u * a[i] + R * (cosine * d[i] + sine * e[i]) for i in range(3))
    y = y + lateral
    keep = np.concatenate([[True], y[1:] > np.maximum.accumulate(y)[:-1]])
    return Outline(x[keep], y[keep], z[keep], across[there][keep], R[keep], R_u[there][keep])


def gap_over(wheel: Outline, rail: tuple[np.ndarray, np.ndarray]) -> Gap:
    """Compute the distance of outline and rail.

    Parameters
    ----------
    wheel : Outline
        The wheel's outline.
    rail : (array, array)
        y increasing, and z, of the rail in the axes of the side (m).

    Raises
    ------
    ValueError
        If wheel and rail do not overlap.
    """
    low, high = max(wheel.y[0], rail[0][0]), min(wheel.y[-1], rail[0][-1])
    if not high - low > 20 * GRID:
        raise ValueError(
            f"wheel and rail profile must overlap, got a wheel from {wheel.y[0]:g} to {wheel.y[-1]:g} m"
            f" and a rail from {rail[0][0]:g} to {rail[0][-1]:g} m"
        )
    y = np.linspace(low, high, int((high - low) / GRID) + 1)
    z = np.interp(y, *rail)
    return Gap(y, np.interp(y, wheel.y, wheel.z) - z, np.gradient(z, y), wheel)
