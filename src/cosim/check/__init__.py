"""Whether an FMU, anyone's, keeps the standard: what validators find, and what they miss.

    for finding in check_fmu("gyro_unit.linear.fmu"):
        print(finding)

The file and its description are read here; the binary is loaded and called in a child process, so that a foreign one that
crashes, hangs or ends the process is a finding like any other. FMI 2.0 and 3.0: Co-Simulation, Model Exchange and, as far as a
model can be started by itself, Scheduled Execution; of FMI 1.0 the files.
"""

from pathlib import Path

from .findings import Finding, Severity

__all__ = ["Finding", "Severity", "check_fmu"]

TIMEOUT = 60.0  # s that one probe of the binary may take


def check_fmu(path: str | Path, *, timeout: float = TIMEOUT) -> list[Finding]:
    """What is wrong with an FMU, and what is worth knowing.

    Parameters
    ----------
    path
        Of the FMU.
    timeout
        How long one probe of the binary may take, s.

    Returns
    -------
    findings
        The worst first. Anything that is wrong with the file itself is a finding, too.

    Raises
    ------
    ValueError
        Where there is no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"FMU {str(path)!r} must be a file")
    if not timeout > 0.0:
        raise ValueError(f"timeout must be positive, got {timeout!r}")

    from . import archive, child, description
    from .findings import in_order

    found = archive.examined(path)
    if not any(f.rule == "archive" for f in found):
        model, problems = description.read(path)
        found += problems
        if model is not None:
            found += description.examined(model) + archive.binaries(path, model)
            found += child.examined(path, model, timeout)
    return in_order(found)
