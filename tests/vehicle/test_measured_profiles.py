"""Wheels and rails by points, in the equations of motion: held against the contact search, and against cones as parameters."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from gyro_cosim import simulate
from gyro_cosim.component import Component
from gyro_cosim.systems import System, SystemComponent
from gyro_cosim.vehicle import contact_points
from gyro_cosim.vehicle.described.component import component_of
from gyro_cosim.vehicle.described.description import Description
from gyro_cosim.vehicle.described.equations import motion
from gyro_cosim.vehicle.described.reading import read, read_text
from gyro_cosim.vehicle.profiles import rail_60e1, s1002
from gyro_cosim.vehicle.profiles import read as read_profile
from gyro_cosim.vehicle.wheelset_contact import WheelsetContacts

AXLE = """
[vehicle]
speed = "10 m/s"
[wheelsets.axle]
axle = "solid"
mass = "1.4 t"
inertia = { x = "800 kg.m2", z = "800 kg.m2" }
spin_inertia = "60 kg.m2"
load = "86266 N"
[wheels.measured]
profile = "s1002"
flange = "inside"
rolling_radius = "0.46 m"
inner_distance = "1360 mm"
[rails.measured]
profile = "60e1"
gauge = "1435 mm"
inclination = "1/40"
rail_lateral_stiffness = "1e12 N/m"
"""
LAID = {"rolling_radius": 0.46, "gauge": 1.435, "inner_distance": 1.36, "inclination": 1 / 40}
LOAD = 86266 + 1400 * 9.81


def at(c: Component, values: dict[str, float] | None = None, **states: float) -> dict[str, float]:
    """Outputs of the axle by name."""
    x = c.start_state.copy()
    for i, v in enumerate(c.states):
        x[i] = states.get(v.name.removeprefix("axle_"), x[i])
    p = [(values or {}).get(v.name, v.start) for v in c.parameters]
    y = np.array(c.output(x, c.start_input, p)).ravel()
    return dict(zip((v.name.removeprefix("axle_") for v in c.outputs), y, strict=True))


def across_of(found: WheelsetContacts) -> float:
    """Side force of the normal forces, to the left (N)."""
    left, right = (sum(c.normal_force * np.sin(c.contact_angle) for c in side) for side in (found.left, found.right))
    return float(right - left)


@pytest.fixture(scope="module")
def axle() -> Component:
    return component_of(read_text(AXLE, "axle.toml"))


@pytest.fixture(scope="module")
def seat() -> float:
    return contact_points(s1002(), rail_60e1(), axle_load=LOAD, normal="kik-piotrowski", **LAID).axle_height


def test_it_stands_with_its_load_on_both_wheels(axle: Component) -> None:
    for speed in (2.0, 40.0):
        found = at(axle, {"speed": speed})
        assert [found["left_vertical_force"], found["right_vertical_force"]] == pytest.approx([LOAD / 2] * 2, rel=1e-9)
        rates = np.array(axle.rhs(axle.start_state, axle.start_input, [v.start for v in axle.parameters])).ravel()
        assert np.abs(rates[1:]).max() < 1e-6


@pytest.mark.parametrize("yaw", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("lateral", [-0.004, 0.0, 0.001, 0.003, 0.0055, 0.007])
def test_forces_are_those_of_the_contact_search(axle: Component, seat: float, lateral: float, yaw: float) -> None:
    """Without friction, at the place where the search has the axle at rest. A tread carries its load within 1 %, 6 % where the
    contact jumps across the wheel: there 0.003 mm of height do as much. On the flange, as if it were moved by 0.02 mm."""
    found = contact_points(s1002(), rail_60e1(), lateral=lateral, yaw=yaw, axle_load=LOAD, normal="kik-piotrowski", **LAID)
    pose = {"yaw_angle": yaw, "roll_angle": found.roll, "vertical_displacement": found.axle_height - seat}
    ours = at(axle, {"friction": 0.0}, lateral_displacement=lateral, **pose)
    across = across_of(found)
    steepest = max((*found.left, *found.right), key=lambda c: c.contact_angle)
    if steepest.contact_angle > 0.5:
        beside = [at(axle, {"friction": 0.0}, lateral_displacement=lateral + d, **pose)["guiding_force"] for d in (-2e-5, 2e-5)]
        assert min(beside) < across < max(beside)
        assert ours["left_contact_angle"] == pytest.approx(steepest.contact_angle, abs=0.01)
        return
    jump = steepest.contact_angle > 0.2
    for side in ("left", "right"):
        assert ours[f"{side}_vertical_force"] == pytest.approx(LOAD / 2, rel=0.06 if jump else 0.01)
    assert ours["guiding_force"] == pytest.approx(across, rel=0.06 if jump else 0.01, abs=20.0)


def inside(d: Description, *, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(rate of every gap, minus the approach rate of its contact) at some states of a vehicle, shape (2, contacts)."""
    c = component_of(d)
    x = ca.SX.sym("x", len(c.states))
    s = {v.name: x[i] for i, v in enumerate(c.states)} | {v.name: ca.SX(v.start) for v in (*c.parameters, *c.inputs)}
    equations = motion(s, d)
    gaps, rates = (ca.vertcat(*column) for column in zip(*equations.account["gaps"], strict=True))
    x_dot = ca.vertcat(*(equations.derivatives[v.name] for v in c.states))
    f = ca.Function("f", [x], [ca.jtimes(gaps, x, x_dot), -rates])
    rng = np.random.default_rng(seed)
    sizes = {"lateral_displacement": 1.5e-3, "yaw_angle": 4e-3, "roll_angle": 5e-4, "vertical_displacement": 2e-5,
             "lateral_velocity": 0.1, "vertical_velocity": 0.05, "yaw_rate": 0.05, "roll_rate": 0.05}  # fmt: skip
    pairs = []
    for _ in range(20):
        state = c.start_state.copy()
        for i, v in enumerate(c.states):
            state[i] += rng.normal() * sizes.get(v.name.removeprefix("axle_"), 0.0)
        pairs.append([np.array(value).ravel() for value in f(state)])
    got, wanted = np.array(pairs).transpose(1, 0, 2)
    return got, wanted


