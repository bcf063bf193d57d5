"""Vehicles from files: what a file says is what the component does; what it must not say is refused in one line."""

import json
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim import system
from gyro_cosim.cli import main
from gyro_cosim.component import Component
from gyro_cosim.systems import catalogue
from gyro_cosim.vehicle.described.component import component_of
from gyro_cosim.vehicle.described.reading import read, read_text

LRT = files("gyro_cosim.vehicle").joinpath("library", "lrt.toml").read_text(encoding="utf-8")
CART = """
[vehicle]
description = "A body on two wheelsets"
[bodies.body]
mass = "8 t"
inertia = { x = "6000 kg.m2", y = "30000 kg.m2", z = "30000 kg.m2" }
centre = { x = "0.5 m", z = "1.4 m" }
[wheelsets.front]
axle = "solid"
x = "3 m"
mass = "1.4 t"
inertia = { x = "800 kg.m2", z = "800 kg.m2" }
spin_inertia = "60 kg.m2"
[wheelsets.rear]
like = "front"
x = "-3 m"
[springs.front]
between = ["body", "front"]
at = { x = "3 m", z = "0.5 m" }
half_spacing = { y = "1 m" }
stiffness = { x = "2 kN/mm", y = "1 kN/mm", z = "0.4 kN/mm" }
damping = { z = "10 kN.s/m" }
[springs.rear]
like = "front"
between = ["body", "rear"]
at = { x = "-3 m", z = "0.5 m" }
[wheels.coned]
flange = "inside"
conicity = "0.05"
conicity_gradient = "0 1/m"
flange_clearance = "7 mm"
"""


def outputs(c: Component, x: np.ndarray | None = None, **values: float) -> dict[str, float]:
    """Outputs and rates by name at the start, or at x."""
    p = [values.get(v.name, v.start) for v in c.parameters]
    at = c.start_state if x is None else x
    y = np.array(c.output(at, c.start_input, p)).ravel()
    rates = np.array(c.rhs(at, c.start_input, p)).ravel()
    found = dict(zip((v.name for v in c.outputs), y, strict=True))
    return found | {f"{v.name}'": rate for v, rate in zip(c.states, rates, strict=True)}


def test_a_file_stands_at_rest_with_its_weight_on_the_wheels() -> None:
    """The body stands 0.5 m ahead of the middle of two equal springs 6 m apart: the lever gives 7 / 12 and 5 / 12 of it."""
    cart = component_of(read_text(CART, "cart.toml"))
    for speed in (5.0, 30.0):
        y = outputs(cart, speed=speed)
        for end, share in (("front", 3.5 / 6), ("rear", 2.5 / 6)):
            for side in ("left", "right"):
                load = (8000.0 * share + 1400.0) * 9.81 / 2
                assert y[f"{end}_{side}_vertical_force"] == pytest.approx(load, rel=1e-9)
        rest = [value for name, value in y.items() if name.endswith("'") and not name.endswith("distance'")]
        assert np.abs(rest).max() < 1e-6
    assert cart.spec == "vehicle:cart"
    assert next(v for v in cart.parameters if v.name == "body_mass").start == 8000.0


def test_parts_that_are_alike_share_their_parameters() -> None:
    cart = component_of(read_text(CART, "cart.toml"))
    names = {v.name for v in cart.parameters}
    assert {"front_mass", "front_stiffness_z"} <= names
    assert not {n for n in names if n.startswith("rear") and n not in ("rear_x", "rear_at_x", "rear_at_z")}


