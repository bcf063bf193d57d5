"""Texts of system files, put together from small parts, and an .ssp around them."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import small_fmus

from gyro_cosim import System

HEAD = (
    '<ssd:SystemStructureDescription version="1.0" name="test" '
    'xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping">'
)
UNITS = (
    '<ssd:Units><ssc:Unit name="ell"><ssc:BaseUnit m="1" factor="0.5"/></ssc:Unit>'
    '<ssc:Unit name="pound"><ssc:BaseUnit kg="1" factor="0.5"/></ssc:Unit></ssd:Units>'
)
TAIL = '<ssd:DefaultExperiment startTime="0" stopTime="0.1"/></ssd:SystemStructureDescription>'


def ssd(inside: str) -> str:
    """A whole .ssd around what a System holds."""
    return f'{HEAD}<ssd:System name="top">{inside}</ssd:System>{UNITS}{TAIL}'


def component(name: str, *connectors: str, source: str = "resources/mixed.fmu", more: str = "") -> str:
    """A Component; a connector is written "kind name" or "kind name Type unit"."""
    return (
        f'<ssd:Component name="{name}" source="{source}">'
        + (f"<ssd:Connectors>{''.join(map(connector, connectors))}</ssd:Connectors>" if connectors else "")
        + f"{more}</ssd:Component>"
    )


def connector(text: str) -> str:
    kind, name, *of = text.split()
    inside = f"<ssc:{of[0]}{f' unit={of[1]!r}' if len(of) > 1 else ''}/>" if of else ""
    return f'<ssd:Connector name="{name}" kind="{kind}">{inside}</ssd:Connector>'


def connection(start: str, end: str, inside: str = "", more: str = "") -> str:
    """From "element.connector" or "connector" of the system."""
    ends = ""
    for which, text in (("start", start), ("end", end)):
        element, dot, name = text.rpartition(".")
        ends += (f'{which}Element="{element}" ' if dot else "") + f'{which}Connector="{name}" '
    return f"<ssd:Connection {ends}{more}>{inside}</ssd:Connection>"


def bound(values: str, *, prefix: str = "", mapping: str = "", source: str = "") -> str:
    """ParameterBindings with one binding, inline or from a file."""
    held = f'<ssd:ParameterValues><ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>{values}</ssv:Parameters>'
    held = "" if source else f"{held}</ssv:ParameterSet></ssd:ParameterValues>"
    of = f'source="{source}"' if source else ""
    binding = f'<ssd:ParameterBinding prefix="{prefix}" {of}>{held}{mapping}</ssd:ParameterBinding>'
    return f"<ssd:ParameterBindings>{binding}</ssd:ParameterBindings>"


def value(name: str, number: object, kind: str = "Real", unit: str = "") -> str:
    of = f' unit="{unit}"' if unit else ""
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{number}"{of}/></ssv:Parameter>'


def elements(*parts: str) -> str:
    return f"<ssd:Elements>{''.join(parts)}</ssd:Elements>"


def connections(*wires: str) -> str:
    return f"<ssd:Connections>{''.join(wires)}</ssd:Connections>"


Ssp = Callable[..., System]


def write(folder: Path, inside: str, **members: str | bytes) -> Path:
    """x.ssp with the given System content, the FMUs mixed and arrays, and more members ("__" is "/", "_dot_" is ".")."""
    file = folder / "x.ssp"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("SystemStructure.ssd", inside if inside.startswith("<ssd:SystemStr") else ssd(inside))
        archive.write(small_fmus.mixed(folder), "resources/mixed.fmu")
        archive.write(small_fmus.arrays(folder), "resources/arrays.fmu")
        for name, content in members.items():
            archive.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return file