def test_the_gap_follows_the_wheel() -> None:
    """Contact point, normal and gap belong together: treads within 5 % of the fastest approach, where the patch changes shape."""
    got, wanted = inside(read_text(AXLE, "axle.toml"), seed=4)
    treads = [0, 2]
    error = np.abs(got - wanted)[:, treads]
    assert np.abs(wanted[:, treads]).max() > 0.1
    assert np.median(error) < 0.005 * np.abs(wanted[:, treads]).max()
    assert error.max() < 0.05 * np.abs(wanted[:, treads]).max()


def points(file: Path, y: np.ndarray, z: np.ndarray) -> str:
    file.write_text("\n".join(f"{1e3 * a:.6f} {1e3 * b:.6f}" for a, b in zip(y, z, strict=True)), encoding="utf-8")
    return file.name


def cone(folder: Path, conicity: float = 0.05, name: str = "cone.whl") -> str:
    """A wheel with a straight tread and a flange of 70 degrees from 40 mm inside its tape line."""
    y = np.linspace(-0.065, 0.055, 1201)
    flange = np.clip(-y - 0.04, 0.0, 0.012) * np.tan(np.radians(70.0))
    return points(folder / name, y, conicity * y - flange)


def head(folder: Path) -> str:
    """A rail with a crown of 300 mm, and sides down to 30 mm."""
    y = np.linspace(-0.036, 0.036, 1441)
    crown = np.sqrt(0.3**2 - np.minimum(np.abs(y), 0.0345) ** 2) - 0.3
    return points(folder / "head.rai", y, crown - 20 * np.maximum(np.abs(y) - 0.0345, 0.0))


def cones(folder: Path, conicity: float = 0.05) -> str:
    """The axle with cones as points; the gauge puts the rails' middles under the tape lines."""
    text = AXLE.replace('"s1002"', f'"{cone(folder, conicity)}"').replace('"60e1"', f'"{head(folder)}"')
    return text.replace('"1/40"', '"0"').replace('"1435 mm"', '"1430.6 mm"')


def kinematic_rate(c: Component) -> float:
    """Of the axle's hunting at its speed (rad/s), free of everything but its wheels."""
    x = ca.SX.sym("x", len(c.states))
    A = np.array(ca.Function("A", [x], [ca.jacobian(c.rhs(x, c.start_input, c.start_parameters), x)])(c.start_state))
    roots = np.linalg.eigvals(A)
    slow = roots[(roots.imag > 0.05) & (roots.imag < 20.0)]
    assert slow.size == 1
    return float(slow[0].imag)


