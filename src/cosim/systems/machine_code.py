"""C code for this machine, made by the installed compiler and kept in the user's cache: kernels, components, lanes of FMUs."""

import ctypes
import hashlib
import os
import platform
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import util
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from .catalogue import cache_folder, entries, fingerprint

__all__ = ["compiled", "compiler_id", "foreign", "loaded", "of_component", "of_lanes"]


def of_component(made: Any) -> Path:
    """The functions of a component as a shared library for this machine, built if anything that decides on it has changed.

    Parameters
    ----------
    made : gyro_cosim.component.Component
        The component.

    Returns
    -------
    Path
        The file, in the user's cache.

    Raises
    ------
    RuntimeError
        There is no compiler, or it refuses the code.
    ValueError
        The component has no C code.
    """
    return _cached(fingerprint("library", made), "component", made)


def of_lanes(sources: Mapping[str, str], width: int) -> Path:
    """Steps of several instances of an FMU of the installed exporter at once, as a shared library for this machine.

    Parameters
    ----------
    sources : mapping of str to str
        The C files that the FMU carries, by name.
    width : int
        How many instances.

    Returns
    -------
    Path
        The file, in the user's cache.

    Raises
    ------
    RuntimeError
        There is no compiler, or it refuses the code.
    ValueError
        The model does not run in lanes.
    """
    text = repr((sorted(sources.items()), width, *_asked()))
    return _cached(hashlib.sha256(text.encode()).hexdigest()[:20], "lanes", sources, width)


def foreign(folder: Path, sources: Mapping[str, Sequence[str]], name: str, headers: Sequence[Path]) -> Path:
    """Somebody else's C code as a shared library for this machine, kept by the content of `folder` and how it is compiled.

    Parameters
    ----------
    folder : Path
        Holds the sources and what they include; intermediate files are written there.
    sources : mapping of str to sequence of str
        Options for the preprocessor by C file, which is relative to `folder` as are folders in the options.
    name : str
        Of the library, without ending.
    headers : sequence of Path
        Folders of headers that the sources may lack.

    Returns
    -------
    Path
        The file, in the user's cache.

    Raises
    ------
    RuntimeError
        There is no compiler, it refuses the code, or it takes too long.
    """
    how = (sorted((file, *options) for file, options in sources.items()), name, *_asked())
    digest = hashlib.sha256(repr(how).encode())
    for file in sorted(p for p in folder.rglob("*") if p.is_file()):
        digest.update(f"{file.relative_to(folder).as_posix()} {hashlib.sha256(file.read_bytes()).hexdigest()} ".encode())
    make = partial(_compiler("foreign").load(), folder, sources, name, headers)
    return _kept(f"fmu-{digest.hexdigest()[:20]}", make)


def _asked() -> tuple[str | None, ...]:
    """What decides on machine code besides what is compiled."""
    return platform.platform(), os.environ.get("CC"), compiler_id()


def loaded(made: Callable[[], Path]) -> ctypes.PyDLL:
    """Load the library that `made` gives; one that cannot be loaded, cut short say, is made anew.

    Raises
    ------
    OSError
        It still cannot be loaded.
    """
    file = made()
    try:
        return ctypes.PyDLL(str(file))
    except OSError:
        file.unlink(missing_ok=True)
        return ctypes.PyDLL(str(made()))


def _cached(name: str, kind: str, *arguments: Any) -> Path:
    """A library that the entry point `kind` makes of the arguments, or made before."""
    entry = next((e for e in entries("libraries") if e.name == kind), None)
    if entry is None:
        raise RuntimeError(f"no package that is installed offers libraries of the kind {kind!r}")
    return _kept(name, partial(entry.load(), *arguments))


def _kept(name: str, make: Callable[[], bytes]) -> Path:
    """The library `name` in the user's cache, made if it is not there."""
    file = cache_folder().parent / "library" / f"{name}.so"
    if not file.is_file():
        data = make()
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=file.parent) as scratch:
            (Path(scratch) / "ready").write_bytes(data)
            (Path(scratch) / "ready").replace(file)
    return file


def compiled(folder: Path, source: str, name: str) -> bytes:
    """A shared library for this machine of the C file `source` in `folder`, made by the installed compiler.

    Parameters
    ----------
    folder : Path
        Where the source is; intermediate files are written there.
    source, name : str
        Of the file, and of the library, without ending.

    Raises
    ------
    RuntimeError
        There is no compiler, or it refuses the code.
    """
    library: bytes = _compiler("c").load()(folder, source, name)
    return library


def _compiler(name: str) -> EntryPoint:
    entry = next((entry for entry in entries("compilers") if entry.name == name), None)
    if entry is None:
        raise RuntimeError("no package that is installed offers a C compiler")
    return entry


def compiler_id() -> str:
    """What decides on the code of compiled() besides the source: the compiler that is asked, and how it is asked."""
    entry = next((entry for entry in entries("compilers") if entry.name == "c"), None)
    if entry is None:
        return ""
    spec = util.find_spec(entry.module)
    how = Path(spec.origin).read_bytes() if spec is not None and spec.origin else b""
    return f"{entry.value} {hashlib.sha256(how).hexdigest()}"
