"""A system as an .ssp file that other tools run: SystemStructure.ssd, the FMUs, and the values as a parameter set.

SSP 1.0 knows no arrays and no FMI 3.0 types: elements of arrays become connectors of their own, types become the nearest of
SSP 1.0. Nested systems stay flat, as the master sees them.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lxml import etree

from gyro_cosim.component.units import BASE, Unit
from gyro_cosim.component.zip_files import write_zip

from ..errors import unknown
from ..network.joining import transfer
from ..slaves import Signal, SlaveDescription, Value
from ..slaves.fmi.description import read
from ..slaves.fmi.signals import described
from ..slaves.fmi.structure import configured
from ..systems import Connection, System, SystemComponent, archive, catalogue
from ..systems.quantities import meaning
from .rules import ANNOTATION, NAMESPACES

_TYPES = {
    "real": "Real", "integer": "Integer", "boolean": "Boolean", "enumeration": "Enumeration", "string": "String",
    "binary": "Binary",
}  # fmt: skip


def pack(system: System, file: Path) -> Path:
    """Write a system with its FMUs and values, complete or not at all.

    Parameters
    ----------
    system : System
        Its components of the catalogue become FMUs of this platform.
    file : Path
        An .ssp file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        Where the file has another ending, or a value fits no parameter.
    """
    if file.suffix != ".ssp":
        raise ValueError(f"packed system must end in .ssp, got {str(file)!r}")
    system.refuse_driven("a packed system")
    fmus, places = _fmus(system)
    descriptions = {c.name: described(configured(read(fmus[c.source]), c.name, c.given)) for c in system.components}
    units = _units(
        s
        for description in descriptions.values()
        for s in (*description.inputs, *description.outputs, *description.settable.values())
    )
    enumerations: dict[tuple[tuple[str, int], ...], str] = {}
    values: dict[str, bytes] = {}  # place in the package -> parameter set
    sets: dict[str, str] = {}  # component -> place
    for component in system.components:
        found = _parameter_set(system.name, component, descriptions[component.name], units)
        if found is not None:
            sets[component.name] = _free(f"resources/{_plain(component.name)}", ".ssv", values)
            values[sets[component.name]] = _bytes(found)
    members = {"SystemStructure.ssd": _bytes(_structure(system, descriptions, places, units, enumerations, sets)), **values}
    members |= {places[source]: archive.read(location) for source, location in fmus.items()}
    write_zip(file, members, stored=[".fmu"])
    return file


def _fmus(system: System) -> tuple[dict[str, str], dict[str, str]]:
    """For each source the location of its FMU, and its place in the package; names that meet get a number."""
    fmus: dict[str, str] = {}
    places: dict[str, str] = {}
    for component in system.components:
        if component.source in fmus:
            continue
        location = component.source if component.source.endswith(".fmu") else str(catalogue.fmu(component.source))
        stem = location.replace("#", "/").rpartition("/")[2].removesuffix(".fmu")
        fmus[component.source], places[component.source] = location, _free(f"resources/{stem}", ".fmu", places.values())
    return fmus, places


def _free(stem: str, suffix: str, taken: Iterable[str]) -> str:
    """A place in the package that is not taken."""
    used, place, n = set(taken), f"{stem}{suffix}", 1
    while place in used:
        n += 1
        place = f"{stem}-{n}{suffix}"
    return place


def _plain(name: str) -> str:
    """A name that every file system takes."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in name) or "system"


def _units(signals: Iterable[Signal]) -> dict[str, Unit]:
    """What every unit in use means. One name that two FMUs define differently stays with the first."""
    found: dict[str, Unit] = {}
    for signal in signals:
        unit = meaning(signal.unit, signal.definition)
        if signal.unit and unit is not None:
            found.setdefault(signal.unit, unit)
    return found


def _tag(kind: str, name: str) -> str:
    return f"{{{NAMESPACES[kind]}}}{name}"


def _add(parent: etree._Element, kind: str, tag: str, /, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, _tag(kind, tag), {key: value for key, value in attributes.items() if value != ""})


def _structure(
    system: System, descriptions: Mapping[str, SlaveDescription], places: Mapping[str, str], units: Mapping[str, Unit],
    enumerations: dict[tuple[tuple[str, int], ...], str], sets: Mapping[str, str],
) -> etree._Element:  # fmt: skip
    used = {k: NAMESPACES[k] for k in ("ssd", "ssc", "gc")}
    root = etree.Element(_tag("ssd", "SystemStructureDescription"), {"version": "1.0", "name": system.name}, nsmap=used)
    top = _add(root, "ssd", "System", name=system.name, description=system.description)
    elements = _add(top, "ssd", "Elements")
    driven = {wire.end for wire in system.connections}
    for component in system.components:
        description = descriptions[component.name]
        # Open inputs get no connector: one importer at least gives them a neighbour's value.
        signals = [(s, "input") for s in description.inputs if (component.name, s.name) in driven] + [
            (s, "output") for s in description.outputs
        ]
        element = _component(elements, component, signals, places[component.source], units, enumerations)
        if component.name in sets:
            _add(_add(element, "ssd", "ParameterBindings"), "ssd", "ParameterBinding", source=sets[component.name])
    if system.connections:
        connections = _add(top, "ssd", "Connections")
        for wire in system.connections:
            _connection(connections, wire, descriptions)
    notes = [("Master", {"step": repr(system.step)})]
    if system.exchange is not None:
        notes.append(("Exchange", {"component": system.exchange.component, "ending": system.exchange.ending}))
    notes += [("Bond", {"motion": ".".join(b.motion), "effort": ".".join(b.effort)}) for b in system.bonds]
    notes += [
        ("StopWhen", {"signal": ".".join(stop.signal), "above": repr(stop.above), "says": stop.says}) for stop in system.stop_when
    ]
    annotations = _add(top, "ssd", "Annotations")
    for name, attributes in notes:
        _add(_add(annotations, "ssc", "Annotation", type=ANNOTATION), "gc", name, **attributes)
    if enumerations:
        parent = _add(root, "ssd", "Enumerations")
        for items, name in enumerations.items():
            of = _add(parent, "ssc", "Enumeration", name=name)
            for item, number in items:
                _add(of, "ssc", "Item", name=item, value=str(number))
    _write_units(root, "ssd", units)
    _add(root, "ssd", "DefaultExperiment", startTime=repr(system.start), stopTime=repr(system.stop))
    return root


