"""A disk that forgets: what can be on it after a loss of power, from a record of the calls that changed its files.

The record is that of c/recorder.c. What a call has changed is sure to survive only once a later fsync has forced it to the disk:
data and size of a file by that of the file, names (a file made, renamed, removed) by that of its folder. Of everything else any
share may survive, in any order, data by sectors. No file system promises less.
"""

import copy
import random
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

__all__ = ["FATES", "Call", "Disk", "cuts", "record", "replayed", "stages"]

_HEAD = struct.Struct("=4sIIIQqQ")
SECTOR = 512  # bytes that are written as a whole
FATES = ("nothing", "everything", "names", "zeros", "data")  # and any number for one drawn by it


@dataclass(frozen=True)
class Call:
    """A call that changed something: C created, W written, Z size, R renamed, U removed, S forced to the disk.

    path, other : names, relative to the folder that was watched. file : the inode. at : where data begins, or the size.
    """

    what: str
    path: str
    other: str
    file: int
    at: int
    data: bytes


def record(file: Path, folder: Path) -> list[Call]:
    """The calls in a record of what was done below a folder."""
    content, place, calls = file.read_bytes(), 0, []
    while place < len(content):
        what, n, m, _, inode, at, size = _HEAD.unpack_from(content, place)
        place += _HEAD.size
        texts = content[place : place + n], content[place + n : place + n + m]
        names = [str(Path(text.decode()).relative_to(folder)) if text else "" for text in texts]
        calls.append(Call(what[:1].decode(), *names, inode, at, content[place + n + m : place + n + m + size]))
        place += n + m + size
    return calls


@dataclass
class _File:
    """safe : what an fsync has forced to the disk. now : what a program reads. since : what was done since that fsync."""

    safe: bytes = b""
    now: bytes = b""
    since: list[tuple[int, bytes | None]] = field(default_factory=list)  # data at a place, None for a size

    def change(self, at: int, data: bytes | None) -> None:
        self.now = _changed(self.now, at, data)
        self.since.append((at, data))

    def survived(self, fate: str, rng: random.Random) -> bytes:
        """What of it is there after a loss of power."""
        if fate in ("everything", "data"):
            return self.now
        if fate == "zeros" and self.since:  # the size is on the disk, what was written there is not
            return self.safe[: len(self.now)].ljust(len(self.now), b"\0")
        if fate in FATES:
            return self.safe
        content = self.safe
        for at, data in self.since:
            for k in range(0, len(data or b"x"), SECTOR):
                if rng.random() < 0.5:
                    content = _changed(content, at + k, None if data is None else data[k : k + SECTOR])
        return content if rng.random() < 0.5 else content[: len(self.now)].ljust(len(self.now), b"\0")


def _changed(content: bytes, at: int, data: bytes | None) -> bytes:
    if data is None:
        return content[:at].ljust(at, b"\0")
    return content[:at].ljust(at, b"\0") + data + content[at + len(data) :]


class Disk:
    """The files below a folder, as they are and as they are sure to be.

    Parameters
    ----------
    folder : Path
        What is in it at the start is on the disk.
    """

    def __init__(self, folder: Path) -> None:
        self._files: dict[int, _File] = {}
        self._called: dict[int, int] = {}  # inode -> its number here, since inodes are given again
        self._safe: dict[str, int] = {}
        for path in folder.rglob("*"):
            if path.is_file():
                self._safe[str(path.relative_to(folder))] = number = self._made(path.stat().st_ino)
                self._files[number] = _File(path.read_bytes(), path.read_bytes())
        self._names = dict(self._safe)
        self._since: list[Call] = []

    def do(self, call: Call) -> None:
        """What the call changes."""
        number = self._made(call.file) if call.what == "C" else self._called.get(call.file, 0)
        if call.what in "WZ":
            self._files[number].change(call.at, call.data if call.what == "W" else None)
        elif call.what == "S" and number:
            file = self._files[number]
            file.safe = file.now
            file.since.clear()
        elif call.what == "S":  # a folder
            for one in [c for c in self._since if str(Path(c.path).parent) == call.path]:
                _name(self._safe, one)
                self._since.remove(one)
        else:
            named = replace(call, file=self._names[call.path] if call.what == "R" else number)
            _name(self._names, named)
            self._since.append(named)

    def _made(self, inode: int) -> int:
        """The number of a new file."""
        self._called[inode] = number = len(self._files) + 1
        self._files[number] = _File()
        return number

    def now(self) -> dict[str, bytes]:
        """What a program sees: name -> content."""
        return {name: self._files[number].now for name, number in self._names.items()}

    def survived(self, fate: str) -> dict[str, bytes]:
        """What is there after a loss of power: name -> content.

        Parameters
        ----------
        fate : str
            nothing: what was forced to the disk alone; everything: all, as where a process is killed; names: all names, no data;
            zeros: all names and sizes, no data; data: all data, no names. Anything else seeds a draw.
        """
        rng = random.Random(fate)
        names = dict(self._names if fate in ("everything", "names", "zeros") else self._safe)
        if fate not in FATES:
            in_order, share = rng.random() < 0.5, rng.random()  # a journal keeps the first so many, other systems any
            first = int(share * (len(self._since) + 1))
            for k, call in enumerate(self._since):
                if k < first if in_order else rng.random() < 0.5:
                    _name(names, call)
        return {name: self._files[number].survived(fate, rng) for name, number in names.items()}


def _name(names: dict[str, int], call: Call) -> None:
    """Make, rename or remove in a table of names."""
    if call.what == "U" or (call.what == "R" and names.get(call.path) == call.file):
        names.pop(call.path, None)
    if call.what != "U":
        names[call.other or call.path] = call.file


def replayed(disk: Disk, calls: list[Call]) -> Disk:
    """The disk after the calls; the one that is given stays as it is."""
    disk = copy.deepcopy(disk)
    for call in calls:
        disk.do(call)
    return disk


def stages(disk: Disk, calls: list[Call]) -> dict[str, set[bytes]]:
    """What each file has held as a whole: before the calls, and whenever a file was given its name by renaming."""
    held = {name: {content} for name, content in disk.now().items()}
    disk = copy.deepcopy(disk)
    for call in calls:
        disk.do(call)
        if call.what == "R":
            held.setdefault(call.other, set()).add(disk.now()[call.other])
    return held


def cuts(disk: Disk, calls: list[Call], seeds: int) -> Iterator[tuple[int, str, dict[str, bytes]]]:
    """Every state that can be found after a loss of power before a call, or at the end, each once: (number, fate, files).

    seeds : draws at each place, besides the fates that have a name.
    """
    disk, seen = copy.deepcopy(disk), set()
    for k in range(len(calls) + 1):
        if k == len(calls):
            seen.clear()  # what is told to be there must be there now
        for fate in (*FATES, *(f"{k} {n}" for n in range(seeds))):
            state = disk.survived(fate)
            mark = hash(tuple(sorted(state.items())))
            if mark not in seen:
                seen.add(mark)
                yield k, fate, state
        if k < len(calls):
            disk.do(calls[k])
