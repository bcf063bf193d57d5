"""The variables that modelDescription.xml lists, as rows: of FMI 2.0 and 3.0 here, of FMI 1.0 in rows1.py."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import prod

from lxml import etree

from gyro_cosim.component.units import Unit

from ...systems.quantities import defined

FMI3_TYPES = (
    "Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
    "Boolean", "String", "Binary", "Enumeration", "Clock",
)  # fmt: skip
LARGEST = 1_000_000  # elements of an array
REAL = ("Real", "Float64", "Float32")
TEXTS = ("String", "Binary")


@dataclass(frozen=True)
class Row:
    """A variable. `type` as FMI calls it; `start` one text per element, in the order of FMI's arrays; `shape` () for a scalar.

    items : names and values of an enumeration. display : the unit in which people read it; nominal : its usual size.
    sized_by : for each dimension the value reference of the structural parameter that gives it, None where it is fixed.
    clocks : value references of the clocks that a clocked variable has. timing : of a clock, its attributes.
    negated : of FMI 1.0, its value is the opposite of what its value reference stands for.
    """

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    initial: str
    start: tuple[str, ...]
    unit: str
    definition: Unit | None
    min: float | None
    max: float | None
    description: str
    shape: tuple[int, ...]
    items: tuple[tuple[str, int], ...]
    intermediate: bool
    display: str = ""
    nominal: float | None = None
    sized_by: tuple[int | None, ...] = ()
    clocks: tuple[int, ...] = ()
    timing: Mapping[str, str] = field(default_factory=dict)
    negated: bool = False

    @property
    def size(self) -> int:
        """How many elements it has."""
        return prod(self.shape)

    @property
    def settable(self) -> bool:
        """Whether it may be given a value before the run."""
        if self.variability == "constant" or self.causality == "independent" or self.type == "Clock":
            return False
        return self.causality in ("parameter", "structuralParameter", "input") or self.initial in ("exact", "approx")


def units_of(root: etree._Element) -> dict[str, Unit | None]:
    """Name -> definition of every unit in UnitDefinitions; None where it has no BaseUnit."""
    units: dict[str, Unit | None] = {}
    for element in root.iterfind("UnitDefinitions/Unit"):
        base = element.find("BaseUnit")
        units[element.get("name", "")] = None if base is None else defined(element.get("name", ""), dict(base.attrib))
    return units


_INITIAL = {
    ("constant", "output"): "exact", ("constant", "local"): "exact",
    **{(v, c): "exact" for v in ("fixed", "tunable") for c in ("parameter", "structuralParameter")},
    **{(v, "input"): "exact" for v in ("discrete", "continuous")},
}  # fmt: skip


def row_of(
    element: etree._Element, value: etree._Element, kind: str, declared: etree._Element | None, units: Mapping[str, Unit | None],
    variability: str, start: tuple[str, ...], shape: tuple[int, ...],
) -> Row:  # fmt: skip
    def attribute(name: str) -> str:
        return value.get(name) or ("" if declared is None else declared.get(name, ""))

    def number(name: str) -> float | None:
        return float(attribute(name)) if attribute(name) else None

    causality = element.get("causality", "local")
    unit = attribute("unit")
    definition = units.get(unit)
    if definition is not None and attribute("relativeQuantity") in ("true", "1"):
        definition = Unit(definition.name, definition.factor, definition.dimension)
    listed = [] if declared is None else declared.findall("Item")
    items = tuple((item.get("name", ""), int(item.get("value", place))) for place, item in enumerate(listed, 1))
    return Row(
        name=element.get("name", ""), reference=int(element.get("valueReference", "0")), type=kind, causality=causality,
        variability=variability, initial=element.get("initial") or _INITIAL.get((variability, causality), "calculated"),
        start=start, unit=unit, definition=definition, min=number("min"), max=number("max"),
        description=element.get("description", ""), shape=shape, items=items,
        intermediate=element.get("intermediateUpdate", "false") in ("true", "1"), display=attribute("displayUnit"),
        nominal=number("nominal"),
    )  # fmt: skip


def rows_2(root: etree._Element, units: Mapping[str, Unit | None]) -> tuple[Row, ...]:
    declared = {e.get("name"): e[0] for e in root.iterfind("TypeDefinitions/SimpleType")}
    rows = []
    for element in root.iterfind("ModelVariables/ScalarVariable"):
        value = next(child for child in element if child.tag != "Annotations")
        of = declared[value.get("declaredType")] if value.get("declaredType") else None
        start = (value.get("start", ""),) if "start" in value.attrib else ()
        rows.append(row_of(element, value, value.tag, of, units, element.get("variability", "continuous"), start, ()))
    return tuple(rows)


def rows_3(root: etree._Element, units: Mapping[str, Unit | None]) -> tuple[Row, ...]:
    declared = {e.get("name"): e for e in root.iterfind("TypeDefinitions/*")}
    elements = [e for e in root.iterfind("ModelVariables/*") if e.tag in FMI3_TYPES]
    starts = {e.get("valueReference"): e.get("start", "") for e in elements}
    rows = []
    for element in elements:
        of = declared[element.get("declaredType")] if element.get("declaredType") else None
        dimensions = element.findall("Dimension")
        shape = tuple(int(d.get("start") or starts[d.get("valueReference")]) for d in dimensions)
        if prod(shape) > LARGEST:
            raise ValueError(f"variable {element.get('name')!r} must have at most {LARGEST} elements, has {prod(shape)}")
        if element.tag in TEXTS:
            start = tuple(s.get("value", "") for s in element.iterfind("Start"))
        else:
            start = tuple(element.get("start", "").split())
        if len(start) == 1:
            start *= prod(shape)
        elif start and len(start) != prod(shape):
            raise ValueError(f"variable {element.get('name')!r} must have {prod(shape)} start values, has {len(start)}")
        parameter = element.get("causality") in ("parameter", "calculatedParameter", "structuralParameter")
        usual = "fixed" if parameter else "continuous" if element.tag in REAL else "discrete"
        row = row_of(element, element, element.tag, of, units, element.get("variability", usual), start, shape)
        sized_by = tuple(int(d.get("valueReference", "0")) if d.get("start") is None else None for d in dimensions)
        clocks = tuple(map(int, element.get("clocks", "").split()))
        row = replace(row, sized_by=sized_by, clocks=clocks, timing=dict(element.attrib) if element.tag == "Clock" else {})
        rows.append(row)
        for alias in element.iterfind("Alias"):
            rows.append(_row_alias(row, alias))
    return tuple(rows)


def _row_alias(row: Row, alias: etree._Element) -> Row:
    """The same variable under another name: it can be given a value, but the outputs list it once."""
    causality = "local" if row.causality == "output" else row.causality
    return Row(**{**row.__dict__, "name": alias.get("name", ""), "causality": causality if causality != "input" else "local"})
