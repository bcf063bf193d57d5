"""Loss of power, simulated: at every call by which a command changes its files the power goes, and what was not on the disk.

    python campaigns/powerloss.py [--seeds N] [--most N] [--forget WHAT] [SCENARIO ...]      some minutes on one core; Linux

Each scenario is a command, run once with c/recorder.c preloaded and once without. From the record lossy_disk.py makes every state
in which the files can be found, had the power gone at any call: nothing of what was not forced to the disk is there, all of it,
its names without its data, and draws of N seeds. In each state

    whole     results, checkpoint and sweep are not there, as before, or as the command had them at some time; an origin beside
              results is theirs
    again     the command, with --resume where there is a checkpoint, ends with exit code 0, in the same bytes as undisturbed,
              and nothing else is in the folder (of a sweep: the same rows but for the time they took)
    kept      at the end, what the command has said to have written is there

--most N draws so many of the states by chance, for a short campaign. --forget files, folders or both leaves out what the command
does to force them to the disk: findings must come then, or the campaign is blind. Exit code 1 where there are findings.
"""

import argparse
import contextlib
import io
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from lossy_disk import Call, Disk, cuts, record, replayed, stages

from gyro_cosim.cli import main as cosim
from gyro_cosim.fmus.compiler import compile_libraries, host
from gyro_cosim.sweeps import load

RUN = ("run", "wheel-pair", "--stop", "0.4", "--every", "0.1")
SWEEP = ("sweep", "wheel-pair", "--stop", "0.05", "--workers", "1", "--lanes", "1", "--output", "s.npz", "--set")


@dataclass(frozen=True)
class Scenario:
    """A command, and what must hold of its files.

    before : commands whose files are there, on the disk, when it begins. resumed : where its checkpoint is, if it writes one.
    results : the files that it is for.
    """

    command: tuple[str, ...]
    results: tuple[str, ...]
    before: tuple[tuple[str, ...], ...] = ()
    resumed: str = ""


OLD = ("run", "wheel-pair", "--stop", "0.1", "--set", "gyro.rotor_speed=0", "--output")
SCENARIOS = {
    "first run": Scenario((*RUN, "--checkpoint", "c.npz", "--output", "r.csv"), ("r.csv",), resumed="c.npz"),
    "over older": Scenario(
        (*RUN, "--checkpoint", "c.npz", "--output", "r.csv", "--output", "r.mat"), ("r.csv", "r.mat"),
        ((*OLD, "r.csv", "--output", "r.mat"),), resumed="c.npz",
    ),
    "two folders": Scenario((*RUN, "--checkpoint", "states/c.npz", "--output", "r.csv"), ("r.csv",), resumed="states/c.npz"),
    "lengthened": Scenario(
        (*RUN, "--checkpoint", "c.npz", "--output", "r.csv"), ("r.csv",),
        (("run", "wheel-pair", "--stop", "0.2", "--every", "0.1", "--checkpoint", "c.npz", "--output", "r.csv"),),
        resumed="c.npz",
    ),
    "sweep": Scenario((*SWEEP, "gyro.rotor_speed=0rpm:300rpm:5"), ("s.npz",)),
    "longer sweep": Scenario(
        (*SWEEP, "gyro.rotor_speed=0rpm:300rpm:5", "--extend"), ("s.npz",), ((*SWEEP, "gyro.rotor_speed=0rpm:300rpm:3"),)
    ),
}  # fmt: skip


class Laboratory:
    """Where the scenarios are played: scratch folders, and the recorder."""

    def __init__(self, scratch: Path) -> None:
        self._scratch = scratch.resolve()
        self._count = 0
        source = Path(__file__).parent / "c" / "recorder.c"
        shutil.copy(source, self._scratch)
        options = ("-w", "-std=gnu11")
        made = compile_libraries(
            self._scratch, {"recorder.c": "-O1"}, "recorder", {host(): True}, libraries=("dl",), options=options
        )
        self._recorder = self._scratch / f"recorder{host().suffix}"
        self._recorder.write_bytes(made[host()])

    def folder(self, files: dict[str, bytes] | None = None) -> Path:
        """A new one, with `states` in it and these files."""
        self._count += 1
        made = self._scratch / f"folder-{self._count}"
        (made / "states").mkdir(parents=True)
        for name, content in (files or {}).items():
            (made / name).write_bytes(content)
        return made

    def begun(self, scenario: Scenario) -> Path:
        """A folder in which its command can begin."""
        made = self.folder()
        for command in scenario.before:
            code, said = called(made, command)
            assert code == 0, said
        return made

    def recorded(self, scenario: Scenario, folder: Path) -> list[Call]:
        """The calls of its command, run in a folder."""
        file = self._scratch / "record"
        file.unlink(missing_ok=True)
        environment = {
            **os.environ, "LD_PRELOAD": str(self._recorder), "RECORD_UNDER": str(folder), "RECORD_TO": str(file)
        }  # fmt: skip
        subprocess.run(
            [sys.executable, "-m", "gyro_cosim", *scenario.command], cwd=folder, env=environment, check=True, capture_output=True
        )
        return record(file, folder)


