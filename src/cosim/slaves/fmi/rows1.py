"""The variables of FMI 1.0 in the words of FMI 2.0, and what its modelDescription.xml says beside them."""

from collections.abc import Mapping
from dataclasses import replace

from lxml import etree

from .rows import Row, row_of

KINDS = ("Real", "Integer", "Boolean", "String", "Enumeration")


def rows_1(root: etree._Element) -> tuple[Row, ...]:
    """What may be set before the run is what has a start value; a unit is what its name says, since FMI 1.0 defines none."""
    declared = {e.get("name"): e[0] for e in root.iterfind("TypeDefinitions/Type")}
    rows = []
    for element in root.iterfind("ModelVariables/ScalarVariable"):
        value = next(child for child in element if child.tag in KINDS)
        of = declared[value.get("declaredType")] if value.get("declaredType") else None
        start = (value.get("start", ""),) if "start" in value.attrib else ()
        stated, causality = element.get("variability", "continuous"), element.get("causality", "internal")
        variability = "fixed" if stated == "parameter" else "discrete" if value.tag != "Real" and stated != "constant" else stated
        row = row_of(element, value, value.tag, of, {}, variability, start, ())
        own = causality if causality in ("input", "output") else "parameter" if stated == "parameter" else "local"
        initial = "calculated" if not start else "approx" if value.get("fixed") in ("false", "0") else "exact"
        rows.append(replace(row, causality=own, initial=initial, negated=element.get("alias") == "negatedAlias"))
    return tuple(rows)


def dependencies_1(root: etree._Element) -> dict[str, tuple[str, ...] | None]:
    """What each output depends on directly; None: not stated."""
    listed = {}
    for element in root.iterfind("ModelVariables/ScalarVariable[@causality='output']"):
        stated = element.find("DirectDependency")
        listed[element.get("name", "")] = None if stated is None else tuple((name.text or "").strip() for name in stated)
    return listed


def interfaces_1(root: etree._Element) -> dict[str, Mapping[str, str]]:
    """By which interfaces it runs, with their capabilities, as FMI 2.0 calls them."""
    identifier = {"modelIdentifier": root.get("modelIdentifier", "")}
    for kind, needs_tool in (("StandAlone", "false"), ("Tool", "true")):
        able = root.find(f"Implementation/CoSimulation_{kind}/Capabilities")
        if able is not None:
            return {"CoSimulation": {**identifier, **dict(able.attrib), "needsExecutionTool": needs_tool}}
    return {"ModelExchange": identifier}
