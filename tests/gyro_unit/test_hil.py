"""The rig around a gyro unit: each effect alone does what it says, none of them leaves the bare unit, and the FMU agrees."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from frames import AXES, Rate, driven, ramp, sine

from gyro_cosim import Jacobi, simulate, system
from gyro_cosim.component import build, input_
from gyro_cosim.gyro_unit import hil as rig
from gyro_cosim.gyro_unit.multibody import multibody_small
from gyro_cosim.gyro_unit.noise import Stream
from gyro_cosim.gyro_unit.nonlinear import nonlinear_small
from gyro_cosim.gyro_unit.rig_parameters import OFF
from gyro_cosim.gyro_unit.twin import twin_small
from gyro_cosim.slaves import open_slave
from gyro_cosim.systems import catalogue

HERE = str(Path(__file__))
TICK = rig.TICK
YAW = {"yaw": sine(0.5, 6.0)}


def around_multibody() -> object:
    return rig.behind_rig(multibody_small(), variant="hil_multibody")


def around_twin() -> object:
    return rig.behind_rig(twin_small(), variant="hil_twin")


def run(
    rates: dict[str, Rate] = YAW, *, stop: float = 1.0, step: float = TICK, source: str = "gyro_unit:hil", **on: float
) -> dict:
    """The rig with nothing but the effects `on`."""
    return driven(source, rates, stop=stop, step=step, **{**OFF, **on})


@pytest.mark.parametrize(
    ("source", "bare", "in_process"),
    [
        ("gyro_unit:hil", "nonlinear", True),
        ("gyro_unit:hil", "nonlinear", False),
        (f"{HERE}:around_multibody", "multibody", True),
        pytest.param(f"{HERE}:around_twin", "twin", True, marks=pytest.mark.slow),
    ],
    ids=["nonlinear", "nonlinear-fmu", "multibody", "twin"],
)
def test_with_all_effects_off_the_rig_is_the_bare_unit(source: str, bare: str, in_process: bool) -> None:
    rates = {axis: sine(0.5, 3.0 + 2 * i) for i, axis in enumerate(AXES)}
    a = driven(source, rates, stop=0.5, in_process=in_process, **OFF)
    b = driven(f"gyro_unit:{bare}", rates, stop=0.5, in_process=in_process)
    for name, values in b.items():
        np.testing.assert_allclose(a[name], values, rtol=1e-13, atol=1e-16)
    np.testing.assert_array_equal(a["unit_yaw_rate"], [rates["yaw"](t)[0] for t in a["time"]])


@pytest.mark.parametrize("effect", [name for name in OFF if name != "table_rate_limit"])
def test_each_effect_alone_changes_the_moment(effect: str) -> None:
    """Its default is strong enough to be seen (the rate limit has a test of its own)."""
    start = {v.name: v.start for v in catalogue.component("gyro_unit:hil").parameters}
    value = 0.05 if effect == "dropout_rate" else start[effect]
    assert not np.array_equal(run(**{effect: value})["yaw_moment"], run()["yaw_moment"])


def test_fmu_and_component_give_the_same_numbers_with_everything_on() -> None:
    """Noise, losses and quantisation included: a counter and exact arithmetic make them."""
    plan = system("wheel-pair").with_source("gyro", "hil").with_value("gyro.dropout_rate", 0.05)
    for value in (0.7e-3, 3.3e-3):
        plan = plan.with_value("gyro.moment_delay", value)
        a, b = (simulate(plan, algorithm=Jacobi(0), stop=1.0, in_process=here).trajectory for here in (True, False))
        assert np.abs(a["gyro.yaw_moment"]).max() > 1e-3
        np.testing.assert_allclose(a.values, b.values, rtol=1e-12, atol=1e-14)


# ---- the yaw table ----------------------------------------------------------------------------------------------------


def test_table_bandwidth_is_a_first_order_lag() -> None:
    y = run({"yaw": sine(1.0, 2 * np.pi * 10)}, stop=2.0, table_bandwidth=10.0)
    late = y["time"] > 1.0
    phase = 2 * np.pi * 10 * y["time"][late]
    fit = 2 * np.mean(y["unit_yaw_rate"][late] * np.exp(-1j * phase)) * 1j  # of the sine
    assert fit == pytest.approx(1 / (1 + 1j), rel=5e-3)  # the mean is over 1000 of 1001 points of ten periods


def test_table_limits_hold() -> None:
    y = run(table_rate_limit=0.2)
    assert np.abs(y["unit_yaw_rate"]).max() == 0.2
    small = np.abs(run()["unit_yaw_rate"]) < 0.2
    np.testing.assert_array_equal(y["unit_yaw_rate"][small], run()["unit_yaw_rate"][small])
    y = run(table_acceleration_limit=1.0)
    assert np.abs(np.diff(y["unit_yaw_rate"])).max() == pytest.approx(1.0 * TICK, rel=1e-9)
    gentle = run({"yaw": sine(0.1, 2.0)}, table_acceleration_limit=1.0)
    np.testing.assert_allclose(gentle["unit_yaw_rate"], 0.1 * np.sin(2.0 * gentle["time"]), atol=2 * TICK * 0.2)  # within a tick


def test_a_table_that_only_yaws_keeps_roll_and_pitch_from_the_unit() -> None:
    tilt = {"pitch": sine(0.5, 4.0), "roll": sine(0.5, 3.0)}
    assert np.abs(run(tilt, table_tilts=0.0)["yaw_moment"]).max() == 0.0
    assert np.abs(run(tilt)["yaw_moment"]).max() > 1e-4


# ---- sensors ----------------------------------------------------------------------------------------------------------


def test_bias_and_quantisation() -> None:
    y = run({}, rate_bias=0.01, moment_bias=2e-3)
    np.testing.assert_array_equal(y["unit_yaw_rate"], 0.01)
    np.testing.assert_allclose(y["yaw_moment"], y["unit_yaw_moment"] + 2e-3, rtol=1e-15)
    y = run(rate_quantisation=0.1, moment_quantisation=1e-4)
    for name, q, true in (("unit_yaw_rate", 0.1, run()["unit_yaw_rate"]), ("yaw_moment", 1e-4, y["unit_yaw_moment"])):
        np.testing.assert_allclose(y[name] / q, np.round(y[name] / q), atol=1e-9)
        assert np.abs(y[name] - true).max() <= q / 2 * (1 + 1e-9)


def test_sensor_bandwidth_is_a_first_order_lag() -> None:
    """A ramp comes out late by the time constant."""
    y = run({"yaw": ramp(1.0)}, rate_bandwidth=10.0)
    assert y["time"][-1] - y["unit_yaw_rate"][-1] == pytest.approx(1 / (2 * np.pi * 10), rel=1e-6)


def test_sampling_holds_the_value_for_a_period() -> None:
    y = run(rate_sampling_period=5e-3)
    steps = y["unit_yaw_rate"][1:]  # at a communication point: what stood before that instant's sample
    true = run()["unit_yaw_rate"]
    for k in range(0, 1000, 5):
        np.testing.assert_array_equal(steps[k : k + 5], true[k])


@pytest.mark.parametrize(("period", "counts"), [(3e-3, {3}), (2.5e-3, {2, 3}), (0.2e-3, {1})])
def test_a_period_off_the_ticks_is_kept_in_the_mean(period: float, counts: set[int]) -> None:
    rate = run({"yaw": ramp(1.0)}, rate_sampling_period=period)["unit_yaw_rate"][1:]
    lengths = np.diff(np.flatnonzero(np.diff(rate)))
    assert set(lengths) == counts
    assert lengths.mean() * TICK == pytest.approx(max(period, TICK), rel=0.01)


def test_noise_has_the_stated_size_and_hangs_on_the_seed_alone() -> None:
    y = run({}, stop=10.0, rate_noise=0.01)["unit_yaw_rate"][1:]
    assert y.std() == pytest.approx(0.01, rel=0.03)  # 10^4 numbers: 0.7 %
    assert abs(y.mean()) < 4 * 0.01 / np.sqrt(y.size)
    np.testing.assert_array_equal(run({}, rate_noise=0.01)["unit_yaw_rate"][1:], y[:1000])
    assert abs(np.corrcoef(run({}, rate_noise=0.01, seed=2.0)["unit_yaw_rate"][1:], y[:1000])[0, 1]) < 0.13  # 4 / sqrt(1000)


def test_the_stream_is_white_uniform_and_different_in_every_channel() -> None:
    n, seed = ca.SX.sym("n"), ca.SX.sym("seed")
    a, b = Stream(seed, 0, n), Stream(seed, 1, n)
    draw = ca.Function("draw", [seed, n], [ca.vertcat(a.uniform(), b.uniform(), a.uniform(), a.normal(), b.normal())])
    count = 20000
    for start in (0.0, 1.0, 12345.0):
        v = np.array(draw(start, np.arange(count, dtype=float)[None, :]))
        assert ((v[:3] >= 0) & (v[:3] < 1)).all()
        for row in v[:3]:
            cells, _ = np.histogram(row, 20, (0, 1))
            assert ((cells - count / 20) ** 2 / (count / 20)).sum() < 52  # chi-square, 19 degrees, one in 10^4
        assert v[3].std() == pytest.approx(1.0, rel=0.03)
        assert v[3].mean() == pytest.approx(0.0, abs=4 / np.sqrt(count))
        assert np.abs(np.corrcoef(v) - np.eye(5)).max() < 4.5 / np.sqrt(count)
        for row in v:
            for lag in (1, 2, 3, 7):
                assert abs(np.corrcoef(row[lag:], row[:-lag])[0, 1]) < 4.5 / np.sqrt(count)


# ---- transport --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0.4e-3, 1e-3, 1.7e-3, 0.02, 0.0133, 0.025])
def test_an_unsampled_signal_arrives_a_delay_later(delay: float) -> None:
    """A ramp, which linear interpolation between ticks keeps exactly; also where steps end between ticks."""
    for step in (TICK, 0.7e-3):
        y = run({"yaw": ramp(1.0)}, stop=0.2, step=step, rate_delay=delay)
        late = y["time"] > delay + 1.01 * TICK
        np.testing.assert_allclose(y["unit_yaw_rate"][late], y["time"][late] - delay, atol=1e-12)
        assert np.abs(y["unit_yaw_rate"][y["time"] < delay - TICK]).max(initial=0.0) == 0.0


def test_the_moment_comes_back_a_delay_later() -> None:
    y = run(moment_delay=7e-3)
    np.testing.assert_allclose(y["yaw_moment"][7:], y["unit_yaw_moment"][:-7], rtol=1e-12, atol=1e-18)


def test_a_sampled_signal_is_delayed_by_whole_ticks_and_mixed_in_between() -> None:
    held = run(rate_sampling_period=2e-3)["unit_yaw_rate"]
    whole = run(rate_sampling_period=2e-3, rate_delay=3e-3)["unit_yaw_rate"]
    np.testing.assert_array_equal(whole[4:], held[1:-3])
    part = run(rate_sampling_period=2e-3, rate_delay=3.25e-3)["unit_yaw_rate"]
    np.testing.assert_allclose(part[5:], 0.75 * held[2:-3] + 0.25 * held[1:-4], atol=1e-15)


@pytest.mark.parametrize("sampled", [0.0, TICK])
def test_lost_samples_are_as_many_as_stated_and_hold_the_last(sampled: float) -> None:
    y = run({"yaw": ramp(1.0)}, stop=10.0, rate_sampling_period=sampled, dropout_rate=0.2)
    lag = y["time"][1:] - y["unit_yaw_rate"][1:]  # a ramp shows how old the value is; reading a sample costs a tick
    lost = lag > sampled + 0.5 * TICK
    assert lost.mean() == pytest.approx(0.2, abs=4 * np.sqrt(0.2 * 0.8 / lost.size))


# ---- wrong use --------------------------------------------------------------------------------------------------------


def stateless() -> object:
    return build(name="g", variant="v", description="no mount", equations="", variables=(input_("yaw_rate", "rad/s", "r"),),
                 model=lambda s: ({}, {}), internal_step=1e-3)  # fmt: skip


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rig.behind_rig(stateless()), "plant 'g:v' must have the input 'roll_rate'"),
        (lambda: rig.behind_rig(rig.small()), "plant 'gyro_unit:hil' must have no sampled part"),
        (lambda: rig.behind_rig(nonlinear_small(), tick=0.0), "`tick` must be positive"),
        (lambda: rig.behind_rig(nonlinear_small(), longest_delay=-1.0), "`longest_delay` must not be negative"),
    ],
)
def test_rigs_that_cannot_be_are_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gyro.rate_delay=-1ms", "gyro.rate_delay: must be at least 0 s, got -1ms"),
        ("gyro.moment_delay=26ms", "gyro.moment_delay: must be at most 0.025 s, got 26ms"),
        ("gyro.dropout_rate=1.5", "gyro.dropout_rate: must be at most 1, got 1.5"),
    ],
)
def test_delays_that_are_negative_or_beyond_the_record_are_refused(setting: str, words: str, cosim: Callable) -> None:
    code, _, err = cosim("run", "wheel-pair", "--gyro", "hil", "--set", setting, "--in-process", "--stop", "0.1")
    assert (code, err.count("\n")) == (2, 1)
    assert words in err


def test_a_longer_record_is_a_matter_of_one_argument() -> None:
    c = rig.behind_rig(nonlinear_small(), tick=2e-3, longest_delay=0.021)
    assert next(v.max for v in c.parameters if v.name == "rate_delay") == pytest.approx(0.022)
    assert c.sample_period == 2e-3


def test_a_step_repeats_its_noise_after_a_restore() -> None:
    slave = open_slave("gyro", "gyro_unit:hil", in_process=True)
    slave.initialize({}, 0.0, 1.0)
    U = np.zeros((3, 3))
    slave.step(U, 0.0, 0.01)
    snapshot = slave.save()
    slave.step(U, 0.01, 0.01)
    first = slave.output(U[0], 0.02)
    slave.restore(snapshot)
    slave.step(U, 0.01, 0.01)
    np.testing.assert_array_equal(slave.output(U[0], 0.02), first)
    slave.close()
