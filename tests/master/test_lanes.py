"""Runs in lanes: the bits, the messages and the ends that each run has alone, whoever runs beside it."""

import re
import threading
import time
import zipfile
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

from gyro_cosim import fmus, system
from gyro_cosim.component import Component, build, input_, parameter, state
from gyro_cosim.coupling import Algorithm, GaussSeidel, Jacobi, Nepce
from gyro_cosim.errors import RunError
from gyro_cosim.kernel import native
from gyro_cosim.master import Options, Run, open_network, run, side_by_side
from gyro_cosim.master.lanes import Job, Lanes, lane_codes
from gyro_cosim.master.recording import Recording
from gyro_cosim.network import Network
from gyro_cosim.slaves.fmi.lanes import lane_code, widest
from gyro_cosim.sweeps import Sweep
from gyro_cosim.sweeps.crew import Crew
from gyro_cosim.sweeps.pool import SweepTask
from gyro_cosim.systems import Connection, StopWhen, System, SystemComponent

WIDTHS = [pytest.param(w, marks=pytest.mark.skipif(w > widest(), reason="this processor has no such lanes")) for w in (2, 4, 8)]
Task = tuple[System, Algorithm, float, float]


def swing(name: str) -> Component:
    """A pendulum that is torn at a large angle: sqrt then has no value; slow ones are stepped in as many parts as they need."""
    return build(
        name=name, variant="swing", description="a pendulum", equations="", internal_step=1e-2,
        variables=(
            input_("push", "rad", "angle of the other, which pushes"), state("angle", "rad", "angle", start=0.1, is_output=True),
            state("rate", "rad/s", "rate", is_output=True), parameter("stiffness", 20.0, "1/s2", "of gravity", source="test"),
            parameter("limit", 50.0, "rad", "where it is torn", source="test"),
        ),
        model=lambda s: ({
            "angle": s["rate"],
            "rate": s["push"] - s["stiffness"] * ca.sin(s["angle"]) + 1e-9 * ca.sqrt(s["limit"] - ca.fabs(s["angle"])),
        }, {}),
        longest_step=lambda s: 0.04 / ca.sqrt(s["stiffness"]),
    )  # fmt: skip


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> System:
    """Two pendulums, each pushed by the other's angle."""
    folder = tmp_path_factory.mktemp("lanes")
    parts = tuple(SystemComponent(n, str(fmus.export(swing(n), folder)[0])) for n in ("left", "right"))
    wires = tuple(Connection((a, "angle"), (b, "push")) for a, b in (("left", "right"), ("right", "left")))
    stop = StopWhen(("left", "angle"), above=3.0, says="fell over")
    return System("pair", parts, wires, step=1e-2, stop=3.0, stop_when=(stop,))


def tasks(pair: System) -> list[Task]:
    """Runs of which no two are alike; of one the left pendulum is torn, another one falls over."""
    of: list[Task] = []
    algorithms = [Jacobi(0), Jacobi(1), Jacobi(2), Nepce(0), Nepce(1)]
    for k in range(13):
        plan = pair.with_value("left.stiffness", 5.0 + 40.0 * k).with_value("right.angle", 0.05 * k)
        if k == 4:
            plan = plan.with_value("left.limit", 0.15).with_value("left.rate", 2.0)
        if k == 7:
            plan = plan.with_value("left.rate", 60.0)
        if k == 9:
            plan = plan.with_value("right.internal_step", 3e-3)
        if k == 10:
            plan = plan.with_value("left.stiffness", 5.0).with_value("left.tolerance", 1e-6)  # error control: not in a lane
        of.append((plan, algorithms[k % 5], (1e-2, 7e-3)[k % 2], 1.0 + 0.1 * k))
    return of


def told(result: Run | Exception) -> tuple[Any, ...]:
    """All of a run that must not depend on who runs beside it."""
    if isinstance(result, RunError):
        assert result.partial is not None
        return str(result), *told(result.partial)
    assert isinstance(result, Run)
    energy = [(bond.residual, bond.exchanged) for bond in result.energy]
    return result.status, result.ended_by, result.steps, result.trajectory.t.tobytes(), result.trajectory.values.tobytes(), energy


def alone(network: Network, algorithm: Algorithm, step: float, stop: float, options: Options | None = None) -> Run | Exception:
    try:
        return run(network, algorithm, step, stop, options=options)
    except RunError as error:
        return error


