"""The quantities of acceptance.py from a record: forces of wheels, accelerations of the body, stability, wear, comfort. SI."""

from collections.abc import Callable, Mapping

import numpy as np

from . import comfort
from .assessment import COEFFICIENT, FORCE
from .filters import CUT_OFF, band_pass, low_pass, sliding_mean
from .record import HIGH, LOAD, RING, Found, Record, Row, everywhere, largest, median, percentile, rms, somewhere, worst

__all__ = ["ALL"]

BAND, ACROSS, STABLE = (0.4, 10.0), 2.0, 100.0  # Hz; Hz to both sides; m
GRAVITY, WINDOWS = 9.81, 60  # m/s2; of a test by EN 12299
GUIDING, WEAR = "_guiding_force", "_wear_number"


def _wheels(run: Record) -> list[Row]:
    """Y/Q, sum Y, Q, unloading and the quasi-static forces, section by section."""
    rows, wheels, limits, mean = [], run.found.wheels, run.limits, "20 Hz, 2 m mean"
    ratio = {w: sliding_mean(low_pass(run.signal(w + COEFFICIENT), run.t), run.s) for w in wheels}
    forced = [p for p in run.found.pairs if run.has(p + GUIDING)]
    guiding = {p: sliding_mean(low_pass(run.signal(p + GUIDING), run.t), run.s) for p in forced}
    loaded = all(run.has(w + LOAD, w + FORCE) for w in wheels)
    Q = {w: low_pass(run.signal(w + LOAD), run.t) for w in wheels} if loaded else {}
    Y = {w: low_pass(run.signal(w + FORCE), run.t) for w in wheels} if loaded else {}
    Q0 = {w: run.load(w) for w in wheels} if loaded else {}
    for part in run.parts:
        places, inside = run.places(part), run.within(part, RING)

        def at_places(signals: Mapping[str, np.ndarray], places: np.ndarray = places) -> dict[str, np.ndarray]:
            return {name: np.interp(places, run.s, signal) for name, signal in signals.items()}

        rows.append(
            run.judged(
                ("Y/Q", f"{HIGH:g} %", mean), part, worst(at_places(ratio), places, percentile, largest), "1", limits.ratio
            )
        )
        if guiding:
            best = worst(at_places(guiding), places, percentile, largest)
            rows.append(run.judged(("sum Y", f"{HIGH:g} %", mean), part, best, "N", _guiding_limit(run, Q0, best.place)))
        if not loaded:
            continue
        here = {w: q[inside] for w, q in Q.items()}
        at = run.s[inside]
        best = worst(here, at, lambda q: float(np.percentile(q, HIGH)), lambda q: int(np.argmax(q)))
        most = min(limits.wheel_load_over + Q0.get(best.place, np.nan), limits.wheel_load)
        rows.append(run.judged(("Q", f"{HIGH:g} %", "20 Hz"), part, best, "N", most))
        lightened = {w: 1.0 - q / Q0[w] for w, q in here.items()}
        best = worst(lightened, at, lambda q: float(np.percentile(q, HIGH)), lambda q: int(np.argmax(q)))
        rows.append(run.judged(("unloading", f"{HIGH:g} %", "20 Hz"), part, best, "1", limits.unloading))
        if part.kind == "curve":
            for name, signals, limit in (("Y_qst", Y, limits.lateral_quasi_static), ("Q_qst", Q, limits.wheel_load_quasi_static)):
                best = everywhere(worst({w: x[inside] for w, x in signals.items()}, at, median, somewhere))
                rows.append(run.judged((name, "median", "20 Hz"), part, best, "N", limit))
    return rows


def _guiding_limit(run: Record, Q0: Mapping[str, float], pair: str) -> float:
    """Of the sum of guiding forces of a pair, N; NaN without its loads."""
    loads = [load for wheel, load in Q0.items() if wheel.rpartition("_")[0] == pair]
    return run.limits.guiding_factor * (10e3 + sum(loads) / 3.0) if loads else np.nan


def _accelerations(run: Record) -> dict[str, np.ndarray]:
    """Of the car body at its centre of gravity: along its floor to the left, and upwards, m/s2; empty without its signals."""
    if not run.has("body_lateral_velocity", "body_vertical_velocity", "body_roll_angle"):
        return {}
    cant = run.signal("cant_angle") if run.has("cant_angle") else 0.0
    speed = np.gradient(run.s, run.t)
    leaning = GRAVITY * np.sin(cant + run.signal("body_roll_angle"))
    y = np.gradient(run.signal("body_lateral_velocity"), run.t) + run.signal("curvature") * speed**2 + leaning
    return {"y": y, "z": np.gradient(run.signal("body_vertical_velocity"), run.t)}


def _bodies(run: Record) -> list[Row]:
    """Accelerations of the car body, section by section."""
    felt, limits, rows = _accelerations(run), run.limits, []
    if not felt:
        return []
    banded = {axis: band_pass(a, run.t, *BAND) for axis, a in felt.items()}
    words = f"{BAND[0]:g} to {BAND[1]:g} Hz"
    most = {"y": (limits.lateral_acceleration, limits.lateral_rms), "z": (limits.vertical_acceleration, limits.vertical_rms)}
    for part in run.parts:
        inside = run.within(part, 1.0 / BAND[0])
        if np.count_nonzero(inside) < 1.0 / BAND[0] / (run.t[1] - run.t[0]):
            inside = np.zeros_like(inside)  # shorter than a wave of what the band still passes
        for axis, a in banded.items():
            here, at, name = {"body": a[inside]}, run.s[inside], f"{axis}''"
            rows.append(
                run.judged((name, f"{HIGH:g} %", words), part, worst(here, at, percentile, largest), "m/s2", most[axis][0])
            )
            rows.append(
                run.judged((name, "r.m.s.", words), part, everywhere(worst(here, at, rms, somewhere)), "m/s2", most[axis][1])
            )
        if part.kind == "curve":
            inside = run.within(part, RING)
            best = worst({"body": low_pass(felt["y"], run.t)[inside]}, run.s[inside], median, somewhere)
            rows.append(
                run.judged(
                    ("y''_qst", "median", "20 Hz"), part, everywhere(best), "m/s2", limits.lateral_quasi_static_acceleration
                )
            )
    return rows


