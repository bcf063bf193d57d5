"""A part swapped by name: what it takes over from the old one, what is dropped and told, signals with other names."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gyro_cosim import simulate, system
from gyro_cosim.comparison.candidates import compare
from gyro_cosim.network import Network
from gyro_cosim.slaves.described import described_slave

# The paper's unit as a vendor may write it: a moment -H eta', other names, rotor speed in rad/s as ours.
VENDOR = """
from gyro_cosim.component import build, input_, output, parameter, state

def component():
    return build(
        name="vendor", variant="one", description="", equations="", internal_step=1e-3,
        variables=[
            input_("omega", "rad/s", "rate of the frame"),
            state("tilt", "rad", "gimbal angle"),
            state("tilt_rate", "rad/s", "its rate"),
            parameter("spin", 10.0, "rad/s", "spin of the rotor", source="data sheet", display_unit="rpm", min=0.0, max=3000.0),
            parameter("inertia", 0.00037, "kg.m2", "of the rotor", source="data sheet"),
            output("torque", "N.m", "on the frame"),
        ],
        model=lambda s: (
            {"tilt": s["tilt_rate"], "tilt_rate": (-s["inertia"] * s["spin"] * s["omega"] - 0.00063 * s["tilt_rate"]
             - 0.0045 * s["tilt"]) / 0.00013},
            {"torque": s["inertia"] * s["spin"] * s["tilt_rate"]},
        ),
    )