def called(folder: Path, command: Iterable[str]) -> tuple[int, str]:
    """(exit code, what it said) of a command, in a fork of this process: what it needs is loaded already."""
    reading, writing = os.pipe()
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        code = 99
        with contextlib.suppress(BaseException), os.fdopen(writing, "w") as said:
            os.chdir(folder)
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
                code = cosim(tuple(command))
        os._exit(code)
    os.close(writing)
    with os.fdopen(reading) as said:
        text = said.read()
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), " ".join(text.split())


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def rows(file: Path) -> list[object]:
    """Those of a sweep in the order of their keys, without the time that each took: workers end in any order."""
    table = load(file)
    table = table.where(table["run"].argsort())
    return [[name, column.tolist()] for name, column in table.values.items() if name != "wall_s"]


class Judge:
    """What must hold of a scenario's files in every state."""

    def __init__(self, laboratory: Laboratory, scenario: Scenario, forget: str = "") -> None:
        self._laboratory, self._scenario = laboratory, scenario
        folder = laboratory.begun(scenario)
        self.disk = Disk(folder)
        self.calls = laboratory.recorded(scenario, folder)
        self._end, self._stages = contents(folder), stages(self.disk, self.calls)
        assert replayed(self.disk, self.calls).now() == self._end, "the record must tell all that the command has done"
        for name in scenario.results:
            self._stages.setdefault(name, set())
        if forget in ("files", "both"):
            self.calls = [c for c in self.calls if c.what != "S" or not Path(c.path).suffix]
        if forget in ("folders", "both"):
            self.calls = [c for c in self.calls if c.what != "S" or Path(c.path).suffix]
        undisturbed = laboratory.begun(scenario)
        code, said = called(undisturbed, scenario.command)
        assert code == 0, said
        self._goal = contents(undisturbed)
        self._rows = rows(undisturbed / "s.npz") if "s.npz" in scenario.results else None
        shutil.rmtree(folder)
        shutil.rmtree(undisturbed)

    def faults(self, state: dict[str, bytes], *, over: bool) -> list[str]:
        """What is wrong in a state. over : the command had ended."""
        told = []
        for name, whole in self._stages.items():
            if not name.endswith(".lock") and state.get(name) is not None and state[name] not in whole:
                told.append(f"{name} is torn")
            if over and state.get(name) != self._end.get(name):
                told.append(f"{name} is lost")
        for name in self._scenario.results:
            origin = state.get(f"{name}.origin.json")
            if name in state and origin is not None and not told and not self._belong(name, state[name], origin):
                told.append(f"{name} is told to come from elsewhere")
        return told or self._again(state)

    def _belong(self, name: str, results: bytes, origin: bytes) -> bool:
        """Whether an origin is that of the results it lies beside."""
        told, ours = (json.loads(text)["command"] for text in (origin, self._end[f"{name}.origin.json"]))
        return (told == ours) == (results == self._end[name])

    def _again(self, state: dict[str, bytes]) -> list[str]:
        folder = self._laboratory.folder(state)
        try:
            resumed = self._scenario.resumed
            resume = ("--resume", resumed) if resumed in state else ()
            code, said = called(folder, (*self._scenario.command, *resume))
            if code != 0:
                return [f"exit code {code}: {said}"]
            found = contents(folder)
            told = [f"{name} is there besides" for name in sorted(found.keys() - self._goal.keys())]
            told += [f"{name} is missing" for name in sorted(self._goal.keys() - found.keys())]
            if self._rows is not None:
                return told + (["other rows"] if rows(folder / "s.npz") != self._rows else [])
            compared = [name for name in self._goal if name in found and name in self._scenario.results]
            return told + [f"{name} differs" for name in compared if found[name] != self._goal[name]]
        finally:
            shutil.rmtree(folder)


def main() -> int:
    """Exit code 1 where there are findings."""
    parser = argparse.ArgumentParser(description="loss of power at every call")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help=", ".join(SCENARIOS))
    parser.add_argument("--seeds", type=int, default=3, help="draws at each call")
    parser.add_argument("--most", type=int, help="so many states of each scenario, drawn by chance")
    parser.add_argument("--forget", choices=("files", "folders", "both"), default="", help="what is not forced to the disk")
    chosen = parser.parse_args()
    total = wrong = 0
    with tempfile.TemporaryDirectory() as scratch:
        laboratory = Laboratory(Path(scratch))
        for name in chosen.scenarios or SCENARIOS:
            began = time.perf_counter()
            judge = Judge(laboratory, SCENARIOS[name], chosen.forget)
            states = list(cuts(judge.disk, judge.calls, chosen.seeds))
            drawn = states if chosen.most is None else random.Random(name).sample(states, min(chosen.most, len(states)))
            findings = [(k, fate, judge.faults(state, over=k == len(judge.calls))) for k, fate, state in drawn]
            findings = [one for one in findings if one[2]]
            total, wrong = total + len(drawn), wrong + len(findings)
            took = time.perf_counter() - began
            print(f"{name:<13} {len(judge.calls):4d} calls, {len(drawn):5d} states, {took:4.0f} s: {len(findings)} findings")
            for k, fate, faults in findings[:5]:
                print(f"    before call {k}, {fate}: {'; '.join(faults)[:200]}")
            sys.stdout.flush()
    print(f"{total} states: {wrong} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