def klingel(folder: Path) -> float:
    """v sqrt(lambda / (r b (1 + r phi / y))) at 2 m/s, for unlike rolling radii 2 lambda y and a roll phi by the contact search:
    the rolling direction v psi is that of the contact's place, which roll moves by r phi as well as y."""
    wheel, rail = read_profile(folder / "cone.whl"), read_profile(folder / "head.rai")
    laid = LAID | {"gauge": 1.4306, "inclination": 0.0}
    low, high = (contact_points(wheel, rail, lateral=y, axle_load=LOAD, normal="kik-piotrowski", **laid) for y in (-5e-4, 5e-4))

    def unlike(found: WheelsetContacts) -> float:
        return (found.left[0].rolling_radius - found.right[0].rolling_radius) / 2

    b = (high.left[0].track_lateral - high.right[0].track_lateral) / 2
    growth, rolling = (unlike(high) - unlike(low)) / 1e-3, (high.roll - low.roll) / 1e-3
    return float(2.0 * np.sqrt(growth / (0.46 * b * (1 + 0.46 * rolling))))


@pytest.mark.parametrize("conicity", [0.02, 0.1])
def test_cones_by_points_hunt_as_klingel_has_it(tmp_path: Path, conicity: float) -> None:
    """Cones on crowned rails: more than their conicity, which the contact search knows too."""
    (tmp_path / "axle.toml").write_text(cones(tmp_path, conicity).replace('"10 m/s"', '"2 m/s"'), encoding="utf-8")
    assert kinematic_rate(component_of(read(tmp_path / "axle.toml"))) == pytest.approx(klingel(tmp_path), rel=0.005)


def test_the_right_wheel_may_have_a_profile_of_its_own(tmp_path: Path) -> None:
    """A steeper cone on the right, 1 mm to the left: loads, side force and creepages are those of the contact search."""
    text = cones(tmp_path)
    cone(tmp_path, 0.1, "steep.whl")
    (tmp_path / "axle.toml").write_text(text.replace("[rails", 'right_profile = "steep.whl"\n[rails'), encoding="utf-8")
    c = component_of(read(tmp_path / "axle.toml"))
    wheel, steep, rail = (read_profile(tmp_path / name) for name in ("cone.whl", "steep.whl", "head.rai"))
    laid = LAID | {"gauge": 1.4306, "inclination": 0.0, "axle_load": LOAD}

    def searched(lateral: float) -> WheelsetContacts:
        return contact_points(wheel, rail, right_wheel=steep, lateral=lateral, normal="kik-piotrowski", **laid)

    aside = -0.46 * searched(0.0).roll  # where it starts: the tape circles' bottoms over the running lines
    start, found = searched(aside), searched(1e-3)
    still = at(c, {"friction": 0.0})
    assert [still[f"{side}_vertical_force"] for side in ("left", "right")] == pytest.approx([LOAD / 2] * 2, rel=0.01)
    pose = {"lateral_displacement": 1e-3 - aside, "roll_angle": found.roll - start.roll,
            "vertical_displacement": found.axle_height - start.axle_height}  # fmt: skip
    ours = at(c, {"friction": 0.0}, **pose)
    assert [ours[f"{side}_vertical_force"] for side in ("left", "right")] == pytest.approx([LOAD / 2] * 2, rel=0.01)
    assert ours["guiding_force"] == pytest.approx(across_of(found), rel=0.01)
    radii = found.left[0].rolling_radius - found.right[0].rolling_radius
    creepages = ours["right_longitudinal_creepage"] - ours["left_longitudinal_creepage"]
    assert creepages == pytest.approx(radii / 0.46, rel=0.01)


