"""Vehicle 1 of the Manchester benchmarks (`vehicle/library/manchester_1.toml`) against hand calculation.

Its published results were not at hand. By hand: masses on two layers of springs, rails that do not give.
"""

from functools import cache
from importlib.resources import files

import numpy as np

from gyro_cosim.stability import AtRest
from gyro_cosim.systems import System, SystemComponent, catalogue

from .table import Line, Quantity, Table

__all__ = ["at_rest", "modes"]

FILE = str(files("gyro_cosim.vehicle").joinpath("library", "manchester_1.toml"))
GRAVITY = 9.81
BODY, FRAME, WHEELSET = 32000.0, 2615.0, 1813.0  # kg
PITCH_INERTIA, FRAME_PITCH_INERTIA, SPIN_INERTIA = 1.97e6, 1476.0, 112.0  # kg m2, of body, frame and wheelset
RADIUS, HALF_BASE = 0.46, 1.28  # m
UPPER = {"k": 4 * 430e3, "c": 4 * 20e3, "k_x": 4 * 160e3}  # N/m, N s/m: all secondary springs
LOWER = {"k": 8 * 1220e3, "c": 8 * 4e3, "k_x": 8 * 31391e3, "c_x": 8 * 15e3}  # all primary springs
ARM, LEVER = 9.5, 1.0  # m: half the distance of the bogies; of the body's centre over the secondary springs
ABOVE, UNDER = 0.2, 0.14  # m: secondary and primary springs over and under a frame's centre


@cache
def linearised() -> AtRest:
    """The vehicle at rest, its drive off: what it does about the speed is not in the hand calculation."""
    system = System("manchester_1", (SystemComponent("vehicle", FILE),), ())
    return AtRest(system, ("vehicle.drive_on",), ("vehicle.*distance",))


def at_rest() -> Table:
    """Wheel loads."""
    coach = catalogue.component(FILE)
    values = np.array(coach.output(coach.start_state, coach.start_input, coach.start_parameters)).ravel()
    loads = [float(y) for v, y in zip(coach.outputs, values, strict=True) if v.name.endswith("_vertical_force")]
    eighth = (BODY + 2 * FRAME + 4 * WHEELSET) * GRAVITY / 8
    lines = [Line(f"{what} of eight wheel loads, N", ((of(loads), eighth),)) for what, of in (("least", min), ("largest", max))]
    return Table("an eighth of the weight", (Quantity("", ".1f", 0.1),), tuple(lines))


def _roots(M: np.ndarray, K: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Oscillating roots of M q'' + C q' + K q = 0, one of each pair, slowest first (1/s)."""
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    roots = np.linalg.eigvals(A)
    roots = roots[roots.imag > 0.1]
    return roots[np.argsort(roots.imag)]


def _bounce() -> np.ndarray:
    """Body and frames up and down."""
    K, C = (np.array([[a, -a], [-a, a + b]]) for a, b in ((UPPER["k"], LOWER["k"]), (UPPER["c"], LOWER["c"])))
    return _roots(np.diag([BODY, 2 * FRAME]), K, C)


def _pitch() -> np.ndarray:
    """Body pitching, frames up and down in turn, body, frames and wheelsets fore and aft, frames pitching alike.

    Springs act along the axes of the upper body, and so do their preloads: its pitch turns them forward.
    """
    theta, w, x_b, chi, x_f, x_w = np.eye(6)
    K, C = np.zeros((6, 6)), np.zeros((6, 6))
    for matrix, name in ((K, "k"), (C, "c")):
        across = w + ARM * theta  # of the secondary springs, in turn
        matrix += UPPER[name] * np.outer(across, across) + LOWER[name] * np.outer(w, w)
        matrix += LOWER[name] * HALF_BASE**2 * np.outer(chi, chi)
    layers = (
        (x_b, theta, LEVER, x_f + ABOVE * chi, UPPER["k_x"], BODY),
        (x_f, chi, UNDER, x_w, LOWER["k_x"], BODY + 2 * FRAME),
    )
    for place, angle, height, lower, stiffness, mass in layers:
        stretch, preload = lower - place + height * angle, mass * GRAVITY
        K += stiffness * np.outer(stretch, stretch) + preload * (np.outer(angle, stretch) + np.outer(lower - place, angle))
    slip = x_w - x_f + UNDER * chi
    C += LOWER["c_x"] * np.outer(slip, slip)
    rolling = 4 * (WHEELSET + SPIN_INERTIA / RADIUS**2)
    return _roots(np.diag([PITCH_INERTIA, 2 * FRAME, BODY, 2 * FRAME_PITCH_INERTIA, 2 * FRAME, rolling]), K, C)


def modes() -> Table:
    """What moves up and down, pitches, and moves fore and aft."""
    roots, bounce, pitch = linearised().roots((0.0,)), _bounce(), _pitch()
    lines = []
    for what, hand in (
        ("bounce of the body", bounce[0]),
        ("bounce of the frames", bounce[1]),
        ("body fore and aft", pitch[0]),
        ("pitch of the body", pitch[1]),
        ("frames up and down in turn", pitch[2]),
    ):
        ours = roots[np.abs(roots - hand).argmin()]
        lines.append(Line(what, ((float(ours.real), float(hand.real)), (float(ours.imag), float(hand.imag)))))
    quantities = (Quantity("growth, 1/s", ".5g", 0.02, relative=True), Quantity("rate, rad/s", ".6g", 2e-3, relative=True))
    return Table("by hand, masses on two layers of springs and dampers, rails that do not give", quantities, tuple(lines))
