"""The coupled system of a run, compiled to WebAssembly, with the table of its variables."""

import base64
import hashlib
import json
import os
import tempfile
import zipfile
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import fmpy

from ..coupling import Algorithm
from ..export import pack_fmu
from ..export.package import KERNEL
from ..systems import System, catalogue

_KINDS = {"Real": "real", "Integer": "integer", "Enumeration": "integer", "Boolean": "boolean"}


@dataclass(frozen=True)
class Module:
    """A system that a page can run.

    Attributes
    ----------
    wasm : bytes
        The module.
    token : str
        What its instances are made with.
    variables : tuple of dict
        Name, reference, type, causality, start, unit, min, max, description.
    """

    wasm: bytes
    token: str
    variables: tuple[dict[str, Any], ...]

    def values(self) -> dict[str, float]:
        """What parameters and start values are, by name, in their variables' units."""
        return {v["name"]: v["start"] for v in self.variables if v["start"] is not None}

    def document(self) -> dict[str, Any]:
        """As the page reads it."""
        return {"wasm": base64.b64encode(self.wasm).decode(), "token": self.token, "variables": list(self.variables)}


def compiled(system: System, algorithm: Algorithm, step: float) -> Module:
    """Compile a system for the page, or take it from the cache, where one of the same content lies.

    Parameters
    ----------
    system : System
        Of components of the catalogue alone; FMUs from files cannot run in a page.
    algorithm : Algorithm
        What couples it.
    step : float
        Macro step, s.

    Raises
    ------
    ValueError
        The system cannot be one FMU: the reason in one line.
    RuntimeError
        There is no compiler, or it refuses the code.
    """
    for component in system.components:
        if component.source.endswith(".fmu"):
            raise ValueError(f"component {component.name!r} is an FMU from a file, which holds no code for WebAssembly")
        if component.source.startswith(("process:", "tcp://")):
            raise ValueError(f"component {component.name!r} runs elsewhere, in {component.source}")
    shelf = catalogue.cache_folder() / "web"
    kept = shelf / f"{_key(system, algorithm, step)}.fmu"
    if not kept.is_file():
        with tempfile.TemporaryDirectory(prefix="cosim-web-") as scratch:
            (made,) = pack_fmu(system, scratch, algorithm=algorithm, step=step, platforms=("wasm32",), sources=False)
            content = made.read_bytes()
        try:
            shelf.mkdir(parents=True, exist_ok=True)
            beside = kept.with_suffix(f".{os.getpid()}")
            beside.write_bytes(content)
            beside.replace(kept)
        except OSError:  # a cache that cannot be written costs time, no more
            return _read(content)
        return _read(content)
    return _read(kept.read_bytes())


def _key(system: System, algorithm: Algorithm, step: float) -> str:
    """What decides the module: the plan of the run and the code that makes it."""
    files = [KERNEL, *sorted((Path(__file__).parent.parent / "export" / "c").iterdir())]
    state = hashlib.sha256(repr((system, algorithm, step, metadata.version("gyro-cosim"))).encode())
    for file in files:
        state.update(file.read_bytes())
    for component in system.components:
        state.update(str(catalogue.fmu(component.source)).encode())
    return state.hexdigest()[:32]


def _read(content: bytes) -> Module:
    with tempfile.TemporaryDirectory(prefix="cosim-web-") as scratch:
        file = Path(scratch, "system.fmu")
        file.write_bytes(content)
        described = fmpy.read_model_description(str(file), validate=False)
        with zipfile.ZipFile(file) as archive:
            (member,) = (name for name in archive.namelist() if name.endswith(".wasm"))
            wasm = archive.read(member)
    variables = tuple(
        {
            "name": v.name,
            "reference": v.valueReference,
            "type": _KINDS[v.type],
            "causality": v.causality,
            "variability": v.variability,
            "start": None if v.start is None else json.loads(str(v.start).lower()) if v.type == "Boolean" else float(v.start),
            "unit": v.unit or (v.declaredType.unit if v.declaredType is not None else None) or "",
            "min": None if v.min is None else float(v.min),
            "max": None if v.max is None else float(v.max),
            "items": [[item.name, int(item.value)] for item in (v.declaredType.items or ())] if v.type == "Enumeration" else [],
            "description": v.description or "",
        }
        for v in described.modelVariables
        if v.type in _KINDS
    )
    return Module(wasm, described.guid, variables)
