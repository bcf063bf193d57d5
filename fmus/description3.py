"""modelDescription.xml, buildDescription.xml and terminalsAndIcons.xml of FMI 3.0."""

from xml.etree import ElementTree as ET

from .description import (
    STOP_TIME,
    TOLERANCE,
    bounds,
    causality,
    document,
    identity,
    log_categories,
    quantities,
    text,
    unit_definitions,
    unknowns,
)
from .table import Row, Table

__all__ = ["ICON", "build_description", "fmi3", "terminals"]

ICON = "icon"  # base name of the pictures in terminalsAndIcons


def fmi3(table: Table, identifier: str, token: str, tool: str, output_order: int) -> bytes:
    """modelDescription.xml of FMI 3.0; parameters as `description.fmi2`, `token` being the instantiation token."""
    root = ET.Element("fmiModelDescription", {"fmiVersion": "3.0", **identity(table, tool), "instantiationToken": token})
    shared = {
        "modelIdentifier": identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
    }
    ET.SubElement(root, "ModelExchange", shared)
    more = {
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": str(output_order),
        "providesIntermediateUpdate": "true",
        "mightReturnEarlyFromDoStep": "false",
        "canReturnEarlyAfterIntermediateUpdate": "true",
        "hasEventMode": "false",
    }
    ET.SubElement(root, "CoSimulation", shared | more)
    root.append(unit_definitions(table))
    types = ET.SubElement(root, "TypeDefinitions")
    named = quantities(table)
    for of, name in named.items():
        ET.SubElement(types, "Float64Type", name=name, quantity=name, unit=of)
    root.append(log_categories())
    step = text(table.component.internal_step)
    experiment = {"startTime": "0.0", "stopTime": text(STOP_TIME), "tolerance": text(TOLERANCE), "stepSize": step}
    ET.SubElement(root, "DefaultExperiment", experiment)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, row in enumerate(table.rows):
        variables.append(_variable(table, reference, row, named))
    structure = ET.SubElement(root, "ModelStructure")
    structured = unknowns(table)
    for tag, key in (("Output", "outputs"), ("ContinuousStateDerivative", "derivatives"), ("InitialUnknown", "initial")):
        for row, known in structured[key]:
            dependencies = " ".join(str(table.reference[k.name]) for k in known)
            ET.SubElement(structure, tag, valueReference=str(table.reference[row.name]), dependencies=dependencies)
    return document(root)


def _variable(table: Table, reference: int, row: Row, named: dict[str, str]) -> ET.Element:
    kind, variability, initial = causality(row)
    attributes = {"name": row.name, "valueReference": str(reference), "description": row.description}
    attributes |= {"causality": kind, "variability": variability} | ({"initial": initial} if initial else {})
    if row.kind in ("input", "output", "state"):
        attributes["intermediateUpdate"] = "true"
    attributes |= ({"declaredType": named[row.unit]} if row.unit in named else {}) | {"unit": row.unit} | bounds(row)
    if row.variable is not None and initial != "calculated":
        attributes["start"] = text(row.variable.start)
    if row.kind == "derivative":
        attributes["derivative"] = str(table.reference[table.of("state", row.index).name])
    return ET.Element("Float64", attributes)


def build_description(identifier: str, sources: list[str]) -> bytes:
    """sources/buildDescription.xml, which FMI 2.0.4 takes over from FMI 3.0."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    options = "-O3 -ffp-contract=off -fvisibility=hidden"
    files = ET.SubElement(configuration, "SourceFileSet", language="C99", compilerOptions=options)
    for source in sources:
        ET.SubElement(files, "SourceFile", name=source)
    return document(root)


def terminals(table: Table) -> bytes:
    """terminalsAndIcons/terminalsAndIcons.xml: one terminal for each connector of the component's power bonds."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = ET.SubElement(root, "GraphicalRepresentation")
    box = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    ET.SubElement(picture, "CoordinateSystem", {**box, "suggestedScalingFactorTo_mm": "0.1"})
    ET.SubElement(picture, "Icon", box)
    connectors = list(dict.fromkeys(bond.connector for bond in table.component.bonds))
    if connectors:
        parent = ET.SubElement(root, "Terminals")
    for connector in connectors:
        bonds = [b for b in table.component.bonds if b.connector == connector]
        about = "; ".join(f"{b.axis}: {b.motion} times {b.effort} is a power" for b in bonds)
        terminal = ET.SubElement(parent, "Terminal", name=connector, matchingRule="plug", description=about)
        for name in (name for bond in bonds for name in (bond.motion, bond.effort)):
            ET.SubElement(terminal, "TerminalMemberVariable", variableName=name, memberName=name, variableKind="signal")
    return document(root)
