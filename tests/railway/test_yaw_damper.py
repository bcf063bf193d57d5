"""A yaw damper and an inerter in place of the gyro: what free wheels make of them, by the reduced pair and the full vehicle."""

from typing import Any

import numpy as np
import pytest

from gyro_cosim import System, SystemComponent
from gyro_cosim.railway.yaw_damper import is_stable, needed_damping, with_device
from gyro_cosim.railway.yaw_stability import WheelPair, wheel_pair
from gyro_cosim.stability import AtRest
from gyro_cosim.vehicle.reduction import reduced_values

BARE = {f"{gimbal}_gimbal_{what}": 0.0 for gimbal in ("inner", "outer") for what in ("mass", "ixx", "izz")}
STEEP = {
    "conicity": 0.3714,
    "conicity_gradient": 19.99,
    "rolling_radius": 0.3167,
    "contact_half_distance": 0.7572,
    "friction": 0.3,
}


def random_pair(rng: np.random.Generator) -> WheelPair:
    inertia, relaxation, damping = np.exp(rng.normal(np.log([1500.0, 0.5, 500.0]), 1.0))
    stiffness, spin_up = rng.normal(1e4, 1e4), np.exp(rng.normal(np.log(1e4), 1.0))
    return WheelPair(inertia, relaxation, damping, stiffness, spin_up, rng.normal(0.0, 3e3))


def growth(pair: WheelPair) -> float:
    return float(np.roots(pair.cubic).real.max())


def test_stable_is_where_all_roots_decay() -> None:
    rng = np.random.default_rng(1)
    found = [(is_stable(pair), growth(pair) < 0.0) for pair in (random_pair(rng) for _ in range(3000))]
    assert all(said == seen for said, seen in found)
    assert 200 < sum(said for said, _ in found) < 2800


def test_needed_damping_is_where_the_growth_changes_sign() -> None:
    rng = np.random.default_rng(2)
    kinds = set()
    for _ in range(1000):
        pair = random_pair(rng)
        needed = needed_damping(pair)
        if needed == np.inf:
            assert all(growth(with_device(pair, c)) >= 0.0 for c in np.geomspace(1.0, 1e8, 17))
        elif needed == 0.0:
            assert growth(pair) <= 1e-9
        else:
            assert growth(with_device(pair, 0.999 * needed)) > 0.0 > growth(with_device(pair, 1.001 * needed))
        kinds.add(0 if needed == 0.0 else np.inf if needed == np.inf else 1)
    assert kinds == {0, 1, np.inf}


def test_an_inerter_stabilises_no_pair_and_slows_the_growth_of_those_that_diverge() -> None:
    rng = np.random.default_rng(3)
    tried = 0
    for _ in range(2000):
        pair, inertance = random_pair(rng), float(np.exp(rng.normal(np.log(1e3), 2.0)))
        heavier = with_device(pair, inertance=inertance)
        if growth(pair) >= 0.0:
            assert not is_stable(heavier)
            tried += 1
            if pair.cubic[3] <= 0.0:  # one real root grows, and a heavier pair takes longer
                assert growth(heavier) <= growth(pair) * (1 + 1e-9)
    assert tried > 500


def bare(source: str, values: dict[str, float]) -> AtRest:
    """A vehicle without gyro units and their masses, on straight track."""
    plan = System("alone", (SystemComponent("vehicle", source),), ())
    for name, value in (BARE | values).items():
        plan = plan.with_value(f"vehicle.{name}", value)
    return AtRest(plan, ("vehicle.speed", "vehicle.pivot_damping", "vehicle.pivot_inertance"), ignorable=("vehicle.*_distance",))


@pytest.fixture(scope="module")
def steep() -> AtRest:
    return bare("vehicle:lrt", STEEP)


@pytest.mark.parametrize("speed", [4.0, 5.0, 6.0, 8.0, 10.0, 12.0])
def test_full_vehicle_needs_the_damper_within_a_factor_of_two(steep: AtRest, speed: float) -> None:
    """Table 2's wheels on a steep tread: unstable at half the pair's damper, stable at twice."""
    values = reduced_values({**BARE, **STEEP, "speed": speed})
    needed = needed_damping(wheel_pair(**values))
    assert 0.0 < needed < np.inf
    assert steep.growth((speed, needed / 2, 0.0)) > 0.0 > steep.growth((speed, needed * 2, 0.0))


def test_full_vehicle_is_stable_with_no_inerter(steep: AtRest) -> None:
    free = bare("vehicle:lrt_set_b", {})
    for speed in (2.0, 8.0, 50.0):
        for inertance in (0.0, 1e2, 1e3, 1e4, 1e5, 1e6):
            assert steep.growth((speed, 0.0, inertance)) > 0.0
            assert free.growth((speed, 0.0, inertance)) > 0.0


def test_set_a_is_stable_with_no_damper(steep: AtRest) -> None:
    """Its spin creep turns the pair aside: p0 < 0. The full vehicle's growth falls with the damper and stays above 0."""
    flat = bare("vehicle:lrt", {})
    assert needed_damping(wheel_pair(**reduced_values({**BARE, "speed": 8.0}))) == np.inf
    rates = [flat.growth((8.0, c, 0.0)) for c in (0.0, 1e3, 1e4, 1e5, 1e6, 1e7)]
    assert rates == sorted(rates, reverse=True)
    assert rates[-1] > 0.0


@pytest.mark.parametrize(("make", "message"), [
    (lambda pair: with_device(pair, -1.0), "damping must be at least 0, got -1"),
    (lambda pair: with_device(pair, inertance=np.nan), "inertance must be at least 0, got nan"),
])  # fmt: skip
def test_refusals(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make(random_pair(np.random.default_rng(0)))
