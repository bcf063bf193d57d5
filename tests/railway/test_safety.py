"""Limits and filters of derailment safety, against published values and signals whose answer is known."""

import math

import numpy as np
import pytest

from gyro_cosim.railway import safety
from gyro_cosim.railway.filters import low_pass, sliding_mean

T = np.arange(0.0, 20.0, 1e-3)


def test_nadal_meets_the_published_value() -> None:
    """70 deg and friction 0.3: 1.342 (PHYSICS section 4)."""
    assert safety.nadal_limit(math.radians(70.0), 0.3) == pytest.approx(1.342, abs=5e-4)


def test_nadal_is_the_balance_of_forces_on_a_sliding_flange() -> None:
    """Normal force N at angle d and friction mu N down the flange: Y and Q by components."""
    for angle, mu in [(1.0, 0.2), (1.2, 0.5)]:
        Y = math.sin(angle) - mu * math.cos(angle)
        Q = math.cos(angle) + mu * math.sin(angle)
        assert safety.nadal_limit(angle, mu) == pytest.approx(Y / Q, rel=1e-12)
        assert safety.weinstock_limit(angle, mu) == pytest.approx(Y / Q + mu, rel=1e-12)


def test_frictionless_limit_is_the_tangent() -> None:
    assert safety.nadal_limit(1.1, 0.0) == pytest.approx(math.tan(1.1))


@pytest.mark.parametrize(("frequency", "gain"), [(0.5, 1.0), (20.0, 1 / math.sqrt(2.0)), (40.0, 0.1311)])
def test_low_pass_has_its_gain_and_no_delay(frequency: float, gain: float) -> None:
    """Two passes of order 2 with the corner at 1.2465 * 20 Hz: |H|^2 = 1 / (1 + (f / 24.93)^4), to the filter's warping."""
    exact = 1 / (1 + (frequency / (20.0 * (math.sqrt(2) - 1) ** -0.25)) ** 4)
    assert exact == pytest.approx(gain, rel=2e-2)
    signal = np.sin(2 * np.pi * frequency * T)
    middle = slice(4000, 16000)  # whole periods, away from the ends
    projected = 2 * np.mean(low_pass(signal, T)[middle] * signal[middle])
    assert projected == pytest.approx(exact, rel=2e-2)


def test_sliding_mean_is_the_mean_over_two_metres() -> None:
    s = np.cumsum(np.random.default_rng(1).uniform(0.001, 0.009, 8000))
    y = np.sin(3.0 * s) + 0.5 * s
    inside = (s > s[0] + 1.0) & (s < s[-1] - 1.0)
    exact = np.sin(3.0 * s) * np.sin(3.0) / 3.0 + 0.5 * s
    assert sliding_mean(y, s)[inside] == pytest.approx(exact[inside], abs=1e-4)
    assert sliding_mean(np.full_like(s, 7.0), s) == pytest.approx(7.0)


def test_a_short_blow_is_filtered_and_a_long_push_is_not() -> None:
    s = 8.0 * T
    blow, push = np.where(np.abs(T - 5) < 0.002, 5.0, 0.1), np.where((T > 5) & (T < 6), 1.1, 0.1)
    found = safety.worst({"left": blow, "right": push}, T, s)
    assert found.wheel == "right"
    assert found.exceeded
    assert found.value == pytest.approx(1.1, rel=0.01)
    assert 40.0 < found.distance < 48.0
    assert not safety.worst({"left": blow}, T, s).exceeded


def test_sum_of_guiding_forces_has_prudhommes_limit() -> None:
    limit = safety.guiding_force_limit(34335.0)
    assert limit == pytest.approx(10e3 + 34335.0 / 3)
    force = np.where(T > 10, -22e3, 0.0)
    found = safety.worst({"front": force}, T, 5.0 * T, limit)
    assert found.exceeded
    assert found.value == pytest.approx(22e3, rel=0.05)


def test_verdict_names_the_first_wheel_that_left() -> None:
    s = 8.0 * T
    climbs = {"front_left": np.where(T > 7.0, 1.2, 0.3), "rear_left": np.where(T > 6.9995, 1.2, 0.3), "rear_right": 0.1 * T / 20}
    found = safety.verdict(climbs, T, s)
    assert found == safety.Verdict(True, "rear_left", T[7000], s[7000])
    assert found.text == "derailed: rear_left at s = 56.00 m, t = 7.000 s"
    assert safety.verdict({"rear_right": climbs["rear_right"]}, T, s) == safety.Verdict(False)
    assert safety.verdict({"w": np.where(T > 3, np.nan, 0.0)}, T, s).derailed


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: safety.nadal_limit(2.0, 0.3), "contact_angle must lie between 0 and pi/2, got 2"),
        (lambda: safety.nadal_limit(1.2, 1.3), "friction must lie in 0..1, got 1.3"),
        (lambda: safety.guiding_force_limit(0.0), "axle_load must be positive, got 0"),
        (lambda: low_pass(T[:-1], T), "signal and t must be columns of equal length"),
        (lambda: low_pass(T, T**2), "t must be evenly spaced"),
        (lambda: low_pass(T[::50], T[::50]), "the sampling rate must exceed 49.9 Hz to cut off at 20 Hz, got 20"),
        (lambda: sliding_mean(T, -T), "distance must grow"),
        (lambda: safety.worst({}, T, T), "at least one wheel"),
    ],
)
def test_wrong_use_is_refused_in_one_line(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        call()  # type: ignore[operator]
    assert "\n" not in str(error.value)