def in_lanes(of: list[Task], width: int, options: Options | None = None) -> dict[int, Run | Exception]:
    """The runs in lanes, by their number."""
    kernel = native.kernel()
    assert isinstance(kernel, native.Kernel)
    opened = [open_network(of[0][0]) for _ in range(width)]
    waiting = deque(enumerate(of))
    try:
        codes = lane_codes(opened[0], width)
        assert not isinstance(codes, str), codes

        def take(slot: int) -> Job | None:
            if not waiting:
                return None
            k, (plan, algorithm, step, stop) = waiting.popleft()
            return Job(k, Network(plan, opened[slot].slaves), algorithm, step, stop, options)

        return {key: result for key, result, _ in Lanes(kernel, codes, width).results(take)}
    finally:
        for network in opened:
            network.close()


@pytest.mark.parametrize("width", WIDTHS)
def test_a_run_in_a_lane_is_the_run_alone_to_the_last_bit(pair: System, width: int) -> None:
    """Parameters, starts, steps, ends, algorithms and internal steps differ; one fails, one ends early, lanes are filled anew."""
    of = tasks(pair)
    results = in_lanes(of, width)
    statuses = set()
    for k, (plan, algorithm, step, stop) in enumerate(of):
        with open_network(plan) as network:
            expected = alone(network, algorithm, step, stop)
        assert told(results[k]) == told(expected), k
        statuses.add("failed" if isinstance(expected, RunError) else expected.status if isinstance(expected, Run) else "")
    assert statuses == {"done", "ended", "failed"}


@pytest.mark.parametrize("options", [None, Options(record=Recording(every=7)), Options(record=Recording(select=("left.rate",)))])
def test_gauss_seidel_and_what_is_recorded(pair: System, options: Options | None) -> None:
    of = [(plan, GaussSeidel(k % 3), step, stop) for k, (plan, _, step, stop) in enumerate(tasks(pair))]
    results = in_lanes(of, 2, options)
    for k, (plan, algorithm, step, stop) in enumerate(of):
        with open_network(plan) as network:
            assert told(results[k]) == told(alone(network, algorithm, step, stop, options)), k


def test_the_vehicle_and_its_gyro_units() -> None:
    """Large models, with twin operations when they run alone; at low speed an internal step has more parts."""
    of: list[Task] = [(system("lrt-curve").with_value("vehicle.speed", v), Jacobi(1), 1e-3, 0.4) for v in (2.0, 5.0, 8.0)]
    results = in_lanes(of, 2)
    for k, (plan, algorithm, step, stop) in enumerate(of):
        with open_network(plan) as network:
            assert told(results[k]) == told(alone(network, algorithm, step, stop)), k


def test_an_fmu_without_sources_has_no_lanes(pair: System, tmp_path: Any) -> None:
    (bare,) = fmus.export(swing("left"), tmp_path, sources=False)
    with open_network(pair.with_source("left", str(bare))) as network:
        assert lane_codes(network, 2) == f"FMU {str(bare)!r} carries no sources for lanes"


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("sources/model_data.h", None, "carries no sources for lanes"),
        ("sources/lanes.c", None, "carries no sources for lanes"),
        ("sources/lanes.c", b"\xff\xfe", "must be UTF-8"),
        ("sources/lanes.c", b"this is no C", "the C compiler for .* failed"),
        ("sources/lanes.c", b'#include "core.h"\nint batch_step(void) { return 0; }\n', "INSTANTIATION_TOKEN"),
        ("sources/below/more.h", b"x", ""),  # it is left where it is, and the lanes work
    ],
    ids=["no data", "no lanes", "no text", "no C", "no symbols", "a folder"],
)
def test_strange_sources_in_an_fmu(pair: System, tmp_path: Path, name: str, content: bytes | None, reason: str) -> None:
    """Whatever an FMU carries: one line why it has no lanes."""
    strange = tmp_path / "strange.fmu"
    with zipfile.ZipFile(pair.components[0].source) as old, zipfile.ZipFile(strange, "w") as new:
        for member in old.namelist():
            if member != name:
                new.writestr(member, old.read(member))
        if content is not None:
            new.writestr(name, content)
    with open_network(pair.with_source("left", str(strange))) as network:
        codes = lane_codes(network, 2)
    if reason:
        assert isinstance(codes, str)
        assert re.search(reason, codes)
        assert "\n" not in codes
    else:
        assert not isinstance(codes, str)


