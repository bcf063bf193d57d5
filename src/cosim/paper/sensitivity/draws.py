"""A study over the open parameters: the paper's cases for a Latin hypercube of draws, one row a draw, in one file.

It is stored and run as a sweep is (gyro_cosim.sweeps): rows by key, a journal while it goes on, processes on all cores. So a
study that was stopped goes on where it was, what was under way is run again, and a draw that fails is a row with its error.
"""

import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...errors import RunError
from ...master import Progress
from ...master.side_by_side import SideBySide
from ...sweeps.axes import Point
from ...sweeps.pool import Pool, cores
from ...sweeps.runner import Row
from ...sweeps.store import Store, load
from ...sweeps.table import Table
from ...systems import archive, catalogue
from .open_parameters import Open, draws, middle

NAMED = ("kind", "draw", "wheels")  # what a row is, before the parameters: see points()
OUTCOME = ("status", "error", "wall_s")
TEXT = ("run", "kind", "wheels", "status", "error")
DRAW, MIDDLE = "draw", "middle"
MARGIN = ", margin"

Parts = Mapping[str, Sequence[str]]  # claim -> its parts


class Bench(Protocol):
    """A subject with its FMUs open."""

    def measure(self, point: Point, into: dict[str, float]) -> dict[str, dict[str, float]]:
        """Run the cases at a point: what is measured is put into `into` as it comes; returns claim -> part -> margin."""

    def close(self) -> None:
        """Close what was opened."""


class Subject(Protocol):
    """What a study draws parameters for; small, since it goes to every process."""

    @property
    def name(self) -> str:
        """Of the subject, for people and files."""

    @property
    def claims(self) -> Parts:
        """The claims about it."""

    @property
    def measures(self) -> Mapping[str, str]:
        """What is measured: column -> unit."""

    @property
    def sources(self) -> Sequence[str]:
        """Of its FMUs."""

    @property
    def parameters(self) -> tuple[Open, ...]:
        """What is drawn."""

    @property
    def wheels(self) -> Mapping[str, Mapping[str, float]]:
        """Kind of wheels -> values it sets, none of them drawn."""

    @property
    def named(self) -> Mapping[str, tuple[str, Mapping[str, float]]]:
        """Points with a name -> their kind of wheels, and their values of what is drawn."""

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> Bench:
        """The subject with its FMUs; files : source -> location; lanes : what does its runs."""

    def described(self) -> Mapping[str, Any]:
        """What decides the results besides parameters and FMUs, as JSON holds it."""


@dataclass(frozen=True)
class Study:
    """`draws` draws of a subject's open parameters, from `seed`; each is run for every kind of wheels."""

    subject: Subject
    draws: int
    seed: int

    @property
    def columns(self) -> tuple[str, ...]:
        """Of a row: key, what it is, parameters, outcome, measures, and for each part of each claim 1 or 0, and its margin."""
        targets = (parameter.target for parameter in self.subject.parameters)
        parts = (f"{c}: {p}{end}" for c, parts in self.subject.claims.items() for p in parts for end in ("", MARGIN))
        return ("run", *NAMED, *targets, *OUTCOME, *self.subject.measures, *parts)

    def points(self) -> list[Point]:
        """Every row's point: what has a name and the middle of all ranges (draw -1), then the draws, for each kind of wheels."""
        of = self.subject
        points = [_point(of.parameters, name, -1, *chosen) for name, chosen in of.named.items()]
        points += [_point(of.parameters, MIDDLE, -1, wheels, middle(of.parameters)) for wheels in of.wheels]
        for number, values in enumerate(draws(of.parameters, self.draws, self.seed)):
            points += [_point(of.parameters, DRAW, number, wheels, values) for wheels in of.wheels]
        return points


def _point(parameters: Sequence[Open], kind: str, number: int, wheels: str, values: Mapping[str, float]) -> Point:
    return {"kind": kind, "draw": float(number), "wheels": wheels, **{p.target: values[p.target] for p in parameters}}


