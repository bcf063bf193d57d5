"""From a tree of systems to one flat System: connections traced through system connectors, parameters brought to components."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from lxml import etree

from ..errors import WiringError, nearest, unknown
from ..systems import Connection, Conversion, Exchange, Port, PowerBond, StopWhen, System, SystemComponent
from .documents import Document, conversion_of, told
from .foreign import macro_step
from .parameters import bound_values
from .rules import ANNOTATION, NAMESPACES
from .tree import Node, components, system_tree

End = tuple[str, str]  # path of an element ("" for the top), connector


@dataclass(frozen=True)
class Wire:
    """One Connection element, turned so that `start` is where the value comes from."""

    start: End
    end: End
    conversion: Conversion


def read(file: Path | str) -> System:
    """Read a system file.

    Parameters
    ----------
    file : Path or str
        An .ssd or .ssp file, or `ARCHIVE#MEMBER`.

    Returns
    -------
    System
        Nested systems are flat in it; names of components hold the path, with "/" between.

    Raises
    ------
    ValueError, WiringError
        Names file, element and rule.
    """
    location = str(file)
    top = system_tree(location)
    leaves = components(top)
    arriving = _wires(top)
    connections = []
    for (path, name), wire in arriving.items():
        if path in leaves and leaves[path].ports[name].kind == "input":
            traced = _traced(wire, arriving, leaves, top.document.what)
            if traced is not None:
                connections.append(traced)
    bound = bound_values(top, arriving)
    members = tuple(
        SystemComponent(p, leaf.source, bound=bound.get(p, {}), ports=leaf.ports, implementation=_implementation(leaf))
        for p, leaf in leaves.items()
    )
    root, found = top.document.root, top.document
    start, stop = _span(found)
    step = macro_step(found)
    try:
        return System(
            name=root.get("name") or Path(location).stem, components=members, connections=tuple(connections),
            bonds=_bonds(top, leaves),
            step=step, start=start, stop=stop, stop_when=_stops(top, leaves), exchange=_exchange(top, leaves),
            description=top.element.get("description") or root.get("description", ""),
            notes=tuple(told(found.notes)),
        )  # fmt: skip
    except WiringError as error:
        raise WiringError(f"{found.what}: {error}") from None


def _implementation(leaf: Node) -> str:
    """The interface that a component says it shall be run by; empty where it leaves that open."""
    stated = leaf.element.get("implementation", "any")
    return "" if stated == "any" else str(stated)


def _wires(node: Node) -> dict[End, Wire]:
    """Every connection of the tree by the place where it ends."""
    found: dict[End, Wire] = {}
    for element in node.connections:
        wire = _wire(node, element)
        if wire is None:
            continue
        if wire.end in found:
            two = f"{_shown(found[wire.end].start)} and {_shown(wire.start)}"
            why = f"input {_shown(wire.end)} must have one source, has two: {two}"
            raise WiringError(str(node.document.fault(element, why)))
        found[wire.end] = wire
    for child in node.children.values():
        below = _wires(child)
        for end in found.keys() & below.keys():
            both = f"{_shown(found[end].start)} and {_shown(below[end].start)}"
            raise WiringError(f"{node.document.what}: {_shown(end)} must have one source, has two: {both}")
        found |= below
    return found


def _shown(end: End) -> str:
    return ".".join(word for word in end if word)


def _wire(node: Node, element: etree._Element) -> Wire | None:
    """A connection in the direction in which values go; None between a parameter and what the master does not compute."""
    found = node.document
    ends = []
    if element.get("startElement") == "" or element.get("endElement") == "":
        found.note(element, 'an element called "" is read as the system itself')
    for which in ("startIndices", "endIndices"):
        if element.get(which):
            why = f"{which} are not read, for the standard does not say where they count from; name the element, such as y[1]"
            raise found.fault(element, why)
    for which in ("start", "end"):
        name, connector = element.get(f"{which}Element") or None, found.attribute(element, f"{which}Connector")
        if name is not None and name not in node.children:
            raise WiringError(
                str(found.fault(element, f"{node.label} must have an element {name!r}, has none{nearest(name, node.children)}"))
            )
        owner = node if name is None else node.children[name]
        port = owner.port(connector, element)
        outward = port.kind in ("output", "calculatedParameter")
        gives = outward if owner is not node else not outward  # seen from inside, a system's input gives
        ends.append((owner, connector, port, gives))
    (a, a_name, a_port, a_gives), (b, b_name, b_port, b_gives) = ends
    if a.passes or b.passes:  # a dictionary gives to what takes, and of two the first gives
        a_gives = not b_gives if a.passes and not b.passes else a_gives or a.passes
        b_gives = not a_gives if b.passes else b_gives
    if a_gives == b_gives:
        both = "give a value" if a_gives else "take a value"
        text = f"must join one end that gives and one that takes, {_end(a, a_name)} and {_end(b, b_name)} both {both}"
        raise WiringError(str(found.fault(element, text)))
    if b_gives:
        (a, a_name, a_port), (b, b_name, b_port) = (b, b_name, b_port), (a, a_name, a_port)
    if a_port.kind == "calculatedParameter":
        raise WiringError(str(found.fault(element, f"{_end(a, a_name)} is a calculatedParameter, which is not passed on")))
    _refuse_unknown_units(found, element, a_port, b_port)
    return Wire((a.path, a_name), (b.path, b_name), conversion_of(found, element, a_port.unit, b_port.unit))


def _refuse_unknown_units(found: Document, element: etree._Element, a: Port, b: Port) -> None:
    """A unit that nobody defines may stand at a connector, but nothing can be converted from or to it."""
    names = [port.unit_name for port in (a, b)]
    if "" in names or names[0] == names[1] or None not in (a.unit, b.unit):
        return
    if element.get("suppressUnitConversion") not in ("true", "1"):
        nobody = names[0] if a.unit is None else names[1]
        why = f"unit {nobody!r} must be defined in the Units of the file to go from {names[0]!r} to {names[1]!r}"
        raise WiringError(str(found.fault(element, why)))


def _end(node: Node, connector: str) -> str:
    return f"{node.path}.{connector}" if node.path else connector


def _traced(wire: Wire, arriving: dict[End, Wire], leaves: Any, what: str) -> Connection | None:
    """The connection from the component that a value comes from; None where it begins at an open connector of a system."""
    conversions, end = [wire.conversion], wire.end
    while wire.start[0] not in leaves:
        if wire.start not in arriving:
            return None
        wire = arriving[wire.start]
        conversions.insert(0, wire.conversion)
        if len(conversions) > 1000:
            raise WiringError(f"{what}: a chain of connectors must begin at a component, that of {_shown(end)} runs in a circle")
    return Connection(wire.start, end, () if all(c == Conversion() for c in conversions) else tuple(conversions))


def _bonds(top: Node, leaves: Any) -> tuple[PowerBond, ...]:
    bonds = []
    for element in top.document.root.iterfind(f".//ssc:Annotation[@type='{ANNOTATION}']//gc:Bond", NAMESPACES):
        motion, effort = (_split(top, element, key, leaves) for key in ("motion", "effort"))
        bonds.append(PowerBond(motion, effort))
    return tuple(bonds)


def _stops(top: Node, leaves: Any) -> tuple[StopWhen, ...]:
    found = []
    for element in top.document.root.iterfind(f".//ssc:Annotation[@type='{ANNOTATION}']//gc:StopWhen", NAMESPACES):
        signal = _split(top, element, "signal", leaves)
        found.append(StopWhen(signal, top.document.number(element, "above", "0.5"), element.get("says", ".".join(signal))))
    return tuple(found)


def _exchange(top: Node, leaves: Any) -> Exchange | None:
    """What people exchange in the system, by the annotation; None where there is none."""
    elements = top.document.root.findall(f".//ssc:Annotation[@type='{ANNOTATION}']//gc:Exchange", NAMESPACES)
    for element in elements[1:]:
        raise top.document.fault(element, "a system must have one Exchange at most, this is the second")
    for element in elements:
        for key in element.attrib:
            if key not in ("component", "ending"):
                raise top.document.fault(element, str(unknown("attribute", key, ("component", "ending"))))
        name = top.document.attribute(element, "component")
        if not any(path == name or path.startswith(f"{name}_") for path in leaves):
            raise top.document.fault(element, f"component must be one of the system, got {name!r}")
        return Exchange(name, element.get("ending", ""))
    return None


def _split(top: Node, element: etree._Element, key: str, leaves: Any) -> End:
    text = top.document.attribute(element, key)
    path = max((p for p in leaves if text.startswith(f"{p}.")), key=len, default="")
    if not path:
        raise top.document.fault(element, f"{key} must be COMPONENT.VARIABLE of a component of the system, got {text!r}")
    return path, text[len(path) + 1 :]


def _span(found: Document) -> tuple[float, float]:
    """When a run begins and ends (s): as DefaultExperiment says, else from 0, over one second."""
    experiment = found.root.find("ssd:DefaultExperiment", NAMESPACES)
    if experiment is None:
        return 0.0, 1.0
    start = found.number(experiment, "startTime", "0")
    stop = found.number(experiment, "stopTime", repr(start + 1.0))
    if not (isfinite(start) and isfinite(stop) and start < stop):
        raise found.fault(experiment, f"stopTime must be after startTime, got {stop:g} and {start:g}")
    return start, stop
