"""The cases of the wheel pair, figures 2 to 4: roots and runs, and the margins of claims C1 to C4 that follow from them.

As in gyro_cosim.paper.measures a part of a claim holds where its margin is positive.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..coupling import Jacobi
from ..master import simulate
from ..stability import roots, travel
from ..systems import System
from ..trajectory import Trajectory
from .measures import Margins, decades

RPM = 2 * np.pi / 60  # rad/s
SPIN, SPEED = "gyro.rotor_speed", "vehicle.speed"
Y, PSI, ETA = "vehicle.lateral_displacement", "vehicle.yaw_angle", "gyro.gimbal_angle"
NAMES = {Y: "y", PSI: "psi", ETA: "eta"}
ALGORITHM = Jacobi(2)
STEP = 2e-3  # s
SPAN = 60.0  # s; the paper's text gives no time span for figures 3 and 4: ten decay times of the case with 100 rpm are ~100 s
STAYS = 1e-9  # a root that moves less than this part of its size stays
AT_REST = 0.02  # at rest: below this part of the largest value, to the end of the run
HELD = 5.0  # s at least for which it has to stay so: an oscillation passes zero once in half a period of some 2 s
EVEN = 1e-3  # an amplitude that changes less than this part neither grows nor decays
ON_AXIS = 1e-9  # 1/s, a root whose real part is smaller lies on the imaginary axis
SPEEDS, SPINS = (1.0, 100.0), (0.0, 1000.0)  # m/s, rpm
TURNING = (100, 200)  # rpm of figure 4

Simulate = Callable[[System], Trajectory]


@dataclass(frozen=True, eq=False)
class Observed:
    """Roots over speed at 10 rpm and over spin at 10 m/s, shape (n, 6) each; the largest real part (1/s) of those at 0 rpm;
    the run without spin, and those with, by rpm."""

    speeds: np.ndarray
    over_speed: np.ndarray
    spins: np.ndarray
    over_spin: np.ndarray
    undamped: float
    still: Trajectory
    turning: dict[int, Trajectory]


def simulated(plan: System) -> Trajectory:
    """A run of the FMUs."""
    return simulate(plan, algorithm=ALGORITHM, step=STEP, stop=SPAN).trajectory


def observe(pair: System, run: Simulate = simulated, *, fineness: int = 400) -> Observed:
    """The cases of figures 2 to 4 for the wheel pair `pair`; `fineness`: steps along each root locus, twice that over spin."""
    speeds, spins = np.geomspace(*SPEEDS, fineness), np.linspace(*SPINS, 2 * fineness + 1)
    over_speed = roots(pair.with_value(SPIN, "10rpm"), SPEED, speeds)
    over_spin = roots(pair.with_value(SPEED, 10.0), SPIN, spins * RPM)
    at_ten = pair.with_value(SPEED, 10.0)
    return Observed(
        speeds, over_speed, spins, over_spin, float(over_spin[0].real.max()), run(at_ten.with_value(SPIN, "0rpm")),
        {rpm: run(at_ten.with_value(SPIN, f"{rpm}rpm")) for rpm in TURNING},
    )  # fmt: skip


def claim_1(seen: Observed) -> Margins:
    """Over speed: four of six roots stay, two move, none crosses the imaginary axis."""
    return {"four stay": _just(4, seen.over_speed), "none crosses the imaginary axis": -float(seen.over_speed.real.max())}


def claim_2(seen: Observed) -> Margins:
    """Over spin: two roots stay, four move, none crosses the axis, none reaches the origin."""
    turning = seen.over_spin[1:]  # at 0 rpm the yaw roots lie on the axis (claim C3)
    return {
        "two stay": _just(2, seen.over_spin),
        "none crosses the imaginary axis": -float(turning.real.max()),
        "none reaches the origin": float(np.abs(seen.over_spin).min()),
    }


def claim_3(seen: Observed) -> Margins:
    """Without spin: lateral and yaw motion are only critically stable."""
    return {
        "yaw neither grows nor decays": EVEN - abs(late_to_early(seen.still, PSI) - 1.0),
        "lateral motion neither grows nor decays": EVEN - abs(late_to_early(seen.still, Y) - 1.0),
        "a root on the imaginary axis": ON_AXIS - abs(seen.undamped),
    }


def claim_4(seen: Observed) -> Margins:
    """With spin: y, psi and then the gimbal angle come to rest."""
    settled = {rpm: {name: settling_time(tr, name) for name in NAMES} for rpm, tr in seen.turning.items()}
    latest = SPAN - HELD
    parts = {
        f"{NAMES[name]} at rest at {rpm} rpm": decades(latest, max(t, STEP))
        for rpm, times in settled.items() for name, t in times.items()
    }  # fmt: skip
    together = STEP / 2  # "not before" allows for the same sample
    after = [min(times[ETA], latest) - min(times[PSI], latest) for times in settled.values()]
    return parts | {"the gimbal not before yaw": min(after) + together}


def margins(seen: Observed) -> dict[str, Margins]:
    """Of claims C1 to C4."""
    return {"C1": claim_1(seen), "C2": claim_2(seen), "C3": claim_3(seen), "C4": claim_4(seen)}


def stay(paths: np.ndarray) -> int:
    """How many roots stay."""
    return int((travel(paths) < STAYS).sum())


def _just(count: int, paths: np.ndarray) -> float:
    """Positive where `count` roots stay and no more: decades to the nearer of the two travels about the limit."""
    way = np.sort(np.maximum(travel(paths), 1e-300))
    return min(decades(STAYS, float(way[count - 1])), decades(float(way[count]), STAYS))


def late_to_early(trajectory: Trajectory, name: str) -> float:
    """Largest value in the last third of the run over the largest in the middle third."""
    size, n = np.abs(trajectory[name]), len(trajectory) // 3
    return float(size[-n:].max() / size[n : 2 * n].max())


def settling_time(trajectory: Trajectory, name: str) -> float:
    """Time (s) after which the signal stays below AT_REST of its largest value; beyond SPAN - HELD it has not settled."""
    size = np.abs(trajectory[name])
    return float(trajectory.t[np.flatnonzero(size > AT_REST * size.max())[-1]])
