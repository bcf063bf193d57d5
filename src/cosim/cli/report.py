"""cosim report: what is in files of results, as one page."""

from pathlib import Path
from typing import Annotated

import typer

from gyro_cosim.component.whole_files import write_whole

from ..slaves.scratch import ScratchFolder
from .common import AsJson, needs, say, tell, writable
from .given import repeated


def command(
    files: Annotated[list[Path], typer.Argument(metavar="RUN...", help="files of results; those after the first lie over it")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="an .html file; beside the first RUN otherwise")
    ] = None,
    again: Annotated[
        bool,
        typer.Option("--again", help="run the command that made RUN again, so that the page holds the system, too"),
    ] = False,
    offered: Annotated[
        str | None,
        typer.Option("--report-variants", metavar="all|none|A,B", help="of --again, as for cosim run"),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Show results of runs as one page that needs nothing but a browser.

    With --again, as with `cosim run --report`, the page holds the system itself, too. This runs the command that the file
    names, and its Python files: of results of people whom you trust.
    """
    from .. import figures
    from ..errors import RunError
    from ..report import Told, check_format, write_recorded
    from ..trajectory import Trajectory, read_results

    page = output or files[0].with_suffix(".html")
    writable(page, check_format)
    needs("--report-variants", offered, "--again", again)
    if again:
        from ..trajectory.sameness import first_difference
        from .reproduce import Made

        if len(files) != 1:
            raise ValueError(f"--again must be of one RUN, got {len(files)}")
        made = Made.of(files[0])
        tell(made.changed)
        with ScratchFolder() as scratch:
            whole = scratch / "page.html"
            different = first_difference(made.results, made.again("--report", str(whole), "--report-variants", offered or "all"))
            if different is not None:
                raise RunError(
                    f"the results of {str(files[0])!r} must come out again for the page to hold the system: {different}"
                )
            content = whole.read_text(encoding="utf-8")
        write_whole(page, content)
        say(as_json, lambda: {"files": [str(page)]}, f"wrote {page}")
        return 0
    runs: dict[str, Trajectory] = {}
    for file in files:
        if not file.is_file():
            raise ValueError(f"file {str(file)!r} must exist")
        runs[str(file)] = read_results(file)
    first = next(iter(runs.values()))
    write_recorded(page, runs, Told(command=repeated(), prefer=figures.worth_drawing(first, 6, lambda name: 0)))
    say(as_json, lambda: {"files": [str(page)]}, f"wrote {page}")
    return 0
