"""Which gyro unit lets Table 2's wheels settle at 50 m/s and pass the 50 m curve at 8 m/s: claims C6 and C10 at once?

The plain gimbal with a soft spring, the progressive spring (soft, or over centre, about the middle, buffers outside),
active centring, spin scheduled on curvature. Each is drawn from wide ranges (Sobol), and the draws' eigenvalues with the full
vehicle on even track at 50 m/s are looked at; the first that are stable run as FMUs through both of the paper's cases. Treads:
set A's, and one of conicity 0.3714. The best runs again from three starts with each creep law. Then the law's needed ratio
beside the full model in ten cases. Three minutes. Run: python studies/lean_units.py [--short]
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.stats import qmc

from gyro_cosim import figures, system
from gyro_cosim.paper.measures import claim_6, claim_10, curve, straight
from gyro_cosim.railway.over_centre import stable_units_fail
from gyro_cosim.railway.yaw_stability import needed_ratio, wheel_pair
from gyro_cosim.stability import AtRest
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.reduction import reduced_values

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
FAST, SLOW, RADIUS = 50.0, 8.0, 50.0  # m/s, m/s, m
DRAWS, RUNS = (64, 1) if SHORT else (512, 12)  # of each unit and tread; how many of the stable ones run, the first
STOPS = {"straight": 5.0 if SHORT else 120.0, "curve": 5.0 if SHORT else 45.0}  # s
STEEP = {"conicity": 0.3714, "conicity_gradient": 19.99, "rolling_radius": 0.3167, "contact_half_distance": 0.7572,
         "flange_clearance": 0.012, "friction": 0.3}  # fmt: skip
TREADS: dict[str, dict[str, float]] = {"set A": {}, "steep tread": STEEP}
COMMON = {"rotor_speed": (1500 * RPM, 6000 * RPM), "gimbal_damping": (10.0, 3e4), "gimbal_stiffness": (10.0, 3e4)}
BUFFERS = {"outer_stiffness": (1e4, 1e5), "outer_time": (0.3, 2.0), "slot_angle": (0.005, 0.1)}  # outer damper over spring, s
UNITS: dict[
    str, tuple[str, float, dict[str, tuple[float, float]]]
] = {  # name -> variant, sign of the spring, ranges beside COMMON
    "plain": ("nonlinear", 1.0, {}),
    "progressive": ("progressive", 1.0, BUFFERS),
    "over-centre": ("progressive", -1.0, BUFFERS),
    "centred": ("centred", 1.0, {"centring_gain": (0.01, 300.0)}),
    "scheduled": ("scheduled", 1.0, {"curve_spin": (0.05, 1.0), "schedule_rate": (0.03, 0.12)}),
}
FIXED = {
    "centred": {"centring_torque_limit": 1e4},
    "scheduled": {"schedule_filter": 0.5, "spin_time": 1.0, "motor_torque_limit": 5e3},
}
LAWS = ("lrt",) if SHORT else ("lrt", "lrt_shen_hedrick_elkins", "lrt_fastsim")
STARTS = "0mm" if SHORT else "0mm,0.1mm,-0.1mm"
COLUMNS = {"y": "m", "psi": "rad", "climb": "1", "steady": "rad", "after": "m", "filtered": "1", "reach": "m", "lean": "rad",
           "power": "W", "swing": "m"}  # fmt: skip


def measured(trajectory: Trajectory) -> dict[str, float]:
    """Of one run: what the claims ask for, the largest lean and the largest power of a motor."""
    end, way = straight(trajectory), curve(trajectory)
    power = [np.abs(trajectory[name]).max() for name in trajectory.names if name.endswith("motor_power")]
    return {"y": end["y"], "psi": end["psi"], "lean": float(np.abs(trajectory["gyro_front.gimbal_angle"]).max()),
            "power": float(max(power, default=0.0)),
            **{key: way[key] for key in ("climb", "steady", "after", "filtered", "reach", "swing")}}  # fmt: skip


def drawn(unit: str) -> list[dict[str, float]]:
    """Values of the gyro units, evenly in the logarithm, always the same."""
    _, sign, own = UNITS[unit]
    ranges = COMMON | own
    u = qmc.Sobol(len(ranges), seed=1).random(DRAWS)
    low, high = np.log(np.array(list(ranges.values()))).T
    rows = [dict(zip(ranges, map(float, row), strict=True)) for row in np.exp(low + u * (high - low))]
    for row in rows:
        row["gimbal_stiffness"] *= sign
        if "outer_time" in row:
            row["outer_damping"] = row["outer_stiffness"] * row.pop("outer_time")
        row |= FIXED.get(unit, {})
    return rows


def at_rest(tread: str, unit: str, free: tuple[str, ...]) -> AtRest:
    """The vehicle with this unit, linearised on even track."""
    plan = system("lrt-straight").with_value("vehicle.stretch_lateral", 0.0).with_source("gyro", UNITS[unit][0])
    for key, value in TREADS[tread].items():
        plan = plan.with_value(f"vehicle.{key}", value)
    return AtRest(plan, free, ignorable=("vehicle.*_distance",))


def runs(
    label: str, track: str, tread: str, variant: str, cases: dict[str, dict[str, float]], law: str = "lrt", starts: str = "0mm"
) -> dict[str, list[dict[str, float]]]:
    """Design -> what is measured of each of its runs on a track of the paper, one for each start in the curve."""
    plan = system(f"lrt-{track}").with_value("vehicle.speed", FAST if track == "straight" else SLOW).with_source("gyro", variant)
    plan = plan.with_source("vehicle", law)
    for key, value in TREADS[tread].items():
        plan = plan.with_value(f"vehicle.{key}", value)
    values = {"vehicle.front_lateral_displacement": starts} if track == "curve" else {}
    what = Sweep(plan, values, cases={name: {f"gyro.{k}": v for k, v in case.items()} for name, case in cases.items()},
                 signals=("vehicle.body_distance",), stop=STOPS[track], measure=Measure(measured, COLUMNS))  # fmt: skip
    what_runs = f"{label}-{track}-{tread}-{law}".replace(" ", "-")
    file = FOLDER / f"lean-units-{what_runs}.npz"
    sweep(what, file)
    table = load(file)
    rows = [(str(case), {column: float(table[column][i]) for column in COLUMNS}) for i, case in enumerate(table["case"])]
    return {name: [row for case, row in rows if case == name] for name in cases}


def verdict(fast: dict[str, float], slow: list[dict[str, float]]) -> dict[str, Any]:
    """The parts of C6 and C10 as the ledger judges them, and the numbers."""
    never = {"y": np.inf, "psi": np.inf, "climb": 2.0}
    parts = {"settles": claim_6(never, fast)["on settles"], **claim_10(slow)}
    worst = max(slow, key=lambda row: row["climb"])
    return {"parts": {part: bool(margin > 0.0) for part, margin in parts.items()}, "y_straight_m": fast["y"],
            "psi_straight_rad": fast["psi"], "lean_straight_rad": fast["lean"], "steady_yaw_rad": worst["steady"],
            "after_m": worst["after"], "Y_over_Q": max(row["filtered"] for row in slow), "climb": worst["climb"],
            "lean_curve_rad": max(row["lean"] for row in slow), "motor_W": max(row["power"] for row in slow)}  # fmt: skip


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    summary: dict[str, Any] = {"units": {}, "laws": {}, "ratio": []}
    best: tuple[Any, ...] = ()
    for tread in TREADS:
        reduced = reduced_values(parameter_set("A").vehicle | TREADS[tread])
        summary[f"{tread}: no stable unit can, by the pair's law"] = {
            f"{v:g} m/s": stable_units_fail(wheel_pair(**reduced | {"speed": v})) for v in (SLOW, FAST)}  # fmt: skip
        for unit, (variant, _, _) in UNITS.items():
            # ---- which draws are stable at rest at 50 m/s
            names = tuple(COMMON) + (("centring_gain",) if unit == "centred" else ())
            rest = at_rest(tread, unit, ("vehicle.speed", *(f"gyro.{n}" for n in names)))
            rows = drawn(unit)
            growth = np.array([rest.growth((FAST, *(row[n] for n in names)), creeping=False) for row in rows])
            stable = np.flatnonzero(growth < 0.0)
            chosen = {f"{unit} {i}": rows[i] for i in stable[:RUNS]}
            result: dict[str, Any] = {"drawn": len(rows), "stable_at_50": len(stable), "least_growth": float(growth.min())}

            # ---- those run, as FMUs
            if chosen:
                fast, slow = (runs(unit, track, tread, variant, chosen) for track in ("straight", "curve"))
                judged = {name: verdict(fast[name][0], slow[name]) for name in chosen}
                score = {
                    name: sum(v["parts"].values()) + 0.1 * v["parts"]["settles"] - v["y_straight_m"] for name, v in judged.items()
                }
                first = max(score, key=lambda name: score[name])
                both = [n for n, v in judged.items() if v["parts"]["settles"] and v["parts"]["passes"]]
                result |= {"run": len(chosen), "settle": sum(v["parts"]["settles"] for v in judged.values()),
                           "pass": sum(v["parts"]["passes"] for v in judged.values()), "both": len(both), "best": judged[first],
                           "design": chosen[first]}  # fmt: skip
                if not best or score[first] > best[0]:
                    best = (score[first], tread, unit, first, chosen[first])
            summary["units"][f"{tread}, {unit}"] = result

    # ---- the best of all with each creep law
    _, tread, unit, name, design = best
    summary["best"] = {"tread": tread, "unit": unit, "design": design}
    for law in LAWS:
        fast, slow = (
            runs("best", track, tread, UNITS[unit][0], {name: design}, law, STARTS)[name] for track in ("straight", "curve")
        )
        summary["laws"][law] = verdict(fast[0], slow)

    # ---- the ratio that the law requires beside that of the full vehicle with the best gyro, in ten cases
    designs = [(rpm * RPM, c) for rpm in (1e3, 2e3, 4e3, 8e3) for c in np.geomspace(300.0, 3e6, 21)]
    free = ("vehicle.speed", "vehicle.conicity", "gyro.rotor_speed", "gyro.gimbal_damping", "gyro.gimbal_stiffness")
    rest = at_rest("steep tread", "plain", free)
    for conicity in (0.3714,) if SHORT else (0.25, 0.3, 0.35, 0.4, 0.45):
        for v in (FAST,) if SHORT else (20.0, FAST):
            law = needed_ratio(wheel_pair(**reduced_values(STEEP | {"conicity": conicity}) | {"speed": v}))

            def least(log_ratio: float, v: float = v, conicity: float = conicity) -> float:
                return min(rest.growth((v, conicity, spin, c, c / np.exp(log_ratio))) for spin, c in designs)

            full = float(np.exp(brentq(least, np.log(0.01), np.log(1000.0), xtol=1e-3)))
            summary["ratio"].append(
                {"conicity": conicity, "speed_m_s": v, "law_s": law, "full_vehicle_s": full, "factor": full / law}
            )
    summary["largest_factor"] = float(np.exp(max(abs(np.log(row["factor"])) for row in summary["ratio"])))

    # ---- figure: what each unit reached, and the ratios
    fig, (axes,) = figures.figure(1, 2, (13.0, 4.8))
    for k, (tread, colour) in enumerate(zip(TREADS, figures.COLOURS, strict=False)):
        shares = [summary["units"][f"{tread}, {unit}"] for unit in UNITS]
        at = np.arange(len(UNITS)) + 0.4 * k - 0.2
        ran = [max(row.get("run", 0), 1) for row in shares]
        for parts, alpha in (("settle", 0.25), ("pass", 0.5), ("both", 1.0)):
            height = [row.get(parts, 0) / n for row, n in zip(shares, ran, strict=True)]
            axes[0].bar(at + {"settle": -0.12, "pass": 0.0, "both": 0.12}[parts], height, 0.12, color=colour, alpha=alpha,
                        label=f"{tread}: {parts}")  # fmt: skip
    counted = [" and ".join(f"{row['stable_at_50']}/{row['drawn']}" for row in (summary["units"][f"{t}, {u}"] for t in TREADS))
               for u in UNITS]  # fmt: skip
    axes[0].set_xticks(range(len(UNITS)), [f"{unit}\n{count}" for unit, count in zip(UNITS, counted, strict=True)], fontsize=8)
    axes[0].set(ylim=(0.0, 1.0), ylabel="share of the designs that were run")
    axes[0].set_xlabel(f"draws that are stable at rest at 50 m/s, {' and '.join(TREADS)}; the first of them were run", fontsize=9)
    axes[0].legend(fontsize=7, ncols=2)
    for v, colour in zip((20.0, FAST), figures.COLOURS, strict=False):
        rows = [row for row in summary["ratio"] if row["speed_m_s"] == v]
        axes[1].plot([r["conicity"] for r in rows], [r["law_s"] for r in rows], color=colour, label=f"law, {v:g} m/s")
        axes[1].plot(
            [r["conicity"] for r in rows], [r["full_vehicle_s"] for r in rows], "o", color=colour, label=f"full, {v:g} m/s"
        )
    axes[1].set(xlabel="conicity at the centre [1]", ylabel="needed ratio $c_g / k_g$ [s]", ylim=(0.0, None))
    axes[1].legend(fontsize=8)
    figures.save(fig, FOLDER / "lean_units.png")
    write_summary(FOLDER / "lean_units.json", summary)
    for key, value in summary.items():
        rows = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ((key, value),)
        for row in rows:
            print(f"{key}: {row[0]}: {row[1]}")
