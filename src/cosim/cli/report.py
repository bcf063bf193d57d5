"""cosim report: what is in files of results, as one page."""

from pathlib import Path
from typing import Annotated

import typer

from .common import AsJson, say, writable
from .given import repeated


def command(
    files: Annotated[list[Path], typer.Argument(metavar="RUN...", help="files of results; those after the first lie over it")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="an .html file; beside the first RUN otherwise")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Show results of runs as one page that needs nothing but a browser.

    Of `cosim run --report` the page holds the system itself, too, and runs it again.
    """
    from .. import figures
    from ..report import Told, check_format, write_recorded
    from ..trajectory import Trajectory, read_results

    page = output or files[0].with_suffix(".html")
    writable(page, check_format)
    runs: dict[str, Trajectory] = {}
    for file in files:
        if not file.is_file():
            raise ValueError(f"file {str(file)!r} must exist")
        runs[str(file)] = read_results(file)
    first = next(iter(runs.values()))
    write_recorded(page, runs, Told(command=repeated(), prefer=figures.worth_drawing(first, 6, lambda name: 0)))
    say(as_json, lambda: {"files": [str(page)]}, f"wrote {page}")
    return 0
