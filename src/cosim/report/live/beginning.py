"""What the page of a run begins with that is only about to be done."""

import platform
from collections.abc import Mapping, Sequence
from importlib import metadata
from typing import Any

from ...network import Network
from ...slaves import Signal
from .. import contents, scenes
from .steering import PACES

__all__ = ["first_page"]


def first_page(
    network: Network, names: Sequence[str], offered: Mapping[str, Mapping[str, Signal]], *,
    start: float, stop: float, command: str, prefer: Sequence[str], paced: bool,
) -> dict[str, Any]:  # fmt: skip
    """The page's document.

    Parameters
    ----------
    network : Network
        What is about to run.
    names : sequence of str
        The outputs that are shown, in the order of the rows.
    offered : mapping
        What may change on the way: component -> name -> signal.
    start, stop : float
        Of the run, s.
    command : str
        What begins it again.
    prefer : sequence of str
        Outputs that are drawn first.
    paced : bool
        Whether the run goes by the clock already.
    """
    units = dict(zip(network.names, network.units, strict=True))
    values = _values(network)
    scene = scenes.scene_of(network.system, names, values)
    return {
        "title": network.system.name,
        "description": network.system.description,
        "system": contents.graph(network.system),
        "run": {"start": start, "stop": stop},
        "command": command,
        "versions": {"gyro-cosim": metadata.version("gyro-cosim"), "Python": platform.python_version()},
        "hashes": contents.hashes(network.system),
        "prefer": [*(scene or {}).get("prefer", ()), *prefer],
        "signals": {"names": list(names), "units": [units[name] for name in names], "rows": 0},
        "live": {
            "paces": [] if paced else list(PACES),
            "parameters": [_parameter(c, s, values) for c, signals in offered.items() for s in signals.values()],
        },
        "module": None,
        "scene": scene,
    }


def _values(network: Network) -> dict[str, float]:
    """What single numbers are given to components, or what they have by themselves, as `component.variable`."""
    given = {
        f"{slave.name}.{name}": values.get(name, signal.start)
        for slave, values in zip(network.slaves, network.values, strict=True)
        for name, signal in slave.description.settable.items()
    }
    return {name: float(value) for name, value in given.items() if isinstance(value, bool | int | float)}


def _parameter(component: str, signal: Signal, values: Mapping[str, float]) -> dict[str, Any]:
    return {
        "component": component,
        "name": signal.name,
        "start": values.get(f"{component}.{signal.name}"),
        "min": signal.min,
        "max": signal.max,
        "unit": signal.unit,
        "type": signal.type,
        "items": [list(item) for item in signal.items],
        "description": signal.meaning,
    }
