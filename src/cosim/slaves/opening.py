"""From the source of a component to a slave; what is not used is not loaded."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

from ..systems import catalogue
from .base import Slave

if TYPE_CHECKING:
    from collections.abc import Mapping

    from .fmi.fmu import FmuSlave
    from .fmi.unpacked import FmuCache
    from .signal import Given


def open_slave(
    name: str, source: str, *, in_process: bool = False, isolate: bool = False, cache: FmuCache | None = None,
    implementation: str = "", values: Mapping[str, Given] = MappingProxyType({}),
) -> Slave:  # fmt: skip
    """The slave `name` for a source: an FMU file, a unit elsewhere, or a catalogue name whose FMU is built when it is needed.

    With `in_process` a component of the catalogue runs in this process instead; an FMU file stays an FMU.
    With `isolate` an FMU runs in a process of its own, and cannot take this one down. So does one of which a process can hold
    one instance only, from the second on.
    cache : the FMUs that are open already, so that slaves of the same file share one copy.
    values : what it will be given at the start; structural parameters must be known here, for the sizes of arrays.
    implementation : "CoSimulation" or "ModelExchange", by which an FMU shall run; else Co-Simulation where it offers that.
    """
    remote = source.startswith(("process:", "tcp://"))
    if implementation == "ModelExchange" and (remote or (in_process and not source.endswith(".fmu"))):
        where = "elsewhere" if remote else "in this process"
        raise ValueError(f"component {name!r} must run as an FMU to be run by Model Exchange, {source!r} runs {where}")
    if remote:
        from .processes.remote import RemoteSlave

        return RemoteSlave(name, source)
    if in_process and not source.endswith(".fmu"):
        from .in_process import ComponentSlave

        return ComponentSlave(name, catalogue.component(source))
    from .fmi.unpacked import FmuCache

    cache = cache or FmuCache()
    location = cache.location(source)
    if isolate or cache.occupied(location, implementation):
        from .processes.isolated import IsolatedSlave

        sizes: Mapping[str, Given] = {}
        if values:
            from .fmi.description import load
            from .fmi.structure import structural

            sizes = structural(load(location), name, values)
        alone = "" if isolate else f"component {name!r} runs in a process of its own: a process can hold its FMU once only"
        return IsolatedSlave(name, location, implementation=implementation, sizes=sizes, note=alone)
    return open_fmu(name, location, cache, implementation, values)


def open_fmu(
    name: str, location: str, cache: FmuCache | None = None, implementation: str = "",
    values: Mapping[str, Given] = MappingProxyType({}),
) -> Slave:  # fmt: skip
    """The slave `name` for the FMU at `location`, `FILE` or `ARCHIVE#MEMBER`; ValueError if it cannot be used."""
    from .fmi.unpacked import FmuCache

    opened = (cache or FmuCache()).take(location, implementation)
    fmu: FmuSlave
    if opened.model.version == "3":
        from .fmi.fmi3 import Fmi3Slave

        fmu = Fmi3Slave(name, opened, values)
    elif opened.model.version == "2":
        from .fmi.fmi2 import Fmi2Slave

        fmu = Fmi2Slave(name, opened)
    else:
        from .fmi.fmi1 import Fmi1Slave

        fmu = Fmi1Slave(name, opened)
    if not opened.model.exchanged:
        return fmu
    from .exchange.slave import ExchangeSlave

    return ExchangeSlave(fmu)
