"""One run of a sweep, where it is done: a point becomes a row. FMUs are opened once and serve run after run."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import master
from ..errors import RunError
from ..master import Run
from ..network import Network
from ..systems import System
from .axes import Point
from .inquiry import MEASURES
from .plan import FIXED, SweepContext

BLOCK = 4096  # rows measured at a time
Row = list[Any]  # in the order of Plan.columns


class Runner:
    """Does the runs of one sweep in this process. files : key of an FMU -> its location here."""

    def __init__(self, frame: SweepContext, files: Mapping[str, str]) -> None:
        self._frame, self._files = frame, files
        self._open: dict[tuple[str, ...], Network] = {}

    def row(self, key: str, point: Point) -> Row:
        """Do the run and measure it; whatever goes wrong is said in the row."""
        began = time.perf_counter()
        run, error = None, ""
        try:
            run = self._run(point)
        except RunError as failure:
            run, error = failure.partial, str(failure)
        except Exception as failure:  # a sweep goes on, whatever one run meets; the row names the error and its kind
            error = f"{type(failure).__name__}: {failure}"
        own, wrong = self._own(run)
        row = row_of(self._frame, key, point, run, error or wrong, 0.0, own)
        row[1 + len(point) + FIXED.index("wall_s")] = time.perf_counter() - began  # measuring is part of the work
        return row

    def _own(self, run: Run | None) -> tuple[list[float] | None, str]:
        """The numbers of one's own, None where there are none, and what went wrong with them."""
        if self._frame.measure is None or run is None:
            return None, ""
        try:
            return self._frame.measure(run.trajectory), ""
        except Exception as failure:  # as for the run: the row says it, and the sweep goes on
            return None, f"measuring the run: {type(failure).__name__}: {failure}"

    def close(self) -> None:
        """Close what was opened."""
        for network in self._open.values():
            network.close()
        self._open.clear()

    def _run(self, point: Point) -> Run:
        system = self._frame.system_at(point, self._files)
        algorithm = self._frame.algorithm_at(point)
        options = master.Options(compiled=True)
        return master.run(self._network(system), algorithm, self._frame.step_at(point), self._frame.stop, options=options)

    def _network(self, system: System) -> Network:
        """The system's wiring and values around slaves that are open already, if ever they were opened."""
        sources = tuple(part.source for part in system.components)
        if sources not in self._open:
            self._open[sources] = master.open_network(system)
        return Network(system, self._open[sources].slaves)


def row_of(
    frame: SweepContext, key: str, point: Point, run: Run | None, error: str, seconds: float, own: list[float] | None = None
) -> Row:
    """The row of a run, which may have failed on the way, or before it began. own : the numbers of the sweep's own measure."""
    status = "failed" if error or run is None else run.status
    head = [key, *point.values(), status, " ".join(error.split()), run.ended_by if run is not None else ""]
    nan = float("nan")
    if run is None:
        return [*head, 0.0, 0.0, seconds, nan, nan, *[nan] * len(frame.measured)]
    trajectory = run.trajectory
    place = {name: j for j, name in enumerate(trajectory.names)}
    columns = [place.get(name) for name in frame.signals]
    measured = _measured(np.asarray(trajectory.values))
    measures = [x for j in columns for x in ([nan] * len(MEASURES) if j is None else measured[:, j].tolist())]
    exchanged = sum(bond.exchanged for bond in run.energy)
    if own is None:
        own = [nan] * (len(frame.measured) - len(measures))
    return [*head, float(run.steps), float(trajectory.t[-1]), seconds, run.energy_residual, exchanged, *measures, *own]


def _measured(values: np.ndarray) -> np.ndarray:
    """Last value, largest size and root mean square of each column of values, shape (rows, n); returns shape (3, n).

    Block by block, which a processor's cache holds: a long run has millions of values.
    """
    largest, squares = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    for begin in range(0, len(values), BLOCK):
        block = values[begin : begin + BLOCK]
        largest = np.maximum(largest, np.maximum(block.max(axis=0), -block.min(axis=0)))
        squares += np.einsum("ij,ij->j", block, block)
    return np.array([values[-1], largest, np.sqrt(squares / len(values))])
