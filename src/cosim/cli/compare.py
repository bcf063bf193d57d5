"""cosim compare: the same run with several variants of a component, and a verdict."""

import cmath
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ..comparison.candidates import Candidate, Comparison, compare
from ..coupling import algorithm
from . import drawing
from .common import (
    AlgorithmName,
    AsJson,
    Degree,
    Exchanged,
    InProcess,
    InputFiles,
    Parameters,
    ScenarioFile,
    Swaps,
    SystemName,
    Tolerance,
    Values,
    Vehicle,
    chosen_system,
    finite,
    needs,
    plain,
    progress,
    say,
    seconds,
    tell,
    writable,
)
from .compare_robust import VERDICTS, prepared
from .given import repeated
from .provenance import origin
from .reference import driven
from .robust import STARTS
from .settings import Settings, read_settings, refuse_exchanged

LONGEST_TABLE, LONGEST_LIST = 12, 8  # signals and violations that people are shown


def command(
    system: SystemName,
    variants: Annotated[
        list[str] | None,
        typer.Option(
            "--variant",
            "--gyro",
            metavar="VARIANT[,PARAMETER=VALUE...]",
            help="give it several times; the first is the reference",
        ),
    ] = None,
    vehicle: Vehicle = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    inputs: InputFiles = None,
    scenario: ScenarioFile = None,
    component: Annotated[
        str | None, typer.Option(metavar="NAME", help="what is exchanged; what the system says otherwise")
    ] = None,
    tolerances: Annotated[Path | None, typer.Option(metavar="FILE", help="a .toml file of limits; 5 % otherwise")] = None,
    step: Annotated[str | None, typer.Option(metavar="TIME", help="macro step, such as 1ms")] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of the runs")] = None,
    algorithm_: AlgorithmName = "jacobi",
    degree: Degree = 1,
    tolerance: Tolerance = None,
    in_process: InProcess = False,
    robust: Annotated[
        bool, typer.Option("--robust", help="compare again with half the steps, other starts, another form of the model")
    ] = False,
    starts: Annotated[int | None, typer.Option(metavar="N", help=f"starts of --robust; {STARTS} otherwise")] = None,
    within: Annotated[
        list[str] | None,
        typer.Option(metavar="COMPONENT.VARIABLE=TOL", help="how far a start of --robust may be away: vehicle.angle=1mrad"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="of the starts of --robust; 1 otherwise")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw the comparison, e.g. into a .png file")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE", help="write an .html page: the first runs in it, the others lie over it")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Run SYSTEM with every variant in turn and compare with the first: signals, energy, frequency response, a verdict.

    --set gyro=A,B names the variants as two --variant do. --set gyro.X=... goes to the variants that have an X.
    Exit code 1 unless the verdict is yes: every variant keeps the tolerances, on signals that it can change; and with --robust
    unless every answer stays the same.
    """
    from ..comparison.tolerances import read as read_tolerances

    plan = chosen_system(system, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange, tolerance=tolerance)
    plan = driven(plan, inputs, scenario)
    tell(plan.notes)
    chosen = read_settings(set_ or (), plan)
    component, variants = _exchanged(chosen, component, variants or [])
    refuse_exchanged(plan, [plan.exchanged(component)], model_exchange)
    limits = None if tolerances is None else read_tolerances(tolerances)
    drawing.check(plot)
    if report is not None:
        from ..report import check_format

        writable(report, check_format)
    for option, value in (("--starts", starts), ("--within", within), ("--seed", seed)):
        needs(option, value, "--robust", robust)
    h = seconds(step, "--step", plan.step)
    settings: dict[str, Any] = {
        "tolerances": limits, "algorithm": algorithm(algorithm_, degree), "stop": seconds(stop, "--stop"),
        "in_process": in_process,
    }  # fmt: skip
    again = None
    if robust and len(variants) > 1:
        drawn = (within or (), STARTS if starts is None else starts, 1 if seed is None else seed)
        again = prepared(plan, component, variants, chosen.values, h, *drawn, settings)
    with progress(f"comparing on {plan.name}") as show:
        result = compare(plan, variants, component=component, values=chosen.values, step=h, progress=show, **settings)
    if plot is not None:
        from ..comparison.figures import comparison

        drawing.save(comparison(result), plot)
    told, words = document(result, degree), _words(result)
    if again is not None:
        asked = again.ask(result)
        told["robust"] = again.again.document(asked)
        words += again.again.words(asked)
    if report is not None:
        _page(result, words, report)
    if as_json:
        told["origin"] = origin(*(c.run.system for c in result.candidates if c.run is not None)).document()
    say(as_json, lambda: told, *words, *(f"wrote {file}" for file in (plot, report) if file))
    return 0 if result.verdict and (again is None or asked.decidable) else 1


def _page(result: Comparison, words: list[str | Table], file: Path) -> None:
    """The page of the first run, with the others over it and what the command says in words."""
    from ..report import Told, write_report

    first, *others = [c for c in result.candidates if c.run is not None]
    assert first.run is not None  # it ran, or there would be no result
    told = Told(
        command=repeated(),
        texts=[("Comparison", plain(words))],
        others={c.label: c.run.trajectory for c in others if c.run is not None},
        called=first.label,
    )
    write_report(file, first.run, told)


def _exchanged(chosen: Settings, component: str | None, variants: list[str]) -> tuple[str | None, list[str]]:
    """What is exchanged and its variants: as --component and --variant say, or as one --set COMPONENT=A,B does."""
    if not chosen.variants:
        return component, variants
    (name, listed), *others = chosen.variants.items()
    if others:
        raise ValueError(f"compare exchanges one component, got variants of {' and '.join(chosen.variants)}")
    if variants:
        raise ValueError(f"--set {name}=... names the variants as --variant does: give one of the two, got both")
    if component not in (None, name):
        raise ValueError(f"--component must be the one that --set gives variants, {name!r}, got {component!r}")
    return name, list(listed)


def document(result: Comparison, degree: int) -> dict[str, Any]:
    """The comparison as JSON holds it; SI units, frequency responses as size and phase in rad."""

    def row(c: Candidate) -> dict[str, Any]:
        return {
            "variant": c.label, "source": c.source, "verdict": c.verdict, "violations": list(c.violations), "failure": c.failure,
            "ignored": list(c.ignored), "notes": [] if c.run is None else list(c.run.notes),
            "signals": {n: {k: finite(v) for k, v in vars(d).items()} for n, d in c.differences.items()},
            "energy": [
                {"unit": e.unit, "absorbed_J": e.absorbed, "least_J": e.least, "exchanged_J": e.exchanged, "created_J": e.created}
                for e in c.energies
            ],
            "coupling_residual_J": None if c.run is None else c.run.energy_residual,
            "responses": [
                {"bond": r.name, "frequency_Hz": r.frequency.tolist(), "size": [abs(v) for v in r.value.tolist()],
                 "phase_rad": [cmath.phase(v) for v in r.value.tolist()]}
                for r in c.responses
            ],
        }  # fmt: skip

    return {
        "system": result.system.name, "component": result.component, "reference": result.candidates[0].label,
        "degree": degree,
        "verdict": result.verdict, "undecided": result.undecided or None,
        "tolerances": {"signals": result.tolerances.signals, "created": result.tolerances.created},
        "variants": [row(c) for c in result.candidates],
    }  # fmt: skip


def _words(result: Comparison) -> list[str | Table]:
    reference, *others = result.candidates
    assert reference.run is not None
    exchanged = result.system.addressed(result.component)
    shown = [n for n in reference.differences if result.system.owner(n) not in exchanged or result.tolerances.limits(n)]
    moving = [n for n in shown if any(c.differences[n].rms > 0 for c in others if n in c.differences)]
    moving.sort(key=lambda n: -max(c.differences[n].rms for c in others if n in c.differences))
    shown = [n for n in shown if n in moving[:LONGEST_TABLE]]
    left_out = len(moving) - len(shown)
    table = Table("signal", "variant", "rms", "peak", "time shift", "correlation", "largest value", "reference", "unit", box=None,
                  pad_edge=False)  # fmt: skip
    for column in table.columns[2:8]:
        column.justify = "right"
    for column in table.columns[:2]:
        column.overflow = "fold"
    for name in shown:
        for k, c in enumerate(others):
            if name in c.differences:
                d = c.differences[name]
                table.add_row(
                    name if k == 0 else "", c.label, f"{d.rms:.2%}", f"{d.peak:.2%}", f"{d.shift * 1e3:.2f} ms",
                    f"{d.correlation:.4f}", f"{d.own_peak:.4g}", f"{d.reference_peak:.4g}", reference.run.trajectory.unit(name),
                )  # fmt: skip
    words: list[str | Table] = [
        f"{result.system.name} to t = {reference.run.trajectory.t[-1]:g} s, against {result.component} = {reference.label}: "
        "difference over the reference's rms and largest value",
        table, "", _energy_table(result), "",
    ]  # fmt: skip
    if left_out:
        words.insert(2, f"and {left_out} signals that differ less; --json has all")
    for c in others:
        more = len(c.violations) - LONGEST_LIST
        listed = [*c.violations[:LONGEST_LIST], *([f"and {more} more"] if more > 0 else [])]
        words.append(f"{c.label}: {VERDICTS[c.verdict]}" + "".join(f"\n  {v}" for v in listed))
        if c.ignored:
            words.append(f"  (has no {', '.join(c.ignored)})")
        words += [f"  (note: {note})" for note in (c.run.notes if c.run is not None else ()) if note not in result.system.notes]
    if reference.ignored:
        words.append(f"({reference.label} has no {', '.join(reference.ignored)})")
    why = f": {result.undecided}" if result.verdict is None else f", by tolerances {result.tolerances.where}"
    return [*words, f"verdict: {VERDICTS[result.verdict]}{why}"]


def _energy_table(result: Comparison) -> Table:
    table = Table("energy [J]", "unit", "exchanged", "absorbed", "least absorbed", "created by the interface", "share",
                  "coupling residual", box=None, pad_edge=False)  # fmt: skip
    for column in table.columns[2:]:
        column.justify = "right"
    for c in result.candidates:
        for e in c.energies:
            created = ("not reported", "") if e.created is None or e.share is None else (f"{e.created:.3g}", f"{e.share:.2%}")
            residual = f"{c.run.energy_residual:.2g}" if c.run is not None else ""
            table.add_row(c.label, e.unit, f"{e.exchanged:.4g}", f"{e.absorbed:.4g}", f"{e.least:.2g}", *created, residual)
    return table