def test_the_file_of_the_paper_takes_the_place_of_its_vehicle(tmp_path: Path) -> None:
    """A system keeps what it has bound for the vehicle: the file is a variant of the package `vehicle`."""
    file = tmp_path / "mine.toml"
    file.write_text(LRT.replace('name = "lrt"', ""), encoding="utf-8")
    plan = system("lrt-curve")
    swapped = plan.with_source("vehicle", str(file))
    assert swapped.notes == plan.notes
    (before,), (after,) = ([c for c in one.components if c.name == "vehicle"] for one in (plan, swapped))
    assert after.bound == before.bound
    own, theirs = (catalogue.component(c.source) for c in (after, before))
    assert own.spec == "vehicle:mine"
    x = {v.name: 1e-3 * (i % 7 - 3) for i, v in enumerate(theirs.states)}
    a, b = (outputs(c, np.array([x[v.name] for v in c.states]), **before.bound) for c in (own, theirs))
    assert a.keys() == b.keys()
    assert max(abs(a[name] - b[name]) / max(abs(b[name]), 1.0) for name in a) < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('mass = "8 t"', 'mas = "8 t"', "cart.toml: bodies.body.mass must be given"),
        ('mass = "8 t"', 'mass = "8 t"\nmas = 3', "cart.toml: bodies.body: unknown key 'mas'; did you mean 'mass'?"),
        ("[springs.front]", "[spring.front]", "cart.toml: file: unknown key 'spring'; did you mean 'springs'?"),
        (', z = "30000 kg.m2" }', " }", "cart.toml: bodies.body.inertia.z must be given"),
        ('x = "6000 kg.m2", y', 'x = "90 t.m2", y',
         "cart.toml: bodies.body.inertia.x must be at most the other two together, 60000 kg.m2, got 90000.0"),
        ('["body", "rear"]', '["body", "front"]',
         "cart.toml: wheelsets.rear must be connected to the rest by springs, links or a pivot, "
         "nothing joins it to 'body'"),
        ('z = "0.4 kN/mm"', 'z = "-0.4 kN/mm"', "cart.toml: springs.front.stiffness.z must be at least 0 N/m, got '-0.4 kN/mm'"),
        ('z = "0.4 kN/mm"', 'z = "0 N/m"', "cart.toml: bodies.body must be carried: no spring with a stiffness along z holds its "
         "height or its pitch"),
        ('mass = "8 t"', 'mass = "8 m"', "cart.toml: bodies.body.mass unit 'm' cannot be expressed in 'kg'"),
        ('mass = "8 t"', "mass = 8000", "cart.toml: bodies.body.mass must have a unit, such as \"8000 kg\", got 8000"),
        ('mass = "8 t"', 'mass = "2 * weight"', "cart.toml: bodies.body.mass: unknown parameter 'weight'; known: conicity, "),
        ('mass = "8 t"', 'mass = "2 * speed"', "cart.toml: bodies.body.mass must be in kg, got '2 * speed'"),
        ('mass = "8 t"', 'mass = "open(1)"', "cart.toml: bodies.body.mass must use + - * / ** and brackets only, got 'open(1)'"),
        ('axle = "solid"', 'axle = "solled"', "cart.toml: wheelsets.front.axle: unknown choice 'solled'; did you mean 'solid'?"),
        ('["body", "rear"]', '["bodi", "rear"]', "cart.toml: springs.rear.between: unknown body 'bodi'; did you mean 'body'?"),
        ("[wheels.coned]", '[mounts.one]\non = "fron"\n[wheels.coned]',
         "cart.toml: mounts.one.on: unknown body 'fron'; did you mean 'front'?"),
        ('conicity = "0.05"', 'conicity = "7"', "cart.toml: wheels.coned.conicity must be at most 1, got 7"),
        ("[vehicle]", "[vehicle]\nspeed = \"0 m/s\"", "cart.toml: vehicle.speed must be at least 0.5 m/s, got 0"),
        ("[vehicle]", "[vehicle", "cart.toml: must be TOML:"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_line(old: str, new: str, says: str) -> None:
    assert old in CART
    with pytest.raises(ValueError, match="cart") as told:
        read_text(CART.replace(old, new, 1), "cart.toml")
    assert str(told.value).startswith(says)
    assert "\n" not in str(told.value)


def test_nothing_is_exported_from_a_bad_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "cart.toml"
    file.write_text(CART.replace('mass = "8 t"', ""), encoding="utf-8")
    assert main(["export", str(file), "-o", str(tmp_path / "built")]) == 2
    assert capsys.readouterr().err == "cosim: cart.toml: bodies.body.mass must be given\n"
    assert not (tmp_path / "built").exists()
    assert main(["export", str(tmp_path / "none.toml")]) == 2
    (tmp_path / "other.toml").write_text("[system]\n", encoding="utf-8")
    assert main(["export", str(tmp_path / "other.toml")]) == 2
    assert "must be TOML with a table [vehicle]" in capsys.readouterr().err


def test_modes_of_a_file_are_those_of_its_springs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Bounce and pitch of the body on four springs, by hand: 8 t on 4 x 0.4 kN/mm, 30 t m2 on arms of 2.5 and 3.5 m, coupled by
    the half metre that the centre stands ahead. 2 % for rails that give, and for the weight over the springs."""
    file = tmp_path / "cart.toml"
    file.write_text(CART.replace('damping = { z = "10 kN.s/m" }', "").replace("2 kN/mm", "1 N/mm"), encoding="utf-8")
    assert main(["modes", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    k, m, J = 2 * 0.4e6, 8000.0, 30000.0
    K = np.array([[2 * k, k * (3.5 - 2.5)], [k * (3.5 - 2.5), k * (2.5**2 + 3.5**2)]])
    hand = np.sqrt(np.linalg.eigvals(np.linalg.solve(np.diag([m, J]), K))) / (2 * np.pi)
    for frequency in hand:
        assert min(abs(mode["frequency"] - frequency) / frequency for mode in found["modes"]) < 0.02
    assert found["velocities"] == 6 + 2 * 6
    assert main(["modes", str(file), "--over", "vehicle.sped=5:50:3"]) == 2
    assert "did you mean 'speed'?" in capsys.readouterr().err


def test_the_manchester_coach_stands_and_bounces_as_by_hand() -> None:
    """42 degrees of freedom; an eighth of the weight under each wheel; bounce of body and frames: two masses on two layers of
    springs and dampers. 1 % for rails that give."""
    coach = component_of(read(Path(str(files("gyro_cosim.vehicle").joinpath("library", "manchester_1.toml")))))
    y = outputs(coach)
    loads = [value for name, value in y.items() if name.endswith("vertical_force")]
    weight = (32000 + 2 * 2615 + 4 * 1813) * 9.81
    assert loads == pytest.approx([weight / 8] * 8, rel=1e-8)
    assert max(abs(value) for name, value in y.items() if name.endswith("'") and "distance" not in name) < 1e-6
    assert sum(v.name.endswith(("_rate", "_velocity", "_deviation")) for v in coach.states) == 42
    x0, u, p = coach.start_state, coach.start_input, coach.start_parameters
    columns = []
    for i in range(x0.size):
        step = np.zeros(x0.size)
        step[i] = 1e-7
        up, down = (np.array(coach.rhs(x0 + sign * step, u, p)).ravel() for sign in (1, -1))
        columns.append((up - down) / 2e-7)
    roots = np.linalg.eigvals(np.array(columns).T)
    m = np.diag([32000.0, 2 * 2615.0])
    K, C = (np.array([[2.0, -2.0], [-2.0, 2.0]]) * 2 * upper + np.diag([0.0, 8.0 * lower])
            for upper, lower in ((430e3, 1220e3), (20e3, 4e3)))  # fmt: skip
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(m, K), -np.linalg.solve(m, C)]])
    for root in np.linalg.eigvals(A):
        assert np.abs(roots - root).min() < 0.01 * abs(root)


def test_vehicle_check_says_what_the_wheels_carry(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "cart.toml"
    file.write_text(CART, encoding="utf-8")
    assert main(["vehicle", "check", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert sum(found["wheel_loads"].values()) == pytest.approx(10800 * 9.81, rel=1e-9)
    assert found["velocities"] == 18
    assert found["rest_error"] < 1e-6
    assert main(["vehicle", "chek", str(file)]) == 2
    file.write_text(CART.replace('mass = "8 t"', 'mass = "-8 t"'), encoding="utf-8")
    assert main(["vehicle", "check", str(file)]) == 2
    assert capsys.readouterr().err.endswith("cosim: cart.toml: bodies.body.mass must be more than 0 kg, got '-8 t'\n")


def test_a_file_may_say_only_in_what_it_differs(tmp_path: Path) -> None:
    """The library's vehicle with conventional wheelsets extends that of the paper: to the bit what is written by hand."""
    library = Path(str(files("gyro_cosim.vehicle").joinpath("library")))
    ours, theirs = component_of(read(library / "lrt_solid_axle.toml")), catalogue.component("vehicle:lrt_solid_axle")
    assert {v.name: v.start for v in ours.parameters} == {v.name: v.start for v in theirs.parameters}
    places = {v.name: 1e-3 * (i % 7 - 3) for i, v in enumerate(theirs.states)}
    a, b = (outputs(c, np.array([places[v.name] for v in c.states])) for c in (ours, theirs))
    assert a == b
    (tmp_path / "base.toml").write_text(CART, encoding="utf-8")
    (tmp_path / "own.toml").write_text(
        '[vehicle]\nextends = "base.toml"\n[bodies.body]\nmass = "9 t"\n[wheels.other]\nflange = "inside"\n', encoding="utf-8"
    )
    own = {v.name: v.start for v in component_of(read(tmp_path / "own.toml")).parameters}
    assert own["body_mass"] == 9000.0
    assert own["body_ixx"] == 6000.0
    assert own["conicity"] == 0.049  # the wheel of another name takes nothing over


@pytest.mark.parametrize(
    ("base", "message"),
    [
        ("none.toml", "own.toml: vehicle.extends must be a file beside this one that there is"),
        ("../base.toml", "own.toml: vehicle.extends must be a file beside this one that there is"),
        ("vehicle:nine", "own.toml: vehicle.extends must be one of vehicle:lrt, vehicle:lrt_solid_axle, vehicle:manchester_1"),
        ("own.toml", "vehicle.extends must lead to a file that extends none, within 8 files"),
        ("bad.toml", "bad.toml: must be TOML"),
    ],
)
def test_what_cannot_be_extended_is_refused(tmp_path: Path, base: str, message: str) -> None:
    (tmp_path / "bad.toml").write_text("= 3", encoding="utf-8")
    (tmp_path / "own.toml").write_text(f'[vehicle]\nextends = "{base}"\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"vehicle|TOML") as refused:
        read(tmp_path / "own.toml")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
