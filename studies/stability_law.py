"""Which ratio of gimbal damper to gimbal spring does the gyro need, and can a softer spring stabilise Table 2's wheels?

The law is a necessary condition (gyro_cosim.railway.yaw_stability): c_g / k_g must exceed a value that grows with the speed,
whatever spin, number of springs and lever arm. Beside it stand the eigenvalues of the full vehicle, with the best spin and damper
for each ratio. Then the vehicle runs over the paper's five waves, its gimbals with dampers and without springs, as co-simulation
of the FMUs. Half a minute. Run: python studies/stability_law.py [--short]
"""

import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from gyro_cosim import Jacobi, Options, Recording, figures, simulate, system
from gyro_cosim.railway.yaw_stability import needed_ratio, wheel_pair
from gyro_cosim.stability import AtRest
from gyro_cosim.sweeps import write_summary
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.reduction import reduced_values

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
PAPER = 21000.0 / 86700.0  # s, Table 2's c_z / k_z
INERTIA, ARM, RADIUS = 22.04, 0.3, 50.0  # kg m2 of a rotor, lever arm of the springs (m), the paper's curve (m)
STEEP = {"conicity": 0.3714, "conicity_gradient": 19.99, "rolling_radius": 0.3167, "contact_half_distance": 0.7572,
         "flange_clearance": 0.012, "friction": 0.3}  # fmt: skip
SOFT = {"gimbal_stiffness": 0.0, "gimbal_damping": 2015.0, "spring_arm": ARM}  # N/m, N s/m, m
RUN = {f"vehicle.{key}": value for key, value in STEEP.items()} | {f"gyro.{key}": value for key, value in SOFT.items()}
STOP = 20.0 if SHORT else 60.0  # s
CASES = {"Table 2's wheels, steep tread": ("lrt-straight", STEEP), "set A": ("lrt-straight", parameter_set("A").vehicle),
         "set B": ("lrt-straight-b", parameter_set("B").vehicle)}  # fmt: skip
speeds = np.array([8, 50] if SHORT else [2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 40, 50, 60, 80, 100], float)  # m/s
dampers = np.geomspace(300.0, 3e6, 9 if SHORT else 21)  # N s/m
DESIGNS = [(rpm * RPM, float(c)) for rpm, c in product((1e3, 2e3, 4e3, 8e3), dampers)]
FREE = ("vehicle.speed", "gyro.rotor_speed", "gyro.gimbal_damping", "gyro.gimbal_stiffness")
LOW, HIGH = np.log((0.01, 1000.0))  # of the ratios looked at, in s
RANGES = {"conicity": np.linspace(0.0, 0.5, 6), "conicity_gradient": np.linspace(0.0, 20.0, 5), "rolling_radius": (0.27, 0.33),
          "contact_half_distance": (0.73, 0.77), "friction": (0.2, 0.4)}  # fmt: skip


def growth(log_ratio: float, v: float, rest: AtRest) -> float:
    """Of the full vehicle, the least over all designs of the gyro with this ratio of damper and spring (1/s)."""
    return min(rest.growth((v, spin, c, c / np.exp(log_ratio))) for spin, c in DESIGNS)


def law(v: float, reduced: dict[str, float]) -> float:
    """The ratio that the law requires at a speed (s)."""
    return needed_ratio(wheel_pair(**reduced | {"speed": v}))


def fastest(reduced: dict[str, float]) -> float:
    """Up to which speed the law allows the paper's ratio (m/s)."""
    return 0.0 if law(0.1, reduced) > PAPER else float(brentq(lambda v: law(v, reduced) - PAPER, 0.1, 1e3))


