"""Parameter bindings (.ssv, .ssm and inline) and the values they give the components of a system.

Within a system a binding names a connector of the system, or, with the names of elements and dots in front, a variable
further down. Later bindings win over earlier ones, those of a system over those of what it holds. Names that are not there
are ignored, as the standard wants it, and told in the notes.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from lxml import etree

from ..errors import nearest
from ..systems import archive
from .documents import Document, conversion_of, document, load, through, value_of
from .rules import NAMESPACES
from .tree import Node

LISTED = 6  # names that a note shows
SET, MAPPING = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"


def bound_values(top: Node, arriving: Mapping[Any, Any]) -> dict[str, dict[str, Any]]:
    """Component path -> variable -> value. `arriving` holds the connections by where they end (see structure)."""
    leaving: dict[tuple[str, str], list[Any]] = {}
    for wire in arriving.values():
        leaving.setdefault(wire.start, []).append(wire)
    found: dict[str, dict[str, Any]] = {}
    _collect(top, leaving, arriving, found)
    return found


def _collect(node: Node, leaving: Mapping[Any, Any], arriving: Mapping[Any, Any], found: dict[str, dict[str, Any]]) -> None:
    for child in node.children.values():
        _collect(child, leaving, arriving, found)
    for place, element in node.bindings:
        nowhere = []
        for name, value in _values(node, place, element):
            targets = list(_targets(node, name, value, leaving, arriving))
            for path, variable, given in targets:
                found.setdefault(path, {})[variable] = given
            if not targets and not _reaches(node, name):
                nowhere.append(name)
        if nowhere:
            first, dot, _ = nowhere[0].partition(".")
            hint = nearest(first + dot, [*node.ports, *(f"{name}." for name in node.children)])
            place.note(element, f"not used, for nothing in {node.label} is called so: {_listed(nowhere)}{hint}")


def _listed(names: Iterable[str]) -> str:
    """A few names, and how many more there are."""
    found = [repr(name) for name in names]
    return ", ".join(found[:LISTED]) + (f" and {len(found) - LISTED} more" if len(found) > LISTED else "")


def _reaches(node: Node, name: str) -> bool:
    """Whether `name` is that of a connector, at which it may end, in `node` or below."""
    if name in node.ports:
        return True
    below = (child for child in node.children.values() if name.startswith(f"{child.name}."))
    return any(_reaches(child, name[len(child.name) + 1 :]) for child in below)


def _targets(
    node: Node, name: str, value: Any, leaving: Mapping[Any, Any], arriving: Mapping[Any, Any]
) -> Iterator[tuple[str, str, Any]]:
    """The variables of components that `name` means in `node`, with the value each gets."""
    if node.source:
        yield node.path, name, value
        return
    if name in node.ports:
        yield from _spread(node, name, value, leaving, arriving)
        return
    for child in node.children.values():
        if name.startswith(f"{child.name}."):
            yield from _targets(child, name[len(child.name) + 1 :], value, leaving, arriving)


def _spread(
    node: Node, connector: str, value: Any, leaving: Mapping[Any, Any], arriving: Mapping[Any, Any]
) -> Iterator[tuple[str, str, Any]]:
    """From a connector of a system to the variables of components behind it: along the connections, for an output back."""
    top = node
    pending = [((node.path, connector), value)]
    inside, seen = _leaves(top), set()
    while pending:
        end, given = pending.pop()
        if end in seen:
            continue  # system connectors in a circle, or one reached twice
        seen.add(end)
        if node.ports[connector].kind in ("output", "calculatedParameter"):
            wire = arriving.get(end)
            nexts = [] if wire is None else [(wire.start, given)]
        else:
            try:
                nexts = [(wire.end, through(given, wire.conversion)) for wire in leaving.get(end, ())]
            except ValueError as error:
                raise node.document.fault(node.element, f"value of {connector}: {error}") from None
        for (path, name), passed in nexts:
            if path in inside:
                yield path, name, passed
            else:
                pending.append(((path, name), passed))


def _leaves(node: Node) -> set[str]:
    if node.source:
        return {node.path}
    return set().union(*(_leaves(child) for child in node.children.values()))


def _values(node: Node, place: Document, element: etree._Element) -> Iterator[tuple[str, Any]]:
    """Name -> value of a ParameterBinding, with its prefix and mapping applied."""
    if element.get("type", SET) != SET:
        raise place.fault(element, f"type must be {SET}, got {element.get('type')!r}")
    found = _content(node, place, element, element, "ssd:ParameterValues", "ssv", "ParameterSet")
    prefix = element.get("prefix", "")
    values = {}
    for parameter in found.root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        values[prefix + found.attribute(parameter, "name")] = value_of(found, parameter)
    mapping = element.find("ssd:ParameterMapping", NAMESPACES)
    if mapping is None:
        yield from values.items()
        return
    if mapping.get("type", MAPPING) != MAPPING:
        raise place.fault(mapping, f"type must be {MAPPING}, got {mapping.get('type')!r}")
    table = _content(node, place, mapping, mapping, ".", "ssm", "ParameterMapping")
    entries = [e for e in table.root.iterfind("ssm:MappingEntry", NAMESPACES) if e.get("source")]
    for entry in entries:
        source, target = table.attribute(entry, "source"), table.attribute(entry, "target")
        if source in values:
            try:
                yield target, through(values[source], conversion_of(table, entry))
            except ValueError as error:
                raise table.fault(entry, str(error)) from None
    wanted = {str(entry.get("source")) for entry in entries}
    without, unused = sorted(wanted - values.keys()), sorted(values.keys() - wanted)
    if without:
        table.note(
            table.root, f"not in the parameter set, and so without effect: {_listed(without)}{nearest(without[0], values)}"
        )
    if unused:
        place.note(mapping, f"not used, for the mapping has no entry: {_listed(unused)}{nearest(unused[0], wanted)}")


def _content(
    node: Node, place: Document, element: etree._Element, parent: etree._Element, within: str, kind: str, name: str
) -> Document:
    """The document that an element refers to by `source`, or holds itself."""
    source = element.get("source")
    if source:
        if element.get("sourceBase", "SSD") == "component":
            if not node.source.endswith(".fmu"):
                raise place.fault(element, "sourceBase 'component' must stand at a component with an FMU")
            location = f"{node.source}#{source}"
        else:
            location = place.beside(element, source)
        if not archive.exists(location):
            raise place.fault(element, f"file {location!r} must exist")
        return load(location, kind, name, place.notes)
    holder = parent if within == "." else parent.find(within, NAMESPACES)
    inner = None if holder is None else holder.find(f"{kind}:{name}", NAMESPACES)
    if inner is None:
        raise place.fault(element, f"must have a source or hold a {name}")
    found = document(place.location, inner, kind, name, place.notes)
    return Document(found.location, found.root, {**place.units, **found.units}, place.notes)
