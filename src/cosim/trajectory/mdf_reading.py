"""The program that reads one .mf4 file: the library for it ends the process at some damaged files, so this is one of its own.

    python -P -m gyro_cosim.trajectory.mdf_reading FILE

On standard output goes what numpy.savez writes: t, shape (n,), values, shape (n, m), and `told`, JSON of names, units and origin.
Exit code 1 with a line on standard error where the file holds no such results.
"""

import io
import json
import os
import sys
from pathlib import Path

import numpy as np

from .mdf_files import ORIGIN


def main(file: str) -> int:
    """Read the first group of the file."""
    goal = os.dup(1)
    os.dup2(2, 1)  # what a library prints is no result
    from asammdf import MDF

    try:
        with MDF(Path(file)) as opened:
            if not opened.groups:
                raise ValueError("it must hold a group of channels")
            master = opened.masters_db.get(0)
            places = [k for k in range(len(opened.groups[0].channels)) if k != master]
            signals = [opened.get(group=0, index=k) for k in places]
            t = np.array(opened.get_master(0), dtype=float)
            told = [k for k, block in enumerate(opened.attachments) if str(block.file_name) == ORIGIN]
            origin = bytes(opened.extract_attachment(told[0])[0]).decode() if told else ""
        numbers = [s for s in signals if s.samples.ndim == 1 and s.samples.dtype.kind in "fiub"]
        values = np.array([np.asarray(s.samples, dtype=float) for s in numbers]).T.reshape(t.size, len(numbers))
        words = {"names": [str(s.name) for s in numbers], "units": [str(s.unit) for s in numbers], "origin": origin}
        content = io.BytesIO()
        np.savez(content, allow_pickle=False, t=t, values=values, told=np.array(json.dumps(words)))
        with os.fdopen(goal, "wb") as stream:
            stream.write(content.getbuffer())
    except Exception as error:  # whatever it is, who asked needs one line
        print(f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"[:500], file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
