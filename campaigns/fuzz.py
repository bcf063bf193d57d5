"""Doors under mutated input: whatever comes in, a value comes out, or one line that says what is wrong.

    python campaigns/fuzz.py [--inputs N] [--seed K] [--keep FOLDER] [DOOR ...]      `make fuzz`

Every door reads one kind of input. Of a good one, N are made with a mistake in each, by a generator seeded with K, the door and
the number, so that any can be made again. An input is

    read       the door takes it
    refused    in one line: a ValueError or RunError without a line break
    silent     a key, element or attribute is misspelt, and the door takes it without a word, but reads something else than before
    traceback  any other error, or one of more than a line
    hang       10 s and no end
    memory     more than 1 GB
    crash      the process is gone

The last five are findings: written to FOLDER with the number that makes them again, and exit code 1.
"""

import argparse
import io
import json
import logging
import os
import random
import resource
import signal
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from mutation import Changed, of_archive, of_bytes, of_table, of_toml, of_xml

from gyro_cosim import System, fmus, open_network, simulate, system
from gyro_cosim.errors import RunError
from gyro_cosim.slaves.fmi import description
from gyro_cosim.slaves.fmi.signals import described
from gyro_cosim.slaves.processes.protocol import document
from gyro_cosim.slaves.processes.serving import read_values
from gyro_cosim.ssp import packing, reading
from gyro_cosim.ssp.parameter_files import read_parameters
from gyro_cosim.ssp.toml_files import read_system
from gyro_cosim.systems import catalogue
from gyro_cosim.systems.scenario import read_scenario
from gyro_cosim.systems.series import read_inputs
from gyro_cosim.trajectory import read_results
from gyro_cosim.trajectory.origin import parsed

LONGEST, MEMORY = 10, 1 << 30  # s; bytes over what the process needs anyway
FINDINGS = ("silent", "traceback", "hang", "memory", "crash")
ROOT = Path(__file__).parent.parent

SCENARIO = b"""[[event]]
at = "10 s"
set = "gyro.gimbal_damping"
to = 0.01

[[event]]
at = "12 s"
ramp = "gyro.rotor_speed"
to = "200 rpm"
over = "5 s"

[[event]]
at = "20 s"
freeze = "vehicle.yaw_moment"
"""
SYSTEM = b"""name = "pair"
step = "1 ms"
stop = "10 s"
connections = [ "vehicle.yaw_rate -> gyro.yaw_rate", { from = "gyro.yaw_moment", to = "vehicle.yaw_moment", factor = 1.0 } ]

[components.vehicle]
source = "vehicle:wheel_pair"
parameters = { speed = "36 km/h" }

[components.gyro]
source = "gyro_unit:linear"

[[stop_when]]
signal = "vehicle.lateral_displacement"
above = 0.005
says = "the flange touches"
"""
PARAMETERS = b"""[gyro]
rotor_speed = "100 rpm"
gimbal_stiffness = "0.0045 N.m/rad"

[vehicle]
speed = "10.0 m/s"
"""
SERIES = b"time,gyro.yaw_rate [rad/s],u\n0,0,1\n0.5,1,2\n0.5,2,2\n1,3,4\n"


@dataclass(frozen=True)
class Door:
    """One kind of input: a good one, what makes a mistake in it, what reads it. ending : of the file that it stands in."""

    good: bytes
    mutate: Callable[[bytes, random.Random], Changed]
    read: Callable[[Path], Any]
    ending: str


