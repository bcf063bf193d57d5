"""cosim converge: a ladder of macro steps against the reference."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ..coupling import algorithm
from . import drawing
from .common import (
    AsJson,
    Degrees,
    Exchanged,
    Gyro,
    InProcess,
    Parameters,
    Swaps,
    SystemName,
    Tolerance,
    Values,
    Vehicle,
    chosen_system,
    degrees,
    finite,
    progress,
    say,
    seconds,
    tell,
)
from .provenance import origin


def command(
    system: SystemName,
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    step: Annotated[
        str | None, typer.Option(metavar="TIME", help="coarsest macro step; 32 times the system's own otherwise")
    ] = None,
    rungs: Annotated[int, typer.Option(help="how many steps, each half of the one before")] = 5,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of the runs; 125 coarsest steps otherwise")] = None,
    algorithms: Annotated[
        str, typer.Option("--algorithm", metavar="A,B,...", help="coupling algorithms of cosim list")
    ] = "jacobi,gauss-seidel",
    degree: Degrees = "0,1,2",
    tolerance: Tolerance = None,
    in_process: InProcess = False,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw errors over steps, e.g. into a .png file")] = None,
    as_json: AsJson = False,
) -> int:
    """Measure how the error falls with the macro step, and the order of each algorithm.

    The reference is the same model without coupling: exact by the matrix exponential where it is linear.
    """
    from ..accuracy.convergence import converge

    plan = chosen_system(
        system, gyro, set_, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange, tolerance=tolerance
    )
    tell(plan.notes)
    coarsest = seconds(step, "--step", 32 * plan.step)
    if not coarsest > 0.0:
        raise ValueError(f"--step must be positive, got {step}")
    chosen = [algorithm(name.strip(), k) for name in algorithms.split(",") for k in degrees(degree)]
    drawing.check(plot)
    end = seconds(stop, "--stop", plan.start + 125 * coarsest)
    with progress(f"ladder of {plan.name}") as show:
        result = converge(plan, chosen, step=coarsest, rungs=rungs, stop=end, in_process=in_process, progress=show)
    if plot is not None:
        from ..accuracy.figures import convergence

        drawing.save(convergence(result), plot)

    def document() -> dict[str, Any]:
        return {
            "system": plan.name,
            "stop": result.stop,
            "reference": result.reference,
            "algorithms": [
                {
                    "algorithm": ladder.algorithm.name, "degree": ladder.algorithm.degree, "steps": ladder.steps,
                    "errors": [finite(e) for e in ladder.errors], "expected_order": ladder.algorithm.order,
                    "observed_order": finite(ladder.observed_order),
                }
                for ladder in result.ladders
            ],
            "origin": origin(plan).document(),
        }  # fmt: skip

    head = [f"{h * 1e3:g} ms" for h in result.ladders[0].steps]
    table = Table("algorithm", "degree", *head, "observed order", "expected", box=None, pad_edge=False)
    for column in table.columns[1:]:
        column.justify = "right"
    for ladder in result.ladders:
        a = ladder.algorithm
        errors = [
            ("fails" if e == float("inf") else f"{e:.2e}") + ("" if u else " x")
            for e, u in zip(ladder.errors, ladder.used, strict=True)
        ]
        table.add_row(a.name, str(a.degree), *errors, _order(ladder.observed_order), str(a.order))
    words: list[str | Table] = [
        f"{plan.name} to t = {result.stop:g} s: largest relative error of an output against the {result.reference}",
        table,
        "x: left out of the fit: not yet proportional to a power of the step, or within the error that the components make by "
        "themselves (where they have a parameter internal_step, a smaller one makes it smaller)",
    ]
    left_out = any(not u for ladder in result.ladders for u in ladder.used)
    say(as_json, document, *(words if left_out else words[:2]), *([f"wrote {plot}"] if plot else []))
    return 0


def _order(observed: float) -> str:
    return f"{observed:.2f}" if observed == observed else "-"
