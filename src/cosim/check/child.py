"""The binary in a child process: probes run one after the other there, and their findings come back through a file."""

import json
import signal
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..slaves.processes import child
from ..slaves.processes.telling import carried_values
from ..slaves.scratch import ScratchFolder
from ..slaves.signal import Value
from ..systems import archive as door
from .archive import INTERFACES
from .examined import GIVEN
from .findings import SEVERITIES, Finding, Findings

FIRST = "instance"  # the probe without which no other makes sense
PROBES = (
    FIRST, "start", "types", "events", "clocks", "scheduled", "derivatives", "dependencies", "sensitivities", "slope", "states",
    "instances", "reset", "bounds", "misuse",
)  # fmt: skip
WRONG_USE = "misuse"  # what an FMU does there is no fault: the standard forbids the calls, not the answers


def examined(path: Path, model: Any, timeout: float, values: Mapping[str, Value]) -> Findings:
    """What the probes find; a probe in which the child dies or hangs is told, and the others still run.

    values : start values in the place of the FMU's own.
    """
    import fmpy

    if model.fmiVersion.startswith("1"):
        return [Finding("binary", "FMI 1.0: only the files were checked, the binary was not run", "note")]
    identifier = next(i.modelIdentifier for i in (getattr(model, n) for n in INTERFACES) if i is not None)
    folder = fmpy.platform if model.fmiVersion.startswith("2") else fmpy.platform_tuple
    library = f"binaries/{folder}/{identifier}{fmpy.sharedLibraryExtension}"
    with door.opened(str(path)) as archive:
        if library not in archive.namelist():
            text = f"{library!r} is not there: the FMU cannot be run on this machine, only its files were checked"
            return [Finding("binary", text, "note")]
        with ScratchFolder() as scratch:
            unpacked = scratch / "fmu"
            door.unpack(archive, unpacked, [""])
            (scratch / GIVEN).write_text(json.dumps(carried_values(values)), encoding="utf-8")
            found: Findings = []
            waiting = list(PROBES)
            while waiting:
                ran, more, ending = _run(unpacked, waiting, timeout, scratch)
                found += more
                if ending:
                    probe = ran[-1] if ran else FIRST
                    text = f"after a wrong call {ending}" if probe == WRONG_USE else ending
                    found.append(Finding(probe, text, "warning" if probe == WRONG_USE else "fault"))
                if not ran or (ending and ran[-1] == FIRST):
                    break  # it cannot even be instantiated
                waiting = waiting[len(ran) :] if ending else []
    return found


def _wait(run: "subprocess.Popen[bytes]", report: Path, timeout: float) -> str:
    """Wait for the child as long as a new probe begins or a finding is told at least every `timeout` (s); how it failed to."""
    seen, since = 0, time.monotonic()
    while True:
        try:
            run.wait(0.2)
            return ""
        except subprocess.TimeoutExpired:
            size = report.stat().st_size
            if size != seen:
                seen, since = size, time.monotonic()
            elif time.monotonic() - since > timeout:
                return f"the binary does not come back within {timeout:g} s"


def _run(folder: Path, probes: list[str], timeout: float, scratch: Path) -> tuple[list[str], Findings, str]:
    """(probes begun, what they found, how the child ended if not well)."""
    report = scratch / "report"
    report.write_bytes(b"")
    with (scratch / "said").open("wb") as said:
        run = child.start("gyro_cosim.check.probes", (str(folder), str(report), *probes), words=said, folder=scratch)
        try:
            ending = _wait(run, report, timeout)
        finally:
            if run.poll() is None:
                run.kill()
            run.wait()
    if not ending and run.returncode < 0:
        number = -run.returncode
        name = signal.Signals(number).name if number in {s.value for s in signal.Signals} else str(number)
        ending = f"the binary crashes ({name})"
    elif not ending and run.returncode != 0:
        tail = (scratch / "said").read_bytes()[-2000:].decode(errors="replace").strip().splitlines()
        ending = f"the process that runs the binary ends with code {run.returncode}" + (f": {tail[-1]}" if tail else "")
    begun: list[str] = []
    found: Findings = []
    finished = False
    for line in report.read_bytes().decode(errors="replace").splitlines():
        try:
            kind, *rest = json.loads(line)
        except ValueError:
            continue  # a line cut off by a crash
        if kind == "begin":
            begun.append(rest[0])
        elif kind == "found" and len(rest) == 3 and rest[2] in SEVERITIES:
            found.append(Finding(str(rest[0]), str(rest[1]), rest[2]))
        elif kind == "end":
            finished = True
    if not finished and not ending:
        ending = "the binary ends the process"
    return begun, found, "" if finished else ending
