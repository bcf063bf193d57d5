"""The master: runs a system over macro steps and says what it cost and how much energy the coupling made."""

import logging
import time
from collections.abc import Callable, Mapping
from typing import Literal

from ..coupling import Algorithm, Jacobi
from ..errors import EndRequest, RunError
from ..network import Network
from ..slaves import Slave, open_slave
from ..slaves.fmi.unpacked import FmuCache
from ..systems import System
from ..trajectory import Trajectory
from .progress import Progress
from .results import Run, Status, Timing
from .stepping import Options, Stepper
from .time_grid import TimeGrid, macro_steps

__all__ = ["Options", "Run", "Status", "Timing", "macro_steps", "open_network", "run", "simulate"]

_log = logging.getLogger(__name__)


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
    """Open the system's components, run it, and close them.

    Parameters
    ----------
    system : System
        What is run.
    algorithm : Algorithm, optional
        How the components are coupled; Jacobi(1) where None.
    step, start, stop : float, optional
        Macro step, begin and end, s; the system's own where None.
    in_process : bool
        Run components of the catalogue in this process instead of as FMUs.
    isolate : bool
        Run every FMU in a process of its own.
    substeps : mapping of str to int, optional
        In how many parts a component, by its name, does each macro step.
    loops : {"solve", "refuse"}
        What to do with algebraic loops.
    options : Options, optional
        Recording, adaptive macro steps, checkpoints.
    progress : callable, optional
        Called now and then with how much is done and how much there is, s.
    before_step : callable, optional
        See run().

    Returns
    -------
    Run
        Results, energy of the coupling, times.

    Raises
    ------
    ValueError
        Wrong use; nothing has run.
    SlaveError
        A component failed; `partial` is the run up to there.
    ConvergenceError
        An iteration did not end; `partial` is the run up to there.
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
    """Open and wire the slaves of a system.

    Parameters
    ----------
    system : System
        What is opened.
    in_process, isolate, substeps
        See simulate().

    Returns
    -------
    Network
        To be closed after use: `with open_network(system) as network`.

    Raises
    ------
    ValueError
        A component that is not there, a connection that cannot be made.
    """
    if not system.components:
        raise ValueError(f"system {system.name!r} holds no component, there is nothing to run")
    slaves: list[Slave] = []
    cache = FmuCache()
    try:
        for part in system.components:
            began = time.perf_counter()
            slave = open_slave(
                part.name, part.source, in_process=in_process, isolate=isolate, cache=cache, implementation=part.implementation,
                values=part.given,
            )  # fmt: skip
            slaves.append(slave)
            _log.info("opened %s (%s) in %.3f s", part.name, part.source, time.perf_counter() - began)
        return Network(system, slaves, substeps=substeps)
    except BaseException:
        for slave in slaves:
            slave.close()
        raise


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
    begun: Callable[["Running"], None] | None = None,
) -> Run:
    """As simulate(), on an open network, which stays open; the run starts anew.

    Parameters
    ----------
    network : Network
        Of open_network().
    algorithm, step, stop, start, options, progress
        See simulate().
    before_step : callable, optional
        Called before macro step k = 1, 2, ... with k; what paces a run to a clock waits here.
    began : float, optional
        When the set-up began (time.perf_counter), for the timing.
    begun : callable, optional
        Called with the run once it has begun: for who must have its results if a component takes the process down.

    Returns
    -------
    Run
        See simulate(), as for the errors.
    """
    running = Running(network, algorithm, step, stop, start=start, options=options, began=began)
    if begun is not None:
        begun(running)
    status: Status = "done"
    failure: RunError | None = None
    request = ""
    try:
        running.stepper.go(progress, before_step)
        status = running.reached()
    except KeyboardInterrupt:
        status = "interrupted"
    except EndRequest as error:
        status, request = "ended", str(error)
    except RunError as error:
        status, failure = "failed", error
    result = running.result(status, request)
    if failure is not None:
        raise failure.keeping(result)
    return result


class Running:
    """A run between its begin and its result. Parameters, errors: see run().

    Attributes
    ----------
    stepper : Stepper
        What takes it to its end.
    """

    def __init__(
        self, network: Network, algorithm: Algorithm, step: float, stop: float, *, start: float | None = None,
        options: Options | None = None, began: float | None = None,
    ) -> None:  # fmt: skip
        self._began = time.perf_counter() if began is None else began
        options = options or Options()
        self._start = network.system.start if start is None else start
        grid = TimeGrid.over(step, stop, self._start)
        algorithm.check(network)
        if options.checkpoint is not None:
            options.checkpoint.check(network)
            if options.adaptive is not None:
                raise ValueError("a checkpoint needs an even macro step, it cannot be combined with an adaptive one")
        self._network, self._algorithm, self._step, self._adaptive = network, algorithm, step, options.adaptive
        self.stepper = Stepper(network, algorithm, grid, options)
        self._set_up = time.perf_counter()

    def rescue(self) -> tuple[Trajectory, str]:
        """The results so far of a run that never comes back, and the component that it is at, if that is known."""
        name = self.stepper.rescue()
        return self.stepper.finish(cut_off=True)[2].finish(), name

    def reached(self) -> Status:
        """How a run that nothing stopped has ended."""
        state = self.stepper.state
        if state.ended_by:
            return "ended"
        newest = state.history  # every slave is left with the inputs of the end, for what asks it afterwards
        self._network.outputs(newest.Y[0].copy(), newest.t[0])
        return "done"

    def result(self, status: Status, request: str = "") -> Run:
        """The run, which ended with `status`. request : why a component has asked for its end."""
        state, meter, recorder = self.stepper.finish(cut_off=status == "failed" or bool(request))
        loop, network = time.perf_counter() - self._set_up, self._network
        counts = network.counts()
        return Run(
            system=network.system,
            algorithm=self._algorithm,
            step=self._step,
            steps=state.done,
            trajectory=recorder.finish(),
            energy=meter.result(state.energy),
            timing=Timing(self._set_up - self._began, loop, network.do_step_s),
            status=status,
            iterations=state.passes,
            rejections=state.rejections,
            ended_by=state.ended_by or request,
            start=self._start,
            events={name: c.events for name, c in counts.items() if c.events is not None},
            without_kernel=self.stepper.without_kernel,
            notes=(*network.notes, *self.stepper.notes),
            adaptive=self._adaptive,
            happened=self.stepper.happened,
            warnings={name: (c.warnings, c.first_warning) for name, c in counts.items() if c.warnings},
        )
