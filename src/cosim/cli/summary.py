"""What a run tells: as a document and in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from ..accuracy.certificate import Certificate
from ..master import Run
from . import assessments
from .assessments import Assessed
from .common import finite

SHOWN = 30  # outputs up to which a summary lists every one


def document(run: Run, found: Sequence[Assessed] = ()) -> dict[str, Any]:
    """The run as JSON holds it; SI units but for values, which are in the units of their variables.

    Parameters
    ----------
    run : Run
        The run, whole or in part.
    found : sequence of Assessed
        What the registered fields found in it.
    """
    own = {
        "system": run.system.name,
        "components": {component.name: component.source for component in run.system.components},
        "step": run.step,
        "algorithm": run.algorithm.name,
        "degree": run.algorithm.degree,
        "steps": run.steps,
        "status": run.status,
        "start": run.start,
        "stop": float(run.trajectory.t[-1]),
        "end": run.trajectory.end(),
        "units": dict(zip(run.trajectory.names, run.trajectory.units, strict=True)),
        "energy_residual": run.energy_residual,
        "bonds": [
            {"bond": b.name, "residual_J": b.residual, "peak_W": b.peak_power, "exchanged_J": b.exchanged, "share": b.share}
            for b in run.energy
        ],
        "coupling_warning": run.coupling_warning,
        "ended_by": run.ended_by,
        "iterations": run.iterations,
        "rejections": run.rejections,
        "without_kernel": run.without_kernel,
        "notes": list(run.notes),
        "warnings": {name: {"count": count, "first": first} for name, (count, first) in run.warnings.items()},
        "scenario": [{"at": one.at, "since": one.since, "event": one.words} for one in run.happened],
        "events": {"total": sum(run.events.values()), "components": dict(run.events)},
        "timing": {
            "setup_s": run.timing.setup_s,
            "loop_s": run.timing.loop_s,
            "do_step_s": run.timing.do_step_s,
            "master_s": run.timing.master_s,
        },
    }
    return own | assessments.documents(found, own)


def summary_lines(run: Run, in_process: bool, found: Sequence[Assessed] = ()) -> list[str | Table]:
    """The run in words.

    Parameters
    ----------
    run : Run
        The run, whole or in part.
    in_process : bool
        Whether its components ran in this process instead of as FMUs.
    found : sequence of Assessed
        What the registered fields found in it.
    """
    a, timing, trajectory = run.algorithm, run.timing, run.trajectory
    what = "components in this process" if in_process else "FMUs"
    components = ", ".join(f"{c.name} ({c.source})" for c in run.system.components[:8])
    if len(run.system.components) > 8:
        components += f" and {len(run.system.components) - 8} more"
    head = "" if run.status == "done" else f"{run.status} at t = {trajectory.t[-1]:g} s\n"
    head = f"{run.ended_by}\n" if run.status == "ended" else head
    slowest = sorted(timing.do_step_s.items(), key=lambda item: -item[1])[:8]
    spent = ", ".join(f"{name} {s:.2f} s" for name, s in slowest)
    even = f"macro steps of {run.step * 1e3:g} ms" if run.adaptive is None else _adapted(run)
    iterated = f", {run.iterations / run.steps:.1f} iterations a step" if run.iterations and run.steps else ""
    span = (f"from t = {run.start:.9g} s " if run.start else "") + f"to t = {trajectory.t[-1]:.9g} s"
    lines = [
        f"{head}{run.system.name}: {components}, as {what}",
        f"{a.name}, input degree {a.degree}, {run.steps} {even} {span}{iterated}",
        f"took {timing.setup_s + timing.loop_s:.2f} s: set-up {timing.setup_s:.2f} s, loop {timing.loop_s:.2f} s, in it {spent}",
    ]
    table = Table("at the end", "value", "unit", box=None, pad_edge=False)
    table.columns[1].justify = "right"
    end = list(zip(trajectory.names, trajectory.units, trajectory.values[-1], strict=True))
    if len(end) > SHOWN:  # of many outputs those that cross an interface
        crossing = {".".join(c.start) for c in run.system.connections}
        end = [row for row in end if row[0] in crossing][:SHOWN]
        table.columns[0].header = f"at the end ({len(end)} of {len(trajectory.names)} outputs: what crosses between components)"
    for name, unit, value in end:
        table.add_row(name, f"{value:.6g}", unit)
    bonds = [
        f"coupling energy residual {b.residual:.3g} J, {b.share:.2g} of the {b.exchanged:.3g} J exchanged "
        f"(peak {b.peak_power:.2g} W), on {b.name}"
        for b in run.energy
    ]
    if len(bonds) > 2:  # one line for all, and the bond that carries most
        most = max(run.energy, key=lambda b: b.exchanged)
        bonds = [
            f"coupling energy residual {run.energy_residual:.3g} J over {len(bonds)} bonds; {most.share:.2g} of the "
            f"{most.exchanged:.3g} J on {most.name}, which carries most",
        ]
    told = ", ".join(f"{name} {count}" for name, count in sorted(run.events.items(), key=lambda item: -item[1])[:8])
    more = f" and {len(run.events) - 8} more" if len(run.events) > 8 else ""
    events = [f"events: {sum(run.events.values())} ({told}{more})"] if run.events else []
    slow = [f"the inner loop ran in Python, without its compiled kernel: {run.without_kernel}"] if run.without_kernel else []
    warned = [f"{name} gave {n} warning{'s' if n > 1 else ''}, the first: {first}" for name, (n, first) in run.warnings.items()]
    warning = [f"WARNING: {run.coupling_warning}"] if run.coupling_warning else []
    bonds = bonds or ["coupling energy residual: the system has no power bond"]
    notes = [f"note: {note}" for note in run.notes]
    events += happened_lines(run)
    return [*lines, *slow, *notes, *events, *warned, "", table, "", *bonds, *warning, *assessments.lines(found)]


def happened_lines(run: Run) -> list[str]:
    """What a scenario has done, in words."""
    lines = []
    for one in run.happened[:SHOWN]:
        late = f" (from t = {one.since:.9g} s on)" if abs(one.since - one.at) > 1e-9 * run.step else ""
        lines.append(f"t = {one.at:.9g} s: {one.words}{late}")
    more = len(run.happened) - SHOWN
    return [*lines, *([f"and {more} events more of the scenario"] if more > 0 else [])]


def _adapted(run: Run) -> str:
    """Macro steps that have adapted, in words."""
    h = np.diff(run.trajectory.t) * 1e3
    lengths = f" of {h.min():.3g} to {h.max():.3g} ms" if h.size == run.steps and h.size else ""
    return f"macro steps{lengths}, {run.rejections} rejected,"


def certificate_document(certificate: Certificate) -> dict[str, Any]:
    """The certificate as JSON holds it; null where there is no estimate."""
    stability = certificate.stability
    return {
        "observed_order": finite(certificate.observed_order),
        "no_estimate": certificate.no_estimate or None,
        "errors": {
            e.name: {"largest": finite(e.largest), "end": finite(e.end), "size": e.size, "unit": e.unit}
            for e in certificate.errors
        },
        "stability": None
        if stability is None
        else {
            "spectral_radius": stability.radius,
            "exact": stability.exact,
            "stable": stability.is_stable(),
            "largest_stable_step": finite(stability.largest_step),
        },
    }


def certificate_words(certificate: Certificate) -> list[str | Table]:
    """The certificate in words."""
    table = Table("estimated coupling error", "largest", "at the end", "of a size of", "unit", box=None, pad_edge=False)
    for column in table.columns[1:4]:
        column.justify = "right"
    for e in () if certificate.no_estimate else certificate.errors[:60]:
        table.add_row(e.name, f"{e.largest:.2e}", f"{e.end:+.2e}", f"{e.size:.3g}", e.unit)
    order = f"observed order {certificate.observed_order:.2f}" if certificate.observed_order == certificate.observed_order else (
        "observed order: differences are at rounding")  # fmt: skip
    stability = certificate.stability
    if stability is None:
        margin = "stability margin: unknown, a component does not give its derivatives"
    else:
        state = "stable" if stability.is_stable() else "UNSTABLE"
        limit = f"{stability.largest_step * 1e3:.4g} ms" if finite(stability.largest_step) else "beyond 1000 times this one"
        margin = (
            f"coupling {state}: spectral radius {stability.radius:.8g} a step ({stability.exact:.8g} without coupling error), "
            f"largest stable step {limit}"
        )
    if certificate.no_estimate:
        return ["", f"no estimate of the coupling error: {certificate.no_estimate}", margin]
    return ["", table, order, margin]
