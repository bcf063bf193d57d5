"""The binary in a child process: probes run one after the other there, and their findings come back through a file."""

import json
import signal
import subprocess
import time
import zipfile
from pathlib import Path
from typing import Any

from ..slaves.processes import child
from ..slaves.scratch import ScratchFolder
from .archive import Findings

PROBES = ("instance", "start", "derivatives", "dependencies", "sensitivities", "slope", "states", "instances", "reset", "bounds")


def faults(path: Path, model: Any, timeout: float) -> Findings:
    """What the probes find; a probe in which the child dies or hangs is a fault, and the others still run."""
    import fmpy

    identifier = (model.coSimulation or model.modelExchange).modelIdentifier
    folder = fmpy.platform if model.fmiVersion.startswith("2") else fmpy.platform_tuple
    library = f"binaries/{folder}/{identifier}{fmpy.sharedLibraryExtension}"
    with zipfile.ZipFile(path) as archive:
        if library not in archive.namelist():
            return [("binary", f"{library!r} is not there: the FMU cannot be run on this machine, only its files were checked")]
        with ScratchFolder() as scratch:
            unpacked = scratch / "fmu"
            archive.extractall(unpacked)
            findings: Findings = []
            waiting = list(PROBES)
            while waiting:
                ran, more, ending = _run(unpacked, waiting, timeout, scratch)
                findings += more
                if ending:
                    findings.append((ran[-1] if ran else "instance", ending))
                if not ran or (ending and ran[-1] == "instance"):
                    break  # it cannot even be instantiated
                waiting = waiting[len(ran) :] if ending else []
    return findings


def _wait(run: "subprocess.Popen[bytes]", report: Path, timeout: float) -> str:
    """Wait for the child as long as a new probe begins or a fault is told at least every `timeout` (s); how it failed to."""
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
    findings: Findings = []
    finished = False
    for line in report.read_bytes().decode(errors="replace").splitlines():
        try:
            kind, *rest = json.loads(line)
        except ValueError:
            continue  # a line cut off by a crash
        if kind == "begin":
            begun.append(rest[0])
        elif kind == "fault":
            findings.append((str(rest[0]), str(rest[1])))
        elif kind == "end":
            finished = True
    if not finished and not ending:
        ending = "the binary ends the process"
    return begun, findings, "" if finished else ending
