"""modelDescription.xml of FMI 2.0 and 3.0, reduced to what a co-simulation needs."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import prod

from lxml import etree

from gyro_cosim.component.units import Unit

from ...systems import archive
from ...systems.quantities import defined
from .model_structure import dependencies_2, dependencies_3, states_2, states_3
from .schema import judged

FMI3_TYPES = (
    "Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
    "Boolean", "String", "Binary", "Enumeration", "Clock",
)  # fmt: skip
MEMBER = "modelDescription.xml"
LARGEST = 1_000_000  # elements of an array
REAL = ("Real", "Float64", "Float32")
TEXTS = ("String", "Binary")
CO_SIMULATION, MODEL_EXCHANGE = "CoSimulation", "ModelExchange"  # FMI's interfaces, as the elements are called


@dataclass(frozen=True)
class Row:
    """A variable. `type` as FMI calls it; `start` one text per element, in the order of FMI's arrays; `shape` () for a scalar.

    items : names and values of an enumeration. display : the unit in which people read it; nominal : its usual size.
    sized_by : for each dimension the value reference of the structural parameter that gives it, None where it is fixed.
    clocks : value references of the clocks that a clocked variable has. timing : of a clock, its attributes.
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


@dataclass(frozen=True)
class Description:
    """`version` "2" or "3"; `interfaces` name -> attributes; `dependencies` output -> names it depends on, None: unknown.

    initial : the same of all that is computed in initialization mode. interface : the one by which it runs here.
    indicators : how many variables the FMU names as event indicators; arrays of FMI 3.0 count once.
    """

    file: str
    version: str
    model: str
    token: str
    identity: Mapping[str, str]
    interfaces: Mapping[str, Mapping[str, str]]
    rows: tuple[Row, ...]
    dependencies: Mapping[str, tuple[str, ...] | None]
    units: Mapping[str, Unit | None]
    experiment: Mapping[str, str] = field(default_factory=dict)
    initial: Mapping[str, tuple[str, ...] | None] = field(default_factory=dict)
    states: tuple[tuple[int, int], ...] = ()  # value references of each continuous state and of its derivative
    schema_faults: tuple[str, ...] = ()  # that do no harm
    interface: str = CO_SIMULATION
    indicators: int = 0

    def can(self, capability: str) -> bool:
        """Whether the interface by which it runs has a boolean capability."""
        return self.interfaces.get(self.interface, {}).get(capability, "false") in ("true", "1")

    @property
    def exchanged(self) -> bool:
        """Whether it is integrated here, by Model Exchange."""
        return self.interface == MODEL_EXCHANGE


def read(file: str, implementation: str = "") -> Description:
    """The description of an FMU that can run, `FILE` or `ARCHIVE#MEMBER`; ValueError says what is wrong.

    It runs by Co-Simulation where it offers that, else by Model Exchange, or as `implementation` says.
    """
    description = load(file)
    wanted = (implementation,) if implementation else (CO_SIMULATION, MODEL_EXCHANGE)
    if not set(wanted) & set(description.interfaces):
        offers = " and ".join(map(_spelt, description.interfaces)) or "nothing"
        raise ValueError(f"FMU {file!r} must offer {' or '.join(map(_spelt, wanted))}, offers {offers} only")
    return replace(description, interface=next(name for name in wanted if name in description.interfaces))


def _spelt(interface: str) -> str:
    """An interface as the standard's text calls it."""
    return {CO_SIMULATION: "Co-Simulation", MODEL_EXCHANGE: "Model Exchange"}.get(interface, "Scheduled Execution")


def load(file: str) -> Description:
    """The description of any FMU of FMI 2.0 or 3.0."""
    if not archive.exists(file):
        raise ValueError(f"FMU {file!r} must exist")
    with archive.opened(file) as members:
        if MEMBER not in members.namelist():
            raise ValueError(f"FMU {file!r} must hold {MEMBER}")
        return parse(file, archive.held(members, MEMBER, file))


def parse(file: str, data: bytes) -> Description:
    """The description in the bytes of modelDescription.xml of the FMU called `file`."""
    where = f"FMU {file!r}: its modelDescription.xml"
    root = archive.xml(data, where)
    version = root.get("fmiVersion", "")
    if root.tag != "fmiModelDescription" or not version:
        raise ValueError(f"{where} must hold an fmiModelDescription with an fmiVersion, got {root.tag!r}")
    if not (version == "2.0" or version.startswith("3.")):
        raise ValueError(f"FMU {file!r} must be FMI 2.0 or 3.0, got FMI {version}")
    major = version[0]
    root, broken = judged(root, major)
    for fault in broken:
        if not fault.harmless:
            raise ValueError(f"{where} must keep the schema of FMI {version}: {fault}")
    kinds = (CO_SIMULATION, MODEL_EXCHANGE, "ScheduledExecution")
    try:
        units = _units(root)
        rows = _rows_3(root, units) if major == "3" else _rows_2(root, units)
        listed = dependencies_3 if major == "3" else dependencies_2
        dependencies, initial = listed(root, rows, "Output"), listed(root, rows, "InitialUnknown")
        states = states_3(root, rows) if major == "3" else states_2(root, rows)
    except (KeyError, IndexError, ValueError) as error:
        what = str(error) if isinstance(error, ValueError) else f"it refers to {error}, which is not there"
        raise ValueError(f"{where}: {what}") from None
    experiment = root.find("DefaultExperiment")
    interfaces = {e.tag: dict(e.attrib) for e in root if e.tag in kinds}
    return Description(
        file, major, root.get("modelName", ""), root.get("instantiationToken" if major == "3" else "guid", ""), dict(root.attrib),
        interfaces, rows, dependencies, units, {} if experiment is None else dict(experiment.attrib), initial, states,
        tuple(str(fault) for fault in broken),
        MODEL_EXCHANGE if MODEL_EXCHANGE in interfaces and CO_SIMULATION not in interfaces else CO_SIMULATION,
        int(root.get("numberOfEventIndicators", "0")) + len(root.findall("ModelStructure/EventIndicator")),
    )  # fmt: skip


def _units(root: etree._Element) -> dict[str, Unit | None]:
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


def _row(
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
    items = () if declared is None else tuple((i.get("name", ""), int(i.get("value", "0"))) for i in declared.iterfind("Item"))
    return Row(
        name=element.get("name", ""), reference=int(element.get("valueReference", "0")), type=kind, causality=causality,
        variability=variability, initial=element.get("initial") or _INITIAL.get((variability, causality), "calculated"),
        start=start, unit=unit, definition=definition, min=number("min"), max=number("max"),
        description=element.get("description", ""), shape=shape, items=items,
        intermediate=element.get("intermediateUpdate", "false") in ("true", "1"), display=attribute("displayUnit"),
        nominal=number("nominal"),
    )  # fmt: skip


def _rows_2(root: etree._Element, units: Mapping[str, Unit | None]) -> tuple[Row, ...]:
    declared = {e.get("name"): e[0] for e in root.iterfind("TypeDefinitions/SimpleType")}
    rows = []
    for element in root.iterfind("ModelVariables/ScalarVariable"):
        value = next(child for child in element if child.tag != "Annotations")
        of = declared[value.get("declaredType")] if value.get("declaredType") else None
        start = (value.get("start", ""),) if "start" in value.attrib else ()
        rows.append(_row(element, value, value.tag, of, units, element.get("variability", "continuous"), start, ()))
    return tuple(rows)


def _rows_3(root: etree._Element, units: Mapping[str, Unit | None]) -> tuple[Row, ...]:
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
        row = _row(element, element, element.tag, of, units, element.get("variability", usual), start, shape)
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
