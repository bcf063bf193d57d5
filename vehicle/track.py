"""Track as data: segments, gradient and irregularity, turned into the parameters of a vehicle.

    line = Track((Straight(30), Clothoid(10), Curve(60, radius=50, cant=0.05), Clothoid(10), Straight(200)))
    vehicle = lrt(line.parameters())

A `Clothoid` changes curvature and cant linearly from its neighbour before to the one after; the last segment goes on for
ever. Curvature and cant must be continuous, since a jump of curvature would be a blow that no railway builds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import asin, hypot, isfinite, radians, sin

from .alignment import CAPACITY

__all__ = ["Clothoid", "Curve", "Segment", "Straight", "Stretch", "Track"]

LARGEST_PIVOT_ANGLE = 20.0  # deg, of a bogie frame in the curve
HALF_DISTANCE = 0.7475  # m, half the distance of the contact points, turns cant into an angle


@dataclass(frozen=True)
class Straight:
    """Straight track without cant, `length` in m."""

    length: float


@dataclass(frozen=True)
class Clothoid:
    """Transition between its neighbours, `length` in m."""

    length: float


@dataclass(frozen=True)
class Curve:
    """Circular arc.

    Attributes
    ----------
    length : float
        m.
    radius : float
        m, positive to the left.
    cant : float
        Of the outer rail over the inner one (m).
    """

    length: float
    radius: float
    cant: float = 0.0


Segment = Straight | Clothoid | Curve


@dataclass(frozen=True)
class Stretch:
    """Sinusoidal irregularity over a length of track.

    Attributes
    ----------
    start, wavelength : float
        Where it begins, and the length of a wave (m).
    cycles : float
        Number of waves.
    amplitudes : mapping of str to float
        Amplitude (m) by channel of `vehicle.irregularity`.
    """

    start: float
    wavelength: float = 50.0
    cycles: float = 5.0
    amplitudes: Mapping[str, float] = field(default_factory=lambda: {"lateral": 0.01})


@dataclass(frozen=True)
class Track:
    """A track as data.

    Attributes
    ----------
    segments : sequence of Segment
        In their order. The first is straight, the last goes on for ever.
    gradient : sequence of (float, float)
        Points (s in m, gradient as a ratio), linear between them, level before the first.
    stretch : Stretch, optional
        A sinusoidal irregularity.
    harmonics : mapping of str to float
        Parameters that `vehicle.spectra` computed.
    """

    segments: Sequence[Segment]
    gradient: Sequence[tuple[float, float]] = ()
    stretch: Stretch | None = None
    harmonics: Mapping[str, float] = field(default_factory=dict)

    def parameters(self, knots: int = CAPACITY, wheelbase: float = 7.0) -> dict[str, float]:
        """Compute the parameters of a vehicle that runs on this track.

        Parameters
        ----------
        knots : int
            Free knots that the vehicle was built with.
        wheelbase : float
            Distance of its wheel pairs (m), which limits the radius.

        Returns
        -------
        dict of str to float
            Values by name of parameter.

        Raises
        ------
        ValueError
            If curvature or cant would jump, a length, radius or cant is out of range, the gradient's table is not in order,
            or the track needs more knots.
        """
        table = self._knots(wheelbase)
        if len(table) > knots:
            raise ValueError(f"the track needs {len(table)} knots, got a vehicle with {knots}: build it with knots={len(table)}")
        values = {"curve_turn": 0.0}
        for i in range(knots):
            row = table[i] if i < len(table) else (0.0, 0.0, 0.0, 0.0)
            names = ("position", "curvature_slope", "cant_slope", "gradient_slope")
            values |= {f"track_{name}[{i}]": value for name, value in zip(names, row, strict=True)}
        if self.stretch is not None:
            s = self.stretch
            values |= {"stretch_start": s.start, "stretch_wavelength": s.wavelength, "stretch_cycles": s.cycles}
            values |= {f"stretch_{channel}": amplitude for channel, amplitude in s.amplitudes.items()}
        return values | dict(self.harmonics)

    def _knots(self, wheelbase: float) -> list[tuple[float, float, float, float]]:
        """Rows (position, change of slope of curvature, of cant angle, of gradient), in order of position."""
        places, ends = self._ends(wheelbase)
        changes: dict[float, list[float]] = {}
        for column, values in ((0, [e[0] for e in ends]), (1, [e[1] for e in ends])):
            _add_slope_changes(changes, column, places, values)
        if self.gradient:
            at = [p for p, _ in self.gradient]
            if any(not b > a for a, b in pairwise(at)):
                raise ValueError(f"positions of the gradient table must increase, got {at}")
            if self.gradient[0][1] != 0.0:
                raise ValueError(f"the gradient table must begin with gradient 0, got {self.gradient[0][1]:g}")
            _add_slope_changes(changes, 2, at, [asin(g / hypot(1.0, g)) for _, g in self.gradient])
        return [
            (s, change[0], change[1], change[2]) for s, change in sorted(changes.items()) if any(abs(c) > 1e-15 for c in change)
        ]

    def _ends(self, wheelbase: float) -> tuple[list[float], list[tuple[float, float]]]:
        """Where segments meet, and (curvature, cant angle) there."""
        if not self.segments:
            raise ValueError("a track must have at least one segment, got none")
        constant: list[tuple[float, float] | None] = [_constant(segment, wheelbase) for segment in self.segments]
        places, ends, here = [0.0], [constant[0] or (0.0, 0.0)], 0.0
        if constant[0] is None or constant[0] != (0.0, 0.0):
            raise ValueError(f"the track must begin with a Straight, got {self.segments[0]}")
        for i, segment in enumerate(self.segments):
            if not (isfinite(segment.length) and segment.length > 0.0):
                raise ValueError(f"the length of a segment must be positive, got {segment}")
            before = ends[-1]
            after = constant[i]
            if after is None:
                following = constant[i + 1] if i + 1 < len(constant) else None
                if following is None:
                    raise ValueError(f"a Clothoid must stand between two segments of constant curvature, got segment {i + 1}")
                after = following
            elif after != before:
                raise ValueError(f"curvature and cant must be continuous: put a Clothoid before segment {i + 1}, {segment}")
            here += segment.length
            places.append(here)
            ends.append(after)
        return places, ends


def _constant(segment: Segment, wheelbase: float) -> tuple[float, float] | None:
    """(curvature, cant angle) of a segment, None for a Clothoid."""
    if isinstance(segment, Clothoid):
        return None
    if isinstance(segment, Straight):
        return 0.0, 0.0
    least = wheelbase / 2 / sin(radians(LARGEST_PIVOT_ANGLE))
    if not abs(segment.radius) >= least:
        raise ValueError(f"the radius must be at least {least:.3g} m for a wheelbase of {wheelbase:g} m, got {segment}")
    if not abs(segment.cant) <= 0.2:
        raise ValueError(f"the cant of a curve must lie within 0.2 m, got {segment}")
    side = 1.0 if segment.radius > 0.0 else -1.0
    return 1.0 / segment.radius, -side * asin(segment.cant / (2.0 * HALF_DISTANCE))


def _add_slope_changes(changes: dict[float, list[float]], column: int, places: Sequence[float], values: Sequence[float]) -> None:
    """Enter the changes of slope of a piecewise linear function, constant before its first and after its last point."""
    slope = 0.0
    for i, place in enumerate(places):
        after = (values[i + 1] - values[i]) / (places[i + 1] - place) if i + 1 < len(places) else 0.0
        changes.setdefault(place, [0.0, 0.0, 0.0])[column] += after - slope
        slope = after
