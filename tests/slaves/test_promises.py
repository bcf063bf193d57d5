"""What an FMU is promised is what the run does; what it promises and does not keep is found before the run."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import exchange_fmus
import numpy as np
import pytest
import small_fmus
import vendor_fmus

from gyro_cosim import (
    Adaptive,
    Connection,
    GaussSeidel,
    Iterated,
    Jacobi,
    Nepce,
    Options,
    SlaveError,
    System,
    SystemComponent,
    simulate,
)  # fmt: skip
from gyro_cosim.coupling import Algorithm
from gyro_cosim.master import Run
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.slaves.exchange.functions import Functions
from gyro_cosim.ssp.packing import pack


def pair(file: Path, **values: float) -> System:
    """a' = b, b' = a from 1 and 0: two of the same kind, of which a gets `values`. a = cosh t."""
    parts = (SystemComponent("a", str(file), {"start": 1.0, **values}), SystemComponent("b", str(file)))
    return System("pair", parts, (Connection(("b", "y"), ("a", "u")), Connection(("a", "y"), ("b", "u"))))


def ran(plan: System, algorithm: Algorithm | None = None, **how: Any) -> Run:
    return simulate(plan, algorithm=algorithm or Jacobi(1), **({"step": 0.1, "stop": 1.0} | how))


ALGORITHMS = [Jacobi(0), Jacobi(2), GaussSeidel(1), Nepce(1), Iterated(2)]


@pytest.mark.parametrize("compiled", [True, False], ids=["kernel", "python"])
@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=repr)
def test_nobody_goes_back_behind_the_begin_of_a_step(algorithm: Algorithm, compiled: bool, tmp_path: Path) -> None:
    """Read as newStep of FMI 1.0, false means that the step before is repeated: the run would freeze."""
    file = vendor_fmus.vendor2(tmp_path)
    told, plain = (
        ran(pair(file, newstep=newstep), algorithm, options=Options(compiled=compiled)).trajectory for newstep in (1.0, 0.0)
    )
    np.testing.assert_array_equal(told["a.y"], plain["a.y"])
    assert told["a.revocable"][-1] == 0


def test_a_step_after_one_that_may_be_taken_back_is_told_so(tmp_path: Path) -> None:
    """Of the two halves that an adaptive step is done in, the second: a rejected step goes back behind its begin."""
    run = ran(pair(vendor_fmus.vendor2(tmp_path)), options=Options(adaptive=Adaptive(1e-3)))
    assert run.rejections == 0
    assert run.trajectory["a.revocable"][-1] == run.steps / 2
    parts = ran(pair(vendor_fmus.vendor2(tmp_path)), Iterated(1), substeps={"a": 3})
    assert parts.trajectory["a.revocable"][-1] == 2 * parts.iterations


@pytest.mark.parametrize(("accepts", "order", "isolate"), [(1, 3, False), (0, 2, False), (1, 3, True)])
def test_the_degree_that_an_fmu_takes_is_found_before_the_run(accepts: int, order: int, isolate: bool, tmp_path: Path) -> None:
    """The standard has no flag for it; after an error the instance is lost, so another one is asked."""
    plan = pair(vendor_fmus.vendor2(tmp_path), accepts=accepts).with_value("b.accepts", accepts)
    run = ran(plan, Jacobi(2), isolate=isolate)
    assert len(run.notes) == (2 - accepts) * 2  # one for each order that each of the two does not take
    lost = "component 'a' does not take second input derivatives (fmi2SetRealInputDerivatives answered error)"
    assert run.notes[0].startswith(lost)
    assert f"keeps order {order}" in run.notes[-1]
    assert ran(pair(vendor_fmus.vendor2(tmp_path), accepts=1.0), Jacobi(1)).notes == ()  # what is not used is not missed
    errors = []
    for h in (0.05, 0.025):
        end = ran(plan, Jacobi(2), step=h, stop=2.0).trajectory
        errors.append(abs(end["a.y"][-1] - np.cosh(2.0)))
    assert np.log2(errors[0] / errors[1]) > order - 0.15  # an integrator does not care for more than the mean


@pytest.mark.parametrize(("algorithm", "options"), [(Iterated(1), Options()), (Jacobi(1), Options(adaptive=Adaptive()))], ids=str)
def test_a_state_that_cannot_be_saved_is_found_before_the_run(algorithm: Algorithm, options: Options, tmp_path: Path) -> None:
    plan = pair(vendor_fmus.vendor2(tmp_path), stateless=1.0)
    with pytest.raises(ValueError, match=r"needs components that can save and restore .*, 'a' cannot: fmi2GetFMUstate answered"):
        ran(plan, algorithm, options=options)
    (note,) = ran(plan).notes
    assert "'a' says that it can save and restore its state, and cannot (fmi2GetFMUstate answered error)" in note


def test_steps_of_different_length_are_refused_before_the_run(tmp_path: Path) -> None:
    file = vendor_fmus.vendor2(tmp_path, canHandleVariableCommunicationStepSize="false")
    plan = pair(file)
    rule = "component 'a' must have steps of one length"
    with pytest.raises(ValueError, match=rf"{rule} .*: a run over 1.05 s ends with a shorter one than 0.1 s"):
        ran(plan, stop=1.05)
    with pytest.raises(ValueError, match=rf"{rule} .*: an adaptive macro step has none"):
        ran(plan, options=Options(adaptive=Adaptive()))
    run = ran(plan, Iterated(1), substeps={"a": 4}).trajectory
    assert run["a.shortest"][-1] == pytest.approx(run["a.longest"][-1], rel=1e-12)
    assert run["a.longest"][-1] == pytest.approx(0.025)


def test_the_tolerance_is_told(tmp_path: Path, cosim_json: Callable[..., Any]) -> None:
    own = vendor_fmus.vendor2(tmp_path, name="own", default="1e-5")
    for file, given, told in ((own, None, 1e-5), (own, 1e-3, 1e-3), (vendor_fmus.vendor2(tmp_path), None, -1.0)):
        assert ran(replace(pair(file), tolerance=given)).trajectory["a.tolerance"][-1] == told
    run = ran(replace(pair(own), tolerance=1e-7), isolate=True)
    assert run.trajectory["a.tolerance"][-1] == 1e-7
    pack(pair(own), tmp_path / "s.ssp")
    told = cosim_json("run", "s.ssp", "--stop", "1", "--step", "0.1", "--tolerance", "1e-4")
    assert told["end"]["a.tolerance"] == 1e-4
    assert told["notes"] == []
    with pytest.raises(ValueError, match="tolerance must be positive, got 0"):
        replace(pair(own), tolerance=0.0)


@pytest.mark.parametrize("isolate", [False, True])
def test_it_is_that_of_the_integration_by_model_exchange(isolate: bool, tmp_path: Path) -> None:
    """speck' = -speck; the FMU's own tolerance is 1e-9."""
    alone = System("s", (SystemComponent("a", str(exchange_fmus.hopper(tmp_path, 3))),), ())
    errors = [
        abs(ran(replace(alone, tolerance=given), stop=0.4, isolate=isolate).trajectory["a.speck"][-1] / 1e-6 / np.exp(-0.4) - 1)
        for given in (None, 1e-5, 1e-3)
    ]
    assert errors[0] < 1e-8 < 1e-7 < errors[1] < 1e-4 < errors[2] < 1e-2


@pytest.mark.parametrize(("algorithm", "goes_back"), [(Jacobi(0), False), (Iterated(1), True)], ids=repr)
def test_completed_steps_are_final_only_where_nobody_goes_back(
    algorithm: Algorithm, goes_back: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of Model Exchange: a step of the integrator beyond the begin of a macro step that may be repeated is none."""
    told: list[tuple[float, bool]] = []
    completed = Functions.completed

    def heard(self: Functions, instance: Any, no_set_state: bool, t: float, h: float) -> tuple[bool, bool]:
        told.append((t, bool(no_set_state)))
        return completed(self, instance, no_set_state, t, h)

    monkeypatch.setattr(Functions, "completed", heard)
    file = str(exchange_fmus.hopper(tmp_path, 2))
    parts = SystemComponent("a", file), SystemComponent("b", file, {"h": 50.0})
    ran(System("s", parts, (Connection(("b", "v"), ("a", "u")),)), algorithm, stop=0.3, step=0.1)
    assert len(told) > 6
    assert {flag for _, flag in told} == {not goes_back}


