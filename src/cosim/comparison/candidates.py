"""Is one unit as good as another? The same run with several variants of a component, against the first of them.

For every variant: the difference of every signal that it shares with the reference, the energy at its power bonds, and its
frequency response, effort over motion; and a verdict against tolerances.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..coupling import Algorithm, Jacobi
from ..errors import RunError, WiringError
from ..master import Progress, Run, macro_steps, open_network, run
from ..network import Network
from ..slaves import open_slave
from ..ssp import system as named_system
from ..systems import System
from ..trajectory import Trajectory
from .difference import Difference, difference
from .frequency_response import Response, measure
from .tolerances import Tolerances
from .unit_energy import UnitEnergy, energies

REST = 1e-9


@dataclass(frozen=True, eq=False)
class Candidate:
    """One variant in the comparison.

    failure : why its run failed, or empty; `run` then holds the part before. ignored : values that it has no parameter for.
    violations : what speaks against it, in words; none for the reference.
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

    @property
    def verdict(self) -> bool:
        """Whether it keeps the tolerances."""
        return not self.violations


@dataclass(frozen=True, eq=False)
class Comparison:
    """The candidates, the reference first; `component` is the name that addresses, in the system, what is exchanged."""

    system: System
    component: str
    candidates: tuple[Candidate, ...]
    tolerances: Tolerances

    @property
    def verdict(self) -> bool:
        """Whether every candidate keeps the tolerances."""
        return all(candidate.verdict for candidate in self.candidates)


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
    """Run `system` with each of `variants` in the place of `component` and compare with the first.

    variants : sources as System.with_source takes them, each perhaps with values of its own: "hil,rate_delay=5ms"; or the file
        of a whole system, for a unit whose signals are called otherwise.
    values : ("component.variable", value) for all; those of the component go to the variants that have the variable.
    tolerances : where None, 5 % of rms and peak on every signal of the other components.
    responses : whether to measure the frequency responses too.
    Raises ValueError for wrong use: fewer than two variants, one without the connector, tolerances on signals that are not
    there, a sampling period that does not fit the step; RunError where the reference fails.
    """
    if len(variants) < 2:
        raise ValueError(f"compare needs at least two variants, got {len(variants)}")
    component = system.exchanged(component)
    members = system.addressed(component)
    step, stop = system.step if step is None else step, system.stop if stop is None else stop
    macro_steps(step, stop, system.start)
    plans = [_plan(system, component, text, values, in_process, step) for text in variants]
    _refuse_values_nobody_takes(plans)
    labels = _labels(variants)
    done: list[Candidate] = []
    drive: dict[str, float] = {}
    for k, ((plan, ignored), label) in enumerate(zip(plans, labels, strict=True)):
        show = None if progress is None else lambda t, end, k=k: progress(k * end + t, len(plans) * end)
        candidate, drive = _candidate(
            plan, members, label, ignored, algorithm or Jacobi(1), step, stop, in_process, drive, responses, show
        )
        done.append(candidate)
    reference = done[0]
    if reference.run is None or reference.failure:
        raise RunError(f"the reference {reference.label!r} failed: {reference.failure}")
    limits = tolerances or five_percent(system, component)
    if tolerances is not None:
        tolerances.check(reference.run.trajectory.names)
    judged = tuple(_judged(reference, candidate, limits) for candidate in done)
    return Comparison(system, component, judged, limits)


def five_percent(system: System, component: str) -> Tolerances:
    """The tolerances where none are given: 5 % of rms and peak on every signal of the components beside the exchanged one."""
    others = [part.name for part in system.components if part.name not in system.addressed(component)]
    return Tolerances({f"{name}.*": {"rms": 0.05, "peak": 0.05} for name in others})


def _plan(
    system: System, component: str, text: str, values: Sequence[tuple[str, str | float]], in_process: bool, step: float
) -> tuple[System, tuple[str, ...]]:
    """The system with the variant that `text` names and the values it takes, and those it has no parameter for.

    What the system itself sets on its units is treated as `values` are.
    """
    source, *own = (part.strip() for part in text.split(","))
    members = system.addressed(component)
    values = [(f"{p.name}.{n}", v) for p in system.components if p.name in members for n, v in p.values.items()] + list(values)
    bare = replace(system, components=tuple(replace(p, values={}) if p.name in members else p for p in system.components))
    plan = named_system(source) if source.endswith((".ssd", ".ssp")) else bare.with_source(component, source)
    ignored = []
    first = next(part for part in plan.components if part.name in members)
    slave = open_slave(first.name, first.source, in_process=in_process)
    try:
        settable = slave.description.settable
        period = [s for n, s in settable.items() if n.endswith("sampling_period")]
    finally:
        slave.close()
    for target, value in values:
        name, _, variable = target.partition(".")
        if set(plan.addressed(name)) <= set(members) and variable not in settable:
            ignored.append(target)
        else:
            plan = plan.with_value(target, value)
    for assignment in own:
        variable, equals, value = assignment.partition("=")
        if not equals:
            raise ValueError(f"a variant must be SOURCE,PARAMETER=VALUE,..., got {text!r}")
        plan = plan.with_value(f"{component}.{variable.strip()}", value.strip())
    chosen = next(part for part in plan.components if part.name == first.name).values
    for signal in period:
        value = signal.value(chosen.get(signal.name, signal.start or 0.0))
        if isinstance(value, float):
            check_period(f"{first.name}.{signal.name}", value, step)
    return plan, tuple(ignored)


