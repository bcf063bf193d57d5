"""modelDescription.xml of a coupled system's FMU, of FMI 2.0 and FMI 3.0."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from gyro_cosim.component.units import BASE, Unit

from ..systems import System
from ..systems.quantities import meaning
from .components import Packed
from .structure import calculated_at_start, derivatives, outputs
from .variables import Variable, Variables

__all__ = ["Identity", "build_description", "fmi2", "fmi3"]

CATEGORIES = {
    "logEvents": "what a component says in passing, and stop conditions",
    "logStatusDiscard": "why a call was refused or a step not done",
    "logStatusError": "why a call was wrong",
    "logStatusWarning": "what is not quite right",
}
_TAGS_3 = {"real": "Float64", "integer": "Int32", "enumeration": "Enumeration", "boolean": "Boolean", "string": "String"}
_TAGS = {"real": "Real", "integer": "Integer", "enumeration": "Enumeration", "boolean": "Boolean", "string": "String"}


@dataclass(frozen=True)
class Identity:
    """What the description says of the FMU as a whole.

    Parameters
    ----------
    identifier, token, tool : str
        The model identifier, the guid or instantiation token, and who made the FMU.
    sources : tuple of str
        The C files to compile; empty where none are shipped.
    """

    identifier: str
    token: str
    tool: str
    sources: tuple[str, ...] = ()


def fmi2(system: System, components: Sequence[Packed], variables: Variables, identity: Identity) -> bytes:
    """modelDescription.xml of FMI 2.0.

    Parameters
    ----------
    system : System
        What is packed.
    components : sequence of Packed
        Its components.
    variables : Variables
        Of the FMU.
    identity : Identity
        What else it says.

    Returns
    -------
    bytes
        The file.
    """
    root = ET.Element("fmiModelDescription", {"fmiVersion": "2.0", **_about(system, variables, identity), "guid": identity.token})
    root.set("numberOfEventIndicators", "0")
    can = _abilities(components)
    interface = ET.SubElement(root, "CoSimulation", {
        "modelIdentifier": identity.identifier, "canNotUseMemoryManagementFunctions": "true", "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0", "canHandleVariableCommunicationStepSize": can["every length"],
        "canBeInstantiatedOnlyOncePerProcess": can["once"], "canGetAndSetFMUstate": can["restore"],
        "canSerializeFMUstate": can["serialize"], "providesDirectionalDerivative": str(variables.derivable).lower(),
    })  # fmt: skip
    if identity.sources:
        files = ET.SubElement(interface, "SourceFiles")
        for source in identity.sources:
            ET.SubElement(files, "File", name=source)
    units = _units(variables.all)
    _write_units(root, units)
    types = ET.SubElement(root, "TypeDefinitions")
    enumerations = _enumerations(variables.all)
    for items, name in enumerations.items():
        kind = ET.SubElement(ET.SubElement(types, "SimpleType", name=name), "Enumeration")
        for item, value in items:
            ET.SubElement(kind, "Item", name=item, value=str(value))
    _write_log_categories(root)
    _write_experiment(root, system)
    listed, states = ET.SubElement(root, "ModelVariables"), dict(variables.derivatives)
    for reference, v in enumerate(variables.all):
        if v.kind != "time":  # optional in FMI 2.0, and FMI Library wants a start value that it must not have
            element = ET.SubElement(listed, "ScalarVariable", _attributes(v, reference))
            of_type = _value(v, units, enumerations, bounds=v.type in ("real", "integer"))
            ET.SubElement(element, _TAGS[v.type], of_type | _of_state(reference, states))
    structure = ET.SubElement(root, "ModelStructure")
    for tag, rows in (
        ("Outputs", outputs(variables)), ("Derivatives", derivatives(variables)),
        ("InitialUnknowns", calculated_at_start(variables)),
    ):  # fmt: skip
        parent = ET.SubElement(structure, tag) if rows else None
        for reference, known in rows:
            assert parent is not None
            ET.SubElement(parent, "Unknown", {"index": str(reference), **_known(known)})  # time, the first, is not in the list
    return _document(root)


def fmi3(system: System, components: Sequence[Packed], variables: Variables, identity: Identity) -> bytes:
    """modelDescription.xml of FMI 3.0.

    Parameters
    ----------
    system, components, variables, identity
        As of fmi2().

    Returns
    -------
    bytes
        The file.
    """
    about = _about(system, variables, identity)
    root = ET.Element("fmiModelDescription", {"fmiVersion": "3.0", **about, "instantiationToken": identity.token})
    can = _abilities(components)
    ET.SubElement(root, "CoSimulation", {
        "modelIdentifier": identity.identifier, "canBeInstantiatedOnlyOncePerProcess": can["once"],
        "canGetAndSetFMUState": can["restore"], "canSerializeFMUState": can["serialize"],
        "canHandleVariableCommunicationStepSize": can["every length"], "maxOutputDerivativeOrder": "0", "hasEventMode": "false",
        "providesDirectionalDerivatives": str(variables.derivable).lower(),
    })  # fmt: skip
    units = _units(variables.all)
    _write_units(root, units)
    types = ET.SubElement(root, "TypeDefinitions")
    enumerations = _enumerations(variables.all)
    for items, name in enumerations.items():
        kind = ET.SubElement(types, "EnumerationType", name=name)
        for item, value in items:
            ET.SubElement(kind, "Item", name=item, value=str(value))
    _write_log_categories(root)
    _write_experiment(root, system)
    listed, states = ET.SubElement(root, "ModelVariables"), dict(variables.derivatives)
    for reference, v in enumerate(variables.all):
        of_type = _value(v, units, enumerations, bounds=v.type in ("real", "integer"))
        text = of_type.pop("start", "") if v.type == "string" else ""
        element = ET.SubElement(listed, _TAGS_3[v.type], _attributes(v, reference) | of_type | _of_state(reference, states))
        if v.type == "string":
            ET.SubElement(element, "Start", value=text)
    structure = ET.SubElement(root, "ModelStructure")
    for tag, rows in (
        ("Output", outputs(variables)), ("ContinuousStateDerivative", derivatives(variables)),
        ("InitialUnknown", calculated_at_start(variables)),
    ):  # fmt: skip
        for reference, known in rows:
            ET.SubElement(structure, tag, {"valueReference": str(reference), **_known(known)})
    return _document(root)


def build_description(identity: Identity) -> bytes:
    """sources/buildDescription.xml, which FMI 2.0.4 takes over from FMI 3.0.

    Parameters
    ----------
    identity : Identity
        Its identifier and sources.

    Returns
    -------
    bytes
        The file.
    """
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identity.identifier)
    options = "-O3 -ffp-contract=off -fvisibility=hidden"
    files = ET.SubElement(configuration, "SourceFileSet", language="C99", compilerOptions=options)
    for source in identity.sources:
        ET.SubElement(files, "SourceFile", name=source)
    return _document(root)


def _document(root: ET.Element) -> bytes:
    ET.indent(root)
    content: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _about(system: System, variables: Variables, identity: Identity) -> dict[str, str]:
    plain = all(part.isidentifier() for v in variables.all for part in v.name.split("."))
    return {
        "modelName": system.name,
        "description": system.description,
        "generationTool": identity.tool,
        "variableNamingConvention": "structured" if plain else "flat",
    }


def _abilities(components: Sequence[Packed]) -> dict[str, str]:
    """What all components can, as XML writes it; `once`: what one of them cannot."""
    can = {
        "every length": all(part.model.can("canHandleVariableCommunicationStepSize") for part in components),
        "restore": all(part.slave.can_restore for part in components),
        "serialize": all(part.slave.can_serialize for part in components),
        "once": any(part.model.can("canBeInstantiatedOnlyOncePerProcess") for part in components),
    }
    return {name: str(value).lower() for name, value in can.items()}


def _units(variables: Sequence[Variable]) -> dict[str, Unit | None]:
    """Every unit in use with what it means. One name that two components define differently stays with the first."""
    found: dict[str, Unit | None] = {}
    for v in variables:
        if v.unit:
            found.setdefault(v.unit, meaning(v.unit, v.definition))
    return dict(sorted(found.items()))


def _write_units(root: ET.Element, units: Mapping[str, Unit | None]) -> None:
    parent = ET.SubElement(root, "UnitDefinitions")
    for name, unit in units.items():
        element = ET.SubElement(parent, "Unit", name=name)
        if unit is None:
            continue
        attributes = {base: str(e) for base, e in zip(BASE, unit.dimension, strict=True) if e}
        attributes |= {} if unit.factor == 1.0 else {"factor": repr(unit.factor)}
        attributes |= {} if unit.offset == 0.0 else {"offset": repr(unit.offset)}
        ET.SubElement(element, "BaseUnit", attributes)


def _enumerations(variables: Sequence[Variable]) -> dict[tuple[tuple[str, int], ...], str]:
    """Name of the type of each enumeration in use."""
    found: dict[tuple[tuple[str, int], ...], str] = {}
    for v in variables:
        if v.type == "enumeration":
            found.setdefault(v.items, "Algorithm" if v.kind == "algorithm" else f"Enumeration{len(found)}")
    return found


def _write_log_categories(root: ET.Element) -> None:
    parent = ET.SubElement(root, "LogCategories")
    for name, description in CATEGORIES.items():
        ET.SubElement(parent, "Category", name=name, description=description)


def _write_experiment(root: ET.Element, system: System) -> None:
    times = {"startTime": system.start, "stopTime": system.stop, "stepSize": system.step}
    ET.SubElement(root, "DefaultExperiment", {name: repr(float(value)) for name, value in times.items()})


def _attributes(v: Variable, reference: int) -> dict[str, str]:
    attributes = {"name": v.name, "valueReference": str(reference), "description": v.description}
    attributes |= {"causality": v.causality, "variability": v.variability}
    return attributes | ({"initial": v.initial} if v.initial else {})


def _of_state(reference: int, states: Mapping[int, int]) -> dict[str, str]:
    """The attribute of a derivative that names its state."""
    return {"derivative": str(states[reference])} if reference in states else {}


def _value(
    v: Variable, units: Mapping[str, Unit | None], enumerations: Mapping[tuple[tuple[str, int], ...], str], *, bounds: bool
) -> dict[str, str]:
    """The attributes that depend on the type."""
    found = {"declaredType": enumerations[v.items]} if v.type == "enumeration" else {"unit": v.unit} if v.unit else {}

    def text(value: float | str) -> str:
        if isinstance(value, str):
            return value
        return {"real": repr(float(value)), "boolean": str(bool(value)).lower()}.get(v.type, str(int(value)))

    if bounds:
        found |= {name: text(value) for name, value in (("min", v.min), ("max", v.max)) if value is not None}
    return found | ({"start": text(v.start)} if v.start is not None else {})


def _known(references: list[int] | None) -> dict[str, str]:
    return {} if references is None else {"dependencies": " ".join(map(str, references))}
