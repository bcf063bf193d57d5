"""The inner loop asks for outputs where they are recorded, judged or coupled, and for no others: the same results."""

from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim import Connection, GaussSeidel, Jacobi, Run, SlaveError, System, SystemComponent, simulate, system
from gyro_cosim.coupling import Algorithm, Nepce
from gyro_cosim.kernel import driver, energy, loop
from gyro_cosim.master import Options, open_network, ways
from gyro_cosim.master.energy import EnergyMeter
from gyro_cosim.master.recording import Recording
from gyro_cosim.master.stepping import Stepper
from gyro_cosim.master.time_grid import TimeGrid
from gyro_cosim.systems import StopWhen

ALGORITHMS = [Jacobi(0), Jacobi(2), Nepce(1), GaussSeidel(0), GaussSeidel(2), GaussSeidel(1, ("right", "left", "echo", "image"))]
WAYS = ((lambda *_: False, False), (driver.fits, False), (driver.fits, True))  # plain, inner loop as Python runs it, compiled
THINNED = Recording(select=("left.position", "image.position", "echo.force"), every=7)


def watched(*stops: StopWhen) -> System:
    """The oscillators, and one more of each that follows them and whom nobody follows; the force feeds through."""
    pair = oscillators.pair(cubic=3.0)
    left, right = (part.source for part in pair.components)
    wires = (Connection(("right", "force"), ("image", "force")), Connection(("left", "position"), ("echo", "position")),
             Connection(("left", "velocity"), ("echo", "velocity")))  # fmt: skip
    parts = (*pair.components, SystemComponent("image", left), SystemComponent("echo", right))
    return System("watched", parts, (*pair.connections, *wires), pair.bonds, stop_when=stops)


def three_ways(plan: System, algorithm: Algorithm, record: Recording, monkeypatch: pytest.MonkeyPatch, stop: float) -> list[Run]:
    runs = []
    for fits, compiled in WAYS:
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            options = Options(compiled=compiled, record=record)
            runs.append(simulate(plan, algorithm=algorithm, step=1e-3, stop=stop, options=options))
    return runs


def same(runs: list[Run]) -> None:
    """To the last bit, signs of zero among them."""
    for other in runs[1:]:
        assert other.trajectory.names == runs[0].trajectory.names
        assert other.trajectory.t.tobytes() == runs[0].trajectory.t.tobytes()
        assert other.trajectory.values.tobytes() == runs[0].trajectory.values.tobytes()
        assert other.energy == runs[0].energy
        assert (other.steps, other.status, other.ended_by) == (runs[0].steps, runs[0].status, runs[0].ended_by)