summary: dict[str, Any] = {"ratio_of_the_paper_s": PAPER}
fig, (axes,) = figures.figure(1, 2, (13.0, 4.8))
for (name, (file, values)), colour in zip(CASES.items(), figures.COLOURS, strict=False):
    # ---- system: at rest on even track
    plan = system(file).with_value("vehicle.stretch_lateral", 0.0)
    for key, value in values.items():
        plan = plan.with_value(f"vehicle.{key}", value)
    rest = AtRest(plan, FREE, ignorable=("vehicle.*_distance",))

    # ---- run: the least ratio at which some design makes the vehicle stable
    full = np.where([growth(LOW, v, rest) < 0.0 for v in speeds], 0.0, np.inf)
    for k, v in enumerate(speeds):
        if full[k] > 0.0 and growth(HIGH, v, rest) < 0.0:
            full[k] = np.exp(brentq(growth, LOW, HIGH, args=(v, rest), xtol=1e-4))
    reduced = reduced_values(values)
    by_law = np.array([law(v, reduced) for v in speeds])
    summary[name] = {
        "speed_m_s": speeds.tolist(), "needed_ratio_by_law_s": by_law.tolist(), "needed_ratio_full_vehicle_s": full.tolist(),
        "law_allows_the_papers_ratio_up_to_m_s": fastest(reduced),
    }  # fmt: skip
    if values is STEEP:  # the price: k eta = H v / R in the paper's curve, at the stable design whose gimbal leans least
        springs = [(n, c, c / ratio) for (n, c), ratio in product(DESIGNS, np.geomspace(0.5, 100.0, 9 if SHORT else 41).tolist())]
        stiff = sorted(springs, key=lambda design: design[0] / design[2])
        spin, c, k = next(design for design in stiff if rest.growth((8.0, *design)) < 0.0)
        summary["least_lean_of_a_stable_gimbal_at_8_m_s"] = {
            "rad": INERTIA * spin * 8.0 / RADIUS / (k * ARM**2), "rpm": spin / RPM, "damper_N_s_per_m": c, "ratio_s": c / k,
        }  # fmt: skip

    # ---- figure
    state = "no ratio is enough" if np.isinf(by_law).all() else "" if by_law.any() else "no ratio is too small"
    axes[0].plot(speeds, by_law, color=colour, label=f"{name}: {state or 'law'}")
    axes[0].plot(speeds, full, "o", color=colour, markersize=4, label=None if state else f"{name}: full vehicle, best gyro")

within = [dict(zip(RANGES, map(float, choice), strict=True)) for choice in product(*RANGES.values())]
fast = [fastest(reduced_values(values)) for values in within]
summary["law_allows_the_papers_ratio_within_the_ranges"] = {"up_to_m_s": max(fast)} | within[int(np.argmax(fast))]
axes[0].axhline(PAPER, color="0.3", linestyle="--", label=f"the paper's springs and dampers, {PAPER:.4f} s")
axes[0].set(xlabel="forward speed v [m/s]", ylabel="needed ratio $c_g / k_g$ [s]")
axes[0].legend(fontsize=8)

# ---- the gimbal without springs over the paper's five waves
for rpm, colour in zip((0, 3000) if SHORT else (0, 2000, 3000), figures.COLOURS, strict=False):
    plan = system("lrt-straight").with_value("gyro.rotor_speed", f"{rpm}rpm")
    for target, value in RUN.items():
        plan = plan.with_value(target, value)
    record = Recording(select=("vehicle.*_lateral_displacement", "vehicle.derailed"), every=10)
    tr = simulate(plan, algorithm=Jacobi(1), stop=STOP, options=Options(record=record)).trajectory
    y = np.abs([tr[f"vehicle.{pair}_lateral_displacement"] for pair in ("front", "rear")]).max(axis=0)
    lost = bool(tr["vehicle.derailed"][-1] > 0.5)
    late = float(y[tr.t > tr.t[-1] - 2.0].max())
    summary[f"without springs, {rpm} rpm"] = {"derailed": lost, "end_s": float(tr.t[-1]), "largest_y_in_the_last_2_s_m": late}
    axes[1].semilogy(tr.t, y * 1e3, color=colour, label=f"{rpm} rpm" + (f", derails after {tr.t[-1]:.1f} s" if lost else ""))
axes[1].set(xlabel="time [s]", ylabel="|y| of the worse pair [mm]", ylim=(1e-4, 100.0))
axes[1].set_title("steep tread, 50 m/s over five waves: dampers of 2015 N s/m, no springs", fontsize=10)
axes[1].legend(fontsize=8)
figures.save(fig, FOLDER / "stability_law.png")
write_summary(FOLDER / "stability_law.json", summary)
for key, result in summary.items():
    print(f"{key}: {result}")
