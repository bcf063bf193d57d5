"""Which gimbal, if spring and damper are free and apart? Stability at 50 m/s against lean in the curve, mass and spin power.

For each vehicle the front of least growth at 50 m/s over the largest lean that is allowed in the 50 m curve at 8 m/s, k eta =
H v / R, for three allowances of rotor mass and spin power: SLSQP with exact gradients (the smoothed growth of the CasADi
monolith), checked by a grid over all bounds, and by co-simulation of the FMUs on straight track and in the curve. The lever arm
is no freedom: only k_g d_g^2 and c_g d_g^2 count. Two minutes. Run: python studies/gimbal_design.py [--short]
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from hashlib import sha256
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim import System, figures, system
from gyro_cosim.paper.measures import curve, straight
from gyro_cosim.stability import AtRest, Limit, Release, pareto_front
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.trajectory import Trajectory

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
FAST, SLOW, RADIUS, ARM = 50.0, 8.0, 50.0, 0.3  # m/s, m/s, m, m
INERTIAS = np.array([22.04, 26.45, 500.0, 22.04, 26.45])  # Table 2: rotor, gimbal; both in kg; on the frame
VISCOUS, DRY = 0.01, 2.0  # N m s/rad, N m, bearing of the rotor: assumed in gyro_unit/rotor_parameters.py
STEEP = {"conicity": 0.3714, "conicity_gradient": 19.99, "rolling_radius": 0.3167, "contact_half_distance": 0.7572,
         "flange_clearance": 0.012, "friction": 0.3}  # fmt: skip
CASES = {  # name -> ending of the systems, values of the vehicle, sign of the spring
    "set B": ("-b", {}, 1.0),
    "Table 2's wheels, steep tread": ("", STEEP, 1.0),
    "set A, spring over centre": ("", {}, -1.0),
}  # fmt: skip
LEANS = np.array([0.3]) if SHORT else np.geomspace(0.03, 100.0, 8)  # rad, largest that is allowed in the curve
ALLOWANCES = {"500 kg, 1 kW": (1.0, 1e3), "1000 kg, 5 kW": (2.0, 5e3)}  # mass over Table 2's, W a rotor
BOUNDS = np.array([(100 * RPM, 8000 * RPM), (10.0, 1e6), (10.0, 1e6), (0.25, 2.0)])  # spin, k_g, c_g, mass over Table 2's
COARSE, FINE = (5, 8, 8), (5, 8, 8) if SHORT else (10, 24, 24)  # grids of spin, k_g, c_g: where to begin, and brute force
HEAVY = ("gyro.rotor_inertia", "gyro.gimbal_inertia", *(f"vehicle.inner_gimbal_{what}" for what in ("mass", "ixx", "izz")))
FREE = ("vehicle.speed", "gyro.rotor_speed", "gyro.gimbal_stiffness", "gyro.gimbal_damping", *HEAVY)
LEVEL = 1e3  # s, of the smoothed growth: some 0.01 1/s above the growth
MANY = "1000 kg, 5 kW"  # compared with the grid, and run as FMUs
CHOSEN = (0.1, 0.3, 1.0)  # rad: designs of these leans run as FMUs too
COLUMNS = {"lean": "rad", "late": "m", "late_yaw": "rad", "climb": "1", "ratio": "1"}


def momentum(d: np.ndarray) -> float:
    """H of a design, N m s."""
    return float(INERTIAS[0] * d[3] * d[0])


def lean(d: np.ndarray) -> tuple[float, np.ndarray]:
    """Logarithm of the steady lean in the curve, H v / (R k) with k = k_g d_g^2, and its slope."""
    value = np.log(momentum(d) * SLOW / RADIUS / (d[1] * ARM**2))
    return value, np.array([1.0, -1.0, 0.0, 1.0]) / d


def power(d: np.ndarray) -> tuple[float, np.ndarray]:
    """Logarithm of the power that an assumed bearing takes from a rotor, its friction in proportion to the mass."""
    friction, slope = VISCOUS * d[0] + DRY, VISCOUS
    return np.log(d[3] * friction * d[0]), np.array([slope / friction + 1 / d[0], 0.0, 0.0, 1 / d[3]])


def vehicle_of(name: str) -> tuple[System, np.ndarray]:
    """The system on even track, and what makes the parameters FREE, but the speed, of a design: shape (8, 4)."""
    ending, values, sign = CASES[name]
    plan = system(f"lrt-straight{ending}").with_value("vehicle.stretch_lateral", 0.0)
    for key, value in values.items():
        plan = plan.with_value(f"vehicle.{key}", value)
    spread = np.zeros((8, 4))
    spread[[0, 1, 2], [0, 1, 2]] = 1.0, sign, 1.0
    spread[3:, 3] = INERTIAS
    return plan, spread


def front(name: str) -> dict[str, Any]:
    """The front of every allowance, and the grid."""
    plan, spread = vehicle_of(name)
    rest = AtRest(plan, FREE, ignorable=("vehicle.*_distance",))
    ends, small = ("front", "rear"), 1e-5  # rad and m
    turned = [{f"vehicle.{end}_yaw_angle": small, f"vehicle.{end}_bogie_angle": small} for end in ends]
    leaning = [{f"gyro_{end}.gimbal_angle": 10 * small} for end in ends]
    sizes = {"vehicle.{}_yaw_angle": 1.0, "vehicle.{}_lateral_displacement": 10.0, "gyro_{}.gimbal_angle": 100.0}
    seen = {name.format(end): factor * small for name, factor in sizes.items() for end in ends}
    release = Release(rest, turned + leaning, seen)

    def growth(d: np.ndarray, v: float) -> float:
        return rest.growth((v, *(spread @ d)))

    def smoothed(v: float) -> Any:
        def function(d: np.ndarray) -> tuple[float, np.ndarray]:
            s, slope = release.smoothed_growth(np.array([v, *(spread @ d)]), LEVEL)
            return s, slope[1:] @ spread

        return function

    def grid(counts: tuple[int, ...], mass: float, watts: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Designs over all bounds that keep the power, their leans (logarithms) and growths at 50 m/s."""
        axes = [np.geomspace(*edges, n) for edges, n in zip(BOUNDS[:3], counts, strict=True)]
        points = np.array([(*p, mass) for p in np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)])
        points = points[[power(p)[0] <= np.log(watts) for p in points]]
        return points, np.array([lean(p)[0] for p in points]), np.array([growth(p, FAST) for p in points])

    result: dict[str, Any] = {"rest_error": max(rest.rest_error((FAST, *(spread @ d))) for d in BOUNDS.T)}
    for label, (mass, watts) in ALLOWANCES.items():
        bounds = np.array([*BOUNDS[:3], (BOUNDS[3, 0], mass)])
        limits = [Limit("lean", lean, 0.0), Limit("power", power, np.log(watts))]
        points, leans, growths = grid(COARSE, mass, watts)

        def begin(largest: float, points: Any = points, leans: Any = leans, growths: Any = growths) -> list[np.ndarray]:
            kept = np.flatnonzero(leans <= largest)
            best = kept[np.argsort(growths[kept])[:2]] if kept.size else [leans.argmin()]
            return list(points[best])

        designs = pareto_front(smoothed(FAST), bounds, begin, limits, np.log(LEANS))
        result[label] = [
            {"largest_lean": float(largest), "rpm": float(d.q[0] / RPM), "k_g": float(CASES[name][2] * d.q[1]),
             "c_g": float(d.q[2]), "mass": float(d.q[3]),
             "ratio_s": float(d.q[2] / d.q[1]), "lean": float(np.exp(lean(d.q)[0])), "power": float(np.exp(power(d.q)[0])),
             "growth_at_50": growth(d.q, FAST), "growth_at_8": growth(d.q, SLOW), "evaluations": d.evaluations}
            if np.isfinite(d.criterion) else {"largest_lean": float(largest)}
            for largest, d in zip(LEANS, designs, strict=True)
        ]  # fmt: skip

    # ---- brute force: the least growth in a finer grid over all bounds that keeps lean and power
    _, leans, growths = grid(FINE, *ALLOWANCES[MANY])
    result["grid"] = [float(growths[leans <= largest].min(initial=np.inf)) for largest in np.log(LEANS)]
    return result


