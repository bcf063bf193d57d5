"""What a run keeps: which signals, every how many steps, in memory or streamed to a file."""

import hashlib
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from gyro_cosim.component.whole_files import folder_to_disk, moved_in

from ..errors import unknown
from ..network import Network
from ..trajectory import Trajectory, csv_header, csv_rows, matching
from ..trajectory.origin import beside

GROWTH = 4_000_000  # rows that memory is taken for at once; it is touched only as they come
IN_MEMORY = 20_000_000  # numbers; a run that streams to a file keeps at most this many, every so many rows, as an overview


@dataclass(frozen=True)
class Recording:
    """Which results of a run are kept, and where.

    Parameters
    ----------
    select : sequence of str
        Names of signals, or patterns of names, as trajectory.matching() reads them; empty: all.
    every : int
        Keep every so many macro steps, and the last; where a component fails or ends the run, the last of these. The inner
        loop asks for outputs that are neither coupled nor in a stop condition at these steps only.
    stream : Path, optional
        A .csv file that rows are written to as they come, so that memory stays bounded; None keeps them in memory. Until the run
        is over they are in a file beside it, with `.part` added to the name.

    Raises
    ------
    ValueError
        Names what is wrong.
    """

    select: Sequence[str] = ()
    every: int = 1
    stream: Path | None = None

    def __post_init__(self) -> None:
        if self.every < 1 or self.every != int(self.every):
            raise ValueError(f"`every` must be a whole number of at least 1, got {self.every!r}")
        if self.stream is not None and self.stream.suffix != ".csv":
            raise ValueError(f"results can be streamed to a .csv file only, got {str(self.stream)!r}")


