"""The necessary condition for a gyro to stabilise free wheels: against a second derivation, its own algebra, the full vehicle."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gyro_cosim import system
from gyro_cosim.railway.yaw_stability import (
    Gimbal,
    WheelPair,
    characteristic_polynomial,
    growth_bound,
    margin,
    needed_ratio,
    wheel_pair,
)
from gyro_cosim.stability import AtRest
from gyro_cosim.vehicle.reduction import reduced_values

RPM = np.pi / 30
PAPER = 21000.0 / 86700.0  # s, Table 2's c_z / k_z


def random_pair(rng: np.random.Generator) -> WheelPair:
    """Stable and unstable ones: sizes of the vehicle's, each over more than a decade, creep of either sign."""
    return WheelPair(
        inertia=rng.uniform(200.0, 3000.0), relaxation=10.0 ** rng.uniform(-2.0, 1.0), damping=rng.uniform(0.0, 500.0),
        stiffness=rng.uniform(100.0, 2e4), spin_up=10.0 ** rng.uniform(1.0, 6.0), creep=rng.uniform(-3e4, 3e4),
    )  # fmt: skip


def random_gimbal(rng: np.random.Generator) -> Gimbal:
    return Gimbal(
        momentum=10.0 ** rng.uniform(2.0, 5.0), inertia=rng.uniform(5.0, 50.0),
        damping=10.0 ** rng.uniform(0.0, 5.0), stiffness=10.0 ** rng.uniform(0.0, 5.0),
    )  # fmt: skip


def state_space(pair: WheelPair, gimbal: Gimbal) -> np.ndarray:
    """Equations (1) to (3) one by one; states y / v, psi, psi', eta, eta'."""
    A = np.zeros((5, 5))
    A[0, :2] = -pair.relaxation, 1.0
    A[1, 2] = A[3, 4] = 1.0
    A[2, :3] = np.array([pair.creep, -pair.stiffness, -pair.damping]) / pair.inertia
    A[2] += pair.spin_up * A[0] / pair.inertia  # a y' / v
    A[2, 4] = gimbal.momentum / pair.inertia
    A[4, 2:] = np.array([-gimbal.momentum, -gimbal.stiffness, -gimbal.damping]) / gimbal.inertia
    return A


@pytest.mark.parametrize("spring", [True, False])
def test_roots_are_the_eigenvalues_of_the_equations(spring: bool) -> None:
    """As monic polynomials, whose coefficients rounding leaves alone: 1e-9 of each one's size."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        pair, gimbal = random_pair(rng), random_gimbal(rng)
        gimbal = gimbal if spring else replace(gimbal, stiffness=0.0)
        A, p = state_space(pair, gimbal), characteristic_polynomial(pair, gimbal)
        for s in rng.normal(0.0, 5.0, (6, 2)) @ np.array([1.0, 1j]):  # six points determine a polynomial of degree five
            value = p[0] * np.linalg.det(s * np.eye(5) - A)
            assert np.polyval(p, s) == pytest.approx(value, rel=1e-9, abs=1e-9 * np.polyval(np.abs(p), abs(s)))
    assert (p[-1] == 0.0) != spring


def test_last_two_coefficients_are_the_condition() -> None:
    rng = np.random.default_rng(2)
    for _ in range(1000):
        pair, gimbal = random_pair(rng), random_gimbal(rng)
        p, k = characteristic_polynomial(pair, gimbal), gimbal.stiffness
        K, D, L, a = pair.stiffness, pair.damping, pair.relaxation, pair.spin_up
        ratio, constant = gimbal.damping / k, K * L - pair.creep
        size = k * (abs(K) + D * L + abs(a) + ratio * (abs(K * L) + abs(pair.creep)))
        assert p[-2] == pytest.approx(k * (K + D * L + ratio * constant - a), abs=1e-12 * size)
        assert p[-2] == pytest.approx(k * margin(pair, ratio), abs=1e-12 * size)
        assert p[-1] == pytest.approx(k * constant, abs=1e-12 * size)


def test_spin_number_of_springs_and_lever_arm_do_not_enter() -> None:
    """At a fixed ratio of Table 2's damper and spring p'(0) per stiffness is the same for every gyro; p itself is not."""
    rng = np.random.default_rng(3)
    pair = random_pair(rng)
    expected, others = margin(pair, PAPER), set()
    for _ in range(500):
        n, arm, rpm = rng.uniform(0.5, 8.0), rng.uniform(0.05, 1.0), rng.uniform(0.0, 2e4)
        gimbal = Gimbal(22.04 * rpm * RPM, rng.uniform(5.0, 50.0), n * 21000.0 * arm**2, n * 86700.0 * arm**2)
        p = characteristic_polynomial(pair, gimbal)
        assert p[-2] / gimbal.stiffness == pytest.approx(expected, rel=1e-9)
        others.add(p[-3] / gimbal.stiffness)
    assert max(others) > 10 * min(others)


def test_growth_is_never_below_its_bound_and_the_bound_is_positive_where_the_condition_is_broken() -> None:
    """The polynomial's own roots have errors where they nearly coincide: 1e-6 of the largest."""
    rng = np.random.default_rng(4)
    broken = stable = 0
    for _ in range(5000):
        pair, gimbal = random_pair(rng), random_gimbal(rng)
        gimbal = replace(gimbal, stiffness=0.0) if rng.random() < 0.2 else gimbal
        roots, bound = np.linalg.eigvals(state_space(pair, gimbal)), growth_bound(pair, gimbal)
        growth, ratio = roots.real.max(), gimbal.damping / gimbal.stiffness if gimbal.stiffness else np.inf
        assert growth > bound - 1e-6 * np.abs(roots).max()
        if margin(pair, ratio) < 0.0:
            broken += 1
            assert bound > 0.0
        stable += growth < 0.0
    assert broken > 1000  # both kinds were among them
    assert stable > 100


