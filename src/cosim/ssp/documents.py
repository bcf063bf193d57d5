"""What the XML files of SSP have in common: namespaces, attributes, units, values, transformations, places of other files."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from gyro_cosim.component.units import Unit

from ..systems import Conversion, archive
from ..systems.quantities import Quantity, defined, meaning

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
    "gc": "urn:gyro-cosim:1",
}
ANNOTATION = "gyro-cosim"
REAL = ("Real", "Float64", "Float32")
TYPES = (
    *REAL, "Integer", *(f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")),
    "Boolean", "String", "Enumeration", "Binary", "Clock",
)  # fmt: skip


@dataclass(frozen=True)
class Document:
    """An XML file of SSP: `location` (`FILE` or `ARCHIVE#MEMBER`), its root element, and the units it defines."""

    location: str
    root: etree._Element
    units: Mapping[str, Unit]

    @property
    def what(self) -> str:
        """How complaints about it begin."""
        return f"system file {self.location!r}"

    def fault(self, element: etree._Element, why: str) -> ValueError:
        """The error that names file, element and rule."""
        name = element.get("name") or element.get("source") or ""
        label = f"{etree.QName(element).localname}{f' {name!r}' if name else ''}"
        return ValueError(f"{self.what}, line {element.sourceline}: {label}: {why}")

    def attribute(self, element: etree._Element, name: str) -> str:
        """An attribute that must be there."""
        if name not in element.attrib:
            raise self.fault(element, f"must have the attribute {name!r}")
        return str(element.attrib[name])

    def number(self, element: etree._Element, name: str, default: str = "") -> float:
        """An attribute that must be a number."""
        text = element.get(name, default)
        try:
            return float(text)
        except ValueError:
            raise self.fault(element, f"{name} must be a number, got {text!r}") from None

    def unit(self, element: etree._Element) -> Unit | None:
        """What the unit of an element means; None where it has none."""
        name = element.get("unit")
        if not name:
            return None
        found = self.units.get(name) or meaning(name)
        if found is None:
            raise self.fault(element, f"unit {name!r} must be defined in the Units of the file")
        return found

    def beside(self, element: etree._Element, source: str) -> str:
        """The location of the file that the URI `source` names, relative to this one; never outside of an archive."""
        parts = urlsplit(source)
        path = unquote(parts.path)
        if parts.scheme or parts.netloc or not path or path.startswith(("/", "\\")):
            raise self.fault(element, f"source must be a relative path, got {source!r}")
        outer, mark, member = self.location.rpartition("#")
        folder = (member if mark else self.location).replace("\\", "/").rpartition("/")[0]
        steps: list[str] = folder.split("/") if folder else []
        if not mark:
            return f"{folder}/{path}" if folder else path
        for step in path.replace("\\", "/").split("/"):
            if step == ".." and not steps:
                raise self.fault(element, f"source must lie inside the archive, got {source!r}")
            if step == "..":
                steps.pop()
            elif step not in ("", "."):
                steps.append(step)
        return f"{outer}#{'/'.join(steps)}"


def load(location: str, kind: str, name: str) -> Document:
    """The file at `location`, whose root must be the element `name` of the namespace `kind`."""
    root = archive.xml(archive.read(location), f"system file {location!r}")
    return document(location, root, kind, name)


def document(location: str, root: etree._Element, kind: str, name: str) -> Document:
    """The same for an element inside another file."""
    if root.tag != f"{{{NAMESPACES[kind]}}}{name}":
        raise ValueError(f"system file {location!r} must hold an SSP 1.0 {name}, got {root.tag!r}")
    version = root.get("version", "1.0")
    if not version.startswith(("1.", "2.")):
        raise ValueError(f"system file {location!r} must be of SSP 1.0 or 2.0, got {version!r}")
    empty = Document(location, root, {})
    units = {}
    for element in root.iterfind(f"{kind}:Units/ssc:Unit", NAMESPACES):
        base = element.find("ssc:BaseUnit", NAMESPACES)
        if base is not None:
            try:
                units[empty.attribute(element, "name")] = defined(element.get("name", ""), dict(base.attrib))
            except ValueError as error:
                raise empty.fault(element, f"BaseUnit must hold whole exponents and numbers: {error}") from None
    return Document(location, root, units)


def type_of(element: etree._Element) -> etree._Element | None:
    """The child of a connector or parameter that states its type."""
    for child in element:
        if isinstance(child.tag, str) and etree.QName(child).localname in TYPES:
            return child
    return None


def value_of(found: Document, parameter: etree._Element) -> Any:
    """The value of a Parameter element: a number, text, bytes, a Quantity, or a sequence of them for an array."""
    kind = type_of(parameter)
    if kind is None:
        raise found.fault(parameter, "must have a value of a known type")
    name = etree.QName(kind).localname
    several = [found.attribute(child, "value") for child in kind.iterfind("ssv:Value", NAMESPACES)]  # SSP 2.0
    if several and name in ("String", "Enumeration", "Binary"):
        return tuple(several)
    text = found.attribute(kind, "value")
    if name in ("String", "Enumeration"):
        return text
    if name == "Binary":
        return "".join(text.split())
    if name == "Boolean":
        return text if len(text.split()) == 1 else tuple(text.split())
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    if not numbers:
        raise found.fault(parameter, f"value must be a number, got {text!r}")
    unit = found.unit(kind) if name in REAL else None
    values = [number if unit is None else Quantity(number, unit) for number in numbers]
    return values[0] if len(values) == 1 else tuple(values)


def conversion_of(found: Document, element: etree._Element, start: Unit | None = None, end: Unit | None = None) -> Conversion:
    """What a Connection or MappingEntry does to a value."""
    suppress = element.get("suppressUnitConversion", "false") in ("true", "1")
    linear = element.find("ssc:LinearTransformation", NAMESPACES)
    if linear is not None:
        factor, offset = found.number(linear, "factor", "1"), found.number(linear, "offset", "0")
        return Conversion(start, end, factor, offset, suppress)
    for kind in ("Boolean", "Integer", "Enumeration"):
        mapping = element.find(f"ssc:{kind}MappingTransformation", NAMESPACES)
        if mapping is not None:
            entries = mapping.findall("ssc:MapEntry", NAMESPACES)
            pairs = [(found.attribute(e, "source"), found.attribute(e, "target")) for e in entries]
            if kind == "Enumeration":
                raise found.fault(element, "a mapping of enumeration items by name is not supported, use one of their numbers")
            try:
                return Conversion(start, end, suppress=suppress, table=tuple((_whole(a), _whole(b)) for a, b in pairs))
            except ValueError as error:
                raise found.fault(element, f"a mapping must have whole numbers or truth values, {error}") from None
    return Conversion(start, end, suppress=suppress)


def _whole(text: str) -> float:
    return float({"true": "1", "false": "0"}.get(text, text))


def through(value: Any, conversion: Conversion) -> Any:
    """A start value after a connection or mapping."""
    if isinstance(value, tuple):
        return tuple(through(element, conversion) for element in value)
    if conversion.table:
        table = dict(conversion.table)
        number = _whole(str(value))
        if number not in table:
            raise ValueError(f"a mapping must have an entry for {value}")
        return table[number]
    if conversion == Conversion():
        return value
    if isinstance(value, str | bytes):
        return value
    quantity = value if isinstance(value, Quantity) else Quantity(float(value), conversion.start)
    return quantity.through(conversion.factor, conversion.offset, conversion.end, suppress=conversion.suppress)