@dataclass(frozen=True)
class DrawTask:
    """A gyro_cosim.sweeps.pool.Task."""

    study: Study

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> "DrawRunner":
        """See Task."""
        return DrawRunner(self, self.study.subject.open(files, lanes))

    def lost(self, key: str, point: Point, error: str) -> Row:
        """See Task."""
        return self.row(key, point, error, 0.0, {})

    def seconds(self, point: Point, row: Row) -> float:
        """See Task."""
        return float(row[1 + len(point) + OUTCOME.index("wall_s")])

    def row(self, key: str, point: Point, error: str, seconds: float, values: Mapping[str, float]) -> Row:
        """The row of a draw; what was not measured is NaN."""
        head = [key, *point.values(), "failed" if error else "done", " ".join(error.split()), seconds]
        return head + [values.get(column, float("nan")) for column in self.study.columns[len(head) :]]


class DrawRunner:
    """Does draws in this process."""

    def __init__(self, task: DrawTask, bench: Bench) -> None:
        self._task, self._bench = task, bench

    def row(self, key: str, point: Point) -> Row:
        """Run the cases of one draw; whatever goes wrong is said in the row, with what was measured before."""
        began, values, error = time.perf_counter(), dict[str, float](), ""
        try:
            for claim, margins in self._bench.measure(point, values).items():
                for part, margin in margins.items():
                    values |= {f"{claim}: {part}": float(margin > 0.0), f"{claim}: {part}{MARGIN}": margin}
        except RunError as failure:
            error = str(failure)
        except Exception as failure:  # a study goes on, whatever one draw meets; the row names the error and its kind
            error = f"{type(failure).__name__}: {failure}"
        return self._task.row(key, point, error, time.perf_counter() - began, values)

    def close(self) -> None:
        """Close the FMUs."""
        self._bench.close()


def carry_out(study: Study, file: Path, *, workers: int | None = None, progress: Progress | None = None) -> Table:
    """All rows of a study, doing those that its file does not hold yet; Ctrl-C keeps what is done and is raised again.

    Parameters
    ----------
    study
        What is drawn and run.
    file
        .csv, .npz or .parquet.
    workers
        Processes, one a core where None.
    progress
        Called with draws done and draws in all.

    Returns
    -------
    Table

    Raises
    ------
    ValueError
        Where the file holds another study.
    """
    files = {source: str(catalogue.fmu(source)) for source in study.subject.sources}
    definition = _definition(study, files)
    runs = {_hash([definition, point]): point for point in study.points()}
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        store = Store(file, study.columns, TEXT, definition, extend=False)
    except ValueError as error:
        raise ValueError(f"{str(error).partition(';')[0]}; give another folder, or remove the file") from None
    finish = False
    try:
        todo = {key: point for key, point in runs.items() if key not in store.done}
        done = len(runs) - len(todo)
        try:
            for rows in Pool(DrawTask(study), files, min(workers or cores(), len(todo))).results(todo) if todo else ():
                store.append(rows)
                done += len(rows)
                if progress is not None:
                    progress(done, len(runs))
        finally:
            finish = True
    finally:
        store.close(finish=finish)
    table = load(file)
    order = {key: place for place, key in enumerate(runs)}
    return table.where(np.argsort([order[key] for key in table["run"].tolist()]))


def _definition(study: Study, files: Mapping[str, str]) -> dict[str, Any]:
    """What decides the rows; equal for equal studies. Axes and units also serve `cosim plot`."""
    of = study.subject
    return {
        "system": of.name,
        "samples": study.draws,
        "seed": study.seed,
        "axes": [[p.target, {"low": p.low, "high": p.high, "log": False}] for p in of.parameters],
        "wheels": {name: dict(values) for name, values in of.wheels.items()},
        "named": {name: [wheels, dict(values)] for name, (wheels, values) in of.named.items()},
        "fmus": {source: hashlib.sha256(archive.read(file)).hexdigest()[:20] for source, file in files.items()},
        "units": {p.target: p.unit for p in of.parameters} | dict(of.measures) | {"wall_s": "s"},
        "variants": {},
        **of.described(),
    }


def _hash(what: Any) -> str:
    return hashlib.sha256(json.dumps(what, sort_keys=True, default=str).encode()).hexdigest()[:16]


def sources_of(*modules: Path) -> str:
    """A hash of files of Python that decide what a row holds."""
    return hashlib.sha256(b"".join(module.read_bytes() for module in modules)).hexdigest()[:16]


def plain(options: Any) -> dict[str, Any]:
    """A dataclass as JSON holds it."""
    return dict(json.loads(json.dumps(asdict(options))))
