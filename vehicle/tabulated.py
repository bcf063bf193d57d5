"""Wheels and rails given by points, in the equations of motion: vehicle.contact_tables as a `Pairing`. SI units.

With o, U outwards and up, square to the rail's tangent t at the wheel, P the bottom of the tape circle and L the running line,

    v = -o.(P - L) to the side away from the flange,   z = U.(P - L),   sin(psi) = -a.t,   a the axle outwards      (1)
    gap = (z - height + (out - o.(P - L)) (sin(phi) - sin(roll))) cos(delta)                                        (2)
    E* k e^3 = N,   e^2 + sin(delta)^2 N / c = sink - gap                                                           (3)

height, out, delta, roll, sink, k from the tables over v and sin(psi)^2. The bracket of (2) is what a wheelset gains that rolls
otherwise than on a straight even track. (3) is Kik and Piotrowski's load in series with the lateral stiffness c of the rail,
which a tread hardly feels; three Newton steps from e = sqrt(p) / (1 + r sqrt(p))^(1/3), p the right-hand side,
r = sin(delta)^2 E* k / c, which is exact for soft and for stiff rails: then it is right to 1e-9 for all.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from gyro_cosim.component.tables import surface

from .contact_tables import QUANTITIES, SHIFT, YAW2, Fit, SideTable
from .creep_laws import LAWS, Patch, polach
from .kalker import Coefficients
from .pairing import Side, Standing
from .rotation import column, cross, dot
from .wheel_rail import Touch, Wheel, forces_at, shear_modulus

__all__ = ["Tabulated"]

SMOOTH = 5  # of the QUANTITIES, those that say where the contact is: monotone cubics; the others are straight between points
LEAST_DEPTH = 1e-12  # m, keeps the patch of a lifted part from vanishing
_AT = {name: i for i, name in enumerate(QUANTITIES)}


@dataclass(frozen=True)
class Tabulated:
    """Wheels and rails by tables.

    Attributes
    ----------
    fit : Fit
        The tables.
    flange_side : int
        1: flanges outside the rails, -1: inside.
    """

    fit: Fit
    flange_side: int

    def table(self, side: str) -> SideTable:
        """Of the left or the right side."""
        return self.fit.left if side == "left" else self.fit.right

    @property
    def unlike(self) -> bool:
        """Whether the sides have tables of their own."""
        return self.fit.left is not self.fit.right

    def contacts(self) -> list[tuple[str, float, float, float, float, float]]:
        """Where the left wheel carries its load without yaw: part, shift, place out and up (m), angle (rad), radius less that
        of the tape line (m)."""
        parts = {"tread": self.fit.left.tread, "flange": self.fit.left.flange}
        found = []
        for i, shift in enumerate(SHIFT):
            if abs(shift) > 0.012:
                continue
            name = max(parts, key=lambda part: parts[part][i, 0, 0])
            height, tangent, out, up = (float(value) for value in parts[name][i, 0, :4])
            found.append((name, float(shift), out, up, float(np.arctan(tangent)), height - up))
        return found

    def standing(self, s: Mapping[str, ca.SX], grid: int, side: str = "left") -> Standing:
        """On the treads, over the running lines, rolled as the tables have it."""
        q = ca.SX(ca.DM(self.table(side).tread[int(np.argmin(np.abs(SHIFT))), 0]))
        tangent = q[_AT["tangent"]]
        press = _press(s, q, grid)

        def heights(depth: Any, cosine: Any) -> tuple[Any, Any]:
            axle = q[_AT["height"]] + (q[_AT["sink"]] - depth) / cosine + s["rolling_radius"]
            return axle, axle - q[_AT["up"]]

        stiffness = q[_AT["stiffness"]] * modulus(s)

        def area(load: Any) -> Any:
            return ca.sqrt(q[_AT["a2"]] * q[_AT["b2"]]) * (load / stiffness) ** (2 / 3)

        return Standing(tangent, stiffness, press, heights, area, _coefficients(q))

    def touches(self, wheel: Wheel, side: Side, s: Mapping[str, ca.SX], law: str, grid: int) -> tuple[Touch, Touch]:
        """By (1) to (3)."""
        b, table = s["contact_half_distance"], self.table(side.name)
        line, t = side.line(side.sign * b, 0, -side.sign * b * ca.sin(side.yaw))
        axle = self.flange_side * wheel.axle
        o = side.sign * column(-t[1], t[0], 0) / ca.sqrt(t[0] * t[0] + t[1] * t[1])
        up = side.sign * cross(t, o)
        down = -side.sign * cross(t, axle)
        P = wheel.centre + s["rolling_radius"] / ca.sqrt(dot(down, down)) * down - line
        sine = -dot(axle, t)
        pose = _Pose(line, t, o, up, dot(P, o), dot(P, up), sine, dot(axle, up))
        v = -self.flange_side * pose.out
        found = []
        for part, values in (("tread", table.tread), ("flange", table.flange)):
            axes = (SHIFT.tolist(), YAW2.tolist())
            place = surface(*axes, values[:, :, :SMOOTH], kind="monotone", names=("shift", "yaw"))(v, sine * sine)
            patch = surface(*axes, values[:, :, SMOOTH:], kind="linear", names=("shift", "yaw"))(v, sine * sine)
            q = ca.vertcat(place, patch)
            acting = LAWS[law] if part == "tread" or law in ("kalker", "linear") else polach
            found.append(forces_at(wheel, t, self._contact(q, pose, v), _press(s, q, grid), acting))
        return found[0], found[1]

    def _contact(self, q: ca.SX, pose: "_Pose", v: Any) -> tuple[Any, ...]:
        """(gap, shift, tangent, normal, contact point) of one part."""
        height, tangent, out, up, ahead, roll, sink = (q[_AT[name]] for name in QUANTITIES[:7])
        cosine = 1 / ca.sqrt(1 + tangent * tangent)
        lift = pose.up_of - height + (out - pose.out) * (pose.roll - roll)
        n = cosine * (pose.up + self.flange_side * tangent * pose.o)
        at = pose.line + (ahead * pose.sine) * pose.t + out * pose.o + up * pose.up
        return lift * cosine - sink, v, tangent, n, at

    def climb(self, flange: Touch, side: str, s: Mapping[str, ca.SX]) -> Any:
        """By the shift."""
        table = self.table(side)
        return (flange.depth - table.clearance) / (table.top - table.clearance)


@dataclass(frozen=True)
class _Pose:
    """A wheel at its rail: the running line, axes, bottom of the tape circle from the line out and up, sines of yaw and roll."""

    line: ca.SX
    t: ca.SX
    o: ca.SX
    up: ca.SX
    out: Any
    up_of: Any
    sine: Any
    roll: Any


def modulus(s: Mapping[str, ca.SX]) -> Any:
    """E* of wheel and rail (Pa)."""
    return s["youngs_modulus"] / (2 * (1 - s["poisson_ratio"] ** 2))


def _coefficients(q: ca.SX) -> Coefficients:
    return Coefficients(*(q[_AT[name]] for name in ("C11", "C22", "C23", "C33")))


def _press(s: Mapping[str, ca.SX], q: ca.SX, grid: int) -> Any:
    """Penetration (m) and its rate (m/s) -> normal load and patch, by (3)."""
    tangent2 = q[_AT["tangent"]] ** 2
    k = q[_AT["stiffness"]] * modulus(s)
    r = tangent2 / (1 + tangent2) * k / s["rail_lateral_stiffness"]

    def press(depth: Any, rate: Any) -> tuple[Any, Patch]:
        p = ca.fmax(depth, LEAST_DEPTH)
        root = ca.sqrt(p)
        e = root / (1 + r * root) ** (1 / 3)
        for _ in range(3):
            e = e - (e * e * (1 + r * e) - p) / (e * (2 + 3 * r * e))
        sunk = e * e
        N = k * sunk * e * ca.fmax(1 + s["contact_damping"] * rate, 0.0)
        a, b = ca.sqrt(q[_AT["a2"]] * sunk), ca.sqrt(q[_AT["b2"]] * sunk)
        return N, Patch(a, b, N, s["friction"], shear_modulus(s), _coefficients(q), grid)

    return press
