"""Steps of several instances of an FMU of ours at once, in the lanes of a register: compiled from the sources it carries."""

import ctypes
import platform
from functools import cache, partial
from pathlib import Path

from ...systems import archive, machine_code

__all__ = ["LaneCode", "lane_code", "widest", "without_lanes"]

NO_LANES = "#define NO_LANES"


class LaneCode:
    """The library of fmus/c/lanes.c of an FMU.

    Parameters
    ----------
    library : ctypes.PyDLL
        The library.
    token : str
        The instantiation token of the FMU, which must be that of the library.

    Attributes
    ----------
    step, output : int
        Addresses of batch_step and batch_output.

    Raises
    ------
    ValueError
        If library and FMU are not of one model.
    """

    def __init__(self, library: ctypes.PyDLL, token: str) -> None:
        self._library = library
        have = ctypes.string_at(ctypes.addressof(ctypes.c_char.in_dll(self._library, "INSTANTIATION_TOKEN"))).decode(
            errors="replace"
        )
        if have != token:
            raise ValueError(f"the sources in the FMU must be of its token {token}, are of {have}")
        self.step, self.output = (
            ctypes.cast(getattr(self._library, name), ctypes.c_void_p).value or 0 for name in ("batch_step", "batch_output")
        )

    def computes(self, references: int, n: int) -> bool:
        """Whether one of `n` variables, whose value references are at an address, is more than a state or an input."""
        return bool(self._library.batch_computed(ctypes.c_void_p(references), ctypes.c_size_t(n)))

    def forget(self) -> None:
        """To be called when other instances come into the lanes."""
        self._library.batch_forget()


@cache
def lane_code(location: str, token: str, width: int) -> LaneCode:
    """The steps of `width` instances of the FMU at `location`, compiled if need be.

    Raises
    ------
    ValueError
        The FMU is not of ours, carries no sources, or its model does not run in lanes.
    RuntimeError, OSError
        There is no compiler, it refuses the code, or the library cannot be loaded.
    """
    return LaneCode(machine_code.loaded(partial(machine_code.of_lanes, _sources(location), width)), token)


def without_lanes(location: str) -> str:
    """Why an FMU has no code for lanes, in words; empty where it has."""
    try:
        sources = _sources(location)
    except ValueError as error:
        return str(error)
    return f"the model of FMU {location!r} is sampled or its steps are implicit" if NO_LANES in sources["model_data.h"] else ""


def _sources(location: str) -> dict[str, str]:
    """The C files that an FMU of ours carries, by name; those in folders below are none of ours."""
    with archive.opened(location) as members:
        names = [n.removeprefix("sources/") for n in members.namelist() if n.startswith("sources/") and n.endswith((".c", ".h"))]
        flat = [name for name in names if name == Path(name).name and "\\" not in name]
        if not {"lanes.c", "model_data.h"} <= set(flat):
            raise ValueError(f"FMU {location!r} carries no sources for lanes")
        try:
            return {name: members.read(f"sources/{name}").decode() for name in flat}
        except UnicodeDecodeError as error:
            raise ValueError(f"the sources in FMU {location!r} must be UTF-8: {error}") from None


@cache
def widest() -> int:
    """How many lanes this processor has: 8 with AVX-512, 4 with AVX2, 2 on others of 64 bits."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return 2
    flags = _flags()
    if {"avx512f", "avx512dq", "avx512vl"} <= flags:
        return 8
    return 4 if "avx2" in flags else 2


def _flags() -> set[str]:
    """What the processor can, as Linux calls it; empty where it is not told."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return set()
    return set(next((line for line in lines if line.startswith("flags")), "").partition(":")[2].split())
