"""cosim plot: draw what is in a file, time histories of a run or maps of a sweep."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .common import AsJson, say, writable
from .settings import assignment

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="the results of cosim run or of cosim sweep")],
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAMES", help="signals of a run, * and ? are wild; X Y MEASURE, or X MEASURE, of a sweep"),
    ] = None,
    where: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="of a sweep, only runs with this value of an axis")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="IMAGE", help="where to draw; beside FILE, as .png, otherwise")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Draw signals of a run over time, or a measure of a sweep over its axes."""
    from .. import figures
    from ..sweeps.store import journal_of

    image = output or file.with_suffix(".png")
    writable(image, figures.check_format)
    if not file.is_file() and not journal_of(file).is_file():
        raise ValueError(f"file {str(file)!r} must exist")
    made = _sweep(file, names or [], where or []) if _holds_a_sweep(file) else _run(file, names or [], where or [])
    figures.save(made, image)
    say(as_json, lambda: {"files": [str(image)]}, f"wrote {image}")
    return 0


def _holds_a_sweep(file: Path) -> bool:
    from ..sweeps.store import journal_of
    from ..sweeps.table import is_sweep

    return journal_of(file).is_file() or is_sweep(file)


def _sweep(file: Path, names: list[str], where: list[str]) -> "Figure":
    from ..sweeps.maps import draw, selected
    from ..sweeps.store import load

    table = load(file)
    for text in where:
        table = selected(table, *assignment(text, "--where must be NAME=VALUE"))
    return draw(table, names)


def _run(file: Path, names: list[str], where: list[str]) -> "Figure":
    from .. import figures
    from ..errors import unknown
    from ..trajectory import FORMATS, matching, read_results

    if where:
        raise ValueError(f"--where is for the file of a sweep, {str(file)!r} is none")
    if file.suffix not in FORMATS:
        raise ValueError(f"{str(file)!r} must be a {', '.join(FORMATS)} that cosim run wrote, or the file of a sweep")
    trajectory = read_results(file)
    chosen: list[str] = []
    for pattern in names:
        meant = matching(pattern, trajectory.names)
        if not meant:
            raise unknown("signal", pattern, trajectory.names)
        chosen += [name for name in meant if name not in chosen]
    return figures.time_histories(trajectory, chosen or trajectory.names[:6], file.name)
