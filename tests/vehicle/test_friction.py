"""Friction of each rail, along the track, and falling with slip: the formula, and what it does to wheels."""

from math import exp

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.component import Component
from gyro_cosim.vehicle.friction import FRICTION, under
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.variants import lrt_set_b
from gyro_cosim.vehicle.wheelset import sprung_wheelset

STRETCH = {"friction_stretch_start": 20.0, "friction_stretch_length": 10.0, "friction_stretch_ramp": 2.0}
FALLING = {"friction_end_ratio": 0.4, "friction_decay": 0.6}


def mu(side: str, place: float, slip: float, **values: float) -> float:
    s = {row.name: ca.SX(values.get(row.name, row.start)) for row in FRICTION} | {"friction": ca.SX(0.369)}
    return float(under(s, side, ca.SX(place))(ca.SX(slip)))


def torque(at: float = 0.0, spin: float = 40.0, **values: float) -> float:
    """Moment on the axle of a wheelset whose wheels spin (rad/s beyond rolling) where the track is `at` metres old, N m."""
    component: Component = sprung_wheelset(values)
    state = np.zeros(len(component.states))
    names = [v.name for v in component.states]
    state[names.index("distance")], state[names.index("spin_deviation")] = at, spin
    p = {v.name: v.start for v in component.parameters}
    rate = np.array(component.rhs(state, np.zeros(len(component.inputs)), np.array(list(p.values())))).ravel()
    return float(rate[names.index("spin_deviation")] * 2 * p["wheel_spin_inertia"])


def test_the_defaults_leave_friction_alone() -> None:
    """To the last bit, wherever and however fast."""
    for place, slip in ((-3.0, 0.0), (5.0, 0.01), (7.3, 4.0), (1e4, 1e3)):
        assert mu("left", place, slip) == mu("right", place, slip) == 0.369


def test_each_rail_has_its_own() -> None:
    assert mu("left", 0.0, 0.0, friction_left=0.5) == pytest.approx(0.1845)
    assert mu("right", 0.0, 0.0, friction_left=0.5) == 0.369


@pytest.mark.parametrize(
    ("place", "share"), [(19.9, 0.0), (20.0, 0.0), (21.0, 0.5), (22.0, 1.0), (25.0, 1.0), (29.5, 0.25), (30.0, 0.0), (99.0, 0.0)]
)
def test_a_stretch_has_ramps_within_it(place: float, share: float) -> None:
    found = mu("left", place, 0.0, friction_stretch_left=0.2, **STRETCH)
    assert found == pytest.approx(0.369 * (1 - 0.8 * share), rel=1e-12)
    assert mu("right", place, 0.0, friction_stretch_left=0.2, **STRETCH) == 0.369


def test_without_a_ramp_friction_jumps() -> None:
    jump = STRETCH | {"friction_stretch_ramp": 0.0, "friction_stretch_right": 2.0}
    assert mu("right", 19.999, 0.0, **jump) == 0.369
    assert mu("right", 20.002, 0.0, **jump) == pytest.approx(0.738)


def test_friction_falls_as_polach_has_it() -> None:
    for slip in (0.0, 0.5, 3.0):
        assert mu("left", 0.0, slip, **FALLING) == pytest.approx(0.369 * (0.6 * exp(-0.6 * slip) + 0.4))
    assert mu("left", 0.0, 1e3, **FALLING) == pytest.approx(0.369 * 0.4)


def test_a_spinning_wheelset_feels_its_rails() -> None:
    """Both wheels slide at 12 m/s: their moment is proportional to the sum of both coefficients. The creep law leaves half a per
    cent (Polach's approaches the limit)."""
    whole = torque()
    assert torque(friction_left=0.5) == pytest.approx(0.75 * whole, rel=0.01)
    assert torque(friction_left=0.5, friction_right=0.5) == pytest.approx(0.5 * whole, rel=0.01)
    wet = STRETCH | {"friction_stretch_left": 0.2, "friction_stretch_right": 0.2}
    assert torque(25.0, **wet) == pytest.approx(0.2 * whole, rel=0.01)
    assert torque(15.0, **wet) == whole


def test_traction_has_its_maximum_and_falls_behind_it() -> None:
    """With friction that falls, more slip gives less force: at 40 rad/s (12 m/s) A of it is left, and a shade more."""
    spins = np.array([0.05, 0.5, 2.0, 5.0, 10.0, 40.0])
    moments = np.array([-torque(spin=spin, **FALLING) for spin in spins])
    even = np.array([-torque(spin=spin) for spin in spins])
    top = int(np.argmax(moments))
    assert 0 < top < len(spins) - 1
    assert np.all(np.diff(even) > 0)
    assert moments[-1] / even[-1] == pytest.approx(0.4 + 0.6 * exp(-0.6 * 12.0), rel=0.01)


@pytest.mark.parametrize("vehicle", [lrt_set_a, lrt_set_b])
def test_rest_is_rest_with_falling_friction(vehicle) -> None:
    """Set B rests with a spin creepage of 1.4 1/m: its slip and its friction belong to the rest state."""
    component = vehicle()
    p = np.array([FALLING.get(v.name, v.start) for v in component.parameters])
    rates = np.array(component.rhs(np.zeros(len(component.states)), np.zeros(len(component.inputs)), p)).ravel()
    moving = [not v.name.endswith("distance") for v in component.states]
    assert np.abs(rates[moving]).max() < 1e-8


def test_a_factor_out_of_range_is_refused() -> None:
    with pytest.raises(ValueError, match=r"friction_end_ratio must be at most 1, got 1[.]2"):
        sprung_wheelset({"friction_end_ratio": 1.2})
    with pytest.raises(ValueError, match="friction_left must be at least 0, got -1"):
        sprung_wheelset({"friction_left": -1.0})
