"""Elements that a system file and a parameter set have in common, and the parameter set, as they are written."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lxml import etree

from gyro_cosim.component.units import BASE, Unit

from ..errors import unknown
from ..slaves import Signal, SlaveDescription, Value
from ..systems import SystemComponent
from ..systems.quantities import meaning
from .rules import NAMESPACES

VERSIONS = ("1.0", "2.0")
TYPES = {
    "real": "Real", "integer": "Integer", "boolean": "Boolean", "enumeration": "Enumeration", "string": "String",
    "binary": "Binary",
}  # fmt: skip


@dataclass(frozen=True)
class Writing:
    """What is written: which version of SSP, the units in use, and names for the enumerations, made as they are met.

    types : component -> variable -> its type as FMI calls it, which SSP 2.0 takes over.
    """

    version: str
    units: Mapping[str, Unit]
    types: Mapping[str, Mapping[str, str]]
    enumerations: dict[tuple[tuple[str, int], ...], str] = field(default_factory=dict)

    def type_of(self, component: str, signal: Signal) -> str:
        """The type of a variable in the version that is written."""
        own = self.types[component].get(self.variable(component, signal.name), "")
        return own if self.version == "2.0" and own else TYPES[signal.type]

    def variable(self, component: str, name: str) -> str:
        """The variable of the FMU that a signal belongs to: the array where it is an element of one."""
        return name if name in self.types[component] else base(name)


def base(name: str) -> str:
    """The variable that an element belongs to: "y" for "y[2]"; a scalar is itself."""
    return name[: name.rindex("[")] if name.endswith("]") else name


def units_of(signals: Iterable[Signal]) -> dict[str, Unit]:
    """What every unit in use means. One name that two FMUs define differently stays with the first."""
    found: dict[str, Unit] = {}
    for signal in signals:
        unit = meaning(signal.unit, signal.definition)
        if signal.unit and unit is not None:
            found.setdefault(signal.unit, unit)
    return found


def tag(kind: str, name: str) -> str:
    """The full name of an element."""
    return f"{{{NAMESPACES[kind]}}}{name}"


def add(parent: etree._Element, kind: str, name_: str, /, **attributes: str) -> etree._Element:
    """A child of the namespace `kind`; attributes that are empty are left out."""
    return etree.SubElement(parent, tag(kind, name_), {key: value for key, value in attributes.items() if value != ""})


def dimensions(parent: etree._Element, shape: Iterable[int]) -> None:
    """The sizes of an array, SSP 2.0."""
    for size in shape:
        add(parent, "ssc", "Dimension", size=str(size))


def write_units(root: etree._Element, kind: str, units: Mapping[str, Unit]) -> None:
    """The Units of a document; none where there are none."""
    if not units:
        return
    parent = add(root, kind, "Units")
    for name, unit in sorted(units.items()):
        exponents = {base: str(e) for base, e in zip(BASE, unit.dimension, strict=True) if e}
        scale = {} if unit.factor == 1.0 else {"factor": repr(unit.factor)}
        shift = {} if unit.offset == 0.0 else {"offset": repr(unit.offset)}
        add(add(parent, "ssc", "Unit", name=name), "ssc", "BaseUnit", **exponents, **scale, **shift)


def parameter_set(
    name: str, component: SystemComponent, description: SlaveDescription, writing: Writing
) -> etree._Element | None:
    """The values of a component as an .ssv; None where there are none. All sets have one name, which some importers ask for.

    SSP 1.0 knows no arrays: each element is a parameter there.
    """
    used = {k: NAMESPACES[k] for k in ("ssv", "ssc")}
    root = etree.Element(tag("ssv", "ParameterSet"), {"version": writing.version, "name": name}, nsmap=used)
    parent = add(root, "ssv", "Parameters")
    for variable in component.values:
        if variable not in description.settable:
            raise unknown(f"parameter of {component.name!r}:", variable, description.settable)
    mentioned = set()
    for variable, given in {**component.bound, **component.values}.items():
        if variable not in description.settable:
            continue
        signal = description.settable[variable]
        try:
            value = signal.value(given)
        except ValueError as error:
            raise ValueError(f"{component.name}.{variable}: {error}") from None
        unit = signal.unit if signal.unit in writing.units and signal.type == "real" else ""
        mentioned.add(unit)
        elements = value if isinstance(value, tuple) else (value,)
        kind = writing.type_of(component.name, signal)
        if signal.shape and writing.version == "2.0":
            _parameter(parent, variable, kind, signal, elements, unit)
            continue
        names = [s for s in description.settable if s.startswith(f"{variable}[")] if signal.shape else [variable]
        for element, label in zip(elements, names, strict=True):
            _parameter(parent, label, kind, signal, (element,), unit)
    write_units(root, "ssv", {name: writing.units[name] for name in mentioned if name})
    return root if len(parent) else None


def _parameter(parent: etree._Element, name: str, kind: str, signal: Signal, values: Iterable[Value], unit: str) -> None:
    texts = [_text(signal, value) for value in values]
    holder = add(parent, "ssv", "Parameter", name=name)
    element = etree.SubElement(holder, tag("ssv", kind))
    if len(texts) > 1 and signal.type in ("string", "enumeration", "binary"):
        for text in texts:
            etree.SubElement(element, tag("ssv", "Value"), value=text)
    else:
        element.set("value", " ".join(texts))
    if unit:
        element.set("unit", unit)
    if len(texts) > 1:
        dimensions(holder, signal.shape)


def _text(signal: Signal, value: Any) -> str:
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, str):
        return value
    return {
        "real": repr(value), "integer": str(int(value)), "boolean": str(bool(value)).lower(),
        "enumeration": next((item for item, number in signal.items if number == value), str(int(value))),
    }[signal.type]  # fmt: skip


def as_bytes(root: etree._Element) -> bytes:
    """The document as it is packed."""
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
