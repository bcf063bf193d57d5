"""The paper's second part: the full vehicle, figures 6 to 10, claims C5 to C10, by co-simulation of the FMUs.

Everything is computed for two vehicles side by side, since a choice that the paper does not document decides C6 and C10: with
Table 2's wheels as they are (set A), and with wheels almost without spin inertia, as in equations (1)-(3) (set B).
"Off" is 0 rpm, "on" 2000 rpm. A run that hunts in the flanges is chaotic, so every case in the curve is run for several starts
a tenth of a millimetre apart; figures show the first, verdicts count all.
"""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cosim import catalogue, figures, safety
from cosim.assessment import Assessment, assess
from cosim.coupling import Jacobi
from cosim.master import Options, simulate
from cosim.recording import Recording
from cosim.report import Claim
from cosim.ssd import system as named_system
from cosim.system import System
from cosim.trajectory import Trajectory

SETS = {"A": "Table 2's wheels", "B": "no spin inertia"}
SYSTEMS = {"A": "", "B": "-b"}
SPEEDS, SPINS = (5, 8), {"off": "0rpm", "on": "2000rpm"}
STARTS = ("0mm", "0.1mm", "-0.1mm")
STRAIGHT = 120.0  # s on straight track, until what settles has settled
AFTER = 200.0  # m of straight track behind the curve
RECORDED = (
    "vehicle.body_distance", "vehicle.curvature", "vehicle.*_lateral_displacement", "vehicle.*_yaw_angle", "vehicle.*_climb",
    "vehicle.*_derailment_coefficient", "vehicle.*_lateral_force",
)  # fmt: skip
Y, PSI, CURVATURE, DISTANCE = (
    f"vehicle.{n}" for n in ("front_lateral_displacement", "front_yaw_angle", "curvature", "body_distance")
)
INNER = "front_left"  # in the curve to the left
SETTLED = 1e-5  # m; the paper speaks of the order of 1e-6 m
RETURNED = 1e-3  # m; y "reduces to zero after the curve section"
STEADY_YAW = (0.5e-3, 2e-3)  # rad; "about 0.001 rad"


@dataclass(frozen=True, eq=False)
class Case:
    """One run: parameter set, speed (m/s), gyro "on" or "off", number of the start; what came out."""

    set: str
    speed: int
    gyro: str
    start: int
    trajectory: Trajectory
    assessment: Assessment

    @property
    def derailed(self) -> bool:
        """Whether a wheel left its rail."""
        return self.assessment.verdict.derailed


Key = tuple[str, int, str, int]


def reproduce(folder: Path, *, progress: Callable[[float, float], None] | None = None) -> tuple[list[Claim], list[Path]]:
    """Draw figures 6 to 10 into `folder`; returns the claims C5 to C10 and the files."""
    curve: list[Key] = [(s, v, g, k) for s in SETS for v in SPEEDS for g in SPINS for k in range(len(STARTS))]
    straight: list[Key] = [(s, 50, g, 0) for s in SETS for g in SPINS]
    cases = _run_all([*straight, *curve], progress)
    jobs = (_figure_6, _figures_7_and_8, _figures_9_and_10)
    claims, files = [_degrees_of_freedom()], []
    for job in jobs:
        found, drawn = job(cases, folder)
        claims += found
        files += drawn
    return claims, files


def _run_all(keys: Sequence[Key], progress: Callable[[float, float], None] | None) -> dict[Key, Case]:
    """All runs, on all cores. The FMUs are built here, once, before the processes begin."""
    for source in sorted({part.source for key in keys for part in _plan(key).parts}):
        catalogue.fmu(source)
    cases: dict[Key, Case] = {}
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as pool:
        for case in pool.map(_run, keys):
            cases[case.set, case.speed, case.gyro, case.start] = case
            if progress is not None:
                progress(len(cases), len(keys))
    return cases


