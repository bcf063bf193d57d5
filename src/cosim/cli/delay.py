"""cosim delay: how much delay a unit's answer can have."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ..coupling import algorithm
from ..hil.compensation import COMPENSATORS
from ..hil.delay_margin import Compensation, DelayStudy, Margin
from ..systems import System
from . import drawing
from .common import (
    AlgorithmName,
    AsJson,
    Degree,
    Exchanged,
    Gyro,
    Parameters,
    Swaps,
    SystemName,
    Tolerance,
    Values,
    Vehicle,
    chosen_system,
    progress,
    say,
    seconds,
    tell,
)
from .provenance import origin
from .settings import assignment


def command(
    system: SystemName,
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    component: Annotated[
        str | None, typer.Option(metavar="NAME", help="whose answer is late; what is exchanged in the system otherwise")
    ] = None,
    compensate: Annotated[
        str, typer.Option(metavar="A,B,...", help=f"{', '.join(COMPENSATORS)}, model:VARIANT, passivity; + joins two")
    ] = "none",
    tolerances: Annotated[Path | None, typer.Option(metavar="FILE", help="a .toml file of limits; 5 % otherwise")] = None,
    step: Annotated[str | None, typer.Option(metavar="TIME", help="macro step; ten times the system's own otherwise")] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of the runs; 20 s otherwise")] = None,
    longest: Annotated[str, typer.Option(metavar="TIME", help="longest delay that is tried")] = "0.5 s",
    algorithm_: AlgorithmName = "jacobi",
    degree: Degree = 1,
    tolerance: Tolerance = None,
    fmus: Annotated[bool, typer.Option("--fmus", help="run the components as FMUs")] = False,
    across: Annotated[
        str | None,
        typer.Option(
            "--map", metavar="COMPONENT.PARAMETER=LOW:HIGH:N", help="draw the margin over this parameter and the macro step"
        ),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="where to draw the map, e.g. a .png file")] = None,
    as_json: AsJson = False,
) -> int:
    """Find the largest loop delay that leaves SYSTEM stable, and the largest that keeps the tolerances.

    Each in two ways: from the sampled linear system (exact where the components are linear) and by bisection on runs.
    """
    from ..comparison.tolerances import read as read_tolerances
    from ..comparison.verdict import five_percent
    from ..hil.delay_margin import by_eigenvalues, by_runs, delay_map, verdict_by_model, verdict_by_runs

    if (across is None) != (plot is None):
        raise ValueError("--map and --plot go together")
    drawing.check(plot)
    plan = chosen_system(
        system, gyro, set_, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange, tolerance=tolerance
    )
    tell(plan.notes)
    setting = DelayStudy(
        plan, seconds(step, "--step", 10 * plan.step), seconds(stop, "--stop", 20.0), component=component,
        algorithm=algorithm(algorithm_, degree), in_process=not fmus, longest=seconds(longest, "--longest"),
    )  # fmt: skip
    limits = five_percent(plan, setting.delayed) if tolerances is None else read_tolerances(tolerances)
    remedies = [remedy(name.strip()) for name in compensate.split(",")]
    grid = None if across is None else _range(plan, across)
    rows: list[dict[str, Any]] = []
    for chosen in remedies:
        s = replace(setting, remedy=chosen)
        exact = chosen.linear and s.algorithm.name == "jacobi"
        with progress(f"{chosen.name}: stability") as show:
            stable = (by_eigenvalues(s) if exact else None, by_runs(s, show))
        with progress(f"{chosen.name}: tolerances") as show:
            kept = (verdict_by_model(s, limits) if exact else None, verdict_by_runs(s, limits, show))
        rows.append({"compensation": chosen.name, "stable": stable, "kept": kept})
    words: list[str | Table] = [
        f"{plan.name}: largest delay of {setting.delayed}, macro step {setting.step * 1e3:g} ms, {setting.algorithm.name} with "
        f"input degree {degree}, runs to {setting.stop:g} s",
        _table(rows, setting),
    ]
    if grid is not None and plot is not None:
        import numpy as np

        from ..hil.figures import delay_margins

        name, values, unit = grid
        steps = np.array([setting.step / 2**k for k in range(4)])
        with progress("map") as show:
            drawn = delay_map(replace(setting, remedy=remedies[0]), name, values, steps, unit, show)
        drawing.save(delay_margins(drawn, plan.name), plot)
        words.append(f"wrote {plot}")

    def document() -> dict[str, Any]:
        def ways(pair: tuple[Margin | None, Margin]) -> dict[str, float | None]:
            return {"model_s": pair[0].delay if pair[0] else None, "runs_s": pair[1].delay}

        return {
            "system": plan.name, "component": setting.delayed, "step": setting.step, "stop": setting.stop,
            "longest": setting.longest, "algorithm": setting.algorithm.name, "degree": degree,
            "margins": [
                {"compensation": r["compensation"], "stable": ways(r["stable"]), "tolerances": ways(r["kept"])} for r in rows
            ],
            "origin": origin(plan).document(),
        }  # fmt: skip

    say(as_json, document, *words)
    return 0


def remedy(name: str) -> Compensation:
    """What the command line calls `name`: words joined by +."""
    made = Compensation()
    for word in name.split("+"):
        if word == "passivity":
            made = replace(made, passive=True)
        elif word.startswith("model:"):
            made = replace(made, model=word.removeprefix("model:"))
        elif word in COMPENSATORS:
            made = replace(made, compensator=COMPENSATORS[word])
        else:
            raise ValueError(f"compensation must be one of {', '.join(COMPENSATORS)}, model:VARIANT, passivity, got {word!r}")
    return made


def _range(plan: System, text: str) -> tuple[str, Any, str]:
    """The parameter, the values that LOW:HIGH:N or A,B,... mean in its unit, and that unit."""
    import numpy as np

    from ..sweeps.axes import Listed, parse
    from ..sweeps.query import SystemQuery

    rule = "--map must be COMPONENT.PARAMETER=LOW:HIGH:N or A,B,..."
    name, words = assignment(text, rule)
    with SystemQuery(plan, {}) as asked:
        axis = parse(name, words, lambda word: asked.value(name, word))
        if not isinstance(axis, Listed) or any(isinstance(value, str) for value in axis.values):
            raise ValueError(f"{rule}, got {text!r}")
        return name, np.array(axis.values, dtype=float), asked.units[name]


def _table(rows: list[dict[str, Any]], setting: DelayStudy) -> Table:
    table = Table("compensation", "stable, eigenvalues", "stable, runs", "tolerances, linear model", "tolerances, runs", box=None,
                  pad_edge=False)  # fmt: skip
    for column in table.columns[1:]:
        column.justify = "right"

    def cell(margin: Margin | None) -> str:
        if margin is None:
            return "-"
        if margin.delay is None:
            return "not even 0"
        more = "at least " if margin.delay >= setting.longest * (1 - 1e-9) else ""
        return f"{more}{margin.delay * 1e3:.1f} ms"

    for row in rows:
        table.add_row(row["compensation"], *(cell(m) for m in (*row["stable"], *row["kept"])))
    return table
