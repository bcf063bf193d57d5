"""Where a packed system comes from: versions, hashes, how it was run and how right that is, as metadata of SSP Traceability.

The metadata is an SRMD file (Simulation Resource Meta Data 1.0) at the place where the standard looks for that of a whole .ssp.
"""

import hashlib
import json
import platform
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any

from lxml import etree

from ..systems import System

MEMBER = "extra/org.ssp-standard.ssp-traceability.srmd/resourceMetaData.srmd"
RESULTS = "extra/io.github.gyro-cosim/run.json"
SRMD = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"
STC = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"
OURS = "io.github.gyro-cosim"
_SETTINGS = ("algorithm", "degree", "step", "start", "stop", "steps", "status", "energy_residual", "coupling_warning")


def results(system: System, run: Mapping[str, Any]) -> bytes:
    """What `cosim run --json` has told, as a member of the package.

    Raises
    ------
    ValueError
        Where it is no such document, or one of another system.
    """
    if not {"system", "components", "algorithm", "step"} <= set(run):
        raise ValueError("a run must be what `cosim run --json` prints")
    components = {component.name: component.source for component in system.components}
    for what, own, told in (("system", system.name, run["system"]), ("components", components, run["components"])):
        if own != told:
            raise ValueError(f"the run must be of the system that is packed, whose {what} is {own}, got {told}")
    return (json.dumps(run, indent=1, ensure_ascii=False) + "\n").encode()


def provenance(system: System, members: Mapping[str, bytes], run: Mapping[str, Any] | None) -> etree._Element:
    """The metadata of a package.

    Parameters
    ----------
    system : System
        What is packed.
    members : mapping of str to bytes
        What the package holds besides, by path.
    run : mapping, optional
        What `cosim run --json` has told.
    """
    tool = f"gyro-cosim {metadata.version('gyro-cosim')}"
    attributes = {"version": "1.0.0", "name": system.name, "generationTool": tool}
    root = etree.Element(f"{{{SRMD}}}SimulationResourceMetaData", attributes, nsmap={"srmd": SRMD, "stc": STC})
    versions = {name: metadata.version(name) for name in ("gyro-cosim", "casadi", "numpy")}
    _classification(root, "versions", {**versions, "python": platform.python_version(), "platform": platform.machine()})
    _classification(root, "sha3-256", {name: hashlib.sha3_256(data).hexdigest() for name, data in members.items()})
    _classification(root, "components", {component.name: component.source for component in system.components})
    if run is not None:
        _classification(root, "run", {**{k: run[k] for k in _SETTINGS if k in run}, "results": f"../../{RESULTS}"})
        _classification(root, "robust", dict(_flat(run.get("robust") or {})))
        _classification(root, "certificate", dict(_flat(run.get("certificate") or {})))
    return root


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted names and values of a document."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list):
        for k, inner in enumerate(value, 1):
            yield from _flat(inner, f"{name}[{k}]")
    elif value is not None:
        yield name, value


def _classification(root: etree._Element, kind: str, entries: Mapping[str, Any]) -> None:
    if not entries:
        return
    parent = etree.SubElement(root, f"{{{STC}}}Classification", {"type": f"{OURS}.{kind}"})
    for keyword, value in entries.items():
        entry = etree.SubElement(parent, f"{{{STC}}}ClassificationEntry", {"keyword": keyword})
        entry.text = repr(value) if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)