def test_broken_condition_grows_at_any_spin() -> None:
    """The pair of Table 2's wheels at 8 m/s on a steep tread, at the paper's ratio: up to 20 000 rpm, 1 to 400 springs."""
    pair = wheel_pair(**reduced_values({"speed": 8.0, "conicity": 0.3714, "conicity_gradient": 19.99}))
    assert margin(pair, PAPER) < 0.0
    for rpm in (0.0, 500.0, 2000.0, 20000.0):
        for n in (1.0, 4.0, 40.0, 400.0):
            gimbal = Gimbal(22.04 * rpm * RPM, 26.45, n * 21000.0 * 0.09, n * 86700.0 * 0.09)
            assert 0.0 < growth_bound(pair, gimbal) <= np.linalg.eigvals(state_space(pair, gimbal)).real.max()


def test_needed_ratio_is_where_the_margin_changes_sign() -> None:
    rng = np.random.default_rng(5)
    kinds = set()
    for _ in range(500):
        pair = random_pair(rng)
        needed = needed_ratio(pair)
        if needed == np.inf:  # no ratio: the margin falls with it, or a root stands at the right without oscillating
            assert pair.stiffness * pair.relaxation <= pair.creep
            assert margin(pair, 1e9) < 0.0 or margin(pair, np.inf) == -np.inf
        elif needed == 0.0:
            assert margin(pair, 0.0) >= 0.0
        else:
            assert margin(pair, needed * 1.001) > 0.0 > margin(pair, needed * 0.999)
        kinds.add(0 if needed == 0.0 else np.inf if needed == np.inf else 1)
    assert kinds == {0, 1, np.inf}


def test_a_fast_rotor_requires_more_by_one_over_the_relaxation() -> None:
    """Equation (9): the slow pair of roots at H = 1e8 N m s, and its change of sign at the needed ratio + 1 / L."""
    pair = WheelPair(inertia=1500.0, relaxation=0.6, damping=1.0, stiffness=1e4, spin_up=4e4, creep=-1e4)
    limit = needed_ratio(pair) + 1.0 / pair.relaxation
    for factor in (0.5, 0.98, 1.02, 2.0):
        gimbal = Gimbal(1e8, 26.45, factor * limit * 1e4, 1e4)
        p = characteristic_polynomial(pair, gimbal)
        H2L = gimbal.momentum**2 * pair.relaxation
        slow = min(np.roots(p), key=abs)
        assert slow.real == pytest.approx(-(p[-2] - p[-1] / pair.relaxation) / (2 * H2L), rel=1e-3)
        assert abs(slow.imag) == pytest.approx(np.sqrt(p[-1] / H2L), rel=1e-3)
        assert (slow.real < 0.0) == (factor > 1.0)


