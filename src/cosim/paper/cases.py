"""The cases of the full vehicle, figures 6 to 10: which runs there are, how long they take, and what is recorded of them.

"Off" is 0 rpm, "on" 2000 rpm. The straight case runs at 50 m/s over five waves, the curve of 50 m at 5 and at 8 m/s. The ledger
runs two parameter sets from several starts; sensitivity/draws.py runs the same cases for draws from the open parameters.
"""

import multiprocessing
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from ..coupling import Jacobi
from ..master import Options, Progress, simulate
from ..master.recording import Recording
from ..railway.assessment import Assessment, assess
from ..ssp import system as named_system
from ..systems import System, catalogue
from ..trajectory import Trajectory

SETS = {"A": "Table 2's wheels", "B": "no spin inertia"}
SYSTEMS = {"A": "", "B": "-b"}
STRAIGHT, SLOW, FAST = 50, 5, 8  # m/s
SPINS = {"off": "0rpm", "on": "2000rpm"}
ALGORITHM = Jacobi(1)
RECORD = Recording(
    select=(
        "vehicle.body_distance", "vehicle.curvature", "vehicle.*_lateral_displacement", "vehicle.*_yaw_angle", "vehicle.*_climb",
        "vehicle.*_derailment_coefficient", "vehicle.*_lateral_force",
    ),
    every=2,
)  # fmt: skip


@dataclass(frozen=True)
class Extent:
    """How much is run.

    Parameters
    ----------
    straight
        Time on straight track, s, until what settles has settled.
    behind_slow, behind_fast
        Straight track behind the curve at 5 and at 8 m/s, m; y must return to 0 in the latter.
    starts
        Lateral displacement of the front pair at the start, one run each, since what hunts in the flanges is chaotic.
    """

    straight: float = 120.0
    behind_slow: float = 200.0
    behind_fast: float = 200.0
    starts: tuple[str, ...] = ("0mm", "0.1mm", "-0.1mm")


Key = tuple[str, int, str, int]  # parameter set, speed (m/s), gyro "off" or "on", number of the start


@dataclass(frozen=True, eq=False)
class Case:
    """One run of the ledger: which it was, its trajectory, and what that says of the vehicle."""

    key: Key
    trajectory: Trajectory
    assessment: Assessment


def ledger_keys(extent: Extent) -> list[Key]:
    """Every run of the ledger: one start on straight track, where nothing hunts that settles, all of them in the curve."""
    curve = [(s, v, g, k) for s in SETS for v in (SLOW, FAST) for g in SPINS for k in range(len(extent.starts))]
    return [*((s, STRAIGHT, g, 0) for s in SETS for g in SPINS), *curve]


def base(name: str, speed: int) -> System:
    """The built-in system of the set `name` for a speed."""
    return named_system(("lrt-straight" if speed == STRAIGHT else "lrt-curve") + SYSTEMS[name])


def with_case(plan: System, speed: int, gyro: str, start: str) -> System:
    """The system at the speed, with the gyro off or on, from the start."""
    values = {"vehicle.speed": float(speed), "gyro.rotor_speed": SPINS[gyro], "vehicle.front_lateral_displacement": start}
    for target, value in values.items():
        plan = plan.with_value(target, value)
    return plan


def seconds(speed: int, vehicle: Mapping[str, float], extent: Extent) -> float:
    """The length of a run (s): on straight track as `extent` says, else through the curve and the track behind it.

    vehicle : values of the vehicle's parameters, of which those of the standard curve are read.
    """
    if speed == STRAIGHT:
        return extent.straight
    behind = extent.behind_slow if speed == SLOW else extent.behind_fast
    return (vehicle["curve_start"] + 2 * vehicle["transition_length"] + vehicle["curve_length"] + behind) / speed


def run_all(extent: Extent, progress: Progress | None) -> dict[Key, Case]:
    """All runs of the ledger, on all cores. The FMUs are built here, once, before the processes begin."""
    keys = ledger_keys(extent)
    for source in sorted({part.source for key in keys for part in base(key[0], key[1]).components}):
        catalogue.fmu(source)
    cases: dict[Key, Case] = {}
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as pool:
        for case in pool.map(_run, keys, [extent] * len(keys)):
            cases[case.key] = case
            if progress is not None:
                progress(len(cases), len(keys))
    return cases


def _run(key: Key, extent: Extent) -> Case:
    name, speed, gyro, start = key
    plan = with_case(base(name, speed), speed, gyro, extent.starts[start])
    vehicle = {v.name: v.start for v in catalogue.component(plan.components[0].source).parameters}
    stop = seconds(speed, vehicle, extent)
    trajectory = simulate(plan, algorithm=ALGORITHM, stop=stop, options=Options(record=RECORD)).trajectory
    (assessment,) = assess(trajectory)
    return Case(key, trajectory, assessment)


def of_set(cases: Mapping[Key, Case], name: str, speed: int, gyro: str) -> Sequence[Any]:
    """The runs of a set, a speed and a state of the gyro, in the order of their starts."""
    return [case for key, case in sorted(cases.items()) if key[:3] == (name, speed, gyro)]