def measured(trajectory: Trajectory) -> dict[str, float]:
    """Of one run: largest lean, y and yaw in its last two seconds, climb and filtered Y/Q."""
    end, way = straight(trajectory), curve(trajectory)
    return {"lean": float(np.abs(trajectory["gyro_front.gimbal_angle"]).max()), "late": end["y"], "late_yaw": end["psi"],
            "climb": end["climb"], "ratio": way["filtered"]}  # fmt: skip


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    # ---- linear model: fronts by SLSQP, one process a vehicle; what is there of the same question is taken
    question = json.loads(json.dumps([LEANS.tolist(), ALLOWANCES, BOUNDS.tolist(), FINE, CASES, LEVEL, FREE]))
    file = FOLDER / "gimbal-design-fronts.json"
    kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    fronts: dict[str, Any] = kept["fronts"] if kept.get("question") == question else {}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        left = [name for name in CASES if name not in fronts]
        for name, result in zip(left, pool.map(front, left), strict=True):
            fronts[name] = result
            write_summary(file, {"question": question, "fronts": fronts})

    # ---- check by co-simulation: straight track with five waves at 50 m/s, the curve at 8 m/s
    summary: dict[str, Any] = {"fronts": fronts}
    for name, (ending, values, sign) in CASES.items():
        near = [d for d in fronts[name][MANY] if "rpm" in d and np.abs(np.log(d["largest_lean"] / np.array(CHOSEN))).min() < 0.6]
        cases: dict[str, dict[str, Any]] = {"Table 2": {}}
        for d in near:
            heavy = dict(zip(HEAVY, map(float, INERTIAS * d["mass"]), strict=True))
            cases[f"lean {d['largest_lean']:.2g} rad"] = heavy | {
                "gyro.rotor_speed": d["rpm"] * RPM, "gyro.gimbal_stiffness": d["k_g"],
                "gyro.gimbal_damping": d["c_g"]}  # fmt: skip
        for case in cases.values():
            case.setdefault("gyro.rotor_speed", 2000.0 * RPM)
        for track, speed, stop in (("straight", FAST, 25.0 if SHORT else 60.0), ("curve", SLOW, 10.0 if SHORT else 45.0)):
            plan = system(f"lrt-{track}{ending}").with_value("vehicle.speed", speed)
            if sign < 0.0:  # the same gimbal with a spring that may push; no buffers
                plan = plan.with_source("gyro", "progressive")
                plan = plan.with_value("gyro.outer_stiffness", 0.0).with_value("gyro.outer_damping", 0.0)
            for key, value in values.items():
                plan = plan.with_value(f"vehicle.{key}", value)
            what = Sweep(plan, {}, cases=cases, signals=("vehicle.body_distance",), stop=stop, measure=Measure(measured, COLUMNS))
            designs = sha256(json.dumps(cases).encode()).hexdigest()[:8]  # other designs, another file
            rows = FOLDER / f"gimbal-design-{track}-{list(CASES).index(name)}-{designs}.npz"
            sweep(what, rows)
            table = load(rows)
            summary[f"{name}, {track} at {speed:g} m/s"] = {
                case: {column: float(table[column][i]) for column in COLUMNS} for i, case in enumerate(table["case"])
            }

    # ---- figure
    fig, (axes,) = figures.figure(1, 3, (16.0, 5.0))
    for ax, (name, result) in zip(axes, fronts.items(), strict=True):
        for (label, _), colour in zip(ALLOWANCES.items(), figures.COLOURS, strict=False):
            points = [d for d in result[label] if "rpm" in d]
            ax.plot(
                [d["lean"] for d in points], [d["growth_at_50"] for d in points], ".-", color=colour, label=f"rotors of {label}"
            )
        ax.plot(
            LEANS, [np.nan if g is None else g for g in result["grid"]], "x", color="0.3", markersize=5, label=f"grid, {MANY}"
        )
        ax.axhline(0.0, color="0.3", linewidth=0.8)
        ax.axvspan(1.0, LEANS[-1], color="0.9", label="lean beyond 1 rad: of no use")
        ax.set(xscale="log", xlabel="steady lean in the 50 m curve at 8 m/s [rad]", ylabel="least growth at 50 m/s [1/s]")
        ax.set_title(name, fontsize=10)
        ax.legend(fontsize=7)
    figures.save(fig, FOLDER / "gimbal_design.png")
    write_summary(FOLDER / "gimbal_design.json", summary)
    for name, result in fronts.items():
        for label in ALLOWANCES:
            for d in result[label]:
                print(f"{name}, {label}: " + ", ".join(f"{key} {value:.4g}" for key, value in d.items()))
    for key, found in summary.items():
        if key != "fronts":
            for case, row in found.items():
                print(f"{key}, {case}: " + ", ".join(f"{column} {value:.4g}" for column, value in row.items()))
