"""Gyro, inerter or yaw damper: what stabilises the vehicle, in the curve and on straight track, and what does it weigh?

Below the rate k/c of its gimbal the gyro is an added yaw inertia H^2/k. So is an inerter, at a fortieth of the mass; a yaw damper
is what the vehicle lacks. Both stand between bogie and car body, where the paper's vehicle has nothing; the gyro stands on the
wheel frame and needs nothing to push against. Every row has its own mass; "no unit" has none.
Straight track from eigenvalues; the curve by co-simulation of the FMUs, as sweeps: one that is stopped goes on where it was.
Some minutes on two cores. Run: python studies/rivals.py [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim import System, SystemComponent, figures, system
from gyro_cosim.railway.assessment import assess
from gyro_cosim.railway.yaw_damper import needed_damping
from gyro_cosim.railway.yaw_stability import wheel_pair
from gyro_cosim.stability import AtRest
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.systems import StopWhen
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.reduction import reduced_values

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM, H = np.pi / 30, 22.04 * 2000 * np.pi / 30  # rad/s; N m s
STIFFNESS = 2.04 * 86700.0 * 0.3**2  # N m, of set A's gimbal
PER_MASS, ARM = (
    90.0,
    1.0,
)  # inertance of an inerter over its mass (1), measured; lever arm of the devices about the pivot (m), assumed
SMALL, LARGE = H**2 / STIFFNESS, PER_MASS * ARM**2 * 600.0  # kg m2: that of the gyro, and that of the gyro's mass
DAMPERS, DAMPER_MASS = (5e3, 3e4, 1e5), 40.0  # N m s/rad: two of 2.5, 15 or 50 kN s/m at 1 m; kg, both of a pair: assumed
SOFT = {"gyro.gimbal_stiffness": 4.1e3, "gyro.gimbal_damping": 4284.0}  # N/m, N s/m
STILL, SPINNING = {"gyro.rotor_speed": 0.0}, {"gyro.rotor_speed": 2000 * RPM}
# name -> settings of the gyro units (None: there are none), damper and inerter at each pivot, their mass at each bogie (kg)
RIVALS: dict[str, tuple[dict[str, float] | None, float, float, float]] = {
    "no unit": (None, 0.0, 0.0, 0.0), "gyro at rest": (STILL, 0.0, 0.0, 600.0), "gyro as in Table 2": (SPINNING, 0.0, 0.0, 600.0),
    "gyro in a soft gimbal": (SPINNING | SOFT, 0.0, 0.0, 600.0),
    "inerter like the gyro": (None, 0.0, SMALL, SMALL / PER_MASS / ARM**2), "inerter of its mass": (None, 0.0, LARGE, 600.0),
    **{f"yaw damper, {c / 1e3:g} kN m s": (None, c, 0.0, DAMPER_MASS) for c in DAMPERS},
}  # fmt: skip
BARE = {f"vehicle.{part}_gimbal_{what}": 0.0 for part in ("inner", "outer") for what in ("mass", "ixx", "izz")}
BARE |= {"vehicle.outer_gimbal_iyy": 0.0}
STEEP = {"conicity": 0.3714, "conicity_gradient": 19.99, "rolling_radius": 0.3167, "contact_half_distance": 0.7572,
         "flange_clearance": 0.012, "friction": 0.3}  # fmt: skip
# name -> file of the system, variant of the vehicle, its values, whether it is run in the curve
WHEELS: dict[str, tuple[str, str, dict[str, float], bool]] = {
    "set A": ("lrt-straight", "lrt", parameter_set("A").vehicle, True), "steep tread": ("lrt-straight", "lrt", STEEP, False),
    "set B": ("lrt-straight-b", "lrt_set_b", parameter_set("B").vehicle, True),
    "solid axles": ("lrt-straight", "lrt_solid_axle", {}, False),
}  # fmt: skip
LAWS = ("polach",) if SHORT else ("polach", "shen_hedrick_elkins", "fastsim")
CHECKED = ("no unit", "gyro at rest", "gyro as in Table 2", "yaw damper, 30 kN m s")  # with the other laws: at 8 m/s, two starts
speeds = np.geomspace(0.5, 80.0, 8 if SHORT else 36)  # m/s
curve_speeds = (8.0,) if SHORT else (5.0, 8.0)  # m/s
starts, few = "0mm,0.1mm" if SHORT else "0mm,0.1mm,-0.1mm", "0mm,0.1mm"
START = "vehicle.front_lateral_displacement"
CURVE = {"vehicle.curve_turn": 1.0, "vehicle.curve_radius": 50.0, "vehicle.curve_start": 20.0}
BEHIND = 250.0  # m of straight track behind the curve of 50 m: what has not settled there will not
FREE = ("vehicle.speed",)
COLOURS = ("0.5", "0.2", *figures.COLOURS[:4], "#8c564b", "#17becf", "#bcbd22")  # one for each of RIVALS


def verdict(trajectory: Trajectory) -> dict[str, float]:
    """Whether a wheel left its rail, the largest Y/Q by EN 14363, and the largest |y| over the last 50 m."""
    (vehicle,) = assess(trajectory)
    s = trajectory["vehicle.body_distance"]
    y = [np.abs(trajectory[f"vehicle.{pair}_lateral_displacement"][s > s[-1] - 50.0]).max() for pair in ("front", "rear")]
    return {
        "derailed": float(vehicle.verdict.derailed),
        "ratio": vehicle.worst.value if vehicle.worst else np.nan,
        "late": max(y),
    }


def damper(values: dict[str, float], v: float) -> float:
    """The yaw damper that a pair of these wheels needs at a speed, by the law (N m s)."""
    return needed_damping(wheel_pair(**reduced_values(values | {"speed": v})))


def with_rival(plan: System, variant: str, values: dict[str, float], name: str) -> tuple[System, dict[str, float]]:
    """The system with or without gyro units, and the values by name, masses included."""
    gyro, damping, inertance, mass = RIVALS[name]
    set_to = {f"vehicle.{key}": value for key, value in values.items()} | (gyro or BARE)
    if gyro is None:
        plan = System("alone", (SystemComponent("vehicle", f"vehicle:{variant}"),), (), stop_when=plan.stop_when)
        set_to |= {"vehicle.pivot_damping": damping, "vehicle.pivot_inertance": inertance,
                   "vehicle.bogie_mass": 500.0 + mass, "vehicle.bogie_izz": 404.7 + mass * ARM**2}  # fmt: skip
    return plan, set_to


def through_the_curve(wheels: str, law: str, with_gyro: bool) -> dict[tuple[str, float], dict[str, float]]:
    """(name, speed) -> runs through the curve of 50 m from all starts: how many, how many derail, medians of the rest."""
    _, variant, values, _ = WHEELS[wheels]
    base = system("lrt-curve-b" if wheels == "set B" else "lrt-curve")
    if law != "polach":
        variant, base = f"lrt_{law}", base.with_source("vehicle", f"lrt_{law}")
    length = 20.0 + 2 * values["transition_length"] + values["curve_length"] + BEHIND
    cases: dict[tuple[str, float], dict[str, float]] = {}
    for name in RIVALS if law == "polach" else CHECKED:
        if (RIVALS[name][0] is not None) == with_gyro:
            plan, set_to = with_rival(base, variant, values, name)
            cases |= {(name, v): set_to | CURVE | {"vehicle.speed": v} for v in (curve_speeds if law == "polach" else (8.0,))}
    end = StopWhen(("vehicle", "body_distance"), length, "end of the track")
    what = Sweep(replace(plan, stop_when=(*plan.stop_when, end)), {START: starts if law == "polach" else few},
                 cases={f"{name}, {v:g} m/s": set_to for (name, v), set_to in cases.items()},
                 stop=1.2 * length / min(curve_speeds),
                 signals=("vehicle.body_distance", "vehicle.*_lateral_displacement"),
                 measure=Measure(verdict, {"derailed": "1", "ratio": "1", "late": "m"}))  # fmt: skip
    file = FOLDER / f"rivals-{wheels}-{law}-{'gyro' if with_gyro else 'none'}.npz".replace(" ", "-")
    sweep(what, file)
    table = load(file)
    found = {}
    for name, v in cases:
        rows = table.where(table["case"] == f"{name}, {v:g} m/s")
        lost = rows["derailed"] == 1.0
        left = {key: float(np.median(rows[key][~lost])) if not lost.all() else np.nan for key in ("ratio", "late")}
        found[name, v] = {"runs": len(lost), "derail": int(lost.sum()), "ratio": left["ratio"], "late_mm": left["late"] * 1e3}
    return found


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    summary: dict[str, Any] = {"mass_at_each_end_kg": {name: rival[3] for name, rival in RIVALS.items()},
                               "inertance_kg_m2": [SMALL, LARGE]}  # fmt: skip
    fig, axes = figures.figure(2, 2, (13.5, 9.0))

    # ---- straight track: growth over speed
    for ax, (wheels, (file, variant, values, _)) in zip(axes.flat, WHEELS.items(), strict=True):
        plan = system(file).with_source("vehicle", variant).with_value("vehicle.stretch_lateral", 0.0)
        for name, colour in zip(RIVALS, COLOURS, strict=True):
            chosen, set_to = with_rival(plan, variant, values, name)
            for key, value in set_to.items():
                chosen = chosen.with_value(key, value)
            rest = AtRest(chosen, FREE, ignorable=("vehicle.*_distance",))
            growth = np.array([rest.growth((v,)) for v in speeds])
            stable = speeds[growth < 0.0]
            summary.setdefault(wheels, {})[name] = {
                "stable_from_to_m_s": [float(stable.min()), float(stable.max())] if stable.size else None,
                "stable_at": f"{stable.size} of {speeds.size} speeds",
                "growth_at_8_and_20_m_s": [rest.growth((v,)) for v in (8.0, 20.0)],
            }  # fmt: skip
            ax.plot(speeds, growth, color=colour, linestyle=":" if name == "gyro at rest" else "-", label=name)
        ax.axhline(0.0, color="0.3", linewidth=0.8)
        ax.set_xscale("log")
        ax.set_yscale("symlog", linthresh=0.1)
        ax.set(xlabel="forward speed v [m/s]", ylabel="largest growth [1/s]", title=wheels)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=9)
    figures.save(fig, FOLDER / "rivals.png")
    bare = {key.partition(".")[2]: value for key, value in BARE.items()}
    summary["needed_damper_by_the_law_N_m_s"] = {
        name: {f"{v:g} m/s": damper(values | bare, v) for v in (5.0, 8.0, 20.0)}
        for name, (_, _, values, _) in WHEELS.items() if name != "solid axles"
    }  # fmt: skip
    print("yaw damper that a pair needs, by the law [N m s]:", summary["needed_damper_by_the_law_N_m_s"])
    for wheels in WHEELS:
        for name, r in summary[wheels].items():
            print(f"{wheels}, {name}: {r}")

    # ---- the curve
    for wheels, law in ((wheels, law) for wheels, (*_, driven) in WHEELS.items() for law in LAWS if driven):
        for (name, speed), found in (through_the_curve(wheels, law, False) | through_the_curve(wheels, law, True)).items():
            summary[wheels][name][f"curve, {law}, {speed:g} m/s"] = found
            print("{}, {}, {:g} m/s, {}: {derail} of {runs} derail, Y/Q {ratio:.2f}, |y| at the end {late_mm:.3g} mm".format(
                wheels, law, speed, name, **found))  # fmt: skip
    write_summary(FOLDER / "rivals.json", {"command": " ".join(["python studies/rivals.py", *sys.argv[1:]])} | summary)
