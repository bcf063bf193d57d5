"""The start: all components in initialization mode together, outputs and inputs exchanged there until they agree."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus

from gyro_cosim import Connection, ConvergenceError, Jacobi, SlaveError, System, SystemComponent, WiringError, simulate
from gyro_cosim.master import open_network, run
from gyro_cosim.slaves.processes import serving
from gyro_cosim.ssp.packing import pack

VERSIONS = ((2, 2, 2), (3, 3, 3), (3, 2, 3))


def chain(files: tuple[Path, ...], prefix: str = "") -> System:
    """a -> b -> c, in the order c, b, a, so that the system's own order is the wrong one: starts at 3, 6, 7."""
    values = {"gain": 1.0, "bias": 1.0}, {"gain": 2.0}, {"gain": 0.0, "bias": 3.0}
    parts = tuple(SystemComponent(name, f"{prefix}{file}", v) for name, file, v in zip("cba", files, values, strict=True))
    return System("chain", parts, (Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("c", "u"))))


def ring(file: Path, gain: float) -> System:
    """x_a(0) = gain x_b(0) + 1 and the same the other way round: both start at 1 / (1 - gain)."""
    parts = tuple(SystemComponent(name, str(file), {"gain": gain, "bias": 1.0}) for name in "ab")
    return System("ring", parts, (Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u"))))


@pytest.mark.parametrize(
    ("versions", "says", "how"),
    [
        *((versions, says, "here") for versions in VERSIONS for says in small_fmus.INITIAL),
        ((3, 2, 3), "stated", "isolated"),
        ((3, 2, 3), "stated", "remote"),
    ],
    ids=str,
)
def test_a_state_that_is_computed_from_a_connected_input_starts_right(
    versions: tuple[int, ...], says: str, how: str, tmp_path: Path
) -> None:
    files = tuple(small_fmus.follower(tmp_path, version, says=says) for version in versions)
    plan = chain(files, "process:" if how == "remote" else "")
    trajectory = simulate(plan, step=0.1, stop=1.0, isolate=how == "isolated").trajectory
    for name, start in (("a", 3.0), ("b", 6.0), ("c", 7.0)):
        np.testing.assert_allclose(trajectory[f"{name}.y"], start * np.exp(-trajectory.t), rtol=1e-12)
    assert trajectory["b.seen"][0] == 3.0
    assert trajectory["c.seen"][0] == 6.0


@pytest.mark.parametrize("gain", [0.5, 3.0])
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("says", ["stated", "anything"])
def test_an_algebraic_loop_of_the_start_is_solved(version: int, says: str, gain: float, tmp_path: Path) -> None:
    """Only in initialization mode do these two depend on one another; a gain above 1 is beyond passing values round."""
    plan = ring(small_fmus.follower(tmp_path, version, says=says), gain)
    with open_network(plan) as network:
        assert network.loops == ()
        assert "a.y -> b.y -> a.y" in network.initial_loops or "b.y -> a.y -> b.y" in network.initial_loops
        with pytest.raises(WiringError, match="must have no algebraic loop in initialization mode, has"):
            network.refuse_loops()
        Y = network.initialize(0.0, 1.0)
        np.testing.assert_allclose(Y, 1.0 / (1.0 - gain), rtol=1e-9)


def test_a_loop_that_is_not_stated_is_passed_round_until_it_settles_or_refused(tmp_path: Path) -> None:
    file = small_fmus.follower(tmp_path, 2, says="nothing")
    assert simulate(ring(file, 0.5), step=0.1, stop=0.1).trajectory["a.y"][0] == pytest.approx(2.0, rel=1e-9)
    with pytest.raises(ConvergenceError, match=r"must agree in initialization mode at t = 0 s, a\.y still changes") as caught:
        simulate(ring(file, 3.0), step=0.1, stop=0.1)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("isolate", [False, True])
def test_an_fmu_that_is_silent_in_initialization_mode_is_named(version: int, isolate: bool, tmp_path: Path) -> None:
    """After an error FMI lets nobody go on with an instance, so there is nothing to fall back to; unconnected it runs."""
    file = small_fmus.follower(tmp_path, version)
    get = "fmi2GetReal" if version == 2 else "fmi3GetFloat64"
    for silent, words in ((1.0, f"{get} answered error in initialization mode"),
                          (2.0, "output 'y' must be finite in initialization mode.*, got nan")):  # fmt: skip
        plan = chain((file, file, file)).with_value("b.silent", silent)
        with pytest.raises(SlaveError, match=f"component 'b' failed at t = 2 s: {words}"):
            simulate(plan, step=0.1, start=2.0, stop=3.0, isolate=isolate)
        alone = System("s", (SystemComponent("s", str(file), {"silent": silent, "u": 4.0}),), ())
        assert simulate(alone, step=0.1, stop=1.0, isolate=isolate).trajectory["s.y"][0] == 4.0


def test_runs_begin_anew_on_an_open_network(tmp_path: Path) -> None:
    files = tuple(small_fmus.follower(tmp_path, version) for version in (3, 2, 3))
    with open_network(chain(files)) as network:
        first, second = (run(network, Jacobi(1), 0.1, 1.0).trajectory.values for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first[0, 0] == 7.0


@pytest.mark.parametrize("initializes", [True, False])
def test_a_unit_without_initialization_mode_is_started_as_a_whole(
    initializes: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What only speaks START, as a device does, starts from its inputs' own start values; with BEGIN they have arrived."""
    from test_remote import offered

    from gyro_cosim.slaves import open_slave

    if not initializes:
        told = serving.introduction
        hidden = ("initialization", "initial_feedthrough")
        monkeypatch.setattr(serving, "introduction", lambda *of: {k: v for k, v in told(*of).items() if k not in hidden})
    file = small_fmus.follower(tmp_path, 2)
    with offered(open_slave("unit", str(file))) as port:
        parts = (
            SystemComponent("a", str(file), {"gain": 0.0, "bias": 3.0}),
            SystemComponent("b", f"tcp://127.0.0.1:{port}", {"bias": 1.0}),
        )
        plan = System("s", parts, (Connection(("a", "y"), ("b", "u")),))
        trajectory = simulate(plan, algorithm=Jacobi(0), step=0.1, stop=0.5).trajectory
    assert trajectory["b.y"][0] == (4.0 if initializes else 1.0)


def test_info_spells_out_the_loops_of_the_start(
    tmp_path: Path, cosim: Callable[..., Any], cosim_json: Callable[..., Any]
) -> None:
    pack(ring(small_fmus.follower(tmp_path, 3), 0.5), tmp_path / "ring.ssp")
    (loop,) = cosim_json("info", "ring.ssp")["initial_loops"]
    assert f"algebraic loop in initialization mode: {loop}" in cosim("info", "ring.ssp")[1]
    code, _, err = cosim("run", "ring.ssp", "--stop", "1", "--loops", "refuse")
    assert (code, err.count("\n")) == (2, 1)
    assert f"must have no algebraic loop in initialization mode, has {loop}" in err
