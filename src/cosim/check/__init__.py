"""Whether an FMU, anyone's, keeps the standard: what validators find, and what they miss.

    for fault in check("gyro_unit.linear.fmu"):
        print(fault)

The file and its description are read here; the binary is loaded and called in a child process, so that a foreign one that
crashes, hangs or ends the process is a fault like any other. FMI 2.0 and 3.0, Co-Simulation and Model Exchange.
"""

from dataclasses import dataclass
from pathlib import Path

__all__ = ["Fault", "check_fmu"]

TIMEOUT = 60.0  # s that one probe of the binary may take


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong.

    Parameters
    ----------
    rule
        Which check says so.
    message
        Names the thing, what must hold and what is, in one line.
    """

    rule: str
    message: str

    def __str__(self) -> str:
        return f"{self.rule}: {self.message}"


def check_fmu(path: str | Path, *, timeout: float = TIMEOUT) -> list[Fault]:
    """The faults of an FMU.

    Parameters
    ----------
    path
        Of the FMU.
    timeout
        How long one probe of the binary may take, s.

    Returns
    -------
    faults
        Empty where there are none; anything that is wrong with the file itself is a fault.

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

    findings = archive.faults(path)
    if not any(rule == "archive" for rule, _ in findings):
        model, problems = description.read(path)
        findings += problems
        if model is not None:
            findings += description.faults(model) + archive.binary_faults(path, model)
            findings += child.faults(path, model, timeout)
    lines = [Fault(rule, " ".join(message.split())) for rule, message in findings]
    return list(dict.fromkeys(lines))
