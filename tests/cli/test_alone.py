"""One FMU alone, a system in TOML, inputs and scenarios from files, comparison with a reference: from the prompt."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest
import small_fmus

from gyro_cosim import read_csv, simulate, system
from gyro_cosim.comparison.reference import Band, judged
from gyro_cosim.trajectory import Trajectory

MIXED = ("run", "mixed.fmu", "--stop", "1", "--step", "0.1")
PAIR = """
name = "pair"
step = "10 ms"
stop = "0.5 s"
connections = [
    "left.position -> right.position",
    { from = "left.velocity", to = "right.velocity", factor = 1 },
    "right.force -> left.force",
]
[components.left]
source = "oscillators.py:left"
parameters = { stiffness = "0.05 kN/m" }
[components.right]
source = "oscillators.py:right"
[[stop_when]]
signal = "left.velocity"
above = 1e9
"""


@pytest.fixture
def mixed(tmp_path: Path) -> Path:
    return small_fmus.mixed(tmp_path, unit_in="m", unit_out="m")


def test_one_fmu_follows_a_csv(cosim: Callable[..., Any], mixed: Path) -> None:
    """A continuous input in lines and in its unit, discrete ones held, a start value by --set, all without a component's name."""
    Path("u.csv").write_text("time,u [km],add,mode,on\n0,0,1,1,true\n0.5,1,3,5,false\n1,2,3,5,false\n")
    code, _, err = cosim(*MIXED, "--input", "u.csv", "--set", "gain=3", "--output", "r.csv", "--plot", "r.png")
    assert code == 0, err
    results = read_csv("r.csv")
    assert results.names == tuple(f"mixed.{name}" for name in ("y", "count", "mode_out", "on_out"))
    np.testing.assert_array_equal(results["mixed.mode_out"], [0.0] + [1.0] * 5 + [5.0] * 5)
    np.testing.assert_array_equal(results["mixed.on_out"], [0.0] + [1.0] * 5 + [0.0] * 5)
    # it holds its inputs, so it is given their means
    np.testing.assert_allclose(results["mixed.y"][1:], 3 * 2000 * (np.arange(10) + 0.5) * 0.1, atol=1e-9)
    assert Path("r.png").is_file()
    code, _, err = cosim(*MIXED, "--input", "u.csv", "--set", "gian=3")
    assert (code, err) == (2, "cosim: unknown parameter of 'mixed': 'gian'; did you mean 'gain'?\n")


def test_one_fmu_takes_span_and_step_from_its_default_experiment(tmp_path: Path) -> None:
    plan = system(str(small_fmus.ball(tmp_path)))
    assert (plan.start, plan.stop, plan.step) == (0.0, 1.0, 1e-3)
    assert plan.notes == ("ball states no step size, which is 0.001 s where nobody gives one (--step)",)
    experiment = '<DefaultExperiment startTime="1" stopTime="4" stepSize="0.01"/><ModelVariables>'
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(small_fmus, "BALL", small_fmus.BALL.replace("<ModelVariables>", experiment))
        plan = system(str(small_fmus.ball(tmp_path)))
    assert (plan.start, plan.stop, plan.step, plan.notes) == (1.0, 4.0, 0.01, ())


def test_a_run_is_compared_with_a_reference(cosim: Callable[..., Any], mixed: Path) -> None:
    Path("u.csv").write_text("time,u\n0,0\n1,2\n")
    given = (*MIXED, "--input", "u.csv")
    assert cosim(*given, "--output", "r.csv")[0] == 0
    rows = Path("r.csv").read_text().replace("mixed.", "")
    Path("ref.csv").write_text(rows)
    code, out, _ = cosim(*given, "--reference", "ref.csv")
    assert code == 0
    assert "agrees with ref.csv within 0.001 of the largest value (4 signals from t = 0 s to 1 s)? yes" in out
    code, out, _ = cosim(*given, "--set", "gain=2.01", "--reference", "ref.csv", "--json")
    told = json.loads(out)["reference"]
    assert (code, told["verdict"]) == (1, False)
    assert told["signals"]["mixed.y"]["distance"] == pytest.approx(0.005, rel=1e-6)
    assert not told["signals"]["mixed.y"]["inside"]
    assert cosim(*given, "--set", "gain=2.01", "--reference", "ref.csv", "--tolerance-band", "1 %")[0] == 0
    Path("still.csv").write_text("time,on_out\n0.1,1\n1,1\n")
    code, out, _ = cosim(*given, "--reference", "still.csv")
    assert code == 1
    assert "cannot be decided: no signal in common moves" in out


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--tolerance-band", "1"), "--tolerance-band has no effect without --reference"),
        (("--reference", "gone.csv"), "reference 'gone.csv' cannot be read"),
        (("--reference", "other.csv"), "unknown signal 'mixed.yy'; did you mean 'mixed.y'?"),
        (("--reference", "other.csv", "--tolerance-band", "0"), "--tolerance-band a band must have a positive share"),
        (("--input", "other.csv"), "input file 'other.csv': unknown input 'mixed.yy'"),
        (("--scenario", "other.toml"), "scenario 'other.toml' cannot be read"),
    ],
)
def test_files_that_do_not_fit_are_one_line(options: tuple[str, ...], says: str, cosim: Callable[..., Any], mixed: Path) -> None:
    Path("other.csv").write_text("time,yy\n0,0\n1,2\n")
    code, _, err = cosim(*MIXED, *options)
    assert (code, err.count("\n")) == (2, 1)
    assert says in err


