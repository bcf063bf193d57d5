"""What does the gyro cost, beside what it gains?

Cost: lean of the gimbal, power at the spin axis, moments on the frame, wheel loads, mass, energy in the rotors. Gain: Y/Q, wear
number, highest safe speed. The full vehicle in a curve of 50 m with the multibody gyro unit, whose rotor has a motor; its bearing
is freed of friction, so that the motor's power is what the spin axis' own balance takes. "none" is a vehicle without the gyros'
1200 kg. Set A has Table 2's wheels, B wheels almost without spin inertia. Run: python studies/gyro_cost.py [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from gyro_cosim import figures, system
from gyro_cosim.railway.assessment import assess
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.systems import StopWhen, catalogue
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
SYSTEMS = {"B": "lrt-curve-b"} if SHORT else {"A": "lrt-curve", "B": "lrt-curve-b"}
RADIUS, BEFORE, BEHIND = 50.0, 20.0, 50.0  # m; straight track before the entry transition and behind the curve
starts = "0mm" if SHORT else "0mm,0.1mm,-0.1mm"
speeds = (5.0, 8.0) if SHORT else (4.0, 5.0, 6.0, 7.0, 8.0, 9.0)  # m/s
spins = (0.0, 2000.0) if SHORT else (0.0, 500.0, 1000.0, 2000.0, 4000.0)  # rpm
SHOWN = (5.0, 8.0)  # m/s
LOOSE = dict.fromkeys(("gyro.bearing_friction", "gyro.bearing_viscous_friction"), 0.0)
NONE = LOOSE | dict.fromkeys((
    *(f"vehicle.{gimbal}_gimbal_{what}" for gimbal in ("inner", "outer") for what in ("mass", "ixx", "izz")),
    "vehicle.outer_gimbal_iyy", *(f"gyro.{name}" for name in (
        "rotor_speed", "gimbal_stiffness", "gimbal_damping", "speed_gain", "speed_integral_gain"))), 0.0)  # fmt: skip
COLUMNS = {"derailed": "1", "ratio": "1", "wear": "N", "lean": "rad", "steady_lean": "rad", "steady_pitch": "N.m", "roll": "N.m",
           "yaw": "N.m", "power": "W", "front_load": "N", "outer_load": "N"}  # fmt: skip
WHEELS = [f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]
PANELS = {"steady_pitch": ("pitch moment on the front frame\nin the steady curve [N m]", -1.0),  # shown positive
          "lean": ("largest lean of a gimbal [deg]", 180 / np.pi), "power": ("largest power of a motor [W]", 1.0),
          "ratio": ("largest Y/Q, EN 14363", 1.0), "wear": ("T$\\gamma$ of all wheels, mean of the curve [N]", 1.0)}  # fmt: skip


def cost_and_gain(trajectory: Trajectory) -> dict[str, float]:
    """Of one run; the steady curve is the second half of its full curvature, nan where the run does not get there."""
    (vehicle,) = assess(trajectory)
    gyro = {name: np.array([trajectory[f"gyro_{end}.{name}"] for end in ("front", "rear")])
            for name in ("gimbal_angle", "pitch_moment", "roll_moment", "yaw_moment", "motor_power")}  # fmt: skip
    Q, wear = (np.array([trajectory[f"vehicle.{w}_{what}"] for w in WHEELS]) for what in ("vertical_force", "wear_number"))
    going = trajectory["vehicle.body_distance"] > BEFORE / 2  # what the start off the centre shakes has died away
    full = np.flatnonzero(trajectory["vehicle.curvature"] > 0.999 / RADIUS)
    steady = full[full.size // 2 :] if not vehicle.verdict.derailed else full[:0]
    mean = (lambda values: values[..., steady].mean(axis=-1)) if steady.size else (lambda values: values[..., 0] * np.nan)
    peak = {name: np.abs(values[:, going]).max(initial=0.0) for name, values in gyro.items()}
    return {
        "derailed": float(vehicle.verdict.derailed), "ratio": vehicle.worst.value if vehicle.worst else np.nan,
        "wear": wear.sum(axis=0)[trajectory["vehicle.curvature"] > 0.0].mean(), "lean": peak["gimbal_angle"],
        "steady_lean": mean(gyro["gimbal_angle"][0]), "steady_pitch": mean(gyro["pitch_moment"][0]),
        "roll": peak["roll_moment"], "yaw": peak["yaw_moment"], "power": peak["motor_power"],
        "front_load": mean(Q[0] + Q[1] - Q[2] - Q[3]) / 2, "outer_load": mean(Q[1] + Q[3] - Q[0] - Q[2]) / 4,
    }  # fmt: skip


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    unit = {v.name: v.start for v in catalogue.component("gyro_unit:multibody_full").parameters}
    cases = {"none": NONE} | {f"{spin:g} rpm": LOOSE | {"gyro.rotor_speed": f"{spin:g}rpm"} for spin in spins}
    omega = np.array(spins) * np.pi / 30  # rad/s
    H = unit["rotor_inertia"] * omega  # N m s, of one rotor
    summary: dict[str, object] = {
        "rpm": list(spins), "momentum_N_m_s": H.tolist(), "energy_of_a_rotor_J": (H * omega / 2).tolist(),
        "pitch_moment_H_v_over_R_N_m": {f"{v:g}": (H * v / RADIUS).tolist() for v in SHOWN},
        "drag_of_an_assumed_bearing_W": ((unit["bearing_friction"] + unit["bearing_viscous_friction"] * omega) * omega).tolist(),
    }  # fmt: skip
    fig, axes = figures.figure(2, 3, (15.0, 8.5))
    for (name, file), line, marker in zip(SYSTEMS.items(), ("-", "--"), "os", strict=False):
        # ---- system: the run ends where its track does, at whatever speed
        layout = parameter_set(name).vehicle
        length = BEFORE + 2 * layout["transition_length"] + layout["curve_length"] + BEHIND
        plan = system(file).with_source("gyro", "multibody").with_value("vehicle.curve_start", BEFORE)
        plan = replace(plan, stop_when=(*plan.stop_when, StopWhen(("vehicle", "body_distance"), length, "end of the track")))

        # ---- run
        values = {"vehicle.speed": ",".join(map(repr, speeds)), "vehicle.curve_radius": f"{RADIUS:g}",
                  "vehicle.front_lateral_displacement": starts}  # fmt: skip
        what = Sweep(plan, values, cases=cases, signals=("vehicle.body_distance",), stop=1.2 * length / min(speeds),
                     measure=Measure(cost_and_gain, COLUMNS))  # fmt: skip
        outcome = sweep(what, FOLDER / f"gyro-cost-{name}.npz")
        table = load(FOLDER / f"gyro-cost-{name}.npz")
        print(f"set {name}: {outcome.done} runs now, {outcome.before} before, {outcome.seconds:.0f} s")

        # ---- analysis: medians over starts that pass; highest scanned speed up to which all starts pass
        tried = np.unique(table["vehicle.speed"])
        summary[name] = results = {case: dict[str, float]() for case in cases}
        for case in cases:
            part = table.where(table["case"] == case)
            lost = np.array([part["derailed"][part["vehicle.speed"] == v].mean() for v in tried])
            safe = tried[: np.argmax(lost > 0)] if lost.any() else tried
            results[case]["safe_to"] = safe[-1] if safe.size else np.nan
            for v in SHOWN:
                good = part.where((part["vehicle.speed"] == v) & (part["derailed"] == 0.0))
                results[case] |= {f"{v:g} m/s: {c}": np.median(good[c]) if len(good) else np.nan for c in list(COLUMNS)[1:]}
                results[case][f"{v:g} m/s: share_derailed"] = lost[tried == v][0]
            if case in ("none", "0 rpm", "2000 rpm"):
                print(f"set {name}, {case}: " + ", ".join(f"{key} {value:.4g}" for key, value in results[case].items()))

        # ---- figure: over the spin; left of it, as a point, the vehicle without gyros
        lines = [(ax, f"{v:g} m/s: {column}", label, factor, colour) for ax, (column, (label, factor)) in zip(
            axes.flat, PANELS.items(), strict=False) for v, colour in zip(SHOWN, figures.COLOURS, strict=False)]  # fmt: skip
        for ax, key, label, factor, colour in [*lines, (axes[1, 2], "safe_to", "safe from every start up to [m/s]", 1.0, "0.2")]:
            at = np.array([results[case][key] * factor for case in cases])
            ax.plot(spins, at[1:], line, color=colour, marker="o", markersize=4, label=f"set {name}, {key.partition(':')[0]}")
            ax.plot(-300.0, at[0] if ax in axes[1] else np.nan, marker, color=colour, fillstyle="none", markersize=6)
            ax.set(ylabel=label, xlabel="spin [rpm]; points at the left: no gyro on board" if ax in axes[1] else "spin [rpm]")
    for v, colour in zip(SHOWN, figures.COLOURS, strict=False):
        axes[0, 0].plot(spins, H * v / RADIUS, color=colour, linewidth=5.0, alpha=0.25, label=f"H v / R, {v:g} m/s")
    axes[0, 0].legend(fontsize=7)
    figures.save(fig, FOLDER / "gyro_cost.png")
    write_summary(FOLDER / "gyro_cost.json", summary)
