"""Reference results inside an FMU: what the component gives in this package, for others to compare with."""

import io
import xml.etree.ElementTree as ET

import numpy as np

from gyro_cosim.component import Component
from gyro_cosim.component.do_step import macro_step
from gyro_cosim.component.integration import Progress, StepError, first_sample

__all__ = ["FOLDER", "MANIFEST", "STEP", "STEPS", "csv", "inputs", "manifest", "results"]

STEP, STEPS = 0.01, 100  # s, macro steps
FOLDER = "documentation/reference"
MANIFEST = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"  # where FMI-LS-REF looks for it
AMPLITUDE = 0.1  # of an input's nominal value


def inputs(component: Component) -> tuple[list[str], np.ndarray]:
    """Header and rows (t in s, u), shape (STEPS + 1, 1 + n_u): sines of 1 Hz, 1.3 Hz, ... about the start values."""
    t = np.arange(STEPS + 1) * STEP
    columns = [t]
    for i, v in enumerate(component.inputs):
        amplitude = AMPLITUDE * abs(v.nominal or 1.0)
        columns.append(v.start + amplitude * np.sin(2 * np.pi * (1.0 + 0.3 * i) * t))
    return ["time", *(v.name for v in component.inputs)], np.column_stack(columns)


def results(component: Component) -> tuple[list[str], np.ndarray]:
    """Header and rows (t in s, y), shape (n, 1 + n_y), with those inputs held over each step of STEP.

    n is STEPS + 1, or less if the model fails before the end.

    An output at t is the value before the input of that moment is set, as an importer reads it after the step.
    """
    rows = inputs(component)[1]
    x, p = component.start_state, component.start_parameters
    progress = Progress(first_sample(component.sample_period, 0.0))
    y = np.array(component.output(x, component.start_input, p)).ravel()
    table = [[0.0, *y]]
    for row in rows[:-1]:
        U = np.zeros((len(component.inputs), 3))
        U[:, 0] = row[1:]
        try:
            step = component.internal_step
            x, progress = macro_step(component, x, U, p, row[0], STEP, internal_step=step, progress=progress)
        except StepError:
            break
        table.append([row[0] + STEP, *np.array(component.output(x, U[:, 0], p)).ravel()])
    return ["time", *(v.name for v in component.outputs)], np.array(table)


def csv(header: list[str], rows: np.ndarray) -> bytes:
    """A comma-separated file whose numbers read back as the same doubles."""
    text = io.StringIO()
    text.write(",".join(f'"{name}"' for name in header) + "\n")
    for row in rows:
        text.write(",".join(repr(float(value)) for value in row) + "\n")
    return text.getvalue().encode()


def manifest(identifier: str) -> bytes:
    """The manifest of the layered standard FMI-LS-REF (1.0.0-alpha.1), by which an importer finds the reference results."""
    space = "http://fmi-standard.org/fmi-ls-manifest"
    ET.register_namespace("fmi-ls", space)
    described = "Layered Standard providing information on related files included in an FMU."
    root = ET.Element("fmiReferences", {
        f"{{{space}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref", f"{{{space}}}fmi-ls-version": "1.0.0-alpha.1",
        f"{{{space}}}fmi-ls-description": described,
    })  # fmt: skip
    for suffix, role, what in (
        ("in", "testcase", f"Inputs of the reference results, held over each step of {STEP:g} s"),
        ("ref", "result", f"Outputs under these inputs, at steps of {STEP:g} s"),
    ):
        place = f"../../{FOLDER}/{identifier}_{suffix}.csv"
        ET.SubElement(root, "Related", type="text/csv", source=place, role=role, description=what)
    ET.indent(root)
    data: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return data