class _Heard(logging.Handler):
    """Whether anything was said."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.said = False

    def emit(self, record: logging.LogRecord) -> None:
        """Take note."""
        self.said = True


def _described(file: Path) -> Any:
    model = description.parse(str(file), file.read_bytes())
    return model, described(model)


def _fmu(file: Path) -> Any:
    model = description.read(str(file))
    return model, described(model)


def _message(file: Path) -> Any:
    told = document(file.read_bytes())
    return read_values(told.get("values"))


def _with_parameters(plan: System, file: Path) -> Any:
    """The system with what a parameter file sets, opened: names are looked up then."""
    for target, value in read_parameters(file, plan):
        plan = plan.with_value(target, value)
    with open_network(plan) as network:
        return network.values


def doors(folder: Path) -> dict[str, Door]:
    """All of them; good inputs are made in `folder`."""
    pair = system("wheel-pair")
    made = folder / "pair.ssp"
    packing.pack(pair, made)
    ours = Path(catalogue.fmu("gyro_unit:linear"))
    (third,) = fmus.export(catalogue.component("gyro_unit:linear"), folder, fmi=("3",))
    run = simulate(pair, stop=0.05)
    results = {}
    for ending in (".csv", ".mat", ".parquet", ".mf4"):
        try:
            run.trajectory.save(folder / f"run{ending}")
            results[ending] = (folder / f"run{ending}").read_bytes()
        except (ValueError, ImportError, RunError):  # an extra that is not installed
            continue
    with zipfile.ZipFile(made) as archive:
        ssd = archive.read("SystemStructure.ssd")
    with zipfile.ZipFile(ours) as archive:
        second = archive.read("modelDescription.xml")
    with zipfile.ZipFile(third) as archive:
        newest = archive.read("modelDescription.xml")
    origin = json.dumps({"gyro_cosim_origin": 1, "command": ["run", "x"], "folder": ".", "versions": {"a": "1"}, "hashes": {},
                         "units": {"a.y": "m"}}).encode()  # fmt: skip
    message = json.dumps({"values": {"speed": 1.0, "x": [1, 2]}, "t": 0.0, "stop": 1.0}).encode()
    small = _small(ours.read_bytes())
    found = {
        "description-2": Door(second, of_xml, _described, ".xml"),
        "description-3": Door(newest, of_xml, _described, ".xml"),
        "fmu": Door(small, of_archive, _fmu, ".fmu"),
        "ssd": Door(ssd, of_xml, reading.read, ".ssd"),
        "ssp": Door(_small(made.read_bytes()), of_archive, reading.read, ".ssp"),
        "toml-system": Door(SYSTEM, of_toml, read_system, ".toml"),
        "toml-scenario": Door(SCENARIO, of_toml, read_scenario, ".toml"),
        "toml-parameters": Door(PARAMETERS, of_toml, lambda file: _with_parameters(pair, file), ".toml"),
        "series": Door(SERIES, of_table, read_inputs, ".csv"),
        "origin": Door(origin, of_bytes, lambda file: parsed(file.read_text(encoding="utf-8"), "x"), ".json"),
        "message": Door(message, of_bytes, _message, ".json"),
        **{f"results{ending}": Door(content, of_table if ending == ".csv" else of_bytes, read_results, ending)
           for ending, content in results.items()},
    }  # fmt: skip
    library = ROOT / "vehicle" / "library" / "lrt.toml"
    if library.is_file():
        from gyro_cosim.vehicle.described.reading import read as read_vehicle

        found["toml-vehicle"] = Door(library.read_bytes(), of_toml, read_vehicle, ".toml")
    return found


def _small(data: bytes) -> bytes:
    """An archive without its large members: what is read of them here is their names."""
    target = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(target, "w") as other:
        for name in archive.namelist():
            content = archive.read(name)
            other.writestr(name, _small(content) if name.endswith(".fmu") else content if len(content) < 50_000 else b"large")
    return target.getvalue()


def made(door: Door, name: str, seed: int, number: int) -> Changed:
    """The input of a number."""
    return door.mutate(door.good, random.Random(f"{seed} {name} {number}"))


def judged(door: Door, file: Path, content: Changed, expected: str) -> tuple[str, str]:
    """What becomes of an input, and the error's words. expected : the good input as it is read."""
    data, misspelt = content
    file.write_bytes(data)
    heard = _Heard()
    logger = logging.getLogger("gyro_cosim")
    logger.addHandler(heard)
    try:
        found = door.read(file)
        told = heard.said or bool(getattr(found, "notes", ()))
        told = told or (isinstance(found, tuple) and bool(getattr(found[0], "schema_faults", ())))  # which a run tells
        silent = misspelt and not told and _shown(found) != expected
        return ("silent", "a misspelt name was taken, and what it stood for was not") if silent else ("read", "")
    except _Hang:
        return "hang", f"no end within {LONGEST} s"
    except MemoryError:
        return "memory", "more than 1 GB"
    except (ValueError, RunError) as error:
        return ("traceback", f"more than a line: {str(error)!r}") if "\n" in str(error) else ("refused", str(error))
    except Exception as error:
        return "traceback", f"{type(error).__name__}: {error}"
    finally:
        logger.removeHandler(heard)


