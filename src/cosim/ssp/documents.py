"""What the XML files of SSP have in common: namespaces, attributes, units, values, transformations, places of other files."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from gyro_cosim.component.units import Unit

from ..errors import nearest
from ..systems import Conversion, archive
from ..systems.quantities import Quantity, defined, meaning
from .rules import NAMESPACES, REAL, TYPES, RuleError, check

Note = tuple[str, int, str]
LINES = 4  # that a note names


def told(notes: Iterable[Note]) -> list[str]:
    """The notes in words, the same of several lines in one."""
    lines: dict[tuple[str, str], set[int]] = {}
    for location, line, what in notes:
        lines.setdefault((location, what), set()).add(line)
    return [f"{location}{_lines(sorted(found - {0}))}: {what}" for (location, what), found in lines.items()]


def _lines(found: list[int]) -> str:
    more = f" and {len(found) - LINES} more" if len(found) > LINES else ""
    return f", line{'s' if len(found) > 1 else ''} {', '.join(map(str, found[:LINES]))}{more}" if found else ""


@dataclass(frozen=True)
class Document:
    """An XML file of SSP: `location` (`FILE` or `ARCHIVE#MEMBER`), its root element, the units it defines.

    notes : what is found that a reader should be told, as location, line and text; all documents of a system share one list.
    """

    location: str
    root: etree._Element
    units: Mapping[str, Unit]
    notes: list[Note]

    def note(self, element: etree._Element, what: str) -> None:
        """Tell the reader, with file and line."""
        self.notes.append((self.location, element.sourceline or 0, what))

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
        """What the unit of an element means; None where it has none, or one of which nothing is known."""
        name = element.get("unit")
        return self.known_unit(name) if name else None

    def known_unit(self, name: str) -> Unit | None:
        """What the file or the package knows of a unit; some tools write one in brackets, "[m/s]"."""
        return self.units.get(name) or meaning(_bare(name))

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


def _bare(unit: str) -> str:
    return unit[1:-1].strip() if unit.startswith("[") and unit.endswith("]") else unit


def load(location: str, kind: str, name: str, notes: list[Note]) -> Document:
    """The file at `location`, whose root must be the element `name` of the namespace `kind`, checked by the rules of SSP."""
    data = archive.read(location)
    undeclared: list[str] = []
    try:
        root = archive.xml(data, f"system file {location!r}")
    except ValueError:
        data, undeclared = with_prefixes(data)
        if not undeclared:
            raise
        root = archive.xml(data, f"system file {location!r}")
    found = document(location, root, kind, name, notes)
    if undeclared:
        found.note(root, f"the namespace prefix {', '.join(undeclared)} is not declared")
    try:
        check(root)
    except RuleError as error:
        raise found.fault(error.element, str(error)) from None
    return found


def document(location: str, root: etree._Element, kind: str, name: str, notes: list[Note]) -> Document:
    """The same for an element inside another file."""
    if root.tag != f"{{{NAMESPACES[kind]}}}{name}":
        draft = ", a draft of before SSP 1.0" if "Draft" in str(root.tag) else ""
        raise ValueError(f"system file {location!r} must hold an SSP {name}, got {root.tag!r}{draft}")
    version = root.get("version", "1.0")
    if not version.startswith(("1.", "2.")):
        raise ValueError(f"system file {location!r} must be of SSP 1.0 or 2.0, got {version!r}")
    empty = Document(location, root, {}, notes)
    units = {}
    for element in root.iterfind(f"{kind}:Units/ssc:Unit", NAMESPACES):
        base = element.find("ssc:BaseUnit", NAMESPACES)
        if base is not None:
            try:
                units[empty.attribute(element, "name")] = defined(element.get("name", ""), dict(base.attrib))
            except ValueError as error:
                raise empty.fault(element, f"BaseUnit must hold whole exponents and numbers: {error}") from None
    return Document(location, root, units, notes)


def with_prefixes(data: bytes) -> tuple[bytes, list[str]]:
    """An XML document with the namespace prefixes declared that it uses and does not declare, and these prefixes.

    Some tools read prefixes as a part of the name, and so their users' files have undeclared ones.
    """
    parser = etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False, recover=True)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError:
        return data, []
    faults = [error.type_name for error in parser.error_log]
    if root is None or not faults or set(faults) != {"NS_ERR_UNDEFINED_NAMESPACE"}:
        return data, []
    words = (re.match(r"Namespace prefix (\S+) ", error.message) for error in parser.error_log)
    prefixes = sorted({word[1] for word in words if word})
    spaces = "".join(f' xmlns:{p}="{NAMESPACES.get(p, f"urn:undeclared:{p}")}"' for p in prefixes)
    return re.sub(rb"(<[A-Za-z_][\w:.-]*)", lambda m: m[1] + spaces.encode(), data, count=1), prefixes


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
    nobody = _bare(kind.get("unit", "")) if unit is None and name in REAL else ""
    if nobody:
        found.note(kind, f"unit {kind.get('unit')!r} is not defined in the file: the number fits where no other unit is stated")
    plain = unit is None and not nobody
    values = [number if plain else Quantity(number, unit, unknown=nobody) for number in numbers]
    return values[0] if len(values) == 1 else tuple(values)


def conversion_of(found: Document, element: etree._Element, start: Unit | None = None, end: Unit | None = None) -> Conversion:
    """What a Connection or MappingEntry does to a value."""
    suppress = element.get("suppressUnitConversion", "false") in ("true", "1")  # the rules admit no other truth
    linear = element.find("ssc:LinearTransformation", NAMESPACES)
    if linear is not None:
        factor, offset = found.number(linear, "factor", "1"), found.number(linear, "offset", "0")
        return Conversion(start, end, factor, offset, suppress, explicit=True)
    for kind in ("Boolean", "Integer", "Enumeration"):
        mapping = element.find(f"ssc:{kind}MappingTransformation", NAMESPACES)
        if mapping is not None:
            entries = mapping.findall("ssc:MapEntry", NAMESPACES)
            pairs = [(found.attribute(e, "source"), found.attribute(e, "target")) for e in entries]
            if kind == "Enumeration":
                return Conversion(start, end, suppress=suppress, items=tuple(pairs))
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
    if conversion.items:
        names = dict(conversion.items)
        if str(value) not in names:
            raise ValueError(f"a mapping must have an entry for {value!r}{nearest(str(value), names)}")
        return names[str(value)]
    if conversion == Conversion():
        return value
    if isinstance(value, str | bytes):
        return value
    quantity = value if isinstance(value, Quantity) else Quantity(float(value), conversion.start)
    return quantity.through(conversion.factor, conversion.offset, conversion.end, suppress=conversion.suppress)
