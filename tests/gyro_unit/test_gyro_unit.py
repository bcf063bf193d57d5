"""Gyro units: every variant passive, the known limits met, the connector the same."""

import casadi as ca
import numpy as np
import pytest
from frames import AXES, YAW_INERTIA, driven, framed, sine

from gyro_cosim import Jacobi, simulate
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.gyro_unit import VARIANTS
from gyro_cosim.gyro_unit.mount import BONDS, CONNECTOR
from gyro_cosim.systems import catalogue

SPECS = [f"gyro_unit:{variant}" for variant in VARIANTS]
PLAIN = [spec for spec in SPECS if ":hil" not in spec]  # what a rig returns need not be passive: see test_hil.py
MOTOR_OFF = {"motor_torque_limit": 0.0, "bearing_friction": 0.0, "bearing_viscous_friction": 0.0}


def places(rows: tuple, *names: str) -> list[int]:
    """Where rows called `names` stand."""
    known = [row.name for row in rows]
    return [known.index(name) for name in names]


@pytest.mark.parametrize("spec", SPECS)
def test_every_variant_has_the_connector(spec: str) -> None:
    unit = catalogue.component(spec)
    rows = {v.name: (v.causality, v.unit) for v in unit.variables}
    for row in CONNECTOR:
        assert rows[row.name] == (row.causality, row.unit)
    assert set(BONDS) <= set(unit.bonds)


@pytest.mark.parametrize("spec", PLAIN)
@pytest.mark.parametrize("spin", [-300.0, 0.0, 10.0, 300.0])
def test_energy_taken_from_the_frame_is_stored_or_dissipated(spec: str, spin: float) -> None:
    """Passivity as an identity at any state: E' = -(sum of moment times rate) + motor power - dissipated power, the last >= 0."""
    unit = catalogue.component(spec)
    rng = np.random.default_rng(7)
    p = unit.start_parameters
    p[[i for i, v in enumerate(unit.parameters) if v.name == "rotor_speed"]] = spin
    rates = places(unit.inputs, "yaw_rate", "roll_rate", "pitch_rate")
    moments = places(unit.outputs, "yaw_moment", "roll_moment", "pitch_moment")
    (stored,), (lost,) = places(unit.outputs, "stored_energy"), places(unit.outputs, "dissipated_power")
    motor = [i for i, v in enumerate(unit.outputs) if v.name == "motor_power"]
    x, u = ca.SX.sym("x", len(unit.states)), ca.SX.sym("u", len(unit.inputs))
    energy = unit.output(x, u, p)[stored]
    growth = ca.Function("growth", [x, u], [ca.jtimes(energy, x, unit.rhs(x, u, p)) if unit.states else ca.SX(0)])
    for _ in range(50):
        state, motion = rng.standard_normal(len(unit.states)), rng.standard_normal(len(unit.inputs))
        y = np.array(unit.output(state, motion, p)).ravel()
        power_in = -float(y[moments] @ motion[rates]) + y[motor].sum()
        terms = np.abs(y[moments] * motion[rates]).max() + abs(y[motor].sum()) + y[lost]
        assert float(growth(state, motion)) == pytest.approx(power_in - y[lost], abs=1e-12 * terms)  # rounding of the terms
        assert y[lost] >= 0.0


@pytest.mark.parametrize("spec", PLAIN)
def test_nothing_that_a_unit_reports_hangs_on_its_own_past_only(spec: str) -> None:
    """A unit at rest in a still frame stays at rest and loads its frame with nothing."""
    y = driven(spec, {}, stop=0.5)
    for axis in AXES:
        assert np.abs(y[f"{axis}_moment"]).max() == 0.0
    assert np.abs(y["gimbal_angle"]).max() == 0.0


def test_a_passive_unit_returns_no_more_than_it_took() -> None:
    """Driven by a yaw rate and left alone, the unit ends with the energy it took less what it turned into heat."""
    unit = catalogue.component("gyro_unit:nonlinear")
    x, p = unit.start_state, unit.start_parameters
    (moment,), (stored,), (lost,) = (places(unit.outputs, n) for n in ("yaw_moment", "stored_energy", "dissipated_power"))
    h, taken, heat = 1e-4, 0.0, 0.0
    for k in range(20000):
        t = k * h
        before = np.array(unit.output(x, [np.sin(3 * t), 0, 0], p)).ravel()
        x = unit.step(x, np.array([[np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)], [0] * 3, [0] * 3]), p, 0.0, h)
        after = np.array(unit.output(x, [np.sin(3 * (t + h)), 0, 0], p)).ravel()
        taken -= h / 2 * (before[moment] * np.sin(3 * t) + after[moment] * np.sin(3 * (t + h)))
        heat += h / 2 * (before[lost] + after[lost])
    assert taken == pytest.approx(after[stored] + heat, rel=1e-6)  # trapezoidal rule at 0.1 ms
    assert heat > 0.0


