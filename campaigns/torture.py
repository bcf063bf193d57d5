"""Hostile FMUs, in process and isolated: what is kept of a run, and how it ends, whatever an FMU does.

    python campaigns/torture.py [KIND ...]      all kinds, some minutes on two cores; `make torture`

Each kind is an FMU of tests/support/hostile.py that misbehaves in one way at one place, beside one that behaves. `cosim run`
runs both as the shell would. A run is right if the points before the misbehaviour are in the file of results, the exit code is 0
only where all points are, one line says what happened where it is not, no traceback is shown, and no process and no temporary
folder is left. Where a process cannot survive by itself, BEYOND says why: there the exit code and the line must be right all the
same, and nothing may be left; the results are kept with --isolate. Exit code 1 if anything is wrong.
"""

import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import hostile

from gyro_cosim.ssp.packing import pack

WORST = (
    "segv", "abort", "exit0", "exit3", "_exit0", "hang", "busy", "illegal", "stack", "kill", "deaf-hang", "double-free",
    "scribble",
)  # fmt: skip
AT_STEP = (
    "null-call", "divide", "bus", "_exit3", "terminate", "memory", "nan", "infinite", "twin", "status2", "status3", "status4",
    "status5", "status99", "status-1", "log-escape", "log-null", "log-nobody", "log-percent", "log-status", "log-long",
    "half-frame", "false-frame", "garbage", "pickle", "close-all", "parent", "parent-term", "thread-crash", "alarm", "traps",
)  # fmt: skip
HARMLESS = (
    "chdir", "umask", "environment", "locale", "rounding", "flush", "orphan", "handlers", "ignore", "timer", "close-0",
    "no-files", "stdout", "stdout-later", "stderr", "files", "fork", "daemon", "threads", "thread-log", "status1", "log-million",
    "no-size",
)  # fmt: skip
KINDS = (
    "good@nowhere", "nothing@instantiate", "at-exit@instantiate",
    *(f"{b}@step" for b in (*WORST, *AT_STEP)), *(f"{b}@instantiate" for b in HARMLESS),
    *(f"{b}@{hook}" for b in ("segv", "exit0", "hang") for hook in ("load", "initialize", "get", "terminate", "free", "unload")),
)  # fmt: skip
BEYOND = {
    "_exit0@step": "_exit asks nobody", "_exit3@step": "_exit asks nobody", "kill@step": "SIGKILL asks nobody",
    "deaf-hang@step": "it hears no signal", "busy@step": "", "scribble@step": "the memory that writing needs is spoilt",
    "double-free@step": "the memory that writing needs is spoilt", "memory@step": "no memory is left to write with",
    "close-all@step": "the files are closed under it", "terminate@step": "",
    "traps@step": "every sum is a crash", "half-frame@step": "it hangs", "thread-crash@step": "the crash comes at any time",
    "no-size@instantiate": "nothing can be written", "no-files@instantiate": "no file can be opened",
    "alarm@step": "SIGALRM ends a process", "parent-term@step": "it asks for the end of the run",
}  # fmt: skip
SETUP = ("load", "instantiate", "initialize")
AT_ONCE = 4  # runs
GIVE_UP, MEMORY = 8.0, 3 << 30  # s after which Ctrl-C is pressed; bytes that a process may have
PROGRAM = (
    "import sys, gyro_cosim.slaves.processes.isolated as i; i.IsolatedSlave.__init__.__defaults__ = (5.0,); i.PATIENCE = 15.0;"
    "from gyro_cosim.cli import main; sys.exit(main())"
)


def run(kind: str, *options: str) -> tuple[str, str]:
    """(what came of it, what is wrong about it or empty)."""
    with tempfile.TemporaryDirectory() as scratch:
        folder, place = Path(scratch).resolve(), Path(scratch).resolve() / "temporary"
        place.mkdir()
        pack(hostile.system(folder, kind), folder / "system.ssp")
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, "run", "system.ssp", "--output", "out.csv", *options],
            cwd=folder, env={**os.environ, "TMPDIR": str(place)}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            text=True, errors="replace", start_new_session=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY)),
        )  # fmt: skip
        began, err = time.monotonic(), ""
        for wait in (GIVE_UP, 60.0):
            try:
                err = process.communicate(timeout=wait)[1]
                break
            except subprocess.TimeoutExpired:
                if not options:
                    os.killpg(process.pid, signal.SIGINT)
        else:
            os.killpg(process.pid, signal.SIGKILL)
            err = process.communicate()[1]
            return "hangs", "does not end"
        file = folder / "out.csv"
        rows = len(file.read_text().splitlines()) - 1 if file.exists() else 0
        outcome = f"exit {process.returncode}, {rows} points, {time.monotonic() - began:.0f} s"
        lines = [line for line in err.splitlines() if line.startswith("cosim: ")]
        faults = []
        needed = _needed(kind, options)
        if process.returncode == 0 and rows != hostile.STEPS + 1:
            faults.append("exit code 0 without all results")
        if rows < needed:
            faults.append(f"{needed} points must be kept")
        if process.returncode != 0 and len(lines) != 1:
            faults.append(f"{len(lines)} lines say what happened")
        if "Traceback" in err:
            faults.append("a traceback")
        if left := [p.name for p in Path("/proc").glob("[0-9]*") if _folder(p) == folder]:
            faults.append(f"{len(left)} processes are left")
            for pid in left:
                os.kill(int(pid), signal.SIGKILL)
        if left := [p.name for p in place.iterdir() if p.name.startswith("cosim-")]:
            faults.append(f"{len(left)} temporary folders are left")
        return outcome, "; ".join(faults)


def _needed(kind: str, options: tuple[str, ...]) -> int:
    """How many points of the run must be kept."""
    behaviour, hook = kind.split("@")
    if behaviour in HARMLESS or hook in ("nowhere", "terminate", "free", "unload"):
        return 0 if kind in BEYOND and not options else hostile.STEPS + 1
    if hook in SETUP or (kind in BEYOND and not options):
        return 0
    return hostile.AT - (hook == "get") * 1


def _folder(process: Path) -> Path | None:
    try:
        return (process / "cwd").readlink()
    except OSError:
        return None


def main(chosen: list[str]) -> int:
    """The table, and whether all is right."""
    kinds = chosen or list(KINDS)
    verdicts: Counter[str] = Counter()
    print(f"{'kind':24s} {'in process':30s} {'isolated':30s}")
    with ThreadPoolExecutor(AT_ONCE) as pool:
        begun = [[pool.submit(run, kind, *options) for options in ((), ("--isolate",))] for kind in kinds]
        for kind, (first, second) in zip(kinds, begun, strict=True):
            here, there = first.result(), second.result()
            told = [fault for _, fault in (here, there) if fault]
            verdicts.update({"in process": not here[1], "isolated": not there[1]})
            note = f"  WRONG: {' | '.join(told)}" if told else f"  ({BEYOND[kind]})" if BEYOND.get(kind) else ""
            print(f"{kind:24s} {here[0]:30s} {there[0]:30s}{note}", flush=True)
    print(f"{len(kinds)} kinds: right in process {verdicts['in process']}, isolated {verdicts['isolated']}")
    return 0 if min(verdicts["in process"], verdicts["isolated"]) == len(kinds) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
