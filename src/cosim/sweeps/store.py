"""The file of a sweep: one row a run, kept column by column, and a journal beside it while the sweep goes on.

Rows are appended to FILE.journal, one JSON array a line, as they come, and forced to the disk every SYNCED seconds. A line
that was cut off or spoilt by a crash, a full disk or a loss of power is dropped with all after it. When the sweep ends, or is
interrupted, all rows go into FILE at once, under another name first, and the journal goes. So FILE is whole or absent, and what
a killed sweep had finished is in the journal, where the next start finds it.
"""

import contextlib
import json
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gyro_cosim.component.whole_files import folder_to_disk

from .runner import Row
from .table import MARK, VERSION, Table, check_format, read, write

try:
    import fcntl
except ImportError:  # not a POSIX system: two sweeps into one file at once go unnoticed there
    fcntl = None  # type: ignore[assignment]

SYNCED = 1.0  # s
EXTENSIBLE = {"axes", "samples", "seed", "variants", "cases"}  # in what an extended sweep may differ from the one before


class Store:
    """An open sweep file. done : keys of the rows that are in it."""

    def __init__(
        self, file: Path, columns: Sequence[str], text: Sequence[str], definition: Mapping[str, Any], *, extend: bool
    ) -> None:
        """Open or make it. ValueError if it holds anything but this sweep.

        columns : of a row, the first of them the key; text : those that hold text.
        extend : runs over the same axes, but other values of theirs, are welcome too.
        """
        check_format(file)
        self._file, self._path = file, journal_of(file)
        self._head = {MARK: VERSION, "columns": list(columns), "text": list(text), "definition": json.loads(_json(definition))}
        self.done: set[str] = set()
        self._good = 0  # length of the journal up to its last whole line
        self._rows = 0  # in the journal
        self._synced = time.monotonic()
        if file.exists():
            kept = read(file)
            self._check(kept.head, file, extend)
            self.done.update(kept["run"].tolist())
        created = not self._path.exists()
        self._journal = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            self._lock()
            self._take_up(extend)
        except BaseException:
            os.close(self._journal)
            if created:
                self._path.unlink(missing_ok=True)
            raise

    def append(self, rows: Iterable[Row]) -> None:
        """Keep rows. OSError, with nothing half-written left, where they cannot be."""
        rows = list(rows)
        self._write("".join(_json(row) + "\n" for row in rows))
        self.done.update(row[0] for row in rows)
        self._rows += len(rows)
        if time.monotonic() - self._synced > SYNCED:
            os.fsync(self._journal)
            self._synced = time.monotonic()

    def close(self, *, finish: bool = True) -> None:
        """Put the rows into the file, unless `finish` is off: then they wait in the journal. Either way, let go of it."""
        try:
            if finish and self._rows:
                os.fsync(self._journal)
                write(load(self._file), self._file)
            if finish or not self._rows:
                self._path.unlink()
        finally:
            os.close(self._journal)

    def _lock(self) -> None:
        if fcntl is None:
            return
        try:
            fcntl.flock(self._journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ValueError(f"sweep file {str(self._file)!r} must not be in use, another sweep is writing to it") from None

    def _take_up(self, extend: bool) -> None:
        """Read the journal that a stopped sweep has left, cut off what is not whole; or begin one."""
        data = self._path.read_bytes()
        self._good = len(_whole_lines(data))
        if self._good:
            head, rows = _parsed(data[: self._good], self._path)
            self._check(head, self._path, extend)
            self.done.update(row[0] for row in rows)
            self._rows = len(rows)
            if self._good < len(data):
                os.ftruncate(self._journal, self._good)
        elif data and not data.startswith(f'{{"{MARK}"'.encode()):
            raise ValueError(f"{str(self._path)!r} must be the journal of a sweep, holds something else")
        else:
            os.ftruncate(self._journal, 0)
            self._write(_json(self._head) + "\n")
            os.fsync(self._journal)
            folder_to_disk(self._path.parent)

    def _check(self, head: Mapping[str, Any], where: Path, extend: bool) -> None:
        """Refuse a file of another sweep, and say in what it differs."""
        if head[MARK] != VERSION:
            raise ValueError(
                f"{str(where)!r} must be a sweep of format {VERSION} to go on, has format {head[MARK]}, which can only be drawn"
                "; give another file"
            )
        theirs, ours = dict(head["definition"]), dict(self._head["definition"])
        differ = {k for k in {*theirs, *ours} if theirs.get(k) != ours.get(k)}
        extensible = differ <= EXTENSIBLE and head["columns"] == self._head["columns"] and not _contradict(theirs, ours)
        if differ and not (extend and extensible):
            hint = "; --extend adds runs over the same axes" if extensible else ""
            raise ValueError(
                f"{str(where)!r} holds another sweep, which differs in {', '.join(sorted(differ))}; give another file{hint}"
            )

    def _write(self, text: str) -> None:
        data = text.encode()
        try:
            view = memoryview(data)
            while view:
                view = view[os.write(self._journal, view) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._journal, self._good)
            raise OSError(error.errno, error.strerror, str(self._path)) from None
        self._good += len(data)


def _contradict(theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> bool:
    """Whether a variant of the same name is another FMU there, or a case of the same name holds other values."""
    pairs = [(theirs["variants"].get(target, {}), of) for target, of in ours["variants"].items()]
    pairs.append((theirs.get("cases", {}), ours.get("cases", {})))
    return any(old[name] != of[name] for old, of in pairs for name in old.keys() & of.keys())


def journal_of(file: Path) -> Path:
    """Where the rows of `file` are while its sweep goes on."""
    return file.with_name(file.name + ".journal")


def load(file: Path) -> Table:
    """All rows of a sweep file, those in its journal included.

    Parameters
    ----------
    file
        Of a sweep, of this or an older version.

    Returns
    -------
    Table

    Raises
    ------
    ValueError
        Where there is no such file, or it is something else.
    """
    tables = [read(file)] if file.exists() else []
    journal = journal_of(file)
    if journal.exists():
        data = journal.read_bytes()
        head, rows = _parsed(_whole_lines(data), journal)
        tables.append(Table.of_rows(head, rows))
    if not tables:
        raise ValueError(f"sweep file {str(file)!r} must exist")
    return Table.joined(tables)


def _whole_lines(data: bytes) -> bytes:
    """The lines up to the first that a crash or a loss of power has cut off or spoilt: no line of JSON holds a zero byte."""
    return data[: data.rfind(b"\n", 0, data.find(b"\0") if b"\0" in data else len(data)) + 1]


def _parsed(data: bytes, where: Path) -> tuple[dict[str, Any], list[Row]]:
    try:
        head, *rows = (json.loads(line) for line in data.splitlines())
        head["definition"], head["columns"], head["text"], head[MARK]
    except (ValueError, KeyError, TypeError):
        raise ValueError(f"{str(where)!r} must be the journal of a sweep, holds something else") from None
    return head, rows


def _json(what: Any) -> str:
    return json.dumps(what, separators=(",", ":"), default=str)
