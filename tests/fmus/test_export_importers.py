"""The FMUs in importers that are not FMPy: CasADi's (Model Exchange, derivatives) and, where installed, libcosim's."""

import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from fmu_models import COMPONENTS, in_process


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("name", [n for n in COMPONENTS if n not in ("gain", "autonomous", "implicit growth", "sampled")])
def test_casadi_reads_the_same_equations_and_jacobian(built: Callable, name: str, version: str, tmp_path: Path) -> None:
    """x' and y at a random point to the last bit, their Jacobian through the FMU's directional derivatives to rounding."""
    c, path, _ = built(name, version)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    fmu = ca.DaeBuilder("fmu", str(tmp_path)).create("fmu", ["x", "u"], ["ode", "y"])
    rng = np.random.default_rng(1)
    x, u = (v + 0.1 * rng.standard_normal(v.size) for v in (c.start_state, c.start_input))
    p = c.start_parameters
    rate, y = (np.array(value).ravel() for value in fmu(x, u))
    assert np.array_equal(rate, np.array(c.rhs(x, u, p)).ravel())
    assert np.array_equal(y, np.array(c.output(x, u, p)).ravel())
    jacobian = [np.array(ca.DM(block)) for block in fmu.jacobian()(x, u, 0, 0)]
    X, U = ca.SX.sym("X", x.size), ca.SX.sym("U", u.size)
    exact = [
        np.array(ca.DM(ca.Function("J", [X, U], [ca.jacobian(f(X, U, p), v)])(x, u))) for f in (c.rhs, c.output) for v in (X, U)
    ]
    for got, expected in zip(jacobian, exact, strict=True):
        assert np.allclose(got, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.skipif(sys.platform != "linux", reason="libcosimpy has wheels for Linux only")
def test_libcosim_steps_to_the_same_result(built: Callable) -> None:
    """FMI Library inside libcosim: Co-Simulation with a start value, 100 steps of 1 ms."""
    pytest.importorskip("libcosimpy", reason="has no wheel for this Python")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    c, path, _ = built("gyro_unit:nonlinear")
    execution = CosimExecution.from_step_size(step_size=1_000_000)  # ns
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name="gyro"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    references = {v.name: i + 1 for i, v in enumerate(c.variables)}
    assert execution.real_initial_value(slave_index=slave, variable_reference=references["gimbal_angle"], value=0.2)
    assert execution.simulate_until(target_time=100_000_000)
    names = [v.name for v in c.outputs]
    got = observer.last_real_values(slave_index=slave, variable_references=[references[n] for n in names])
    x0 = [0.2 if v.name == "gimbal_angle" else v.start for v in c.states]
    U = np.zeros((len(c.inputs), 3))
    expected = in_process(c, [(i * 1e-3, 1e-3, U) for i in range(100)], state=np.array(x0))[-1]
    assert got == pytest.approx(expected, rel=1e-11)  # libcosim's step is the difference of two times, not 1e-3
