"""The exporter: a component becomes FMUs of FMI 2.0 and 3.0 that need nothing but themselves.

from gyro_cosim.fmus import export
export(component, "built")                                       # built/gyro_unit.linear.fmu, for this machine
export(component, "built", fmi=("2", "3"), platforms=("all",))   # five platforms
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
    """Write the FMUs of `component` into `directory`, and return their paths in the order of `fmi`.

    fmi : "2", "3" or both; files are called name.variant.fmu and name.variant.fmi3.fmu.
    platforms : "host" (with the machine's own C compiler if it has one), "all", or names such as "x86_64-windows".
    sources : ship the C sources and buildDescription.xml, so that others can rebuild.

    A file appears complete or not at all, and the same component gives the same bytes. ValueError for wrong use,
    fmus.compiler.CompilerError (a RuntimeError) if there is no compiler or it fails.
    """
    from .package import write  # late: CasADi takes its time to load

    return write(component, Path(directory), fmi=fmi, platforms=platforms, sources=sources)
