"""Whether modelDescription.xml keeps FMI's schema, and which faults do no harm: one judgement for runs and for checks.

A fault does no harm where nothing is read that it could change: in what a tool adds for itself (Annotations, Tool), in the date
of the export, in an attribute that FMI does not know and that is near none of those it does, in a list that is empty. Such faults
are taken out of the tree and the rest is validated again, for a validator looks no further behind a fault.
"""

import difflib
import importlib.util
import re
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from lxml import etree

VENDOR = ("Annotation", "Annotations", "VendorAnnotations", "Tool")
EMPTY_LISTS = (
    "Outputs", "Derivatives", "DiscreteStates", "InitialUnknowns", "LogCategories", "UnitDefinitions", "TypeDefinitions",
    "VendorAnnotations", "Annotations", "SourceFiles",
)  # fmt: skip
DATES = ("generationDateAndTime",)
ELSEWHERE = (("ScalarVariable", "previous"), ("String", "start"), ("Binary", "start"))  # misplaced, and not read there
MEANT = 0.8  # of difflib: an unknown attribute that is so near a known one may be that one, misspelt
ROUNDS = 50
MODEL_DESCRIPTION, BUILD_DESCRIPTION = "ModelDescription", "BuildDescription"  # the documents, as their schemas are called
_ATTRIBUTE = re.compile(r"^Element '[^']*', attribute '([^']*)'")
_XSD = "{http://www.w3.org/2001/XMLSchema}"


@dataclass(frozen=True)
class SchemaFault:
    """One place that does not keep the schema. harmless : whether the FMU can be read all the same."""

    line: int
    message: str
    harmless: bool

    def __str__(self) -> str:
        return f"line {self.line}: {self.message}"


def judged(root: etree._Element, major: str, document: str = MODEL_DESCRIPTION) -> tuple[etree._Element, tuple[SchemaFault, ...]]:
    """The description without its harmless faults, and all faults, each once.

    `major`: "1", "2" or "3", the version of FMI. `document`: which of that version's it is. `root` itself stays as it is.
    Where a fault is not harmless, the description must not be read.
    """
    schema = _schema(major, document)
    if schema.validate(root):
        return root, ()
    found: dict[tuple[int, str], SchemaFault] = {}
    whole, known = deepcopy(root), _known_attributes(major)
    for _ in range(ROUNDS):
        if schema.validate(whole):
            break
        mended = False
        for error, element in [(e, _element(whole, e.path)) for e in schema.error_log]:  # found before any is changed
            harmless = element is not None and _mend(element, error.message, known)
            mended = mended or harmless
            fault = SchemaFault(error.line, " ".join(error.message.split()), harmless)
            found.setdefault((fault.line, fault.message), fault)
        if not mended or any(not fault.harmless for fault in found.values()):
            break
    else:
        found[0, ""] = SchemaFault(0, f"it has more faults than {ROUNDS} repairs take out", False)
    return whole, tuple(found.values())


def _element(root: etree._Element, path: str | None) -> etree._Element | None:
    """The element at an XPath of the validator's; None where that is no one element."""
    found = root.getroottree().xpath(path) if path else []
    return found[0] if len(found) == 1 else None


def _mend(element: etree._Element, message: str, known: frozenset[str]) -> bool:
    """Take a harmless fault out; False, and nothing is done, where it may do harm."""
    parent, attribute = element.getparent(), _ATTRIBUTE.match(message)
    if parent is None and element.tag in VENDOR:
        return True  # taken out already, for another fault of its own
    vendor = any(e.tag in VENDOR for e in (element, *element.iterancestors()))
    if attribute is not None:
        name = attribute[1]
        if name not in element.attrib:
            return True  # the same
        strange = name not in known and not difflib.get_close_matches(name, known, 1, MEANT)
        foreign = "is not allowed" in message and (strange or (element.tag, name) in ELSEWHERE)
        if vendor or name in DATES or foreign:
            del element.attrib[name]
            return True
        return False
    if vendor and parent is not None:
        parent.remove(element)
        return True
    if element.tag in EMPTY_LISTS and not len(element) and parent is not None:
        parent.remove(element)
        return True
    return False


def _folder(major: str) -> Path:
    """Where FMPy keeps the schema; found without loading FMPy."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        raise RuntimeError("FMPy must be installed: it holds the schemas of FMI")
    return Path(spec.submodule_search_locations[0]) / "schema" / f"fmi{major}"


@lru_cache(maxsize=4)
def _schema(major: str, document: str) -> etree.XMLSchema:
    name = f"fmi{'' if major == '1' else major}{document}.xsd"
    return etree.XMLSchema(file=str(_folder(major) / name))


@lru_cache(maxsize=3)
def _known_attributes(major: str) -> frozenset[str]:
    """Every attribute that the schema knows on any element."""
    names: set[str] = set()
    for file in _folder(major).glob("*.xsd"):
        names |= {e.get("name", "") for e in etree.parse(str(file)).iter(f"{_XSD}attribute")}
    return frozenset(names - {""})
