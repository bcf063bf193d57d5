"""What is between two bodies, as values: springs and dampers along axes, links along their own line, roll bars."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .sections import Vector
from .values import ZERO, Value

__all__ = ["AXES", "NO_VECTOR", "Curve", "Link", "RollBar", "Springs"]

AXES = "xyz"
NO_VECTOR = Vector(ZERO, ZERO, ZERO)
HALVES = ("ahead", "aside")  # what a spring's displacement has beside the mean: its change along x, and along y


@dataclass(frozen=True)
class Curve:
    """A force over travel, straight between points and beyond the last ones, the corners rounded.

    Attributes
    ----------
    points : tuple of (Value, Value)
        Travel from rest (m) and force (N), both rising.
    rounding : Value
        A corner is rounded from so much before to so much after it (m).
    rest : int or None
        Which point is that of rest, where points lie on both sides of it; None: the other direction is alike.
    gap : bool
        Alike in both directions, and free before the first point.
    """

    points: tuple[tuple[Value, Value], ...]
    rounding: Value
    rest: int | None
    gap: bool

    def bends(self, s: Mapping[str, Any]) -> tuple[Any, list[tuple[Any, Any, int]]]:
        """Stiffness at rest (N/m), and the corners: (travel, change of stiffness beyond it, direction beyond, 1 or -1)."""
        d, force = [travel.of(s) for travel, _ in self.points], [force.of(s) for _, force in self.points]
        k = [(force[i + 1] - force[i]) / (d[i + 1] - d[i]) for i in range(len(d) - 1)]
        if self.rest is None:
            steps = [(d[0], k[0])] if self.gap else []
            steps += [(d[i], k[i] - k[i - 1]) for i in range(1, len(k))]
            return 0 if self.gap else k[0], [(sign * at, by, sign) for at, by in steps for sign in (1, -1)]
        ahead = [(d[i], k[i] - k[i - 1], 1) for i in range(self.rest, len(k))]
        behind = [(d[i], k[i - 1] - k[i], -1) for i in range(self.rest - 1, 0, -1)]
        return k[self.rest - 1], ahead + behind


@dataclass(frozen=True)
class Springs:
    """Springs and dampers along the axes of `upper`: one, a pair, or four at the corners of a rectangle.

    Attributes
    ----------
    name : str
        What they are called.
    upper, lower : str
        The bodies.
    at : Vector
        The middle at rest, m.
    half_x, half_y : Value
        Half the distances along and across; 0 where there is no second one.
    stiffness, damping : Vector
        Of one, N/m and N s/m.
    series : Vector
        Stiffness of what each damper is held by, N/m; the constant 0: held firmly.
    friction : Vector
        Dry friction of one, N.
    friction_speed : Value
        Sliding speed at which that has three quarters of its size, m/s.
    curves : mapping of str to Curve
        By axis, beside the stiffness: piecewise-linear springs, bump stops.
    """

    name: str
    upper: str
    lower: str
    at: Vector
    half_x: Value
    half_y: Value
    stiffness: Vector
    damping: Vector
    series: Vector = NO_VECTOR
    friction: Vector = NO_VECTOR
    friction_speed: Value = ZERO
    curves: Mapping[str, Curve] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """How many there are: 1, 2 or 4."""
        return (1 if self.half_x.is_zero else 2) * (1 if self.half_y.is_zero else 2)

    @property
    def halves(self) -> tuple[tuple[int, str, Value], ...]:
        """(axis, word, half the distance) for each axis along which there are two."""
        both = ((0, HALVES[0], self.half_x), (1, HALVES[1], self.half_y))
        return tuple((axis, word, half) for axis, word, half in both if not half.is_zero)

    @property
    def series_states(self) -> tuple[str, ...]:
        """States: how far the holds of the dampers are stretched; the mean, and its change along each half distance."""
        axes = [axis for axis in AXES if not getattr(self.series, axis).is_zero]
        words = ["", *(f"_{word}" for _, word, _ in self.halves)]
        return tuple(f"{self.name}_{axis}_series{word}" for axis in axes for word in words)

    @property
    def corners(self) -> tuple[tuple[int, int], ...]:
        """Signs of x and y of each of them."""
        return tuple((i, j) for i in ((0,) if self.half_x.is_zero else (1, -1)) for j in
                     ((0,) if self.half_y.is_zero else (1, -1)))  # fmt: skip

    def carrying(self, s: Mapping[str, Any]) -> Any:
        """Stiffness (N/m) of one along z at rest."""
        k, curve = self.stiffness.z.of(s), self.curves.get("z")
        return k if curve is None else k + curve.bends(s)[0]

    @property
    def carries(self) -> bool:
        """Whether it can hold a weight."""
        return not self.stiffness.z.is_zero or ("z" in self.curves and not self.curves["z"].gap)


@dataclass(frozen=True)
class Link:
    """A rod, spring or damper along the line between a point of each body: traction rods, yaw dampers, couplers.

    Attributes
    ----------
    name, upper, lower
        As for `Springs`.
    upper_end, lower_end : Vector
        Where it is fixed at rest (m).
    mirrored : bool
        Whether there is a second one at -y.
    stiffness, damping, series, friction, friction_speed, curve
        As for `Springs`, along the line; a pull is positive.
    """

    name: str
    upper: str
    lower: str
    upper_end: Vector
    lower_end: Vector
    mirrored: bool
    stiffness: Value
    damping: Value
    series: Value
    friction: Value
    friction_speed: Value
    curve: Curve | None

    @property
    def sides(self) -> tuple[tuple[str, int], ...]:
        """(end of the name, sign of y) of each."""
        return (("_left", 1), ("_right", -1)) if self.mirrored else (("", 1),)

    @property
    def series_states(self) -> tuple[str, ...]:
        """States: how far the holds of the dampers are stretched."""
        return () if self.series.is_zero else tuple(f"{self.name}{side}_series" for side, _ in self.sides)


@dataclass(frozen=True)
class RollBar:
    """A torsion bar against roll of the lower body under the upper one: N m/rad, N m s/rad."""

    name: str
    upper: str
    lower: str
    stiffness: Value
    damping: Value
