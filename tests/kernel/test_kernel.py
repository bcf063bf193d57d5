"""The inner loop: one source, run by Python or compiled, and the plain path: the same bits from all three."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest
import small_fmus

from gyro_cosim import GaussSeidel, Jacobi, Run, SlaveError, System, fmus, simulate, system
from gyro_cosim.coupling import Algorithm, Nepce
from gyro_cosim.kernel import driver, native
from gyro_cosim.master import Options, open_network
from gyro_cosim.systems import Connection, SystemComponent, catalogue, machine_code

ALGORITHMS = [
    *(Jacobi(k) for k in range(3)),
    *(Nepce(k) for k in range(3)),
    *(GaussSeidel(k) for k in range(3)),
    GaussSeidel(1, ("right", "left")),
]
WAYS = ((lambda *_: False, False), (driver.fits, False), (driver.fits, True))  # plain, inner loop as Python runs it, compiled


def three_ways(plan: System, algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch, step: float, stop: float) -> list[Run]:
    """The same run by the plain path, the inner loop in Python, and the inner loop compiled."""
    runs = []
    for fits, compiled in WAYS:
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            runs.append(simulate(plan, algorithm=algorithm, step=step, stop=stop, options=Options(compiled=compiled)))
    return runs


@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=repr)
def test_plain_path_and_both_inner_loops_give_the_same_bits(algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the oscillators, whose force feeds through; 5.003 s are no multiple of the step, and more than one chunk of steps."""
    assert isinstance(native.kernel(), native.Kernel)
    runs = three_ways(oscillators.pair(cubic=3.0), algorithm, monkeypatch, 1e-3, 5.0003)
    for other in runs[1:]:
        np.testing.assert_array_equal(other.trajectory.t, runs[0].trajectory.t)
        np.testing.assert_array_equal(other.trajectory.values, runs[0].trajectory.values)
        assert other.steps == runs[0].steps == 5001
        (a,), (b,) = runs[0].energy, other.energy
        assert b == a


def test_units_are_converted_in_the_inner_loop_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every connection gets a factor and an offset: same bits, and neither forgotten."""
    from gyro_cosim.network import network
    from gyro_cosim.network.joining import Transfer

    plain = network.transfer
    monkeypatch.setattr(network, "transfer", lambda *a: Transfer(plain(*a).factor / 3, plain(*a).offset + 0.1))
    runs = three_ways(oscillators.pair(), Jacobi(2), monkeypatch, 1e-3, 0.5)
    for other in runs[1:]:
        np.testing.assert_array_equal(other.trajectory.values, runs[0].trajectory.values)
    monkeypatch.undo()
    assert not np.array_equal(simulate(oscillators.pair(), algorithm=Jacobi(2), step=1e-3, stop=0.5).trajectory.values,
                              runs[0].trajectory.values)  # fmt: skip


def test_the_compiled_meter_sums_what_the_plain_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of different history, a shorter last one, any factor and offset between units: the same sums to the last bit."""
    from gyro_cosim.network import network
    from gyro_cosim.network.joining import Transfer

    plain = network.transfer
    monkeypatch.setattr(network, "transfer", lambda *a: Transfer(plain(*a).factor / 3, plain(*a).offset + 0.1))
    plan = system("wheel-pair").with_source("gyro", "nonlinear")
    python, compiled = (
        simulate(plan, algorithm=GaussSeidel(1), step=7e-3, stop=40.0, options=Options(compiled=way)).energy[0]
        for way in (False, True)
    )
    assert python == compiled
    assert compiled.residual != 0.0


