"""What a run says of a railway vehicle: did it stay on the track, and how near was it to leaving it?

A component is taken for a railway vehicle if it calls its outputs like one:

    body_distance                   along the track, m
    PAIR_lateral_displacement       m, and PAIR_yaw_angle, rad, of each wheel pair; PAIR_guiding_force, N, its sum of Y
    WHEEL_climb                     way of the flange over the rail: 0 first touch, 1 on top
    WHEEL_lateral_force             Y, N, and WHEEL_derailment_coefficient, Y/Q
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..trajectory import Trajectory
from . import causes, safety, track_sections
from .filters import CUT_OFF

if TYPE_CHECKING:
    from .acceptance import Acceptance

DISTANCE, CLIMB, COEFFICIENT, FORCE = "body_distance", "_climb", "_derailment_coefficient", "_lateral_force"
LATERAL, YAW = "_lateral_displacement", "_yaw_angle"


@dataclass(frozen=True)
class Assessment:
    """What a run says of one railway vehicle.

    Parameters
    ----------
    vehicle, wheels, pairs
        Its name in the system; the names of its wheels and wheel pairs.
    verdict
        Whether a wheel left its rail.
    worst
        The largest Y/Q by EN 14363; None where too few points a second were recorded for the filter, and where the vehicle
        has not moved forward all the time.
    climb
        The farthest that a flange went over its rail: 0 where it first touches, 1 on top, where it derails; infinite for a NaN.
    lateral, yaw
        For each pair the largest size over the run, and that in its last tenth, in m and in rad.
    acceptance
        The table of acceptance.py; None where nobody asked for it.
    """

    vehicle: str
    wheels: tuple[str, ...]
    pairs: tuple[str, ...]
    verdict: safety.Verdict
    worst: safety.Extreme | None
    climb: float
    lateral: dict[str, tuple[float, float]]
    yaw: dict[str, tuple[float, float]]
    acceptance: "Acceptance | None" = None


def assess(trajectory: Trajectory) -> tuple[Assessment, ...]:
    """Assess every railway vehicle whose outputs were recorded.

    Parameters
    ----------
    trajectory
        Of a run.

    Returns
    -------
    assessments
        Empty where there is no vehicle, or too little of a run to filter.
    """
    found = vehicles_in(trajectory.names) if len(trajectory) > 100 else ()
    return tuple(_assessed(trajectory, *one) for one in found)


def vehicles_in(names: Sequence[str]) -> tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...]:
    """The railway vehicles among signals.

    Parameters
    ----------
    names
        Of the signals, `component.output`.

    Returns
    -------
    vehicles
        Of each its name, its wheels, whose climb and derailment coefficient are both there, and its wheel pairs.
    """
    found = []
    for name in names:
        vehicle, dot, signal = name.rpartition(".")
        wheels = _wheels(names, vehicle) if dot and signal == DISTANCE else ()
        found += [(vehicle, wheels, _pairs(names, vehicle))] if wheels else []
    return tuple(found)


def _wheels(names: Sequence[str], vehicle: str) -> tuple[str, ...]:
    start = f"{vehicle}."
    climbing = [n[len(start) : -len(CLIMB)] for n in names if n.startswith(start) and n.endswith(CLIMB)]
    return tuple(w for w in climbing if f"{start}{w}{COEFFICIENT}" in names)


def _pairs(names: Sequence[str], vehicle: str) -> tuple[str, ...]:
    start = f"{vehicle}."
    moving = [n[len(start) : -len(LATERAL)] for n in names if n.startswith(start) and n.endswith(LATERAL)]
    wheeled = {wheel.rpartition("_")[0] for wheel in _wheels(names, vehicle)}  # not a car body, not a bogie frame
    return tuple(p for p in moving if p in wheeled and f"{start}{p}{YAW}" in names)


def _assessed(trajectory: Trajectory, vehicle: str, wheels: tuple[str, ...], pairs: tuple[str, ...]) -> Assessment:
    t = trajectory.t
    even = np.linspace(t[0], t[-1], t.size)  # the filter wants even steps; a last, shorter one is spread

    def signal(name: str) -> np.ndarray:
        return np.asarray(np.interp(even, t, trajectory[f"{vehicle}.{name}"]))

    def extent(suffix: str) -> dict[str, tuple[float, float]]:
        sizes = {pair: np.abs(trajectory[f"{vehicle}.{pair}{suffix}"]) for pair in pairs}
        return {pair: (float(size.max()), float(size[-max(1, size.size // 10) :].max())) for pair, size in sizes.items()}

    distance = signal(DISTANCE)
    climbs = {w: trajectory[f"{vehicle}.{w}{CLIMB}"] for w in wheels}
    fine_enough = t.size > 3 * CUT_OFF * (t[-1] - t[0]) and bool(np.all(np.diff(distance) > 0.0))
    return Assessment(
        vehicle,
        wheels,
        pairs,
        _verdict(trajectory, vehicle, wheels, safety.verdict(climbs, t, trajectory[f"{vehicle}.{DISTANCE}"])),
        safety.worst({w: signal(w + COEFFICIENT) for w in wheels}, even, distance) if fine_enough else None,
        max(float(np.where(np.isnan(climb), np.inf, climb).max()) for climb in climbs.values()),
        extent(LATERAL),
        extent(YAW),
    )


def _verdict(trajectory: Trajectory, vehicle: str, wheels: tuple[str, ...], climbed: safety.Verdict) -> safety.Verdict:
    """The verdict with its cause, or with the track that it speaks of."""
    lifted = causes.lifted(trajectory, vehicle, wheels)
    found = lifted if lifted.derailed and not climbed.t <= lifted.t else climbed
    if found.derailed:
        return replace(found, cause=found.cause or causes.cause(trajectory, vehicle, wheels, found))
    distance = trajectory[f"{vehicle}.{DISTANCE}"]
    if f"{vehicle}.curvature" not in trajectory.names or not np.all(np.diff(distance) > 0.0):
        return found
    passed = track_sections.sections(distance, trajectory[f"{vehicle}.curvature"])
    unfinished = "" if passed[-1].whole else passed[-1].words
    return replace(found, through=track_sections.words(passed), unfinished=unfinished)
