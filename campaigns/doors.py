"""The doors of the fuzzing campaign: what comes in from outside, what makes a mistake in it, and who reads it.

A door reads as its command does, so far that everything in the input has been looked at: names are looked up in a system, a short
run is made where that is what an input is for. Good inputs are made by this package, or stand here.
"""

import hashlib
import io
import json
import random
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mutation import Changed, of_archive, of_bytes, of_table, of_toml, of_xml

from gyro_cosim import System, fmus, open_network, simulate, sweep, system
from gyro_cosim.cli.reference import driven
from gyro_cosim.cli.reproduce import Made
from gyro_cosim.comparison.reference import Band, judged, read_reference
from gyro_cosim.errors import RunError
from gyro_cosim.master import Options
from gyro_cosim.master.checkpoint import MARK, Checkpoint, Resume
from gyro_cosim.railway import limits
from gyro_cosim.railway.acceptance import judge
from gyro_cosim.railway.assessment import assess
from gyro_cosim.report import Told, contents
from gyro_cosim.slaves.fmi import description
from gyro_cosim.slaves.fmi.signals import described
from gyro_cosim.slaves.processes.protocol import document
from gyro_cosim.slaves.processes.serving import read_values
from gyro_cosim.ssp import packing, reading
from gyro_cosim.ssp.parameter_files import read_parameters
from gyro_cosim.ssp.toml_files import read_system
from gyro_cosim.sweeps import Sweep, load
from gyro_cosim.sweeps.store import Store, journal_of
from gyro_cosim.systems import catalogue
from gyro_cosim.systems.scenario import read_scenario
from gyro_cosim.systems.series import read_inputs
from gyro_cosim.trajectory import Origin, Trajectory, read_results
from gyro_cosim.trajectory.origin import beside, parsed
from gyro_cosim.vehicle import profile_files
from gyro_cosim.vehicle.described.component import component_of_file
from gyro_cosim.vehicle.described.reading import read as read_vehicle

__all__ = ["Door", "doors"]

LIBRARY = Path(__file__).parent.parent / "vehicle" / "library"

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
EVENTS = b"""[[event]]
at = "2 ms"
set = "gyro.gimbal_damping"
to = 0.01

[[event]]
at = "4 ms"
ramp = "gyro.rotor_speed"
to = "200 rpm"
over = "5 ms"

[[event]]
at = "6 ms"
freeze = "vehicle.yaw_moment"
"""
DRIVEN = b"time,gyro.yaw_rate [rad/s]\n0,0\n0.005,1\n0.005,2\n0.01,3\n"
LIMITS = b"ratio = 1.2\nguiding_factor = 0.85\nwheel_load = 150e3\nlateral_rms = 0.4\nunloading = 0.6\n"
SIMPACK = b"""header.begin
  version  = 1
  type     = 0
header.end
spline.begin
  approx.smooth = 0.0
  units.len.f = 1000.0
  point.begin
{}
  point.end
spline.end
"""
SHORT = 0.01  # s, of the runs that a door makes


@dataclass(frozen=True)
class Door:
    """One kind of input: a good one, what makes a mistake in it, what reads it. ending : of the file that it stands in.

    share : of the campaign's inputs that are tried here, where one takes long.
    """

    good: bytes
    mutate: Callable[[bytes, random.Random], Changed]
    read: Callable[[Path], Any]
    ending: str
    share: float = 1.0


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


def _ran(plan: System, **how: Any) -> Any:
    """What comes of a short run."""
    return simulate(plan, step=1e-3, stop=SHORT, **how).trajectory


def _judged(file: Path) -> Any:
    run = read_results(file)
    return [judge(run, one) for one in assess(run)]


def _compared(file: Path, plan: System, run: Trajectory) -> Any:
    return judged(run, read_reference(file, plan), Band.of("1e-3"))


def _reported(file: Path) -> Any:
    run = read_results(file)
    return json.dumps(contents.recorded({"run": run}, Told(command="")), default=repr)


def _with_origin(file: Path, results: Path) -> Any:
    """What cosim reproduce makes of results beside which the origin lies."""
    place = file.with_name(f"{file.stem}.csv")
    shutil.copy(results, place)
    shutil.copy(file, beside(place))
    return replace(Made.of(place), file=Path())