def test_nonlinear_tends_to_linear_for_small_motion() -> None:
    """The two differ by the square of the gimbal angle: a tenth of the motion, a hundredth of the difference."""
    linear, nonlinear = (catalogue.component(f"gyro_unit:{v}") for v in ("linear", "nonlinear"))
    u, p = np.array([1.0, 0.0, 0.0]), linear.start_parameters

    def difference(size: float) -> float:
        x = size * np.ones(2)
        a, b = (np.array(c.output(x, size * u, p)).ravel() for c in (linear, nonlinear))
        return abs(a[0] - b[0]) / size

    assert difference(0.01) / difference(0.1) == pytest.approx(0.01, rel=0.01)


def test_roll_moment_follows_from_momentum() -> None:
    """Moment on the frame in x and z against the change of the rotor's momentum H (cos eta, 0, -sin eta) in a still frame."""
    unit = catalogue.component("gyro_unit:nonlinear")
    p = unit.start_parameters
    H = np.prod(p[places(unit.parameters, "rotor_inertia", "rotor_speed")])
    eta, omega_y = 0.7, 2.0
    y = np.array(unit.output([eta, omega_y], [0, 0, 0], p)).ravel()
    M_x, M_z = y[places(unit.outputs, "roll_moment", "yaw_moment")]
    change = H * omega_y * np.array([-np.sin(eta), -np.cos(eta)])  # of (L_x, L_z)
    np.testing.assert_allclose([M_x, M_z], -change, rtol=1e-12)


def test_consistent_unit_obeys_the_triangle_inequality_that_table_1_breaks() -> None:
    def inertias(spec: str) -> np.ndarray:
        unit = catalogue.component(spec)
        return unit.start_parameters[places(unit.parameters, "rotor_inertia", "gimbal_inertia")]

    I_x, I_y = inertias("gyro_unit:linear")
    assert I_x > 2 * I_y
    I_x, I_y = inertias("gyro_unit:consistent")
    assert I_x <= 2 * I_y


def test_small_and_full_scale_come_in_pairs() -> None:
    small = {v for v in VARIANTS if not v.endswith("_full")} - {"consistent"}
    assert {f"{v}_full" for v in small} == {v for v in VARIANTS if v.endswith("_full")}
    for v in small:
        a, b = (catalogue.component(f"gyro_unit:{name}") for name in (v, f"{v}_full"))
        assert [row.name for row in a.variables] == [row.name for row in b.variables]


def difference(a: str, b: str, size: float, axes: tuple[str, ...], **values: float) -> float:
    """Largest difference of a moment between two units over its largest size, under sines of amplitude `size`."""
    rates = {axis: sine(size, 5.0 + 2 * i, 0.3 * i) for i, axis in enumerate(axes)}
    own = {v.name for v in catalogue.component(b).parameters}
    x = driven(a, rates, stop=3.0, **values)
    y = driven(b, rates, stop=3.0, **{k: v for k, v in values.items() if k in own})
    moments = [f"{axis}_moment" for axis in AXES]
    return max(np.abs(x[m] - y[m]).max() for m in moments) / max(np.abs(y[m]).max() for m in moments)


def test_multibody_tends_to_nonlinear_under_yaw_and_pitch_with_a_stiff_speed_controller() -> None:
    """What differs is of second order: a tenth of the motion, a tenth of the relative difference."""
    spec = "gyro_unit:multibody", "gyro_unit:nonlinear"
    stiff = {"speed_gain": 0.2, "speed_integral_gain": 0.2, "motor_torque_limit": 10.0}
    coarse, fine = (difference(*spec, size, ("yaw", "pitch"), **stiff) for size in (0.1, 0.01))
    assert fine < 2e-3
    assert fine / coarse == pytest.approx(0.1, rel=0.1)


