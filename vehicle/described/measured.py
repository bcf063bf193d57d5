"""Wheels and rails of a vehicle file whose profiles are points."""

from dataclasses import dataclass
from functools import lru_cache

from ..contact_tables import Fit, fit
from ..section import Profile

__all__ = ["Measured"]


@dataclass(frozen=True, eq=False)
class Measured:
    """Profiles and how they lie.

    Attributes
    ----------
    flange_side : int
        1: flanges outside the rails, -1: inside.
    wheels, rails : (Profile, Profile)
        Left and right, each in the axes of the left side.
    rolling_radius, gauge, inner_distance : float
        As in vehicle.contact_points (m).
    inclination : float
        Of the rails inwards (1).
    poisson_ratio, youngs_modulus : float
        Of wheels and rails (1, Pa).
    names : tuple of str
        What the profiles are, for people.
    """

    flange_side: int
    wheels: tuple[Profile, Profile]
    rails: tuple[Profile, Profile]
    rolling_radius: float
    gauge: float
    inner_distance: float
    inclination: float
    poisson_ratio: float
    youngs_modulus: float
    names: tuple[str, ...]

    def fit(self, load: float) -> Fit:
        """The contact tables for a wheel that carries `load` (N) at rest; ValueError where there are none."""
        return _fit(self, load)


@lru_cache(maxsize=8)
def _fit(m: Measured, load: float) -> Fit:
    return fit(
        (m.wheels[0], m.rails[0]), (m.wheels[1], m.rails[1]), rolling_radius=m.rolling_radius, gauge=m.gauge,
        inner_distance=m.inner_distance, inclination=m.inclination, flange_side=m.flange_side, load=load,
        youngs_modulus=m.youngs_modulus, poisson_ratio=m.poisson_ratio,
    )  # fmt: skip