def _plan(key: Key) -> System:
    name, speed, gyro, start = key
    kind = "lrt-straight" if speed > max(SPEEDS) else "lrt-curve"
    plan = (
        named_system(kind + SYSTEMS[name]).with_value("vehicle.speed", float(speed)).with_value("gyro.rotor_speed", SPINS[gyro])
    )
    return plan.with_value("vehicle.front_lateral_displacement", STARTS[start])


def _run(key: Key) -> Case:
    plan = _plan(key)
    stop = STRAIGHT if key[1] > max(SPEEDS) else (_curve_end(plan) + AFTER) / key[1]
    options = Options(record=Recording(select=RECORDED, every=2))
    trajectory = simulate(plan, algorithm=Jacobi(1), stop=stop, options=options).trajectory
    (assessment,) = assess(trajectory)
    return Case(*key, trajectory, assessment)


def _curve_end(plan: System) -> float:
    """Where the exit transition ends (m), from the vehicle's own parameters."""
    start = {v.name: v.start for v in catalogue.component(plan.parts[0].source).parameters}
    return start["curve_start"] + 2 * start["transition_length"] + start["curve_length"]


def _degrees_of_freedom() -> Claim:
    """C5: velocities among the states of the vehicle and of two gyro units, and the spin of each rotor."""
    plan = named_system("lrt-curve")
    counts = []
    for part in plan.parts:
        c = catalogue.component(part.source)
        velocities = sum(v.unit in ("m/s", "rad/s") and v.variability == "continuous" for v in c.states)
        rotors = sum(v.name == "rotor_speed" for v in c.parameters)  # held at its speed: a degree of freedom that is prescribed
        counts.append(velocities + rotors)
    return Claim(
        "C5", "sec. 3.1", "the full vehicle has 28 degrees of freedom", "28",
        " + ".join(map(str, counts)) + f" = {sum(counts)} (vehicle, two gyro units with their rotors)",
        {"28 degrees of freedom": sum(counts) == 28},
    )  # fmt: skip


def _figure_6(cases: dict[Key, Case], folder: Path) -> tuple[list[Claim], list[Path]]:
    """Straight track at 50 m/s over five waves: claim C6."""
    made, axes = figures.figure(2, len(SETS), (6.0 * len(SETS), 6.0), sharex=True)
    words, parts = [], {}
    for column, (name, label) in enumerate(SETS.items()):
        for (gyro, _), colour in zip(SPINS.items(), figures.COLOURS, strict=False):
            tr = cases[name, 50, gyro, 0].trajectory
            axes[0, column].plot(tr.t, tr[Y] * 1e3, color=colour, linewidth=1.0, label=gyro)
            axes[1, column].plot(tr.t, tr[PSI] * 1e3, color=colour, linewidth=1.0, label=gyro)
            last = tr.t > tr.t[-1] - 2.0
            y, psi = float(np.abs(tr[Y][last]).max()), float(np.abs(tr[PSI][last]).max())
            lost = cases[name, 50, gyro, 0].derailed
            words.append(f"{name} {gyro}: |y| {y:.1e} m, |psi| {psi:.1e} rad" + (", derailed" if lost else ""))
            settled = y < SETTLED and not lost
            parts[f"{name}: {'off does not settle' if gyro == 'off' else 'on settles'}"] = settled == (gyro == "on")
        axes[0, column].set_title(f"set {name}: {label}, 50 m/s", fontsize=10)
        axes[1, column].set_xlabel("time [s]")
    for ax, label in zip(axes[:, 0], ("lateral displacement y [mm]", "yaw angle $\\psi$ [mrad]"), strict=True):
        ax.set_ylabel(label)
    axes[0, 0].legend()
    claim = Claim(
        "C6", "fig. 6", "50 m/s over waves of 50 m and 10 mm: off does not settle, on goes to y about 1e-6 m and yaw 0",
        "off critically stable, on settles", "in the last 2 s " + "; ".join(words), parts,
        "five waves, so that there is a steady state; spin inertia as in Table 2 makes the pair diverge in yaw above about 4 m/s",
    )  # fmt: skip
    return [claim], [figures.save(made, folder / "figure_6.png")]


