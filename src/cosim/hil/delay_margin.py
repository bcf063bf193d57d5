"""How much delay can a unit's answer have? The largest loop delay that leaves the system stable, or within tolerances.

Two ways that must agree: the eigenvalues (or the course) of the sampled, delayed, linearised system of sampled_model.py, exact
for a linear system under Jacobi; and bisection on runs, which take any component, algorithm and compensator. In a loop only
the sum of the delays there and back counts for stability, so the delay is put on the way back.

A run is unstable where the motion at the power bonds has grown: its rms over the last third of the run is larger than over the
first or the second. (Larger than the first: a nonlinear unit may hold the growth at an oscillation that lasts.)
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..comparison.tolerances import Tolerances
from ..comparison.verdict import judge
from ..coupling import Algorithm, Jacobi
from ..errors import RunError
from ..master import Progress, Run, macro_steps, open_network, run
from ..network import Network
from ..slaves import Slave, open_slave
from ..systems import System
from ..trajectory import Trajectory
from .compensation import Compensator, Uncompensated
from .delayed_slave import DelayedSlave
from .sampled_model import SampledModel, linearise


@dataclass(frozen=True)
class Compensation:
    """What stands at the receiving end of the delayed signals.

    Parameters
    ----------
    compensator : Compensator
        A filter that extrapolates.
    model : str
        The variant that predicts; empty for none.
    passive : bool
        Whether there is a passivity controller.
    """

    compensator: Compensator = field(default_factory=Uncompensated)
    model: str = ""
    passive: bool = False

    @property
    def name(self) -> str:
        """As the command line writes it."""
        words = [self.compensator.name] * (self.compensator.name != "none")
        words += [f"model:{self.model}"] * bool(self.model) + ["passivity"] * self.passive
        return "+".join(words) or "none"

    @property
    def linear(self) -> bool:
        """Whether the eigenvalues can tell."""
        return not self.model and not self.passive


@dataclass(frozen=True)
class DelayStudy:
    """What is studied: a component of a system behind a delay.

    Parameters
    ----------
    system : System
        With all its values.
    step, stop : float
        Macro step and end of the runs (s).
    component : str or None
        Whose answer is late; None: the one that the system says people exchange in it.
    algorithm : Algorithm
        Of the coupling.
    remedy : Compensation
        What stands at the receiving end.
    in_process : bool
        Whether components run in this process instead of as FMUs.
    longest : float
        The longest delay that is tried (s).
    resolution : float
        Relative width of the last interval of the bisection.

    Raises
    ------
    ValueError
        Where step and stop do not fit, `longest` is shorter than a step, or there is no such component.
    """

    system: System
    step: float
    stop: float
    component: str | None = None
    algorithm: Algorithm = field(default_factory=Jacobi)
    remedy: Compensation = field(default_factory=Compensation)
    in_process: bool = True
    longest: float = 0.5
    resolution: float = 0.01

    def __post_init__(self) -> None:
        self.system.exchanged(self.component)
        macro_steps(self.step, self.stop, self.system.start)
        if not self.longest >= self.step:
            raise ValueError(f"the longest delay must be at least the macro step of {self.step:g} s, got {self.longest:g} s")

    @property
    def delayed(self) -> str:
        """The component whose answer is late."""
        return self.system.exchanged(self.component)


@dataclass(frozen=True)
class Margin:
    """The largest delay that is still good.

    Parameters
    ----------
    delay : float or None
        s; None where even no delay is good, the study's `longest` where all that were tried are.
    tried : int
        How many delays were tried.
    """

    delay: float | None
    tried: int


def largest(good: Callable[[float], bool], setting: DelayStudy, progress: Progress | None = None) -> Margin:
    """The largest delay up to the first that is not good: a geometric grid finds it, bisection refines it."""
    grid = [0.0, *np.geomspace(setting.step / 2, setting.longest, 16)]
    below, above, tried = None, None, 0
    steps = int(np.ceil(np.log2(grid[2] / grid[1] / setting.resolution)))
    for d in grid:
        tried += 1
        if progress is not None:
            progress(tried, len(grid) + steps)
        if not good(float(d)):
            above = float(d)
            break
        below = float(d)
    if below is None or above is None:
        return Margin(below, tried)
    while above - below > setting.resolution * above:
        middle = (below + above) / 2
        below, above = (middle, above) if good(middle) else (below, middle)
        tried += 1
    return Margin(below, tried)


def by_eigenvalues(setting: DelayStudy, model: SampledModel | None = None) -> Margin:
    """The largest stable delay from the eigenvalues of the macro step."""
    degree, model = _degree(setting), model or linearise(setting.system, setting.delayed)

    def stable(d: float) -> bool:
        return model.radius(setting.remedy.compensator.taps(d / setting.step), degree, setting.step) < 1.0 + 1e-9

    return largest(stable, setting)


def by_runs(setting: DelayStudy, progress: Progress | None = None) -> Margin:
    """The largest stable delay from runs, which must hold several periods of the slowest motion for growth to show."""

    def stable(d: float) -> bool:
        try:
            with delayed_network(setting, d) as network:
                result = run(network, setting.algorithm, setting.step, setting.stop)
                motions = [bond.motion for bond in network.bonds]
        except RunError:
            return False
        w = result.trajectory.values[:, motions]
        first, second, last = (float((third**2).mean()) for third in np.array_split(w, 3))
        return last <= min(first, second)

    return largest(stable, setting, progress)


def verdict_by_runs(setting: DelayStudy, tolerances: Tolerances, progress: Progress | None = None) -> Margin:
    """The largest delay whose run keeps the tolerances against the run without."""
    reference = _run(setting, 0.0, plain=True).trajectory
    tolerances.check(reference.names)

    def kept(d: float) -> bool:
        try:
            return not judge(reference, _run(setting, d).trajectory, tolerances)[1]
        except RunError:
            return False

    return largest(kept, setting, progress)


def verdict_by_model(setting: DelayStudy, tolerances: Tolerances) -> Margin:
    """The same from the course of the sampled linear system."""
    degree, model = _degree(setting), linearise(setting.system, setting.delayed)
    start = setting.system.start
    n = macro_steps(setting.step, setting.stop, start)

    def course(compensator: Compensator, d: float) -> Trajectory:
        with np.errstate(over="ignore", invalid="ignore"):
            values = model.run(compensator.taps(d / setting.step), degree, setting.step, n)
        return Trajectory(start + np.arange(n + 1) * setting.step, model.names, model.units, values)

    reference = course(Uncompensated(), 0.0)
    tolerances.check(reference.names)

    def kept(d: float) -> bool:
        found = course(setting.remedy.compensator, d)
        return bool(np.isfinite(found.values).all()) and not judge(reference, found, tolerances)[1]

    return largest(kept, setting)


def _degree(setting: DelayStudy) -> int:
    if setting.algorithm.name != "jacobi" or not setting.remedy.linear:
        raise ValueError(
            "eigenvalues need the algorithm jacobi and a linear compensator, "
            f"got {setting.algorithm.name} and {setting.remedy.name}; runs take any"
        )
    return setting.algorithm.degree


def _run(setting: DelayStudy, delay: float, *, plain: bool = False) -> Run:
    if plain:
        setting = replace(setting, remedy=Compensation())
    with delayed_network(setting, delay) as network:
        return run(network, setting.algorithm, setting.step, setting.stop)


def delayed_network(setting: DelayStudy, delay: float) -> Network:
    """The system's slaves with those of the delayed component behind their interfaces; close it after use."""
    plain = open_network(setting.system, in_process=setting.in_process)
    late = setting.system.addressed(setting.delayed)
    slaves: list[Slave] = []
    try:
        for i, slave in enumerate(plain.slaves):
            pairs = [(b.motion_input[1], b.effort - plain.slices[i].start) for b in plain.bonds if b.motion_input[0] == i]
            if slave.name in late and pairs:
                model = None
                if setting.remedy.model:
                    source = next(p.source for p in setting.system.with_source(setting.delayed, setting.remedy.model).components
                                  if p.name == slave.name)  # fmt: skip
                    model = open_slave(slave.name, source, in_process=setting.in_process)
                slave = DelayedSlave(
                    slave, pairs, step=setting.step, delay=delay, compensator=setting.remedy.compensator, model=model,
                    passive=setting.remedy.passive,
                )  # fmt: skip
            slaves.append(slave)
        return Network(setting.system, slaves)
    except BaseException:
        for slave in (*slaves, *plain.slaves[len(slaves) :]):
            slave.close()
        raise


