"""The equations of motion, derived a second time: velocities of every part projected on the coordinates by AD.

Every part (car body, bogies, wheel frames with gimbals, four wheels) has its own place R(q), X(q) in fixed axes, built from
the track's definition by quadrature. With V = A(q) q' the velocities of all parts, Newton and Euler projected give

    sum A^T (M (A q'' + A' q') + gyroscopic) = sum A^T (applied force)

on the coordinates q = (s, y, z, psi, phi, theta) of three bodies, two pivots and four wheel angles: 24. The accelerations must
agree with vehicle.car_body and vehicle.wheel_frame to rounding, inside a clothoid with changing cant and gradient.
"""

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.component import Component
from gyro_cosim.vehicle import car_body, wheel_frame
from gyro_cosim.vehicle.alignment import Alignment
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.running_gear import frame_mass
from gyro_cosim.vehicle.wheel_frame import FrameState

KAPPA, CANT, GRADE = 2e-3, -4e-3, 3e-3  # slopes per metre, from s = 0 on
N_Q = 24


def rz(a: ca.SX) -> ca.SX:
    return ca.vertcat(ca.horzcat(ca.cos(a), -ca.sin(a), 0), ca.horzcat(ca.sin(a), ca.cos(a), 0), ca.horzcat(0, 0, 1))


def rx(a: ca.SX) -> ca.SX:
    return ca.vertcat(ca.horzcat(1, 0, 0), ca.horzcat(0, ca.cos(a), -ca.sin(a)), ca.horzcat(0, ca.sin(a), ca.cos(a)))


def ry(a: ca.SX) -> ca.SX:
    return ca.vertcat(ca.horzcat(ca.cos(a), 0, ca.sin(a)), ca.horzcat(0, 1, 0), ca.horzcat(-ca.sin(a), 0, ca.cos(a)))


