"""Wheel and rail profiles of the standards, by their formulas.

    s1002       wheel of EN 13715, h 28, e 32.5 mm: two polynomials on the tread, arcs and lines on the flange
    rail_60e1   rail head 60E1 of EN 13674-1: arcs of 300, 80 and 13 mm, sides of 1 : 20

Axes as in vehicle.section: y outwards, z up, in metres; the formulas are in millimetres, as the standards have them.
"""

import numpy as np

from .section import Profile

__all__ = ["rail_60e1", "s1002"]

# EN 13715: depth under the tape line over y, coefficients of 1, y, y^2, ... (mm)
TREAD = (0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8, -1.562379023e-8, 5.309217349e-15,
         -5.957839843e-12, 2.646656573e-13)  # fmt: skip
ROOT = (-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1, -4.169739389e-3, -4.687195829e-5,
        -2.252755540e-7)  # fmt: skip
CHAMFER = (1.364323640, -6.6666667e-2)  # the field side, 1 : 15
FACE = (-93.576667419, -2.747477419)  # the flange's face, 70 deg
CUTS = (-62.764705882, -49.662510381, -39.764473993, -38.426669071, -35.0, -26.0, 32.15796)  # mm, where the pieces meet

HEAD_FLAT, HEAD_EDGE = 10.228, 26.0265  # mm, where 300 mm gives way to 80 mm, and that to 13 mm
CROWN, SHOULDER, CORNER = 300.0, 80.0, 13.0  # mm


def _arc(y: np.ndarray, height: float, radius: float, place: float) -> np.ndarray:
    arc: np.ndarray = height + np.sqrt(np.maximum(radius**2 - (y + place) ** 2, 0.0))
    return arc


def s1002(points: int = 1301) -> Profile:
    """Compute the wheel S1002 with a flange of 28 mm height and 32.5 mm thickness.

    Parameters
    ----------
    points : int
        Number of points, spaced evenly along the section.

    Returns
    -------
    Profile
        From the flange's back, y = -70 mm, to y = 60 mm; y = 0 and z = 0 at the tape line.

    References
    ----------
    EN 13715, Railway applications, Wheelsets and bogies, Wheels, Tread profile: S1002.
    """
    y = np.linspace(-69.99, 60.0, 50 * points)
    pieces = (
        _arc(y, 9.519259302, 20.5, 49.5), _arc(y, 16.0, 12.0, 55.0), _arc(y, 8.834924130, 20.0, 58.558326413),
        FACE[0] + FACE[1] * y, 2 * 16.446 - _arc(y, 16.446, 13.0, 26.210665), np.polynomial.Polynomial(ROOT)(y),
        np.polynomial.Polynomial(TREAD)(y), CHAMFER[0] + CHAMFER[1] * y,
    )  # fmt: skip
    depth = np.select([y < cut for cut in CUTS], pieces[:-1], pieces[-1])
    return _evenly(y, -depth, points, "wheel", "S1002, EN 13715")


def rail_60e1(points: int = 1001, depth: float = 30.0) -> Profile:
    """Compute the head of the rail 60E1 (UIC 60), upright.

    Parameters
    ----------
    points : int
        Number of points, spaced evenly along the section.
    depth : float
        How far down the sides go (mm).

    Returns
    -------
    Profile
        The head; y = 0 in its middle, z = 0 at its top.

    References
    ----------
    EN 13674-1, Railway applications, Track, Rail, Vignole railway rails 46 kg/m and above: 60E1.
    """
    shoulder_y = HEAD_FLAT * (1 - SHOULDER / CROWN)
    shoulder_z = -CROWN + (CROWN - SHOULDER) * np.sqrt(1 - (HEAD_FLAT / CROWN) ** 2)
    share = 1 - CORNER / SHOULDER  # of the way from the shoulder's centre to where the corner begins
    corner_y = shoulder_y + share * (HEAD_EDGE - shoulder_y)
    corner_z = shoulder_z + share * np.sqrt(SHOULDER**2 - (HEAD_EDGE - shoulder_y) ** 2)
    side_y, side_z = corner_y + CORNER * 20 / np.hypot(20, 1), corner_z + CORNER / np.hypot(20, 1)
    end = side_y + (depth + side_z) / 20
    y = np.linspace(-end, end, 100 * points)
    x = np.abs(y)
    z = np.select(
        [x < HEAD_FLAT, x < HEAD_EDGE, x < side_y],
        [_arc(x, -CROWN, CROWN, 0.0), _arc(x, shoulder_z, SHOULDER, -shoulder_y), _arc(x, corner_z, CORNER, -corner_y)],
        side_z - 20 * (x - side_y),
    )
    return _evenly(y, z, points, "rail", "60E1, EN 13674-1")


def _evenly(y: np.ndarray, z: np.ndarray, points: int, kind: str, name: str) -> Profile:
    """`points` of the dense curve (mm), evenly along it."""
    s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    even = np.linspace(0.0, s[-1], points)
    return Profile(np.interp(even, s, y) * 1e-3, np.interp(even, s, z) * 1e-3, kind, (f"{name}, by its formula",))
