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
        return _fit(_Key(self, load))


@dataclass(frozen=True, eq=False)
class _Key:
    """What decides on the tables, compared by content: a file that is read again has them again."""

    measured: Measured
    load: float

    @property
    def content(self) -> tuple[object, ...]:
        m = self.measured
        alike = (m.wheels[0] is m.wheels[1], m.rails[0] is m.rails[1])
        points = tuple(column.tobytes() for profile in (*m.wheels, *m.rails) for column in (profile.y, profile.z))
        return (*points, *alike, m.flange_side, m.rolling_radius, m.gauge, m.inner_distance, m.inclination, m.poisson_ratio,
                m.youngs_modulus, self.load)  # fmt: skip

    def __hash__(self) -> int:
        return hash(self.content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self.content == other.content


@lru_cache(maxsize=8)
def _fit(key: _Key) -> Fit:
    m = key.measured
    return fit(
        (m.wheels[0], m.rails[0]), (m.wheels[1], m.rails[1]), rolling_radius=m.rolling_radius, gauge=m.gauge,
        inner_distance=m.inner_distance, inclination=m.inclination, flange_side=m.flange_side, load=key.load,
        youngs_modulus=m.youngs_modulus, poisson_ratio=m.poisson_ratio,
    )  # fmt: skip
