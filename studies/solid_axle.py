"""When does a gyro help conventional wheelsets? A stiff gimbal makes it an added inertia, a soft one a spring against hunting.

The textbook's wheelset on springs with a gyro unit: what the unit is at the frequency of hunting, and the critical speed over
spring and damper of the gimbal, beside the condition of gyro_cosim.railway.yaw_impedance. Then the vehicle on solid axles, its
gyro units spinning about the longitudinal axis as the paper's, or about the lateral axis as a traction motor does. From
eigenvalues, with three runs in time. Half a minute. Run: python studies/solid_axle.py [--short]
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from gyro_cosim import Connection, Jacobi, Options, Recording, System, SystemComponent, figures, simulate, system
from gyro_cosim.railway.yaw_impedance import SprungWheelset, critical_point, equivalent, stiffest_spring
from gyro_cosim.railway.yaw_stability import Gimbal
from gyro_cosim.stability import AtRest
from gyro_cosim.sweeps import write_summary
from gyro_cosim.vehicle.reduction import wheelset_values

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
INERTIA, GIMBAL, ARM, RADIUS = 22.04, 26.45, 0.3, 0.3  # kg m2 of rotor and gimbal, lever arm of its springs, wheel radius (m)
SPRINGS = 2.04  # n, of Table 2's 86 700 N/m and 21 000 N s/m
STIFF, DAMPED = SPRINGS * 86700.0, SPRINGS * 21000.0
WEAK, STRONG = 100.0, 2000.0  # rpm
# name -> rotor speed (rad/s), gimbal spring (N/m) and damper (N s/m), inertia of rotor and of gimbal (kg m2)
UNITS = {
    "at rest": (0.0, STIFF, DAMPED, INERTIA, GIMBAL),
    "as in Table 2": (STRONG * RPM, STIFF, DAMPED, INERTIA, GIMBAL),
    "Table 2 with a hundredth of its damper": (STRONG * RPM, STIFF, DAMPED / 100, INERTIA, GIMBAL),
    "Table 2's damper, spring 4.1 kN/m": (STRONG * RPM, 4.1e3, DAMPED, INERTIA, GIMBAL),
    "a tenth of the damper, 4.1 kN/m": (STRONG * RPM, 4.1e3, DAMPED / 10, INERTIA, GIMBAL),
    "a hundredth of the damper, 10 N/m": (STRONG * RPM, 10.0, DAMPED / 100, INERTIA, GIMBAL),
}
MOTOR = {"rotor": 1.5, "gear": 6.0, "gimbal": 15.0, "damper": 1e3}  # kg m2, 1, kg m2, N s/m: assumed, a motor of some 100 kW
VEHICLE = {"10 N/m, 1 kN s/m": (10.0, 1000.0), "1 kN/m, 0.43 kN s/m": (1e3, DAMPED / 100)}
CURVES = ((50.0, 8.0), (1000.0, 40.0))  # radius (m) and speed (m/s) at which the gimbal's lean H v / (R k) is told
FAST, STOP = 40.0, 1.0 if SHORT else 5.0  # m/s and s, of the runs in time
springs, dampers = (np.geomspace(low, high, 6 if SHORT else 31) for low, high in ((100.0, 1e6), (100.0, 1e6)))
speeds = np.geomspace(0.5, 60.0, 16 if SHORT else 60)  # m/s; 0.5 is the vehicle's lowest
FREE = ("vehicle.speed", *(f"gyro.{key}" for key in ("rotor_speed", "gimbal_stiffness", "gimbal_damping", "rotor_inertia",
                                                     "gimbal_inertia")))  # fmt: skip

# ---- systems
pair = SystemComponent("vehicle", "vehicle:wheelset"), SystemComponent("gyro", "gyro_unit:linear_full")
bond = (("vehicle", "yaw_rate"), ("gyro", "yaw_rate")), (("gyro", "yaw_moment"), ("vehicle", "yaw_moment"))
bonds = tuple(Connection(*ends) for ends in bond)
wheelset = AtRest(System("wheelset", pair, bonds), FREE, ignorable=("vehicle.distance",))
textbook = SprungWheelset(**wheelset_values({}))
alone, hunting = critical_point(textbook)
straight = system("lrt-straight").with_source("vehicle", "lrt_solid_axle").with_value("vehicle.stretch_lateral", 0.0)
across = straight.with_value("vehicle.inner_gimbal_ixx", 0.0).with_value("vehicle.inner_gimbal_izz", GIMBAL)
for side in ("gyro_front", "gyro_rear"):
    across = across.with_source(side, "lateral_full")
vehicle, turned = (AtRest(plan, FREE, ignorable=("vehicle.*_distance",)) for plan in (straight, across))


def gimbal(spin: float, k: float, c: float, rotor: float, inertia: float) -> Gimbal:
    """A unit of UNITS as the derivation has it."""
    return Gimbal(rotor * spin, inertia, c * ARM**2, k * ARM**2)


def critical(unit: tuple[float, ...], low: float = 2.0, high: float = 100.0) -> float:
    """The least speed at which the wheelset's growth gets above 0 (m/s); NaN where it is unstable from the lowest on."""
    where = np.geomspace(low, high, 12 if SHORT else 24)
    growth = np.array([wheelset.growth((v, *unit)) for v in where])
    crossing = np.flatnonzero((growth[:-1] <= 0.0) & (growth[1:] > 0.0))
    if growth[0] > 0.0 or not crossing.size:
        return np.nan if growth[0] > 0.0 else np.inf
    return float(brentq(lambda v: wheelset.growth((v, *unit)), *where[crossing[0] : crossing[0] + 2], xtol=1e-6))


