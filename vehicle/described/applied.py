"""What is put on a vehicle from outside, as inputs: forces on bodies (wind), torques on wheels (traction, brakes). SI units.

A force F along the axes of the track under the body, at a point r of it, gives F and r x R' F. A torque T turns a wheel of
independent axles, or a solid axle; the body that it is braced against, a frame with its motor or its brake, feels -T about
the axle. Where none is named the wheel frame itself does.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from ..rotation import column, cross
from .description import Force, Torque
from .elements import Action
from .moving import Moving

__all__ = ["force_on", "torque_action", "torques_on"]


def force_on(s: Mapping[str, ca.SX], one: Force, moving: Moving) -> tuple[ca.SX, ca.SX, Any]:
    """(force in track axes, moment about the centre in the body's axes, power)."""
    F = column(*(s[f"{one.name}_force_{axis}"] if axis in one.starts else 0 for axis in "xyz"))
    x, y, z = one.at.of(s)
    r = column(x - moving.x, y - moving.y, z - moving.height)
    moment = cross(r, moving.at.attitude().T @ F)
    return F, moment, ca.dot(F, moving.at.v) + ca.dot(moment, moving.at.omega)


def torques_on(s: Mapping[str, ca.SX], torques: list[Torque]) -> tuple[Any, Any]:
    """The sum of the torques on left and right wheel; a solid axle's is halved between them."""
    sides = [0, 0]
    for one in torques:
        values = [s[name] for name in one.inputs]
        for i in (0, 1):
            sides[i] = sides[i] + (values[0] / 2 if one.solid else values[i])
    return sides[0], sides[1]


def torque_action(one: Torque, total: Any, axle: ca.SX, rates: tuple[ca.SX, Any]) -> Action:
    """What the bodies at both ends feel of a torque on wheels; the wheel frame's own -T stands in its equations.

    Parameters
    ----------
    one : Torque
        The torque.
    total : casadi.SX
        Its sum over the wheels (N m).
    axle : casadi.SX, shape (3, 1)
        Along the axle, in the axes of the free body that moves what the torque is braced against.
    rates : tuple of (casadi.SX of shape (3, 1), casadi.SX)
        That body's angular velocity in the same axes, and the pitch rate of the wheel frame (rad/s).
    """
    none = ca.SX.zeros(3)
    power = total * (rates[1] - ca.dot(axle, rates[0]))
    return Action(one.against, one.wheelset, none, column(0, total, 0), none, -total * axle, -total * axle[2], 0, 0, power=power)
