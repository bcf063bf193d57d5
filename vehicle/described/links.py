"""What links along their own line, and roll bars, do between two bodies. SI units.

A link runs from a point of the upper body to one of the lower body, d apart as seen from the upper one, d_0 at rest:

    e = |d| - |d_0|,   e' = d.d' / |d|,   F = -(k e + f(e) + c e' + F_0 tanh(e' / v_0)) d / |d|    on the lower body

and -F on the upper one. F acts along the line through both points, so it may be put at the lower one for both. A damper held
by a series stiffness k_s gives k_s q for c e', q' = e' - k_s q / c.

A roll bar feels how far the lower body's y axis S_y points up in the upper body's axes, phi = S_yz, and so

    phi' = (w x S_y)_z = w.g,   g = S_y x e_z,   M = -(k phi + c phi') g                          on the lower body

w being the relative angular velocity: for small angles the roll between the two, for any angle without loss of energy.
"""

from collections.abc import Mapping

import casadi as ca

from ..rotation import column, cross
from . import laws
from .between import Link, RollBar
from .elements import Action, Meeting, Seat, acting

__all__ = ["link_action", "roll_bar_action"]


def link_action(s: Mapping[str, ca.SX], link: Link, side: str, seat: Seat, at: Meeting, rest: ca.SX) -> Action:
    """One link; `at` is its lower end seen from its upper one, and `rest` the same at rest, in the upper body's axes (m)."""
    length = ca.sqrt(ca.dot(at.e, at.e))
    along = at.e / length
    e, e_dot = length - ca.sqrt(ca.dot(rest, rest)), ca.dot(along, at.e_dot)
    k, c = link.stiffness.of(s), link.damping.of(s)
    pull, energy, heat, rates = k * e, k * e * e / 2, ca.SX(0), {}
    if link.series.is_zero:
        pull, heat = pull + c * e_dot, c * e_dot**2
    else:
        state = f"{link.name}{side}_series"
        held, q = link.series.of(s), s[state]
        rates[state] = e_dot - held * q / c
        pull, energy, heat = pull + held * q, energy + held * q * q / 2, (held * q) ** 2 / c
    if link.curve is not None:
        pull, energy = pull + laws.travelled(link.curve, s, e), energy + laws.stored(link.curve, s, e)
    if not link.friction.is_zero:
        rub = laws.dry_friction(link.friction.of(s), link.friction_speed.of(s), e_dot)
        pull, heat = pull + rub, heat + rub * e_dot
    return acting(link, seat, at, -pull * along, ca.SX.zeros(3), energy, heat, rates)


def roll_bar_action(s: Mapping[str, ca.SX], bar: RollBar, seat: Seat, at: Meeting) -> Action:
    """A roll bar; `at` is any point of the lower body seen from the upper one."""
    k, c, S_y = bar.stiffness.of(s), bar.damping.of(s), at.S[:, 1]
    g = cross(S_y, column(0, 0, 1))
    phi, phi_dot = S_y[2], ca.dot(at.w, g)
    return acting(bar, seat, at, ca.SX.zeros(3), -(k * phi + c * phi_dot) * g, k * phi**2 / 2, c * phi_dot**2, {})
