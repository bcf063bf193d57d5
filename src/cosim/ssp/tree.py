"""A system file as a tree of systems and components, before it is flattened."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from urllib.parse import parse_qs, quote, urlsplit

from lxml import etree

from ..errors import WiringError, nearest, unknown
from ..systems import Port, archive
from ..systems.catalogue import spec_of_fmu
from .documents import Document, Note, document, load, type_of
from .rules import NAMESPACES

KINDS = ("input", "output", "parameter", "calculatedParameter")  # that a connection can join
OTHERS = ("inout", "unspecified", "structuralParameter", "constant", "local")
FMU, SSD, SSP = "application/x-fmu-sharedlibrary", "application/x-ssp-definition", "application/x-ssp-package"
DEEPEST = 50  # levels of nesting; a file that holds itself has no end


@dataclass
class Node:
    """An element of a system: a component (with `source`) or a system (with children and connections).

    path : names from the top, joined by "/"; empty for the top. bindings : (document, element) of each ParameterBinding.
    passes : it stands for a signal dictionary, which every reference to it shares: what goes in comes out.
    """

    name: str
    path: str
    document: Document
    element: etree._Element
    ports: dict[str, Port]
    source: str = ""
    children: dict[str, "Node"] = field(default_factory=dict)
    connections: list[etree._Element] = field(default_factory=list)
    bindings: list[tuple[Document, etree._Element]] = field(default_factory=list)
    passes: bool = False

    def port(self, name: str, element: etree._Element) -> Port:
        """The connector called `name`, which the connection `element` of the file names."""
        if name not in self.ports:
            why = f"{self.label} must have a connector {name!r}, has none{nearest(name, self.ports)}"
            raise WiringError(str(self.document.fault(element, why)))
        found = self.ports[name]
        if found.kind not in KINDS and not self.passes:
            why = f"connector {name!r} of {self.label} must be one of {', '.join(KINDS)} to be connected, is {found.kind}"
            raise WiringError(str(self.document.fault(element, why)))
        return found

    @property
    def label(self) -> str:
        """For complaints."""
        if self.passes:
            return f"signal dictionary {self.path!r}"
        return f"component {self.path!r}" if self.source else f"system {self.path!r}" if self.path else "the system"


Dictionaries = Mapping[str, tuple[str, Mapping[str, Port]]]  # name -> its path and entries, those of the systems around too


def system_tree(location: str) -> Node:
    """The tree of the .ssd or .ssp file at `location`."""
    return _system(*_top(location, []), "", "", 0, {})


def _top(location: str, notes: list[Note]) -> tuple[Document, etree._Element]:
    """The document of a .ssd or .ssp file, and its System."""
    found = load(_structure(location, notes), "ssd", "SystemStructureDescription", notes)
    top = found.root.find("ssd:System", NAMESPACES)
    assert top is not None  # by the rules
    return found, top


def _structure(location: str, notes: list[Note]) -> str:
    """The .ssd that a location stands for."""
    if not location.endswith(".ssp"):
        return location
    with archive.opened(location) as members:
        names = [name for name in members.namelist() if name.endswith(".ssd") and "/" not in name]
    if "SystemStructure.ssd" in names:
        return f"{location}#SystemStructure.ssd"
    if len(names) != 1:
        found = f"; it holds {', '.join(names)}, of which one is named as {location}#{names[0]}" if names else ""
        raise ValueError(f"system file {location!r} must hold SystemStructure.ssd{found}")
    notes.append((location, 0, f"{names[0]} is read in place of SystemStructure.ssd, which is not there"))
    return f"{location}#{names[0]}"


def _system(found: Document, element: etree._Element, name: str, path: str, depth: int, known: Dictionaries) -> Node:
    if depth > DEEPEST:
        raise found.fault(element, f"systems must be nested at most {DEEPEST} deep (does one hold itself?)")
    node = Node(name, path, found, element, _ports(found, element))
    node.connections = element.findall("ssd:Connections/ssd:Connection", NAMESPACES)
    node.bindings = _bindings(found, element)
    known = {**known, **_dictionaries(found, element, path)}
    for child in element.iterfind("ssd:Elements/*", NAMESPACES):
        kind, own = etree.QName(child).localname, found.attribute(child, "name")
        below = f"{path}/{own}" if path else own
        if own in node.children:
            raise WiringError(str(found.fault(child, "element names must differ, this one stands twice")))
        if kind == "System":
            node.children[own] = _system(found, child, own, below, depth + 1, known)
        elif kind == "Component":
            node.children[own] = _component(found, child, own, below, depth + 1, known)
        else:
            node.children[own] = _reference(found, child, own, known)
    return node


def _dictionaries(found: Document, element: etree._Element, path: str) -> dict[str, tuple[str, Mapping[str, Port]]]:
    """The signal dictionaries that a System holds."""
    made: dict[str, tuple[str, Mapping[str, Port]]] = {}
    for holder in element.iterfind("ssd:SignalDictionaries/ssd:SignalDictionary", NAMESPACES):
        source, name = holder.get("source"), found.attribute(holder, "name")
        inner = holder.find("ssb:SignalDictionary", NAMESPACES)
        if source:
            location = found.beside(holder, source)
            if not archive.exists(location):
                raise found.fault(holder, f"file {location!r} must exist")
            held = load(location, "ssb", "SignalDictionary", found.notes)
        elif inner is not None:
            held = document(found.location, inner, "ssb", "SignalDictionary", found.notes)
        else:
            raise found.fault(holder, "must have a source or hold a SignalDictionary")
        entries = held.root.iterfind("ssb:DictionaryEntry", NAMESPACES)
        made[name] = (f"{path}/{name}" if path else name, {held.attribute(e, "name"): _port(held, e, "inout") for e in entries})
    return made


def _reference(found: Document, element: etree._Element, name: str, known: Dictionaries) -> Node:
    """A reference to a signal dictionary, whose connectors are entries of it."""
    wanted = found.attribute(element, "dictionary")
    if wanted not in known:
        raise found.fault(element, str(unknown("signal dictionary", wanted, known)))
    path, entries = known[wanted]
    ports = {}
    for own, port in _ports(found, element).items():
        if own not in entries:
            raise found.fault(element, str(unknown(f"entry of signal dictionary {wanted!r}:", own, entries)))
        ports[own] = port if port.unit_name else replace(port, unit=entries[own].unit, unit_name=entries[own].unit_name)
    return Node(name, path, found, element, ports, passes=True)


def _component(found: Document, element: etree._Element, name: str, path: str, depth: int, known: Dictionaries) -> Node:
    source, kind = found.attribute(element, "source"), element.get("type", FMU)
    if source.startswith("#"):
        inner = next((e for e in found.root.iter(f"{{{NAMESPACES['ssd']}}}System") if e.get("id") == source[1:]), None)
        if inner is None:
            raise found.fault(element, f"source must be the id of a System of the file, got {source!r}")
        return _with_bindings(_system(found, inner, name, path, depth, known), found, element)
    if kind in (SSD, SSP):
        place, _, variant = source.partition("#")
        location = found.beside(element, place)
        if not archive.exists(location):
            raise found.fault(element, f"system file {location!r} must exist")
        inside = _top(f"{location}#{variant}" if variant else location, found.notes)
        return _with_bindings(_system(*inside, name, path, depth, {}), found, element)
    if kind != FMU:
        raise found.fault(element, f"type must be {FMU}, {SSD} or {SSP}, got {kind!r}")
    if element.get("implementation") == "ScheduledExecution":
        raise found.fault(element, "implementation must not be ScheduledExecution, for which there is no scheduler here")
    return Node(
        name, path, found, element, _ports(found, element), _fmu(found, element, source), bindings=_bindings(found, element)
    )


def _with_bindings(node: Node, found: Document, element: etree._Element) -> Node:
    """What a component says of the system that it refers to comes after what that system says itself."""
    node.bindings += _bindings(found, element)
    return node


def _fmu(found: Document, element: etree._Element, source: str) -> str:
    """The FMU's location, or the catalogue name of an installed component that an .ssd file names like its FMU.

    Never a Python file: what a system file names is data, and nobody expects it to run on being looked at.
    """
    location = found.beside(element, _local(found, element, source))
    if not location.endswith(".fmu"):
        raise found.fault(element, f"source must be an FMU, whose name ends in .fmu, got {source!r}")
    if archive.exists(location):
        return location
    spec = None if "#" in found.location else spec_of_fmu(location.rpartition("/")[2])
    if spec is None:
        raise found.fault(element, f"FMU {location!r} must exist")
    return spec


def _local(found: Document, element: etree._Element, source: str) -> str:
    """The file that a source of libcosim's proxy-fmu names on this machine; any other source as it is."""
    parts = urlsplit(source)
    if parts.scheme != "proxyfmu":
        return source
    files = parse_qs(parts.query).get("file", [])
    if parts.hostname not in ("localhost", "127.0.0.1") or len(files) != 1:
        raise found.fault(element, f"source must be a file of this machine, got {source!r}")
    found.note(element, "an FMU behind proxyfmu runs here (--isolate gives it a process of its own)")
    return quote(files[0])


