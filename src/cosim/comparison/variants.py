"""A system with one variant of what is exchanged in it: which values it takes, and what it is called."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..slaves import open_slave
from ..ssp import system as named_system
from ..systems import System
from ..systems.riding import settled
from ..systems.swap import told_apart


def variant_plan(
    system: System, component: str, text: str, values: Sequence[tuple[str, str | float]], in_process: bool, step: float
) -> tuple[System, tuple[str, ...]]:
    """The system with the variant that `text` names and the values it takes, and those it has no parameter for.

    What the system itself sets on its units is treated as `values` are. FOREIGN=OURS behind a source says that it calls a
    signal otherwise than the system.
    """
    source, *words = (word.strip() for word in text.split(","))
    renamed, own = told_apart(words, system.signals_of(component))
    exchanged = system.addressed(component)
    values = [(f"{p.name}.{n}", v) for p in system.components if p.name in exchanged for n, v in p.values.items()] + list(values)
    bare = replace(system, components=tuple(replace(p, values={}) if p.name in exchanged else p for p in system.components))
    if source.endswith((".ssd", ".ssp", ".toml")):  # a system of its own, in which the same happens
        plan = replace(named_system(source), inputs=system.inputs, scenario=system.scenario)
    else:
        plan = bare.with_source(component, source, renamed)
    ignored = []
    first = next(c for c in plan.components if c.name in exchanged)
    slave = open_slave(first.name, first.source, in_process=in_process)
    try:
        settable = slave.description.settable
        period = [s for n, s in settable.items() if n.endswith("sampling_period")]
    finally:
        slave.close()
    for target, value in values:
        name = system.owner(target) or target.partition(".")[0]
        variable = target[len(name) + 1 :]
        if set(plan.addressed(name)) <= set(exchanged) and variable not in settable:
            ignored.append(target)
        else:
            plan = plan.with_value(target, value)
    for assignment in own:
        variable, equals, value = assignment.partition("=")
        if not equals:
            raise ValueError(f"a variant must be SOURCE,PARAMETER=VALUE,..., got {text!r}")
        plan = plan.with_value(f"{component}.{variable.strip()}", value.strip())
    chosen = next(c for c in plan.components if c.name == first.name).values
    for signal in period:
        value = signal.value(chosen.get(signal.name, signal.start or 0.0))
        if isinstance(value, float):
            check_period(f"{first.name}.{signal.name}", value, step)
    return settled(plan), tuple(ignored)


def check_period(name: str, period: float, step: float) -> None:
    """ValueError where a sampling period (s) neither divides the macro step (s) nor is a multiple of it; 0 is no sampling."""
    if period <= 0.0:
        return
    ratio = max(period, step) / min(period, step)
    if abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{name} must divide the macro step of {step:g} s or be a multiple of it, got {period:g} s")


def refuse_values_nobody_takes(plans: Sequence[tuple[System, tuple[str, ...]]]) -> None:
    """ValueError where a value is for a parameter that no variant has."""
    for target in plans[0][1]:
        if all(target in ignored for _, ignored in plans):
            raise ValueError(f"no variant has the parameter {target!r}")


def labels(variants: Sequence[str]) -> list[str]:
    """What each variant is called: as given, files without their folder, a number behind what stands twice."""
    shown = [",".join((Path(head).name if "/" in head else head, *own)) for head, *own in (v.split(",") for v in variants)]
    return [f"{s} #{shown[: i + 1].count(s)}" if shown[:i].count(s) else s for i, s in enumerate(shown)]
