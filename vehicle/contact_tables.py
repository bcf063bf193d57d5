"""Contact of a measured wheel with a measured rail, tabulated for the equations of motion. SI units.

For one side, in its own axes (o outwards, z up, from the running line, over which the wheel's tape line stands when centred), the
tables go over the shift v of the wheel towards its flange, measured at the bottom of the tape circle, and the square of the sine
of the yaw: the contact locus is even in yaw, but for the way ahead, which is odd and stands as its ratio to the sine.

A wheel has two parts, tread and flange, divided where its face leans by 45 degrees: two contacts of a wheel are these two. At
each v and yaw the patches that reach into a part (vehicle.contact_search) are pressed by the load of a wheel at rest. Of a patch
that the division cuts each part has its share of the overlap. Patches of one part are merged, by their loads: the jump from one
to the other is then as smooth as the load makes it. So the tables hold

    height     of the bottom of the tape circle where the part carries that load (m)
    tangent    of the contact angle, towards the flange positive
    out, up    place of the contact from the running line (m)
    ahead      its way ahead of the tape circle's bottom, over the sine of the yaw (m)
    roll       of the wheelset at that shift, which the tables assume (rad)
    sink       normal approach at that load (m)
    stiffness  N / (sink^1.5 E*),  E* = E / (2 (1 - nu^2))  (m^0.5)
    a2, b2     squares of the patch's semi-axes over the sink (m)
    C11, C22, C23, C33     Kalker's coefficients of the patch

with the normal load of a part N = stiffness E* sink^1.5, Kik and Piotrowski's (vehicle.normal_patch). The roll is that of a rigid
wheelset on both rails. Where a part is more than 0.3 mm from touching, what it would be there is that of its nearest place.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import radians, tan

import numpy as np

from .contact_search import Gap, gap_over, outline, placed_rail
from .kalker import RATIO, coefficients
from .normal_patch import kik_piotrowski
from .section import Profile
from .wheelset_contact import TAPE

__all__ = ["QUANTITIES", "Fit", "SideTable", "fit"]

QUANTITIES = ("height", "tangent", "out", "up", "ahead", "roll", "sink", "stiffness", "a2", "b2", "C11", "C22", "C23", "C33")
PARTS = ("tread", "flange")
COARSE, FINE = 1e-3, 1.5e-4  # m, far from the middle and from -7.95 to 10.05 mm
SHIFT = np.round(np.concatenate([np.arange(-20, -8) * COARSE, np.arange(-53, 68) * FINE, np.arange(11, 41) * COARSE]), 10)
YAW2 = np.linspace(0.0, 0.0049, 8)  # to 70 mrad
NEARLY_STRAIGHT = 1e-4  # rad, stands for no yaw
LEAN = radians(45.0)
AWAY = 3e-4  # m
SHALLOW = 2e-5  # m
CELLS = 20  # of the gap: a stretch that is shorter holds no contact
ENOUGH = 1e-5  # of the load


@dataclass(frozen=True)
class SideTable:
    """One wheel on its rail.

    Attributes
    ----------
    tread, flange : array, shape (shifts, yaws, 14)
        The QUANTITIES.
    clearance : float
        Shift at which the flange first touches, without yaw (m).
    top : float
        Shift at which the flange's top is on the rail (m).
    """

    tread: np.ndarray
    flange: np.ndarray
    clearance: float
    top: float


@dataclass(frozen=True)
class Fit:
    """Both sides.

    Attributes
    ----------
    left, right : SideTable
        The same object where the sides are alike.
    """

    left: SideTable
    right: SideTable


@dataclass(frozen=True)
class _Pair:
    """A wheel and its rail in the axes of the left side; `into` is 1 where outwards is towards the flange."""

    wheel: Profile
    rail: tuple[np.ndarray, np.ndarray]
    radius: float
    tape: float
    into: int
    division: float  # y of the wheel's profile

    def over(self, shift: float, yaw: float, roll: float) -> tuple[Gap, tuple[float, float, float]]:
        """The gap, and where the bottom of the tape circle is (m): ahead and up from the axle's middle, and out on the track."""
        a = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
        down = np.array([0.0, a[2], -a[1]]) / np.hypot(a[1], a[2])
        bottom = self.tape * a + self.radius * down
        out = self.tape - self.into * -shift
        locus = outline(self.wheel, self.radius, self.tape, out - bottom[1], yaw, roll)
        return gap_over(locus, self.rail), (bottom[0], bottom[2], out)

    def parts(self, gap: Gap) -> tuple[np.ndarray, np.ndarray]:
        """Which places of the gap are under the tread and which under the flange."""
        on_flange = (np.interp(gap.y, gap.wheel.y, gap.wheel.place) - self.division) * self.into < 0
        return ~on_flange, on_flange


