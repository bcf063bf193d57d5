"""A system file as a tree of systems and components, before it is flattened."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from lxml import etree

from ..errors import WiringError
from ..systems import Port, archive
from ..systems.catalogue import spec_of_fmu
from .documents import NAMESPACES, Document, load, type_of

KINDS = ("input", "output", "parameter", "calculatedParameter")  # that a connection can join
OTHERS = ("inout", "unspecified", "structuralParameter", "constant", "local")
FMU, SSD, SSP = "application/x-fmu-sharedlibrary", "application/x-ssp-definition", "application/x-ssp-package"
DEEPEST = 50  # levels of nesting; a file that holds itself has no end


@dataclass
class Node:
    """An element of a system: a component (with `source`) or a system (with children and connections).

    path : names from the top, joined by "/"; empty for the top. bindings : (document, element) of each ParameterBinding.
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

    def port(self, name: str, element: etree._Element) -> Port:
        """The connector called `name`, which the connection `element` of the file names."""
        if name not in self.ports:
            raise WiringError(str(self.document.fault(element, f"{self.label} must have a connector {name!r}, has none")))
        found = self.ports[name]
        if found.kind not in KINDS:
            why = f"connector {name!r} of {self.label} must be one of {', '.join(KINDS)} to be connected, is {found.kind}"
            raise WiringError(str(self.document.fault(element, why)))
        return found

    @property
    def label(self) -> str:
        """For complaints."""
        return f"component {self.path!r}" if self.source else f"system {self.path!r}" if self.path else "the system"


def system_tree(location: str) -> Node:
    """The tree of the .ssd or .ssp file at `location`."""
    found = load(_structure(location), "ssd", "SystemStructureDescription")
    top = found.root.find("ssd:System", NAMESPACES)
    if top is None:
        raise ValueError(f"{found.what} must hold a System")
    return _system(found, top, "", "", 0)


def _structure(location: str) -> str:
    """The .ssd that a location stands for."""
    if not location.endswith(".ssp"):
        return location
    with archive.opened(location) as members:
        if "SystemStructure.ssd" not in members.namelist():
            raise ValueError(f"system file {location!r} must hold SystemStructure.ssd")
    return f"{location}#SystemStructure.ssd"


def _system(found: Document, element: etree._Element, name: str, path: str, depth: int) -> Node:
    if depth > DEEPEST:
        raise found.fault(element, f"systems must be nested at most {DEEPEST} deep (does one hold itself?)")
    node = Node(name, path, found, element, _ports(found, element))
    node.connections = element.findall("ssd:Connections/ssd:Connection", NAMESPACES)
    node.bindings = _bindings(found, element)
    for child in element.iterfind("ssd:Elements/*", NAMESPACES):
        kind, own = etree.QName(child).localname, found.attribute(child, "name")
        below = f"{path}/{own}" if path else own
        if own in node.children:
            raise WiringError(str(found.fault(child, "element names must differ, this one stands twice")))
        if kind == "System":
            node.children[own] = _system(found, child, own, below, depth + 1)
        elif kind == "Component":
            node.children[own] = _component(found, child, own, below, depth + 1)
        else:
            raise found.fault(child, "must be a Component or a System; signal dictionaries are not supported")
    return node


def _component(found: Document, element: etree._Element, name: str, path: str, depth: int) -> Node:
    source, kind = found.attribute(element, "source"), element.get("type", FMU)
    if element.get("implementation", "any") not in ("any", "CoSimulation"):
        raise found.fault(element, f"implementation must be CoSimulation or any, got {element.get('implementation')!r}")
    if source.startswith("#"):
        inner = next((e for e in found.root.iter(f"{{{NAMESPACES['ssd']}}}System") if e.get("id") == source[1:]), None)
        if inner is None:
            raise found.fault(element, f"source must be the id of a System of the file, got {source!r}")
        return _with_bindings(_system(found, inner, name, path, depth), found, element)
    if kind in (SSD, SSP):
        place, _, variant = source.partition("#")
        location = found.beside(element, place)
        if not archive.exists(location):
            raise found.fault(element, f"system file {location!r} must exist")
        inside = load(f"{location}#{variant}" if variant else _structure(location), "ssd", "SystemStructureDescription")
        top = inside.root.find("ssd:System", NAMESPACES)
        if top is None:
            raise ValueError(f"{inside.what} must hold a System")
        return _with_bindings(_system(inside, top, name, path, depth), found, element)
    if kind != FMU:
        raise found.fault(element, f"type must be {FMU}, {SSD} or {SSP}, got {kind!r}")
    return Node(
        name, path, found, element, _ports(found, element), _fmu(found, element, source), bindings=_bindings(found, element)
    )


def _with_bindings(node: Node, found: Document, element: etree._Element) -> Node:
    """What a component says of the system that it refers to comes after what that system says itself."""
    node.bindings += _bindings(found, element)
    return node


def _fmu(found: Document, element: etree._Element, source: str) -> str:
    """The FMU's location, or the catalogue name of an installed component that an .ssd file names like its FMU."""
    location = found.beside(element, source)
    if archive.exists(location):
        return location
    spec = None if "#" in found.location else spec_of_fmu(location.rpartition("/")[2])
    if spec is None:
        raise found.fault(element, f"FMU {location!r} must exist")
    return spec


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
        stated = type_of(connector)
        if stated is None:
            ports[name] = Port(kind)
        else:
            ports[name] = Port(kind, etree.QName(stated).localname, found.unit(stated))
    return ports


def components(node: Node) -> Mapping[str, Node]:
    """Every component below, by path."""
    if node.source:
        return {node.path: node}
    return {path: leaf for child in node.children.values() for path, leaf in components(child).items()}