def _kept(file: Path) -> Any:
    """The file of a sweep."""
    table = load(file)
    return table.head, {name: column.tolist() for name, column in table.values.items()}


def _taken_up(file: Path, head: dict[str, Any]) -> Any:
    """A sweep whose journal this is, taken up again."""
    goal = file.with_name(f"{file.stem}.npz")
    goal.unlink(missing_ok=True)
    shutil.copy(file, journal_of(goal))
    store = Store(goal, head["columns"], head["text"], head["definition"], extend=False)
    store.close()
    return sorted(store.done), load(goal).values if goal.exists() else None


def _of_checkpoint(data: bytes, rng: random.Random) -> Changed:
    """A checkpoint whose checksum is right, whatever it holds."""
    content, _ = of_archive(data[: -len(MARK) - 32], rng)
    return content + MARK + hashlib.sha256(content).digest(), False


def _vehicle_run(folder: Path) -> bytes:
    """Results that call their signals as those of a vehicle do."""
    outputs = catalogue.component("vehicle:lrt").outputs
    t = np.linspace(0.0, 1.2, 121)
    columns = [8.0 * t if v.name == "body_distance" else 0.1 * np.sin(3.0 * t + k) for k, v in enumerate(outputs)]
    run = Trajectory(t, tuple(f"vehicle.{v.name}" for v in outputs), tuple(v.unit for v in outputs), np.array(columns).T)
    run.save(folder / "vehicle.csv")
    return (folder / "vehicle.csv").read_bytes()


def _wheel() -> np.ndarray:
    """A wheel's profile, mm, shape (n, 2), y from the flange to the rim, z down."""
    y = np.linspace(-68.0, 60.0, 90)
    flange = 28.0 / (1.0 + np.exp((y + 42.0) / 3.0)) - 9.0 * np.maximum(0.0, (-58.0 - y) / 10.0) ** 2
    return np.stack([y, flange - y / 40.0], axis=1)


def doors(folder: Path) -> dict[str, Door]:
    """All of them; good inputs are made in `folder`."""
    return {**_of_systems(folder), **_of_results(folder), **_of_vehicles(folder)}


def _of_systems(folder: Path) -> dict[str, Door]:
    """Components, systems, and what drives them."""
    pair = system("wheel-pair")
    made = folder / "pair.ssp"
    packing.pack(pair, made)
    ours = Path(catalogue.fmu("gyro_unit:linear"))
    (third,) = fmus.export(catalogue.component("gyro_unit:linear"), folder, fmi=("3",))
    with zipfile.ZipFile(made) as archive:
        ssd = archive.read("SystemStructure.ssd")
    with zipfile.ZipFile(ours) as archive:
        second = archive.read("modelDescription.xml")
    with zipfile.ZipFile(third) as archive:
        newest = archive.read("modelDescription.xml")
    message = json.dumps({"values": {"speed": 1.0, "x": [1, 2]}, "t": 0.0, "stop": 1.0}).encode()
    alone = replace(pair, components=pair.components[1:], connections=(), bonds=())
    kept = folder / "kept.npz"
    simulate(pair, step=1e-3, stop=SHORT, options=Options(checkpoint=Checkpoint(kept, SHORT / 2)))
    return {
        "description-2": Door(second, of_xml, _described, ".xml"),
        "description-3": Door(newest, of_xml, _described, ".xml"),
        "fmu": Door(_small(ours.read_bytes()), of_archive, _fmu, ".fmu"),
        "ssd": Door(ssd, of_xml, reading.read, ".ssd"),
        "ssp": Door(_small(made.read_bytes()), of_archive, reading.read, ".ssp"),
        "toml-system": Door(SYSTEM, of_toml, read_system, ".toml"),
        "toml-scenario": Door(SCENARIO, of_toml, read_scenario, ".toml"),
        "toml-parameters": Door(PARAMETERS, of_toml, lambda file: _with_parameters(pair, file), ".toml"),
        "series": Door(SERIES, of_table, read_inputs, ".csv"),
        "message": Door(message, of_bytes, _message, ".json"),
        "run-system": Door(SYSTEM, of_toml, lambda file: _ran(read_system(file)), ".toml", 0.2),
        "run-scenario": Door(EVENTS, of_toml, lambda file: _ran(driven(pair, None, file)), ".toml", 0.2),
        "run-input": Door(DRIVEN, of_table, lambda file: _ran(driven(alone, [file], None)), ".csv", 0.2),
        "checkpoint": Door(
            kept.read_bytes(), _of_checkpoint, lambda file: _ran(pair, options=Options(resume=Resume(file))), ".npz", 0.2
        ),
    }


