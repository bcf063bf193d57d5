"""The vehicle over time: convergence with the internal step, gradient, rough track, and the joined reference."""

import numpy as np
import pytest
from joined import Joined

from gyro_cosim.component.do_step import macro_step
from gyro_cosim.gyro_unit.nonlinear import nonlinear_full
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.spectra import random_track
from gyro_cosim.vehicle.track import Straight, Track
from gyro_cosim.vehicle.variants import lrt_rough


@pytest.fixture(scope="module")
def plain() -> Joined:
    return Joined(lrt_set_a(), {"front": nonlinear_full(), "rear": nonlinear_full()}, cut=False)


def test_internal_step_has_order_four_while_the_contacts_last(plain: Joined) -> None:
    """From a small yaw on straight track, treads in contact, no flange: 16 times less error per halving."""
    p, x = plain.p({"speed": 20.0}), plain.x({"front_yaw_angle": 1e-3})
    ends = [plain.run(0.4, p, x, h=h, every=round(0.2 / h)).end for h in (0.5e-3, 0.25e-3, 0.125e-3, 0.03125e-3)]
    errors = [np.abs(end - ends[-1])[: len(plain.state_names)].max() for end in ends[:-1]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(4.0, abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A", "B"])
def test_default_internal_step_is_converged_in_the_curve(plain: Joined, name: str) -> None:
    """Into the flange at 8 m/s: 0.5 ms is within 1 um of a step eight times shorter; benchmarks/vehicle_step.py has more."""
    chosen = parameter_set(name)
    values = chosen.vehicle | {f"unit.{n}": v for n, v in chosen.gyro.items()}
    p = plain.p(values | {"speed": 8.0, "curve_turn": 1.0, "curve_start": 2.0, "transition_length": 5.0})
    coarse, fine = (plain.run(3.0, p, h=h, every=round(0.02 / h)) for h in (0.5e-3, 0.5e-3 / 8))
    assert fine["front_left_flange_force"].max() > 1e3
    assert np.abs(coarse["front_lateral_displacement"] - fine["front_lateral_displacement"]).max() < 1e-6


def test_joined_system_steps_as_the_component_does() -> None:
    """Without units it is the component itself, cut steps included."""
    vehicle = lrt_set_a({"speed": 2.0})
    joined = Joined(vehicle)
    x = joined.x({"front_yaw_angle": 1e-3})
    end = joined.run(0.05, joined.p({}), x, every=100).end
    U, step = np.zeros((len(vehicle.inputs), 3)), vehicle.internal_step
    other, _ = macro_step(vehicle, x, U, vehicle.start_parameters, 0.0, 0.05, internal_step=step)
    assert end == pytest.approx(other, rel=1e-12, abs=1e-15)


def test_joined_system_refuses_what_is_not_there() -> None:
    vehicle = lrt_set_a()
    with pytest.raises(ValueError, match="component 'vehicle:lrt' has no connector 'middle'"):
        Joined(vehicle, {"middle": nonlinear_full()})
    with pytest.raises(ValueError, match="the joined system has no 'sped'"):
        Joined(vehicle).p({"sped": 1.0})


def test_vehicle_rolls_down_a_gradient_as_its_masses_say() -> None:
    """Free on a 2 % fall: m g sin / (m + 4 I_y / r^2), spin inertia included; 1 % for the creep's share and the entry."""
    joined = Joined(lrt_set_a({"drive_on": 0.0, "speed": 10.0}))
    p = joined.p(Track((Straight(1),), gradient=((5.0, 0.0), (15.0, -0.02))).parameters())
    run = joined.run(5.0, p, every=200)
    late = run.t > 3.0
    acceleration = np.polyfit(run.t[late], run["body_speed_deviation"][late], 1)[0]
    expected = 7000 * 9.81 * np.sin(np.arctan(0.02)) / (7000 + 4 * 21.25 / 0.328**2)
    assert acceleration == pytest.approx(expected, rel=0.01)


def test_vehicle_follows_rough_track() -> None:
    """Random track, low level: long vertical waves lift the frames as they are, and the seed decides the run."""
    component = lrt_rough()
    joined = Joined(component)
    runs = [joined.run(5.0, joined.p(parameter_set("B").vehicle | random_track("low", seed, 48) | {"speed": 10.0}), every=100)
            for seed in (1, 2)]  # fmt: skip
    for run, seed in zip(runs, (1, 2), strict=True):
        values = random_track("low", seed, 48)
        s = run["front_distance"] + 3.0  # set B: the front pair stands 3 m before the middle
        n = np.arange(1, 49)
        wave = 2 * np.pi * np.outer(s, n) / 100.0
        rail = np.cos(wave) @ [values[f"vertical_cosine[{i}]"] for i in range(48)]
        rail += np.sin(wave) @ [values[f"vertical_sine[{i}]"] for i in range(48)]
        even = s > 25.0  # behind the fade
        lift = run["front_vertical_displacement"][even]
        # the frame rises by the rails and by its own lateral motion: k_psi / 2 P of 1e-4 m at most
        assert np.std(lift - rail[even]) < 0.15 * np.std(rail[even])
        assert np.all(run["derailed"] == 0.0)
    assert np.abs(runs[0]["front_lateral_displacement"] - runs[1]["front_lateral_displacement"]).max() > 1e-4
