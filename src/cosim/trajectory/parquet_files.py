"""Results in .parquet files: a column a signal, `time` first, its unit in the metadata of its field."""

from pathlib import Path

import numpy as np

from .origin import Origin
from .signals import Trajectory

KEY = b"gyro_cosim.origin"  # in the metadata of the file


def write_parquet(trajectory: Trajectory, file: Path, origin: Origin | None) -> None:
    """Write a .parquet file, with where it comes from inside."""
    import pyarrow
    from pyarrow import parquet

    kind = pyarrow.float64()
    columns = [("time", "s", trajectory.t), *zip(trajectory.names, trajectory.units, trajectory.values.T, strict=True)]
    fields = [pyarrow.field(name, kind, nullable=False, metadata={"unit": unit}) for name, unit, _ in columns]
    arrays = [pyarrow.array(np.ascontiguousarray(values)) for _, _, values in columns]
    about = None if origin is None else {KEY: origin.text()}
    parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields, about)), file)


def read_parquet(file: Path) -> tuple[Trajectory, str]:
    """The trajectory in a .parquet file whose first column is `time`, anyone's, and the text of its origin, perhaps empty."""
    from pyarrow import ArrowInvalid, parquet

    try:
        table = parquet.ParquetFile(file).read()
    except ArrowInvalid as error:
        raise ValueError(str(error).partition("\n")[0]) from None
    names = table.column_names
    if names[:1] != ["time"]:
        raise ValueError("its first column must be time")
    units = tuple((field.metadata or {}).get(b"unit", b"").decode() for field in table.schema)
    columns = [np.asarray(column.to_numpy(), dtype=float) for column in table.columns]
    values = np.array(columns[1:]).T.reshape(columns[0].size, len(columns) - 1)
    origin = (table.schema.metadata or {}).get(KEY, b"").decode()
    return Trajectory(columns[0].copy(), tuple(names[1:]), units[1:], values), origin
