"""C code for this machine alone, without FMI: a component in this process, and steps of several instances of an FMU at once.

c/library.c and c/lanes.c say what the libraries offer. Their code is the FMU's, so the bits are.
"""

import platform
import tempfile
from collections.abc import Mapping
from pathlib import Path

from gyro_cosim.component import Component

from .compiler import compile_libraries, host, host_compiler

__all__ = ["LANES", "component_library", "lane_library"]

LANES = (2, 4, 8)


def component_library(component: Component) -> bytes:
    """Compile the functions of a component.

    Parameters
    ----------
    component : Component
        Whose functions they are.

    Returns
    -------
    bytes
        A shared library of c/library.c.

    Raises
    ------
    ValueError
        For an operation without C code.
    gyro_cosim.fmus.compiler.CompilerError
        A RuntimeError: there is no compiler, or it refuses the code.
    """
    from . import code  # late: CasADi takes its time to load
    from .table import Table

    files = {p.name: p.read_text(encoding="utf-8") for p in sorted((Path(__file__).parent / "c").iterdir())}
    files |= code.generate(Table(component), "model", derivatives=False)
    return _compiled(files, "library.c", [])


def lane_library(sources: Mapping[str, str], width: int) -> bytes:
    """Compile the steps of several instances of an FMU at once.

    Parameters
    ----------
    sources : mapping of str to str
        The files below sources/ of an FMU of this exporter, by name.
    width : int
        How many: 2, 4 (needs a processor with AVX2 where it is an x86-64) or 8 (AVX-512).

    Returns
    -------
    bytes
        A shared library of c/lanes.c.

    Raises
    ------
    ValueError
        For another width, or a model that does not run in lanes.
    gyro_cosim.fmus.compiler.CompilerError
        A RuntimeError: there is no compiler, or it refuses the code.
    """
    if width not in LANES:
        raise ValueError(f"lanes must be one of {', '.join(map(str, LANES))}, got {width!r}")
    if "#define NO_LANES" in sources["model_data.h"]:
        raise ValueError("a component with a sampled part or an implicit method does not run in lanes")
    return _compiled(sources, "lanes.c", [f"-DLANES={width}", *_vectors(width)])


def _vectors(width: int) -> list[str]:
    """Options of the compiler for vectors as wide as that."""
    if width == 2 or platform.machine().lower() not in ("x86_64", "amd64"):
        return []
    if host_compiler() is None:
        return ["-mcpu=x86_64_v4" if width == 8 else "-mcpu=x86_64_v3"]
    return ["-mavx2"] if width == 4 else ["-mavx512f", "-mavx512dq", "-mavx512vl", "-mprefer-vector-width=512"]


def _compiled(files: Mapping[str, str], source: str, options: list[str]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="library-") as scratch:
        for name, content in files.items():
            Path(scratch, name).write_text(content, encoding="utf-8", newline="\n")
        return compile_libraries(Path(scratch), {source: "-O2"}, "model", {host(): True}, options=options)[host()]