def fit(
    left: tuple[Profile, Profile], right: tuple[Profile, Profile], *, rolling_radius: float, gauge: float, inner_distance: float,
    inclination: float, flange_side: int, load: float, youngs_modulus: float, poisson_ratio: float,
) -> Fit:  # fmt: skip
    """Make the tables.

    Parameters
    ----------
    left, right : (Profile, Profile)
        Wheel and rail of either side, each in the axes of the left.
    rolling_radius, gauge, inner_distance, inclination
        As in vehicle.contact_points (m, m, m, 1).
    flange_side : int
        1: flanges outside the rails, -1: inside.
    load : float
        What a wheel carries at rest (N).
    youngs_modulus, poisson_ratio : float
        Of wheels and rails (Pa, 1).

    Returns
    -------
    Fit
        The tables of both sides.

    Raises
    ------
    ValueError
        If a wheel does not stand on its rail, has no flange on that side, or the flange never reaches the rail.
    """
    tape, into, same = inner_distance / 2 + TAPE, -flange_side, all(a is b for a, b in zip(left, right, strict=True))
    pairs = []
    for wheel, rail in (left,) if same else (left, right):
        across, up, _, _ = placed_rail(rail, gauge, inclination)
        pairs.append(_Pair(wheel, (across, up), rolling_radius, tape, into, _division(wheel, into)))
    rolls = _rolls(pairs)
    tables = [_side(pair, roll, load, (youngs_modulus, poisson_ratio)) for pair, roll in zip(pairs, rolls, strict=True)]
    return Fit(tables[0], tables[-1])


def _division(wheel: Profile, into: int) -> float:
    """Where the face of the wheel first leans by LEAN, on the way from the tape line to the flange."""
    y, _, slope = wheel.fine
    leaning = (slope * into > tan(LEAN)) & (y * into < 0.0)
    if not leaning.any():
        side = "inside" if into > 0 else "outside"
        raise ValueError(f"a wheel with its flange {side} the rail must lean there by 45 degrees somewhere, got none that does")
    return float(y[leaning][int(np.argmin(np.abs(y[leaning])))])


def _rise(pair: _Pair, shift: float, roll: float) -> float:
    """Height of the bottom of the tape circle (m) where the wheel first touches."""
    gap, (_, up, _) = pair.over(shift, 0.0, roll)
    return up - float(gap.gap.min())


def _rolls(pairs: list[_Pair]) -> list[Callable[[float], float]]:
    """The roll of a rigid wheelset over the shift of each side, raising it."""
    v = np.linspace(SHIFT[0], SHIFT[-1], 61)
    rolls = [np.zeros(v.size) for _ in pairs]
    for _ in range(2):
        rises = [np.array([_rise(p, float(x), float(roll)) for x, roll in zip(v, r, strict=True)])
                 for p, r in zip(pairs, rolls, strict=True)]  # fmt: skip
        rolls = [(rises[i] - np.interp(-v, v, rises[-1 - i])) / (2 * pairs[0].tape) for i in range(len(pairs))]
    return [lambda x, r=roll: float(np.interp(x, v, r)) for roll in rolls]  # type: ignore[misc]


def _side(pair: _Pair, roll: Callable[[float], float], load: float, elastic: tuple[float, float]) -> SideTable:
    tables = np.full((2, SHIFT.size, YAW2.size, len(QUANTITIES)), np.nan)
    rises = np.full((2, SHIFT.size, YAW2.size), -np.inf)
    for i, v in enumerate(SHIFT):
        for j, yaw2 in enumerate(YAW2):
            yaw = max(float(np.arcsin(np.sqrt(yaw2))), NEARLY_STRAIGHT)
            gap, bottom = pair.over(float(v), yaw, roll(float(v)))
            least = float(gap.gap.min())
            for k, part in enumerate(pair.parts(gap)):
                if np.count_nonzero(part) <= CELLS:
                    continue
                nearest = float(gap.gap[part].min())
                rises[k, i, j] = bottom[1] - nearest
                if nearest < least + AWAY:
                    row = _pressed(pair, gap, part, bottom, np.sin(yaw), load, elastic)
                    tables[k, i, j] = (*row[:5], roll(float(v)), *row[5:])
    tread, flange = (_whole(tables[k], rises[k]) for k in range(2))
    touching = np.flatnonzero(rises[1, :, 0] >= rises[0, :, 0])
    if touching.size == 0:
        raise ValueError(f"the flange must reach the rail within {1e3 * SHIFT[-1]:g} mm, got none that does: see gauge and"
                         " inner_distance")  # fmt: skip
    first = int(touching[0])
    if SHIFT[first] <= 0.0:
        raise ValueError("a centred wheel must run on its tread, got one on its flange: see gauge and inner_distance")
    return SideTable(tread, flange, float(SHIFT[first]), float(SHIFT[first + int(np.argmax(rises[1, first:, 0]))]))


