"""The full vehicle: rest, degrees of freedom, steady curve, derailment, bad input."""

import numpy as np
import pytest
from joined import Joined

from gyro_cosim.component import Component
from gyro_cosim.gyro_unit.nonlinear import nonlinear_full
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.parameter_sets import parameter_set, parameter_set_names

G = 9.81


@pytest.fixture(scope="module")
def vehicle() -> Component:
    return lrt_set_a()


@pytest.fixture(scope="module")
def alone(vehicle: Component) -> Joined:
    return Joined(vehicle)


@pytest.fixture(scope="module")
def damped(vehicle: Component) -> Joined:
    return Joined(vehicle, {"front": nonlinear_full(), "rear": nonlinear_full()})


def test_vehicle_and_two_gyro_units_have_the_papers_28_degrees_of_freedom(vehicle: Component) -> None:
    """Every degree of freedom has one velocity among the states; those of the rotors, held by their drives, are not states."""
    velocities = [v.name for v in vehicle.states if v.name.endswith(("_rate", "_velocity", "speed_deviation", "spin_deviation"))]
    assert len(velocities) == 24
    gimbals = [v.name for v in nonlinear_full().states if v.name == "gimbal_pitch_rate"]
    rotors = [v.name for v in nonlinear_full().parameters if v.name == "rotor_speed"]
    assert len(velocities) + 2 * (len(gimbals) + len(rotors)) == 28
    # each is free: it has acceleration of its own when pushed, and places follow (wheel angles are not needed)
    assert len(vehicle.states) == 24 + 20


@pytest.mark.parametrize("law", ["kalker", "shen-hedrick-elkins", "polach", "fastsim", "half-space"])
def test_vehicle_starts_at_rest_with_every_law(law: str) -> None:
    component = lrt_set_a(law=law)
    x_dot = np.array(component.rhs(component.start_state, component.start_input, component.start_parameters)).ravel()
    accelerations = [a for v, a in zip(component.states, x_dot, strict=True) if not v.name.endswith("distance")]
    assert np.abs(accelerations).max() < 1e-6  # four Newton steps of the trim; without spin creep in it: 1e-3 m/s2


@pytest.mark.parametrize("name", parameter_set_names())
def test_vehicle_starts_at_rest_with_other_parameters(alone: Joined, name: str) -> None:
    """The rest state is a formula in the parameters: changed masses, loads and speeds start without a transient, too."""
    for change in (
        {},
        {"speed": 50.0},
        {"body_mass": 6000.0, "speed": 1.0},
        {"friction": 0.1},
        {"conicity": 0.3, "gravity": 1.6},
    ):
        p = alone.p(parameter_set(name).vehicle | change)
        x_dot = np.array(alone.f(alone.x0, p)).ravel()
        accelerations = [a for n, a in zip(alone.state_names, x_dot, strict=True) if not n.endswith("distance")]
        assert np.abs(accelerations).max() < 2e-6, change


def test_wheels_carry_the_weight_at_rest(alone: Joined) -> None:
    y = dict(zip(alone.output_names, np.array(alone.g(alone.x0, alone.p({}))).ravel(), strict=True))
    loads = [y[f"{end}_{side}_vertical_force"] for end in ("front", "rear") for side in ("left", "right")]
    assert loads == pytest.approx([7000 * G / 4] * 4, rel=1e-9)  # total mass 7000 kg: PHYSICS section 3


def test_rest_of_the_undriven_vehicle_is_only_slowed_by_spin_creep(alone: Joined) -> None:
    """Rolling freely it loses what the drive would give: drag over mass and the wheels' spin inertia over radius squared."""
    p = alone.p({"drive_on": 0.0})
    x_dot = dict(zip(alone.state_names, np.array(alone.f(alone.x0, p)).ravel(), strict=True))
    power = float(np.array(alone.g(alone.x0, alone.p({}))).ravel()[alone.output_names.index("dissipated_power")])
    assert -2 * 2000 * x_dot["front_speed_deviation"] * 5.0 == pytest.approx(power, rel=1e-6)