@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=repr)
def test_what_is_passed_over_changes_nothing(algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thinned, and with fewer signals: the rows of the full record, and the energy of its bonds."""
    plan = watched()
    thinned = three_ways(plan, algorithm, THINNED, monkeypatch, 0.5003)
    same(thinned)
    full = simulate(plan, algorithm=algorithm, step=1e-3, stop=0.5003)
    kept = [*range(0, 501, 7), 501]
    assert thinned[0].trajectory.t.tobytes() == full.trajectory.t[kept].tobytes()
    for name in THINNED.select:
        np.testing.assert_array_equal(thinned[0].trajectory[name], full.trajectory[name][kept])
    assert thinned[0].energy == full.energy


@pytest.mark.parametrize("algorithm", [Jacobi(1), GaussSeidel(1)], ids=repr)
def test_a_stop_condition_keeps_the_row_that_it_ends_with(algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch) -> None:
    """At a step whose turn it is not, judged by an output that is not recorded; what is recorded is read there."""
    plan = watched(StopWhen(("image", "velocity"), 0.5, "fast"))
    runs = three_ways(plan, algorithm, THINNED, monkeypatch, 5.0)
    same(runs)
    assert runs[0].status == "ended"
    assert runs[0].steps % 7
    full = simulate(plan, algorithm=algorithm, step=1e-3, stop=5.0)
    np.testing.assert_array_equal([runs[2].trajectory[name][-1] for name in THINNED.select],
                                  [full.trajectory[name][-1] for name in THINNED.select])  # fmt: skip


@pytest.mark.parametrize("algorithm", [Jacobi(1), GaussSeidel(1)], ids=repr)
def test_outputs_are_asked_for_where_they_are_recorded_judged_or_coupled(
    algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the vehicle's wheel pair its yaw rate in every step, what is recorded at every tenth, the rest never."""
    plan, asked = system("wheel-pair"), []
    plain = loop.receive

    def noted(plan: loop.Plan, data: loop.Data, i: int, r: int, whole: bool) -> bool:
        of = plan.slaves[i]
        first, n = of[loop.c.Y_FIRST], of[loop.c.N_Y if whole else loop.c.N_POLLED]
        asked.append((i, *sorted(plan.places[first : first + n].tolist())))
        return plain(plan, data, i, r, whole)

    monkeypatch.setattr(loop, "receive", noted)
    monkeypatch.setattr(ways, "FIRST_CHUNK", 1000)
    record = Recording(select=("vehicle.yaw_angle",), every=10)
    simulate(plan, algorithm=algorithm, step=1e-3, stop=0.1, options=Options(record=record, compiled=False))
    with open_network(plan) as network:
        rate, angle, moment = (
            network.place(tuple(n.split("."))) for n in ("vehicle.yaw_rate", "vehicle.yaw_angle", "gyro.yaw_moment")
        )
    steps = [(k, step) for k, step in enumerate(range(2, 101))]  # the first is the plain loop's
    assert asked == [call for _, step in steps for call in
                     ((0, *sorted((rate, angle) if step % 10 == 0 else (rate,))), (1, moment))]  # fmt: skip


@pytest.mark.parametrize("compiled", [True, False])
def test_an_output_that_nobody_asks_for_is_found_out_at_the_end(compiled: bool) -> None:
    """It is NaN from 0.55 s on; only when the run is over is every slave asked for all that it has."""
    parts = (SystemComponent("clock", f"{oscillators.HERE}:fails"), SystemComponent("left", f"{oscillators.HERE}:left"))
    options = Options(record=Recording(select=("left.*",)), compiled=compiled)
    with pytest.raises(SlaveError, match=r"'clock' failed at t = 1 s: output 'reading' must be finite, got nan") as caught:
        simulate(System("s", parts, ()), step=0.01, stop=1.0, options=options)
    assert caught.value.partial.steps == 100


def test_a_run_that_fails_keeps_the_steps_whose_turn_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = (SystemComponent("clock", f"{oscillators.HERE}:failing_force"), SystemComponent("left", f"{oscillators.HERE}:left"))
    wires = (Connection(("clock", "reading"), ("left", "force")),)
    partial: list[Any] = []
    for fits, compiled in WAYS:
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            with pytest.raises(SlaveError, match=r"'clock' failed at t = 0\.55 s: output 'reading'") as caught:
                simulate(System("s", parts, wires), step=1e-3, stop=1.0, options=Options(record=THINNED_LEFT, compiled=compiled))
        partial.append(caught.value.partial)
    same(partial)
    assert partial[0].steps == 549
    assert partial[0].trajectory.t[-1] == pytest.approx(546e-3)


THINNED_LEFT = Recording(select=("left.position",), every=7)


@pytest.mark.parametrize("compiled", [True, False])
def test_the_state_of_a_run_does_not_show_its_chunks(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was passed over must not differ between a row that ended a chunk and one that did not: checkpoints hold it."""
    states = []
    for first, patience in ((1000, 1e3), (1, 0.0), (3, 1e3)):
        monkeypatch.setattr(ways, "FIRST_CHUNK", first)
        monkeypatch.setattr(ways, "PATIENCE", patience)
        with open_network(watched()) as network:
            stepper = Stepper(network, Jacobi(2), TimeGrid.over(1e-3, 0.1), Options(record=THINNED, compiled=compiled))
            stepper.go(None, None)
            states.append(stepper.finish(cut_off=False)[0])
    assert states[0] == states[1] == states[2]


def test_the_meter_s_definition_and_the_same_on_arrays_give_the_same_bits() -> None:
    """energy.accumulate, which the kernel repeats, against what the plain loop calls; the steps are of two lengths."""
    rng = np.random.default_rng(4)
    with open_network(oscillators.pair()) as network:
        meter = EnergyMeter(network)
        Y, used = rng.normal(size=(20, len(network.names))), rng.normal(size=(20, 2, 3))
        h = np.where(np.arange(20) < 12, 1e-3, 0.7e-3)
        begun = meter.begin(rng.normal(size=len(network.names)))
        whole, sums = meter.add(begun, h, Y, used), begun.copies()
        energy.accumulate(meter.bonds, begun.past, Y, h, float(h[0]), used, sums)
        for a, b in zip(sums, (whole.residual, whole.exchanged, whole.peak), strict=True):
            assert a.tobytes() == b.tobytes()
            assert a[0] != 0.0


@pytest.mark.parametrize("algorithm", [Jacobi(1), Jacobi(2), GaussSeidel(1)], ids=repr)
def test_a_derivative_of_zero_is_the_same_as_none(algorithm: Algorithm, monkeypatch: pytest.MonkeyPatch) -> None:
    """At rest the quotients of differences are -0.0: neither they nor -0.0 itself must reach a component."""
    from gyro_cosim.network import network as of_network
    from gyro_cosim.network.joining import Transfer

    plain = of_network.transfer
    monkeypatch.setattr(of_network, "transfer", lambda *a: Transfer(-plain(*a).factor, -0.0))
    pair = oscillators.pair()
    still = (SystemComponent("left", pair.components[0].source, {"position": 0.0}), pair.components[1])
    rest = System(pair.name, still, pair.connections, pair.bonds)
    same(three_ways(rest, algorithm, Recording(), monkeypatch, 0.05))
    with open_network(rest) as network:
        C = np.array([network.initialize(3e-3, 1.0), *-np.zeros((2, len(network.names)))])
        assert not any(np.signbit(network.inputs(i, C)).any() for i in range(len(network.slaves)))
        meter, rows = EnergyMeter(network), ways.Rows(network)
        inner = driver.FastLoop(
            network, algorithm, rows.Y, rows.t, rows.h, rows.whole, rows.used, network.coupled, meter.bonds, None
        )
        rows.t[:], rows.h[:] = 1e-3 * np.arange(rows.t.size), 1e-3
        assert inner.march(3, 5, np.zeros((1, 2)), 0.0, meter.begin(rows.Y[0]).copies())[0] == 5
        assert not np.signbit(inner._data.u).any()
        assert not np.signbit(inner._data.du).any()
        assert not inner._data.orders.any()