class Recorder:
    """Keeps rows as a Recording says. Row 0 is the start; the last row of a run is kept, too, unless it is forgotten.

    every, columns : which rows, and which places in Y.
    """

    def __init__(self, what: Recording, network: Network, steps: int) -> None:
        self._what, self._steps = what, steps
        self.every = what.every
        self.columns = _selected(what.select, network.names)
        self.names = tuple(network.names[c] for c in self.columns)
        self.units = tuple(network.units[c] for c in self.columns)
        self._all = self.columns.size == len(network.names)
        rows = steps // what.every + 2
        self._stride = 1
        if what.stream is not None:
            self._stride = max(1, -(-rows * max(1, self.columns.size) // IN_MEMORY))
        most = steps + 2 if what.stream is None and what.every == 1 else rows // self._stride + 2
        self._t = np.empty(min(most, GROWTH))
        self._values = np.empty((self._t.size, self.columns.size))
        self._filled = 0  # rows of the two that hold something
        self._kept = 0  # rows recorded so far
        self._last: tuple[float, np.ndarray] | None = None  # the newest row, where it was not recorded
        self._newest: tuple[np.ndarray, np.ndarray] | None = None  # the newest row that was recorded
        self._file: IO[bytes] | None = None
        self._digest = hashlib.sha256()  # of what was written to it

    def begin(self) -> None:
        """Open the file that the rows go to, where they go to one, and write its first line."""
        if self._what.stream is not None:
            self._file = growing(self._what.stream).open("wb")
            folder_to_disk(self._what.stream.parent)  # checkpoints, which rely on this file, may lie elsewhere
            self._append(csv_header(self.names))

    def add(self, k: int, t: np.ndarray, Y: np.ndarray) -> None:
        """Rows k, k + 1, ... of the run: times t (s), shape (n,), outputs Y, shape (n, n_Y)."""
        chosen = slice((-k) % self._what.every, None, self._what.every)
        self._keep(t[chosen], Y[chosen] if self._all else Y[chosen][:, self.columns])
        newest = k + t.size - 1
        self._last = (float(t[-1]), Y[-1, self.columns].copy()) if newest % self._what.every else None

    def forget_last(self) -> None:
        """Do not keep the newest row unless its turn has come."""
        self._last = None

    def _keep(self, t: np.ndarray, rows: np.ndarray) -> None:
        self._write(t, rows)
        if t.size:
            self._newest = (t[-1:].copy(), rows[-1:].copy())
        thinned = slice((-self._kept) % self._stride, None, self._stride)
        self._store(t[thinned], rows[thinned])
        self._kept += t.size

    def _write(self, t: np.ndarray, rows: np.ndarray) -> None:
        if self._file is not None:
            self._append(csv_rows(t, rows))

    def _append(self, data: bytes) -> None:
        if self._file is not None:
            self._digest.update(data)
            try:
                self._file.write(data)
            except OSError as error:  # a full disk: what is there is whole up to here
                raise OSError(error.errno, error.strerror, self._file.name) from error

    def _store(self, t: np.ndarray, rows: np.ndarray) -> None:
        """Append rows to what is in memory, which doubles where it is full."""
        end = self._filled + t.size
        if end > self._t.size:
            size = max(end, 2 * self._t.size)
            self._t = np.concatenate([self._t[: self._filled], np.empty(size - self._filled)])
            self._values = np.concatenate([self._values[: self._filled], np.empty((size - self._filled, self.columns.size))])
        self._t[self._filled : end], self._values[self._filled : end] = t, rows
        self._filled = end

    def finish(self) -> Trajectory:
        """Close the file; the trajectory of what is in memory, which ends with the newest row."""
        if self._last is not None:
            self._keep(np.array([self._last[0]]), self._last[1][None, :])
            self._last = None
        if self._file is not None and self._what.stream is not None:
            self._file.close()
            moved_in(growing(self._what.stream), self._what.stream, beside(self._what.stream))
        memory = self._memory()
        t, values = memory["t"], memory["values"]
        if self._newest is not None and (not t.size or t[-1] != self._newest[0][0]):  # an overview ends where the run does
            t, values = np.append(t, self._newest[0]), np.vstack([values, self._newest[1]])
        return Trajectory(t, self.names, self.units, values)

    def state(self) -> dict[str, np.ndarray]:
        """What a checkpoint keeps: rows in memory, or how long the file is."""
        if self._file is not None:
            self._file.flush()
            os.fsync(self._file.fileno())  # the checkpoint relies on these rows
            digest = np.frombuffer(self._digest.digest(), dtype=np.uint8)
            return {"position": np.array(self._file.tell()), "digest": digest, "kept": np.array(self._kept), **self._memory()}
        return {"kept": np.array(self._kept), **self._memory()}

    def _memory(self) -> dict[str, np.ndarray]:
        return {"t": self._t[: self._filled], "values": self._values[: self._filled]}

    def resume(self, state: dict[str, np.ndarray]) -> None:
        """Go on from what state() gave; in place of begin(). ValueError where the rows before cannot be had."""
        file, position = self._what.stream, int(state["position"]) if "position" in state else None
        if position is None or file is None:
            if int(state["kept"]) != state["t"].size:
                raise ValueError("a run that streamed its results to a .csv file must go on into that file")
            self.begin()
            self._write(state["t"], state["values"])
        else:
            self._file, self._digest = _continued(file, position, state["digest"].tobytes() if "digest" in state else None)
        self._filled, self._kept = 0, int(state["kept"])
        self._store(state["t"], state["values"])


def growing(file: Path) -> Path:
    """Where the rows of a run that streams to `file` are, until the run is over."""
    return file.with_name(f"{file.name}.part")


def _continued(file: Path, position: int, digest: bytes | None) -> tuple[IO[bytes], Any]:
    """What was streamed before, cut off after `position` bytes, open for more; `file` itself stays until the run is over.

    digest : of these bytes, None from older checkpoints; what it has come to is returned, too.
    """
    part = growing(file)
    for held in (part, file):
        so_far = _digest(held, position)
        if so_far is not None and digest in (None, so_far.digest()):
            break
    else:
        raise ValueError(f"results file {str(file)!r} must hold what was streamed before, it has been lost, cut off or exchanged")
    if held is file:  # the run was over, and goes on further than it was to go
        with file.open("rb") as source, part.open("wb") as target:
            shutil.copyfileobj(source, target)
        folder_to_disk(part.parent)
    stream = part.open("r+b")
    stream.truncate(position)
    stream.seek(position)
    return stream, so_far


def _digest(file: Path, position: int) -> Any:
    """The digest of the first `position` bytes of a file, to be updated; None where there are none."""
    if not file.is_file() or file.stat().st_size < position:
        return None
    digest = hashlib.sha256()
    with file.open("rb") as source:
        while position and (data := source.read(min(position, 1 << 20))):
            digest.update(data)
            position -= len(data)
    return digest


def _selected(patterns: Sequence[str], names: Sequence[str]) -> np.ndarray:
    """Places of the names that match a pattern, in their own order; ValueError for a pattern that matches none."""
    if not patterns:
        return np.arange(len(names))
    chosen: set[str] = set()
    for pattern in patterns:
        meant = matching(pattern, names)
        if not meant:
            raise unknown("signal to record:", pattern, names)
        chosen.update(meant)
    return np.array([k for k, name in enumerate(names) if name in chosen], dtype=int)
