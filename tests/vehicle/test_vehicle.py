"""The wheel pair against the paper's equations and numbers."""

import numpy as np
import pytest

from gyro_cosim import system
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.stability import roots
from gyro_cosim.systems import catalogue

RPM = 2 * np.pi / 60
PAIR = system("wheel-pair")


def paper_matrix(v: float, rpm: float) -> np.ndarray:
    """Equations (1)-(3) typed in once more, in the order y, y', psi, psi', eta, eta' (Table 1; I_zw, P, d_g assumed)."""
    m_t, I_yg, k_g, c_g, b, k22, g0, g1 = 2.94, 1.3e-4, 0.0045, 0.00063, 0.049, 171.0, 0.025, 0.8
    P, I, H = 14.42, 0.006 + 1.3e-4, 3.7e-4 * rpm * RPM
    return np.array(
        [
            [0, 1, 0, 0, 0, 0],
            [-2 * P * g1 / m_t, -2 * k22 / (v * m_t), 2 * k22 / m_t, 0, 0, 0],
            [0, 0, 0, 1, 0, 0],
            [0, 0, -2 * P * g0 * b / I, 0, 0, H / I],
            [0, 0, 0, 0, 0, 1],
            [0, 0, 0, -H / I_yg, -k_g / I_yg, -c_g / I_yg],
        ]
    )


@pytest.mark.parametrize(("v", "rpm"), [(10.0, 0.0), (10.0, 100.0), (10.0, 200.0), (1.0, 10.0), (100.0, 1000.0)])
def test_the_joined_components_are_the_papers_equations(v: float, rpm: float) -> None:
    joined = Monolith(PAIR.with_value("vehicle.speed", v).with_value("gyro.rotor_speed", rpm * RPM))
    assert joined.is_linear
    np.testing.assert_allclose(joined.matrix(), paper_matrix(v, rpm), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("rpm", "root"), [(0, 2.40j), (100, -0.100 + 1.91j), (200, -0.087 + 1.33j), (1000, -0.007 + 0.32j)])
def test_slow_yaw_root_at_10_m_per_s(rpm: float, root: complex) -> None:
    found = roots(PAIR, "gyro.rotor_speed", np.array([rpm * RPM]))[0]
    assert np.abs(found - root).min() < 6e-3  # the reference values are given to two or three digits


def test_lateral_roots_at_10_m_per_s_and_their_independence_of_the_gyro() -> None:
    for rpm in (0.0, 500.0):
        found = roots(PAIR, "gyro.rotor_speed", np.array([rpm * RPM]))[0]
        for root in (-10.91, -0.72):
            assert np.abs(found - root).min() < 5e-3


def test_wheel_speed_is_that_of_a_centred_wheel() -> None:
    vehicle = catalogue.component("vehicle:wheel_pair")
    y = np.array(vehicle.output(vehicle.start_state, vehicle.start_input, vehicle.start_parameters)).ravel()
    assert y[[v.name for v in vehicle.outputs].index("wheel_speed")] == pytest.approx(10.0 / 0.036)
