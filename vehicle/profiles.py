"""Cross-sections of wheel and rail as tables, contact between them in the plane, and the equivalent conicity.

A profile is a table z(y), SI, y across, z up. For the LEFT side: y grows towards the field side (outwards). A wheel's z is
the height of its surface over that at y = 0, so the rolling radius is r0 - z. The right side is the mirror image.

    ntcirw_wheel        radius r0 + g0 y + g1 y^2 / 2, fillet and flange on the field side
    conventional_wheel  radius r0 - g0 y, fillet and flange on the gauge side
    rail_head           crown, corners on both sides

These tables show the sections that vehicle.wheel_rail computes with in closed form; tests hold the two together.
"""

from math import pi

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from .profile_files import read
from .section import Profile
from .standard_profiles import rail_60e1, s1002

__all__ = [
    "Profile", "conventional_wheel", "corner_depth", "equivalent_conicity", "ntcirw_wheel", "rail_60e1", "rail_head", "read",
    "rolling_radius_difference", "s1002",
]  # fmt: skip

UNLIKE = 5e-3  # m, how far from the middle a wheelset with unlike sides may run


def rail_head(crown: float = 0.3, corner: float = 0.013, corner_offset: float = 0.02, points: int = 801) -> Profile:
    """Compute a rail head: a crown and two corners, which are circles, down to 70 deg.

    Parameters
    ----------
    crown, corner : float
        Radii of crown and corners (m).
    corner_offset : float
        Distance of the corners' centres from the middle of the head (m).
    points : int
        Number of points.

    Returns
    -------
    Profile
        The section; z = 0 in the middle of the crown.
    """
    depth = corner_depth(crown, corner, corner_offset)
    edge = corner_offset * crown / (crown - corner)  # where the circles touch the crown
    limit = corner_offset + corner * np.sin(np.radians(80.0))
    y = np.linspace(-limit, limit, points)
    on_crown = np.sqrt(crown**2 - y**2) - crown
    on_corner = np.sqrt(np.maximum(corner**2 - (np.abs(y) - corner_offset) ** 2, 0.0)) - depth
    return Profile(y, np.where(np.abs(y) < edge, on_crown, on_corner))


def corner_depth(crown: float, corner: float, corner_offset: float) -> float:
    """Depth (m) under the crown of the centre of a corner circle that touches the crown from inside; arguments in m."""
    return float(crown - np.sqrt((crown - corner) ** 2 - corner_offset**2))


