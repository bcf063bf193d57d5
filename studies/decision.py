"""Is the unit worth its mass? The vehicle without it, with the unit at rest, with it spinning, and with a yaw damper instead.

For both kinds of wheels, three creep laws, and curves of four radii at three speeds: in what share of starts does a wheel leave its
rail? "No unit" is the vehicle without the 1200 kg, which is what somebody would build who does not believe in the unit. Starts are
drawn evenly within 1 mm of lateral displacement of each wheel pair; shares have Wilson's interval at 95 %. A run goes on for 250 m
of straight track behind the curve. Stopped, it goes on; --starts 100 adds to the starts that are done.
Some 2 minutes on two cores for each start of every cell. Run: python studies/decision.py [--starts N] [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim import System, SystemComponent, system
from gyro_cosim.railway.assessment import assess
from gyro_cosim.sweeps import Measure, Sweep, load, sweep
from gyro_cosim.systems import StopWhen
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set

SHORT = "--short" in sys.argv
STARTS = int(sys.argv[sys.argv.index("--starts") + 1]) if "--starts" in sys.argv else 2 if SHORT else 10
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
SYSTEMS = {"A": "lrt-curve", "B": "lrt-curve-b"}
LAWS = {"Polach": "lrt", "Shen-Hedrick-Elkins": "lrt_shen_hedrick_elkins", "FASTSIM": "lrt_fastsim"}
speeds = "5,8" if SHORT else "5,8,11"  # m/s
radii = "50m" if SHORT else "30m,50m,100m,200m"
BEFORE, BEHIND = 20.0, 250.0  # m of straight track before the entry transition and behind the curve
TOLERANCE, SEED = 1e-3, 1  # m, of a wheel pair's place at the start, as `cosim run --robust` assumes it
BARE = {f"vehicle.{part}_gimbal_{what}": 0.0 for part in ("inner", "outer") for what in ("mass", "ixx", "izz")}
BARE |= {"vehicle.outer_gimbal_iyy": 0.0}
DAMPER = {"vehicle.pivot_damping": 5e3, "vehicle.bogie_mass": 540.0, "vehicle.bogie_izz": 444.7}  # 40 kg at 1 m: rivals.py
ALONE = {"no unit": BARE, "yaw damper": BARE | DAMPER}
WITH_UNIT = {"at rest": {"gyro.rotor_speed": 0.0}, "spinning": {"gyro.rotor_speed": "2000rpm"}}
COLUMNS = {"derailed": "1", "at": "m", "ratio": "1", "climb": "1", "late": "m"}


def verdict(trajectory: Trajectory) -> dict[str, float]:
    """Derailed, where the run ended, largest Y/Q by EN 14363, farthest climb of a flange, largest |y| over the last 50 m."""
    (vehicle,) = assess(trajectory)
    s = trajectory["vehicle.body_distance"]
    y = [np.abs(trajectory[f"vehicle.{pair}_lateral_displacement"][s > s[-1] - 50.0]).max() for pair in ("front", "rear")]
    return {
        "derailed": float(vehicle.verdict.derailed), "at": float(s[-1]),
        "ratio": vehicle.worst.value if vehicle.worst else np.nan,
        "climb": max(float(trajectory[f"vehicle.{wheel}_climb"].max()) for wheel in vehicle.wheels), "late": max(y),
    }  # fmt: skip


def runs(name: str, law: str, units: dict[str, dict[str, Any]], alone: bool) -> Any:
    """The rows of all starts, speeds and radii of some units."""
    values = parameter_set(name).vehicle
    length = BEFORE + 2 * values["transition_length"] + values["curve_length"] + BEHIND
    base = system(SYSTEMS[name]).with_source("vehicle", LAWS[law])
    for key, value in {**values, "curve_turn": 1.0, "curve_start": BEFORE}.items():
        base = base.with_value(f"vehicle.{key}", value)
    if alone:
        (vehicle,) = (c for c in base.components if c.name == "vehicle")
        base = System("alone", (vehicle,), (), stop_when=base.stop_when)
    end = StopWhen(("vehicle", "body_distance"), length, "end of the track")
    plan = replace(base, stop_when=(*base.stop_when, end))
    places = np.random.default_rng(SEED).uniform(-TOLERANCE, TOLERANCE, (STARTS, 2))
    cases = {f"{unit}, {k}": set_to | {"vehicle.front_lateral_displacement": y[0], "vehicle.rear_lateral_displacement": y[1]}
             for k, y in enumerate(places.tolist()) for unit, set_to in units.items()}  # fmt: skip
    what = Sweep(plan, {"vehicle.speed": speeds, "vehicle.curve_radius": radii}, cases=cases,
                 stop=1.2 * length / min(map(float, speeds.split(","))), signals=("vehicle.body_distance",),
                 measure=Measure(verdict, COLUMNS))  # fmt: skip
    file = FOLDER / f"decision-{name}-{LAWS[law]}-{'alone' if alone else 'unit'}.npz"
    outcome = sweep(what, file, extend=True)
    print(f"{name} {law} {'alone' if alone else 'unit'}: {outcome.done} now, {outcome.before} before, {outcome.failed} failed, "
          f"{outcome.seconds:.0f} s, {outcome.way}", flush=True)
    return load(file)


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in SYSTEMS:
        for law in LAWS:
            for units, alone in ((ALONE, True), (WITH_UNIT, False)):
                table = runs(name, law, units, alone)
                kind = np.array([case.partition(",")[0] for case in table["case"]])
                for unit in units:
                    words = []
                    for radius in np.unique(table["vehicle.curve_radius"]):
                        for v in np.unique(table["vehicle.speed"]):
                            chosen = (kind == unit) & (table["vehicle.curve_radius"] == radius) & (table["vehicle.speed"] == v)
                            words.append(f"{radius:g}/{v:g}: {table['derailed'][chosen].sum():.0f}/{chosen.sum()}")
                    print(name, law, unit, "; ".join(words), flush=True)