def track(s: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Place and axes of the track frame at s > 0, from the definition: 20-point Gauss-Legendre, exact to rounding."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    X = ca.SX.zeros(3)
    for node, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        u = node * s
        g, chi = GRADE * u, KAPPA * u**2 / 2
        X += weight * s * ca.vertcat(ca.cos(g) * ca.cos(chi), ca.cos(g) * ca.sin(chi), ca.sin(g))
    return X, rz(KAPPA * s**2 / 2) @ ry(-GRADE * s) @ rx(CANT * s)


@pytest.fixture(scope="module")
def vehicle() -> Component:
    return lrt_set_a()


def test_track_frames_seen_from_one_another(vehicle: Component) -> None:
    """Alignment.between against the definition: 7 m apart on a clothoid, remainders by three points: 0.1 um."""
    knots = [ca.SX([0.0]), ca.SX([KAPPA]), ca.SX([CANT]), ca.SX([GRADE])]
    alignment = Alignment(*(tuple(ca.vertsplit(k)) for k in knots))
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    offset, turned = alignment.between(a, alignment.at(a), b, alignment.at(b))
    (Xa, Ra), (Xb, Rb) = track(a), track(b)
    f = ca.Function("f", [a, b], [offset - Ra.T @ (Xb - Xa), turned - Ra.T @ Rb])
    for where in ((2.0, 9.0), (9.0, 2.5), (5.0, 5.0)):
        distance, rotation = (np.abs(np.array(v)).max() for v in f(*where))
        assert distance < 1e-7
        assert rotation < 1e-14


@pytest.mark.parametrize("pivot", [{}, {"pivot_damping": 7e3, "pivot_inertance": 300.0}], ids=["pivot", "damper and inerter"])
def test_second_derivation_agrees_to_rounding(vehicle: Component, pivot: dict[str, float]) -> None:
    s = {v.name: ca.SX(pivot.get(v.name, v.start)) for v in vehicle.parameters}
    q, dq, ddq = ca.SX.sym("q", N_Q), ca.SX.sym("dq", N_Q), ca.SX.sym("ddq", N_Q)
    half = float(s["pivot_spacing"]) / 2
    m_body, h_body = car_body.masses(s)
    m_frame, J = frame_mass(s)
    b = s["contact_half_distance"]

    def pose(i: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Place of the centre, attitude, and axes of the track frame of body i."""
        X, Rt = track(q[6 * i])
        y, z, psi, phi, theta = (q[6 * i + k] for k in range(1, 6))
        return X + Rt @ ca.vertcat(0, y, z), Rt @ rz(psi) @ rx(phi) @ ry(theta), Rt

    def velocity(X: ca.SX, R: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Velocity in fixed axes and angular velocity in the axes of R, by AD."""
        R_dot = ca.reshape(ca.jtimes(R.reshape((9, 1)), q, dq), 3, 3)
        skew = R.T @ R_dot
        return ca.jtimes(X, q, dq), ca.vertcat(skew[2, 1], skew[0, 2], skew[1, 0])

    rng = np.random.default_rng(7)
    applied = {key: rng.normal(size=n) * size for key, n, size in (
        ("F0", 3, 5e4), ("M0", 3, 5e4), ("F1", 3, 5e4), ("M1", 3, 2e4), ("F2", 3, 5e4), ("M2", 3, 2e4), ("pivot", 2, 1e4),
        ("axle", 4, 5e3))}  # fmt: skip

    # parts: (mass, inertia in the axes R, velocity, angular velocity whose axes are R, frame rate of R)
    parts, power = [], ca.SX(0)
    X, R, Rt = pose(0)
    v_body, w_body = velocity(X, R)
    up_body, up_bogie = s["body_height"] - h_body, s["bogie_height"] - h_body
    inertia = ca.vertcat(s["body_ixx"], s["body_iyy"], s["body_izz"])
    parts.append((s["body_mass"], inertia, velocity(X + R @ ca.vertcat(0, 0, up_body), R)[0], w_body, w_body))
    power += ca.dot(applied["F0"], Rt.T @ v_body) + ca.dot(applied["M0"], w_body)
    mine = {"body": (v_body, w_body, Rt)}
    for i in range(2):
        R_i = R @ rz(q[18 + i])
        v, w = velocity(X + R @ ca.vertcat(half if i == 0 else -half, 0, up_bogie), R_i)
        parts.append((s["bogie_mass"], ca.vertcat(s["bogie_ixx"], s["bogie_iyy"], s["bogie_izz"]), v, w, w))
        power += applied["pivot"][i] * (w[2] - w_body[2])
        mine[f"bogie{i}"] = w[2]
    for i in (1, 2):
        X, R, Rt = pose(i)
        v, w = velocity(X, R)
        inner = ca.vertcat(s["inner_gimbal_ixx"], 0, s["inner_gimbal_izz"])  # its pitch inertia belongs to the gyro unit
        inertia = inner + ca.vertcat(*(s[f"frame_i{k}{k}"] + s[f"outer_gimbal_i{k}{k}"] for k in "xyz"))
        parts.append((m_frame - 2 * s["wheel_mass"], inertia, v, w, w))
        power += ca.dot(applied[f"F{i}"], Rt.T @ v) + ca.dot(applied[f"M{i}"], w)
        mine[f"frame{i}"] = (v, w, Rt)
        for side in (0, 1):
            spin = dq[20 + 2 * (i - 1) + side]
            v_wheel, _ = velocity(X + R @ ca.vertcat(0, (1 - 2 * side) * b, 0), R)
            w_wheel = w + ca.vertcat(0, spin, 0)
            parts.append(
                (s["wheel_mass"], ca.vertcat(s["wheel_ixx"], s["wheel_spin_inertia"], s["wheel_ixx"]), v_wheel, w_wheel, w)
            )
            power += applied["axle"][2 * (i - 1) + side] * spin
            mine[f"spin{i}{side}"] = w_wheel[1]

    def rate(value: ca.SX) -> ca.SX:
        """d/dt of a function of q and q'."""
        return ca.jtimes(value, q, dq) + ca.jtimes(value, dq, ddq)

    balance = -ca.gradient(power, dq)
    balance[18:20] += s["pivot_damping"] * dq[18:20] + s["pivot_inertance"] * ddq[18:20]
    for m, inertia, v, w, w_axes in parts:
        balance += ca.jacobian(v, dq).T @ (m * rate(v))
        balance += ca.jacobian(w, dq).T @ (inertia * rate(w) + ca.cross(w_axes, inertia * w))
    M = ca.jacobian(balance, ddq)
    h = ca.substitute(balance, ddq, ca.SX.zeros(N_Q))
    project = ca.Function("project", [q, dq], [M, h])

    # a moderate random state on the clothoid, and the accelerations by projection
    at = np.zeros(N_Q)
    at[[0, 6, 12]] = 20.0, 20.0 + half, 20.0 - half
    at += rng.normal(size=N_Q) * 0.02
    at[[2, 8, 14]] += float(h_body), 0.33, 0.33
    dot = rng.normal(size=N_Q) * 0.3
    dot[[0, 6, 12]], dot[20:] = 8.0 + 0.1 * rng.normal(size=3), 25 + rng.normal(size=4)
    mass, rest = (np.array(v) for v in project(at, dot))
    acceleration = np.linalg.solve(mass, -rest.ravel())
    assert mass.shape == (24, 24)
    assert np.linalg.matrix_rank(mass) == 24

    def value(expression: ca.SX) -> np.ndarray:
        return np.array(ca.Function("f", [q, dq, ddq], [expression])(at, dot, acceleration)).ravel()

    alignment = Alignment(*((ca.SX(v),) for v in (0.0, KAPPA, CANT, GRADE)))

    def state(i: int, key: str) -> tuple[FrameState, ca.SX, ca.SX]:
        v, w, Rt = mine[key]
        here = at[6 * i : 6 * i + 6]
        spins = tuple(float(value(mine[f"spin{i}{k}"])[0]) for k in (0, 1)) if i else (0, 0)
        frame = FrameState(*here, ca.SX(value(Rt.T @ v)), ca.SX(value(w)), spins)
        turn = alignment.at(here[0]).turn_rate()
        return frame, turn, ca.SX(wheel_frame.place_rates(frame, turn)[0])

    def compare(got: ca.SX, wanted: np.ndarray, what: str) -> None:
        scale = max(1.0, np.abs(wanted).max())
        assert np.abs(np.array(ca.DM(got)).ravel() - wanted).max() / scale < 1e-11, what

    body, turn, s_dot = state(0, "body")
    compare(ca.vertcat(*wheel_frame.place_rates(body, turn)), dot[:6], "kinematics of the body")
    v_dot = applied["F0"] / m_body - ca.cross(s_dot * turn, body.v)
    angles = (at[18], at[19])
    rates = tuple(float(value(mine[f"bogie{i}"])[0]) for i in range(2))
    omega_dot, w_dot = car_body.accelerations(s, body.omega, angles, rates, ca.SX(applied["M0"]), tuple(applied["pivot"]))
    v, w, Rt = mine["body"]
    # the body's force acts at the common centre, the projected one too; its moment includes the pivots' reactions
    compare(v_dot, value(rate(Rt.T @ v)), "body, velocity")
    compare(omega_dot, value(rate(w)), "body, rotation")
    for i in range(2):
        compare(w_dot[i], value(rate(mine[f"bogie{i}"])), f"bogie {i}")
    for i in (1, 2):
        frame, turn, s_dot = state(i, f"frame{i}")
        compare(ca.vertcat(*wheel_frame.place_rates(frame, turn)), dot[6 * i : 6 * i + 6], f"kinematics of frame {i}")
        axle = tuple(applied["axle"][2 * (i - 1) : 2 * i])
        v_dot, omega_dot, W_dot = wheel_frame.accelerations(
            frame, turn, s_dot, m_frame, J, s["wheel_spin_inertia"], ca.SX(applied[f"F{i}"]), ca.SX(applied[f"M{i}"]), axle, False
        )
        v, w, Rt = mine[f"frame{i}"]
        compare(v_dot, value(rate(Rt.T @ v)), f"frame {i}, velocity")
        compare(omega_dot, value(rate(w)), f"frame {i}, rotation")
        for k in (0, 1):
            compare(ca.SX(W_dot[k]), value(rate(mine[f"spin{i}{k}"])), f"wheel {i}{k}")