class _Hang(BaseException):
    """An input that takes too long."""


def _late(number: int, frame: Any) -> None:
    raise _Hang


def _shown(found: Any) -> str:
    with np.printoptions(threshold=sys.maxsize):
        return repr(found)


def some(name: str, door: Door, seed: int, numbers: range, folder: Path, at: Any, results: Any) -> None:
    """A process: judges the inputs of some numbers, and says at which it is, should it end."""
    logging.getLogger("gyro_cosim").setLevel(logging.INFO)
    logging.getLogger("gyro_cosim").propagate = False
    data = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5]) * os.sysconf("SC_PAGE_SIZE")
    limit = data + MEMORY
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    signal.signal(signal.SIGALRM, _late)
    file = folder / f"input-{os.getpid()}{door.ending}"
    file.write_bytes(door.good)
    expected = _shown(door.read(file))
    for number in numbers:
        at.value = number
        signal.alarm(LONGEST)
        try:
            outcome = judged(door, file, made(door, name, seed, number), expected)
        except _Hang:
            outcome = "hang", f"no end within {LONGEST} s"
        finally:
            signal.alarm(0)
        results.put((number, *outcome))
    results.put(None)


def campaign(name: str, door: Door, seed: int, count: int, folder: Path) -> tuple[Counter[str], list[tuple[int, str, str]]]:
    """(how many of each outcome, the findings as (number, outcome, words)) of a door."""
    context = get_context("fork")
    outcomes: Counter[str] = Counter()
    findings = []
    first = 0
    while first < count:
        at, results = context.Value("l", first), context.SimpleQueue()
        process = context.Process(target=some, args=(name, door, seed, range(first, count), folder, at, results))
        process.start()
        results._writer.close()  # so that the reader hears of the end
        try:
            while (told := results.get()) is not None:
                number, outcome, words = told
                outcomes[outcome] += 1
                first = number + 1
                if outcome in FINDINGS:
                    findings.append((number, outcome, words))
            first = count
        except EOFError:
            outcomes["crash"] += 1
            findings.append((at.value, "crash", "the process is gone"))
            first = at.value + 1
        process.join()
    return outcomes, findings


def main() -> int:
    """Exit code 1 where there are findings."""
    parser = argparse.ArgumentParser(description="doors under mutated input")
    parser.add_argument("doors", nargs="*")
    parser.add_argument("--inputs", type=int, default=2000, help="of each door")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="a folder for what was found")
    chosen = parser.parse_args()
    total: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        there = doors(Path(scratch))
        for name in chosen.doors or there:
            began = time.perf_counter()
            outcomes, findings = campaign(name, there[name], chosen.seed, chosen.inputs, Path(scratch))
            total += outcomes
            told = ", ".join(f"{outcome} {n}" for outcome, n in sorted(outcomes.items()))
            print(f"{name:<16} {sum(outcomes.values()):>7} inputs, {time.perf_counter() - began:5.0f} s: {told}", flush=True)
            for number, outcome, words in findings[:5]:
                print(f"    {outcome} {number}: {' '.join(words.split())[:160]}", flush=True)
            if chosen.keep is not None:
                for number, outcome, _ in findings:
                    chosen.keep.mkdir(parents=True, exist_ok=True)
                    content, _ = made(there[name], name, chosen.seed, number)
                    (chosen.keep / f"{name}-{outcome}-{number}{there[name].ending}").write_bytes(content)
    wrong = sum(total[outcome] for outcome in FINDINGS)
    print(f"{sum(total.values())} inputs over {len(chosen.doors or there)} doors: {wrong} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