def _of_results(folder: Path) -> dict[str, Door]:
    """Results of runs and sweeps, and who reads them."""
    pair = system("wheel-pair")
    run = simulate(pair, stop=0.05).trajectory
    results = {}
    for ending in (".csv", ".mat", ".parquet", ".mf4"):
        try:
            run.save(folder / f"run{ending}")
            results[ending] = (folder / f"run{ending}").read_bytes()
        except (ValueError, ImportError, RunError):  # an extra that is not installed
            continue
    origin = Origin(("run", "x"), ".", {"a": "1"}, {}, {"a.y": "m"}).text().encode()
    again = Origin(("run", "wheel-pair", "--output", "run.csv"), ".", {"python": "3"}, {"wheel-pair": "0"}, {}).text().encode()
    table = folder / "sweep.csv"
    what = Sweep(pair, {"gyro.rotor_speed": "0rpm:100rpm:3"}, stop=SHORT)
    sweep(what, table, workers=1)
    sweep(what, folder / "sweep.npz", workers=1)
    held = load(table)
    columns = [held.values[name].tolist() for name in held.head["columns"]]
    journal = [held.head, *map(list, zip(*columns, strict=True))]
    lines = "".join(json.dumps(line) + "\n" for line in journal).encode()
    return {
        "origin": Door(origin, of_bytes, lambda file: parsed(file.read_text(encoding="utf-8"), "x"), ".json"),
        "reproduce": Door(again, of_bytes, lambda file: _with_origin(file, folder / "run.csv"), ".json", 0.3),
        **{
            f"results{ending}": Door(
                content, of_table if ending == ".csv" else of_bytes, read_results, ending, 0.02 if ending == ".mf4" else 1.0
            )
            for ending, content in results.items()
        },
        "reference": Door(results[".csv"], of_table, lambda file: _compared(file, pair, run), ".csv"),
        "report": Door(results[".csv"], of_table, _reported, ".csv", 0.3),
        "sweep.csv": Door(table.read_bytes(), of_table, _kept, ".csv"),
        "sweep.npz": Door((folder / "sweep.npz").read_bytes(), of_archive, _kept, ".npz"),
        "journal": Door(lines, of_bytes, lambda file: _taken_up(file, held.head), ".json", 0.3),
    }


def _of_vehicles(folder: Path) -> dict[str, Door]:
    """Vehicles, their profiles, and what judges their runs."""
    lrt, coach = ((LIBRARY / f"{name}.toml").read_bytes() for name in ("lrt", "manchester_1"))
    wheel = _wheel()
    rows = "\n".join(f"{y:.4f} {z:.4f}" for y, z in wheel)
    simpack = SIMPACK.replace(b"{}", rows.encode())
    miniprof = f"Filename=w\nColumnDef=X,Y\n32.5 28.0\n\n{rows}\n".encode()
    return {
        "toml-vehicle": Door(lrt, of_toml, read_vehicle, ".toml"),
        "toml-coach": Door(coach, of_toml, read_vehicle, ".toml"),
        "vehicle": Door(coach, of_toml, component_of_file, ".toml", 0.02),
        "profile.prw": Door(simpack, of_bytes, profile_files.read, ".prw"),
        "profile.whl": Door(miniprof, of_bytes, profile_files.read, ".whl"),
        "profile.csv": Door(rows.replace(" ", ",").encode(), of_table, profile_files.read, ".csv"),
        "limits": Door(LIMITS, of_toml, limits.read, ".toml"),
        "assess": Door(_vehicle_run(folder), of_table, _judged, ".csv", 0.2),
    }


def _small(data: bytes) -> bytes:
    """An archive without its large members: what is read of them here is their names."""
    target = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(target, "w") as other:
        for name in archive.namelist():
            content = archive.read(name)
            other.writestr(name, _small(content) if name.endswith(".fmu") else content if len(content) < 50_000 else b"large")
    return target.getvalue()