def test_steady_curve_meets_hand_calculation(damped: Joined) -> None:
    """Wide curve, gentle speed, set B: the rails push m v^2 / R less the cant's share, the gyro's pitch moment is H v / R, the
    loads follow the roll moment of the centrifugal force."""
    B = parameter_set("B")
    v, R, cant = 6.0, 200.0, 0.01
    values = B.vehicle | {f"unit.{n}": value for n, value in B.gyro.items()}
    values |= {"speed": v, "curve_turn": 1.0, "curve_radius": R, "curve_length": 500.0, "curve_cant": cant, "curve_start": 5.0,
               "transition_length": 10.0, "primary_damping_y": 21000.0}  # fmt: skip
    run = damped.run(20.0, damped.p(values), every=200)
    steady = run.t > 17.0
    m, angle = 7000.0, cant / (2 * 0.7475)
    side = m * (v**2 / R - G * angle)
    guiding = run["front_guiding_force"][steady].mean() + run["rear_guiding_force"][steady].mean()
    assert guiding == pytest.approx(side, rel=0.01)
    loads = sum(run[f"{end}_{s}_vertical_force"][steady].mean() for end in ("front", "rear") for s in ("left", "right"))
    assert loads == pytest.approx(m * (G * np.cos(angle) + v**2 / R * np.sin(angle)), rel=1e-3)
    outer = sum(run[f"{end}_right_vertical_force"][steady].mean() for end in ("front", "rear"))
    height = (2000 * 1.5 + 1000 * 0.55 + 4000 * 0.3) / 7000
    # the masses stand a little outwards: the pairs by their displacement, the body less the height of the arc over its chord
    outwards = 2000 * sum(-run[f"{end}_lateral_displacement"][steady].mean() for end in ("front", "rear"))
    outwards += 3000 * (6.0**2 / (8 * R) - run["body_lateral_displacement"][steady].mean())
    assert outer - loads / 2 == pytest.approx((side * height + G * outwards) / (2 * 0.7475), rel=0.03)
    H = 22.04 * 2000 * 2 * np.pi / 60
    for end in ("front", "rear"):
        assert run[f"{end}.pitch_moment"][steady].mean() == pytest.approx(-H * v / R, rel=0.01)
        assert abs(run[f"{end}.yaw_moment"][steady].mean()) < 0.02 * H * v / R


def test_derailment_is_reported_before_the_model_ends(alone: Joined) -> None:
    """Set A without gyro at 8 m/s leaves the rails: the run says so, every output is finite up to there and beyond."""
    p = alone.p(parameter_set("A").vehicle | {"speed": 8.0, "curve_turn": 1.0, "curve_start": 5.0, "curve_length": 300.0})
    x = alone.x({"front_yaw_angle": 0.03})
    run = alone.run(40.0, p, x, every=40, until="derailed")
    assert run["derailed"][-1] == 1.0
    assert np.all(run["derailed"][:-1] == 0.0)
    climbs = [run[f"{end}_{side}_climb"] for end in ("front", "rear") for side in ("left", "right")]
    assert max(c[-1] for c in climbs) > 1.0
    after = alone.run(0.02, p, run.end, every=40)
    assert np.all(np.isfinite(run.values))
    assert np.all(np.isfinite(after.values))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("speed", 0.0, "speed must be at least 0.5 m/s, got 0"),
        ("speed", -3.0, "speed must be at least 0.5 m/s, got -3"),
        ("friction", 1.5, "friction must be at most 1, got 1.5"),
        ("curve_radius", 4.0, "curve_radius must be at least 10 m, got 4"),
        ("body_mass", float("nan"), "body_mass must be finite, got nan"),
    ],
)
def test_bad_values_are_refused_in_one_line(name: str, value: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        lrt_set_a({name: value})


def test_unknown_names_are_refused_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"law must be one of kalker, .*, got 'coulomb'"):
        lrt_set_a(law="coulomb")
    with pytest.raises(ValueError, match="'vehicle:lrt' has no variable 'sped'"):
        lrt_set_a({"sped": 5.0})
    with pytest.raises(ValueError, match="parameter set must be one of A, B, got 'C'"):
        parameter_set("C")
