"""Workers on many machines: a Dask cluster (extra `dask`). The workers need this package, and nothing else of this machine.

Every worker gets the FMUs once, as files named by their content, when it joins; Dask does the runs of a worker that is lost
again elsewhere, and a run that has taken several workers with it becomes a row with that error.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..systems import archive
from .axes import Point
from .crew import Crew
from .plan import FIXED, SweepContext
from .pool import SweepTask
from .runner import Row, row_of

ANSWERS_WITHIN = 5.0  # s
TASK = 0.5  # s of work in a task
MOST = 200  # runs in a task


class Fmus:
    """A plugin of Dask's workers: the FMUs of a sweep as files there, and crews that have them open.

    A worker with several threads has a crew for each that is at work; lanes, expected : see Crew.
    """

    def __init__(self, name: str, context: SweepContext, contents: Mapping[str, bytes], lanes: int | None, expected: int) -> None:
        self.name, self._context, self._contents = name, context, dict(contents)
        self._lanes, self._expected = lanes, expected
        self._files: dict[str, str] = {}
        self._idle: list[Crew] = []

    def setup(self, worker: Any) -> None:
        """Write the files into the worker's own folder."""
        folder = Path(worker.local_directory) / "cosim-fmus"
        folder.mkdir(parents=True, exist_ok=True)
        for key, content in self._contents.items():
            file = folder / f"{key}.fmu"
            if not file.exists():
                part = file.with_suffix(f".{id(self)}")
                part.write_bytes(content)
                part.replace(file)
            self._files[key] = str(file)

    def teardown(self, worker: Any) -> None:
        """Close the FMUs and remove the files."""
        while self._idle:
            self._idle.pop().close()
        for file in self._files.values():
            Path(file).unlink(missing_ok=True)

    def rows(self, runs: list[tuple[str, Point]]) -> list[Row]:
        """Do the runs."""
        try:
            crew = self._idle.pop()
        except IndexError:
            crew = Crew(SweepTask(self._context), self._files, self._lanes, self._expected)
        done = crew.all_rows(runs)
        self._idle.append(crew)
        return done


def do(name: str, runs: list[tuple[str, Point]]) -> list[Row]:
    """What a task does on its worker."""
    from distributed import get_worker

    plugin: Fmus = get_worker().plugins[name]
    return plugin.rows(runs)


class Cluster:
    """The cluster whose scheduler is at `address`; results() yields rows as they come. ValueError if nobody answers there."""

    def __init__(self, address: str, context: SweepContext, files: Mapping[str, str], lanes: int | None = None) -> None:
        try:
            import distributed
        except ImportError:
            raise ValueError("--scheduler needs the extra `dask` (distributed), which is not installed") from None
        self._context, self._lanes = context, lanes
        try:
            self._client = distributed.Client(address, timeout=ANSWERS_WITHIN, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())
            raise ValueError(f"a Dask scheduler must answer at {address!r} within {ANSWERS_WITHIN:g} s: {reason}") from None
        self._contents = {key: archive.read(location) for key, location in files.items()}

    def results(self, todo: Mapping[str, Point]) -> Iterator[list[Row]]:
        """Rows of all runs in `todo`, in any order."""
        import distributed

        plugin = type("Plugin", (Fmus, distributed.WorkerPlugin), {})  # Dask takes only what is derived from its own class
        name = f"cosim-{next(iter(todo))}"
        runs = list(todo.items())
        client = self._client
        try:
            client.register_plugin(plugin(name, self._context, self._contents, self._lanes, len(runs)), name=name)
            pace, begun = TASK, 0
            tasks: dict[Any, list[tuple[str, Point]]] = {}
            completed = distributed.as_completed(loop=client.loop)

            def submit() -> None:
                nonlocal begun
                slots = max(1, sum(client.nthreads().values()))
                size = max(1, min(MOST, int(TASK / pace), -(-(len(runs) - begun) // (2 * slots))))
                part = runs[begun : begun + size]
                begun += len(part)
                task = client.submit(do, name, part, pure=False)
                tasks[task] = part
                completed.add(task)

            ahead = 2 * max(1, sum(client.nthreads().values()))
            while begun < len(runs) and len(tasks) < ahead:
                submit()
            for task in completed:
                part = tasks.pop(task)
                if task.status == "finished":
                    rows = task.result()
                else:
                    reason = f"{type(task.exception()).__name__}: {' '.join(str(task.exception()).split())}"
                    rows = [row_of(self._context, key, point, None, reason, 0.0) for key, point in part]
                seconds = [row[1 + len(part[0][1]) + FIXED.index("wall_s")] for row in rows]
                pace += 0.3 * (max(sum(seconds) / len(seconds), 1e-4) - pace)
                ahead = 2 * max(1, sum(client.nthreads().values()))
                while begun < len(runs) and len(tasks) < ahead:
                    submit()
                yield rows
        finally:
            client.close()
