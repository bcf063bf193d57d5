"""Is one unit as good as another? The same run with several variants of a component, against the first of them.

For every variant: the difference of every signal that it shares with the reference, the energy at its power bonds, and its
frequency response, effort over motion; and a verdict against tolerances.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..coupling import Algorithm, Jacobi
from ..errors import RunError, WiringError
from ..master import Progress, Run, macro_steps, open_network, run
from ..network import Network
from ..systems import System
from ..trajectory import Trajectory
from .difference import Difference
from .frequency_response import Response, measure
from .tolerances import Tolerances
from .unit_energy import UnitEnergy, energies
from .variants import labels, refuse_values_nobody_takes, variant_plan
from .verdict import five_percent, judge, undecided


@dataclass(frozen=True, eq=False)
class Candidate:
    """One variant in the comparison.

    Parameters
    ----------
    label, source : str
        What it is called, and where its component comes from.
    run : Run or None
        Its run, up to where it failed.
    failure : str
        Why its run failed, or empty.
    ignored : tuple of str
        Values that it has no parameter for.
    differences : mapping of str to Difference
        Of every signal that it shares with the reference.
    energies : tuple of UnitEnergy
        At the power bonds of each component exchanged.
    responses : tuple of Response
        Effort over motion at each bond of the first component exchanged.
    violations : tuple of str
        What speaks against it, in words; none for the reference.
    undecided : str
        Why nothing speaks for it either, or empty.
    """

    label: str
    source: str
    run: Run | None
    failure: str = ""
    ignored: tuple[str, ...] = ()
    differences: Mapping[str, Difference] = field(default_factory=dict)
    energies: tuple[UnitEnergy, ...] = ()
    responses: tuple[Response, ...] = ()
    violations: tuple[str, ...] = ()
    undecided: str = ""

    @property
    def verdict(self) -> bool | None:
        """Whether it keeps the tolerances; None where that cannot be decided."""
        return False if self.violations else None if self.undecided else True


@dataclass(frozen=True, eq=False)
class Comparison:
    """The same run with several variants of a component.

    Parameters
    ----------
    system : System
        Without a variant.
    component : str
        What is exchanged in it, as System.addressed() takes it.
    candidates : tuple of Candidate
        The reference first.
    tolerances : Tolerances
        What the verdict goes by.
    """

    system: System
    component: str
    candidates: tuple[Candidate, ...]
    tolerances: Tolerances

    @property
    def verdict(self) -> bool | None:
        """Whether every candidate keeps the tolerances; None where that cannot be decided of one and none breaks them."""
        verdicts = [candidate.verdict for candidate in self.candidates]
        return False if False in verdicts else None if None in verdicts else True

    @property
    def undecided(self) -> str:
        """Why the verdict cannot be decided, or empty."""
        return next((c.undecided for c in self.candidates if c.undecided), "") if self.verdict is None else ""


def compare(
    system: System,
    variants: Sequence[str],
    *,
    component: str | None = None,
    values: Sequence[tuple[str, str | float]] = (),
    tolerances: Tolerances | None = None,
    algorithm: Algorithm | None = None,
    step: float | None = None,
    stop: float | None = None,
    in_process: bool = False,
    responses: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Run a system with each of several variants of a component and compare with the first.

    Parameters
    ----------
    system : System
        What is run.
    variants : sequence of str
        Sources as System.with_source() takes them, each perhaps with values of its own: "hil,rate_delay=5ms"; or the file of
        a whole system, for a unit whose signals are called otherwise.
    component : str, optional
        What is exchanged; the component that the system names otherwise.
    values : sequence of (str, value)
        `component.variable` and value for all; those of the component go to the variants that have the variable.
    tolerances : Tolerances, optional
        5 % of rms and peak on every signal of the other components otherwise.
    algorithm : Algorithm, optional
        Jacobi(1) otherwise.
    step, stop : float, optional
        Macro step and end of the runs (s); the system's own otherwise.
    in_process : bool
        Whether components run in this process instead of as FMUs.
    responses : bool
        Whether to measure the frequency responses too.
    progress : Progress, optional
        Called with how much is done and how much there is.

    Returns
    -------
    Comparison
        The candidates in the order of `variants`, with the verdict.

    Raises
    ------
    ValueError
        Fewer than two variants, one without the connector, tolerances on signals that are not there, a sampling period that
        does not fit the step.
    RunError
        Where the reference fails.
    """
    if len(variants) < 2:
        raise ValueError(f"compare needs at least two variants, got {len(variants)}")
    component = system.exchanged(component)
    exchanged = system.addressed(component)
    step, stop = system.step if step is None else step, system.stop if stop is None else stop
    macro_steps(step, stop, system.start)
    plans = [variant_plan(system, component, text, values, in_process, step) for text in variants]
    refuse_values_nobody_takes(plans)
    names = labels(variants)
    done: list[Candidate] = []
    drive: dict[str, float] = {}
    for k, ((plan, ignored), label) in enumerate(zip(plans, names, strict=True)):
        show = None if progress is None else lambda t, end, k=k: progress(k * end + t, len(plans) * end)
        candidate, drive = _candidate(
            plan, exchanged, label, ignored, algorithm or Jacobi(1), step, stop, in_process, drive, responses, show
        )
        done.append(candidate)
    reference = done[0]
    if reference.run is None or reference.failure:
        raise RunError(f"the reference {reference.label!r} failed: {reference.failure}")
    limits = tolerances or five_percent(system, component)
    if tolerances is not None:
        tolerances.check(reference.run.trajectory.names)
    judged = tuple(_judged(component, reference, candidate, limits) for candidate in done)
    return Comparison(system, component, judged, limits)


