"""The gyro units that are to keep the lean small: the known limits of each. Their energy balance is tested with all variants."""

import casadi as ca
import numpy as np
import pytest
from frames import AXES, Rate, driven, sine

from gyro_cosim.gyro_unit.mount import CONNECTOR
from gyro_cosim.systems import catalogue

RATES = {axis: sine(0.3, 2.0 + i) for i, axis in enumerate(AXES)}
MOMENTS = [f"{axis}_moment" for axis in AXES]


def turning(rate: float) -> Rate:
    """A constant rate, its derivatives zero."""
    return lambda t: (rate, 0.0, 0.0)


@pytest.mark.parametrize(("unit", "values"), [
    ("progressive", {"outer_stiffness": 0.0, "outer_damping": 0.0}),
    ("centred", {"centring_gain": 0.0}), ("scheduled", {"curve_spin": 1.0}),
])  # fmt: skip
def test_without_what_it_adds_each_is_the_nonlinear_unit(unit: str, values: dict[str, float]) -> None:
    plain, other = driven("gyro_unit:nonlinear", RATES, stop=3.0), driven(f"gyro_unit:{unit}", RATES, stop=3.0, **values)
    added = driven(f"gyro_unit:{unit}", RATES, stop=3.0)
    for name in (*MOMENTS, "gimbal_angle"):
        size = np.abs(plain[name]).max()
        np.testing.assert_allclose(other[name], plain[name], rtol=0, atol=1e-12 * size)  # rounding: other formulas of the same
        assert np.abs(added[name] - plain[name]).max() > 1e-3 * size


