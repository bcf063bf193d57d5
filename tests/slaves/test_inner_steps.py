"""Every step of an FMU's own integrator, where somebody asks for it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import exchange_fmus
import numpy as np
import pytest
import small_fmus
from fmu_models import in_process
from test_events import flight

from gyro_cosim import read_results
from gyro_cosim.slaves import open_slave, restorable, steps_of


def test_steps_of_fmi_3_are_told_and_those_that_were_taken_back_are_not(built: Callable) -> None:
    """Its internal step is 2 ms; a step goes back and is done again, then one that was gone back from counts after all."""
    c, path, _ = built("plain", "3")
    slave = open_slave("a", str(path))
    steps, able = steps_of(slave), restorable(slave)
    assert steps is not None
    assert able is not None
    names = [signal.name for signal in steps.signals]
    U = np.zeros((3, 1))
    U[:, 0] = 0.4, 3.0, -20.0
    for _ in range(2):  # the second run has nothing of the first
        slave.initialize({}, 0.0, 1.0)
        begin = able.save()
        slave.step(U, 0.0, 0.1)
        end = able.save()
        able.restore(begin)
        slave.step(-U, 0.0, 0.05)
        assert len(steps.arrays()[0]) == 25
        able.restore(end)
        t, values = steps.arrays()
        np.testing.assert_allclose(t, 0.002 * np.arange(1, 51), atol=1e-12)
        np.testing.assert_array_equal(values[-1], slave.output(U[0] + 0.1 * (U[1] + 0.05 * U[2]), 0.1))
    assert names == [signal.name for signal in slave.outputs]
    here = in_process(c, [(0.0, float(t[9]), U.T)])[0]
    np.testing.assert_allclose(values[9], here, rtol=1e-9)
    slave.close()


def test_steps_of_model_exchange_go_into_a_file_that_can_be_made_again(cosim: Callable[..., Any]) -> None:
    """Between two points 0.5 s apart the impacts are seen at their own times, before and after."""
    file = exchange_fmus.hopper(Path.cwd(), 2)
    name = file.stem
    run = ("run", file.name, "--step", "0.5", "--stop", "1.5", "--integrator-steps", f"{name}=steps.parquet")
    code, out, err = cosim(*run)
    assert code == 0, err
    assert "wrote steps.parquet" in out
    steps = read_results("steps.parquet")
    h, hits = flight(steps.t)
    np.testing.assert_allclose(steps[f"{name}.h"], h, rtol=0, atol=1e-6)
    assert len(steps) > 50
    jumps = steps.t[1:][np.diff(steps[f"{name}.impacts"]) > 0]
    assert len(jumps) == hits[-1]
    assert cosim("reproduce", "steps.parquet")[0] == 0


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (("--integrator-steps", "mixed=s.csv"), "component 'mixed' must be an FMU for Model Exchange, or one of FMI 3.0"),
        (("--integrator-steps", "mixd=s.csv"), "unknown component to tell its steps: 'mixd'; did you mean 'mixed'?"),
        (("--integrator-steps", "mixed"), "--integrator-steps must be COMPONENT=FILE, got 'mixed'"),
        (("--integrator-steps", "mixed=s.csv", "--output", "s.csv"), "must name a file of its own, got 's.csv' twice"),
        (("--integrator-steps", "mixed=s.csv", "--resume", "c.npz"), "has no effect with --checkpoint or --resume"),
    ],
)
def test_steps_that_cannot_be_had_are_refused_in_one_line(more: tuple[str, ...], says: str, cosim: Callable[..., Any]) -> None:
    small_fmus.mixed(Path.cwd())
    code, _, err = cosim("run", "mixed.fmu", "--stop", "1", "--step", "0.1", *more)
    assert (code, err.count("\n")) == (2, 1), err
    assert says in err
