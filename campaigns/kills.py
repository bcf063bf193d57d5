"""kill -9 at random instants: whatever it hits, the command goes on from what is there, and ends in the same bytes.

    python campaigns/kills.py [--kills N] [--seed K] [SCENARIO ...]      300 kills some 20 minutes on one core; Linux

Each scenario is a command, run undisturbed once, which says how long it takes and what it leaves. Then it is started again and
again, with --resume where there is a checkpoint, and SIGKILL is sent at an instant drawn from the whole of that time: to the
command, to one of the processes that it has started, or to all of them at once. After one to three kills it is left to its end.

    ends        with exit code 0
    same        results are, byte by byte, those of the undisturbed run; of a sweep the rows, but for the time they took
    nothing     besides these files is in its folder, or in the folder of temporary files
    nobody      of its processes lives three seconds after its end

The last two hold after the last kill, the last one after each. Exit code 1 where there are findings.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from powerloss import contents, rows

LONGEST = 120.0  # s that a command may take
GONE_WITHIN = 3.0  # s, as Python takes to start, in which the processes of a command that was killed must be gone


@dataclass(frozen=True)
class Scenario:
    """A command, the files of results that it is for, and where its checkpoint is, if it writes one."""

    command: tuple[str, ...]
    results: tuple[str, ...]
    resumed: str = ""


RUN = ("run", "wheel-pair", "--gyro", "nonlinear", "--checkpoint", "c.npz")
SCENARIOS = {
    "streamed": Scenario((*RUN, "--stop", "40", "--every", "1", "--output", "r.csv"), ("r.csv",), "c.npz"),
    "whole": Scenario(
        (*RUN, "--stop", "40", "--every", "1", "--record-every", "10", "--output", "r.csv", "--output", "r.mat"),
        ("r.csv", "r.mat"), "c.npz",
    ),
    "isolated": Scenario((*RUN, "--stop", "3", "--every", "0.2", "--isolate", "--output", "r.csv"), ("r.csv",), "c.npz"),
    "sweep": Scenario(
        ("sweep", "wheel-pair", "--set", "gyro.rotor_speed=0rpm:300rpm:40", "--stop=10", "--workers=2", "--output", "s.npz"),
        ("s.npz",),
    ),
}  # fmt: skip


class Place:
    """A folder in which a command is run, and one for its temporary files."""

    def __init__(self, scratch: Path, scenario: Scenario) -> None:
        self._scenario = scenario
        self.folder, self.temporary = scratch / "folder", scratch / "temporary"
        for made in (self.folder, self.temporary):
            made.mkdir()

    def start(self) -> "subprocess.Popen[bytes]":
        """The command, in a session of its own, going on from its checkpoint where there is one."""
        checkpoint = self._scenario.resumed
        resume = ("--resume", checkpoint) if checkpoint and (self.folder / checkpoint).exists() else ()
        with (self.folder.parent / "said").open("wb") as said:
            return subprocess.Popen(
                [sys.executable, "-m", "gyro_cosim", *self._scenario.command, *resume], cwd=self.folder, start_new_session=True,
                env={**os.environ, "TMPDIR": str(self.temporary)}, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
            )  # fmt: skip

    def said(self) -> str:
        """The last line of the last command."""
        return " ".join((self.folder.parent / "said").read_text(errors="replace").splitlines()[-1:])[:200]

    def left(self) -> list[str]:
        """What is in the folders besides results, and what tells of them."""
        allowed = {self._scenario.resumed, *(n for r in self._scenario.results for n in (r, f"{r}.origin.json"))}
        return sorted((contents(self.folder).keys() - allowed) | {p.name for p in self.temporary.iterdir()})


def of_session(leader: int) -> list[int]:
    """The processes of a session that live."""
    alive = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, session = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
        except OSError:  # gone meanwhile
            continue
        if int(session) == leader and state != "Z":
            alive.append(int(entry.name))
    return alive


def killed(place: Place, rng: random.Random, taken: float) -> tuple[str, str]:
    """(whom SIGKILL has hit, what is wrong or empty)."""
    process = place.start()
    whom = rng.choice(("command", "child", "all"))
    at = rng.uniform(0.0, taken)
    try:
        process.wait(at)
        whom = "over"
    except subprocess.TimeoutExpired:
        alive = of_session(process.pid)
        children = [pid for pid in alive if pid != process.pid]
        for pid in {"command": [process.pid], "child": [rng.choice(children)] if children else [process.pid], "all": alive}[whom]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                whom = "nobody"
    return whom, ended(process)


def ended(process: "subprocess.Popen[bytes]") -> str:
    """What is wrong about the end of a command: it does not come, or somebody stays."""
    fault = ""
    try:
        process.wait(LONGEST)
    except subprocess.TimeoutExpired:
        fault = f"no end within {LONGEST:g} s"
    end = time.monotonic() + GONE_WITHIN
    while (alive := of_session(process.pid)) and time.monotonic() < end:
        time.sleep(0.01)
    for pid in alive:
        os.kill(pid, signal.SIGKILL)
    process.wait()
    return fault or (f"{len(alive)} processes are left" if alive else "")


def campaign(scenario: Scenario, kills: int, rng: random.Random) -> tuple[Counter[str], list[str]]:
    """(whom the kills have hit, findings) of a scenario."""
    hit: Counter[str] = Counter()
    findings = []
    with tempfile.TemporaryDirectory() as scratch:
        for name in ("warm", "undisturbed"):  # the first builds what is built once
            (Path(scratch) / name).mkdir()
            undisturbed = Place(Path(scratch) / name, scenario)
            began = time.monotonic()
            process = undisturbed.start()
            assert not ended(process), undisturbed.said()
            assert process.returncode == 0, undisturbed.said()
            taken = time.monotonic() - began
        goal = _results(undisturbed.folder, scenario)
        done = 0
        while done < kills:
            (Path(scratch) / "place").mkdir()
            place = Place(Path(scratch) / "place", scenario)
            history, faults = [], []
            for _ in range(min(kills - done, rng.randint(1, 3))):
                whom, fault = killed(place, rng, taken)
                hit[whom] += 1
                history.append(whom)
                faults += [fault] if fault else []
            done += len(history)
            process = place.start()
            fault = ended(process)
            faults += [fault] if fault else []
            if process.returncode != 0:
                faults.append(f"exit code {process.returncode}: {place.said()}")
            elif _results(place.folder, scenario) != goal:
                faults.append("other results")
            elif place.left():
                faults.append(f"left behind: {', '.join(place.left())}")
            if faults:
                findings.append(f"kills {done - len(history) + 1} to {done} ({', '.join(history)}): {'; '.join(faults)}")
            shutil.rmtree(place.folder.parent)
    return hit, findings


def _results(folder: Path, scenario: Scenario) -> list[object]:
    found = [folder / name for name in scenario.results]
    return [rows(file) if file.suffix == ".npz" else file.read_bytes() if file.exists() else None for file in found]


def main() -> int:
    """Exit code 1 where there are findings."""
    parser = argparse.ArgumentParser(description="kill -9 at random instants")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help=", ".join(SCENARIOS))
    parser.add_argument("--kills", type=int, default=300, help="in all")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    names = chosen.scenarios or list(SCENARIOS)
    total: Counter[str] = Counter()
    wrong = 0
    for k, name in enumerate(names):
        began = time.perf_counter()
        count = (chosen.kills * (k + 1)) // len(names) - (chosen.kills * k) // len(names)
        hit, findings = campaign(SCENARIOS[name], count, random.Random(f"{chosen.seed} {name}"))
        total += hit
        wrong += len(findings)
        told = ", ".join(f"{whom} {n}" for whom, n in sorted(hit.items()))
        print(f"{name:<10} {count:4d} kills, {time.perf_counter() - began:5.0f} s: {told}; {len(findings)} findings", flush=True)
        for finding in findings[:10]:
            print(f"    {finding}", flush=True)
    reached = sum(n for whom, n in total.items() if whom not in ("over", "nobody"))
    print(f"{reached} of {sum(total.values())} kills came before the end: {wrong} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
