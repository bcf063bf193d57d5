"""One run of a sweep, where it is done: a point becomes a row. FMUs are opened once and serve run after run."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import master
from ..errors import RunError
from ..master import Run
from ..master.side_by_side import SideBySide
from ..network import Network
from ..systems import System
from .axes import Point
from .plan import FIXED, SweepContext
from .query import MEASURES

BLOCK = 4096  # rows measured at a time
Row = list[Any]  # in the order of Plan.columns


class Runner:
    """Does the runs of one sweep in this process. files : key of an FMU -> its location here; lanes : what does them."""

    def __init__(self, context: SweepContext, files: Mapping[str, str], lanes: SideBySide | None = None) -> None:
        self._context, self._files, self._lanes = context, files, lanes or SideBySide(1)
        self._open: dict[tuple[str, ...], Network] = {}

    def row(self, key: str, point: Point) -> Row:
        """Do the run and measure it; whatever goes wrong is said in the row."""
        began = time.perf_counter()
        run, error, waited = None, "", 0.0
        try:
            run, waited = self._run(point)
        except RunError as failure:
            run, error = failure.partial, str(failure)
        except Exception as failure:  # a sweep goes on, whatever one run meets; the row names the error and its kind
            error = f"{type(failure).__name__}: {failure}"
        extra, wrong = self._extra(run)
        row = row_of(self._context, key, point, run, error or wrong, 0.0, extra)
        # measuring is part of the work; of what was done side by side a share
        row[1 + len(point) + FIXED.index("wall_s")] = time.perf_counter() - began - waited
        return row

    def _extra(self, run: Run | None) -> tuple[list[float] | None, str]:
        """The numbers of the user's measure, None where there are none, and what went wrong with them."""
        if self._context.measure is None or run is None:
            return None, ""
        try:
            return self._context.measure(run.trajectory), ""
        except Exception as failure:  # as for the run: the row says it, and the sweep goes on
            return None, f"measuring the run: {type(failure).__name__}: {failure}"

    def close(self) -> None:
        """Close what was opened."""
        for network in self._open.values():
            network.close()
        self._open.clear()

    def _run(self, point: Point) -> tuple[Run, float]:
        """The run, and the seconds that it waited for others."""
        system = self._context.system_at(point, self._files)
        algorithm = self._context.algorithm_at(point)
        options = master.Options(compiled=True)
        network, began = self._network(system), time.perf_counter()
        run, own = self._lanes.run(network, algorithm, self._context.step_at(point), self._context.stop, options)
        return run, time.perf_counter() - began - own

    def _network(self, system: System) -> Network:
        """The system's wiring and values around slaves that are open already, if ever they were opened."""
        sources = tuple(part.source for part in system.components)
        if sources not in self._open:
            self._open[sources] = master.open_network(system)
        return Network(system, self._open[sources].slaves)


def row_of(
    context: SweepContext, key: str, point: Point, run: Run | None, error: str, seconds: float, extra: list[float] | None = None
) -> Row:
    """The row of a run, which may have failed on the way, or before it began. extra : the numbers of the sweep's own measure."""
    status = "failed" if error or run is None else run.status
    head = [key, *point.values(), status, " ".join(error.split()), run.ended_by if run is not None else ""]
    nan = float("nan")
    if run is None:
        return [*head, 0.0, 0.0, seconds, nan, nan, *[nan] * len(context.measured)]
    trajectory = run.trajectory
    place = {name: j for j, name in enumerate(trajectory.names)}
    columns = [place.get(name) for name in context.signals]
    measured = _measured(np.asarray(trajectory.values))
    measures = [x for j in columns for x in ([nan] * len(MEASURES) if j is None else measured[:, j].tolist())]
    exchanged = sum(bond.exchanged for bond in run.energy)
    if extra is None:
        extra = [nan] * (len(context.measured) - len(measures))
    return [*head, float(run.steps), float(trajectory.t[-1]), seconds, run.energy_residual, exchanged, *measures, *extra]


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
