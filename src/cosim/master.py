"""The master: runs a system at a fixed macro step and says what it cost and how much energy the coupling made."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cosim.coupling import Algorithm, History, Jacobi
from cosim.energy import BondEnergy, EnergyMeter
from cosim.errors import RunError
from cosim.network import Network
from cosim.slaves import Slave, open_slave
from cosim.system import System
from cosim.trajectory import Trajectory

Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class Timing:
    """Seconds: opening and starting the slaves, the loop over macro steps, and in it each component's steps."""

    setup_s: float
    loop_s: float
    do_step_s: dict[str, float]


@dataclass(frozen=True, eq=False)
class Run:
    """What a run did. `status` is "done", "interrupted" by the user, or "failed"; `steps` counts macro steps completed."""

    system: System
    algorithm: Algorithm
    step: float
    steps: int
    trajectory: Trajectory
    energy: tuple[BondEnergy, ...]
    timing: Timing
    status: Literal["done", "interrupted", "failed"]

    @property
    def energy_residual(self) -> float:
        """Energy (J) that the coupling added over all power bonds."""
        return sum(bond.residual for bond in self.energy)


def simulate(
    system: System,
    *,
    algorithm: Algorithm | None = None,
    step: float | None = None,
    stop: float | None = None,
    in_process: bool = False,
    progress: Progress | None = None,
) -> Run:
    """Open the system's components, run it from 0 to `stop` (s) at macro step `step` (s), and close them.

    algorithm : Jacobi(1) where None. step, stop : the system's own where None.
    in_process : components of the catalogue run in this process instead of as FMUs.
    progress : called now and then with the present time and the end (s).
    Raises ValueError for wrong use, SlaveError for a component that fails; its `partial` is the run up to there.
    """
    began = time.perf_counter()
    step, stop = system.step if step is None else step, system.stop if stop is None else stop
    macro_steps(step, stop)
    with open_network(system, in_process=in_process) as network:
        return run(network, algorithm or Jacobi(1), step, stop, progress=progress, began=began)


def open_network(system: System, *, in_process: bool = False) -> Network:
    """The system's slaves, opened and wired; close it after use."""
    slaves: list[Slave] = []
    try:
        for part in system.parts:
            slaves.append(open_slave(part.name, part.source, in_process=in_process))
        return Network(system, slaves)
    except BaseException:
        for slave in slaves:
            slave.close()
        raise


def macro_steps(step: float, stop: float) -> int:
    """How many macro steps of `step` (s) reach `stop` (s); the last may be shorter, so that it ends there exactly."""
    if not (np.isfinite(stop) and stop > 0.0):
        raise ValueError(f"`stop` must be positive, got {stop:g} s")
    if not (np.isfinite(step) and step > 0.0):
        raise ValueError(f"`step` must be positive, got {step:g} s")
    if step > stop * (1 + 1e-9):
        raise ValueError(f"`step` must be at most the run's length of {stop:g} s, got {step:g} s")
    return max(1, int(np.ceil(stop / step - 1e-9)))


def run(
    network: Network,
    algorithm: Algorithm,
    step: float,
    stop: float,
    *,
    progress: Progress | None = None,
    before_step: Callable[[int], None] | None = None,
    began: float | None = None,
) -> Run:
    """As simulate(), on an open network, which stays open; it starts anew.

    before_step : called before macro step k = 1, 2, ... with k; what paces a run to a clock waits here.
    began : when the set-up began (time.perf_counter), for the timing.
    """
    began = time.perf_counter() if began is None else began
    n = macro_steps(step, stop)
    Y = network.initialize(0.0, stop)
    t = np.arange(n + 1) * step
    t[-1] = stop
    last = stop - (n - 1) * step
    last = step if abs(last - step) <= 1e-9 * step else last
    values = np.empty((n + 1, Y.size))
    values[0] = Y
    history, meter = History(0.0, Y.copy(), step), EnergyMeter(network, Y)
    done, status, failure = 0, "done", None
    start = shown = time.perf_counter()
    try:
        for k in range(1, n + 1):
            if before_step is not None:
                before_step(k)
            h = last if k == n else step
            Y, used = algorithm.advance(network, history, h)
            values[k] = Y
            meter.record(h, Y, used)
            history.push(t[k], Y)
            done = k
            if progress is not None and k % 64 == 0 and (now := time.perf_counter()) - shown > 0.1:
                shown = now
                progress(t[k], stop)
    except KeyboardInterrupt:
        status = "interrupted"
    except RunError as error:
        status, failure = "failed", error
    loop = time.perf_counter() - start
    result = Run(
        network.system,
        algorithm,
        step,
        done,
        Trajectory(t[: done + 1], network.names, network.units, values[: done + 1]),
        meter.result(),
        Timing(start - began, loop, dict(zip((s.name for s in network.slaves), network.do_step_s, strict=True))),
        status,  # type: ignore[arg-type]
    )
    if failure is not None:
        failure.partial = result
        raise failure
    return result