def check_period(name: str, period: float, step: float) -> None:
    """ValueError where a sampling period (s) neither divides the macro step (s) nor is a multiple of it; 0 is no sampling."""
    if period <= 0.0:
        return
    ratio = max(period, step) / min(period, step)
    if abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{name} must divide the macro step of {step:g} s or be a multiple of it, got {period:g} s")


def _refuse_values_nobody_takes(plans: Sequence[tuple[System, tuple[str, ...]]]) -> None:
    for target in plans[0][1]:
        if all(target in ignored for _, ignored in plans):
            raise ValueError(f"no variant has the parameter {target!r}")


def _labels(variants: Sequence[str]) -> list[str]:
    """What each variant is called: as given, files without their folder, a number behind what stands twice."""
    shown = [",".join((Path(head).name if "/" in head else head, *own)) for head, *own in (v.split(",") for v in variants)]
    return [f"{s} #{shown[: i + 1].count(s)}" if shown[:i].count(s) else s for i, s in enumerate(shown)]


def _candidate(
    plan: System, members: Sequence[str], label: str, ignored: tuple[str, ...], algorithm: Algorithm, step: float, stop: float,
    in_process: bool, drive: dict[str, float], responses: bool, progress: Progress | None,
) -> tuple[Candidate, dict[str, float]]:  # fmt: skip
    """Run one variant; `drive` holds the rms of each bond's motion in the reference run, filled by the first."""
    source = next(part.source for part in plan.components if part.name in members)
    try:
        network = open_network(plan, in_process=in_process)
    except WiringError as error:
        raise ValueError(f"variant {label!r} must have the connector of {members[0]!r}: {error}") from None
    except ValueError as error:
        missing = str(error).startswith(("unknown input", "unknown output"))
        words = f"variant {label!r} must have the connector of {members[0]!r}: {error}" if missing else str(error)
        raise ValueError(words) from None
    with network:
        failure = ""
        try:
            result = run(network, algorithm, step, stop, progress=progress)
        except RunError as error:
            if error.partial is None:
                raise
            failure, result = str(error), error.partial
        made = Candidate(label, source, result, failure, ignored, energies=energies(network, members, result.trajectory))
        if not drive:
            drive = {b.name: float(np.sqrt(np.mean(result.trajectory.values[:, b.motion] ** 2))) for b in network.bonds}
        if responses and not failure:
            made = replace(made, responses=_responses(network, members[0], drive, step))
    return made, drive


def _responses(network: Network, member: str, drive: Mapping[str, float], step: float) -> tuple[Response, ...]:
    """Effort over motion at every bond of one unit; a bond that rests in the reference run is driven with 1."""
    found = []
    for bond in network.bonds:
        i, place = bond.motion_input
        slave = network.slaves[i]
        if slave.name == member:
            row = bond.effort - network.slices[i].start
            found.append(
                measure(slave, network.values[i], place, row, rms=drive.get(bond.name) or 1.0, step=step, name=bond.name)
            )
    return tuple(found)


def _judged(reference: Candidate, own: Candidate, tolerances: Tolerances) -> Candidate:
    assert reference.run is not None
    if own.run is None or own.failure:
        return replace(own, violations=(own.failure,))
    found, broken = judge(reference.run.trajectory, own.run.trajectory, tolerances)
    if own is not reference and tolerances.created is not None:
        for energy in own.energies:
            if energy.share is not None and energy.share > tolerances.created:
                share, limit = f"{energy.share:.3g}", f"{tolerances.created:g}"
                broken.append(f"{energy.unit}: creates {share} of the energy that crosses, beyond {limit}")
    return replace(own, differences=found, violations=() if own is reference else tuple(broken))


def judge(reference: Trajectory, own: Trajectory, tolerances: Tolerances) -> tuple[dict[str, Difference], list[str]]:
    """The differences of every signal that both have, and in words which of them are beyond the tolerances.

    A signal is at rest below REST of the largest one of its unit, or of 1 in SI.
    """
    largest: dict[str, float] = {}
    for name, unit in zip(reference.names, reference.units, strict=True):
        largest[unit] = max(largest.get(unit, 1.0), float(np.abs(reference[name]).max()))
    found = {
        n: difference(reference.t, reference[n], own[n], REST * largest[reference.unit(n)])
        for n in reference.names if n in own.names
    }  # fmt: skip
    broken = []
    for name, d in found.items():
        limits = tolerances.limits(name)
        for key, value in (("rms", d.rms), ("peak", d.peak), ("shift", abs(d.shift))):
            if key in limits and not value <= limits[key]:
                unit_of = " s" if key == "shift" else ""
                broken.append(f"{name}: {key} {value:.3g}{unit_of} beyond {limits[key]:g}{unit_of}")
    return found, broken
