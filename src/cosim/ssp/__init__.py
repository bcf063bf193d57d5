"""System files: .ssd and .ssp of SSP 1.0, and of 2.0 as far as both say the same things in the same way.

What SSP cannot say stands in annotations of type `gyro-cosim`: the usual macro step, which signals form power bonds, what ends
a run, and which component people exchange.
"""

from pathlib import Path

from ..errors import unknown
from ..systems import System
from ..systems.catalogue import described_by, systems
from .reading import read
from .rules import NAMESPACES
from .single import of_one_described, of_one_fmu
from .toml_files import read_system

__all__ = ["NAMESPACES", "read", "system"]


def system(name: str) -> System:
    """A built-in system, or one from a file.

    Parameters
    ----------
    name : str
        As `cosim list` shows it; the path of an .ssd or .ssp file ("plant.ssp#VariantB.ssd" for one of several); of a .toml
        file that describes a system (toml_files.py); or of an .fmu, or a .toml file that describes a component, which then is
        all of the system (single.py).

    Returns
    -------
    System
        A plan; nothing of it is loaded.

    Raises
    ------
    ValueError, WiringError
        Where there is none of that name, or the file is wrong.
    """
    if name in systems():
        return read(systems()[name])
    if name.endswith((".ssd", ".ssp")):
        return read(Path(name))
    if name.endswith(".toml"):
        package = described_by(name)
        return read_system(name) if package is None else of_one_described(name, package)
    if name.endswith(".fmu"):
        return of_one_fmu(name)
    raise unknown("system", name, systems())