def test_flanges_may_be_outside(tmp_path: Path) -> None:
    """Mirrored wheels and rails: what was towards the flange still is, so that the radius falls as the wheel moves there."""
    y = np.linspace(-0.055, 0.065, 1201)
    outside = points(tmp_path / "outside.txt", y, -0.05 * y - np.clip(y - 0.04, 0.0, 0.012) * np.tan(np.radians(70.0)))
    text = cones(tmp_path).replace('"cone.whl"', f'"{outside}"').replace('"inside"', '"outside"')
    (tmp_path / "axle.toml").write_text(text, encoding="utf-8")
    c = component_of(read(tmp_path / "axle.toml"))
    pushed = at(c, {"friction": 0.0}, lateral_displacement=2e-3)
    assert pushed["left_contact_angle"] == pytest.approx(np.arctan(0.05), rel=0.02)
    pressed = at(c, {"friction": 0.0}, lateral_displacement=-0.0075, vertical_displacement=2e-4)
    assert pressed["left_flange_force"] > 1e3
    assert pressed["right_flange_force"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_its_fmu_has_the_bits_of_this_process(tmp_path: Path) -> None:
    """Against the flange and back: 3 mm aside, with 5 mrad of yaw."""
    (tmp_path / "axle.toml").write_text(AXLE, encoding="utf-8")
    plan = System("axle", (SystemComponent("vehicle", str(tmp_path / "axle.toml")),), ())
    plan = plan.with_value("vehicle.axle_lateral_displacement", 3e-3).with_value("vehicle.axle_yaw_angle", 5e-3)
    runs = [simulate(plan, stop=1.0, step=1e-3, in_process=here) for here in (False, True)]
    first, second = (run.trajectory["vehicle.axle_lateral_displacement"] for run in runs)
    assert np.array_equal(first, second)
    assert first.max() > 5e-3


@pytest.mark.slow
def test_the_coach_settles_and_its_fmu_agrees(tmp_path: Path) -> None:
    """Vehicle 1 of the Manchester benchmarks on S1002: 4 mm aside at 30 m/s, an FMU as in this process, quiet after 4 s."""
    file = str(Path(__file__).resolve().parents[2] / "vehicle" / "library" / "manchester_1.toml")
    plan = System("coach", (SystemComponent("vehicle", file),), ()).with_value("vehicle.speed", 30.0)
    plan = plan.with_value("vehicle.first_lateral_displacement", 4e-3)
    runs = [simulate(plan, stop=4.0, step=1e-3, in_process=here) for here in (False, True)]
    first, second = (run.trajectory["vehicle.first_lateral_displacement"] for run in runs)
    assert np.array_equal(first, second)
    assert np.abs(first[-500:]).max() < 1e-3
    assert np.abs(first[:500]).max() >= 4e-3


REFUSED = (
    ('"s1002"', '"s1003"', "wheels.measured.profile must be 's1002' or a file beside this one that there is, got 's1003'"),
    ('profile = "60e1"\n', "", "rails.measured.profile must be a rail given by points"),
    ('"1360 mm"', '"1800 mm"', "inner_distance must be within 0.3 m of the gauge"),
    ('"1360 mm"', '"1380 mm"', "a centred wheel must run on its tread"),
    ('"1435 mm"', '"1435 km"', "gauge must be from 0.2 to 2.5 m"),
    ('"1/40"', '"steep"', 'inclination must be a slope such as "1/40"'),
    ('"1/40"', '"1"', "inclination must lie in 0..0.2"),
    ('rolling_radius = "0.46 m"', 'conicity = "0.05"', "wheels.measured: unknown key 'conicity'"),
    ('inclination = "1/40"', 'corner_radius = "13 mm"', "rails.measured: unknown key 'corner_radius'"),
)


@pytest.mark.parametrize(("old", "new", "message"), REFUSED, ids=[new for _, new, _ in REFUSED])
def test_refusals_name_the_key(old: str, new: str, message: str) -> None:
    assert old in AXLE
    with pytest.raises(ValueError, match=r"^(axle.toml|vehicle 'axle')") as refused:
        component_of(read_text(AXLE.replace(old, new, 1), "axle.toml"))
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_bad_file_of_points_is_named(tmp_path: Path) -> None:
    (tmp_path / "few.whl").write_text("\n".join(f"{i} 0" for i in range(10)), encoding="utf-8")
    (tmp_path / "axle.toml").write_text(AXLE.replace('"s1002"', '"few.whl"'), encoding="utf-8")
    with pytest.raises(ValueError, match=r"wheels.measured.profile cannot be used: .*must have 25 points or more, got 10"):
        read(tmp_path / "axle.toml")


@pytest.mark.parametrize("name", ["contact_half_distance", "poisson_ratio"])
def test_what_the_tables_were_made_for_cannot_be_changed(axle: Component, name: str) -> None:
    row = next(v for v in axle.parameters if v.name == name)
    assert row.check(row.start) == row.start
    with pytest.raises(ValueError, match=name):
        row.check(row.start * 1.1)
