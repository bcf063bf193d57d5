"""The coupled system of a run, compiled to WebAssembly, with the table of its variables."""

import hashlib
import json
import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path
from typing import Any

import fmpy

from ..coupling import Algorithm
from ..errors import WiringError
from ..export import pack_fmu
from ..export.components import packed
from ..export.package import KERNEL
from ..master import open_network
from ..slaves.scratch import ScratchFolder
from ..systems import System, catalogue
from . import signals

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
    given : mapping of str to float
        What a run gives it, since it starts with its components' own values.
    """

    wasm: bytes
    token: str
    variables: tuple[dict[str, Any], ...]
    given: Mapping[str, float] = field(default_factory=dict)

    def values(self) -> dict[str, float]:
        """What parameters and start values are, by name, in their variables' units."""
        return {v["name"]: v["start"] for v in self.variables if v["start"] is not None}

    def with_values(self, given: Mapping[str, float]) -> "Module":
        """The same that starts with these values, of those variables that it has."""
        known = {v["name"]: given[v["name"]] for v in self.variables if v["name"] in given}
        return replace(
            self, given=known, variables=tuple({**v, "start": known.get(v["name"], v["start"])} for v in self.variables)
        )

    def document(self) -> dict[str, Any]:
        """As the page reads it."""
        return {
            "wasm": signals.deflated(self.wasm),
            "token": self.token,
            "given": dict(self.given),
            "variables": list(self.variables),
        }

    def folded(self) -> dict[str, Any]:
        """As the page reads it where it is one of many: its variables are unfolded only if it is chosen."""
        variables = json.dumps(list(self.variables), ensure_ascii=False).encode()
        return self.document() | {"variables": signals.deflated(variables)}


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
    system = _bare(system)
    shelf = catalogue.cache_folder() / "web"
    kept = shelf / f"{_key(system, algorithm, step)}.fmu"
    if not kept.is_file():
        with ScratchFolder() as scratch:
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


def given(system: System) -> dict[str, float]:
    """The numbers that a system gives its components, as `component.variable`, in the variables' own units."""
    with open_network(system) as network:
        found = {f"{part.name}.{row.name}": value for part in packed(system, network) for row, value in part.given}
    return {name: float(value) for name, value in found.items() if isinstance(value, bool | int | float)}


def exchangeable(system: System) -> list[str]:
    """Other variants, of those that the catalogue has, for the component that people exchange in a system."""
    if system.exchange is None:
        return []
    present = {c.source for c in system.components if c.name in system.addressed(system.exchange.component)}
    package = {source.partition(":")[0] for source in present}
    if len(package) != 1:
        return []
    of_package = catalogue.components().get(package.pop(), {})
    ending = system.exchange.ending
    if ending:
        fitting = [name for name in of_package if name.endswith(ending)]
    else:  # without those that are a variant's form for another connector
        fitting = [name for name in of_package if not any(name.startswith(f"{other}_") for other in of_package)]
    return [name for name in fitting if not any(source.endswith(f":{name}") for source in present)]


def exchanged(system: System, algorithm: Algorithm, step: float, wanted: Sequence[str]) -> Iterator[tuple[str, Module | None]]:
    """The same system with each of the wanted variants in the place that people exchange, compiled; None where that cannot be."""
    for name in wanted:
        try:
            yield name, compiled(system.with_source(system.exchanged(), name), algorithm, step)
        except (ValueError, RuntimeError, WiringError):
            yield name, None


def _bare(system: System) -> System:
    """The same without values: the page gives them, so that one module serves all."""
    components = tuple(replace(c, values={}, bound={}) for c in system.components)
    return replace(system, components=components, description="", start=0.0, stop=1.0, notes=())


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
    with ScratchFolder() as scratch:
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