def _pressed(
    pair: _Pair, gap: Gap, part: np.ndarray, bottom: tuple[float, float, float], sine: float, load: float,
    elastic: tuple[float, float],
) -> tuple[float, ...]:  # fmt: skip
    """The quantities but the roll, where the patches that reach into the part carry `load`, but sunk into it by SHALLOW."""
    least, approach = float(gap.gap[part].min()), 8e-5
    for _ in range(40):
        shares = _shares(gap, part, least + approach, elastic)
        total = sum(share.whole for share in shares)
        factor = (load / total) ** (2 / 3) if total > 0.0 else 2.0
        if abs(factor - 1.0) < ENOUGH or (factor < 1.0 and approach <= SHALLOW):
            break
        approach = max(approach * factor, SHALLOW)
    normal = sum(share.normal for share in shares)
    weight = np.array([share.normal for share in shares]) / normal
    angle = float(weight @ [share.angle for share in shares])
    y = float(weight @ [share.place for share in shares])
    ahead = float(np.interp(y, gap.wheel.y, gap.wheel.x)) - bottom[0]
    sink = approach * float(np.cos(angle))
    E = elastic[0] / (2 * (1 - elastic[1] ** 2))
    a2, b2 = (float(weight @ [getattr(share, axis) ** 2 for share in shares]) / sink for axis in "ab")
    ratio = float(np.clip(np.sqrt(a2 / b2), RATIO[0], 1 / RATIO[0]))
    C = [float(c) for c in coefficients(ratio, 1.0, elastic[1])]
    return (
        bottom[1] - least - approach, pair.into * float(np.tan(angle)), y - pair.tape, float(np.interp(y, *pair.rail)),
        ahead / sine, sink, normal / (sink**1.5 * E), a2, b2, *C,
    )  # fmt: skip


@dataclass(frozen=True)
class _Share:
    """What of a patch lies on a part: load of the patch (N), load, place (m) and angle (rad) of the share, its axes (m)."""

    whole: float
    normal: float
    place: float
    angle: float
    a: float
    b: float


def _shares(gap: Gap, part: np.ndarray, level: float, elastic: tuple[float, float]) -> list[_Share]:
    """The shares of the patches that reach into the part, the wheel pressed down to `level`: by the volume of the overlap."""
    overlap = level - gap.gap
    edges = np.flatnonzero(np.diff(np.concatenate([[False], overlap > 0.0, [False]]).astype(int)))
    found = []
    for start, end in edges.reshape(-1, 2):
        around = slice(max(start - 2, 0), min(end + 2, gap.y.size))
        y, h = gap.y[around], np.maximum(overlap[around], 0.0)
        on = h * part[around]
        if y.size < 5 or not on.any():
            continue
        weight = on**2.5 / (on**2.5).sum()
        place = float(weight @ y)
        whole = h**2.5 / (h**2.5).sum()
        leaning = np.arctan(gap.slope[around])
        radius = float(np.interp(float(whole @ y), gap.wheel.y, gap.wheel.radius))
        pressed = kik_piotrowski(y, overlap[around], float(whole @ leaning), radius, *elastic)
        fraction = float(on.sum() / h.sum())
        found.append(
            _Share(pressed.load, fraction * pressed.load, place, float(weight @ leaning), pressed.a, fraction * pressed.b)
        )
    return found


def _whole(table: np.ndarray, rise: np.ndarray) -> np.ndarray:
    """The table with its empty places filled: the quantities of the nearest shift, and the height of the rise."""
    for j in range(table.shape[1]):
        there = np.flatnonzero(np.isfinite(table[:, j, 0]))
        if there.size == 0:
            raise ValueError("wheel and rail must touch on the tread and on the flange, got profiles that do not")
        for i in np.flatnonzero(~np.isfinite(table[:, j, 0])):
            near = int(there[int(np.argmin(np.abs(there - i)))])
            table[i, j] = table[near, j]
            table[i, j, 0] += min(0.0, max(float(rise[i, j]), table[near, j, 0] - 0.03) - float(rise[near, j]))
    return table
