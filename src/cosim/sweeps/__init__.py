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

__all__ = ["Axis", "Listed", "Measure", "Outcome", "Plan", "Ranged", "Sweep", "Table", "load", "parse", "sweep", "write_summary"]


@dataclass(frozen=True)
class Outcome:
    """What a sweep came to: runs in all, those that were in the file before, done now, failed now, and the seconds it took.

    busy : share of the workers' time that was spent in runs; nan on a cluster, whose workers may be others' too.
    """

    runs: int
    before: int
    done: int
    failed: int
    seconds: float
    workers: int
    busy: float
    status: Literal["done", "interrupted"]


def sweep(
    what: Sweep,
    file: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    extend: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Do the runs that `file` does not hold yet, and put their rows there; a failed run is a row with its error.

    file : ends in .npz, .csv or .parquet. workers : processes on this machine, one a core where None.
    scheduler : address of a Dask scheduler, instead. extend : `file` may hold other runs over the same axes.
    progress : called with runs done and runs in all, those of before left out.
    Ctrl-C ends it with what is done. ValueError for wrong use; OSError where rows cannot be kept, with those before kept.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"the number of workers must be at least 1, got {workers}")
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
            team = Pool(plan.context, plan.files, count) if scheduler is None else Cluster(scheduler, plan.context, plan.files)
            for rows in team.results(todo) if todo else ():
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
        status,  # type: ignore[arg-type]
    )  # fmt: skip
