"""A bare C loop over the FMUs' functions: what a master could reach at most. loop.c, compiled anew each time."""

import ctypes
import shutil
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from case import Case, answer, asked

from gyro_cosim.fmus.compiler import compile_libraries, host

HERE = Path(__file__).parent
REPEATS = 10  # the loop is short: the fastest of them counts


class End(ctypes.Structure):
    """Ours of loop.c: a loaded FMU with its references."""

    _fields_ = (
        ("library", ctypes.c_char_p), ("guid", ctypes.c_char_p), ("resources", ctypes.c_char_p),
        ("n_outputs", ctypes.c_size_t), ("outputs", ctypes.POINTER(ctypes.c_uint)),
        ("source", ctypes.c_uint), ("target", ctypes.c_uint),
    )  # fmt: skip


def compiled(folder: Path) -> ctypes.CDLL:
    """loop.c as a library."""
    shutil.copy(HERE / "loop.c", folder)
    for header in (Path(fmpy.__file__).parent / "c-code").glob("fmi2*.h"):
        shutil.copy(header, folder)
    (library,) = compile_libraries(folder, {"loop.c": "-O3"}, "loop", {host(): True}).values()
    file = folder / f"compiled{host().suffix}"
    file.write_bytes(library)
    return ctypes.CDLL(str(file))


def ends(case: Case, folder: Path) -> list[End]:
    """Both FMUs unpacked, as the C loop wants them: one output goes to the other's one input."""
    pointers = []
    for name, path in case.fmus.items():
        place = fmpy.extract(path, str(folder / name))
        description = fmpy.read_model_description(place)
        reference = {v.name: v.valueReference for v in description.modelVariables}
        identifier = description.coSimulation.modelIdentifier
        (source,) = (out for a, out, _, _ in case.connections if a == name)
        (target,) = (into for _, _, b, into in case.connections if b == name)
        outputs = [reference[out] for out in case.outputs[name]]
        pointers.append(
            End(
                str(Path(place) / "binaries" / fmpy.platform / (identifier + fmpy.sharedLibraryExtension)).encode(),
                description.guid.encode(), (Path(place) / "resources").as_uri().encode(),
                len(outputs), (ctypes.c_uint * len(outputs))(*outputs), reference[source], reference[target],
            )
        )  # fmt: skip
    return pointers


def main() -> None:
    """Run, and answer with the fastest."""
    case = asked()
    with tempfile.TemporaryDirectory() as scratch:
        library = compiled(Path(scratch))
        pair = (End * 2)(*ends(case, Path(scratch)))
        n = len(case.names())
        end = (ctypes.c_double * n)()
        seconds, best = ctypes.c_double(), float("inf")
        run = library.run
        run.restype = ctypes.c_char_p
        for _ in range(REPEATS):
            log = np.empty(n * (case.steps + 1) if case.log else 1)  # a new one each time, as a master has for each run
            failure = run(
                pair, ctypes.c_int(case.algorithm == "gauss-seidel"), ctypes.c_double(case.step), ctypes.c_long(case.steps),
                log.ctypes.data_as(ctypes.c_void_p) if case.log else None, end, ctypes.byref(seconds),
            )  # fmt: skip
            if failure:
                raise RuntimeError(failure.decode())
            best = min(best, seconds.value)
            del log
        answer(best, dict(zip(case.names(), end, strict=True)))


main()
