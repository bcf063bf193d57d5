"""Contacts of a loaded wheelset on its track, left and right, for profiles given by points. SI units.

Lateral displacement and yaw are given, the load presses, height and roll follow: each wheel carries half the axle load upwards,
without friction, so that a contact alone carries Q / cos(delta), and two share it as their overlap makes them
(vehicle.contact_search for the gap, vehicle.normal_patch for the load). A patch is a stretch where the undeformed bodies
overlap: two minima parted by a ridge lower than that are one patch. Its place is the mean over the patch, weighted by the
square of the overlap over its area, its angle the mean of the rail's, and so not those of the first touch.
"""

from math import atan, cos
from typing import NamedTuple

import numpy as np

from .contact_search import Gap, gap_over, outline, placed_rail
from .normal_patch import MODELS, Pressed
from .section import Profile

__all__ = ["TAPE", "Contact", "WheelsetContacts", "contact_points"]

TAPE = 0.07  # m from a wheel's inner face to its tape line
STEPS = 60
ENOUGH = {"kik-piotrowski": 1e-7, "half-space": 1e-4}  # of the approach


class Contact(NamedTuple):
    """One contact of a wheel.

    Attributes
    ----------
    lateral : float
        Place on the rail: y of the rail profile as given, outwards (m).
    contact_angle : float
        Against the running surface, positive towards the flange (rad).
    rolling_radius, normal_force : float
        m, N.
    track_lateral, height, ahead : float
        Place in the track's axes: to the left of its middle, over the running surface, before the axle (m).
    wheel_lateral : float
        y of the wheel profile, outwards (m).
    a, b, peak_pressure : float
        Semi-axes of the patch along and across (m), and Pa.
    """

    lateral: float
    contact_angle: float
    rolling_radius: float
    normal_force: float
    track_lateral: float
    height: float
    ahead: float
    wheel_lateral: float
    a: float
    b: float
    peak_pressure: float


class WheelsetContacts(NamedTuple):
    """What `contact_points` finds.

    Attributes
    ----------
    left, right : tuple of Contact
        From the gauge side outwards.
    roll : float
        Of the wheelset, raising the left wheel (rad).
    axle_height : float
        Of its middle over the running surface (m).
    """

    left: tuple[Contact, ...]
    right: tuple[Contact, ...]
    roll: float
    axle_height: float


class _Side(NamedTuple):
    """A wheel over its rail, in the axes of the left side."""

    wheel: Profile
    rail: tuple[np.ndarray, np.ndarray]
    turn: float
    shift: tuple[float, float]
    sign: int


