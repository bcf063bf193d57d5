"""cosim plot: draw what is in files, histories of runs over one another, or maps of a sweep."""

import glob
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import assessments, drawing
from .common import AsJson, needs, say, tell
from .labels import labelled
from .settings import assignment

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..figures import Style
    from ..trajectory import Trajectory

PANELS = 30  # that one figure may have


def command(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE... [NAMES]...",
            help="results of cosim run, several over one another, and signals of theirs, in which * and ? are wild; or the "
            "results of cosim sweep, and X Y MEASURE or X MEASURE",
        ),
    ],
    over: Annotated[
        str | None, typer.Option(metavar="time|distance|SIGNAL", help="of runs, what lies on the x axis; time otherwise")
    ] = None,
    label: Annotated[
        list[str] | None, typer.Option(metavar="WORDS", help="what a FILE is called in the legend, one for each in turn")
    ] = None,
    style: Annotated[str, typer.Option(metavar="screen|paper", help="for a screen, or a vector figure for a paper")] = "screen",
    columns: Annotated[
        int | None, typer.Option(metavar="1|2", help="of --style paper: how wide, 88 mm or 180 mm; 1 otherwise")
    ] = None,
    where: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="of a sweep, only runs with this value of an axis")
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o", "--output", metavar="IMAGE", help="where to draw, as often as you like; beside the first FILE otherwise"
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="replace an IMAGE which does not say that cosim drew it")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Draw signals of runs over time, distance or a signal, or a measure of a sweep over its axes.

    Without NAMES a vehicle's run is drawn along its track, and of other runs six signals that change.
    """

    looks = _style(style, columns)
    files, names = _told_apart(what)
    images = output or [files[0].with_suffix(".pdf" if style == "paper" else ".png")]
    for image in images:
        if drawing.foreign(image) and not overwrite:
            raise ValueError(f"{str(image)!r} must be a figure that cosim drew, or --overwrite is needed: it does not say so")
        drawing.check(image)
    with looks.applied():
        if _holds_a_sweep(files[0]):
            needs("--over", over, "the results of a run", False)
            needs("--label", label, "the results of a run", False)
            if len(files) > 1:
                raise ValueError(f"a sweep is drawn alone, got {len(files)} files")
            made = _sweep(files[0], names, where or [], looks)
        else:
            if where:
                raise ValueError(f"--where is for the file of a sweep, {str(files[0])!r} is none")
            made = _runs(files, names, over, label or [], looks)
        for image in images:
            drawing.save(made, image)
    say(as_json, lambda: {"files": [str(image) for image in images]}, *(f"wrote {image}" for image in images))
    return 0


def _style(style: str, columns: int | None) -> "Style":
    from .. import figures
    from ..errors import unknown

    if style not in ("screen", "paper"):
        raise unknown("--style", style, ("screen", "paper"))
    needs("--columns", columns, "--style paper", style == "paper")
    return figures.SCREEN if style == "screen" else figures.paper(1 if columns is None else columns)


def _told_apart(what: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Files and names: the first is a file, and each after it that is one, or ends like one, or fits some."""
    from ..sweeps.store import journal_of
    from ..sweeps.table import FORMATS as SWEPT
    from ..trajectory import FORMATS

    files: list[Path] = []
    names: list[str] = []
    for k, word in enumerate(what):
        file = Path(word)
        if k and not file.is_file() and file.suffix not in {*FORMATS, *SWEPT}:
            names.append(word)
            continue
        fitting = [file] if file.is_file() or journal_of(file).is_file() else sorted(map(Path, glob.glob(word)))  # noqa: PTH207
        if not fitting:
            raise ValueError(f"file {word!r} must exist")
        files += [one for one in fitting if one not in files]
    return files, names


def _holds_a_sweep(file: Path) -> bool:
    from ..sweeps.store import journal_of
    from ..sweeps.table import is_sweep

    return journal_of(file).is_file() or is_sweep(file)


def _sweep(file: Path, names: Sequence[str], where: Sequence[str], style: "Style") -> "Figure":
    from ..sweeps.maps import draw, selected
    from ..sweeps.store import load

    table = load(file)
    for text in where:
        table = selected(table, *assignment(text, "--where must be NAME=VALUE"))
    return draw(table, names, style)


def _runs(files: Sequence[Path], names: Sequence[str], over: str | None, given: Sequence[str], style: "Style") -> "Figure":
    from .. import figures
    from ..trajectory import FORMATS, read_with_origin

    for file in files:
        if file.suffix not in FORMATS:
            raise ValueError(f"{str(file)!r} must be a {', '.join(FORMATS)} that cosim run wrote, or the file of a sweep")
    if len(files) > figures.LINES:
        raise ValueError(f"at most {figures.LINES} runs can be told apart in one figure, got {len(files)}")
    read = [read_with_origin(file) for file in files]
    for file, (run, _) in zip(files, read, strict=True):
        if not len(run):
            raise ValueError(f"{str(file)!r} must hold at least one row, holds none")
    title, called = labelled(files, [origin for _, origin in read])
    if given:
        if len(given) != len(files) or len(set(given)) != len(given):
            raise ValueError(f"--label must name each of {len(files)} files differently, got {', '.join(map(repr, given))}")
        called = list(given)
    runs = {word: run for word, (run, _) in zip(called, read, strict=True)}
    if not names and over is None:
        made = assessments.overlay(runs, title, style)
        if made is not None:
            return made
    known = list(dict.fromkeys(name for run in runs.values() for name in run.names))
    chosen = _signals(names, known) or figures.worth_drawing(read[0][0], 6, lambda name: 0)
    if len(chosen) > PANELS:
        raise ValueError(f"one figure must hold at most {PANELS} signals, got {len(chosen)}: name fewer")
    overlay = figures.Overlay.of(runs, chosen, _axis(over or figures.TIME, runs))
    tell(overlay.notes)
    return figures.drawn_overlay(overlay, title, style)


def _signals(patterns: Sequence[str], known: Sequence[str]) -> list[str]:
    """The signals that patterns mean, each once; ValueError for a pattern that means none."""
    from ..errors import unknown
    from ..trajectory import matching

    chosen: dict[str, None] = {}
    for pattern in patterns:
        meant = matching(pattern, known)
        if not meant:
            raise unknown("signal", pattern, known)
        chosen |= dict.fromkeys(meant)
    return list(chosen)


def _axis(over: str, runs: "dict[str, Trajectory]") -> str:
    """The signal on the x axis: "time", a signal, or the first of the one component that has one which ends so."""
    from .. import figures
    from ..errors import unknown

    every = [name for name in next(iter(runs.values())).names if all(name in run.names for run in runs.values())]
    if over == figures.TIME or over in every:
        return over
    ending = [name for name in every if name.endswith((f".{over}", f"_{over}"))]
    if not ending:
        raise unknown("signal of every run", over, [figures.TIME, *every])
    if len({name.rpartition(".")[0] for name in ending}) > 1:
        raise ValueError(f"--over must name one signal, {over!r} may be {', '.join(ending)}")
    return ending[0]
