"""modelDescription.xml of FMI 2.0: variables, units, types, dependencies and what the FMU can do."""

from collections.abc import Iterable
from xml.etree import ElementTree as ET

import numpy as np

from gyro_cosim.component.units import BASE, unit

from .table import Kind, Row, Table

__all__ = [
    "STOP_TIME", "bounds", "capabilities", "causality", "document", "fmi2", "identity", "log_categories", "quantities", "text",
    "unit_definitions", "unknowns",
]  # fmt: skip

CATEGORIES = {
    "logEvents": "samples of the sampled part",
    "logStatusDiscard": "why a call was refused or a step not done",
    "logStatusError": "why a call was wrong",
    "logStatusWarning": "what is not quite right",
}
QUANTITIES = {
    "m": "Length", "m/s": "Velocity", "m/s2": "Acceleration", "rad": "Angle", "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration", "N": "Force", "N.m": "Torque", "kg": "Mass", "kg.m2": "MomentOfInertia", "s": "Time",
    "J": "Energy", "W": "Power", "N/m": "Stiffness", "N.m/rad": "RotationalStiffness", "N.s/m": "Damping",
    "N.m.s/rad": "RotationalDamping", "1": "Number", "Hz": "Frequency", "Pa": "Pressure",
}  # fmt: skip
STOP_TIME = 10.0  # s, of the default experiment
TOLERANCE = 1e-8  # relative, of an importer's integrator: some states stay a thousand times below their nominal value


def text(value: float) -> str:
    """The shortest text that reads back as the same double."""
    return repr(float(value))


def document(root: ET.Element) -> bytes:
    """The XML file of `root`, the same bytes every time."""
    ET.indent(root)
    content: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def identity(table: Table, tool: str) -> dict[str, str]:
    """Attributes of the root element that FMI 2.0 and 3.0 share."""
    c = table.component
    return {
        "modelName": f"{c.name}.{c.variant}",
        "description": c.description,
        "license": "BSD-3-Clause",
        "generationTool": tool,
        "variableNamingConvention": "structured",
    }


def unit_definitions(table: Table) -> ET.Element:
    """Every unit that a variable has, as a product of SI base units, with the display units in use."""
    root = ET.Element("UnitDefinitions")
    for name in sorted({row.unit for row in table.rows}):
        element = ET.SubElement(root, "Unit", name=name)
        base = unit(name)
        exponents = {b: str(e) for b, e in zip(BASE, base.dimension, strict=True) if e}
        ET.SubElement(element, "BaseUnit", exponents)
        shown = {r.variable.display_unit for r in table.rows if r.variable and r.unit == name and r.variable.display_unit}
        for display in sorted(shown):
            d = unit(display)
            attributes = {"name": display, "factor": text(1.0 / d.factor)}
            if d.offset:
                attributes["offset"] = text(-d.offset / d.factor)
            ET.SubElement(element, "DisplayUnit", attributes)
    return root


def quantities(table: Table) -> dict[str, str]:
    """Name of the type definition for each unit that has one and is in use, in the order of the names."""
    used = {row.unit for row in table.rows}
    taken = {row.name for row in table.rows}
    return {u: name for u, name in sorted(QUANTITIES.items(), key=lambda item: item[1]) if u in used and name not in taken}


def log_categories() -> ET.Element:
    """The categories that core.h names."""
    root = ET.Element("LogCategories")
    for name, description in CATEGORIES.items():
        ET.SubElement(root, "Category", name=name, description=description)
    return root


def bounds(row: Row) -> dict[str, str]:
    """display unit, min, max, nominal of a row, where stated."""
    v = row.variable
    if v is None:
        return {}
    shown = {"displayUnit": v.display_unit} if v.display_unit else {}
    return shown | {
        key: text(value)
        for key, value in (("min", v.min), ("max", v.max), ("nominal", abs(v.nominal) if v.nominal else None))
        if value is not None
    }


def causality(row: Row) -> tuple[str, str, str | None]:
    """(causality, variability, initial) of a row."""
    v = row.variable
    if row.kind == "time":
        return "independent", "continuous", None
    if v is None:
        return "local", "continuous", "calculated"
    initial = {"input": None, "output": "calculated"}.get(row.kind, "exact")
    return v.causality, v.variability, initial


def unknowns(table: Table) -> dict[str, list[tuple[Row, list[Row]]]]:
    """The unknowns of the model structure with the variables each depends on: outputs, derivatives, initial unknowns."""
    c = table.component
    derivatives = [(table.of("derivative", i), _known(table, c.rhs, i)) for i in table.continuous]
    outputs = []
    for i, v in enumerate(c.outputs):
        if v.is_state:
            state = table.of("output", i)
            outputs.append((state, [state] if v.variability == "continuous" else []))
        else:
            outputs.append((table.of("output", i), _known(table, c.output, i)))
    at_start = [(row, None) for row, _ in (*outputs, *derivatives) if row.kind != "state"]
    initial = []
    for row, _ in at_start:
        function = c.output if row.kind == "output" else c.rhs
        initial.append((row, _known(table, function, row.index, start=True)))
    return {
        "outputs": [(row, _while_running(known)) for row, known in outputs],
        "derivatives": [(row, _while_running(known)) for row, known in derivatives],
        "initial": initial,
    }