def _figures_7_and_8(cases: dict[Key, Case], folder: Path) -> tuple[list[Claim], list[Path]]:
    """The curve at 5 m/s: claims C7 and C8."""
    seven = _over_time(cases, 5, tuple(SPINS), (Y, PSI))
    inner = {f"vehicle.{INNER}_lateral_force": ("lateral force Y, inner front wheel [kN]", 1e-3),
             f"vehicle.{INNER}_derailment_coefficient": ("Y/Q, inner front wheel [1]", 1.0)}  # fmt: skip
    eight = _over_time(cases, 5, tuple(SPINS), tuple(inner), inner)
    words7, words8, parts7, parts8, lost = [], [], {}, {}, []
    for name in SETS:
        found = {gyro: [_measures(cases[name, 5, gyro, k]) for k in range(len(STARTS))] for gyro in SPINS}
        median = {gyro: {key: float(np.median([m[key] for m in rows])) for key in rows[0]} for gyro, rows in found.items()}
        off, on = median["off"], median["on"]
        for key, what in (("y", "max y"), ("psi", "max psi"), ("swing", "swing in the curve")):
            parts7[f"{name}: {what}"] = on[key] < off[key]
        for key, what in (("force", "Y"), ("filtered", "Y/Q")):
            parts8[f"{name}: {what}"] = on[key] < off[key]
        words7.append(
            f"{name}: max |y| {off['y'] * 1e3:.1f} -> {on['y'] * 1e3:.1f} mm, "
            f"max |psi| {off['psi'] * 1e3:.0f} -> {on['psi'] * 1e3:.0f} mrad, "
            f"swing of y {off['swing'] * 1e3:.2f} -> {on['swing'] * 1e3:.2f} mm"
        )
        words8.append(
            f"{name}: Y {off['force'] / 1e3:.1f} -> {on['force'] / 1e3:.1f} kN, "
            f"Y/Q (EN 14363) {off['filtered']:.2f} -> {on['filtered']:.2f}"
        )
        lost += [f"{name} {gyro} derails in {_lost(cases, name, 5, gyro)} of {len(STARTS)} runs" for gyro in SPINS
                 if _lost(cases, name, 5, gyro)]  # fmt: skip
    note = "medians over the starts, off -> on" + ("; " + ", ".join(lost) if lost else "")
    claims = [
        Claim("C7", "fig. 7", "R = 50 m at 5 m/s: on has the better transients and steady state of y and psi",
              "on better than off", "; ".join(words7), parts7, note),
        Claim("C8", "fig. 8", "same run: on lowers lateral force and derailment coefficient of the inner wheel", "both lower",
              "; ".join(words8), parts8, note),
    ]  # fmt: skip
    return claims, [figures.save(seven, folder / "figure_7.png"), figures.save(eight, folder / "figure_8.png")]


def _figures_9_and_10(cases: dict[Key, Case], folder: Path) -> tuple[list[Claim], list[Path]]:
    """The curve at 8 m/s: claims C9 and C10."""
    nine, ten = (_over_time(cases, 8, (gyro,), (Y, PSI)) for gyro in SPINS)
    parts9, words9, parts10, words10 = {}, [], {}, []
    for name in SETS:
        count = _lost(cases, name, 8, "off")
        parts9[f"{name}: derails"] = count == len(STARTS)
        words9.append(f"{name}: derails in {count} of {len(STARTS)} runs; {cases[name, 8, 'off', 0].assessment.verdict.text}")
        rows = [_measures(cases[name, 8, "on", k]) for k in range(len(STARTS))]
        steady, after = (float(np.median([row[key] for row in rows])) for key in ("steady", "after"))
        parts10[f"{name}: passes"] = _lost(cases, name, 8, "on") == 0
        parts10[f"{name}: yaw about 0.001 rad"] = STEADY_YAW[0] < steady < STEADY_YAW[1]
        parts10[f"{name}: y back to 0"] = after < RETURNED
        words10.append(f"{name}: derails in {_lost(cases, name, 8, 'on')} of {len(STARTS)} runs, mean |psi| in the steady curve "
                       f"{steady:.4f} rad, |y| in the last 50 m {after * 1e3:.2f} mm")  # fmt: skip
    claims = [
        Claim("C9", "fig. 9", "R = 50 m at 8 m/s, off: derails", "derails", "; ".join(words9), parts9),
        Claim("C10", "fig. 10", "R = 50 m at 8 m/s, on: passes; yaw falls to about 0.001 rad, y goes back to 0 after the curve",
              "passes, 0.001 rad, back to 0", "; ".join(words10), parts10,
              "with Table 2's spin inertia the vehicle hunts on straight track at 8 m/s, gyro or not"),
    ]  # fmt: skip
    return claims, [figures.save(nine, folder / "figure_9.png"), figures.save(ten, folder / "figure_10.png")]


