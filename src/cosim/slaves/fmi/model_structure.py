"""What ModelStructure of a modelDescription.xml says: states with their derivatives, and what depends on what."""

from collections.abc import Sequence
from typing import Protocol

from lxml import etree


class Variable(Protocol):
    """What is needed of a variable."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def reference(self) -> int:
        """Its value reference."""

    @property
    def size(self) -> int:
        """How many elements it has."""


def states_2(root: etree._Element, rows: Sequence[Variable]) -> tuple[tuple[int, int], ...]:
    """ValueError where a derivative names no state; an FMU whose states nobody here asks for then has none."""
    elements = root.findall("ModelVariables/ScalarVariable")
    asked = root.find("ModelExchange") is not None or bool(root.xpath("CoSimulation/@providesDirectionalDerivative"))
    pairs = []
    for element in root.iterfind("ModelStructure/Derivatives/Unknown"):
        place = int(element.get("index", "0")) - 1
        real = elements[place].find("Real") if 0 <= place < len(elements) else None
        state = int(real.get("derivative", "0")) - 1 if real is not None else -1
        if not 0 <= state < len(rows):
            if not asked:
                return ()
            raise ValueError(f"ModelStructure lists {place + 1} as a derivative, which names no state")
        pairs.append((rows[state].reference, rows[place].reference))
    return tuple(pairs)


def states_3(root: etree._Element, rows: Sequence[Variable]) -> tuple[tuple[int, int], ...]:
    of = {e.get("valueReference"): e.get("derivative") for e in root.findall("ModelVariables/*") if e.get("derivative")}
    listed = [e.get("valueReference") for e in root.iterfind("ModelStructure/ContinuousStateDerivative")]
    scalar = {row.reference for row in rows if row.size == 1}
    pairs = [(int(of[r] or -1), int(r or -1)) for r in listed if r in of]
    return tuple(pair for pair in pairs if len(pairs) == len(listed) and set(pair) <= scalar)


def dependencies_2(root: etree._Element, rows: Sequence[Variable], kind: str) -> dict[str, tuple[str, ...] | None]:
    def named(index: str) -> str:
        if not 1 <= int(index) <= len(rows):
            raise ValueError(f"ModelStructure refers to variable {index}, it has {len(rows)}")
        return rows[int(index) - 1].name

    dependencies: dict[str, tuple[str, ...] | None] = {}
    for element in root.iterfind(f"ModelStructure/{kind}s/Unknown"):
        stated = element.get("dependencies")
        dependencies[named(element.get("index", "0"))] = None if stated is None else tuple(named(i) for i in stated.split())
    return dependencies


def dependencies_3(root: etree._Element, rows: Sequence[Variable], kind: str) -> dict[str, tuple[str, ...] | None]:
    names = {row.reference: row.name for row in reversed(rows)}
    dependencies: dict[str, tuple[str, ...] | None] = {}
    for element in root.iterfind(f"ModelStructure/{kind}"):
        stated = element.get("dependencies")
        known = None if stated is None else tuple(names[int(reference)] for reference in stated.split())
        dependencies[names[int(element.get("valueReference", "-1"))]] = known
    return dependencies
