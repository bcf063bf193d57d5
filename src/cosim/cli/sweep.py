"""cosim sweep: many runs of one system, over all cores or a Dask cluster, into one file."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..coupling import ALGORITHMS
from ..systems import System
from .common import (
    AsJson,
    Degrees,
    Exchanged,
    InputFiles,
    Parameters,
    ScenarioFile,
    Swaps,
    SystemName,
    Tolerance,
    Vehicle,
    chosen_system,
    degrees,
    finite,
    needs,
    progress,
    say,
    seconds,
    tell,
)
from .provenance import origin
from .reference import driven
from .settings import gyro_of, read_settings, refuse_exchanged, words


def command(
    system: SystemName,
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUES",
            help="COMPONENT.PARAMETER=VALUES: one value, a list A,B,C, a grid LOW:HIGH:N[:log] or, with --lhs, a range "
            "LOW:HIGH[:log]; COMPONENT=A,B: its variants",
        ),
    ] = None,
    vehicle: Vehicle = None,
    swap: Swaps = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    inputs: InputFiles = None,
    scenario: ScenarioFile = None,
    gyro: Annotated[str | None, typer.Option(metavar="A,B,...", help="variants of the gyro unit; as --set gyro=A,B")] = None,
    algorithms: Annotated[
        str, typer.Option("--algorithm", metavar="A,B,...", help=f"coupling algorithms: {', '.join(ALGORITHMS)}")
    ] = "jacobi",
    degree: Degrees = "1",
    steps: Annotated[str | None, typer.Option("--step", metavar="H,...", help="macro steps, such as 1ms,2ms")] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of every run")] = None,
    tolerance: Tolerance = None,
    samples: Annotated[int | None, typer.Option("--lhs", metavar="N", help="sample the ranges by a Latin hypercube")] = None,
    seed: Annotated[int | None, typer.Option(metavar="S", help="seed of the Latin hypercube; 0 otherwise")] = None,
    signals: Annotated[
        str, typer.Option(metavar="PATTERN,...", help="signals whose end, max and rms are kept; all outputs otherwise")
    ] = "",
    output: Annotated[
        Path | None, typer.Option(metavar="FILE", help=".npz, .csv or .parquet; SYSTEM-sweep.npz otherwise")
    ] = None,
    extend: Annotated[bool, typer.Option("--extend", help="add other runs over the same axes to FILE")] = False,
    workers: Annotated[
        int | None, typer.Option(metavar="N", help="processes on this machine; one for each core otherwise")
    ] = None,
    lanes: Annotated[
        int | None,
        typer.Option(metavar="N", help="runs that a worker does at once; as many as its processor has lanes otherwise"),
    ] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786")] = None,
    as_json: AsJson = False,
) -> int:
    """Run a system over a grid, lists or a Latin hypercube of parameters, variants, algorithms and steps.

    One row a run, with the end value, largest size and root mean square of each signal, the energy residual, and the error
    of a run that failed. A sweep that was stopped goes on where it was when it is started again with the same FILE.
    `cosim plot FILE X Y MEASURE` draws a map.
    """
    from ..sweeps import Sweep, sweep

    plan = chosen_system(system, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange, tolerance=tolerance)
    plan = driven(plan, inputs, scenario)
    tell(plan.notes)
    needs("--seed", seed, "--lhs", samples is not None)
    if scheduler is not None and workers is not None:
        raise ValueError(f"--workers has no effect with --scheduler, got {workers}")
    parameters, variants = _axes([*([f"{gyro_of(plan)}={gyro}"] if gyro is not None else []), *(values or ())], plan)
    refuse_exchanged(plan, variants, model_exchange)
    what = Sweep(
        plan, parameters, variants,
        algorithms=words(algorithms), degrees=degrees(degree),
        steps=[seconds(word, "--step") for word in words(steps or "")], stop=seconds(stop, "--stop"),
        samples=samples, seed=seed or 0, signals=words(signals),
    )  # fmt: skip
    file = output or Path(f"{plan.name}-sweep.npz")
    if not file.parent.is_dir():
        raise ValueError(f"the folder of {str(file)!r} must exist")
    with progress(f"sweeping {plan.name}") as show:
        outcome = sweep(what, file, workers=workers, scheduler=scheduler, lanes=lanes, extend=extend, progress=show)

    def document() -> dict[str, Any]:
        return {
            "system": plan.name, "file": str(file), "status": outcome.status, "runs": outcome.runs, "before": outcome.before,
            "done": outcome.done, "failed": outcome.failed, "seconds": outcome.seconds, "workers": outcome.workers,
            "busy": finite(outcome.busy), "way": outcome.way, "origin": origin(plan, written=[file]).document(),
        }  # fmt: skip

    where = f"on {scheduler}" if scheduler else f"on {outcome.workers} worker(s), {outcome.busy:.0%} of their time in runs"
    left = outcome.runs - outcome.before - outcome.done
    told = [
        f"{outcome.runs} runs of {plan.name}: {outcome.before} were in the file, {outcome.done} done now, {outcome.failed} of "
        f"them failed" + (f", {left} left" if left else ""),
        *([f"took {outcome.seconds:.1f} s, {where}", outcome.way] if outcome.done else []),
        f"wrote {file}" if outcome.done else f"{file} is complete",
    ]
    if outcome.status == "interrupted":
        told.append("interrupted; the same command goes on from here")
    say(as_json, document, *told)
    return 0 if outcome.status == "done" else 1


def _axes(texts: list[str], plan: System) -> tuple[dict[str, str], dict[str, tuple[str, ...]]]:
    """Values and variants by target, each given once and with at least one of them."""
    chosen = read_settings(texts, plan)
    parameters: dict[str, str] = {}
    for target, value in chosen.values:
        if not value:
            raise ValueError(f"--set must be COMPONENT.PARAMETER=VALUES or COMPONENT=VARIANTS, got '{target}='")
        if target in parameters:
            raise ValueError(f"axis {target!r} must be given once, got it twice")
        parameters[target] = value
    for name, variants in chosen.variants.items():
        for variant in variants:
            if "," in variant:
                raise ValueError(f"a sweep takes variants of {name!r} without values of their own, got {variant!r}")
    return parameters, chosen.variants