@dataclass(frozen=True, eq=False)
class DelayMap:
    """Largest stable delay over macro step and a parameter.

    Parameters
    ----------
    parameter, unit : str
        `component.parameter` and its unit.
    values : ndarray, shape (m,)
        Of the parameter, in its unit.
    steps : ndarray, shape (n,)
        Macro steps (s).
    delay : ndarray, shape (n, m)
        s; NaN where not even no delay is stable.
    longest : float
        The longest delay that was tried (s).
    """

    parameter: str
    unit: str
    values: np.ndarray
    steps: np.ndarray
    delay: np.ndarray
    longest: float


def delay_map(
    setting: DelayStudy, parameter: str, values: np.ndarray, steps: np.ndarray, unit: str, progress: Progress | None = None
) -> DelayMap:
    """by_eigenvalues() over a grid of a parameter, in its `unit`, and macro steps (s)."""
    found = np.full((steps.size, values.size), np.nan)
    for j, value in enumerate(values):
        plan = setting.system.with_value(parameter, float(value))
        model = linearise(plan, setting.delayed)
        for i, step in enumerate(steps):
            margin = by_eigenvalues(replace(setting, system=plan, step=float(step)), model)
            found[i, j] = np.nan if margin.delay is None else margin.delay
            if progress is not None:
                progress(j * steps.size + i + 1, found.size)
    return DelayMap(parameter, unit, values, steps, found, setting.longest)