def _lost(cases: dict[Key, Case], name: str, speed: int, gyro: str) -> int:
    """In how many of the starts a wheel left its rail."""
    return sum(cases[name, speed, gyro, k].derailed for k in range(len(STARTS)))


def _measures(case: Case) -> dict[str, float]:
    """Largest |y|, |psi|, Y and filtered Y/Q of the inner wheel, then the steady curve and the end.

    In the second half of the steady curve: the swing of y and the mean |psi|; over the last 50 m: the largest |y|.
    What a derailed run did not reach counts as infinite.
    """
    tr = case.trajectory
    curvature, s = np.abs(tr[CURVATURE]), tr[DISTANCE]
    full = np.flatnonzero(curvature > 0.999 * curvature.max())
    steady = full[full.size // 2 :]
    reached = not case.derailed
    even = np.linspace(tr.t[0], tr.t[-1], tr.t.size)  # the filter wants even steps; a last, shorter one is spread
    inner = np.interp(even, tr.t, tr[f"vehicle.{INNER}_derailment_coefficient"])
    after = s > s[-1] - 50.0
    return {
        "y": float(np.abs(tr[Y]).max()),
        "psi": float(np.abs(tr[PSI]).max()),
        "force": float(np.abs(tr[f"vehicle.{INNER}_lateral_force"]).max()),
        "filtered": safety.worst({INNER: inner}, even, np.interp(even, tr.t, s)).value,
        "swing": float(np.std(tr[Y][steady])),
        "steady": float(np.abs(tr[PSI][steady]).mean()),
        "after": float(np.abs(tr[Y][after]).max()) if reached else float("inf"),
    }


def _over_time(
    cases: dict[Key, Case], speed: int, gyros: Sequence[str], signals: Sequence[str],
    labels: dict[str, tuple[str, float]] | None = None,
) -> Any:  # fmt: skip
    """One row a set, one column a signal, one curve a state of the gyro."""
    labels = labels or {Y: ("lateral displacement y [mm]", 1e3), PSI: ("yaw angle $\\psi$ [mrad]", 1e3)}
    made, axes = figures.figure(len(SETS), len(signals), (6.0 * len(signals), 3.4 * len(SETS)))
    for row, (name, described) in zip(axes, SETS.items(), strict=True):
        for ax, signal in zip(row, signals, strict=True):
            label, factor = labels[signal]
            for gyro in gyros:
                case = cases[name, speed, gyro, 0]
                colour = figures.COLOURS[tuple(SPINS).index(gyro)]
                tr = case.trajectory
                ending = ", derailed" if case.derailed else ""
                ax.plot(tr.t, tr[signal] * factor, color=colour, linewidth=0.9, label=f"gyro {gyro}{ending}")
                if case.derailed:
                    ax.plot(tr.t[-1], tr[signal][-1] * factor, "x", color=colour, markersize=8)
            ax.set_ylabel(label)
            ax.set_xlabel("time [s]")
            ax.set_title(f"set {name}: {described}, R = 50 m at {speed} m/s", fontsize=9)
            ax.legend(fontsize=7)
    return made
