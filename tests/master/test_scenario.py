"""Time series and scenarios: what happens by plan happens when it should, alike in every way of stepping."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim import GaussSeidel, Iterated, Jacobi, Nepce, Newton, Run, Scenario, load, simulate, system
from gyro_cosim.component import Component, build, input_, output, parameter, state
from gyro_cosim.coupling import Algorithm
from gyro_cosim.master import Options
from gyro_cosim.master.adaptive import Adaptive
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.systems import Connection, Event, InputSeries, System, SystemComponent, catalogue
from gyro_cosim.systems.courses import Course
from gyro_cosim.systems.scenario import read_scenario
from gyro_cosim.systems.series import read_inputs

PAIR = system("wheel-pair")
ALGORITHMS = [Jacobi(0), Jacobi(1), GaussSeidel(2), Nepce(1), Iterated(1), Newton(1)]
EVENTS = (
    Event(0.05, "set", "gyro.rotor_speed", "200rpm"),
    Event(0.1, "freeze", "vehicle.yaw_moment"),
    Event(0.15, "restore", "vehicle.yaw_moment"),
    Event(0.16, "ramp", "gyro.roll_rate", "1 rad/s", 0.02),
    Event(0.2, "scale", "gyro.yaw_rate", 0.5),
)


def clock() -> Component:
    """x = t."""
    return build(
        name="test", variant="clock", description="a clock", equations="", internal_step=1e-3,
        variables=[state("x", "1", "time", is_output=True)], model=lambda s: ({"x": 1}, {}),
    )  # fmt: skip


def sink() -> Component:
    """y = gain u, and the integral of u."""
    return build(
        name="test", variant="sink", description="passes on and sums up", equations="", internal_step=1e-3,
        variables=[input_("u", "1", "in", start=7.0), input_("v", "m/s", "another"), output("y", "1", "gain u"),
                   state("sum", "1", "integral of u", is_output=True), state("way", "m", "integral of v", is_output=True),
                   parameter("gain", 1.0, "1", "gain", source="test", max=10.0)],
        model=lambda s: ({"sum": s["gain"] * s["u"], "way": s["v"]}, {"y": s["gain"] * s["u"]}),
    )  # fmt: skip


CHAIN = System(
    "chain",
    (SystemComponent("clock", f"{__file__}:clock"), SystemComponent("sink", f"{__file__}:sink")),
    (Connection(("clock", "x"), ("sink", "u")),),
)


def with_events(plan: System, *events: Event, **more: Any) -> System:
    return replace(plan, scenario=Scenario(events), **more)


def series(target: str, t: list[float], values: list[float], unit: str = "") -> InputSeries:
    return InputSeries(target, unit, np.array(t), np.array(values, dtype=float))


def bits(run: Run) -> tuple[bytes, bytes]:
    return run.trajectory.t.tobytes(), run.trajectory.values.tobytes()


@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=repr)
def test_what_happens_to_a_connection_is_seen_at_its_end(algorithm: Algorithm) -> None:
    plan = with_events(
        CHAIN,
        Event(0.1, "freeze", "sink.u"), Event(0.2, "restore", "sink.u"), Event(0.3, "offset", "sink.u", 2.0),
        Event(0.4, "scale", "sink.u", "300 %"), Event(0.5, "drop", "sink.u"), Event(0.6, "override", "sink.u", -1),
    )  # fmt: skip
    run = simulate(plan, algorithm=algorithm, step=0.05, stop=0.7, in_process=True)
    y = dict(zip(run.trajectory.t.round(9), run.trajectory["sink.y"], strict=True))
    expected = [0.0, 0.05, 0.1, 0.1, 0.2, 0.25, 2.3, 2.35, 1.2, 1.35, 7.0, 7.0, -1.0, -1.0, -1.0]
    np.testing.assert_allclose([y[round(0.05 * k, 9)] for k in range(15)], expected, atol=1e-12)
    assert [one.words for one in run.happened][:2] == ["freeze sink.u at 0.1", "restore sink.u"]
    total = 0.1**2 / 2 + 0.1 * 0.1 + (0.3**2 - 0.2**2) / 2 + 0.1 * 2.35 + 0.1 * 3 * 0.45 + 0.1 * 7.0 - 0.1
    if algorithm.degree:  # with inputs that are held, the sum lags behind
        assert run.trajectory["sink.sum"][-1] == pytest.approx(total, abs=1e-12)


@pytest.mark.parametrize("algorithm", [Jacobi(1), GaussSeidel(2), Nepce(1)], ids=repr)
def test_a_scenario_gives_the_same_bits_in_every_way_of_stepping(algorithm: Algorithm) -> None:
    plan = with_events(PAIR, *EVENTS)

    def run(**how: Any) -> Run:
        return simulate(plan, algorithm=algorithm, step=1e-3, stop=0.25, **how)

    python = run(options=Options(compiled=False))
    assert bits(run(options=Options(compiled=True))) == bits(python)
    assert bits(run(before_step=lambda k: None)) == bits(python)
    assert run(in_process=True).trajectory["vehicle.yaw_angle"][-1] == pytest.approx(
        python.trajectory["vehicle.yaw_angle"][-1], rel=1e-9
    )
    quiet = simulate(PAIR, algorithm=algorithm, step=1e-3, stop=0.25)
    assert quiet.trajectory["vehicle.yaw_angle"][-1] != python.trajectory["vehicle.yaw_angle"][-1]
    np.testing.assert_array_equal(quiet.trajectory.values[:50], python.trajectory.values[:50])


@pytest.mark.parametrize("in_process", [True, False])
def test_a_resumed_run_has_the_bits_of_a_whole_one(in_process: bool, tmp_path: Path) -> None:
    """Killed while a connection is frozen, a parameter set and an open input on its way."""
    plan = with_events(PAIR, *EVENTS, Event(0.08, "ramp", "gyro.pitch_rate", "0.2 rad/s", 0.1))
    whole = simulate(plan, step=1e-3, stop=0.25, in_process=in_process)

    def kill(k: int) -> None:
        if k == 130:
            raise KeyboardInterrupt

    file = tmp_path / "c.npz"
    options = Options(checkpoint=Checkpoint(file, every=0.06))
    simulate(plan, step=1e-3, stop=0.25, in_process=in_process, options=options, before_step=kill)
    again = simulate(plan, step=1e-3, stop=0.25, in_process=in_process, options=Options(resume=Resume(file)))
    assert bits(again) == bits(whole)
    assert again.happened == whole.happened
    with pytest.raises(ValueError, match="must be of this run"):
        simulate(PAIR, step=1e-3, stop=0.25, in_process=in_process, options=Options(resume=Resume(file)))


def test_steps_that_adapt_end_at_every_jump() -> None:
    jump = series("sink.v", [0.0, 1 / 7, 1 / 7, 1.0], [1.0, 1.0, 3.0, 3.0])
    plan = with_events(CHAIN, Event(np.pi / 10, "override", "sink.u", 2.0), inputs=(jump,))
    run = simulate(plan, step=0.01, stop=0.5, in_process=True, options=Options(adaptive=Adaptive(1e-4)))
    assert {1 / 7, np.pi / 10} < set(run.trajectory.t)
    assert run.trajectory["sink.way"][-1] == pytest.approx(1 / 7 + 3 * (0.5 - 1 / 7), abs=1e-12)
    assert run.trajectory["sink.sum"][-1] == pytest.approx((np.pi / 10) ** 2 / 2 + 2 * (0.5 - np.pi / 10), abs=1e-12)


@pytest.mark.parametrize("compiled", [None, False, True])
def test_inputs_follow_a_series(compiled: bool | None) -> None:
    """Lines between the points, a jump at the next communication point, the ends kept; in units of its own."""
    given = series("sink.v", [0.1, 0.3, 0.35, 0.35, 0.6], [36.0, 72.0, 72.0, 0.0, 0.0], "km/h")
    options = {"in_process": True} if compiled is None else {"options": Options(compiled=compiled)}
    run = simulate(replace(CHAIN, inputs=(given,)), step=0.02, stop=1.0, **options)
    way = 0.1 * 10 + 0.2 * 15 + 20 * 0.06  # the jump at 0.35 s counts from 0.36 s on
    assert run.trajectory["sink.way"][-1] == pytest.approx(way, abs=1e-12)


def test_a_parameter_that_ramps_moves_in_stairs_and_stays() -> None:
    plan = with_events(CHAIN, Event(0.2, "ramp", "sink.gain", 3.0, 0.4), Event(0.8, "restore", "sink.gain"))
    run = simulate(plan, step=0.1, stop=1.0, in_process=True)
    gains = run.trajectory["sink.y"][1:] / run.trajectory["clock.x"][1:]
    np.testing.assert_allclose(gains, [1.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 1.0, 1.0, 1.0], atol=1e-12)


@pytest.mark.parametrize(("fmi", "isolate"), [("2", False), ("3", False), ("3", True)])
def test_parameters_of_fmus_change_on_the_way(fmi: str, isolate: bool, tmp_path: Path) -> None:
    (file,) = catalogue.export(f"{__file__}:sink", tmp_path, fmi=(fmi,))
    plan = System("alone", (SystemComponent("sink", str(file)),), (), scenario=Scenario((Event(0.3, "set", "gain", 4.0),)))
    run = simulate(plan, step=0.1, stop=0.6, isolate=isolate)
    np.testing.assert_allclose(run.trajectory["sink.y"], [7.0, 7.0, 7.0, 28.0, 28.0, 28.0, 28.0], atol=1e-12)
    assert run.trajectory["sink.sum"][-1] == pytest.approx(0.3 * 7 + 0.3 * 28)


def test_an_event_between_two_points_takes_effect_at_the_later_one() -> None:
    run = simulate(with_events(CHAIN, Event(0.34, "override", "sink.u", 5.0)), step=0.1, stop=0.6, in_process=True)
    np.testing.assert_allclose(run.trajectory["sink.y"], [0.0, 0.1, 0.2, 0.3, 5.0, 5.0, 5.0], atol=1e-12)
    (only,) = run.happened
    assert (only.at, round(only.since, 9)) == (0.34, 0.4)


BAD = [
    (Event(0.1, "set", "sink.gian", 1.0), "unknown input or parameter of 'sink': 'gian'; did you mean 'gain'?"),
    (Event(0.1, "set", "snik.gain", 1.0), "unknown component of system 'chain': 'snik'; did you mean 'sink'?"),
    (Event(0.1, "freeze", "clock.x"), "clock.x is an output: name the input of its connection, sink.u"),
    (Event(0.1, "freeze", "sink.v"), "sink.v is an input that nothing is connected to: use set or ramp"),
    (Event(0.1, "set", "sink.u", 1.0), "clock.x feeds sink.u: use override"),
    (Event(0.1, "set", "sink.internal_step", 1e-4), "parameter sink.internal_step must be tunable to change in a run"),
    (Event(0.1, "set", "sink.gain", 11.0), "sink.gain at t = 0.1 s must be at most 10, got 11.0"),
    (Event(0.1, "set", "sink.v", "3 kg"), "sink.v at t = 0.1 s"),
    (Event(1.5, "freeze", "sink.u"), "freeze sink.u at t = 1.5 s must lie in the run, from 0 s to before 1 s"),
    (Event(0.95, "freeze", "sink.u"), "has no effect: the next communication point is the end of the run at 1 s"),
    (Event(0.1, "scale", "sink.u", "2 m"), "scale must be by a plain number"),
]


@pytest.mark.parametrize(("event", "says"), BAD, ids=lambda x: x if isinstance(x, str) else "")
def test_events_that_cannot_be_are_refused_before_the_run(event: Event, says: str) -> None:
    with pytest.raises(ValueError, match=r"^scenario: ") as caught:
        simulate(with_events(CHAIN, event), step=0.1, stop=1.0, in_process=True)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("second", "says"),
    [
        (Event(0.3, "ramp", "sink.gain", 2.0, 0.1), "ramp at t = 0.1 s to 0.5 s and ramp at t = 0.3 s meet"),
        (Event(0.1, "set", "sink.gain", 2.0), "ramp at t = 0.1 s to 0.5 s and set at t = 0.1 s meet"),
    ],
)
def test_ramps_of_one_target_must_not_overlap(second: Event, says: str) -> None:
    plan = with_events(CHAIN, Event(0.1, "ramp", "sink.gain", 3.0, 0.4), second)
    with pytest.raises(ValueError, match=f"events of sink.gain must follow one another, {says}"):
        simulate(plan, step=0.1, stop=1.0, in_process=True)


def test_two_events_of_one_target_in_one_step_are_refused() -> None:
    plan = with_events(CHAIN, Event(0.11, "freeze", "sink.u"), Event(0.12, "restore", "sink.u"))
    with pytest.raises(ValueError, match="must not fall into the same macro step"):
        simulate(plan, step=0.1, stop=1.0, in_process=True)
    assert simulate(plan, step=0.01, stop=1.0, in_process=True).status == "done"


def test_what_drives_an_input_must_fit(tmp_path: Path) -> None:
    for given, says in (
        (series("sink.u", [0.0], [1.0]), "input sink.u must be open, clock.x is connected to it"),
        (series("sink.w", [0.0], [1.0]), "unknown input 'sink.w'; did you mean 'sink.v'?"),
        (series("sink.v", [0.0], [1.0], "kg"), "unit 'kg' cannot be expressed in 'm/s'"),
        (series("sink.v", [0.0], [1.0], "cubits"), "must be in a unit that is known"),
    ):
        with pytest.raises(ValueError, match=r"^input series: ") as caught:
            simulate(replace(CHAIN, inputs=(given,)), step=0.1, stop=1.0, in_process=True)
        assert says in str(caught.value)


def test_an_input_file_is_read_as_it_stands(tmp_path: Path) -> None:
    file = tmp_path / "u.csv"
    file.write_bytes(b'\xef\xbb\xbf"time [ms]"; sink.v [km/h] ;"y[1,2]";on\n0;36;1;true\n500;72;2;false\n')
    first, second, third = read_inputs(file)
    assert (first.target, first.unit, first.t.tolist()) == ("sink.v", "km/h", [0.0, 0.5])
    assert (second.target, second.unit, second.values.tolist()) == ("y[1,2]", "", [1.0, 2.0])
    assert third.values.tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "must begin with a column 'time', got ''"),
        ("t,u\n0,1\n", "must begin with a column 'time', got 't,u'"),
        ("time\n0\n", "must have a column for an input besides time"),
        ("time,u\n", "must have a row of numbers at least"),
        ("time,u,u\n0,1,2\n", "columns must differ, got 'u' twice"),
        ("time,u\n0,1\n1,x\n", "line 3 must hold numbers, got '1,x'"),
        ("time,u\n0,1\n1,2,3\n", "line 3 must have 2 numbers as the one before, got 3"),
        ("time,u\n1,1\n0,2\n", "time must never fall, got 1 s and then 0 s"),
        ("time,u\n0,nan\n", "u must be finite, got nan in row 1"),
        ("time [kg],u\n0,1\n", "time must be in a unit of time, got 'kg'"),
    ],
)
def test_an_input_file_that_is_wrong_is_refused(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "u.csv").write_text(text)
    with pytest.raises(ValueError, match=r"^input file '.*u.csv'") as caught:
        read_inputs(tmp_path / "u.csv")
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "must hold an [[event]] at least"),
        ("[[evnt]]\n", "unknown key 'evnt'; did you mean 'event'?"),
        ("[[event]]\nat = 1\n", "event 1 must do one of set, ramp"),
        ("[[event]]\nset = 'a.b'\nto = 1\n", "event 1 must say `at` which time"),
        ("[[event]]\nat = 1\nsat = 'a.b'\n", "unknown key 'sat'; did you mean"),
        ("[[event]]\nat = 1\nset = 'a.b'\n", "set a.b at t = 1 s must say `to` which value"),
        ("[[event]]\nat = 1\nset = 'a.b'\nby = 1\n", "set takes `to`, got 'by'"),
        ("[[event]]\nat = 1\nfreeze = 'a.b'\nto = 1\n", "freeze takes no value"),
        ("[[event]]\nat = '1 kg'\nfreeze = 'a.b'\n", "event 1: at"),
        ("[[event]]\nat = 1\nramp = 'a.b'\nto = 1\n", "must take a positive time"),
        ("[[event]]\nat = 1\nset = 'a.b'\nto = 1\nover = 2\n", "only a ramp has `over`"),
        ("[[event]\n", "must be TOML"),
    ],
)
def test_a_scenario_that_is_wrong_is_refused(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(ValueError, match=r"^scenario '.*s.toml'") as caught:
        read_scenario(tmp_path / "s.toml")
    assert says in str(caught.value)


def test_a_course_is_continuous_from_the_right_and_meets_points_that_rounding_misses() -> None:
    stairs = Course.through([0.0, 0.1, 0.2, 0.3], [0.0, 1.0, 2.0, 2.0], held=True)
    assert [stairs.at(t) for t in (-1.0, 0.05, 0.1, 0.1 + 0.1, 3 * 0.1, 9.0)] == [0.0, 0.0, 1.0, 2.0, 2.0, 2.0]
    assert stairs.over(0.05, 0.1) == (0.0, 0.0)
    assert (stairs.jumps, stairs.still_until(0.1)) == ((0.1, 0.2), 0.2)
    line = Course.through([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 5.0, 6.0], held=False)
    assert line.over(0.5, 1.0) == (0.5, 1.0)  # without the jump inside
    assert line.over(1.0, 0.5) == (5.0, 1.0)
    assert (line.still_until(0.5), line.still_until(2.0)) == (0.5, float("inf"))


def test_the_order_is_kept_across_an_event() -> None:
    """Nothing is extrapolated over a jump: halving the step divides the error by 2^(degree + 1)."""
    plan = with_events(oscillators.pair(), Event(0.5, "override", "right.position", 0.3), Event(1.0, "restore", "right.position"))

    def end(step: float) -> float:
        run = simulate(plan, algorithm=Jacobi(1), step=step, stop=2.0, in_process=True)
        return float(run.trajectory["left.position"][-1])

    exact = end(5e-4)
    errors = [abs(end(h) - exact) for h in (0.005, 0.0025)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


FAILS = '[[event]]\nat = 0.05\noverride = "vehicle.yaw_moment"\nto = "50 N.m"\n'


def test_the_same_happens_in_every_run_of_a_comparison(cosim: Any) -> None:
    Path("s.toml").write_text(FAILS)
    pair = ("wheel-pair", "--stop", "0.1", "--in-process", "--gyro", "linear", "--gyro", "linear,rotor_speed=200rpm")
    quiet = cosim("compare", *pair, "--json")[1]
    told = cosim("compare", *pair, "--scenario", "s.toml", "--json")[1]
    exchanged = [[v["energy"][0]["exchanged_J"] for v in json.loads(text)["variants"]] for text in (quiet, told)]
    assert all(abs(after) > 1.5 * abs(before) for before, after in zip(*exchanged, strict=True))
    code, _, err = cosim("compare", *pair, "--model-exchange", "gyro")
    assert (code, err[:60]) == (2, "cosim: --model-exchange must name a component that stays, 'g")


@pytest.mark.slow
def test_a_sweep_s_file_is_of_its_scenario_and_says_so(cosim_json: Any, cosim: Any) -> None:
    Path("s.toml").write_text(FAILS)
    sweep = (
        "sweep",
        "wheel-pair",
        "--stop",
        "0.1",
        "--set",
        "gyro.rotor_speed=100rpm,200rpm",
        "--workers",
        "1",
        "--output",
        "w.csv",
    )
    cosim_json(*sweep)
    before = load(Path("w.csv"))
    code, _, err = cosim(*sweep, "--scenario", "s.toml")
    assert (code, err) == (2, "cosim: 'w.csv' holds another sweep, which differs in scenario; give another file\n")
    cosim_json(*sweep[:-1], "v.csv", "--scenario", "s.toml")
    name = "vehicle.yaw_rate.end"
    assert np.all(np.abs(load(Path("v.csv"))[name] - before[name]) > 1e-3)


def test_what_knows_nothing_of_scenarios_refuses_them(tmp_path: Path) -> None:
    from gyro_cosim.accuracy.monolith import Monolith
    from gyro_cosim.export import pack_fmu
    from gyro_cosim.ssp.packing import pack

    plan = with_events(CHAIN, Event(0.1, "freeze", "sink.u"))
    for call in (lambda: Monolith(plan), lambda: pack(plan, tmp_path / "s.ssp"), lambda: pack_fmu(plan, tmp_path)):
        with pytest.raises(ValueError, match="must be of a system that runs by itself, 'chain' has a scenario"):
            call()
