"""Gyro units: every variant passive, the known limits met, the connector the same."""

import numpy as np
import pytest

from cosim import catalogue
from gyro_unit import VARIANTS
from gyro_unit.mount import BONDS, CONNECTOR

SPECS = [f"gyro_unit:{variant}" for variant in VARIANTS]


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


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize("spin", [-300.0, 0.0, 10.0, 300.0])
def test_energy_taken_from_the_frame_is_stored_or_dissipated(spec: str, spin: float) -> None:
    """Passivity as an identity: E' = -(sum of moment times rate) - dissipated power, dissipated power >= 0, at any state."""
    unit = catalogue.component(spec)
    rng = np.random.default_rng(7)
    p = unit.start_parameters
    p[places(unit.parameters, "rotor_speed")] = spin
    rates = places(unit.inputs, "yaw_rate", "roll_rate", "pitch_rate")
    moments = places(unit.outputs, "yaw_moment", "roll_moment", "pitch_moment")
    (stored,), (lost,) = places(unit.outputs, "stored_energy"), places(unit.outputs, "dissipated_power")

    def energy(x: np.ndarray, u: np.ndarray) -> float:
        return float(unit.output(x, u, p)[stored])

    for _ in range(20):
        x, u = rng.standard_normal(len(unit.states)), rng.standard_normal(len(unit.inputs))
        y, rate = np.array(unit.output(x, u, p)).ravel(), np.array(unit.rhs(x, u, p)).ravel()
        h = 1e-4 / np.abs(rate).max()  # E is quadratic in x, so the central difference is exact but for rounding
        growth = (energy(x + h * rate, u) - energy(x - h * rate, u)) / (2 * h)
        power_in = -float(y[moments] @ u[rates])
        assert growth == pytest.approx(power_in - y[lost], rel=1e-7, abs=1e-9)
        assert y[lost] >= 0.0


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
