"""The exporter: a component becomes FMUs of FMI 2.0 and 3.0 that need nothing but themselves.

    from gyro_cosim.fmus import export
    export(component, "built")                                       # built/gyro_unit.linear.fmu, for this machine
    export(component, "built", fmi=("2", "3"), platforms=("all",))   # five platforms

From component to file: table (variables and value references), code (C of the model; c/ holds the rest, its mathematics, too,
whose polynomials the module of that name computes), compiler (libraries), description and description3 (modelDescription.xml),
page, picture and reference (documentation), package (the zip file). The
systems of the package, as .ssd files, stand in systems/. Public: `export` and `compiler.CompilerError`.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gyro_cosim.component import Component

__all__ = ["export"]


def export(
    component: "Component",
    directory: str | Path,
    *,
    fmi: Sequence[str] = ("2",),
    platforms: Sequence[str] = ("host",),
    sources: bool = True,
) -> list[Path]:
    """Write a component as FMUs that need nothing but themselves.

    A file appears complete or not at all, and the same component gives the same bytes with the same compiler.

    Parameters
    ----------
    component : Component
        What the FMU computes.
    directory : str or Path
        The folder for the files; made where there is none.
    fmi : sequence of str
        "2", "3" or both. Files are called name.variant.fmu and name.variant.fmi3.fmu.
    platforms : sequence of str
        "host" (with the machine's own C compiler if it has one), "all", or names such as "x86_64-windows".
    sources : bool
        Whether to ship the C sources and buildDescription.xml, so that others can rebuild.

    Returns
    -------
    list of Path
        The files, in the order of `fmi`.

    Raises
    ------
    ValueError
        For an unknown version or platform, a folder that is a file, or a name that makes no C identifier.
    gyro_cosim.fmus.compiler.CompilerError
        A RuntimeError: there is no compiler, or it refuses the code.
    """
    from .package import write  # late: CasADi takes its time to load

    return write(component, Path(directory), fmi=fmi, platforms=platforms, sources=sources)