def test_a_band_may_be_wide_in_time() -> None:
    t = np.linspace(0.0, 1.0, 101)
    late = Trajectory(t, ("a.y",), ("1",), (t >= 0.5)[:, None].astype(float))
    reference = {"a.y": (t, (t >= 0.48).astype(float), "")}
    assert judged(late, reference, Band(1e-3)).verdict is False
    assert judged(late, reference, Band(1e-3, 0.02)).verdict is True
    assert judged(late, reference, Band(1e-3, 0.005)).verdict is False
    jump = {"a.y": (np.array([0.0, 0.5, 0.5, 1.0]), np.array([0.0, 0.0, 1.0, 1.0]), "")}
    assert judged(late, jump, Band(1e-3)).verdict is True  # either side of a jump
    assert judged(late, {"a.y": (t + 5.0, t, "")}, Band()).undecided.endswith("less than two times in common")
    nan = Trajectory(t, ("a.y",), ("1",), np.full((101, 1), np.nan))
    assert judged(nan, reference, Band(1.0)).verdict is False


def test_a_system_in_toml_is_run_and_packed(cosim: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "pair.toml").write_text(PAIR)
    (tmp_path / "oscillators.py").write_text(Path(oscillators.HERE).read_text())
    code, _, err = cosim("run", "pair.toml", "--in-process", "--output", "r.csv")
    assert code == 0, err
    expected = simulate(oscillators.pair().with_value("left.stiffness", 50.0), step=0.01, stop=0.5, in_process=True)
    np.testing.assert_array_equal(read_csv("r.csv").values, expected.trajectory.values)
    assert cosim("pack", "pair.toml")[0] == 0
    packed = system("pair.ssp")
    assert (packed.step, packed.stop) == (0.01, 0.5)
    assert {(c.start, c.end) for c in packed.connections} == {(c.start, c.end) for c in oscillators.pair().connections}


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("step =", "steps =", "unknown key 'steps'; did you mean 'step'?"),
        ("left.position -> right", "left.position -> rihgt", "unknown component 'rihgt'; did you mean 'right'?"),
        ("left.position -> right.position", "left.position, right.position", "must be 'COMPONENT.OUTPUT -> COMPONENT.INPUT'"),
        ("source =", "sources =", "component 'left': unknown key 'sources'; did you mean 'source'?"),
        ("10 ms", "10 kg", "step unit 'kg' cannot be expressed in 's'"),
        ("factor = 1", "factor = '1'", "factor of left.velocity -> right.velocity must be a number, got '1'"),
        ("above = 1e9", "above = 'x'", "above of stop_when left.velocity must be a number"),
        ("name =", "name", "must be TOML"),
    ],
)
def test_a_system_in_toml_that_is_wrong_is_refused(before: str, after: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "pair.toml").write_text(PAIR.replace(before, after, 1))
    with pytest.raises(ValueError, match=r"^system file '.*pair.toml'") as caught:
        system(str(tmp_path / "pair.toml"))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_scenario_is_in_the_summary_and_in_json(cosim: Callable[..., Any]) -> None:
    Path("s.toml").write_text(
        '[[event]]\nat = "0.0954 s"\nset = "gyro.rotor_speed"\nto = "200rpm"\n'
        '[[event]]\nat = 0.2\nfreeze = "vehicle.yaw_moment"\n[[event]]\nat = 0.3\nrestore = "vehicle.yaw_moment"\n'
    )
    run = ("run", "wheel-pair", "--in-process", "--stop", "0.4", "--scenario", "s.toml")
    code, out, err = cosim(*run)
    assert code == 0, err
    assert "t = 0.0954 s: set gyro.rotor_speed to 200rpm (from t = 0.096 s on)\n" in out
    assert "t = 0.3 s: restore vehicle.yaw_moment\n" in out
    assert "DO NOT TRUST" not in out
    told = json.loads(cosim(*run, "--json")[1])["scenario"]
    assert [event["event"].split(" at ")[0] for event in told] == [
        "set gyro.rotor_speed to 200rpm", "freeze vehicle.yaw_moment", "restore vehicle.yaw_moment",
    ]  # fmt: skip
    assert (told[0]["at"], round(told[0]["since"], 9)) == (0.0954, 0.096)


def test_a_tolerance_says_what_it_means(cosim: Callable[..., Any]) -> None:
    code, out, _ = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--adaptive", "1e-3")
    assert code == 0
    assert "tolerance 0.001: of each macro step, its own estimated error in every coupled output" in out
