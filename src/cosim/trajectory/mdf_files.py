"""Results in .mf4 files: MDF 4.1 of ASAM, as measurements are kept, in one group of channels with `time` as its master."""

import datetime
from pathlib import Path

import numpy as np

from .origin import Origin
from .signals import Trajectory

ORIGIN = "gyro_cosim.origin.json"  # the attachment that says where the file comes from
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
    """The trajectory in the first group of an .mf4 file, anyone's, and the text of its origin, perhaps empty."""
    from asammdf import MDF
    from asammdf.blocks.utils import MdfException

    try:
        with MDF(file) as opened:
            if not opened.groups:
                raise ValueError("it must hold a group of channels")
            master = opened.masters_db.get(0)
            places = [k for k in range(len(opened.groups[0].channels)) if k != master]
            signals = [opened.get(group=0, index=k) for k in places]
            t = np.array(opened.get_master(0), dtype=float)
            told = [k for k, block in enumerate(opened.attachments) if str(block.file_name) == ORIGIN]
            origin = bytes(opened.extract_attachment(told[0])[0]).decode() if told else ""
    except MdfException as error:
        raise ValueError(str(error).partition("\n")[0]) from None
    numbers = [s for s in signals if s.samples.ndim == 1 and s.samples.dtype.kind in "fiub"]
    values = np.array([np.asarray(s.samples, dtype=float) for s in numbers]).T.reshape(t.size, len(numbers))
    return Trajectory(t, tuple(s.name for s in numbers), tuple(s.unit for s in numbers), values), origin
