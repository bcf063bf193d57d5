"""What is reported of a wheel on its rail: forces, creepages, contact angle, wear number, lift and climb."""

from typing import Any

import casadi as ca

from .wheel_rail import Touch

__all__ = ["REPORT", "report"]

REPORT = (
    ("vertical_force", "N", "vertical force of the wheel on the rail", "Q", 1e4),
    ("lateral_force", "N", "lateral force on the rail, positive as the flange presses", "Y", 1e4),
    ("derailment_coefficient", "1", "lateral over vertical force", "Y/Q", 1.0),
    ("longitudinal_creepage", "1", "longitudinal creepage of the tread", "xi", 1e-3),
    ("lateral_creepage", "1", "lateral creepage of the tread", "eta", 1e-3),
    ("spin_creepage", "rad/m", "spin creepage of the tread", "phi", 0.1),
    ("contact_angle", "rad", "contact angle of tread or flange, whichever carries more", "delta", 0.1),
    ("flange_force", "N", "normal force of the flange", "N_f", 1e4),
    ("wear_number", "N", "creep power over speed, tread and flange", "T gamma", 100.0),
    ("wheel_lift", "m", "gap between tread and rail, 0 in contact", "", 1e-3),
    ("climb", "1", "way of the flange over the rail: 0 at first touch, 1 on the top of the tip", "", 1.0),
)
LEAST_LOAD = 100.0  # N; an unloaded wheel has no ratio Y/Q


def report(tread: Touch, flange: Touch, towards: int, climb: Any) -> dict[str, Any]:
    """The rows of REPORT for one wheel; `towards` is the side (1 left, -1 right) on which its flange lies, `climb` its way."""
    Q = tread.force[2] + flange.force[2]
    Y = towards * (tread.force[1] + flange.force[1])
    xi, eta, phi = tread.creepages
    values = (
        Q, Y, Y / ca.fmax(Q, LEAST_LOAD), xi, eta, phi,
        ca.atan(ca.if_else(flange.normal_load > tread.normal_load, flange.slope, tread.slope)),
        flange.normal_load, tread.heat + flange.heat, ca.fmax(tread.gap, 0.0), climb,
    )  # fmt: skip
    return {name: value for (name, *_), value in zip(REPORT, values, strict=True)}
