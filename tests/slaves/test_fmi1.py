"""FMUs of FMI 1.0 for Co-Simulation: imported as slaves beside those of later versions."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import vendor_fmus

from gyro_cosim import Connection, Iterated, Jacobi, Options, SlaveError, System, SystemComponent, simulate
from gyro_cosim.check import check_fmu
from gyro_cosim.export import pack_fmu
from gyro_cosim.master import Run
from gyro_cosim.ssp.packing import pack


def ran(plan: System, **how: Any) -> Run:
    return simulate(plan, **({"algorithm": Jacobi(1), "step": 0.1, "stop": 1.0} | how))


def pair(a: Path, b: Path, **values: Any) -> System:
    """a' = b, b' = -a from 1 and, since b begins at start + u, from 0; `values` are a's."""
    parts = (SystemComponent("a", str(a), {"start": 1.0, **values}), SystemComponent("b", str(b), {"start": 1.0}))
    return System("pair", parts, (Connection(("b", "y"), ("a", "u")), Connection(("a", "minus_y"), ("b", "u"))))


def test_every_type_goes_in_and_out(tmp_path: Path) -> None:
    part = SystemComponent("m", str(vendor_fmus.vendor1(tmp_path, others=True)), {"u": 2.0, "loss": -3.0, "on": False})
    end = ran(System("s", (part,), ())).trajectory
    assert [end[f"m.{name}"][-1] for name in ("count", "on_out", "off", "told", "stop")] == [3 + 10, 0, 1, 10, 1]
    assert end["m.y"][-1] == pytest.approx(2.0 + 3.0 * 2.0 * 1.0)  # x = start + u at the start, as FMI 1.0 sets it before
    np.testing.assert_array_equal(end["m.minus_y"], -end["m.y"])


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(2)], ids=repr)
def test_versions_run_side_by_side_with_the_same_bits(algorithm: Jacobi, tmp_path: Path) -> None:
    """FMI 1.0 under the compiled loop, the plain one, and in a process of its own; and as the same integrator of FMI 2.0."""
    one, two = vendor_fmus.vendor1(tmp_path, negated=False), vendor_fmus.vendor2(tmp_path, canGetAndSetFMUstate="false")

    def both(a: Path, **how: Any) -> np.ndarray:
        parts = (SystemComponent("a", str(a), {"start": 1.0}), SystemComponent("b", str(two)))
        plan = System("p", parts, (Connection(("b", "y"), ("a", "u")), Connection(("a", "y"), ("b", "u"))))
        run = ran(plan, algorithm=algorithm, **how)
        return run.trajectory["a.y"]

    expected = both(two)
    assert expected[-1] == pytest.approx(np.cosh(1.0), rel=0.1)
    for how in ({}, {"options": Options(compiled=False)}, {"isolate": True}):
        np.testing.assert_array_equal(both(one, **how), expected)


def test_it_couples_to_the_order_that_it_can_keep(tmp_path: Path) -> None:
    """From cos and sin, with derivatives of inputs; iterating algorithms want to go back, and are refused."""
    file = vendor_fmus.vendor1(tmp_path)
    errors = [abs(ran(pair(file, file), algorithm=Jacobi(2), step=h).trajectory["a.y"][-1] - np.cos(1.0)) for h in (0.02, 0.01)]
    assert np.log2(errors[0] / errors[1]) > 1.85
    with pytest.raises(ValueError, match="needs components that can save and restore their state, 'a' cannot"):
        ran(pair(file, file), algorithm=Iterated(1))


def test_what_fmi_1_has_not_is_told(tmp_path: Path) -> None:
    file = vendor_fmus.vendor1(tmp_path, canHandleVariableCommunicationStepSize="false")
    (note, _) = ran(replace(pair(file, file), tolerance=1e-5)).notes
    assert note == "component 'a' is told no tolerance, since FMI 1.0 has none in Co-Simulation"
    with pytest.raises(
        ValueError, match=r"component 'a' must have steps of one length .*: a run over 1\.05 s ends with a shorter"
    ):
        ran(pair(file, file), stop=1.05)


@pytest.mark.parametrize(("answer", "says"), [(2, "discard, having reached t = 0.1 s"), (3, "error"), (4, "fatal")])
@pytest.mark.parametrize("compiled", [True, False], ids=["kernel", "python"])
def test_a_failure_is_told_in_its_words(answer: int, says: str, compiled: bool, tmp_path: Path) -> None:
    """printf arguments and all; the logger of FMI 1.0 says by its name only who speaks."""
    file = vendor_fmus.vendor1(tmp_path, negated=False)
    parts = SystemComponent("m", str(file), {"answer": answer, "text": "oops"}), SystemComponent("n", str(file))
    plan = System("s", parts, ())
    with pytest.raises(SlaveError) as caught:
        ran(plan, options=Options(compiled=compiled))
    where = "component 'm' failed at t = 0.1 s over a step of 0.1 s"
    assert str(caught.value) == f"{where}: fmiDoStep answered {says}; it says: oops at 0.1 [solver]"


def test_the_prompt_runs_and_describes_it(tmp_path: Path, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    file = vendor_fmus.vendor1(tmp_path, others=True)
    end = cosim_json("run", str(file), "--set", "vendor1.gain=2", "--set", "vendor1.u=1")["end"]
    assert end["vendor1.y"] == pytest.approx(3.0)
    _, told, _ = cosim("info", str(file))
    assert "vendor: FMI 1.0, CoSimulation" in told
    assert "count depends directly on add" in told
    assert [f.severity for f in check_fmu(file)] == ["note"]
    pack(pair(file, file), tmp_path / "s.ssp")
    run = ran(pair(file, file))
    end = cosim_json("run", str(tmp_path / "s.ssp"), "--step", "0.1", "--stop", "1")["end"]
    assert end["a.y"] == run.trajectory["a.y"][-1]
    exchanged = tuple(replace(part, implementation="ModelExchange") for part in pair(file, file).components)
    with pytest.raises(ValueError, match=r"of FMI 1\.0 must run by Co-Simulation, offers Co-Simulation"):
        ran(replace(pair(file, file), components=exchanged))
    plain = vendor_fmus.vendor1(tmp_path, name="plain")
    with pytest.raises(ValueError, match=r"component 'a' must be an FMU of FMI 2\.0 or 3\.0 to be packed into one, .*FMI 1\.0"):
        pack_fmu(pair(plain, plain), tmp_path)
