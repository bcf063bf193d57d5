"""Rotations and the kinematics of a body that follows the track. Axes: x forward, y left, z up; right-handed angles.

A body's axes stand in its track frame as R = Rz(psi) Rx(phi) Ry(theta): yaw, roll, pitch. With u = Ry(theta) omega, omega
the body's angular velocity relative to the track frame in body axes,

    phi' = u_x,   psi' = u_z / cos(phi),   theta' = u_y - psi' sin(phi).

Derivation: omega = Ry^T (Rx^T (0, 0, psi') + (phi', 0, 0)) + (0, theta', 0), so that u = (phi', theta' + psi' sin(phi),
psi' cos(phi)).
"""

from typing import Any

import casadi as ca

__all__ = ["about_x", "about_y", "about_z", "angle_rates", "attitude", "column", "cross", "dot"]


def about_x(angle: Any) -> ca.SX:
    """Rotation about x, shape (3, 3): maps components in the turned axes to components in the original ones."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(1, 0, 0), ca.horzcat(0, c, -s), ca.horzcat(0, s, c))


def about_y(angle: Any) -> ca.SX:
    """Rotation about y, shape (3, 3)."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, 0, s), ca.horzcat(0, 1, 0), ca.horzcat(-s, 0, c))


def about_z(angle: Any) -> ca.SX:
    """Rotation about z, shape (3, 3)."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def attitude(psi: Any, phi: Any, theta: Any) -> ca.SX:
    """R of the module's docstring."""
    return about_z(psi) @ about_x(phi) @ about_y(theta)


def angle_rates(phi: Any, theta: Any, omega: ca.SX) -> tuple[Any, Any, Any]:
    """(psi', phi', theta') for the angular velocity `omega` relative to the track frame, in body axes."""
    u = about_y(theta) @ omega
    psi_dot = u[2] / ca.cos(phi)
    return psi_dot, u[0], u[1] - psi_dot * ca.sin(phi)


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """a x b as a dense column."""
    return ca.vertcat(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: ca.SX, b: ca.SX) -> ca.SX:
    """Scalar product of two columns of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def column(x: Any, y: Any, z: Any) -> ca.SX:
    """A vector, shape (3, 1)."""
    return ca.vertcat(ca.SX(x), ca.SX(y), ca.SX(z))