def _known(table: Table, function: object, row: int, *, start: bool = False) -> list[Row]:
    """The variables that element `row` of a function's result depends on; parameters only at the start."""
    kinds: list[Kind] = ["state", "input", *(["parameter"] if start else [])]  # type: ignore[list-item]
    known = []
    for argument, kind in enumerate(kinds):
        sparsity = function.jac_sparsity(0, argument)  # type: ignore[attr-defined]
        columns = np.array(sparsity.get_col(), dtype=int)[np.array(sparsity.row(), dtype=int) == row]
        known += [table.of(kind, int(i)) for i in sorted(columns)]
    return sorted(known, key=lambda row: table.reference[row.name])


def _while_running(known: list[Row]) -> list[Row]:
    """Without discrete states, which are no knowns once the simulation runs."""
    return [k for k in known if not (k.kind == "state" and k.variable and k.variable.variability == "discrete")]


def capabilities(identifier: str) -> dict[str, str]:
    """Attributes of both interfaces of FMI 2.0."""
    return {
        "modelIdentifier": identifier,
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    }


def fmi2(table: Table, identifier: str, token: str, tool: str, output_order: int, sources: Iterable[str]) -> bytes:
    """modelDescription.xml of FMI 2.0.

    Parameters
    ----------
    table : Table
        The FMU's variables.
    identifier, token, tool : str
        The model identifier, the guid, and who made the FMU.
    output_order : int
        Highest time derivative of the outputs that the FMU gives.
    sources : iterable of str
        The C files to compile, empty where none are shipped.

    Returns
    -------
    bytes
        The file.
    """
    root = ET.Element("fmiModelDescription", {"fmiVersion": "2.0", **identity(table, tool), "guid": token})
    root.set("numberOfEventIndicators", "0")
    sources = list(sources)
    more = {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": str(output_order),
    }
    for name, attributes in (
        ("ModelExchange", {**capabilities(identifier), "completedIntegratorStepNotNeeded": "true"}),
        ("CoSimulation", capabilities(identifier) | more),
    ):
        interface = ET.SubElement(root, name, attributes)
        if sources:
            files = ET.SubElement(interface, "SourceFiles")
            for source in sources:
                ET.SubElement(files, "File", name=source)
    root.append(unit_definitions(table))
    types = ET.SubElement(root, "TypeDefinitions")
    named = quantities(table)
    for of, name in named.items():
        ET.SubElement(ET.SubElement(types, "SimpleType", name=name), "Real", quantity=name, unit=of)
    root.append(log_categories())
    step = text(table.component.internal_step)
    experiment = {"startTime": "0.0", "stopTime": text(STOP_TIME), "tolerance": text(TOLERANCE), "stepSize": step}
    ET.SubElement(root, "DefaultExperiment", experiment)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, row in enumerate(table.rows):
        if row.kind != "time":  # optional in FMI 2.0, and FMI Library wants a start value that it must not have
            variables.append(_variable(table, reference, row, named))
    structure = ET.SubElement(root, "ModelStructure")
    for tag, key in (("Outputs", "outputs"), ("Derivatives", "derivatives"), ("InitialUnknowns", "initial")):
        rows = unknowns(table)[key]
        parent = ET.SubElement(structure, tag) if rows else None
        for row, known in rows:
            assert parent is not None
            dependencies = " ".join(str(table.reference[k.name]) for k in known)  # time has reference 0 and no place in the list
            ET.SubElement(parent, "Unknown", index=str(table.reference[row.name]), dependencies=dependencies)
    return document(root)


def _variable(table: Table, reference: int, row: Row, named: dict[str, str]) -> ET.Element:
    kind, variability, initial = causality(row)
    attributes = {"name": row.name, "valueReference": str(reference), "description": row.description}
    attributes |= {"causality": kind, "variability": variability} | ({"initial": initial} if initial else {})
    element = ET.Element("ScalarVariable", attributes)
    real = {"declaredType": named[row.unit]} if row.unit in named else {}
    real |= {"unit": row.unit} | bounds(row)
    if row.variable is not None and initial != "calculated":
        real["start"] = text(row.variable.start)
    if row.kind == "derivative":
        real["derivative"] = str(table.reference[table.of("state", row.index).name])
    ET.SubElement(element, "Real", real)
    return element
