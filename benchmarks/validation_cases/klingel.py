"""Klingel's wave: a wheelset of conicity gamma runs along a sine of 2 pi sqrt(b r0 / gamma), whatever its speed."""

from math import sqrt

import numpy as np

from gyro_cosim.stability import AtRest
from gyro_cosim.systems import System, SystemComponent, catalogue

from .table import Line, Quantity, Table

__all__ = ["waves"]

SPEEDS = (1.0, 2.0, 5.0, 10.0)  # m/s


def waves() -> Table:
    """Of the slowest hunting root over speed: a free wheelset, and the vehicle whose bogies turn freely on their pivots."""
    lines = []
    for variant, free in (("wheelset", ("guide_stiffness_x", "guide_stiffness_y")), ("lrt_solid_axle", ())):
        spec = f"vehicle:{variant}"
        start = {v.name: v.start for v in catalogue.component(spec).parameters}
        names = ("vehicle.speed", *(f"vehicle.{name}" for name in free))
        system = System(spec, (SystemComponent("vehicle", spec),), ())
        rest = AtRest(system, names, ("vehicle.*distance",) if free == () else ("vehicle.distance",))
        number = sqrt(start["conicity"] / (start["contact_half_distance"] * start["rolling_radius"]))  # rad/m
        for speed in SPEEDS:
            roots = rest.roots((speed, *(0.0 for _ in free)))
            hunting = max((root for root in roots if abs(root.imag - number * speed) < 0.2 * number * speed), key=np.real)
            lines.append(Line(f"`{spec}` at {speed:g} m/s, rad/s", ((float(hunting.imag), number * speed),)))
    return Table("Klingel 1883, v sqrt(gamma / (b r0))", (Quantity("", ".6g", 5e-3, relative=True),), tuple(lines))