def still(unit: str, angle: float, rate: float = 0.0, **values: float) -> dict[str, float]:
    """Outputs of a unit in a still frame at an angle and rate of its gimbal."""
    c = catalogue.component(unit)
    p = np.array([values.get(v.name, v.start) for v in c.parameters])
    x = np.array([{"gimbal_angle": angle, "gimbal_pitch_rate": rate}.get(v.name, 0.0) for v in c.states])
    return dict(zip((v.name for v in c.outputs), np.array(c.output(x, np.zeros(len(CONNECTOR) // 2), p)).ravel(), strict=True))


def test_progressive_spring_and_damper_are_soft_about_the_centre_and_stiff_outside() -> None:
    """A quarter of what is added is there at the slot's angle, all of it far outside, and less than 1e-4 at a tenth of it."""
    values = {"gimbal_stiffness": -2.0, "outer_stiffness": 10.0, "gimbal_damping": 0.1, "outer_damping": 5.0, "slot_angle": 0.2}

    def added(angle: float) -> tuple[float, float]:
        e = 1e-5
        torque = [still("gyro_unit:progressive", a, **values)["pitch_moment"] for a in (angle - e, angle + e)]
        heat = still("gyro_unit:progressive", angle, 1.0, **values)["dissipated_power"]
        return (torque[1] - torque[0]) / (2 * e) + 2.0, heat - 0.1

    for angle, share in ((0.0, 0.0), (0.2, 0.25), (-0.2, 0.25), (20.0, 1.0)):
        stiffness, damping = added(angle)
        assert stiffness == pytest.approx(10.0 * share, abs=3e-3)  # 2e-4 of 10 is missing at 100 slots
        assert damping == pytest.approx(5.0 * share, abs=2e-3)
    assert 0.0 < added(0.02)[0] < 1e-3 < added(0.05)[0]


def test_over_centre_spring_lets_the_gimbal_fall_to_where_the_outer_spring_holds_it() -> None:
    """In a still frame with the rotor at rest: from the centre's side to the rim, where the torque is zero, and E below zero."""
    values = {"gimbal_stiffness": -0.0045, "outer_stiffness": 0.03, "outer_damping": 0.02, "slot_angle": 0.3, "rotor_speed": 0.0}
    fallen = driven("gyro_unit:progressive", {}, stop=60.0, gimbal_angle=1e-3, **values)
    assert fallen["gimbal_angle"][-1] > 0.1
    assert abs(fallen["pitch_moment"][-1]) < 1e-6 * 0.0045
    assert fallen["stored_energy"][-1] < -1e-6


def test_active_centring_takes_the_lean_out_of_a_long_curve() -> None:
    """Steady yaw rate: without it k eta = -H psi', with it eta goes to 0 and the motor carries H psi'."""
    values = {"centring_gain": 1e-3, "centring_torque_limit": 0.01}
    H, k, rate = 3.7e-4 * 100 * 2 * np.pi / 60, 0.0045, 0.1
    plain = driven("gyro_unit:nonlinear", {"yaw": turning(rate)}, stop=20.0)
    assert plain["gimbal_angle"][-1] == pytest.approx(-H * rate / k, rel=0.01)  # the cosine of 5 degrees
    centred = driven("gyro_unit:centred", {"yaw": turning(rate)}, stop=80.0, **values)
    assert abs(centred["gimbal_angle"][-1]) < 1e-3 * abs(plain["gimbal_angle"][-1])
    assert centred["centring_torque"][-1] == pytest.approx(H * rate, rel=1e-3)
    assert centred["pitch_moment"][-1] == pytest.approx(-H * rate, rel=1e-3)


def test_the_centring_motor_keeps_within_its_torque() -> None:
    weak = driven("gyro_unit:centred", {"yaw": turning(1.0)}, stop=60.0, centring_gain=0.01, centring_torque_limit=1e-3)
    assert 0.99e-3 < np.abs(weak["centring_torque"]).max() <= 1e-3


def test_spin_follows_the_schedule_and_the_motor_pays_for_it() -> None:
    """In a steady turn the spin is (2), and the motor's energy is that of the rotor's change plus what it gave to the frame."""
    rate, f, r_s, Omega, C = 0.6, 0.4, 0.5, 10.0, 3.7e-4
    y = driven("gyro_unit:scheduled", {"yaw": turning(rate)}, stop=30.0, rotor_speed=Omega, curve_spin=f, schedule_rate=r_s)
    wanted = Omega * (f + (1 - f) / (1 + (rate / r_s) ** 4))
    assert y["spin"][0] == Omega
    assert y["spin"][-1] == pytest.approx(wanted, rel=1e-6)
    t = y["time"]
    change = y["stored_energy"][-1] - y["stored_energy"][0] + np.trapezoid(y["dissipated_power"] + y["yaw_moment"] * rate, t)
    paid = np.trapezoid(y["motor_power"], t)
    assert paid < 0.0  # slower: it brakes
    assert paid == pytest.approx(change, rel=1e-4)  # trapezoidal rule at 1 ms
    faster = driven(
        "gyro_unit:scheduled", {"yaw": turning(rate)}, stop=30.0, rotor_speed=Omega, curve_spin=1.5, schedule_rate=r_s
    )
    assert np.trapezoid(faster["motor_power"], t) > 0.0
    kinetic = C * (Omega**2 - wanted**2) / 2
    assert -paid == pytest.approx(kinetic, rel=0.05)  # the frame takes part in it by T sin(eta) psi'


def test_moments_of_the_scheduled_unit_are_the_change_of_its_rotors_momentum() -> None:
    """Independent of the model's own terms: L = C W e_x1, M = -(dL/dt in the frame + w x L), but for y, which (3) carries."""
    c = catalogue.component("gyro_unit:scheduled_full")
    rng, p = np.random.default_rng(5), c.start_parameters
    start = {v.name: v.start for v in c.parameters}
    order = [v.name for v in c.states]
    x, u = ca.SX.sym("x", len(order)), ca.SX.sym("u", 3)
    names = [v.name for v in c.inputs]
    eta = x[order.index("gimbal_angle")]
    W = start["rotor_speed"] + x[order.index("rotor_speed_deviation")]
    L = start["rotor_inertia"] * W * ca.vertcat(ca.cos(eta), 0, -ca.sin(eta))
    w = ca.vertcat(*(u[names.index(f"{axis}_rate")] for axis in ("roll", "pitch", "yaw")))
    change = ca.Function("change", [x, u], [ca.jtimes(L, x, c.rhs(x, u, p)) + ca.cross(w, L)])
    outputs = [v.name for v in c.outputs]
    for _ in range(20):
        state, motion = rng.standard_normal(len(order)), rng.standard_normal(3)
        y = np.array(c.output(state, motion, p)).ravel()
        expected = -np.array(change(state, motion)).ravel()
        for axis, of in (("roll", 0), ("yaw", 2)):
            assert y[outputs.index(f"{axis}_moment")] == pytest.approx(expected[of], abs=1e-12 * np.abs(expected).max())