@pytest.mark.parametrize("compiled", [True, False])
def test_a_failing_fmu_stops_the_inner_loop_at_the_last_good_point(compiled: bool) -> None:
    broken = System(
        "s", (SystemComponent("clock", f"{oscillators.HERE}:fails"), SystemComponent("left", f"{oscillators.HERE}:left")), ()
    )
    with pytest.raises(SlaveError, match=r"component 'clock' failed at t = 0\.5") as caught:
        simulate(broken, step=0.01, stop=1.0, options=Options(compiled=compiled))
    partial = caught.value.partial
    assert partial.trajectory.t[-1] == pytest.approx(0.55, abs=0.011)
    np.testing.assert_allclose(partial.trajectory["clock.reading"], partial.trajectory.t, atol=1e-11)


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(2), GaussSeidel(0), GaussSeidel(1)], ids=repr)
@pytest.mark.parametrize(
    ("kind", "into"), [("fails", ()), ("failing_force", ("left", "force")), ("failing_position", ("right", "position"))],
    ids=["nowhere", "held", "fed through"],
)  # fmt: skip
def test_an_output_that_is_no_number_stops_all_paths_alike(
    kind: str, into: tuple[str, str], algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether it is connected or not, to what feeds it through or not: the same error, the same results before it."""
    parts = tuple(SystemComponent(name, f"{oscillators.HERE}:{of}") for name, of in
                  (("clock", kind), ("left", "left"), ("right", "right")))  # fmt: skip
    wires = tuple(Connection(("clock", "reading"), into) for _ in (into,) if into)
    said, values = [], []
    for fits, compiled in WAYS:
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            with pytest.raises(
                SlaveError, match=r"'clock' failed at t = 0\.55 s: output 'reading' must be finite, got nan"
            ) as caught:
                simulate(System("s", parts, wires), algorithm=algorithm, step=0.01, stop=1.0, options=Options(compiled=compiled))
        said.append((caught.value.slave, caught.value.t, caught.value.reason))
        values.append(caught.value.partial.trajectory.values)
    assert said[0] == said[1] == said[2]
    assert len(values[0]) == 55  # to t = 0.54 s
    np.testing.assert_array_equal(values[1], values[0])
    np.testing.assert_array_equal(values[2], values[0])


def test_a_connected_input_never_goes_back_to_its_start_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """The inverse would be infinite there. Its other input, which nobody connects, keeps what it was given."""
    clock = SystemComponent("clock", f"{oscillators.HERE}:fails", {"clock": 0.5, "breaks_at": 10.0})
    plan = System("s", (clock, SystemComponent("one", f"{oscillators.HERE}:inverse", {"u": 0.0, "v": 3.0})),
                  (Connection(("clock", "reading"), ("one", "u")),))  # fmt: skip
    for run in three_ways(plan, Jacobi(1), monkeypatch, 1e-2, 1.0):
        np.testing.assert_allclose(run.trajectory["one.y"], 1 / run.trajectory["clock.reading"] + 3.0, rtol=1e-12)


def test_time_inside_the_components_is_reported() -> None:
    run = simulate(system("wheel-pair"), step=1e-3, stop=5.0, options=Options(compiled=True))
    assert set(run.timing.do_step_s) == {"vehicle", "gyro"}
    assert all(0.0 < s < run.timing.loop_s for s in run.timing.do_step_s.values())


@pytest.fixture(scope="module")
def pair_3(tmp_path_factory: pytest.TempPathFactory) -> System:
    """The oscillators as FMI 3.0 FMUs."""
    plan, folder = oscillators.pair(cubic=3.0), tmp_path_factory.mktemp("fmi3")
    for part in plan.components:
        (file,) = fmus.export(catalogue.component(part.source), folder, fmi=("3",))
        plan = plan.with_source(part.name, str(file))
    return plan


@pytest.mark.parametrize("algorithm", [Jacobi(0), GaussSeidel(0), Jacobi(1)], ids=repr)
def test_fmi_3_runs_in_the_inner_loop_too(algorithm: Algorithm, pair_3: System, monkeypatch: pytest.MonkeyPatch) -> None:
    """With held inputs; these FMUs ask for inputs of higher degree within the step, which is the plain path's business."""
    with open_network(pair_3) as network:
        network.initialize(0.0, 1.0)
        assert driver.fits(network, algorithm) == (algorithm.degree == 0)
    runs = three_ways(pair_3, algorithm, monkeypatch, 1e-3, 5.0003)
    for other in runs[1:]:
        np.testing.assert_array_equal(other.trajectory.values, runs[0].trajectory.values)
    second = simulate(oscillators.pair(cubic=3.0), algorithm=algorithm, step=1e-3, stop=5.0003)
    np.testing.assert_allclose(runs[0].trajectory.values, second.trajectory.values, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("values", "events"),
    [({}, 4), ({"period": 0.113}, 4 + 17), ({"last": 3}, 3), ({"stubborn": 1}, None), ({}, 0)],
    ids=["impacts", "ticks too", "the third is the last", "the same again and again", "by itself"],
)
def test_events_interrupt_the_inner_loop_where_they_are(
    values: dict[str, float], events: int | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """State and time events, an FMU that ends the run, and two that never settle: the same on all paths."""
    ball = small_fmus.ball(tmp_path, events=events != 0, smooth=True)
    plan = System("s", (SystemComponent("ball", str(ball), values),), ())
    with open_network(plan) as network:
        network.initialize(0.0, 1.0)
        assert driver.fits(network, Jacobi(1))
    found = []
    for fits, compiled in WAYS:
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            try:
                done, said = simulate(plan, step=0.01, stop=2.0, options=Options(compiled=compiled)), ""
            except SlaveError as error:
                done, said = error.partial, str(error)
            found.append((done.status, done.ended_by, done.events, said))
            if len(found) == 1:
                first = done
            np.testing.assert_array_equal(done.trajectory.values, first.trajectory.values)
    assert found[0] == found[1] == found[2]
    assert bool(found[0][3]) == (events is None)
    assert sum(first.events.values()) == events or events is None


def test_a_thousand_fmus_run() -> None:
    """Five hundred uncoupled pairs give what one gives."""
    pair = oscillators.pair()
    parts, wires = [], []
    for m in range(500):
        parts += [SystemComponent(f"{p.name}{m}", p.source, p.values) for p in pair.components]
        wires += [Connection((f"{a}{m}", x), (f"{b}{m}", y)) for (a, x), (b, y) in ((c.start, c.end) for c in pair.connections)]
    many = simulate(System("many", tuple(parts), tuple(wires)), step=1e-2, stop=0.2).trajectory
    one = simulate(pair, step=1e-2, stop=0.2).trajectory
    assert len(many.names) == 500 * len(one.names)
    np.testing.assert_array_equal(many.values, np.tile(one.values, 500))


@pytest.fixture
def no_kernel_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A cache that holds our FMUs and no kernel."""
    catalogue.fmu("gyro_unit:linear"), catalogue.fmu("vehicle:wheel_pair")
    cache = tmp_path / "cache"
    cache.mkdir()
    (cache / "fmu").symlink_to(catalogue.cache_folder())
    monkeypatch.setenv("GYRO_COSIM_CACHE", str(cache))
    for function in (native.kernel, native._file):
        function.cache_clear()
    yield cache
    for function in (native.kernel, native._file):
        function.cache_clear()


def test_the_kernel_is_compiled_once_and_kept(no_kernel_yet: Path) -> None:
    assert not native.cached()
    simulate(system("wheel-pair"), step=1e-3, stop=0.1)
    assert not native.cached()  # too short a run to pay
    simulate(system("wheel-pair"), step=1e-3, stop=8.0)
    assert native.cached()
    (kept,) = (no_kernel_yet / "kernel").iterdir()
    before = kept.stat().st_mtime_ns
    native.kernel.cache_clear()
    assert isinstance(native.kernel(), native.Kernel)
    assert kept.stat().st_mtime_ns == before


def test_a_spoilt_kernel_is_compiled_anew(no_kernel_yet: Path) -> None:
    file = native._file()
    file.parent.mkdir()
    file.write_bytes(b"not a library")
    assert isinstance(native.kernel(), native.Kernel)


@pytest.mark.parametrize("how", ["no compiler", "no place"])
def test_without_a_kernel_the_plain_loop_runs_and_the_summary_says_so(
    how: str, no_kernel_yet: Path, monkeypatch: pytest.MonkeyPatch, cosim: Callable[..., Any]
) -> None:
    if how == "no compiler":

        def refuse(*_: object) -> bytes:
            raise fmus.compiler.CompilerError("the C compiler for this machine cannot be run: none")

        monkeypatch.setattr(machine_code, "compiled", refuse)
    else:
        (no_kernel_yet / "kernel").write_text("a file where a folder should be")
    code, out, _ = cosim("run", "wheel-pair", "--stop", "8")
    assert code == 0
    (line,) = (line for line in out.splitlines() if "compiled kernel" in line)
    assert line.startswith("the inner loop ran in Python, without its compiled kernel: "), line
    assert ("the C compiler for this machine cannot be run" if how == "no compiler" else "File exists") in line