def test_multibody_tends_to_nonlinear_under_all_rates_with_a_free_rotor() -> None:
    spec = "gyro_unit:multibody", "gyro_unit:nonlinear"
    coarse, fine = (difference(*spec, size, AXES, **MOTOR_OFF) for size in (0.1, 0.01))
    assert fine < 2e-3
    assert fine / coarse == pytest.approx(0.1, rel=0.1)


def test_a_rotor_held_at_its_speed_adds_its_spin_inertia_to_the_frames_roll() -> None:
    """Under roll alone, gimbal still: M_x = -C phi'' with a stiff controller, 0 with a free rotor."""
    roll = {"roll": sine(0.2, 3.0)}
    stiff = driven("gyro_unit:multibody", roll, stop=2.0, speed_gain=0.2, speed_integral_gain=0.0, motor_torque_limit=10.0,
                   gimbal_stiffness=1.0)  # fmt: skip
    late = stiff["time"] > 0.1  # the controller settles in C / K_p = 2 ms
    inertia = -3.7e-4 * 0.2 * 3.0 * np.cos(3.0 * stiff["time"])
    assert np.abs(stiff["roll_moment"] - inertia)[late].max() < 0.02 * np.abs(inertia).max()
    free = driven("gyro_unit:multibody", roll, stop=2.0, gimbal_stiffness=1.0, **MOTOR_OFF)
    assert np.abs(free["roll_moment"]).max() < 0.02 * np.abs(inertia).max()


@pytest.mark.parametrize("unit", ["linear", "nonlinear", "multibody", "twin"])
def test_free_gyro_nutates_and_precesses(unit: str) -> None:
    """Without spring and damper: nutation at H / sqrt(I_y I_z), and under a yaw moment M the gimbal drifts at M / H."""
    plan = framed(f"gyro_unit:{unit}")
    for name in ("gimbal_stiffness", "gimbal_damping"):
        plan = plan.with_value(f"gyro.{name}", 0.0)
    c = catalogue.component(f"gyro_unit:{unit}")
    I_x, I_y, Omega = c.start_parameters[places(c.parameters, "rotor_inertia", "gimbal_inertia", "rotor_speed")]
    H = I_x * Omega
    nutation = H / np.sqrt(I_y * YAW_INERTIA)
    roots = np.linalg.eigvals(Monolith(plan).matrix())
    assert np.abs(roots - 1j * nutation).min() < 1e-9 * nutation

    M = 1e-5  # N m: slow, so that the gimbal stays near 0
    stop = round(10 * 2 * np.pi / nutation, 2)
    run = simulate(plan.with_value("frame.external_moment", M), algorithm=Jacobi(2), step=0.01, stop=stop, in_process=True)
    drift = np.polyfit(run.trajectory.t, run.trajectory["gyro.gimbal_angle"], 1)[0]
    assert drift == pytest.approx(-M / H, rel=0.02)  # the fit's error: part of a nutation in ten


def test_twin_loads_its_frame_with_no_pitch_moment() -> None:
    """In a curve the single gimbal pitches its frame with H psi', the pair does not; in yaw both do the same."""
    curve = {"yaw": sine(0.5, 4.0), "pitch": sine(0.2, 3.0)}
    twin, single = (driven(f"gyro_unit:{v}", curve, stop=3.0) for v in ("twin", "nonlinear"))
    assert np.abs(twin["pitch_moment"]).max() == 0.0
    assert np.abs(single["pitch_moment"]).max() > 1e-4
    yaw = {"yaw": sine(0.5, 4.0)}
    twin, single = (driven(f"gyro_unit:{v}", yaw, stop=3.0) for v in ("twin", "nonlinear"))
    np.testing.assert_allclose(twin["yaw_moment"], single["yaw_moment"], rtol=1e-12, atol=1e-15)


def test_off_and_locked_are_the_ends_of_nonlinear() -> None:
    """`off` is a rotor that stands still; `locked` is a gimbal spring without end, under yaw and slow pitch."""
    rates = {axis: sine(0.3, 2.0 + i) for i, axis in enumerate(AXES)}
    still = driven("gyro_unit:nonlinear", rates, stop=2.0, rotor_speed=0.0)
    off = driven("gyro_unit:off", rates, stop=2.0)
    locked = driven("gyro_unit:locked", rates, stop=2.0)
    stiff = driven("gyro_unit:nonlinear", rates, stop=2.0, gimbal_stiffness=50.0, gimbal_damping=0.05)
    for axis in AXES:
        np.testing.assert_array_equal(off[f"{axis}_moment"], still[f"{axis}_moment"])
    late = stiff["time"] > 0.5
    inertia = 1.3e-4 * 0.3 * 4.0  # I_y theta'', which the locked unit leaves out
    assert np.abs(locked["yaw_moment"] - stiff["yaw_moment"])[late].max() < 0.02 * np.abs(locked["yaw_moment"]).max()
    assert np.abs(locked["pitch_moment"] - stiff["pitch_moment"])[late].max() < 1.1 * inertia


