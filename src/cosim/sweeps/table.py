"""Rows of a sweep as columns, and the files that hold them: .npz (numpy), .csv, .parquet (with the extra `parquet`).

The head of a table is a dict with MARK, columns, text (the columns that hold text) and definition; every format keeps it:
.npz as the array `head`, .csv in a first line that begins with #, .parquet in the metadata of its schema.
"""

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim.component.whole_files import whole_file

from ..systems import archive

MARK = "cosim sweep"
VERSION = 2  # 1, of gyro-cosim 0.1, drew other samples and called the degree `order`
FORMATS = (".npz", ".csv", ".parquet")


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of a sweep as columns.

    Parameters
    ----------
    head
        See the module's docstring.
    values
        Column -> shape (rows,), of float64 or text.
    """

    head: dict[str, Any]
    values: dict[str, np.ndarray]

    def __getitem__(self, column: str) -> np.ndarray:
        """The column called so."""
        if column not in self.values:
            from ..errors import unknown

            raise unknown("column of the sweep:", column, self.values)
        return self.values[column]

    def __len__(self) -> int:
        return len(self.values["run"])

    def unit(self, column: str) -> str:
        """The unit of a column, empty where it has none."""
        return str(self.head["definition"].get("units", {}).get(column, ""))

    def where(self, chosen: np.ndarray) -> "Table":
        """The rows that a boolean array, shape (rows,), or indices choose."""
        return Table(self.head, {name: column[chosen] for name, column in self.values.items()})

    @staticmethod
    def of_rows(head: dict[str, Any], rows: Sequence[Sequence[Any]]) -> "Table":
        """From rows in the order of the head's columns."""
        columns: Sequence[Sequence[Any]] = list(zip(*rows, strict=True)) if rows else [()] * len(head["columns"])
        values = {
            name: np.array(column, dtype=str if name in head["text"] else float)
            for name, column in zip(head["columns"], columns, strict=True)
        }
        return Table(head, values)

    @staticmethod
    def joined(tables: Sequence["Table"]) -> "Table":
        """One after another, a run that stands in several once; the last table's head, whose definition is the newest."""
        values = {name: np.concatenate([t.values[name] for t in tables]) for name in tables[0].values}
        _, first = np.unique(values["run"], return_index=True)
        return Table(tables[-1].head, values).where(np.sort(first))


def check_format(file: Path) -> None:
    """Refuse a file name whose ending says no format, and a format that is not installed."""
    if file.suffix not in FORMATS:
        raise ValueError(f"sweep file must end in {', '.join(FORMATS)}, got {str(file)!r}")
    if file.suffix == ".parquet":
        _parquet()


def write(table: Table, file: Path) -> None:
    """Write the file under another name and give it its own at the end: it is whole or not there."""
    with whole_file(file) as beside:
        if file.suffix == ".npz":
            _write_npz(table, beside)
        elif file.suffix == ".csv":
            _write_csv(table, beside)
        else:
            _write_parquet(table, beside)


def is_sweep(file: Path) -> bool:
    """Whether the file is one of a sweep."""
    try:
        read(file)
    except (ValueError, OSError):
        return False
    return True


def read(file: Path) -> Table:
    """The table in a file; ValueError if it is not one of a sweep."""
    check_format(file)
    try:
        table = {".npz": _read_npz, ".csv": _read_csv, ".parquet": _read_parquet}[file.suffix](file)
        if list(table.values) != table.head["columns"] or MARK not in table.head or "definition" not in table.head:
            raise ValueError
    except OSError:
        raise
    except Exception:  # each format has errors of its own for what it cannot read
        raise ValueError(f"{str(file)!r} must be the file of a sweep, holds something else") from None
    return table


def _write_npz(table: Table, file: Path) -> None:
    with file.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, head=np.array(json.dumps(table.head)), **table.values)


def _read_npz(file: Path) -> Table:
    with archive.opened(str(file)), np.load(file, allow_pickle=False) as stored:  # the door of all archives looks at it first
        head = json.loads(str(stored["head"]))
        return Table(head, {name: stored[name] for name in head["columns"]})


def _write_csv(table: Table, file: Path) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        stream.write("# " + json.dumps(table.head) + "\n")
        writer = csv.writer(stream)
        writer.writerow(table.values)
        writer.writerows(zip(*(column.tolist() for column in table.values.values()), strict=True))


def _read_csv(file: Path) -> Table:
    with file.open(newline="", encoding="utf-8") as stream:
        head = json.loads(stream.readline(1 << 24).removeprefix("# "))
        names, *rows = csv.reader(stream)
        if names != head["columns"]:
            raise ValueError
        return Table.of_rows(head, rows)


def _parquet() -> Any:
    try:
        from pyarrow import parquet
    except ImportError:
        raise ValueError("sweep files in .parquet need the extra `parquet` (pyarrow), which is not installed") from None
    return parquet


def _write_parquet(table: Table, file: Path) -> None:
    import pyarrow

    stored = pyarrow.table({name: pyarrow.array(column.tolist()) for name, column in table.values.items()})
    _parquet().write_table(stored.replace_schema_metadata({MARK: json.dumps(table.head)}), file)


def _read_parquet(file: Path) -> Table:
    stored = _parquet().read_table(file)
    head = json.loads(stored.schema.metadata[MARK.encode()])
    values = {n: np.array(stored[n].to_pylist(), dtype=str if n in head["text"] else float) for n in head["columns"]}
    return Table(head, values)