def ntcirw_wheel(
    g0: float = 0.049, g1: float = 10.65, clearance: float = 0.0061, flange_angle: float = np.radians(71.8), *,
    height: float = 0.028, tip: float = 0.012, corner: float = 0.013, corner_offset: float = 0.02, depth: float = 0.0135,
    margin: float = 0.004, width: float = 0.04, points: int = 4001,
) -> Profile:  # fmt: skip
    """Compute an NTCIRW wheel: tread r0 + g0 y + g1 y^2 / 2, fillet of the rail corner's radius, cone, tip, top.

    Parameters
    ----------
    g0, g1 : float
        Conicity at the centre (1) and its gradient (1/m).
    clearance : float
        How far (m) the wheel moves inwards until the flange meets the rail's corner.
    flange_angle : float
        Angle of the cone against the axle (rad).
    height, tip : float
        Height of the flange's top under the running line, and radius of its tip (m).
    corner, corner_offset, depth : float
        Radius of the rail's corner, distance of its centre from the running line and depth under it (m).
    margin : float
        The tread is straight beyond `clearance` + `margin` (m).
    width : float
        How far the tread reaches to the gauge side (m).
    points : int
        Number of points.

    Returns
    -------
    Profile
        The section.

    Raises
    ------
    ValueError
        If the flange is too low for fillet, cone and tip.

    Notes
    -----
    With a gradient g1 as large as the paper's pattern needs, the tread falls below a common rail head beside the running line:
    such a wheel requires a narrow or inclined head, which the model's knife-edge rail stands for.
    """
    end = clearance + margin

    def drop(y: np.ndarray) -> np.ndarray:  # radius less r0 of the tread
        yc = np.clip(y, -end, end)
        fall: np.ndarray = g0 * y + g1 * (yc * y - yc**2 / 2)
        return fall

    # the cone, by the rail's corner circle that touches it at the clearance: its centre runs along a parallel to the cone
    sine, cosine, t = np.sin(flange_angle), np.cos(flange_angle), np.tan(flange_angle)
    centre, below = clearance + corner_offset, float(drop(np.array(clearance))) + depth

    def fillet_centre(v: float) -> tuple[float, float]:
        """Centre of the circle that touches the tread at `v` from the rail's side."""
        slope = g0 + g1 * np.clip(v, -end, end)
        return v - corner * slope / np.hypot(1, slope), float(drop(np.array(v))) + corner / np.hypot(1, slope)

    def miss(v: float) -> float:
        y, r = fillet_centre(v)
        return float(r - (below + t * (y - centre)))

    start = brentq(miss, centre - 0.05, centre + 0.05)
    y_f, r_f = fillet_centre(start)
    cone_start = y_f + corner * sine
    cone_end = centre + (height + corner - (tip + corner) * (1 - cosine) - below) / t + corner * sine
    summit = cone_end + tip * sine
    if not cone_start < cone_end:
        raise ValueError(f"the flange must be high enough for fillet, cone and tip, got {height:g} m")
    y = np.linspace(-width, summit + 0.01, points)
    fillet = r_f - np.sqrt(np.maximum(corner**2 - (y - y_f) ** 2, 0.0))
    cone = below - corner * cosine + t * (y - centre - corner * sine)
    on_tip = height - tip + np.sqrt(np.maximum(tip**2 - (np.clip(y, cone_end, summit) - summit) ** 2, 0.0))
    radius = np.select([y >= cone_end, y >= cone_start, y >= start], [on_tip, cone, fillet], drop(y))
    return Profile(y, -radius)


def conventional_wheel(g0: float = 0.025, clearance: float = 0.007, flange_angle: float = np.radians(70.0)) -> Profile:
    """Compute a conventional wheel: a cone that narrows outwards, the flange on the gauge side.

    Parameters
    ----------
    g0 : float
        Conicity (1).
    clearance, flange_angle : float
        As in `ntcirw_wheel` (m, rad).

    Returns
    -------
    Profile
        The NTCIRW section with g1 = 0, mirrored.
    """
    mirrored = ntcirw_wheel(g0, 0.0, clearance, flange_angle)
    return Profile(-mirrored.y[::-1], mirrored.z[::-1])


def rolling_radius_difference(
    wheel: Profile, rail: Profile, y: np.ndarray, inclination_gap: float = 0.0,
    right_wheel: Profile | None = None, right_rail: Profile | None = None,
) -> np.ndarray:  # fmt: skip
    """Compute the rolling radius difference of a wheelset that does not roll.

    Parameters
    ----------
    wheel, rail : Profile
        Sections of the left side.
    y : array, shape (n,)
        Lateral displacements of the wheelset to the left (m).
    inclination_gap : float
        How far the rail stands outwards of its place: half the gauge widening (m).
    right_wheel, right_rail : Profile, optional
        Of the right side where it is unlike, mirrored.

    Returns
    -------
    array, shape (n,)
        r_left - r_right (m), each where the vertical gap is least.

    Raises
    ------
    ValueError
        If wheel and rail do not overlap.
    """

    def radius_at(wheel: Profile, z_wheel: PchipInterpolator, rail: Profile, shift: float) -> float:
        """-z of the wheel at its contact when it stands `shift` outwards of its nominal place over the rail."""
        place = rail.y + inclination_gap - shift
        inside = (place >= wheel.y[0]) & (place <= wheel.y[-1])
        if not np.any(inside):
            raise ValueError(f"wheel and rail profile must overlap, got none at a lateral displacement of {shift:g} m")
        gap = z_wheel(place[inside]) - rail.z[inside]
        i = int(np.argmin(gap))
        at = place[inside]
        if 0 < i < gap.size - 1:  # vertex of the parabola through the three lowest
            left, low, right = gap[i - 1 : i + 2]
            bend = left - 2 * low + right
            step = 0.5 * (left - right) / bend if bend > 0.0 else 0.0
            return -float(z_wheel(at[i] + step * (at[1] - at[0])))
        return -float(z_wheel(at[i]))

    left, right = (
        (w, PchipInterpolator(w.y, w.z, extrapolate=False), r)
        for w, r in ((wheel, rail), (right_wheel or wheel, right_rail or rail))
    )
    return np.array([radius_at(*left, float(v)) - radius_at(*right, float(-v)) for v in np.atleast_1d(y)])


