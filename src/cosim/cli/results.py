"""Where the results of `cosim run` go: files of any number and format, of which a .csv may be streamed, and a figure."""

import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.table import Table

from .. import trajectory
from ..master import Run
from ..master.recording import IN_MEMORY, Recording
from ..trajectory import Origin, Trajectory
from . import drawing
from .assessments import Assessed, drawn, figure, lines, tables
from .common import plain, progress, writable
from .given import repeated
from .settings import words

AUTO_STREAM = 2_000_000  # numbers from which a .csv file is written while the run goes on, so that memory stays bounded


@dataclass(frozen=True)
class Files:
    """The files of --output and --plot.

    Parameters
    ----------
    outputs : tuple of Path
        Files of results, each in the format that its ending names.
    plot : Path or None
        A figure.
    origin : Origin or None
        Where the results come from; its folder is the one where the command runs.
    report : Path or None
        A page of the run.
    variants : str
        Of the component that people exchange, those that the page offers: all, none, or names with commas.
    command : str
        What makes them again; the present command where empty.
    """

    outputs: tuple[Path, ...]
    plot: Path | None
    origin: Origin | None = None
    report: Path | None = None
    variants: str = "all"
    command: str = ""
    _places: dict[Path, Path] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for file in (*self.outputs, *filter(None, [self.plot, self.report])):
            self._places[file] = file.absolute()  # an FMU may change the current folder

    @property
    def all(self) -> tuple[Path, ...]:
        """Every file that is written."""
        return (*self.outputs, *filter(None, (self.plot, self.report)))

    def check(self) -> None:
        """Refuse, before any work, what cannot be written afterwards."""
        for k, file in enumerate(self.outputs):
            writable(file, trajectory.check_format)
            if file in self.outputs[:k]:
                raise ValueError(f"--output must name different files, got {str(file)!r} twice")
        drawing.check(self.plot)
        if self.report is not None:
            from ..report import check_format

            writable(self.report, check_format)

    def recording(self, select: Sequence[str], every: int, numbers: int, *, always: bool, never: bool) -> Recording:
        """What the run keeps of its `numbers` results, with the first .csv streamed where there are many.

        always, never : stream whatever their number, keep all in memory whatever their number.

        Raises
        ------
        ValueError
            Where results too many for memory are to go into a format that is written as a whole.
        """
        first = next((file for file in self.outputs if file.suffix == ".csv"), None)
        never = never or self.report is not None
        streams = first is not None and not never and (always or numbers > AUTO_STREAM)
        if streams and numbers > IN_MEMORY * every:
            for file in self.outputs:
                if file != first:
                    rule = f"results of more than {IN_MEMORY:,} numbers go into one .csv file only"
                    raise ValueError(f"{rule}, got {str(file)!r} besides (--record-every N keeps fewer)")
        if not streams or first is None:
            return Recording(tuple(select), every)
        return Recording(tuple(select), every, self._places[first])

    def write(self, run: Run, found: Sequence[Assessed], streamed: Path | None) -> list[Path]:
        """Write what has not been streamed; all files that are there now."""
        written = self.rescue(run.trajectory, streamed)
        if self.plot is not None:
            _plot(run, found, self._places[self.plot])
            written.append(self.plot)
        return written

    def rescue(self, results: Trajectory, streamed: Path | None) -> list[Path]:
        """Write what has not been streamed of the results alone; all files of results that are there now."""
        for file in self.outputs:
            place = self._places[file]
            if place == streamed:
                trajectory.tell_origin(place, results, self.seen_from(place))
            else:
                results.save(place, self.seen_from(place))
        return list(self.outputs)

    def made_by(self, command: Sequence[str], hashes: Mapping[str, str]) -> "Files":
        """The same files of results that another command makes again. hashes : of the files that it reads besides."""
        origin = self.origin
        if origin is not None:
            origin = replace(origin, command=tuple(command), hashes={**origin.hashes, **hashes})
        made = replace(self, origin=origin, command=shlex.join(["cosim", *command]))
        made._places.update(self._places)
        return made

    def page(self, run: Run, found: Sequence[Assessed], certificate: Sequence[str | Table], every: int) -> list[Path]:
        """Write the page of a run, where one is wished; the files that are there now.

        certificate : the estimate of the coupling error in words. every : macro steps between recorded rows.
        """
        if self.report is None:
            return []
        from ..report import Told, write_report

        named = {"all": None, "none": ()}
        told = Told(
            variants=named[self.variants] if self.variants in named else words(self.variants),
            command=self.command or repeated(),
            lines=[line for line in lines(found) if line],
            certificate=plain(certificate),
            texts=[(table.title, plain([drawn(table)])) for table in tables(found)],
            record_every=every,
            prefer=_drawn(run),
        )
        with progress("making the page") as show:
            write_report(self._places[self.report], run, replace(told, progress=show))
        return [self.report]

    def seen_from(self, place: Path) -> Origin | None:
        """The origin, with the folder where the command runs as the file's own folder sees it."""
        if self.origin is None:
            return None
        try:
            folder = os.path.relpath(self.origin.folder, place.parent)
        except ValueError:  # on another drive
            folder = self.origin.folder
        return replace(self.origin, folder=Path(folder).as_posix())


def _plot(run: Run, found: Sequence[Assessed], file: Path) -> Path:
    """Draw what the first field that has found something draws, else time histories."""
    from .. import figures

    title = f"{run.system.name}: " + ", ".join(f"{c.name} = {c.source.rpartition('/')[2]}" for c in run.system.components)
    made = figure(found, run.trajectory, title)
    return drawing.save(figures.time_histories(run.trajectory, _drawn(run), title) if made is None else made, file)


def _drawn(run: Run) -> list[str]:
    """Signals that change, at most six: angles and displacements first, then what crosses an interface, then the rest."""
    from .. import figures

    trajectory = run.trajectory
    crossing = {".".join(c.start) for c in run.system.connections}
    rank = {"m": 0, "rad": 0}
    return figures.worth_drawing(trajectory, 6, lambda name: rank.get(trajectory.unit(name), 1 if name in crossing else 2))
