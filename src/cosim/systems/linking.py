"""FMUs linked into one library, by the installed exporter; cosim does not name it."""

from collections.abc import Mapping, Sequence
from importlib import metadata
from typing import Any

from . import catalogue

__all__ = ["linked", "platform_folders"]


def linked(name: str, master: Mapping[str, str], parts: Mapping[str, Mapping[str, str]], **options: Any) -> Any:
    """A library of a master with the FMUs that it calls, made by the installed exporter.

    Parameters
    ----------
    name : str
        Of the library.
    master : mapping of str to str
        C files by name.
    parts : mapping of str to mapping of str to str
        For each prefix of functions the sources of an FMU.
    **options
        The exporter's own.

    Returns
    -------
    gyro_cosim.fmus.linked.Linked
        Sources and libraries.

    Raises
    ------
    RuntimeError
        There is no exporter that can, no compiler, or it refuses the code.
    """
    return _linker("link")(name, master, parts, **options)


def platform_folders(platforms: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """What FMUs call platforms in their binaries.

    Parameters
    ----------
    platforms : sequence of str
        As the exporter takes them.

    Returns
    -------
    dict of str to tuple of str
        By FMI version.

    Raises
    ------
    RuntimeError
        There is no exporter that can link.
    """
    folders: dict[str, tuple[str, ...]] = _linker("folders")(platforms)
    return folders


def _linker(name: str) -> Any:
    for entry in metadata.entry_points(group=f"{catalogue.GROUP}.linkers"):
        if entry.name == name:
            return entry.load()
    raise RuntimeError("no package that is installed can link FMUs (install gyro-cosim anew)")