def _bindings(found: Document, element: etree._Element) -> list[tuple[Document, etree._Element]]:
    return [(found, e) for e in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES)]


def _ports(found: Document, element: etree._Element) -> dict[str, Port]:
    ports: dict[str, Port] = {}
    for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
        name, kind = found.attribute(connector, "name"), found.attribute(connector, "kind")
        if kind not in KINDS + OTHERS:
            raise found.fault(connector, f"kind must be one of {', '.join(KINDS + OTHERS)}, got {kind!r}")
        if name in ports:
            raise WiringError(str(found.fault(connector, "connector names must differ, this one stands twice")))
        ports[name] = _port(found, connector, kind)
    return ports


def _port(found: Document, element: etree._Element, kind: str) -> Port:
    """What a Connector or DictionaryEntry states."""
    stated = type_of(element)
    clocks = tuple(found.attribute(clock, "name") for clock in element.iterfind("ssd:Clock", NAMESPACES))
    if stated is None:
        return Port(kind, clocks=clocks)
    unit, name = found.unit(stated), stated.get("unit", "")
    if name and unit is None:
        found.note(stated, f"unit {name!r} is not defined in the file, and is taken as not stated")
    return Port(kind, etree.QName(stated).localname, unit, name, clocks)


def components(node: Node) -> Mapping[str, Node]:
    """Every component below, by path."""
    if node.source:
        return {node.path: node}
    return {path: leaf for child in node.children.values() for path, leaf in components(child).items()}
