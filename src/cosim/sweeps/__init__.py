"""Sweeps: many runs of one system, over all cores of this machine or a Dask cluster, into one file.

from gyro_cosim import system
from gyro_cosim.sweeps import Sweep, load, sweep

if __name__ == "__main__":  # worker processes import this script
    plan = Sweep(system("wheel-pair"), {"gyro.rotor_speed": "10rpm:300rpm:30", "vehicle.speed": "1:50:20:log"}, stop=10.0)
    sweep(plan, "map.npz")
    print(load("map.npz")["vehicle.yaw_angle.rms"])
"""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Literal

from ..master import Progress
from .axes import Axis, Listed, Ranged, parse
from .cluster import Cluster
from .measure import Measure
from .plan import Plan, Sweep
from .pool import Pool, cores
from .store import Store, load
from .summary import write_summary
from .table import Table
from .way import way_of

__all__ = ["Axis", "Listed", "Measure", "Outcome", "Plan", "Ranged", "Sweep", "Table", "load", "parse", "sweep", "write_summary"]


@dataclass(frozen=True)
class Outcome:
    """What a sweep has done.

    Parameters
    ----------
    runs, before, done, failed
        Runs in all, those that were in the file before, those done now, and those of them that failed.
    seconds
        That it took.
    workers
        Processes on this machine.
    busy
        Share of the workers' time that was spent in runs; NaN on a cluster, whose workers may do other work too.
    status
        "done", or "interrupted" by Ctrl-C.
    way
        Which way the runs went, in one line.
    """

    runs: int
    before: int
    done: int
    failed: int
    seconds: float
    workers: int
    busy: float
    status: Literal["done", "interrupted"]
    way: str


def sweep(
    what: Sweep,
    file: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    lanes: int | None = None,
    extend: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Do the runs that a file does not hold yet, and put their rows there; Ctrl-C ends the sweep with what is done.

    Parameters
    ----------
    what
        The sweep.
    file
        Ends in .npz, .csv or .parquet; a failed run is a row with its error.
    workers
        Processes on this machine, one a core where None.
    scheduler
        Address of a Dask scheduler, whose workers do the runs instead.
    lanes
        How many runs a worker does at once in the lanes of its processor, at most, where that pays; 1 for one at a time. Where
        None, as many as the processor has. The results are the same.
    extend
        Whether the file may hold other runs over the same axes.
    progress
        Called with runs done and runs in all, without those that were in the file before.

    Returns
    -------
    Outcome

    Raises
    ------
    ValueError
        For wrong use, and where the file holds another sweep.
    OSError
        Where rows cannot be kept; those before are.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"the number of workers must be at least 1, got {workers}")
    if lanes is not None and lanes < 1:
        raise ValueError(f"the number of lanes must be at least 1, got {lanes}")
    if workers is not None and scheduler is not None:
        raise ValueError("a sweep runs on workers here or on those of a scheduler, got both")
    began = perf_counter()
    plan = what.plan()
    store = Store(Path(file), plan.columns, plan.text_columns, {**plan.definition, "units": dict(plan.units)}, extend=extend)
    finish = False
    try:
        todo = {key: point for key, point in plan.runs.items() if key not in store.done}
        count = min(workers or cores(), max(1, len(todo)))
        done = failed = 0
        inside, status = 0.0, "done"
        at = {name: place for place, name in enumerate(plan.columns)}
        started = perf_counter()
        try:
            pool: Pool | Cluster
            if scheduler is None:
                pool = Pool(plan.context, plan.files, count, lanes)
            else:
                pool = Cluster(scheduler, plan.context, plan.files, lanes)
            for rows in pool.results(todo) if todo else ():
                store.append(rows)
                done += len(rows)
                failed += sum(row[at["status"]] == "failed" for row in rows)
                inside += sum(row[at["wall_s"]] for row in rows)
                if progress is not None:
                    progress(done, len(todo))
        except KeyboardInterrupt:
            status = "interrupted"
        taken = perf_counter() - started
        busy = inside / (taken * count) if scheduler is None and done else float("nan")
        finish = True
    finally:
        store.close(finish=finish)
    return Outcome(
        len(plan.runs), len(plan.runs) - len(todo), done, failed, perf_counter() - began, count, busy,
        status, way_of(plan, lanes, elsewhere=scheduler is not None),  # type: ignore[arg-type]
    )  # fmt: skip