def test_the_motor_keeps_the_speed_within_its_torque() -> None:
    """Steady from the start at any speed set; after a load it comes back; with a weak motor it lags."""
    steady = driven("gyro_unit:multibody", {}, stop=1.0, rotor_speed=150.0)
    np.testing.assert_allclose(steady["spin"], 150.0, rtol=1e-12)
    pulled = driven("gyro_unit:multibody", {}, stop=20.0, rotor_speed=20.0, rotor_speed_deviation=-5.0)
    assert pulled["spin"][0] == 15.0
    assert pulled["spin"][-1] == pytest.approx(20.0, abs=0.01)
    weak = driven("gyro_unit:multibody", {}, stop=1.0, rotor_speed=20.0, rotor_speed_deviation=-5.0, motor_torque_limit=1e-3,
                  bearing_friction=0.0, bearing_viscous_friction=0.0)  # fmt: skip
    assert weak["spin"][-1] - 15.0 == pytest.approx(1e-3 / 3.7e-4, rel=1e-6)  # torque over inertia for 1 s


def test_end_stops_hold_the_gimbal_and_only_take_energy() -> None:
    """Pushed through 2 rad the free unit turns as far, the stopped one a little beyond its stop; both balance their energy."""
    push = {"yaw": sine(3.0, 1.5)}
    free, stopped = (driven("gyro_unit:multibody", push, stop=4.0, stop_angle=1.0, stop_stiffness=k) for k in (0.0, 5.0))
    assert np.abs(free["gimbal_angle"]).max() > 1.2
    assert np.abs(stopped["gimbal_angle"]).max() < 1.05
    t, w = stopped["time"], np.array([push["yaw"](t)[0] for t in stopped["time"]])
    taken = np.trapezoid(-stopped["yaw_moment"] * w + stopped["motor_power"], t)
    kept = stopped["stored_energy"][-1] - stopped["stored_energy"][0] + np.trapezoid(stopped["dissipated_power"], t)
    exchanged = np.trapezoid(np.abs(stopped["yaw_moment"] * w), t)
    assert taken == pytest.approx(kept, abs=2e-3 * exchanged)  # the trapezoidal rule over the impacts


@pytest.mark.parametrize("spec", ["gyro_unit:multibody", "gyro_unit:multibody_full"])
def test_multibody_moments_are_the_change_of_its_momentum(spec: str) -> None:
    """Euler, independent of the model's own terms: L = C W e_x1 + B omega_y e_y, and M = -(dL/dt in the frame + w x L)."""
    unit = catalogue.component(spec)
    rng = np.random.default_rng(3)
    p = unit.start_parameters
    C, B, Omega = p[places(unit.parameters, "rotor_inertia", "gimbal_inertia", "rotor_speed")]
    order = [v.name for v in unit.states]
    x, u = ca.SX.sym("x", len(unit.states)), ca.SX.sym("u", 3)
    eta, omega_y, W = (x[order.index(n)] for n in ("gimbal_angle", "gimbal_pitch_rate", "rotor_speed_deviation"))
    L = ca.vertcat(C * (Omega + W) * ca.cos(eta), B * omega_y, -C * (Omega + W) * ca.sin(eta))
    w = ca.vertcat(*(u[i] for i in places(unit.inputs, "roll_rate", "pitch_rate", "yaw_rate")))
    change = ca.Function("change", [x, u], [ca.jtimes(L, x, unit.rhs(x, u, p)) + ca.cross(w, L)])
    for _ in range(20):
        state, motion = rng.standard_normal(len(order)), rng.standard_normal(3)
        y = np.array(unit.output(state, motion, p)).ravel()[places(unit.outputs, "roll_moment", "pitch_moment", "yaw_moment")]
        expected = -np.array(change(state, motion)).ravel()
        np.testing.assert_allclose(y, expected, atol=1e-12 * np.abs(expected).max())
