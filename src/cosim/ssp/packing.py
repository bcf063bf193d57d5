"""A system as an .ssp file that other tools run: SystemStructure.ssd, the FMUs, and the values as a parameter set.

SSP 1.0 knows no arrays and no FMI 3.0 types: elements of arrays become connectors of their own, types become the nearest of
SSP 1.0. In SSP 2.0 an array stays one connector, unless the system connects elements of it, and types are the FMUs' own.
Nested systems stay flat, as the master sees them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lxml import etree

from gyro_cosim.component.zip_files import write_zip

from ..errors import unknown
from ..network.joining import transfer
from ..network.wiring import connections
from ..slaves import Signal, SlaveDescription
from ..slaves.described import DescribedSlave
from ..slaves.fmi.description import read
from ..slaves.fmi.signals import described
from ..slaves.fmi.structure import configured
from ..systems import Connection, Conversion, System, archive, catalogue
from .rules import ANNOTATION, NAMESPACES
from .traceability import MEMBER, RESULTS, provenance, results
from .writing import VERSIONS, Writing, add, as_bytes, base, dimensions, parameter_set, tag, units_of, write_units


def pack(system: System, file: Path, *, version: str = "1.0", run: Mapping[str, Any] | None = None) -> Path:
    """Write a system with its FMUs and values, complete or not at all.

    Parameters
    ----------
    system : System
        Its components of the catalogue become FMUs of this platform.
    file : Path
        An .ssp file.
    version : str
        Of SSP, "1.0" or "2.0".
    run : mapping, optional
        What `cosim run --json` has told of a run of this system. It is packed as it is, and its settings and certificate stand
        in the metadata.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        Where the file has another ending, a value fits no parameter, or the run is of another system.
    """
    if file.suffix != ".ssp":
        raise ValueError(f"packed system must end in .ssp, got {str(file)!r}")
    if version not in VERSIONS:
        raise unknown("version of SSP", version, VERSIONS)
    system.refuse_driven("a packed system")
    told = b"" if run is None else results(system, run)  # before FMUs are built, which may take minutes
    fmus, places = _fmus(system)
    models = {c.name: configured(read(fmus[c.source], c.implementation), c.name, c.given) for c in system.components}
    descriptions = {name: described(model) for name, model in models.items()}
    units = units_of(s for d in descriptions.values() for s in (*d.inputs, *d.outputs, *d.settable.values()))
    writing = Writing(version, units, {name: {row.name: row.type for row in model.rows} for name, model in models.items()})
    values: dict[str, bytes] = {}  # place in the package -> parameter set
    sets: dict[str, str] = {}  # component -> place
    for component in system.components:
        found = parameter_set(system.name, component, descriptions[component.name], writing)
        if found is not None:
            sets[component.name] = _free(f"resources/{_plain(component.name)}", ".ssv", values)
            values[sets[component.name]] = as_bytes(found)
    members = {"SystemStructure.ssd": as_bytes(_structure(system, descriptions, places, writing, sets)), **values}
    members |= {places[source]: archive.read(location) for source, location in fmus.items()}
    if told:
        members[RESULTS] = told
    members[MEMBER] = as_bytes(provenance(system, members, run))
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


def _wires(system: System, descriptions: Mapping[str, SlaveDescription], writing: Writing) -> list[Connection]:
    """The connections as they are written: of whole arrays only in SSP 2.0, and where no element is connected alone."""
    slaves = [DescribedSlave(name, d) for name, d in descriptions.items()]
    ends = [end for wire in system.connections for end in (wire.start, wire.end)]
    apart = {(component, writing.variable(component, name)) for component, name in ends if name not in writing.types[component]}
    found = []
    for wire in system.connections:
        one = all(name in writing.types[component] for component, name in (wire.start, wire.end))
        whole = writing.version == "2.0" and one and not {wire.start, wire.end} & apart
        found += [wire] if whole else connections(replace(system, connections=(wire,), bonds=(), stop_when=()), slaves)
    return found


def _structure(
    system: System, descriptions: Mapping[str, SlaveDescription], places: Mapping[str, str], writing: Writing,
    sets: Mapping[str, str],
) -> etree._Element:  # fmt: skip
    used = {k: NAMESPACES[k] for k in ("ssd", "ssc", "gc")}
    root = etree.Element(tag("ssd", "SystemStructureDescription"), {"version": writing.version, "name": system.name}, nsmap=used)
    top = add(root, "ssd", "System", name=system.name, description=system.description)
    elements = add(top, "ssd", "Elements")
    wires = _wires(system, descriptions, writing)
    driven = {wire.end for wire in wires}
    for component in system.components:
        description = descriptions[component.name]
        element = add(
            elements, "ssd", "Component", name=component.name, type="application/x-fmu-sharedlibrary",
            source=places[component.source], implementation=component.implementation,
        )  # fmt: skip
        # Open inputs get no connector: one importer at least gives them a neighbour's value.
        inputs = {
            n: s
            for n, s in _connectors(component.name, (*description.inputs, *description.text_inputs), wires, writing)
            if (component.name, n) in driven
        }
        outputs = dict(_connectors(component.name, (*description.outputs, *description.text_outputs), wires, writing))
        clocks = [
            (name, kind)
            for kind, names in (("input", description.clock_inputs), ("output", description.clock_outputs))
            for name in names
            if any((component.name, name) in (wire.start, wire.end) for wire in wires)
        ]
        parent = add(element, "ssd", "Connectors") if inputs or outputs or clocks else element
        for kind, signals in (("input", inputs), ("output", outputs)):
            for name, several in signals.items():
                _connector(parent, component.name, name, kind, several, writing)
        for name, kind in clocks:
            connector = add(parent, "ssd", "Connector", name=name, kind=kind)
            if writing.version == "2.0":  # SSP 1.0 knows no clocks, and lets a connector say no type
                add(connector, "ssc", "Clock", intervalVariability="triggered")
        if component.name in sets:
            add(add(element, "ssd", "ParameterBindings"), "ssd", "ParameterBinding", source=sets[component.name])
    if wires:
        parent = add(top, "ssd", "Connections")
        for wire in wires:
            _connection(parent, wire, descriptions)
    notes = [("Master", {"step": repr(system.step)})]
    if system.exchange is not None:
        notes.append(("Exchange", {"component": system.exchange.component, "ending": system.exchange.ending}))
    notes += [("Bond", {"motion": ".".join(b.motion), "effort": ".".join(b.effort)}) for b in system.bonds]
    notes += [
        ("StopWhen", {"signal": ".".join(stop.signal), "above": repr(stop.above), "says": stop.says}) for stop in system.stop_when
    ]
    annotations = add(top, "ssd", "Annotations")
    for name, attributes in notes:
        add(add(annotations, "ssc", "Annotation", type=ANNOTATION), "gc", name, **attributes)
    if writing.enumerations:
        parent = add(root, "ssd", "Enumerations")
        for items, name in writing.enumerations.items():
            of = add(parent, "ssc", "Enumeration", name=name)
            for item, number in items:
                add(of, "ssc", "Item", name=item, value=str(number))
    write_units(root, "ssd", writing.units)
    add(root, "ssd", "DefaultExperiment", startTime=repr(system.start), stopTime=repr(system.stop))
    return root


def _connectors(
    component: str, signals: Iterable[Signal], wires: Iterable[Connection], writing: Writing
) -> Iterable[tuple[str, list[Signal]]]:
    """Name of each connector, and the signals that it stands for: several where an array is one connector."""
    single = {name for wire in wires for end, name in (wire.start, wire.end) if end == component}
    apart = {writing.variable(component, name) for name in single if name not in writing.types[component]}
    grouped: dict[str, list[Signal]] = {}
    for signal in signals:
        variable = writing.variable(component, signal.name)
        alone = writing.version == "1.0" or variable in apart
        grouped.setdefault(signal.name if alone else variable, []).append(signal)
    return grouped.items()


def _connector(
    parent: etree._Element, component: str, name: str, kind: str, signals: list[Signal], writing: Writing
) -> None:  # fmt: skip
    signal = signals[0]
    connector = add(parent, "ssd", "Connector", name=name, kind=kind)
    if signal.type == "enumeration":
        item = writing.enumerations.setdefault(signal.items, f"enumeration_{len(writing.enumerations) + 1}")
        add(connector, "ssc", "Enumeration", name=item)
    else:
        unit = signal.unit if signal.unit in writing.units else ""
        add(connector, "ssc", writing.type_of(component, signal), **({"unit": unit} if signal.type == "real" else {}))
    if name != signal.name:
        last = signals[-1].name  # elements are in order, so the last one's index is the shape
        dimensions(connector, map(int, last[last.rindex("[") + 1 : -1].split(",")))


def _connection(connections: etree._Element, wire: Connection, descriptions: Mapping[str, SlaveDescription]) -> None:
    element = add(
        connections, "ssd", "Connection",
        startElement=wire.start[0], startConnector=wire.start[1], endElement=wire.end[0], endConnector=wire.end[1],
    )  # fmt: skip
    plain = all(h == Conversion(h.start, h.end) for h in wire.conversions)
    if plain:
        return
    a = next(s for s in descriptions[wire.start[0]].outputs if wire.start[1] in (s.name, base(s.name)))
    b = next(s for s in descriptions[wire.end[0]].inputs if wire.end[1] in (s.name, base(s.name)))
    total = transfer(wire, a, b)
    if total.table is None:
        element.set("suppressUnitConversion", "true")
        add(element, "ssc", "LinearTransformation", factor=repr(total.factor), offset=repr(total.offset))
        return
    kind = "Boolean" if a.type == b.type == "boolean" else "Integer"
    mapping = add(element, "ssc", f"{kind}MappingTransformation")
    for source, target in total.table.items():
        if not float(target).is_integer():
            raise ValueError(f"connection to {'.'.join(wire.end)}: a mapping in SSP must be to whole numbers, got {target:g}")
        pair = [str(bool(n)).lower() if kind == "Boolean" else str(int(n)) for n in (source, target)]
        add(mapping, "ssc", "MapEntry", source=pair[0], target=pair[1])
