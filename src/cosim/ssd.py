"""System structure descriptions (.ssd, SSP 1.0): read what a co-simulation of scalar FMUs needs.

An FMU named in the file is looked for beside it; one that is not there but is called like an installed component
("gyro_unit.linear.fmu") stands for that component and is built when it is needed. What SSP cannot say, the usual macro
step and which signals form power bonds, stands in annotations of type `gyro-cosim`.
"""

from pathlib import Path

from lxml import etree

from cosim.catalogue import spec_of_fmu, systems, unknown
from cosim.errors import WiringError
from cosim.system import Connection, Part, PowerBond, System

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "gc": "urn:gyro-cosim:1",
}
ANNOTATION = "gyro-cosim"


def system(name: str) -> System:
    """The system called `name`: built in, or a path of an .ssd file."""
    if name in systems():
        return read(systems()[name])
    if name.endswith(".ssd"):
        return read(Path(name))
    raise unknown("system", name, systems())


def read(file: Path) -> System:
    """Read an .ssd file. ValueError or WiringError names file, element and rule."""
    try:
        parser = etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True)
        root = etree.parse(str(file), parser).getroot()
    except OSError as error:
        raise ValueError(f"system file {str(file)!r} cannot be read: {error.strerror or error}") from None
    except etree.XMLSyntaxError as error:
        raise ValueError(f"system file {str(file)!r} must be well-formed XML: {error.msg}") from None
    if root.tag != f"{{{NAMESPACES['ssd']}}}SystemStructureDescription":
        raise ValueError(f"system file {str(file)!r} must hold an SSP 1.0 SystemStructureDescription, got {root.tag!r}")
    structure = root.find("ssd:System", NAMESPACES)
    if structure is None:
        raise ValueError(f"system file {str(file)!r} must hold a System")
    try:
        parts = tuple(_part(element, file.parent) for element in structure.iterfind("ssd:Elements/ssd:Component", NAMESPACES))
        connections = tuple(_connection(element) for element in structure.iterfind("ssd:Connections/ssd:Connection", NAMESPACES))
        bonds = tuple(_bond(element) for element in root.iterfind(f".//ssc:Annotation[@type='{ANNOTATION}']/gc:Bond", NAMESPACES))
    except KeyError as error:
        raise ValueError(f"system file {str(file)!r}: an element lacks the attribute {error.args[0]!r}") from None
    except WiringError as error:
        raise WiringError(f"system file {str(file)!r}: {error}") from None
    experiment = root.find("ssd:DefaultExperiment", NAMESPACES)
    master = root.find(f".//ssc:Annotation[@type='{ANNOTATION}']/gc:Master", NAMESPACES)
    return System(
        name=root.get("name", file.stem),
        parts=parts,
        connections=connections,
        bonds=bonds,
        step=float(master.get("step", "1e-3")) if master is not None else 1e-3,
        stop=float(experiment.get("stopTime", "1")) if experiment is not None else 1.0,
        description=structure.get("description", ""),
    )


def _part(element: etree._Element, folder: Path) -> Part:
    source = element.attrib["source"]
    path = folder / source
    spec = None if path.is_file() else spec_of_fmu(Path(source).name)
    return Part(element.attrib["name"], spec or str(path))


def _connection(element: etree._Element) -> Connection:
    a = element.attrib
    if "startElement" not in a or "endElement" not in a:
        raise WiringError("a connection must join two components; connectors of the system itself are not supported")
    return Connection((a["startElement"], a["startConnector"]), (a["endElement"], a["endConnector"]))


def _bond(element: etree._Element) -> PowerBond:
    motion, effort = ((*element.attrib[key].split(".", 1),) for key in ("motion", "effort"))
    return PowerBond((motion[0], motion[1]), (effort[0], effort[1]))