def _stability(run: Record) -> list[Row]:
    """The r.m.s. of the sum of guiding forces about its strongest frequency, in sections that are long enough."""
    rows = []
    pairs = [
        p for p in run.found.pairs if run.has(p + GUIDING) and all(run.has(f"{p}_{side}{LOAD}") for side in ("left", "right"))
    ]
    Q0 = {f"{p}_{side}": run.load(f"{p}_{side}") for p in pairs for side in ("left", "right")}
    step = float(run.t[1] - run.t[0])
    long = [p for p in run.parts if p.end - p.begin > STABLE and p.kind != "transition"]
    for part in (long or [max(run.parts, key=lambda p: p.end - p.begin)]) if pairs else ():
        inside = run.within(part, 1.0 / BAND[0])
        at = run.s[inside]
        best, words = Found("", np.nan, np.nan, f"shorter than {STABLE:g} m"), f"f0 +- {ACROSS:g} Hz, {STABLE:g} m"
        if at.size and at[-1] - at[0] >= STABLE:
            for pair in pairs:
                force = run.signal(pair + GUIDING)
                f, power = np.fft.rfftfreq(at.size, step), np.abs(np.fft.rfft(force[inside] - force[inside].mean()))
                heard = (f >= BAND[0]) & (f <= CUT_OFF - ACROSS)
                if not np.any(heard) or not np.all(np.isfinite(force)):
                    continue
                strongest = float(f[heard][np.argmax(power[heard])])
                banded = band_pass(force, run.t, max(strongest - ACROSS, BAND[0]), strongest + ACROSS)
                squares = np.concatenate([[0.0], np.cumsum(banded[inside][1:] ** 2 * np.diff(at))])
                ends = at[at >= at[0] + STABLE]
                sliding = np.sqrt((np.interp(ends, at, squares) - np.interp(ends - STABLE, at, squares)) / STABLE)
                k = int(np.argmax(sliding))
                if not best.value > sliding[k]:
                    best, words = (
                        Found(pair, float(ends[k]), float(sliding[k])),
                        f"{strongest:.3g} +- {ACROSS:g} Hz, {STABLE:g} m",
                    )
        rows.append(
            run.judged(
                ("stability", "sum Y r.m.s.", words), part, best, "N", _guiding_limit(run, Q0, best.place or pairs[0]) / 2.0
            )
        )
    return rows


def _wear(run: Record) -> list[Row]:
    """The mean wear number of the wheel that wears most, section by section."""
    worn = {w: run.signal(w + WEAR) for w in run.found.wheels if run.has(w + WEAR)}
    rows = []
    for part in run.parts if worn else ():
        inside = run.within(part, 0.0)
        best = worst({w: x[inside] for w, x in worn.items()}, run.s[inside], lambda x: float(np.mean(x)), somewhere)
        rows.append(run.judged(("T gamma", "mean", "none"), part, everywhere(best), "N", np.nan))
    return rows


def _comfort(run: Record) -> list[Row]:
    """Mean comfort, and the worst window across and upwards, of all but the first window, in which filters settle."""
    felt = _accelerations(run)
    if not felt:
        return []
    felt["x"] = (
        np.gradient(run.signal("body_speed_deviation"), run.t) if run.has("body_speed_deviation") else np.zeros_like(run.t)
    )
    step, missing = float(run.t[1] - run.t[0]), ""
    if not 2.0 * comfort.W_D.f2 * step < 1.0:
        missing = f"recorded at {1.0 / step:.3g} Hz, its filters need {2 * comfort.W_D.f2:g}"
    windows: dict[str, np.ndarray] = {}
    if not missing:
        after = run.t >= run.t[0] + comfort.WINDOW
        if run.t[-1] - run.t[0] < 2.0 * comfort.WINDOW + step:
            missing = f"shorter than two windows of {comfort.WINDOW:g} s"
        else:
            for axis, a in felt.items():
                weighted = comfort.weighted(a, run.t, comfort.W_B if axis == "z" else comfort.W_D)
                windows[axis] = comfort.window_rms(weighted[after], run.t[after])
    few = missing or (f"{len(windows['y'])} of {WINDOWS} windows" if len(windows["y"]) < WINDOWS else "")
    rows = [_mean_comfort(run, windows, few)]
    for axis, name in (("y", "C_Cy"), ("z", "C_Cz")):
        best = Found("body", np.nan, float(windows[axis].max()) if windows else np.nan, missing)
        weighting = comfort.W_B if axis == "z" else comfort.W_D
        rows.append(run.judged((name, "largest", f"{weighting.name}, 5 s"), None, best, "m/s2", np.nan, missing))
    return rows


def _mean_comfort(run: Record, windows: Mapping[str, np.ndarray], few: str) -> Row:
    value = comfort.mean_comfort(windows["x"], windows["y"], windows["z"]) if windows else np.nan
    return run.judged(("N_MV", "mean comfort", "W_d, W_b, 5 s"), None, Found("body", np.nan, value, few), "1", np.nan, few)


ALL: tuple[Callable[[Record], list[Row]], ...] = (_wheels, _bodies, _stability, _wear, _comfort)