summary: dict[str, Any] = {"textbook": {"critical_speed_m_s": alone, "frequency_rad_s": hunting}}

# ---- the wheelset: what each unit is at the frequency of hunting, what follows for a weak one, what the eigenvalues say
reference = critical(UNITS["at rest"])
for name, unit in UNITS.items():
    seen, limit = equivalent(gimbal(*unit), hunting), stiffest_spring(textbook, gimbal(*unit))
    summary[name] = {
        "spring_N_m": unit[1], "damper_N_s_m": unit[2], "damping_N_m_s": seen.damping, "inertia_kg_m2": seen.inertia,
        "stiffness_N_m": -seen.inertia * hunting**2, "stiffest_spring_N_m": limit / ARM**2,
        "a_weak_one_helps": bool(unit[1] * ARM**2 < limit), "critical_speed_m_s": critical(unit),
        "lean_in_curves_rad": [gimbal(*unit).momentum * v / R / (unit[1] * ARM**2) for R, v in CURVES],
    }  # fmt: skip

# ---- the wheelset in time, with the full gimbal geometry: begun 1 mm aside, what is left of it at the end
for name in ("at rest", "as in Table 2", "a tenth of the damper, 4.1 kN/m"):
    plan = System("wheelset", (pair[0], SystemComponent("gyro", "gyro_unit:nonlinear_full")), bonds)
    plan = plan.with_value("vehicle.speed", FAST).with_value("vehicle.lateral_displacement", 1e-3)
    for target, value in zip(FREE[1:], UNITS[name], strict=True):
        plan = plan.with_value(target, value)
    record = Recording(select=("vehicle.lateral_displacement",), every=10)
    run = simulate(plan, algorithm=Jacobi(1), stop=STOP, in_process=SHORT, options=Options(record=record)).trajectory
    late = np.abs(run["vehicle.lateral_displacement"][run.t > STOP - 0.5]).max()
    summary[name] |= {"largest_y_at_the_end_mm": float(late) * 1e3}

# ---- the wheelset: a traction motor, its spin in proportion to the speed, in a gimbal without spring
motors = {}
for gear in (0.0, MOTOR["gear"] / 2, MOTOR["gear"], 2 * MOTOR["gear"]):

    def growth(v: float, gear: float = gear) -> float:
        return wheelset.growth((v, gear * v / RADIUS, 1.0, MOTOR["damper"], MOTOR["rotor"], MOTOR["gimbal"]))

    motors[f"{gear:g} : 1"] = float(brentq(growth, 15.0, 60.0, xtol=1e-6))
summary["traction motor"] = MOTOR | {"critical_speed_by_gear_m_s": motors}

# ---- the wheelset: critical speed over spring and damper
maps = {}
for rpm in (WEAK, STRONG):
    maps[rpm] = np.array([[critical((rpm * RPM, k, c, INERTIA, GIMBAL)) for k in springs] for c in dampers]) / reference
limits = [stiffest_spring(textbook, gimbal(1.0, 1.0, c, INERTIA, GIMBAL)) / ARM**2 for c in dampers]
agree = np.sign(np.nan_to_num(maps[WEAK]) - 1.0) == np.sign(np.array(limits)[:, None] - springs[None, :])
summary["map"] = {"cells": agree.size, "weak_unit_as_the_condition_says": int(agree.sum()),
                  "highest_at_2000_rpm": float(np.nanmax(maps[STRONG])) * reference}  # fmt: skip

# ---- the vehicle: growth over speed
rows = {
    "rotor at rest": (vehicle, UNITS["at rest"]), "as in Table 2": (vehicle, UNITS["as in Table 2"]),
    **{name: (vehicle, (STRONG * RPM, k, c, INERTIA, GIMBAL)) for name, (k, c) in VEHICLE.items()},
    "the same, lateral spin axis": (turned, (STRONG * RPM, *VEHICLE["1 kN/m, 0.43 kN s/m"], INERTIA, GIMBAL)),
}  # fmt: skip
lines = {name: np.array([rest.growth((v, *unit)) for v in speeds]) for name, (rest, unit) in rows.items()}
for name, (rest, unit) in rows.items():
    stable = speeds[lines[name] < 0.0]
    lost = speeds[(lines[name] > 0.0) & (speeds > (stable.min() if stable.size else 0.0))]
    fast = None
    if stable.size and lost.size:
        fast = float(brentq(lambda v, r=rest, u=unit: r.growth((v, *u)), stable[stable < lost.min()].max(), lost.min()))  # type: ignore[misc]
    below = lines[name][(speeds < (stable.min() if stable.size else 1.0))]
    summary[f"vehicle, {name}"] = {
        "stable_up_to_m_s": fast, "stable_from_m_s": float(stable.min()) if stable.size else None,
        "largest_growth_below_that_1_s": float(below.max()) if below.size else 0.0,
        "growth_at_8_m_s": rest.growth((8.0, *unit)), "growth_at_20_m_s": rest.growth((20.0, *unit)),
    }  # fmt: skip