def equivalent_conicity(
    wheel: Profile, rail: Profile, rolling_radius: float, contact_distance: float, amplitude: float = 3e-3, *,
    right_wheel: Profile | None = None, right_rail: Profile | None = None,
) -> float:  # fmt: skip
    """Compute the equivalent conicity by EN 15302: that of the cone whose kinematic motion has the same wavelength.

    A wheelset follows y'' = -dr(y) / (e r0), dr the rolling radius difference, e the distance of the contact points. Unlike
    sides move it about another place c than the middle: int dr dy from c - amplitude to c + amplitude is 0. The wavelength
    over the full amplitude is computed by quadrature and gives tan g = (pi / wavelength)^2 2 e r0. Where dr is 0 near the
    middle the wheelset runs straight on, which counts.

    Parameters
    ----------
    wheel, rail : Profile
        Sections of the left side.
    rolling_radius, contact_distance : float
        r0 and e (m).
    amplitude : float
        Of the lateral motion (m).
    right_wheel, right_rail : Profile, optional
        Sections of the right side where it is unlike, mirrored.

    Returns
    -------
    float
        tan g; negative where the radius grows the other way (NTCIRW), 0 where dr is 0 over the whole amplitude.

    Raises
    ------
    ValueError
        If a length is not positive, or there is no periodic motion of this amplitude.

    References
    ----------
    EN 15302, Railway applications: wheel-rail contact geometry parameters.
    """
    for name, value in (("rolling_radius", rolling_radius), ("contact_distance", contact_distance), ("amplitude", amplitude)):
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, got {value:g}")
    unlike = right_wheel is not None or right_rail is not None
    reach = amplitude + (UNLIKE if unlike else 0.0)
    y = np.linspace(-reach, reach, 801)
    difference = rolling_radius_difference(wheel, rail, y, 0.0, right_wheel, right_rail)
    if np.max(np.abs(difference)) < 1e-9:
        return 0.0
    work = PchipInterpolator(y, difference / (contact_distance * rolling_radius)).antiderivative()

    def lean(c: float) -> float:  # the work over a swing about c
        return float(work(c + amplitude) - work(c - amplitude))

    places = np.linspace(-reach + amplitude, reach - amplitude, 161) if unlike else np.array([0.0])
    leans = np.array([lean(float(c)) for c in places])
    changes = np.flatnonzero(np.diff(np.sign(leans)))
    if unlike and changes.size == 0:
        raise ValueError(
            f"the rolling radii must balance within {1e3 * UNLIKE:g} mm of the middle for a periodic motion, got none"
        )
    nodes, weights = np.polynomial.legendre.leggauss(800)  # y = c + amplitude sin(u) takes the roots at the turning points away
    u = nodes * pi / 2
    for near in sorted(changes, key=lambda i: abs(places[i])) if unlike else [0]:  # the nearest place that it swings about
        c = float(brentq(lean, places[near], places[near + 1], xtol=1e-12)) if unlike else 0.0
        end = np.where(u > 0.0, work(c + amplitude), work(c - amplitude))  # alike but for rounding
        square = 2 * (end - work(c + amplitude * np.sin(u)))
        sign = 1.0 if np.sum(square) > 0.0 else -1.0
        if np.all(sign * square > 0.0):
            break
    else:
        raise ValueError("the rolling radius difference must turn the wheelset back within the amplitude for a periodic motion")
    wavelength = 2 * np.sum(weights * pi / 2 * amplitude * np.cos(u) / np.sqrt(sign * square))
    return float(sign * (pi / wavelength) ** 2 * 2 * contact_distance * rolling_radius)