def contact_points(
    wheel: Profile, rail: Profile, *, rolling_radius: float, gauge: float, inner_distance: float, inclination: float = 0.0,
    lateral: float = 0.0, yaw: float = 0.0, axle_load: float = 1e5, right_wheel: Profile | None = None,
    right_rail: Profile | None = None, youngs_modulus: float = 2.1e11, poisson_ratio: float = 0.28,
    normal: str = "half-space",
) -> WheelsetContacts:  # fmt: skip
    """Find where a loaded wheelset touches its rails.

    Parameters
    ----------
    wheel, rail : Profile
        Of the left side, and of the right one in the mirror.
    rolling_radius : float
        At the tape lines (m).
    gauge : float
        Of the track, 14 mm under the running surface (m).
    inner_distance : float
        Between the inner faces of the wheels, 70 mm inside their tape lines (m).
    inclination : float
        Of the rails inwards, 1/40 say; 0 for a rail profile that already has it (1).
    lateral, yaw : float
        Of the wheelset, to the left (m) and turning left (rad).
    axle_load : float
        N.
    right_wheel, right_rail : Profile, optional
        Of the right side where it is unlike, in the axes of the left: mirrored.
    youngs_modulus, poisson_ratio : float
        Of wheels and rails (Pa, 1).
    normal : str
        A key of vehicle.normal_patch.MODELS: "half-space", exact, or "kik-piotrowski", thirty times as fast.

    Returns
    -------
    WheelsetContacts
        Its `left` and `right`, one `Contact` for each place of contact.

    Raises
    ------
    ValueError
        If a length or the load is not positive, a number is not finite, a wheel does not lie over its rail, or a rail profile
        does not reach down to where the gauge is measured.
    """
    positive = {"rolling_radius": rolling_radius, "gauge": gauge, "inner_distance": inner_distance, "axle_load": axle_load}
    for name, value in positive.items():
        if not (value > 0.0 and np.isfinite(value)):
            raise ValueError(f"{name} must be positive and finite, got {value:g}")
    for name, value, largest in (("lateral", lateral, 0.1), ("yaw", yaw, 0.2), ("inclination", inclination, 0.2)):
        if not abs(value) <= largest:
            raise ValueError(f"{name} must lie in -{largest:g}..{largest:g}, got {value:g}")
    if normal not in MODELS:
        raise ValueError(f"normal must be one of {', '.join(MODELS)}, got {normal!r}")
    sides = []
    for sign, w, r in ((1, wheel, rail), (-1, right_wheel or wheel, right_rail or rail)):
        y, z, across, up = placed_rail(r, gauge, inclination)
        sides.append(_Side(w, (y, z), atan(inclination), (across, up), sign))
    tape = inner_distance / 2 + TAPE
    elastic = (youngs_modulus, poisson_ratio)

    def seat(roll: float, by: str) -> list[tuple[float, tuple[Contact, ...]]]:
        """(height of the axle's middle, contacts) of either side alone under half the load."""
        result = []
        for side in sides:
            locus = outline(side.wheel, rolling_radius, tape, side.sign * lateral, side.sign * yaw, side.sign * roll)
            result.append(_press(gap_over(locus, side.rail), axle_load / 2, elastic, by, side))
        return result

    before, roll, miss = 0.0, 0.0, None
    for _ in range(12):  # secant: the roll at which both sides are seated at one height
        heights = [height for height, _ in seat(roll, "kik-piotrowski")]
        unlike = heights[0] - heights[1]
        if abs(unlike) < 1e-8:
            break
        slope = -2 * tape if miss is None or roll == before else (unlike - miss) / (roll - before)
        before, miss, roll = roll, unlike, roll - unlike / slope
    (left_height, left), (right_height, right) = seat(roll, normal)
    return WheelsetContacts(left, right, roll, (left_height + right_height) / 2)


def _press(gap: Gap, load: float, elastic: tuple[float, float], by: str, side: _Side) -> tuple[float, tuple[Contact, ...]]:
    """(height of the axle's middle, contacts) where one wheel carries `load`: its approach by the rule load ~ approach^1.5."""
    least = float(gap.gap.min())
    approach = 2e-5
    for model in dict.fromkeys(("kik-piotrowski", by)):  # the fast one first: the other then starts near its end
        for _ in range(STEPS):
            patches = _patches(gap, least, approach, elastic, model)
            factor = (load / sum(p.load * cos(angle) for p, angle, _ in patches)) ** (2 / 3)
            if abs(factor - 1.0) < ENOUGH[model]:
                break
            approach *= factor
    contacts = tuple(_contact(gap, place, angle, pressed, side) for pressed, angle, place in patches)
    return -(least + approach), contacts


def _patches(
    gap: Gap, least: float, approach: float, elastic: tuple[float, float], by: str
) -> list[tuple[Pressed, float, float]]:
    """(patch, contact angle, place) of every stretch of overlap."""
    overlap = approach + least - gap.gap
    edges = np.flatnonzero(np.diff(np.concatenate([[False], overlap > 0.0, [False]]).astype(int)))
    result = []
    for start, end in edges.reshape(-1, 2):
        around = slice(max(start - 2, 0), min(end + 2, gap.y.size))
        y, h = gap.y[around], np.maximum(overlap[around], 0.0)
        if y.size < 5:
            continue
        weight = h**2.5 / (h**2.5).sum()
        place = float(weight @ y)
        angle = float(weight @ np.arctan(gap.slope[around]))
        radius = float(np.interp(place, gap.wheel.y, gap.wheel.radius))
        result.append((MODELS[by](y, overlap[around], angle, radius, *elastic), angle, place))
    return result


def _contact(gap: Gap, place: float, angle: float, pressed: Pressed, side: _Side) -> Contact:
    x, wheel, radius = (float(np.interp(place, gap.wheel.y, c)) for c in (gap.wheel.x, gap.wheel.place, gap.wheel.radius))
    z = float(np.interp(place, *side.rail))
    across, up = place - side.shift[0], z - side.shift[1]
    own = across * np.cos(side.turn) + up * np.sin(side.turn)
    return Contact(
        float(own), angle, radius, pressed.load, side.sign * place, z, x, wheel, pressed.a, pressed.b, pressed.peak_pressure
    )
