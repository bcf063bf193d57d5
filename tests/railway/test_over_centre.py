"""What units cannot do, and what a spring over centre can: against roots, for random pairs and for set A and its vehicle."""

from dataclasses import replace

import numpy as np
import pytest
from test_yaw_stability import random_gimbal, random_pair

from gyro_cosim import system
from gyro_cosim.railway.over_centre import centring_time, closed_loop, largest_ratio, stable_units_fail
from gyro_cosim.railway.yaw_stability import WheelPair, characteristic_polynomial, wheel_pair
from gyro_cosim.stability import AtRest
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.reduction import reduced_values

RPM = np.pi / 30


def set_a(v: float) -> WheelPair:
    return wheel_pair(**reduced_values(parameter_set("A").vehicle) | {"speed": v})


def test_closed_loop_with_the_plain_gimbal_is_that_of_the_law() -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        pair, g = random_pair(rng), random_gimbal(rng)
        p = closed_loop(pair, [g.momentum**2, 0.0], [g.inertia, g.damping, g.stiffness])
        np.testing.assert_allclose(p, characteristic_polynomial(pair, g), rtol=1e-12)


@pytest.mark.slow
def test_no_stable_unit_stabilises_a_pair_that_spin_creep_turns_aside() -> None:
    """Random units of up to four states, active ones too; and with an unstable unit it can be done, or the test shows nothing."""
    rng = np.random.default_rng(2)
    pair, tried, fallen = set_a(50.0), 0, 0
    assert stable_units_fail(pair)
    for _ in range(20000):
        n = int(rng.integers(1, 5))
        roots = -np.abs(rng.normal(0.0, 10.0, n))
        Q, N = np.poly(roots), rng.normal(0.0, 1.0, n + 1) * 10.0 ** rng.uniform(2.0, 9.0)
        assert np.roots(closed_loop(pair, N, Q)).real.max() > 0.0
        tried += 1
        over = np.array([26.45, 10.0 ** rng.uniform(0.0, 2.0), -(10.0 ** rng.uniform(1.0, 3.0))])
        H = 22.04 * 4000 * RPM
        fallen += np.roots(closed_loop(pair, [H**2, 0.0], over)).real.max() < 0.0
    assert tried == 20000
    assert fallen > 1000


@pytest.mark.parametrize("v", [30.0, 50.0, 80.0])
def test_a_spring_over_centre_must_have_a_small_damper(v: float) -> None:
    """Beyond (13) none of any spin is stable; a fast rotor is stable just inside (14), and not just outside."""
    pair = set_a(v)
    necessary, fast = largest_ratio(pair), largest_ratio(pair, fast=True)
    assert 0.0 < fast < necessary

    def growth(momentum: float, ratio: float, k: float = 100.0) -> float:
        return np.roots(closed_loop(pair, [momentum**2, 0.0], [26.45, ratio * k, -k])).real.max()

    for H in np.geomspace(100.0, 1e6, 30):
        assert growth(H, 1.001 * necessary) > 0.0
    assert growth(1e6, 0.95 * fast) < 0.0 < growth(1e6, 1.05 * fast)


def test_below_a_speed_no_fast_rotor_over_centre_does_it_and_the_vehicle_agrees() -> None:
    """The pair's speed is where (14) begins to be positive, 26.6 m/s; of the whole vehicle between 24 and 28."""
    speeds = np.linspace(10.0, 40.0, 601)
    first = speeds[np.flatnonzero([largest_ratio(set_a(v), fast=True) > 0.0 for v in speeds])[0]]
    assert first == pytest.approx(26.6, abs=0.5)
    free = ("vehicle.speed", "gyro.rotor_speed", "gyro.gimbal_damping", "gyro.gimbal_stiffness")
    rest = AtRest(system("lrt-straight").with_value("vehicle.stretch_lateral", 0.0), free, ignorable=("vehicle.*_distance",))
    designs = [(rpm * RPM, 3.0, -k) for rpm in (1000.0, 4000.0, 8000.0) for k in np.geomspace(100.0, 1e5, 16)]
    least = {v: min(rest.growth((v, *design)) for design in designs) for v in (20.0, 24.0, 28.0, 50.0)}
    assert least[20.0] > 0.0
    assert least[24.0] > 0.0
    assert least[28.0] < 0.0
    assert least[50.0] < -0.1


def test_no_spring_over_centre_where_the_pair_returns_by_itself() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        pair = random_pair(rng)
        if not stable_units_fail(pair):
            assert largest_ratio(pair) == 0.0
            over = [20.0, 10.0, -100.0]
            assert np.roots(closed_loop(pair, [1e8, 0.0], over)).real.max() > 0.0


def test_a_slow_loop_must_be_slower_than_the_ratio_that_the_law_asks_for() -> None:
    """(15): a loop that is quicker is unstable at any spin; a slow one leaves a stable pair stable."""
    rng = np.random.default_rng(4)
    broken = kept = 0
    for _ in range(2000):
        pair, g = random_pair(rng), random_gimbal(rng)
        time = centring_time(pair)
        if not 0.0 < time < 1e6:
            continue
        for factor in (0.5, 1e4):
            k_i = g.stiffness / (factor * time)
            loop = closed_loop(pair, [g.momentum**2, 0.0, 0.0], [g.inertia, g.damping, g.stiffness, k_i])
            growth = np.roots(loop).real.max()
            if factor < 1.0:
                assert growth > 0.0
                broken += 1
            elif np.roots(characteristic_polynomial(pair, g)).real.max() < -1e-2:
                kept += growth < 0.0
    assert broken > 300
    assert kept > 5


def test_what_cannot_be_a_unit_is_refused() -> None:
    with pytest.raises(ValueError, match="degree must be at most"):
        closed_loop(set_a(8.0), [1.0, 0.0, 0.0], [1.0, 1.0])
    assert largest_ratio(replace(set_a(50.0), relaxation=-1.0), fast=True) == 0.0
