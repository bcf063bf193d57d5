"""What of a gyro unit's inertia rides on its carrier: none lost, none counted twice, for every variant."""

import json

import casadi as ca
import numpy as np
import pytest

from gyro_cosim import system
from gyro_cosim.cli import main
from gyro_cosim.gyro_unit import VARIANTS
from gyro_cosim.sweeps import Sweep
from gyro_cosim.sweeps.plan import SweepContext
from gyro_cosim.systems import catalogue
from gyro_cosim.systems.riding import held_with, inertia_on_carriers, settled

FULL = [variant for variant in VARIANTS if variant.endswith("_full")]
TABLE_2 = {"roll": 22.04, "pitch": 26.45, "yaw": 26.45}  # kg m2 of inner gimbal and rotor together
STATES = {  # what turns with the frame at a rate w about an axis, all of it rigidly
    "roll": {"rotor_speed_deviation": 1.0, "gimbal_roll_rate": -1.0}, "pitch": {"gimbal_pitch_rate": 1.0}, "yaw": {},
}  # fmt: skip


@pytest.mark.parametrize("variant", FULL)
def test_a_units_inertia_is_all_there_once(variant: str) -> None:
    """Frame and unit turning rigidly about an axis, rotor not spinning: the unit's stored energy and that of what rides on the
    frame are together half its whole inertia. In `lateral` the rotor lies across, so roll and pitch change places."""
    plan = settled(system("lrt-curve").with_source("gyro", variant))
    assert all(one.right for one in inertia_on_carriers(plan))
    carried = {one.axis: one.carried for one in inertia_on_carriers(plan) if one.mount == "front"}
    unit = catalogue.component(f"gyro_unit:{variant}")
    names = [v.name for v in unit.states]
    p = [0.0 if v.name == "rotor_speed" else v.start for v in unit.parameters]
    stored = [v.name for v in unit.outputs].index("stored_energy")
    whole = dict(zip(TABLE_2, (26.45, 22.04, 26.45), strict=True)) if variant == "lateral_full" else TABLE_2
    for axis, inertia in whole.items():
        x = np.zeros(len(names))
        for name, rate in STATES[axis].items():
            if name in names and (name != "gimbal_roll_rate" or variant == "lateral_full"):
                x[names.index(name)] = rate
        energy = float(unit.output(x, np.zeros(len(unit.inputs)), p)[stored])
        assert 2 * energy + carried[axis] == pytest.approx(inertia, rel=1e-12), axis


def test_the_vehicle_takes_what_its_units_say() -> None:
    plan = system("lrt-curve")
    assert settled(plan) is plan
    wrong = [one for one in inertia_on_carriers(plan.with_source("gyro", "twin_full")) if not one.right]
    assert [(one.mount, one.axis, one.carried, one.rides) for one in wrong] == [
        ("front", "pitch", 0.0, 26.45), ("rear", "pitch", 0.0, 26.45)
    ]  # fmt: skip
    assert wrong[0].words().endswith("26.45 lost (vehicle.inner_gimbal_iyy)")
    right = settled(plan.with_source("gyro", "twin_full"))
    assert right.notes[-1].startswith("vehicle.inner_gimbal_iyy = 26.45 kg m2")
    twice = [one.words() for one in inertia_on_carriers(plan.with_source("gyro", "multibody_full")) if not one.right]
    assert twice[0].endswith("22.04 counted twice (vehicle.inner_gimbal_ixx)")
    heavier = settled(plan.with_value("gyro.rotor_inertia", "44 kg.m2"))
    assert all(one.right for one in inertia_on_carriers(heavier))
    assert next(one.carried for one in inertia_on_carriers(heavier) if one.axis == "roll") == 44.0
    unlike = plan.with_value("gyro_front.rotor_inertia", 30.0)
    assert next(c for c in settled(unlike).components if c.name == "vehicle").bound == plan.components[0].bound
    assert settled(unlike).notes[-1].endswith("30 ride there: 7.96 lost (vehicle.inner_gimbal_ixx)")
    mine = settled(plan.with_source("gyro", "twin_full").with_value("vehicle.inner_gimbal_iyy", 1.0))
    assert "25.45 lost" in mine.notes[-1]


def test_a_sweep_over_variants_gives_the_vehicle_what_a_run_does() -> None:
    plan, names = system("lrt-curve"), ("nonlinear_full", "twin_full")
    context = SweepContext(plan, {"gyro": {name: {} for name in names}}, {}, 1.0, (), riding=held_with(plan, {"gyro": names}))
    for name in names:
        swept = context.system_at({"gyro": name}, {part.source: part.source for part in plan.components})
        alone = settled(plan.with_source("gyro", name))
        assert swept.components[0].bound == alone.components[0].bound
        assert swept.components[0].bound.get("inner_gimbal_iyy", 0.0) == {"twin_full": 26.45}.get(name, 0.0)


@pytest.mark.slow
def test_the_plan_of_a_sweep_tells_them_apart() -> None:
    """It builds the FMUs first."""
    planned = Sweep(system("lrt-curve"), {}, {"gyro": ("nonlinear_full", "twin_full")}, stop=0.01).plan()
    held = {str(point["gyro"]): planned.context.held_at(point) for point in planned.runs.values()}
    assert held == {"nonlinear_full": {}, "twin_full": {"vehicle": {"inner_gimbal_iyy": 26.45}}}


@pytest.mark.slow
def test_info_says_whether_inertia_is_all_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "lrt-curve", "--json"]) == 0
    assert {row["right"] for row in json.loads(capsys.readouterr().out)["riding"]} == {True}
    assert main(["info", "lrt-curve"]) == 0
    assert capsys.readouterr().out.endswith("inertia of gyro_front, gyro_rear on vehicle: all there, once\n")


def test_a_twins_pitch_inertia_is_felt_by_the_vehicle() -> None:
    """The frame's pitch acceleration to a pitch moment: 1 / J with J = 63.55 without, 90.0 kg m2 with the unit's 26.45."""
    plan = system("lrt-curve").with_source("gyro", "twin_full")
    vehicle = catalogue.component("vehicle:lrt")
    x, u, p = (
        ca.SX.sym(name, n) for name, n in (("x", len(vehicle.states)), ("u", len(vehicle.inputs)), ("p", len(vehicle.parameters)))
    )
    row = [v.name for v in vehicle.states].index("front_pitch_rate")
    column = [v.name for v in vehicle.inputs].index("front_pitch_moment")
    slope = ca.Function("slope", [x, u, p], [ca.jacobian(vehicle.rhs(x, u, p)[row], u[column])])
    for chosen, inertia in ((plan, 63.55), (settled(plan), 90.0)):
        part = next(c for c in chosen.components if c.name == "vehicle")
        values = [float(part.bound.get(v.name, v.start)) if v.name == "inner_gimbal_iyy" else v.start for v in vehicle.parameters]
        got = float(slope(vehicle.start_state, vehicle.start_input, values))
        assert 1 / got == pytest.approx(inertia, rel=1e-9)
