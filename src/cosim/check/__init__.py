"""Whether an FMU, anyone's, keeps the standard: what validators find, and what they miss.

    for finding in check_fmu("gyro_unit.linear.fmu"):
        print(finding)

The file and its description are read here; the binary is loaded and called in a child process, so that a foreign one that
crashes, hangs or ends the process is a finding like any other. FMI 2.0 and 3.0: Co-Simulation, Model Exchange and, as far as a
model can be started by itself, Scheduled Execution; of FMI 1.0 the files.
"""

from collections.abc import Mapping
from pathlib import Path

from ..slaves.signal import Value
from .findings import Finding, Severity

__all__ = ["Finding", "Severity", "check_fmu"]

TIMEOUT = 60.0  # s that one probe of the binary may take


def check_fmu(path: str | Path, *, timeout: float = TIMEOUT, values: Mapping[str, Value] | None = None) -> list[Finding]:
    """What is wrong with an FMU, and what is worth knowing.

    Parameters
    ----------
    path
        Of the FMU.
    timeout
        How long one probe of the binary may take, s.
    values
        With which the binary is tried in the place of its start values, by name, in the FMU's own units.

    Returns
    -------
    findings
        The worst first. Anything that is wrong with the file itself is a finding, too.

    Raises
    ------
    ValueError
        Where there is no such file, or values are given that a check cannot give: of structural parameters and clocks.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"FMU {str(path)!r} must be a file")
    if not timeout > 0.0:
        raise ValueError(f"timeout must be positive, got {timeout!r}")

    from . import archive, child, description
    from .findings import in_order

    given = _whole(path, values) if values else {}
    found = archive.examined(path)
    if not any(f.rule == "archive" for f in found):
        model, problems = description.read(path)
        found += problems
        if model is not None:
            found += description.examined(model) + archive.binaries(path, model)
            found += child.examined(path, model, timeout, given)
    return in_order(found)


def _whole(path: Path, values: Mapping[str, Value]) -> dict[str, Value]:
    """The values by variable, of arrays as a whole."""
    from ..slaves.fmi.description import load
    from ..slaves.fmi.signals import by_variable
    from ..slaves.fmi.structure import STRUCTURAL

    found: dict[str, Value] = {}
    for row, elements in by_variable({row.name: row for row in load(str(path)).rows}, values):
        if row.causality == STRUCTURAL or row.type == "Clock":
            what = "a structural parameter" if row.causality == STRUCTURAL else "the interval of a clock"
            raise ValueError(f"a check must be given start values, {row.name!r} is {what}")
        found[row.name] = tuple(elements) if row.shape else elements[0]  # type: ignore[arg-type]
    return found