"""


@pytest.fixture
def vendor(tmp_path: Path) -> str:
    file = tmp_path / "vendor.py"
    file.write_text(VENDOR)
    return str(file)


def described(plan: Any) -> Network:
    return Network(plan, [described_slave(p.name, p.source) for p in plan.components])


def test_a_vehicle_of_one_s_own_takes_no_value_over_that_was_bound_for_the_system_s(vendor: str) -> None:
    """`lrt-curve` binds the curve of 50 m and its turn for its own vehicle; on the track of another they would be wrong."""
    plan = system("lrt-curve").with_source("vehicle", vendor)
    vehicle = next(part for part in plan.components if part.name == "vehicle")
    assert dict(vehicle.bound) == {}
    (note,) = plan.notes
    assert note.startswith(f"vehicle is {vendor} now")
    assert note.endswith("what the system had bound for vehicle:lrt is dropped: speed = 5, curve_turn = 1, curve_radius = 50")


def test_another_variant_of_the_package_keeps_what_is_bound_and_an_exported_fmu_of_it_too() -> None:
    for source in ("lrt_set_b", "vehicle:lrt_rough", "somewhere/vehicle.lrt.fmu"):
        plan = system("lrt-curve").with_source("vehicle", source)
        assert plan.notes == ()
        assert dict(plan.components[0].bound)["curve_radius"] == 50
    assert dict(system("lrt-curve").with_source("vehicle", "other.fmu").components[0].bound) == {}


def test_signals_of_other_names_are_renamed_in_connections_bonds_and_stops(vendor: str) -> None:
    plan = system("wheel-pair").with_source("gyro", vendor, {"omega": "yaw_rate", "torque": "yaw_moment"})
    assert {(c.start, c.end) for c in plan.connections} >= {
        (("vehicle", "yaw_rate"), ("gyro", "omega")), (("gyro", "torque"), ("vehicle", "yaw_moment")),
    }  # fmt: skip
    assert (plan.bonds[0].motion, plan.bonds[0].effort) == (("vehicle", "yaw_rate"), ("gyro", "torque"))
    plan = plan.with_value("gyro.spin", "100rpm")
    mine = simulate(plan, stop=0.2, in_process=True).trajectory.end()
    ours = simulate(system("wheel-pair"), stop=0.2, in_process=True).trajectory.end()
    assert mine["gyro.torque"] == pytest.approx(ours["gyro.yaw_moment"], rel=0.02)  # the paper's unit, the same parameters
    assert mine["vehicle.yaw_angle"] == pytest.approx(ours["vehicle.yaw_angle"], rel=1e-3)


@pytest.mark.parametrize(
    ("renamed", "words"),
    [
        ({"torque": "yaw_momnt"}, "unknown signal of 'gyro' that the system uses: 'yaw_momnt'; did you mean 'yaw_moment'"),
        ({"yaw_moment": "torque"}, "a renaming is FOREIGN=OURS, the part's own name first, got yaw_moment=torque"),
        ({"torque": "yaw_moment", "torque_2": "yaw_moment"}, "signal 'yaw_moment' of 'gyro' must be renamed once, got it twice"),
    ],
)
def test_a_wrong_renaming_is_refused_with_the_nearest_name(vendor: str, renamed: dict[str, str], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        system("wheel-pair").with_source("gyro", vendor, renamed)


def test_a_misspelt_name_of_the_part_is_found_when_it_is_opened(vendor: str) -> None:
    plan = system("wheel-pair").with_source("gyro", vendor, {"omega": "yaw_rate", "torqe": "yaw_moment"})
    with pytest.raises(ValueError, match=r"torqe.*did you mean '(gyro\.)?torque'"):
        described(plan)


def test_compare_takes_a_variant_that_calls_its_signals_otherwise(vendor: str) -> None:
    found = compare(
        system("wheel-pair"), ["linear", f"{vendor},omega=yaw_rate,torque=yaw_moment,spin=100rpm"], stop=0.1, in_process=True,
        responses=False,
    )  # fmt: skip
    assert [c.failure for c in found.candidates] == ["", ""]
    assert found.candidates[1].differences["vehicle.yaw_angle"].rms < 0.01
    with pytest.raises(ValueError, match="'yaw_momnt'; did you mean 'yaw_moment'"):
        compare(system("wheel-pair"), ["linear", f"{vendor},omega=yaw_rate,torque=yaw_momnt"], in_process=True)


def test_the_command_line_swaps_any_part(vendor: str, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    ours = ("--in-process", "--stop", "0.01")
    swap = f"gyro={vendor},omega=yaw_rate,torque=yaw_moment"
    found = cosim_json("run", "wheel-pair", "--swap", swap, "--vehicle", "wheelset", "--set", "gyro.spin=100rpm", *ours)
    assert found["components"] == {"vehicle": "vehicle:wheelset", "gyro": vendor}
    for words, told in (
        (("--swap", "gyros=linear"), "unknown component of system 'wheel-pair': 'gyros'; did you mean 'gyro'"),
        (("--swap", "gyro=linaer"), "unknown variant of gyro_unit 'linaer'; did you mean 'linear'"),
        (("--vehicle", "wheelst"), "unknown variant of vehicle 'wheelst'; did you mean 'wheelset'"),
        (("--swap", f"{swap},"), ""),
        (("--swap", "gyro"), "--swap must be NAME=SOURCE or NAME=SOURCE,FOREIGN=OURS,..., got 'gyro'"),
        (("--swap", "vehicle=wheelset", "--vehicle", "wheelset"), "--swap names a component once: give one of the two"),
        (("--swap", "gyro=off", "--gyro", "off"), "--swap names a component once: give one of the two"),
    ):
        code, _, err = cosim("run", "wheel-pair", *words, *ours)
        assert (code, told in err) == (2 if told else 0, True), (words, err)


def test_the_other_commands_swap_too(vendor: str, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    swap = f"gyro={vendor},omega=yaw_rate,torque=yaw_moment"
    ladder = ("--step", "4ms", "--rungs", "2", "--stop", "0.04", "--algorithm", "jacobi", "--degree", "1")
    found = cosim_json("converge", "wheel-pair", "--swap", swap, "--in-process", *ladder)
    assert len(found["algorithms"]) == 1
    twice = ("--variant", "linear", "--variant", "linear", "--in-process", "--stop", "0.02")
    found = cosim_json("compare", "wheel-pair", "--vehicle", "wheelset", *twice)
    assert [v["source"] for v in found["variants"]] == ["gyro_unit:linear"] * 2
    twice = ("--variant", "linear", "--variant", vendor, "--in-process", "--stop", "0.02")
    ours = (*twice[:3], f"{vendor},omega=yaw_rate,torque=yaw_moment,spin=1900", *twice[4:])
    code, out, _ = cosim("compare", "wheel-pair", *ours)
    assert "note: gyro.spin=1900: 1900 rad/s = 18144 rpm" in out
    code, _, err = cosim("converge", "lrt-curve", "--vehicle", "vehicle:lrt_set_b", "--swap", f"vehicle={vendor}")
    assert (code, "--swap names a component once" in err) == (2, True)
    code, _, err = cosim("pack", "lrt-curve", "--swap", f"vehicle={vendor}", "-o", "x.zip")
    assert f"cosim: note: vehicle is {vendor} now: what the system had bound for vehicle:lrt is dropped: speed = 5" in err
    found = cosim_json("delay", "wheel-pair", "--swap", swap, "--stop", "0.1", "--longest", "20ms", "--degree", "0")
    assert found["component"] == "gyro"
