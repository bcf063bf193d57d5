"""A component as a shared library for this machine, without FMI: for one run in this process, or for several side by side.

    prepare(p, P), rhs(x, u, P, x'), output(x, u, P, y), sample(x, u, P, x), step(x, U, P, tau, h, x), advance(...)

c/library.c says what each does. The code is the FMU's, so the bits are.
"""

import platform
import tempfile
from pathlib import Path

from gyro_cosim.component import Component

from . import code
from .compiler import compile_libraries, host, host_compiler
from .table import Table

__all__ = ["LANES", "library"]

LANES = (1, 2, 4, 8)


def library(component: Component, lanes: int = 1) -> bytes:
    """Compile the library of a component.

    Parameters
    ----------
    component : Component
        Whose functions it has.
    lanes : int
        How many runs go side by side: 1, 2, 4 (a processor with AVX2) or 8 (with AVX-512).

    Returns
    -------
    bytes
        The library.

    Raises
    ------
    ValueError
        For another number of lanes, an operation without C code, or lanes of a component whose functions are no SX graphs.
    gyro_cosim.fmus.compiler.CompilerError
        A RuntimeError: there is no compiler, or it refuses the code.
    """
    if lanes not in LANES:
        raise ValueError(f"lanes must be one of {', '.join(map(str, LANES))}, got {lanes!r}")
    if lanes > 1 and not runs_in_lanes(component):
        raise ValueError(f"component {component.spec!r} must have SX functions and an explicit method to run in lanes")
    table = Table(component)
    files = {p.name: p.read_text(encoding="utf-8") for p in sorted((Path(__file__).parent / "c").iterdir())}
    files |= code.generate(table, "model", derivatives=False)
    with tempfile.TemporaryDirectory(prefix="library-") as scratch:
        for name, content in files.items():
            Path(scratch, name).write_text(content, encoding="utf-8", newline="\n")
        built = compile_libraries(Path(scratch), {"library.c": "-O2"}, "model", {host(): True}, options=_options(lanes))
    return built[host()]


def runs_in_lanes(component: Component) -> bool:
    """Whether all that a macro step calls is an SX graph, and no sampled part cuts the steps."""
    step = code.functions(Table(component), derivatives=False).values()
    return component.sample is None and all(function.is_a("SXFunction") for function in step)


def _options(lanes: int) -> list[str]:
    """Of the compiler, for vectors as wide as that."""
    if lanes == 1:
        return []
    options = [f"-DLANES={lanes}"]
    if lanes > 2 and platform.machine().lower() in ("x86_64", "amd64"):
        if host_compiler() is None:
            options += ["-mcpu=x86_64_v4" if lanes == 8 else "-mcpu=x86_64_v3"]
        else:
            options += ["-mavx2"] if lanes == 4 else ["-mavx512f", "-mavx512dq", "-mavx512vl", "-mprefer-vector-width=512"]
    return options