def test_sources_of_another_model_are_refused(pair: System) -> None:
    location = pair.components[0].source
    with pytest.raises(ValueError, match=r"must be of its token \{other\}"):
        lane_code(location, "{other}", 2)


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run is worth a lane."""
    monkeypatch.setattr(side_by_side, "LARGE", 0.0)
    monkeypatch.setattr(side_by_side, "LONG", 0.0)


def crew_of(plan: Any, lanes: int) -> Crew:
    return Crew(SweepTask(plan.context), plan.files, lanes, len(plan.runs))


@pytest.mark.usefixtures("eager")
def test_a_sweeps_rows_are_the_same_side_by_side(pair: System) -> None:
    plan = Sweep(pair, {"left.stiffness": "5:400:9", "left.limit": "0.0999,50"}, algorithms=("jacobi", "iterated")).plan()
    wall = list(plan.columns).index("wall_s")

    def rows(lanes: int) -> Iterator[list[Any]]:
        crew = crew_of(plan, lanes)
        try:
            yield from sorted([*row[:wall], *row[wall + 1 :]] for row in crew.all_rows(plan.runs.items()))
            assert crew.free == (lanes if lanes > 1 else 1)
        finally:
            crew.close()

    assert repr(list(rows(2))) == repr(list(rows(1)))  # repr: NaN is NaN


@pytest.mark.usefixtures("eager")
def test_without_a_compiler_runs_go_one_at_a_time(
    pair: System, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_: object) -> None:
        raise RuntimeError("the C compiler for this machine cannot be run: none")

    monkeypatch.setattr("gyro_cosim.systems.machine_code.of_lanes", refuse)
    lane_code.cache_clear()
    lanes = side_by_side.SideBySide(2, expected=10)
    with open_network(pair) as network:
        assert [lanes.run(network, Jacobi(1), 1e-2, 0.5)[0].status for _ in range(2)] == ["done", "done"]
    assert lanes.at_once == 1
    assert caplog.messages == ["runs of pair go one at a time: the C compiler for this machine cannot be run: none"]


@pytest.mark.usefixtures("eager")
def test_nobody_waits_for_a_march_that_has_stopped(pair: System, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault of our own in the marching thread becomes the error of the runs that wait; later ones go alone."""

    class Broken:
        def __init__(self, *_: object) -> None:
            raise MemoryError("no room")

    lanes = side_by_side.SideBySide(2, expected=10)
    try:
        with open_network(pair) as network:
            lanes.run(network, Jacobi(1), 1e-2, 0.5)
            monkeypatch.setattr(side_by_side, "Lanes", Broken)
            with pytest.raises(MemoryError, match="no room"):
                lanes.run(network, Jacobi(1), 1e-2, 0.5)
            assert lanes.run(network, Jacobi(1), 1e-2, 0.5)[0].status == "done"
    finally:
        lanes.close()


@pytest.mark.usefixtures("eager")
def test_a_lane_waits_for_a_thread_that_prepares_its_run(pair: System, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the march would start with one run in its lanes, and those who measure theirs would come too late every time."""
    together = []

    class Counting:
        def __init__(self, *_: object) -> None:
            pass

        def results(self, take: Callable[[int], Job | None]) -> Iterator[tuple[Any, Any, float]]:
            jobs = [job for job in (take(0), take(1)) if job is not None]
            together.append(len(jobs))
            for job in jobs:
                yield job.key, alone(job.network, job.algorithm, job.step, job.stop), 0.0

    lanes, ready = side_by_side.SideBySide(2, expected=10), threading.Barrier(2)

    def take_part(network: Network, prepares: float) -> None:
        with lanes.taking_part():
            ready.wait()
            time.sleep(prepares)
            lanes.run(network, Jacobi(1), 1e-2, 0.5)

    with open_network(pair) as one, open_network(pair) as two:
        lanes.run(one, Jacobi(1), 1e-2, 0.5)
        monkeypatch.setattr(side_by_side, "Lanes", Counting)
        threads = [threading.Thread(target=take_part, args=arguments) for arguments in ((one, 0.0), (two, 0.3))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        lanes.close()
    assert together == [2]


def test_short_steps_go_one_run_at_a_time(pair: System) -> None:
    plan = Sweep(pair, {"left.stiffness": "5:400:5"}).plan()
    crew = crew_of(plan, 8)
    try:
        crew.all_rows(plan.runs.items())
        assert crew.free == 1
    finally:
        crew.close()


def test_a_wrong_number_of_lanes_is_refused(cosim: Callable[..., Any]) -> None:
    code, _, err = cosim("sweep", "wheel-pair", "--set", "gyro.rotor_speed=0rpm:300rpm:3", "--lanes", "0")
    assert (code, err) == (2, "cosim: the number of lanes must be at least 1, got 0\n")
