"""A cross-section of wheel or rail as points, and the smooth curve through them. SI units.

Axes of a section, LEFT side: y across, outwards (to the field side), z up. A wheel's z is the height of its surface over that at
y = 0, its tape line, so the rolling radius is r0 - z. The right side is the mirror image.

The curve is Akima's spline over the chord length: it passes through every point, does not overshoot at a kink, and follows a
steep flange as well as a flat tread. Smoothing replaces the points by a smoothing spline first, over the same chord length:
it minimises  sum |p - q|^2 + lambda int |p''|^2 ds,  and takes half off a wave whose length is `wavelength` where
lambda = (wavelength / 2 pi)^4 / spacing; shorter waves lose more, a wave of twice the length 6 %.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
from scipy.interpolate import Akima1DInterpolator, make_smoothing_spline

__all__ = ["Profile", "smoothed"]

FINE = 5e-5  # m, spacing of `Profile.fine`


@dataclass(frozen=True)
class Profile:
    """Points of a cross-section.

    Attributes
    ----------
    y, z : array, shape (n,)
        Across and up (m), `y` strictly increasing, n at least 3.
    kind : str
        "wheel", "rail" or "" where it does not matter.
    notes : tuple of str
        What was done to the points on the way here, one sentence each.

    Raises
    ------
    ValueError
        If the columns differ in length, hold fewer than three points or a number that is not finite, or `y` does not increase.
    """

    y: np.ndarray
    z: np.ndarray
    kind: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a table that is no section."""
        if self.y.ndim != 1 or self.y.shape != self.z.shape or self.y.size < 3:
            raise ValueError(f"a profile must have two equal columns of three points or more, got {self.y.shape}, {self.z.shape}")
        if not (np.all(np.isfinite(self.y)) and np.all(np.isfinite(self.z))):
            raise ValueError("a profile must hold finite numbers only")
        if not np.all(np.diff(self.y) > 0.0):
            i = int(np.argmin(np.diff(self.y)))
            raise ValueError(f"the y of a profile must increase, got {self.y[i]:g} before {self.y[i + 1]:g}")

    @cached_property
    def fine(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(y, z, dz/dy) along the curve, closer than 0.05 mm, y increasing; shape (m,) each."""
        s = _chord(self.y, self.z)
        dense = np.unique(np.concatenate([s, np.linspace(0.0, s[-1], int(s[-1] / FINE) + 2)]))
        across, up = Akima1DInterpolator(s, self.y), Akima1DInterpolator(s, self.z)
        y, z = across(dense), up(dense)
        dy, dz = across(dense, 1), up(dense, 1)
        keep = np.concatenate([[True], y[1:] > np.maximum.accumulate(y)[:-1] + 1e-12])
        steepest = 1e-6 * np.hypot(dy, dz)
        return y[keep], z[keep], (dz / np.maximum(dy, steepest))[keep]

    def turned(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """(y, z) of the fine curve turned by `angle` (rad) from y to z: a rail's head leans inwards by its inclination."""
        y, z, _ = self.fine
        c, s = np.cos(angle), np.sin(angle)
        return y * c - z * s, y * s + z * c


def _chord(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])


def smoothed(y: np.ndarray, z: np.ndarray, wavelength: float) -> tuple[np.ndarray, np.ndarray]:
    """Smooth a curve by the rule of this module.

    Parameters
    ----------
    y, z : array, shape (n,)
        Points in their order along the curve (m).
    wavelength : float
        A wave of this length (m) keeps half of its height; 0 changes nothing.

    Returns
    -------
    array, array
        The points moved onto the smooth curve, shape (n,) each.
    """
    if not wavelength > 0.0:
        return y, z
    s = _chord(y, z)
    stiffness = (wavelength / (2 * pi)) ** 4 / (s[-1] / (s.size - 1))
    # in millimetres: the solver's matrix is better conditioned where spacings are of order one
    fit = [make_smoothing_spline(1e3 * s, 1e3 * column, lam=1e9 * stiffness)(1e3 * s) * 1e-3 for column in (y, z)]
    return fit[0], fit[1]