def test_a_stop_time_is_final_only_where_the_run_ends_there(tmp_path: Path) -> None:
    """A run with checkpoints may go on from them: its components are told no stop time, and can."""
    file = vendor_fmus.vendor2(tmp_path, canSerializeFMUstate="false")
    assert ran(pair(file)).trajectory["a.stop"][-1] == 1.0
    plan = System("s", (SystemComponent("g", "gyro_unit:linear", {"yaw_rate": 0.1}),), ())
    checkpoint = tmp_path / "c.npz"
    ran(plan, options=Options(checkpoint=Checkpoint(checkpoint, 0.5)))
    longer = ran(plan, stop=2.0, options=Options(resume=Resume(checkpoint))).trajectory
    whole = ran(plan, stop=2.0).trajectory
    np.testing.assert_array_equal(longer.values, whole.values)


@pytest.mark.parametrize("isolate", [False, True])
def test_event_mode_that_is_refused_is_done_without(isolate: bool, tmp_path: Path) -> None:
    plan = System("s", (SystemComponent("ball", str(small_fmus.ball(tmp_path, refuses=True))),), ())
    run = ran(plan, step=0.01, stop=2.0, isolate=isolate)
    (note,) = run.notes
    assert "component 'ball' says that it has event mode, and refuses it" in note
    assert run.events == {}
    alone = System("s", (SystemComponent("ball", str(small_fmus.ball(tmp_path, events=False))),), ())
    np.testing.assert_array_equal(run.trajectory.values, ran(alone, step=0.01, stop=2.0).trajectory.values)


