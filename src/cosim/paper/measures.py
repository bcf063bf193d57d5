"""What is measured of a run of the full vehicle, and the verdicts on claims C6 to C10 that follow from it.

A verdict is a margin for each part of a claim: positive where the part holds, larger the more clearly it does. Comparisons of
two sizes are decades (the logarithm to base 10 of their ratio), so that margins compare across parameters; only their sign
decides. The ledger gives these functions the measures of several starts, the study of draws those of one.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..railway import safety
from ..trajectory import Trajectory

Measures = dict[str, float]
Margins = dict[str, float]  # part of a claim -> margin

Y, PSI, CURVATURE, DISTANCE = (
    f"vehicle.{n}" for n in ("front_lateral_displacement", "front_yaw_angle", "curvature", "body_distance")
)
INNER = "front_left"  # in the curve to the left
FORCE, COEFFICIENT = (f"vehicle.{INNER}_{n}" for n in ("lateral_force", "derailment_coefficient"))
CLIMB = "_climb"
LAST = 2.0  # s at the end of straight track in which it must have settled
SETTLED = 1e-5  # m; the paper speaks of the order of 1e-6 m
RETURNED = 1e-3  # m; y "reduces to zero after the curve section"
END = 50.0  # m, the last of the track behind the curve
STEADY_YAW = (0.5e-3, 2e-3)  # rad; "about 0.001 rad"


def climb(tr: Trajectory) -> float:
    """The farthest any flange went over its rail: above 1 it left it. NaN counts as infinite."""
    ways = np.array([tr[name] for name in tr.names if name.endswith(CLIMB)])
    return float(np.where(np.isnan(ways), np.inf, ways).max())


def straight(tr: Trajectory) -> Measures:
    """Of a run on straight track: largest |y| (m) and |psi| (rad) in its last two seconds, and the climb."""
    last = tr.t > tr.t[-1] - LAST
    return {"y": float(np.abs(tr[Y][last]).max()), "psi": float(np.abs(tr[PSI][last]).max()), "climb": climb(tr)}


def curve(tr: Trajectory) -> Measures:
    """Of a run in the curve: largest |y| (m), |psi| (rad), Y (N) and filtered Y/Q of the inner wheel, climb, way run (m); then

    swing : standard deviation of y (m), and steady : mean |psi| (rad), in the second half of the steady curve;
    after : largest |y| (m) over the last 50 m. A run that derails before the end of the steady curve has infinite swing and yaw,
    one that derails at all is never back.
    """
    curvature, s = np.abs(tr[CURVATURE]), tr[DISTANCE]
    full = np.flatnonzero(curvature > 0.999 * max(curvature.max(), 1e-9))
    steady = full[full.size // 2 :]
    most = climb(tr)
    through = full.size > 0 and full[-1] < tr.t.size - 1  # the curvature has fallen again
    even = np.linspace(tr.t[0], tr.t[-1], tr.t.size)  # the filter wants even steps; a last, shorter one is spread
    filtered = safety.worst({INNER: np.interp(even, tr.t, tr[COEFFICIENT])}, even, np.interp(even, tr.t, s)).value
    after = s > s[-1] - END
    return {
        "y": float(np.abs(tr[Y]).max()),
        "psi": float(np.abs(tr[PSI]).max()),
        "force": float(np.abs(tr[FORCE]).max()),
        "filtered": filtered,
        "swing": float(np.std(tr[Y][steady])) if through else np.inf,
        "steady": float(np.mean(np.abs(tr[PSI][steady]))) if through else np.inf,
        "after": float(np.abs(tr[Y][after]).max()) if most <= 1.0 else np.inf,
        "climb": most,
        "reach": float(s[-1]),
    }


def holds(margins: Mapping[str, float]) -> dict[str, bool]:
    """Which parts hold."""
    return {part: margin > 0.0 for part, margin in margins.items()}


def medians(rows: Sequence[Measures]) -> Measures:
    """Each measure's median over the starts."""
    return {key: float(np.median([row[key] for row in rows])) for key in rows[0]}


def decades(larger: float, smaller: float) -> float:
    """log10(larger / smaller) of two sizes that are not negative; 0 for equal ones, infinite ones included."""
    if larger == smaller:
        return 0.0
    with np.errstate(divide="ignore"):
        return float(np.log10(larger) - np.log10(smaller))


def claim_6(off: Measures, on: Measures) -> Margins:
    """50 m/s straight: off does not settle, on does."""

    def settling(run: Measures) -> float:
        return decades(SETTLED, run["y"]) if run["climb"] <= 1.0 else -np.inf

    return {"off does not settle": -settling(off), "on settles": settling(on)}


def claim_7(off: Sequence[Measures], on: Sequence[Measures]) -> Margins:
    """Curve at 5 m/s: on has the better transients and steady state of y and psi than off, in the median over the starts."""
    without, damped = medians(off), medians(on)
    parts = {"max y": "y", "max psi": "psi", "swing in the curve": "swing"}
    return {part: decades(without[key], damped[key]) for part, key in parts.items()}


def claim_8(off: Sequence[Measures], on: Sequence[Measures]) -> Margins:
    """The same runs: on lowers lateral force and derailment coefficient of the inner wheel."""
    without, damped = medians(off), medians(on)
    return {part: decades(without[key], damped[key]) for part, key in {"Y": "force", "Y/Q": "filtered"}.items()}


def derailing(run: Measures) -> float:
    """Positive where the run derailed, the earlier the larger; else what was missing to the top of the rail, negative."""
    return END / max(run["reach"], 1.0) if run["climb"] > 1.0 else run["climb"] - 1.0


def claim_9(off: Sequence[Measures]) -> Margins:
    """Curve at 8 m/s, off: every start derails."""
    return {"derails": min(derailing(run) for run in off)}


def claim_10(on: Sequence[Measures]) -> Margins:
    """Curve at 8 m/s, on: every start passes; yaw falls to about 0.001 rad, y goes back to 0, in the median."""
    run = medians(on)
    low, high = STEADY_YAW
    return {
        "passes": min(-derailing(r) for r in on),
        "yaw about 0.001 rad": min(decades(run["steady"], low), decades(high, run["steady"])),
        "y back to 0": decades(RETURNED, run["after"]),
    }