def _write_units(root: etree._Element, kind: str, units: Mapping[str, Unit]) -> None:
    if not units:
        return
    parent = _add(root, kind, "Units")
    for name, unit in sorted(units.items()):
        exponents = {base: str(e) for base, e in zip(BASE, unit.dimension, strict=True) if e}
        scale = {} if unit.factor == 1.0 else {"factor": repr(unit.factor)}
        shift = {} if unit.offset == 0.0 else {"offset": repr(unit.offset)}
        _add(_add(parent, "ssc", "Unit", name=name), "ssc", "BaseUnit", **exponents, **scale, **shift)


def _component(
    elements: etree._Element, component: SystemComponent, signals: Sequence[tuple[Signal, str]], place: str,
    units: Mapping[str, Unit], enumerations: dict[tuple[tuple[str, int], ...], str],
) -> etree._Element:  # fmt: skip
    element = _add(elements, "ssd", "Component", name=component.name, type="application/x-fmu-sharedlibrary", source=place)
    connectors = _add(element, "ssd", "Connectors") if signals else element
    for signal, kind in signals:
        connector = _add(connectors, "ssd", "Connector", name=signal.name, kind=kind)
        if signal.type == "enumeration":
            name = enumerations.setdefault(signal.items, f"enumeration_{len(enumerations) + 1}")
            _add(connector, "ssc", "Enumeration", name=name)
        else:
            unit = signal.unit if signal.unit in units else ""
            _add(connector, "ssc", _TYPES[signal.type], **({"unit": unit} if signal.type == "real" else {}))
    return element


def _connection(connections: etree._Element, wire: Connection, descriptions: Mapping[str, SlaveDescription]) -> None:
    element = _add(
        connections, "ssd", "Connection",
        startElement=wire.start[0], startConnector=wire.start[1], endElement=wire.end[0], endConnector=wire.end[1],
    )  # fmt: skip
    plain = all((h.factor, h.offset, h.suppress, h.table, h.explicit) == (1.0, 0.0, False, (), False) for h in wire.conversions)
    if plain:
        return
    a = next(s for s in descriptions[wire.start[0]].outputs if s.name == wire.start[1])
    b = next(s for s in descriptions[wire.end[0]].inputs if s.name == wire.end[1])
    total = transfer(wire, a, b)
    if total.table is None:
        element.set("suppressUnitConversion", "true")
        _add(element, "ssc", "LinearTransformation", factor=repr(total.factor), offset=repr(total.offset))
        return
    kind = "Boolean" if a.type == b.type == "boolean" else "Integer"
    mapping = _add(element, "ssc", f"{kind}MappingTransformation")
    for source, target in total.table.items():
        if not float(target).is_integer():
            raise ValueError(f"connection to {'.'.join(wire.end)}: a mapping in SSP must be to whole numbers, got {target:g}")
        pair = [str(bool(n)).lower() if kind == "Boolean" else str(int(n)) for n in (source, target)]
        _add(mapping, "ssc", "MapEntry", source=pair[0], target=pair[1])


def _parameter_set(
    name: str, component: SystemComponent, description: SlaveDescription, units: Mapping[str, Unit]
) -> etree._Element | None:
    """The values of a component as an .ssv; None where there are none. All sets have one name, which some importers ask for."""
    used = {k: NAMESPACES[k] for k in ("ssv", "ssc")}
    root = etree.Element(_tag("ssv", "ParameterSet"), {"version": "1.0", "name": name}, nsmap=used)
    parent = _add(root, "ssv", "Parameters")
    for variable in component.values:
        if variable not in description.settable:
            raise unknown(f"parameter of {component.name!r}:", variable, description.settable)
    mentioned = set()
    for variable, given in {**component.bound, **component.values}.items():
        if variable not in description.settable:
            continue
        signal = description.settable[variable]
        try:
            value = signal.value(given)
        except ValueError as error:
            raise ValueError(f"{component.name}.{variable}: {error}") from None
        unit = signal.unit if signal.unit in units and signal.type == "real" else ""
        mentioned.add(unit)
        elements = value if isinstance(value, tuple) else (value,)
        names = [s for s in description.settable if s.startswith(f"{variable}[")] if signal.shape else [variable]
        for element, label in zip(elements, names, strict=True):
            _parameter(parent, label, signal, element, unit)
    _write_units(root, "ssv", {name: units[name] for name in mentioned if name})
    return root if len(parent) else None


def _parameter(parent: etree._Element, name: str, signal: Signal, value: Value, unit: str) -> None:
    text: Any = value
    if isinstance(value, float):
        text = {
            "real": repr(value), "integer": str(int(value)), "boolean": str(bool(value)).lower(),
            "enumeration": next((item for item, number in signal.items if number == value), str(int(value))),
        }[signal.type]  # fmt: skip
    elif isinstance(value, bytes):
        text = value.hex()
    element = etree.SubElement(_add(parent, "ssv", "Parameter", name=name), _tag("ssv", _TYPES[signal.type]), value=str(text))
    if unit:
        element.set("unit", unit)


def _bytes(root: etree._Element) -> bytes:
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