def test_the_ratio_grows_with_the_speed_in_proportion() -> None:
    pairs = [wheel_pair(**reduced_values({"speed": v, "conicity": 0.4, "conicity_gradient": 20.0})) for v in (400.0, 800.0)]
    fast = [needed_ratio(pair) for pair in pairs]
    assert fast[1] / fast[0] == pytest.approx(2.0, rel=1e-3)


FULL = ("speed", "conicity", "conicity_gradient", "wheel_spin_inertia")


@pytest.fixture(scope="module")
def full() -> AtRest:
    """The vehicle with its two gyro units on straight track."""
    gyro = ("gyro.rotor_speed", "gyro.gimbal_damping", "gyro.gimbal_stiffness")
    plan = system("lrt-straight").with_value("vehicle.stretch_lateral", 0.0)
    return AtRest(plan, (*(f"vehicle.{name}" for name in FULL), *gyro), ignorable=("vehicle.*_distance",))


def least_growth(full: AtRest, case: tuple[float, ...], ratio: float) -> float:
    """Of the full vehicle at a ratio of damper and spring: over 1000 to 16 000 rpm and dampers of 0.3 to 3000 kN s/m."""
    designs = [(rpm * RPM, c) for rpm in (1e3, 2e3, 4e3, 8e3, 16e3) for c in np.geomspace(300.0, 3e6, 21)]
    return min(full.growth((*case, spin, c, c / ratio)) for spin, c in designs)


@pytest.mark.parametrize("case", [
    (12.0, 0.3, 20.0, 21.25), (12.0, 0.5, 20.0, 21.25), (20.0, 0.2, 20.0, 21.25), (20.0, 0.3, 15.0, 21.25),
    (20.0, 0.5, 20.0, 21.25), (50.0, 0.3, 20.0, 21.25), (50.0, 0.4, 15.0, 21.25), (20.0, 0.3, 20.0, 10.0),
    (30.0, 0.4, 20.0, 10.0), (50.0, 0.4, 20.0, 5.0),
])  # fmt: skip
def test_full_vehicle_needs_the_ratio_within_a_factor_of_two(full: AtRest, case: tuple[float, ...]) -> None:
    """No design is stable at half the law's ratio, some design is at twice."""
    needed = needed_ratio(wheel_pair(**reduced_values(dict(zip(FULL, case, strict=True)))))
    assert 0.0 < needed < np.inf
    assert least_growth(full, case, needed / 2) > 0.0 > least_growth(full, case, needed * 2)


def test_full_vehicle_of_set_a_is_stable_at_no_ratio_tried(full: AtRest) -> None:
    """Its tread is so flat that the spin creep turns the pair: K L < c v, no gimbal helps the pair. Of the vehicle: a search."""
    values = reduced_values({})
    case = (values["speed"], values["conicity"], values["conicity_gradient"], values["spin_inertia"])
    assert needed_ratio(wheel_pair(**values)) == np.inf
    for ratio in (PAPER, 1.0, 10.0, 100.0, 1e4):
        assert least_growth(full, case, ratio) > 0.0


@pytest.mark.parametrize(("make", "message"), [
    (lambda: Gimbal(1.0, 1.0, 0.0, 0.0), "must not both be 0"),
    (lambda: Gimbal(1.0, 0.0, 1.0, 0.0), "inertia must be above 0, got 0"),
    (lambda: Gimbal(1.0, 1.0, -1.0, 1.0), "damping must be at least 0, got -1"),
    (lambda: Gimbal(np.nan, 1.0, 1.0, 1.0), "momentum must be finite, got nan"),
    (lambda: WheelPair(0.0, 1.0, 1.0, 1.0, 1.0, 1.0), "inertia must be above 0, got 0"),
    (lambda: WheelPair(1.0, np.inf, 1.0, 1.0, 1.0, 1.0), "relaxation must be finite, got inf"),
    (lambda: margin(WheelPair(1.0, 1.0, 1.0, 1.0, 1.0, 1.0), -1.0), "ratio must be at least 0, got -1"),
    (lambda: margin(WheelPair(1.0, 1.0, 1.0, 1.0, 1.0, 1.0), np.nan), "ratio must be at least 0, got nan"),
    (lambda: wheel_pair(**reduced_values({}) | {"speed": 0.0}), "speed must be above 0, got 0"),
    (lambda: reduced_values({}, "fastsim"), "law must be smooth"),
    (lambda: reduced_values({}, "coulomb"), "law must be one of"),
])  # fmt: skip
def test_refusals(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