# ---- figure
fig, axes = figures.figure(2, 2, (13.5, 9.5))
w = np.geomspace(0.1, 100.0, 300)
for (name, unit), colour in zip([(n, UNITS[n]) for n in (list(UNITS)[k] for k in (1, 4, 5))], figures.COLOURS, strict=False):
    seen = [equivalent(gimbal(*unit), x) for x in w]
    axes[0, 0].plot(w, [-e.inertia * x**2 / 1e3 for e, x in zip(seen, w, strict=True)], color=colour, label=f"{name}: stiffness")
    axes[0, 0].plot(w, [e.damping * x / 1e3 for e, x in zip(seen, w, strict=True)], ":", color=colour, label="damping times w")
axes[0, 0].axvline(hunting, color="0.3", linewidth=0.8)
axes[0, 0].text(hunting * 1.05, -470.0, "hunting of the wheelset", rotation=90, fontsize=8, color="0.3")
axes[0, 0].axhline(0.0, color="0.3", linewidth=0.8)
axes[0, 0].set(xscale="log", ylim=(-500.0, 900.0), xlabel="frequency w [rad/s]", ylabel="moment per yaw angle [kN m/rad]",
               title="what a unit at 2000 rpm is: spring (+) or inertia (-), and damper")  # fmt: skip
axes[0, 0].legend(fontsize=8)
for ax, (rpm, ratio) in zip((axes[0, 1], axes[1, 0]), maps.items(), strict=True):
    away = 0.01 if rpm == WEAK else 1.0
    drawn = ax.pcolormesh(springs / 1e3, dampers / 1e3, np.clip(ratio, 0.0, 2.5) - 1.0, cmap="RdBu", vmin=-away, vmax=away)
    fig.colorbar(drawn, ax=ax, label="critical speed over that without spin, less 1")
    ax.plot(np.array(limits) / 1e3, dampers / 1e3, color="0.1", label="condition for a weak unit: helps to the left")
    ax.plot(STIFF / 1e3, DAMPED / 1e3, "k*", markersize=11, label="Table 2")
    ax.set(xscale="log", yscale="log", xlim=(springs[0] / 1e3, springs[-1] / 1e3), xlabel="gimbal spring [kN/m]",
           ylabel="gimbal damper [kN s/m]", title=f"wheelset, {rpm:g} rpm: blue helps, red harms")  # fmt: skip
    ax.set_facecolor("0.75")
    ax.legend(fontsize=8, loc="upper left")
for name, colour in zip(rows, figures.COLOURS, strict=False):
    axes[1, 1].plot(speeds, lines[name], "--" if "lateral" in name else "-", color=colour, label=name)
axes[1, 1].axhline(0.0, color="0.3", linewidth=0.8)
axes[1, 1].set(xscale="log", ylim=(-1.0, 1.0), xlabel="forward speed v [m/s]", ylabel="largest growth [1/s]",
               title="vehicle on solid axles, 2000 rpm")  # fmt: skip
axes[1, 1].legend(fontsize=8, loc="lower left")
figures.save(fig, FOLDER / "solid_axle.png")
write_summary(FOLDER / "solid_axle.json", {"command": " ".join(["python studies/solid_axle.py", *sys.argv[1:]])} | summary)

# ---- table
print(f"wheelset alone: {alone:.2f} m/s and {hunting:.2f} rad/s by the formula, {reference:.2f} m/s by the multibody model")
print(f"{'unit at 2000 rpm':36} {'R [N m s]':>10} {'J [kg m2]':>10} {'weak helps':>10} {'critical [m/s]':>14}",
      "lean [rad] at R, v", *CURVES)  # fmt: skip
for name in UNITS:
    r = summary[name]
    helps = "yes" if r["a_weak_one_helps"] else "no"
    print(f"{name:36} {r['damping_N_m_s']:10.0f} {r['inertia_kg_m2']:10.0f} {helps:>10} {r['critical_speed_m_s']:14.2f}",
          *(f"{lean:.3g}" for lean in r["lean_in_curves_rad"]))  # fmt: skip
print(f"begun 1 mm aside at {FAST:g} m/s, co-simulation, largest |y| after {STOP:g} s:",
      {n: f"{r['largest_y_at_the_end_mm']:.3g} mm" for n, r in summary.items() if "largest_y_at_the_end_mm" in r})  # fmt: skip
print("traction motor, critical speed by gear:", {gear: round(v, 2) for gear, v in motors.items()})
print("map:", summary["map"])
for name in rows:
    print(f"vehicle, {name}: {summary[f'vehicle, {name}']}")
