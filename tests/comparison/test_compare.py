"""Comparing variants: the measures are right, the verdict is computed, wrong use is one line."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from gyro_cosim import RunError, system
from gyro_cosim.comparison.candidates import _judged, compare
from gyro_cosim.comparison.difference import signal_difference, time_shift
from gyro_cosim.comparison.tolerances import Tolerances, read
from gyro_cosim.comparison.unit_energy import UnitEnergy
from gyro_cosim.comparison.variants import check_period
from gyro_cosim.component import Component, build, input_, output
from gyro_cosim.gyro_unit.nonlinear import nonlinear_small
from gyro_cosim.systems import StopWhen, catalogue

HERE = str(Path(__file__))
PLAN = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")
COMPARE = ("compare", "wheel-pair", "--in-process", "--stop", "1")


def without_mount() -> Component:
    return build(
        name="no", variant="mount", description="d", equations="",
        variables=(input_("yaw_rate", "rad/s", "rate"), output("torque", "N.m", "moment")),
        model=lambda s: ({}, {"torque": s["yaw_rate"]}), internal_step=1e-3,
    )  # fmt: skip


def bursting() -> Component:
    """The nonlinear unit, whose moment is no number any more from a gimbal angle of 0.2 rad on."""
    plain = nonlinear_small()
    x, u, p = (ca.SX.sym(n, k) for n, k in zip("xup", (2, 3, len(plain.parameters)), strict=True))
    y = plain.output(x, u, p)
    y[0] = ca.if_else(ca.fabs(x[0]) > 0.2, np.nan, y[0])
    return Component(
        name="gyro", variant="bursting", description="d", equations="", variables=plain.variables, rhs=plain.rhs,
        output=ca.Function("output", [x, u, p], [y]), internal_step=1e-3, bonds=plain.bonds,
    )  # fmt: skip


# ---- the measures -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [-0.05, -0.0037, 0.0, 0.0123, 0.2])
@pytest.mark.parametrize("start", [0.0, 1.2], ids=["from zero", "from off zero"])
def test_time_shift_is_found_between_samples(shift: float, start: float) -> None:
    t = np.arange(4001) * 0.005

    def wave(t: np.ndarray) -> np.ndarray:
        return np.exp(-0.1 * t) * np.sin(2.0 * t + start)

    found, correlation = time_shift(t, wave(t), 0.7 * wave(t - shift))
    assert found == pytest.approx(shift, abs=5e-4 + 5e-3 * abs(shift))  # a tenth of a sample; the decay pulls a little
    assert correlation > 0.999


def test_differences_are_relative_to_the_reference() -> None:
    t = np.arange(1000) * 0.01
    r = np.sin(t)
    d = signal_difference(t, r, 1.1 * r)
    assert (d.rms, d.peak, d.own_peak) == (pytest.approx(0.1), pytest.approx(0.1), pytest.approx(1.1 * d.reference_peak))
    assert d.shift == pytest.approx(0.0, abs=1e-9)
    zero = np.zeros_like(t)
    d = signal_difference(t, zero, 0.3 * r)
    assert (d.rms, d.peak) == (pytest.approx(1.0), pytest.approx(1.0))
    d = signal_difference(t, zero, zero)
    assert (d.rms, d.peak, d.shift, d.correlation) == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("in_process", [True, False], ids=["component", "fmu"])
def test_the_frequency_response_is_that_of_the_equations(in_process: bool) -> None:
    """M / psi' of the linear unit: -H^2 s / (I s^2 + c s + k)."""
    result = compare(PLAN, ["linear", "linear"], stop=0.5, in_process=in_process)
    unit = catalogue.component("gyro_unit:linear")
    v = {row.name: row.start for row in unit.parameters}
    H = v["rotor_inertia"] * 200 * 2 * np.pi / 60
    (response,) = result.candidates[0].responses
    s = 2j * np.pi * response.frequency
    exact = -(H**2) * s / (v["gimbal_inertia"] * s**2 + v["gimbal_damping"] * s + v["gimbal_stiffness"])
    error = np.abs(response.value / exact - 1)
    assert (error < 1e-5 + np.abs(s * 1e-3) ** 3 / 20).all()  # settled to exp(-12); inputs of degree 2 over 1 ms
    assert response.frequency[0] == pytest.approx(0.2)
    assert response.frequency[-1] == pytest.approx(50.0)


