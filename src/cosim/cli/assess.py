"""cosim assess: what recorded runs say of their railway vehicles, quantity by quantity."""

import csv
import io
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from gyro_cosim.component.whole_files import write_whole

from ..railway.acceptance import EXCEEDED, judge
from ..railway.assessment import assess
from ..railway.limits import Limits
from ..railway.limits import read as read_limits
from ..trajectory import read_results
from .assessments import drawn
from .common import AsJson, say


def command(
    files: Annotated[list[Path], typer.Argument(metavar="RUN...", help="results of cosim run: .csv, .mat, .parquet, .mf4")],
    limits: Annotated[
        Path | None, typer.Option(metavar="FILE", help="a .toml file of other limits; those of EN 14363 otherwise")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="write the rows to a .csv file")] = None,
    as_json: AsJson = False,
) -> int:
    """Judge recorded runs of railway vehicles by EN 14363 and EN 12299: one table a vehicle, section by section of its track.

    Exit code 1 if a vehicle derailed or exceeds a limit.
    """
    by = Limits() if limits is None else read_limits(limits)
    if output is not None and output.suffix != ".csv":
        raise ValueError(f"--output must be a .csv file, got {str(output)!r}")
    words: list[str | Table] = []
    documents, rows, bad = [], [], False
    for file in files:
        run = read_results(file)
        found = assess(run)
        if not found:
            needed = "body_distance and, of a wheel, climb and derailment_coefficient"
            raise ValueError(f"{file} must hold a railway vehicle with more than 100 points, it has none: {needed} are needed")
        for one in found:
            table = judge(run, one, by)
            bad |= one.verdict.derailed or table.count(EXCEEDED) > 0
            words += [f"{file}: {one.vehicle} {one.verdict.text}", table.title, drawn(table)]
            documents.append({"file": str(file), "verdict": one.verdict.text, **table.document()})
            rows += [(str(file), one.vehicle, *cells) for cells in table.cells]
    if output is not None:
        text = io.StringIO(newline="")
        csv.writer(text, lineterminator="\n").writerows([("file", "vehicle", *table.head), *rows])
        write_whole(output, text.getvalue())
        words.append(f"wrote {output}")
    say(as_json, lambda: {"assessments": documents}, *words)
    return int(bad)
