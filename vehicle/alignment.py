"""The track's centre line in the equations of motion: piecewise linear curvature, cant angle and gradient over s.

    kappa(s) = sum a_j <s - s_j>,   heading chi(s) = sum a_j <s - s_j>^2 / 2            <x> = max(x, 0)
    cant angle alpha(s) = sum c_j <s - s_j>,   gradient angle g(s) = sum g_j <s - s_j>

s is the length along the centre line. The track frame at s is Rz(chi) Ry(-g) Rx(alpha): x along the track, y to the left in
the plane of the rails, z up. kappa > 0 turns left, g > 0 climbs, alpha > 0 lifts the left rail. Before s_0 all are zero.
Its angular velocity per unit of s, in its own axes (derivation: Euler angles chi, -g, alpha about z, y, x):

    Omega = (alpha' + kappa sin g,  -g' cos alpha + kappa cos g sin alpha,  kappa cos g cos alpha + g' sin alpha)

Where a track frame lies, seen from another a few metres off, needs the integrals of cos g cos D, cos g sin D and sin g, D the
heading difference. Their leading parts, of D and g, are integrated exactly; the remainders, of third order in D and g
(second order for the shortening), by Gauss-Legendre with three points: better than 0.1 um for a curve of 50 m and 7 m.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import casadi as ca

from .rotation import about_x, about_y, about_z, column
from .track_files import Line

__all__ = ["CAPACITY", "COLUMNS", "Alignment", "TrackPoint"]

NODES = ((0.5 - 0.15**0.5, 5 / 18), (0.5, 8 / 18), (0.5 + 0.15**0.5, 5 / 18))  # of Gauss-Legendre on 0..1, with weights
CAPACITY = 4  # free knots beside the four of the standard curve, unless a vehicle is built with more
COLUMNS = ("position", "curvature_slope", "cant_slope", "gradient_slope")


@dataclass(frozen=True)
class TrackPoint:
    """The track frame at one s, as expressions.

    Attributes
    ----------
    curvature : casadi.SX
        1/m, positive to the left.
    heading, cant, gradient : casadi.SX
        Angles (rad).
    cant_slope, gradient_slope : casadi.SX
        Their changes along the track (rad/m).
    heading_integral, gradient_integral : casadi.SX
        Integrals over s (rad m).
    """

    curvature: Any
    heading: Any
    heading_integral: Any
    cant: Any
    cant_slope: Any
    gradient: Any
    gradient_slope: Any
    gradient_integral: Any

    def turn_rate(self) -> ca.SX:
        """Omega of the module's docstring, rad/m, shape (3, 1)."""
        sa, ca_, sg, cg = ca.sin(self.cant), ca.cos(self.cant), ca.sin(self.gradient), ca.cos(self.gradient)
        k, gs = self.curvature, self.gradient_slope
        return column(self.cant_slope + k * sg, -gs * ca_ + k * cg * sa, k * cg * ca_ + gs * sa)

    def up(self) -> ca.SX:
        """The vertical in track axes, shape (3, 1)."""
        return about_x(self.cant).T @ column(ca.sin(self.gradient), 0, ca.cos(self.gradient))


@dataclass(frozen=True)
class Alignment:
    """The knots of a centre line, as symbols or numbers.

    Attributes
    ----------
    position : tuple
        s_j (m).
    curvature_slope : tuple
        Changes of the curvature's slope there, a_j (1/m^2).
    cant_slope, gradient_slope : tuple
        Changes of the slopes of cant and gradient angle there, c_j and g_j (rad/m).
    line : Line, optional
        Of a file, to which the knots add.
    """

    position: tuple[Any, ...]
    curvature_slope: tuple[Any, ...]
    cant_slope: tuple[Any, ...]
    gradient_slope: tuple[Any, ...]
    line: Line | None = None

    @classmethod
    def of(cls, symbols: Mapping[str, ca.SX], capacity: int, line: Line | None = None) -> "Alignment":
        """From a component's symbols: the standard curve's four knots, then `track_position[0]`, ... up to `capacity`.

        The standard curve is transition, curve, transition from `curve_start` on; `curve_turn` 1 left, -1 right, 0 none.
        """
        T, turn = symbols["transition_length"], symbols["curve_turn"]
        ends = (symbols["curve_start"], symbols["curve_start"] + T + symbols["curve_length"])
        curvature = turn / (symbols["curve_radius"] * T)
        cant = -turn * symbols["curve_cant"] / (2 * symbols["contact_half_distance"] * T)
        standard = {
            "position": (ends[0], ends[0] + T, ends[1], ends[1] + T),
            "curvature_slope": (curvature, -curvature, -curvature, curvature),
            "cant_slope": (cant, -cant, -cant, cant),
            "gradient_slope": (0, 0, 0, 0),
        }
        free = {c: tuple(symbols[f"track_{c}[{i}]"] for i in range(capacity)) for c in COLUMNS}
        knots = {c: standard[c] + free[c] for c in COLUMNS}
        return cls(knots["position"], knots["curvature_slope"], knots["cant_slope"], knots["gradient_slope"], line)

    def at(self, s: Any) -> TrackPoint:
        """The track frame at `s` (m)."""
        ramps = [ca.fmax(s - s_j, 0.0) for s_j in self.position]
        squares = [r * r for r in ramps]
        cubes = [r * q for r, q in zip(ramps, squares, strict=True)]
        passed = [s > s_j for s_j in self.position]

        def total(slopes: tuple[Any, ...], powers: list[Any]) -> Any:
            return sum((a * r for a, r in zip(slopes, powers, strict=True)), ca.SX(0))

        knots = TrackPoint(
            curvature=total(self.curvature_slope, ramps),
            heading=total(self.curvature_slope, squares) / 2,
            heading_integral=total(self.curvature_slope, cubes) / 6,
            cant=total(self.cant_slope, ramps),
            cant_slope=total(self.cant_slope, passed),
            gradient=total(self.gradient_slope, ramps),
            gradient_slope=total(self.gradient_slope, passed),
            gradient_integral=total(self.gradient_slope, squares) / 2,
        )
        if self.line is None:
            return knots
        by_file = self.line.at(s)
        return TrackPoint(**{field.name: by_file[field.name] + getattr(knots, field.name) for field in fields(TrackPoint)})

    def between(self, s_here: Any, here: TrackPoint, s_there: Any, there: TrackPoint) -> tuple[ca.SX, ca.SX]:
        """Where the track frame at `s_there` lies, seen in the one at `s_here`: (offset in m, rotation), (3, 1) and (3, 3)."""
        run = s_there - s_here
        # leading parts: x runs along, y and z by the integrals of heading difference and gradient
        x: Any = run
        y: Any = there.heading_integral - here.heading_integral - here.heading * run
        z: Any = there.gradient_integral - here.gradient_integral
        for node, weight in NODES:
            at = self.at(s_here + node * run)
            D, g = at.heading - here.heading, at.gradient
            x = x + weight * run * (ca.cos(g) * ca.cos(D) - 1.0)
            y = y + weight * run * (ca.cos(g) * ca.sin(D) - D)
            z = z + weight * run * (ca.sin(g) - g)
        level = about_y(-here.gradient) @ about_x(here.cant)  # from the frame here to axes that are level but turned to chi
        turned = about_z(there.heading - here.heading) @ about_y(-there.gradient) @ about_x(there.cant)
        return level.T @ column(x, y, z), level.T @ turned