def test_energy_closes_for_every_variant_and_a_delay_makes_some() -> None:
    """The plain units create nothing but the coupling's error; 40 ms more of delay at 600 rpm create a good share."""
    plan = system("wheel-pair").with_value("gyro.rotor_speed", "600rpm")
    late = "hil,table_bandwidth=0,rate_delay=20ms,moment_delay=20ms"
    result = compare(plan, ["nonlinear", "linear", "multibody", "twin", late], stop=2.0, in_process=True, responses=False)
    for candidate in result.candidates[:-1]:
        (energy,) = candidate.energies
        assert energy.share is not None
        assert abs(energy.share) < 1e-4  # second order at 1 ms
        assert energy.least > -1e-12
    (energy,) = result.candidates[-1].energies
    assert energy.share is not None
    assert energy.share > 0.05
    a = result.candidates[-1].run
    assert a is not None
    power = -a.trajectory["vehicle.yaw_rate"] * a.trajectory["gyro.yaw_moment"]
    assert energy.absorbed == pytest.approx(np.trapezoid(power, a.trajectory.t))


# ---- the verdict ------------------------------------------------------------------------------------------------------


def test_a_run_that_ends_early_is_compared_as_far_as_it_goes_and_is_no_match() -> None:
    """As a vehicle does that derails without its unit."""
    whole = compare(PLAN, ["nonlinear", "off"], stop=4.0, in_process=True).candidates
    peaks = {c.label: float(np.max(c.run.trajectory["vehicle.lateral_displacement"])) for c in whole if c.run is not None}
    assert peaks["nonlinear"] > 1.1 * peaks["off"]
    signal = ("vehicle", "lateral_displacement")
    stops = replace(PLAN, stop_when=(StopWhen(signal, 1.05 * peaks["off"], "off the rails"),))
    for variants, ends in ((["nonlinear", "off"], 0), (["off", "nonlinear"], 1)):
        result = compare(stops, variants, stop=4.0, in_process=True)
        lengths = [len(c.run.trajectory) for c in result.candidates if c.run is not None]
        assert lengths[ends] < lengths[1 - ends] == 4001
        assert result.verdict is False
        words = result.candidates[1].violations[0]
        assert words.startswith("the runs must end together, ")
        assert f"nonlinear at t = {result.candidates[ends].run.trajectory.t[-1]:.9g} s (" in words
        assert "off the rails" in words


def test_a_unit_is_as_good_as_itself_and_off_is_not() -> None:
    result = compare(PLAN, ["nonlinear", "nonlinear", "off", "locked"], stop=2.0, in_process=True, responses=False)
    same, off, locked = result.candidates[1:]
    assert same.verdict
    assert same.label == "nonlinear #2"
    assert not off.verdict
    assert any(v.startswith("vehicle.yaw_angle: rms") for v in off.violations)
    assert not result.verdict
    for name, d in off.differences.items():  # without pitch a locked gimbal does as much as none
        if name.startswith("vehicle."):
            assert locked.differences[name] == d


def test_tolerances_decide(tmp_path: Path) -> None:
    file = tmp_path / "limits.toml"
    run = {"stop": 2.0, "in_process": True, "responses": False}
    kinds = [PLAN, ["nonlinear", "multibody"]]
    d = compare(*kinds, **run).candidates[1].differences["vehicle.yaw_rate"]
    for factor, expected in ((1.01, True), (0.99, False)):
        file.write_text(
            f'[signals."vehicle.*"]\n[signals."*.yaw_rate"]\nrms = {factor * d.rms}\npeak = "{factor * d.peak * 100} %"\n'
            f'shift = "{1e3 * factor * abs(d.shift)} ms"\n[energy]\ncreated = 0.01\n'
        )
        result = compare(*kinds, tolerances=read(file), **run)
        assert result.verdict is expected
        assert len(result.candidates[1].violations) == (0 if expected else 3)
    created = Tolerances({}, created=1e-12)
    (violation,) = compare(*kinds, tolerances=created, **run).candidates[1].violations
    assert violation.startswith("gyro: creates")


def test_values_go_to_the_variants_that_have_them() -> None:
    values = [("gyro.rotor_speed", "300rpm"), ("vehicle.speed", "5m/s")]
    result = compare(system("wheel-pair"), ["nonlinear", "off", "nonlinear,rotor_speed=300rpm"], values=values, stop=0.5,
                     in_process=True, responses=False)  # fmt: skip
    assert [c.ignored for c in result.candidates] == [(), ("gyro.rotor_speed",), ()]
    assert result.candidates[2].verdict
    assert result.candidates[0].run is not None
    assert dict(result.candidates[0].run.system.components[0].values)["speed"] == "5m/s"


def test_a_variant_that_fails_gets_a_no_and_the_others_their_due() -> None:
    variants = ["nonlinear", f"{HERE}:bursting", "nonlinear"]
    result = compare(PLAN, variants, stop=2.0, in_process=True, responses=False)
    burst = result.candidates[1]
    assert not burst.verdict
    assert "must be finite" in burst.failure
    assert burst.run is not None
    assert 0.1 < burst.run.trajectory.t[-1] < 2.0  # kept up to there
    assert result.candidates[2].verdict
    with pytest.raises(RunError, match=r"the reference .*bursting' failed: .*must be finite"):
        compare(PLAN, [f"{HERE}:bursting", "nonlinear"], stop=2.0, in_process=True, responses=False)


