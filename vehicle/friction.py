"""The coefficient of friction under a wheel: of its rail, of the place on the track, and of the slip. SI units.

    mu = mu_0 f_rail (1 + (f_stretch - 1) r(s)) ((1 - A) exp(-B w) + A),   w = v sqrt(xi^2 + eta^2)                 (1)
    r(s) = 1 on the stretch, 0 off it, straight over `friction_stretch_ramp` at either end                         (2)

mu_0 `friction`, f_rail `friction_left` or `friction_right`, A `friction_end_ratio`, B `friction_decay`. The factors multiply
mu_0, so a wet rail, a greased one or a leaf on it is a number below 1; the stretch has one for either rail. w is the speed at
which the surfaces slide in the contact's middle; spin adds none there. Every default makes (1) mu_0 to the last bit.

Falling friction takes more force from a slow slip than from a fast one: where the force falls with creepage, the creep law feeds
motion instead of damping it, which makes squeal and stick-slip. Source of the last factor of (1): Polach 2005, Creep forces in
simulations of traction vehicles running on adhesion limit, with A = 0.4 and B = 0.6 s/m on dry rails; mu_0 then is larger.
"""

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from gyro_cosim.component import parameter

__all__ = ["FRICTION", "Friction", "falling", "slip_speed", "under"]

SHARPEST = 1e-3  # m; a shorter ramp counts as this one
NO_SLIP = 1e-9  # keeps the slope of the slip finite where there is none

Friction = Callable[[Any], Any]  # speed of slip (m/s) -> coefficient of friction

OURS = "ours: none"
FRICTION = (
    parameter("friction_end_ratio", 1.0, "1", "friction at fast slip over that at none; 1: it does not fall", symbol="A",
              source="Polach 2005: 0.4 on dry rails, 1 where it is left out", min=0.0, max=1.0),
    parameter("friction_decay", 0.6, "s/m", "how fast friction falls with the speed of slip", symbol="B",
              source="Polach 2005, dry rails", min=0.0),
    *(parameter(f"friction_{side}", 1.0, "1", f"friction on the {side} rail over `friction`", source=OURS, min=0.0, max=10.0)
      for side in ("left", "right")),
    parameter("friction_stretch_start", 0.0, "m", "where a stretch of other friction begins", source=OURS),
    parameter("friction_stretch_length", 10.0, "m", "length of that stretch, ramps included", source=OURS, min=0.0),
    parameter("friction_stretch_ramp", 0.0, "m", "length over which friction changes at either end of it; 0: a jump", source=OURS,
              min=0.0),
    *(parameter(f"friction_stretch_{side}", 1.0, "1", f"friction of the {side} rail on the stretch over that off it", source=OURS,
                min=0.0, max=10.0) for side in ("left", "right")),
)  # fmt: skip


def falling(s: Mapping[str, ca.SX], static: Any) -> Friction:
    """Friction that falls with the speed of slip from `static`, at rest."""
    end, decay = s["friction_end_ratio"], s["friction_decay"]
    return lambda slip: static * ((1 - end) * ca.exp(-decay * slip) + end)


def under(s: Mapping[str, ca.SX], side: str, place: Any) -> Friction:
    """Friction of the rail `side`, "left" or "right", at `place` along the track (m).

    Parameters
    ----------
    s : mapping of str to casadi.SX
        A component's symbols by name.
    side : str
        Of the rail.
    place : casadi.SX
        s of the axle (m).
    """
    steepness = 1 / ca.fmax(s["friction_stretch_ramp"], SHARPEST)
    inside = place - s["friction_stretch_start"]
    nearest = ca.fmin(inside, s["friction_stretch_length"] - inside)  # to an end, positive on the stretch
    share = ca.fmin(ca.fmax(nearest * steepness, 0.0), 1.0)
    on = 1 + (s[f"friction_stretch_{side}"] - 1) * share
    return falling(s, s["friction"] * s[f"friction_{side}"] * on)


def slip_speed(speed: Any, xi: Any, eta: Any) -> Any:
    """w of (1), m/s, at the rolling speed `speed`."""
    return speed * ca.sqrt(xi * xi + eta * eta + NO_SLIP**2)
