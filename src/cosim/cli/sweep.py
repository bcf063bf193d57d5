"""cosim sweep: many runs of one system, over all cores or a Dask cluster, into one file."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..coupling import ALGORITHMS
from .common import AsJson, SystemName, chosen_system, finite, progress, say, seconds


def command(
    system: SystemName,
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUES",
            help="COMPONENT.PARAMETER= a value, a list A,B,C, a grid LOW:HIGH:N[:log] or, with --lhs, a range LOW:HIGH[:log]; "
            "COMPONENT= a list of its variants",
        ),
    ] = None,
    gyro: Annotated[str | None, typer.Option(metavar="A,B,...", help="variants of the gyro unit; as --set gyro=A,B")] = None,
    algorithms: Annotated[
        str, typer.Option("--algorithm", metavar="A,B,...", help=f"coupling algorithms: {', '.join(ALGORITHMS)}")
    ] = "jacobi",
    orders: Annotated[str, typer.Option("--order", metavar="K,...", help="degrees of the input extrapolation")] = "1",
    steps: Annotated[str | None, typer.Option("--step", metavar="H,...", help="macro steps, such as 1ms,2ms")] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of every run")] = None,
    samples: Annotated[int | None, typer.Option("--lhs", metavar="N", help="sample the ranges by a Latin hypercube")] = None,
    seed: Annotated[int, typer.Option(help="of the Latin hypercube")] = 0,
    signals: Annotated[
        str, typer.Option(metavar="PATTERN,...", help="whose end, max and rms are kept; all outputs otherwise")
    ] = "",
    output: Annotated[
        Path | None, typer.Option(metavar="FILE", help=".npz, .csv or .parquet; SYSTEM-sweep.npz otherwise")
    ] = None,
    extend: Annotated[bool, typer.Option("--extend", help="add other runs over the same axes to FILE")] = False,
    workers: Annotated[int | None, typer.Option(metavar="N", help="processes on this machine; one a core otherwise")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786")] = None,
    as_json: AsJson = False,
) -> int:
    """Run a system over a grid, lists or a Latin hypercube of parameters, variants, algorithms and steps.

    One row a run, with the end value, largest size and root mean square of each signal, the energy residual, and the error
    of a run that failed. A sweep that was stopped goes on where it was when it is started again with the same FILE.
    `cosim plot FILE X Y MEASURE` draws a map.
    """
    from ..sweeps import Sweep, sweep

    plan = chosen_system(system, None, None)
    parameters, variants = _settings([*([f"gyro={gyro}"] if gyro is not None else []), *(values or ())])
    what = Sweep(
        plan, parameters, variants,
        algorithms=_words(algorithms), degrees=[_degree(word) for word in _words(orders)],
        steps=[seconds(word, "--step") or 0.0 for word in _words(steps or "")], stop=seconds(stop, "--stop"),
        samples=samples, seed=seed, signals=_words(signals),
    )  # fmt: skip
    file = output or Path(f"{plan.name}-sweep.npz")
    if not file.parent.is_dir():
        raise ValueError(f"the folder of {str(file)!r} must exist")
    with progress(f"sweeping {plan.name}") as show:
        outcome = sweep(what, file, workers=workers, scheduler=scheduler, extend=extend, progress=show)

    def document() -> dict[str, Any]:
        return {
            "system": plan.name, "file": str(file), "status": outcome.status, "runs": outcome.runs, "before": outcome.before,
            "done": outcome.done, "failed": outcome.failed, "seconds": outcome.seconds, "workers": outcome.workers,
            "busy": finite(outcome.busy),
        }  # fmt: skip

    where = f"on {scheduler}" if scheduler else f"on {outcome.workers} worker(s), {outcome.busy:.0%} of their time in runs"
    left = outcome.runs - outcome.before - outcome.done
    words = [
        f"{outcome.runs} runs of {plan.name}: {outcome.before} were in the file, {outcome.done} done now, {outcome.failed} of "
        f"them failed" + (f", {left} left" if left else ""),
        *([f"took {outcome.seconds:.1f} s, {where}"] if outcome.done else []),
        f"wrote {file}" if outcome.done else f"{file} is complete",
    ]
    if outcome.status == "interrupted":
        words.append("interrupted; the same command goes on from here")
    say(as_json, document, *words)
    return 0 if outcome.status == "done" else 1


def _settings(texts: list[str]) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Parameters (with a dot in the name) and variants (without) by target."""
    parameters: dict[str, str] = {}
    variants: dict[str, list[str]] = {}
    for text in texts:
        target, equals, value = (part.strip() for part in text.partition("="))
        if not (target and equals and value):
            raise ValueError(f"--set must be COMPONENT.PARAMETER=VALUES or COMPONENT=VARIANTS, got {text!r}")
        if target in parameters or target in variants:
            raise ValueError(f"axis {target!r} must be given once, got it twice")
        if "." in target:
            parameters[target] = value
        else:
            variants[target] = _words(value)
    return parameters, variants


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()]


def _degree(word: str) -> int:
    if not word.isdecimal():
        raise ValueError(f"--order must be degrees such as 0,1,2, got {word!r}")
    return int(word)
