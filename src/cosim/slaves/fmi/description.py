"""modelDescription.xml of FMI 1.0, 2.0 and 3.0, reduced to what a co-simulation needs."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from lxml import etree

from gyro_cosim.component.units import Unit

from ...systems import archive
from .model_structure import dependencies_2, dependencies_3, states_2, states_3
from .rows import Row, rows_2, rows_3, units_of
from .rows1 import dependencies_1, interfaces_1, rows_1
from .schema import judged

MEMBER = "modelDescription.xml"
CO_SIMULATION, MODEL_EXCHANGE = "CoSimulation", "ModelExchange"  # FMI's interfaces, as the elements are called


@dataclass(frozen=True)
class Description:
    """`version` "1", "2" or "3"; `interfaces` name -> attributes; `dependencies` output -> names it depends on, None: unknown.

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
    def own_step(self) -> float:
        """The one length of its steps within communication steps (s), where it has one and says so; else 0."""
        return float(self.interfaces.get(self.interface, {}).get("fixedInternalStepSize", "0"))

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
    offers = " and ".join(map(_spelt, description.interfaces)) or "nothing"
    if description.version == "1":
        if MODEL_EXCHANGE in (implementation, description.interface):
            raise ValueError(f"FMU {file!r} of FMI 1.0 must run by Co-Simulation, offers {offers}")
        wanted = (CO_SIMULATION,)
    if not set(wanted) & set(description.interfaces):
        raise ValueError(f"FMU {file!r} must offer {' or '.join(map(_spelt, wanted))}, offers {offers} only")
    return replace(description, interface=next(name for name in wanted if name in description.interfaces))


def _spelt(interface: str) -> str:
    """An interface as the standard's text calls it."""
    return {CO_SIMULATION: "Co-Simulation", MODEL_EXCHANGE: "Model Exchange"}.get(interface, "Scheduled Execution")


def load(file: str) -> Description:
    """The description of any FMU of FMI 1.0, 2.0 or 3.0."""
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
    if not (version in ("1.0", "2.0") or version.startswith("3.")):
        raise ValueError(f"FMU {file!r} must be FMI 1.0, 2.0 or 3.0, got FMI {version}")
    major = version[0]
    root, broken = judged(root, major)
    for fault in broken:
        if not fault.harmless:
            raise ValueError(f"{where} must keep the schema of FMI {version}: {fault}")
    kinds = (CO_SIMULATION, MODEL_EXCHANGE, "ScheduledExecution")
    try:
        if major == "1":
            return _parsed_1(file, root, tuple(str(fault) for fault in broken))
        units = units_of(root)
        rows = rows_3(root, units) if major == "3" else rows_2(root, units)
        listed = dependencies_3 if major == "3" else dependencies_2
        dependencies, initial = listed(root, rows, "Output"), listed(root, rows, "InitialUnknown")
        states = states_3(root, rows) if major == "3" else states_2(root, rows)
    except (KeyError, IndexError, ValueError) as error:
        what = str(error) if isinstance(error, ValueError) else f"it refers to {error}, which is not there"
        raise ValueError(f"{where}: {what}") from None
    interfaces = {e.tag: dict(e.attrib) for e in root if e.tag in kinds}
    return Description(
        file, major, root.get("modelName", ""), root.get("instantiationToken" if major == "3" else "guid", ""), dict(root.attrib),
        interfaces, rows, dependencies, units, _experiment(root), initial, states, tuple(str(fault) for fault in broken),
        MODEL_EXCHANGE if MODEL_EXCHANGE in interfaces and CO_SIMULATION not in interfaces else CO_SIMULATION,
        int(root.get("numberOfEventIndicators", "0")) + len(root.findall("ModelStructure/EventIndicator")),
    )  # fmt: skip


def _experiment(root: etree._Element) -> dict[str, str]:
    found = root.find("DefaultExperiment")
    return {} if found is None else dict(found.attrib)


def _parsed_1(file: str, root: etree._Element, faults: tuple[str, ...]) -> Description:
    """Of FMI 1.0. It has no initialization mode: what depends on what at the start is what does at other times."""
    interfaces, dependencies = interfaces_1(root), dependencies_1(root)
    return Description(
        file, "1", root.get("modelName", ""), root.get("guid", ""), dict(root.attrib), interfaces, rows_1(root), dependencies, {},
        _experiment(root), dependencies, (), faults, next(iter(interfaces)), int(root.get("numberOfEventIndicators", "0")),
    )  # fmt: skip
