"""Reference results inside an FMU: what the component gives in this package, for others to compare with."""

import io

import numpy as np

from gyro_cosim.component import Component
from gyro_cosim.component.do_step import macro_step
from gyro_cosim.component.integration import Progress, StepError, first_sample

__all__ = ["STEP", "STEPS", "csv", "inputs", "results"]

STEP, STEPS = 0.01, 100  # s, macro steps
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
