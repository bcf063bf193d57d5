"""cosim run: one run of a system, a short summary, results in files."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from cosim import trajectory
from cosim.cli.common import AsJson, Gyro, InProcess, SystemName, Values, chosen_system, console, progress, say, seconds, writable
from cosim.coupling import ALGORITHMS, algorithm
from cosim.errors import RunError
from cosim.master import Run, simulate


def command(
    system: SystemName,
    gyro: Gyro = None,
    set_: Values = None,
    step: Annotated[str | None, typer.Option(metavar="TIME", help="macro step, such as 1ms")] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of the run, such as 60 or 2min")] = None,
    algorithm_: Annotated[str, typer.Option("--algorithm", help=f"coupling algorithm: {', '.join(ALGORITHMS)}")] = "jacobi",
    order: Annotated[int, typer.Option(help="degree of the input extrapolation: 0, 1 or 2")] = 1,
    sequence: Annotated[
        str, typer.Option(metavar="A,B,...", help="order of stepping for gauss-seidel; else chosen by dependence")
    ] = "",
    in_process: InProcess = False,
    output: Annotated[Path | None, typer.Option(metavar="FILE", help="write the results to a .csv or .mat file")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw the results, e.g. into a .png file")] = None,
    as_json: AsJson = False,
) -> int:
    """Run a built-in system or an .ssd file.

    Without options `cosim run wheel-pair` is the paper's case of figure 4: v = 10 m/s, rotor at 100 rpm, starting at
    y = 0.001 m and psi = 0.314 rad.
    """
    plan = chosen_system(system, gyro, set_)
    chosen = algorithm(algorithm_, order, [name.strip() for name in sequence.split(",") if name.strip()])
    writable(output, trajectory.check_format)
    if plot is not None:
        from cosim import figures

        writable(plot, figures.check_format)
    failure: RunError | None = None
    with progress(f"running {plan.name}") as show:
        try:
            run = simulate(
                plan, algorithm=chosen, step=seconds(step, "--step"), stop=seconds(stop, "--stop"),
                in_process=in_process, progress=show,
            )  # fmt: skip
        except RunError as error:
            if error.partial is None:
                raise
            failure, run = error, error.partial
    written = _write(run, output, plot)
    if failure is not None:
        for file in written:
            console().print(f"kept the results up to t = {run.trajectory.t[-1]:g} s in {file}", markup=False)
        raise failure
    say(as_json, lambda: document(run), *_summary(run, in_process), *(f"wrote {file}" for file in written))
    return 0 if run.status == "done" else 1


def document(run: Run) -> dict[str, Any]:
    """The run as JSON holds it; SI units but for values, which are in the units of their variables."""
    return {
        "system": run.system.name,
        "components": {part.name: part.source for part in run.system.parts},
        "step": run.step,
        "algorithm": run.algorithm.name,
        "order": run.algorithm.degree,
        "steps": run.steps,
        "status": run.status,
        "stop": float(run.trajectory.t[-1]),
        "end": run.trajectory.end(),
        "units": dict(zip(run.trajectory.names, run.trajectory.units, strict=True)),
        "energy_residual": run.energy_residual,
        "bonds": [
            {"bond": b.name, "residual_J": b.residual, "peak_W": b.peak_power, "exchanged_J": b.exchanged, "share": b.share}
            for b in run.energy
        ],
        "timing": {"setup_s": run.timing.setup_s, "loop_s": run.timing.loop_s, "do_step_s": run.timing.do_step_s},
    }


def _write(run: Run, output: Path | None, plot: Path | None) -> list[Path]:
    if output is not None:
        run.trajectory.save(output)
    if plot is not None:
        from cosim import figures

        names = _worth_drawing(run)
        title = f"{run.system.name}: " + ", ".join(f"{p.name} = {p.source.rpartition('/')[2]}" for p in run.system.parts)
        figures.save(figures.time_histories(run.trajectory, names, title), plot)
    return [file for file in (output, plot) if file is not None]


def _worth_drawing(run: Run) -> list[str]:
    """Signals that change, at most six: angles and displacements first, then what crosses the wall, then the rest."""
    trajectory = run.trajectory
    crossing = {".".join(c.start) for c in run.system.connections}
    moving = [n for n in trajectory.names if trajectory[n].min() < trajectory[n].max()]
    rank = {"m": 0, "rad": 0}
    moving.sort(key=lambda n: rank.get(trajectory.unit(n), 1 if n in crossing else 2))
    return moving[:6] or list(trajectory.names[:6])


def _summary(run: Run, in_process: bool) -> list[str | Table]:
    a, timing, trajectory = run.algorithm, run.timing, run.trajectory
    what = "components in this process" if in_process else "FMUs"
    parts = ", ".join(f"{p.name} ({p.source})" for p in run.system.parts)
    head = "" if run.status == "done" else f"{run.status} at t = {trajectory.t[-1]:g} s\n"
    spent = ", ".join(f"{name} {s:.2f} s" for name, s in timing.do_step_s.items())
    lines = [
        f"{head}{run.system.name}: {parts}, as {what}",
        f"{a.name}, input degree {a.degree}, {run.steps} macro steps of {run.step * 1e3:g} ms to t = {trajectory.t[-1]:g} s",
        f"took {timing.setup_s + timing.loop_s:.2f} s: set-up {timing.setup_s:.2f} s, loop {timing.loop_s:.2f} s, in it {spent}",
    ]
    table = Table("at the end", "value", "unit", box=None, pad_edge=False)
    table.columns[1].justify = "right"
    for name, unit, value in zip(trajectory.names, trajectory.units, trajectory.values[-1], strict=True):
        table.add_row(name, f"{value:.6g}", unit)
    bonds = [
        f"coupling energy residual {b.residual:.3g} J, {b.share:.2g} of the {b.exchanged:.3g} J exchanged "
        f"(peak {b.peak_power:.2g} W), on {b.name}"
        for b in run.energy
    ]
    return [*lines, "", table, "", *(bonds or ["coupling energy residual: the system has no power bond"])]