# ---- the command ------------------------------------------------------------------------------------------------------


def test_the_command_says_what_it_found(cosim: Callable[..., Any]) -> None:
    code, out, err = cosim(*COMPARE, "--gyro", "nonlinear", "--gyro", "twin", "--gyro", "off", "--plot", "c.png")
    assert (code, err) == (1, "")
    for words in ("vehicle.yaw_angle", "twin: yes", "off: no", "verdict: no", "created by the interface"):
        assert words in out
    assert Path("c.png").stat().st_size > 10000
    code, out, _ = cosim(*COMPARE, "--gyro", "nonlinear", "--gyro", "twin")
    assert code == 0
    assert "verdict: yes" in out


def test_the_document_holds_everything_and_fmu_files_take_part(cosim: Callable[..., Any]) -> None:
    cosim("export", "gyro_unit:linear", "-o", ".")
    Path("limits.toml").write_text('[signals."vehicle.yaw_angle"]\nrms = 1e-9\n')
    code, out, err = cosim(
        *COMPARE, "--gyro", "linear", "--gyro", "./gyro_unit.linear.fmu", "--tolerances", "limits.toml", "--json"
    )
    assert code == 0, err
    document = json.loads(out)
    assert document["verdict"] is True
    own = document["variants"][1]
    assert own["variant"] == "gyro_unit.linear.fmu"
    assert own["signals"]["vehicle.yaw_angle"]["rms"] < 1e-12
    assert len(own["responses"][0]["size"]) == len(own["responses"][0]["frequency_Hz"])
    assert document["tolerances"]["signals"] == {"vehicle.yaw_angle": {"rms": 1e-9}}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--gyro", "linear"), "compare needs at least two variants, got 1"),
        ((), "compare needs at least two variants, got 0"),
        (("--gyro", "linear", "--gyro", "lienar"), "did you mean 'linear'?"),
        (
            ("--gyro", "linear", "--gyro", f"{HERE}:without_mount"),
            "variant 'test_compare.py:without_mount' must have the connector",
        ),
        (("--gyro", "linear", "--gyro", "hil,rate_delay"), "must be SOURCE,PARAMETER=VALUE"),
        (("--gyro", "linear", "--gyro", "hil,rate_delay=-1ms"), "gyro.rate_delay: must be at least 0 s, got -1ms"),
        (("--gyro", "linear", "--gyro", "hil,rate_delay=1s"), "gyro.rate_delay: must be at most 0.025 s, got 1s"),
        (("--gyro", "linear", "--gyro", "hil", "--step", "0.7ms"), "must divide the macro step of 0.0007 s or be a multiple"),
        (("--gyro", "linear", "--gyro", "nonlinear", "--set", "gyro.spin=3"), "no variant has the parameter 'gyro.spin'"),
        (("--gyro", "linear", "--gyro", "nonlinear", "--set", "gyro.rotor_speed"), "--set must be COMPONENT.PARAMETER=VALUE"),
        (("--gyro", "linear", "--gyro", "nonlinear", "--component", "gear"), "unknown component of system 'wheel-pair': 'gear'"),
        (("--gyro", "linear", "--gyro", "nonlinear", "--tolerances", "none.toml"), "tolerance file 'none.toml' cannot be read"),
        (("--gyro", "linear", "--gyro", "nonlinear", "--step", "0.5"), "`step` must be at most 0.25 s for a frequency response"),
    ],
)
def test_wrong_use_is_one_line(arguments: tuple[str, ...], words: str, cosim: Callable[..., Any]) -> None:
    code, out, err = cosim(*COMPARE, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[signals."vehicle.yaw_angel"]\nrms = 0.1', "unknown signal 'vehicle.yaw_angel'; did you mean 'vehicle.yaw_angle'?"),
        ('[signals."vehicle.yaw_angle"]\nrmse = 0.1', "unknown limit 'rmse'; did you mean 'rms'?"),
        ('[signals."vehicle.yaw_angle"]\nrms = -0.1', "rms must not be negative, got -0.1"),
        ('[signals."vehicle.yaw_angle"]\nrms = "5 kg"', "rms must be a number: unit 'kg' cannot be expressed in '1'"),
        ('[signals."vehicle.yaw_angle"]\nrms = [1]', "rms must be a number"),
        ("signals = 3", "'signals' must be a table, got 3"),
        ("[signal]", "unknown table 'signal'; did you mean 'signals'?"),
        ("[signals", "must be TOML"),
    ],
)
def test_tolerance_files_that_mean_nothing_are_refused(text: str, words: str, cosim: Callable[..., Any]) -> None:
    Path("limits.toml").write_text(text)
    code, out, err = cosim(*COMPARE, "--gyro", "linear", "--gyro", "linear", "--tolerances", "limits.toml")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