@pytest.mark.parametrize("compiled", [True, False], ids=["kernel", "python"])
@pytest.mark.parametrize("status", [-1, 6, 99, -(2**31)])
def test_a_status_that_fmi_does_not_have_is_an_error(status: int, compiled: bool, tmp_path: Path) -> None:
    with pytest.raises(SlaveError, match=f"component 'a' failed at .*: fmi2DoStep answered status {status}"):
        ran(pair(vendor_fmus.vendor2(tmp_path), answer=status), options=Options(compiled=compiled))


def test_a_step_that_is_pending_is_waited_for(tmp_path: Path) -> None:
    file = vendor_fmus.vendor2(tmp_path, canRunAsynchronuously="true", canGetAndSetFMUstate="false")
    told, plain = (ran(pair(file, pending=n)).trajectory["a.y"] for n in (3, 0))
    np.testing.assert_array_equal(told, plain)


def test_what_a_process_can_hold_once_only_runs_beside_others_in_their_own(tmp_path: Path) -> None:
    file = vendor_fmus.vendor2(tmp_path, flags="-DONCE", canBeInstantiatedOnlyOncePerProcess="true")
    run = ran(pair(file), Jacobi(2))
    assert "component 'b' runs in a process of its own: a process can hold its FMU once only" in run.notes
    assert any("'a' does not take input derivatives (which cannot be tried" in note for note in run.notes)


def test_what_a_trial_leaves_behind_is_not_met_by_the_run(tmp_path: Path) -> None:
    """This FMU cannot be instantiated a second time, and does not say so; the trial has a library of its own."""
    file = vendor_fmus.vendor2(tmp_path, flags="-DONCE")
    run = ran(System("s", (SystemComponent("a", str(file), {"start": 1.0}),), ()), Jacobi(2))
    assert run.notes == ()
    assert run.trajectory["a.y"][-1] == 1.0


def test_an_fmu_alone_is_not_taken_back(tmp_path: Path) -> None:
    """Nothing is extrapolated, so no step need be repeated; and what its saved states miss does no harm."""
    file = vendor_fmus.vendor2(tmp_path)
    run = ran(System("s", (SystemComponent("a", str(file), {"stateless": 1.0}),), ()), Jacobi(2))
    assert run.notes == ()
    assert ran(pair(file, stateless=1.0), Jacobi(2)).notes != ()


def test_a_missing_licence_is_told_in_the_vendors_words(tmp_path: Path) -> None:
    file = vendor_fmus.vendor2(tmp_path, flags="-DLICENCE", needsExecutionTool="true")
    with pytest.raises(SlaveError) as caught:
        ran(pair(file))
    assert str(caught.value) == (
        "component 'a' failed at t = 0 s: fmi2Instantiate answered with no instance (it needs its tool, A vendor's tool); "
        "it says: no licence for Vendor found at 27000 [licence]"
    )
