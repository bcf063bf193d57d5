"""The master: runs a system over macro steps and says what it cost and how much energy the coupling made."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..coupling import Algorithm, Jacobi
from ..errors import EndRequest, RunError
from ..network import Network
from ..slaves import Slave, open_slave
from ..slaves.fmi.unpacked import FmuCache
from ..systems import System
from ..trajectory import Trajectory
from .energy import BondEnergy, untrustworthy
from .stepping import Options, Progress, Stepper

__all__ = ["Options", "Run", "Status", "Timing", "macro_steps", "open_network", "run", "simulate"]

Status = Literal["done", "ended", "interrupted", "failed"]


@dataclass(frozen=True)
class Timing:
    """Seconds: opening and starting the slaves, the loop over macro steps, and in it each component's steps."""

    setup_s: float
    loop_s: float
    do_step_s: dict[str, float]

    @property
    def master_s(self) -> float:
        """What the loop spent outside the components' steps."""
        return self.loop_s - sum(self.do_step_s.values())


@dataclass(frozen=True, eq=False)
class Run:
    """What a run did.

    step : macro step (s), the first one where it adapts. steps : macro steps completed. start : when it began (s).
    status : "done", "ended" by a stop condition of the system or at a component's request, which `ended_by` tells,
    "interrupted" by the user, "failed".
    iterations : passes over macro steps where the algorithm iterates, in all.
    rejections : macro steps that were taken back to be done shorter.
    events : how many each component that tells of them has had; FMUs of FMI 3.0 with event mode do, others do not.
    """

    system: System
    algorithm: Algorithm
    step: float
    steps: int
    trajectory: Trajectory
    energy: tuple[BondEnergy, ...]
    timing: Timing
    status: Status
    iterations: int = 0
    rejections: int = 0
    ended_by: str = ""
    start: float = 0.0
    events: Mapping[str, int] = field(default_factory=dict)

    @property
    def coupling_warning(self) -> str:
        """Why the result should not be trusted, in words; empty where nothing speaks against it."""
        bond = untrustworthy(self.energy)
        if bond is None:
            return ""
        return (
            f"the coupling itself made or lost {bond.share:.2g} of the energy on {bond.name}: do not trust this result before "
            "you have it with a smaller macro step or a higher input degree (a certificate tells the largest stable step)"
        )

    @property
    def energy_residual(self) -> float:
        """Energy (J) that the coupling added over all power bonds."""
        return sum(bond.residual for bond in self.energy)


def simulate(
    system: System,
    *,
    algorithm: Algorithm | None = None,
    step: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    in_process: bool = False,
    isolate: bool = False,
    substeps: Mapping[str, int] | None = None,
    loops: Literal["solve", "refuse"] = "solve",
    options: Options | None = None,
    progress: Progress | None = None,
    before_step: Callable[[int], None] | None = None,
) -> Run:
    """Open the system's components, run it from `start` to `stop` (s) at macro step `step` (s), and close them.

    algorithm : Jacobi(1) where None. step, start, stop : the system's own where None.
    in_process : components of the catalogue run in this process instead of as FMUs. isolate : every FMU in a process of its own.
    substeps : component name -> in how many parts it does each macro step. loops : what to do with algebraic loops.
    progress : called now and then with how much is done and how much there is (s). before_step : see run().
    Raises ValueError for wrong use, SlaveError for a component that fails, ConvergenceError for an iteration without end;
    their `partial` is the run up to there.
    """
    began = time.perf_counter()
    step, stop = system.step if step is None else step, system.stop if stop is None else stop
    start = system.start if start is None else start
    macro_steps(step, stop, start)
    with open_network(system, in_process=in_process, isolate=isolate, substeps=substeps) as network:
        if loops == "refuse":
            network.refuse_loops()
        return run(
            network, algorithm or Jacobi(1), step, stop,
            start=start, options=options, progress=progress, before_step=before_step, began=began,
        )  # fmt: skip


def open_network(
    system: System, *, in_process: bool = False, isolate: bool = False, substeps: Mapping[str, int] | None = None
) -> Network:
    """The system's slaves, opened and wired; close it after use."""
    slaves: list[Slave] = []
    cache = FmuCache()
    try:
        for part in system.components:
            slaves.append(open_slave(part.name, part.source, in_process=in_process, isolate=isolate, cache=cache))
        return Network(system, slaves, substeps=substeps)
    except BaseException:
        for slave in slaves:
            slave.close()
        raise


def macro_steps(step: float, stop: float, start: float = 0.0) -> int:
    """How many macro steps of `step` lead from `start` to `stop` (s); the last may be shorter, so that it ends there exactly."""
    if not np.isfinite(start):
        raise ValueError(f"`start` must be finite, got {start:g} s")
    if not (np.isfinite(stop) and stop > start):
        rule = "positive" if start == 0.0 else f"after `start` at {start:g} s"
        raise ValueError(f"`stop` must be {rule}, got {stop:g} s")
    if not (np.isfinite(step) and step > 0.0):
        raise ValueError(f"`step` must be positive, got {step:g} s")
    length = stop - start
    if step > length * (1 + 1e-9):
        raise ValueError(f"`step` must be at most the run's length of {length:g} s, got {step:g} s")
    rounding = 4 * np.finfo(float).eps * abs(start)  # far from 0 the times themselves are rounded
    if step < 4 * rounding:
        raise ValueError(f"`step` must be told apart from rounding at `start` = {start:g} s, got {step:g} s")
    return max(1, int(np.ceil(length / step - 1e-9 - rounding / step)))


def run(
    network: Network,
    algorithm: Algorithm,
    step: float,
    stop: float,
    *,
    start: float | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    before_step: Callable[[int], None] | None = None,
    began: float | None = None,
) -> Run:
    """As simulate(), on an open network, which stays open; it starts anew.

    start : when it begins (s), the system's own where None.
    before_step : called before macro step k = 1, 2, ... with k; what paces a run to a clock waits here.
    began : when the set-up began (time.perf_counter), for the timing.
    """
    began = time.perf_counter() if began is None else began
    options = options or Options()
    start = network.system.start if start is None else start
    n = macro_steps(step, stop, start)
    algorithm.check(network)
    if options.checkpoint is not None:
        options.checkpoint.check(network)
        if options.adaptive is not None:
            raise ValueError("a checkpoint needs an even macro step, it cannot be combined with an adaptive one")
    march = Stepper(network, algorithm, step, start, stop, n, options)
    set_up = time.perf_counter()
    status: Status = "done"
    failure: RunError | None = None
    try:
        march.go(progress, before_step)
        status = "ended" if march.ended_by else "done"
        if status == "done":  # every slave is left with the inputs of the end, for what asks it afterwards
            network.outputs(march.history.Y[0].copy(), march.history.t[0])
    except KeyboardInterrupt:
        status = "interrupted"
    except EndRequest as request:
        status, march.ended_by = "ended", str(request)
    except RunError as error:
        status, failure = "failed", error
    march.hand_over()
    loop = time.perf_counter() - set_up
    result = Run(
        network.system, algorithm, step, march.done, march.recorder.finish(), march.meter.result(),
        Timing(set_up - began, loop, dict(zip((s.name for s in network.slaves), network.do_step_s, strict=True))),
        status, march.history.iterations, march.rejections, march.ended_by, start, network.events(),
    )  # fmt: skip
    if failure is not None:
        failure.partial = result
        raise failure
    return result