@pytest.mark.parametrize(
    ("period", "fits"), [(0.0, True), (1e-3, True), (5e-3, True), (0.5e-3, True), (1.5e-3, False), (0.4e-3, False)]
)
def test_sampling_periods_fit_the_step_or_not(period: float, fits: bool) -> None:
    if fits:
        check_period("p", period, 1e-3)
    else:
        with pytest.raises(ValueError, match=r"p must divide the macro step of .* or be a multiple"):
            check_period("p", period, 1e-3)


def test_rounding_is_not_compared_with_rounding() -> None:
    """What rests in the reference, to rounding, and moves elsewhere differs by all of itself; what rests in both, by nothing."""
    t = np.arange(100) * 0.01
    noise = 1e-14 * np.sin(37 * t)
    assert signal_difference(t, noise, 2 * noise, rest=1e-9).rms == 0.0
    d = signal_difference(t, noise, np.sin(t), rest=1e-9)
    assert (d.rms, d.peak, d.reference_peak) == (pytest.approx(1.0), pytest.approx(1.0), 0.0)


def test_a_whole_system_stands_for_a_variant(tmp_path: Path) -> None:
    file = tmp_path / "pair.ssd"
    file.write_bytes(catalogue.systems()["wheel-pair"].read_bytes())
    result = compare(system("wheel-pair"), ["linear", str(file)], stop=0.5, in_process=True, responses=False)
    assert result.candidates[1].label == "pair.ssd"
    assert all(d.rms == 0.0 for d in result.candidates[1].differences.values())


# ---- a verdict needs evidence -----------------------------------------------------------------------------------------


def test_units_whose_outputs_go_nowhere_cannot_be_judged(cosim: Callable[..., Any]) -> None:
    wired = system("wheel-pair")
    loose = replace(wired, connections=wired.connections[:1], bonds=())
    result = compare(loose, ["linear", "off"], stop=0.5, in_process=True, responses=False)
    assert result.verdict is None
    assert result.candidates[1].verdict is None
    assert result.undecided == "no output of 'gyro' reaches a signal with a limit"
    limits = Tolerances({"gyro.gimbal_angle": {"rms": 0.05}})  # of the unit itself, which differ whoever listens
    assert compare(loose, ["linear", "off"], stop=0.5, in_process=True, responses=False, tolerances=limits).verdict is False
    assert compare(loose, ["linear", "linear"], stop=0.5, in_process=True, responses=False, tolerances=limits).verdict is True
    text = catalogue.systems()["wheel-pair"].read_text()
    wire = next(line for line in text.splitlines(keepends=True) if 'startConnector="yaw_moment"' in line)
    bond = next(line for line in text.splitlines(keepends=True) if "gc:Bond" in line)
    Path("loose.ssd").write_text(text.replace(wire, "").replace(bond, ""))
    code, out, err = cosim("compare", "loose.ssd", "--in-process", "--stop", "1", "--gyro", "linear", "--gyro", "off")
    assert (code, err) == (1, "")
    assert "verdict: cannot be decided: no output of 'gyro' reaches a signal with a limit" in out
    assert "off: cannot be decided" in out
    assert "yes" not in out


def test_a_run_at_rest_decides_nothing() -> None:
    still = system("wheel-pair").with_value("vehicle.yaw_angle", 0.0).with_value("vehicle.lateral_displacement", 0.0)
    result = compare(still, ["linear", "off"], stop=0.5, in_process=True, responses=False)
    assert result.verdict is None
    assert result.undecided == "no signal with a limit that 'gyro' reaches moves"


def test_what_fails_is_a_no_even_where_the_others_cannot_be_decided() -> None:
    wired = system("wheel-pair")
    loose = replace(wired, connections=wired.connections[:1], bonds=())
    result = compare(loose, ["nonlinear", f"{HERE}:bursting", "linear"], stop=2.0, in_process=True, responses=False)
    assert [c.verdict for c in result.candidates] == [True, False, None]
    assert (result.verdict, result.undecided) == (False, "")


def test_energy_that_is_nan_is_beyond_any_limit() -> None:
    energy = UnitEnergy("gyro", 1.0, 0.0, 1.0, float("nan"), np.zeros(2))
    run = compare(PLAN, ["linear", "linear"], stop=0.1, in_process=True, responses=False)
    own = replace(run.candidates[1], energies=(energy,))
    judged = _judged("gyro", run.candidates[0], own, Tolerances({"vehicle.*": {"rms": 1.0}}, created=0.5))
    assert judged.verdict is False
    assert judged.violations == ("gyro: creates nan of the energy that crosses, beyond 0.5",)