def _candidate(
    plan: System, exchanged: Sequence[str], label: str, ignored: tuple[str, ...], algorithm: Algorithm, step: float, stop: float,
    in_process: bool, drive: dict[str, float], responses: bool, progress: Progress | None,
) -> tuple[Candidate, dict[str, float]]:  # fmt: skip
    """Run one variant; `drive` holds the rms of each bond's motion in the reference run, filled by the first."""
    source = next(c.source for c in plan.components if c.name in exchanged)
    try:
        network = open_network(plan, in_process=in_process)
    except WiringError as error:
        raise ValueError(f"variant {label!r} must have the connector of {exchanged[0]!r}: {error}") from None
    except ValueError as error:
        missing = str(error).startswith(("unknown input", "unknown output"))
        words = f"variant {label!r} must have the connector of {exchanged[0]!r}: {error}" if missing else str(error)
        raise ValueError(words) from None
    with network:
        failure = ""
        try:
            result = run(network, algorithm, step, stop, progress=progress)
        except RunError as error:
            if error.partial is None:
                raise
            failure, result = str(error), error.partial
        made = Candidate(label, source, result, failure, ignored, energies=energies(network, exchanged, result.trajectory))
        if not drive:
            drive = {b.name: float(np.sqrt(np.mean(result.trajectory.values[:, b.motion] ** 2))) for b in network.bonds}
        if responses and not failure:
            made = replace(made, responses=_responses(network, exchanged[0], drive, step))
    return made, drive


def _responses(network: Network, component: str, drive: Mapping[str, float], step: float) -> tuple[Response, ...]:
    """Effort over motion at every bond of one unit; a bond that rests in the reference run is driven with 1."""
    found = []
    for bond in network.bonds:
        i, place = bond.motion_input
        slave = network.slaves[i]
        if slave.name == component:
            row = bond.effort - network.slices[i].start
            found.append(
                measure(slave, network.values[i], place, row, rms=drive.get(bond.name) or 1.0, step=step, name=bond.name)
            )
    return tuple(found)


def _until(trajectory: Trajectory, n: int) -> Trajectory:
    return trajectory if len(trajectory) == n else replace(trajectory, t=trajectory.t[:n], values=trajectory.values[:n])


def _judged(component: str, reference: Candidate, own: Candidate, tolerances: Tolerances) -> Candidate:
    assert reference.run is not None
    if own.run is None or own.failure:
        return replace(own, violations=(own.failure,))
    n = min(len(reference.run.trajectory), len(own.run.trajectory))  # one may have ended early, as a derailed vehicle does
    found, broken = judge(_until(reference.run.trajectory, n), _until(own.run.trajectory, n), tolerances)
    if own is reference:
        return replace(own, differences=found)
    if len(reference.run.trajectory) != len(own.run.trajectory):
        ends = [f"{c.label} at t = {c.run.trajectory.t[-1]:.9g} s{c.run.ended_by and f' ({c.run.ended_by})'}"
                for c in (own, reference) if c.run is not None]  # fmt: skip
        broken.insert(0, f"the runs must end together, {' and '.join(ends)}: compared as far as both go")
    if tolerances.created is not None:
        for energy in own.energies:
            if energy.share is not None and not energy.share <= tolerances.created:
                share, limit = f"{energy.share:.3g}", f"{tolerances.created:g}"
                broken.append(f"{energy.unit}: creates {share} of the energy that crosses, beyond {limit}")
    systems = (reference.run.system, own.run.system)
    why = undecided(component, systems, reference.run.trajectory, own.run.trajectory, own.energies, tolerances)
    return replace(own, differences=found, violations=tuple(broken), undecided="" if broken else why)
