"""Results in .mf4 files: MDF 4.1 of ASAM, as measurements are kept, in one group of channels with `time` as its master."""

import datetime
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from .origin import Origin
from .signals import Trajectory

ORIGIN = "gyro_cosim.origin.json"  # the attachment that says where the file comes from
LEAST, PER_MB = 60.0, 1.0  # s that reading may take, of any file and for each MB
EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)  # when a simulation "was measured": the same for every run


def write_mdf(trajectory: Trajectory, file: Path, origin: Origin | None) -> None:
    """Write an .mf4 file, with where it comes from inside."""
    from asammdf import MDF, Signal

    with MDF(version="4.10") as made:
        made.header.start_time = EPOCH
        if origin is not None:
            made.attach(origin.text().encode(), file_name=ORIGIN, mime="application/json")
        columns = zip(trajectory.names, trajectory.units, trajectory.values.T, strict=True)
        signals = [Signal(np.ascontiguousarray(v), trajectory.t, unit=unit, name=name) for name, unit, v in columns]
        made.append(signals, common_timebase=True)
        made.save(file, overwrite=True, compression=2)


def read_mdf(file: Path) -> tuple[Trajectory, str]:
    """The trajectory in the first group of an .mf4 file, anyone's, and the text of its origin, perhaps empty.

    It is read in a process of its own, which a damaged file can end (mdf_reading.py).
    """
    with file.open("rb") as stream:
        patience = LEAST + PER_MB * os.fstat(stream.fileno()).st_size / 1e6
    command = [sys.executable, "-P", "-m", "gyro_cosim.trajectory.mdf_reading", str(file.resolve())]
    try:
        done = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, timeout=patience, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"asammdf does not come to an end with it within {patience:.0f} s") from None
    if done.returncode == 1:
        raise ValueError(done.stderr.decode(errors="replace").strip().rpartition("\n")[2])
    if done.returncode != 0:
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
        raise ValueError(f"asammdf, which reads it, ended with {how}")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as read:
        t, values, told = read["t"], read["values"], json.loads(str(read["told"]))
    return Trajectory(t, tuple(told["names"]), tuple(told["units"]), values), str(told["origin"])
