"""One wheel on one rail: where tread and flange touch in space, and the forces there. Tread and flange may touch at once.

The wheel is a surface of revolution about the axle line (centre c, unit vector a towards the flange) of radius R(d), d being
the distance along a from the wheel's reference plane. The piece of rail that can touch is a circular cylinder of radius q along
the rail's tangent t. Then the contact is that of the cylinder's centre line C + x t with the wheel's profile grown by q: exact
for a circular rail section. The gap along the centre line

    f(x) = rho - R(d),   d = (u + x t).a,   rho^2 = |u + x t|^2 - d^2,   u = C - c

is smallest where the wheel's normal is square to the rail, so f' = rho' - R' (t.a) = 0 gives the contact in space, with its
shift along the rail by yaw. Full Newton steps find it (one on the tread, three on the flange):

    rho' = ((u + x t).t - d (t.a)) / rho,   f'' = ((1 - (t.a)^2) - rho'^2) / rho - R'' (t.a)^2.

The force on the wheel acts along n = (R' a - e_rho) / sqrt(1 + R'^2); the penetration along n is -f / sqrt(1 + R'^2).

Tread: knife-edge rail (q = 0), R = r0 + g0 d + g1 d^2 / 2, straight beyond +-`tread_end`: the conicity is literally
g0 + g1 d, the paper's gamma0 + gamma1 y. Normal force N = K delta^1.5 max(1 + c delta', 0), Hertz with a nearly circular
patch: K = (4/3) E* sqrt(R_e), a b = R_e delta, 1 / R_e the mean of the curvatures of wheel (1 / r0) and rail crown.
Flange: the rail's corner (q its radius, centre `corner_offset` beside and `corner_depth` below the running line) against
a cone of the flange angle from a displacement of `clearance` on, a tip arc, and a flat top: climb and derailment happen.
The wheel's fillet between tread and flange has the radius of the rail's corner, so that grown by it the fillet is the
corner point between the two. N = k p^2 / (p + p_s): Hertz is stiff against the rail's lateral support k, the blend p_s
keeps it smooth at touch. Its tangential stiffness is that of a fixed patch in proportion to N: smooth at N = 0.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from .creep_laws import LAWS, Patch, polach
from .friction import Friction, slip_speed
from .kalker import Coefficients
from .rotation import cross, dot

__all__ = [
    "SLOWEST",
    "Profile",
    "Touch",
    "Wheel",
    "flange_press",
    "flange_profile",
    "forces_at",
    "hertz_stiffness",
    "shear_modulus",
    "touch",
    "tread_press",
    "tread_profile",
    "wheel_on_rail",
]

BLEND = 20e-6  # m, p_s
LEAST_DEPTH = 1e-9  # m, keeps the patch of a lifted wheel from vanishing
SLOWEST = 0.05  # m/s, creepages at lower speed are taken over this one

Profile = Callable[[Any], tuple[Any, Any, Any]]  # d -> R, R', R''


@dataclass(frozen=True)
class Wheel:
    """Where a wheel is and how it moves, in track axes.

    Attributes
    ----------
    centre : casadi.SX, shape (3, 1)
        Middle of its reference plane (m).
    axle : casadi.SX, shape (3, 1)
        Unit vector along the axle towards the flange.
    origin, velocity : casadi.SX, shape (3, 1)
        Place (m) and velocity (m/s) of the wheel frame's centre.
    rotation : casadi.SX, shape (3, 1)
        The wheel's absolute angular velocity (rad/s).
    speed : casadi.SX
        What the creepages refer to (m/s).
    friction : callable
        Speed of slip (m/s) -> coefficient of friction on its rail.
    """

    centre: ca.SX
    axle: ca.SX
    origin: ca.SX
    velocity: ca.SX
    rotation: ca.SX
    speed: Any
    friction: Friction


@dataclass(frozen=True)
class Touch:
    """One contact: force (N) on the wheel, moment about the frame's origin (N m), and what is reported of it."""

    force: ca.SX
    moment: ca.SX
    normal_load: Any
    gap: Any  # along the normal, negative in contact, m
    depth: Any  # d at the contact, m
    slope: Any  # R', tangent of the contact angle
    creepages: tuple[Any, Any, Any]
    heat: Any  # creep power over speed: T gamma, N
    approach_rate: Any  # delta', m/s


def tread_profile(s: Mapping[str, ca.SX]) -> Profile:
    """R of the tread."""
    end = s["flange_clearance"] + s["tread_margin"]

    def profile(d: Any) -> tuple[Any, Any, Any]:
        dc = ca.fmin(ca.fmax(d, -end), end)
        g0, g1 = s["conicity"], s["conicity_gradient"]
        return s["rolling_radius"] + g0 * d + g1 * (dc * d - dc * dc / 2), g0 + g1 * dc, g1 * (ca.fabs(d) <= end)

    return profile


def flange_profile(s: Mapping[str, ca.SX]) -> tuple[Profile, Any]:
    """R of the flange grown by the rail's corner radius, d counted from the corner's centre; and the d of the tip's top."""
    tangent = ca.tan(s["flange_angle"])
    tip = s["flange_tip_radius"] + s["corner_radius"]
    clear, offset = s["flange_clearance"], s["corner_offset"]
    root = tread_profile(s)(clear)[0] + s["corner_depth"]  # grown radius where the cone meets the rail at the clearance
    top = s["rolling_radius"] + s["flange_height"] + s["corner_radius"]
    cosine = 1 / ca.sqrt(1 + tangent * tangent)
    cone_end = clear + offset + (top - tip * (1 - cosine) - root) / tangent
    summit = cone_end + tip * tangent * cosine

    def profile(d: Any) -> tuple[Any, Any, Any]:
        on_arc = ca.fmin(ca.fmax(d, cone_end), summit)
        height = ca.sqrt(tip * tip - (on_arc - summit) ** 2)
        past = ca.logic_and(d > cone_end, d < summit)
        R = top - tip + height + tangent * ca.fmin(d - cone_end, 0.0)
        return R, (summit - on_arc) / height, -past * tip * tip / height**3

    return profile, summit


def touch(wheel: Wheel, point: ca.SX, t: ca.SX, q: Any, profile: Profile, newton: int) -> tuple[Any, ...]:
    """Contact of the line through `point` along the unit vector `t`, grown by `q`: (gap, d, R', n, contact point)."""
    u = point - wheel.centre
    te, ua, ut = dot(t, wheel.axle), dot(u, wheel.axle), dot(u, t)
    uu = dot(u, u)
    x = (ua * te - ut) / (1 - te * te)  # nearest to the axle
    for _ in range(newton):
        d, along = ua + x * te, ut + x
        rho = ca.sqrt(uu + x * (2 * ut + x) - d * d)
        _, slope, curvature = profile(d)
        rho_x = (along - d * te) / rho
        x = x - (rho_x - slope * te) / (((1 - te * te) - rho_x * rho_x) / rho - curvature * te * te)
    d = ua + x * te
    rho = ca.sqrt(uu + x * (2 * ut + x) - d * d)
    R, slope, _ = profile(d)
    cosine = 1 / ca.sqrt(1 + slope * slope)
    outward = (u + x * t - d * wheel.axle) / rho
    n = cosine * (slope * wheel.axle - outward)
    return (rho - R) * cosine, d, slope, n, point + x * t + q * n


def forces_at(
    wheel: Wheel, t: ca.SX, contact: tuple[Any, ...], press: Callable[[Any, Any], tuple[Any, Patch]], law: Any
) -> Touch:
    """Creepages at the `contact` that `touch` found, and the forces of `press` (penetration, rate -> load, patch) and `law`."""
    gap, d, slope, n, at = contact
    arm = at - wheel.origin
    v = wheel.velocity + cross(wheel.rotation, arm)
    across = cross(n, t)
    approach_rate = -dot(v, n)
    N, patch = press(-gap, approach_rate)
    creepages = (dot(v, t) / wheel.speed, dot(v, across) / wheel.speed, dot(wheel.rotation, n) / wheel.speed)
    mu = wheel.friction(slip_speed(wheel.speed, creepages[0], creepages[1]))
    Fx, Fy, Mz = law(*creepages, replace(patch, mu=mu))
    force = N * n + Fx * t + Fy * across
    heat = -(Fx * creepages[0] + Fy * creepages[1] + Mz * creepages[2])
    return Touch(force, cross(arm, force) + Mz * n, N, gap, d, slope, creepages, heat, approach_rate)


def hertz_stiffness(s: Mapping[str, ca.SX]) -> tuple[Any, Any]:
    """(K in N/m^1.5, R_e in m) of the tread contact."""
    radius = 2 / (1 / s["rolling_radius"] + 1 / s["rail_crown_radius"])
    modulus = s["youngs_modulus"] / (2 * (1 - s["poisson_ratio"] ** 2))
    return 4 / 3 * modulus * ca.sqrt(radius), radius


def shear_modulus(s: Mapping[str, ca.SX]) -> Any:
    """G of wheel and rail, Pa."""
    return s["youngs_modulus"] / (2 * (1 + s["poisson_ratio"]))


def tread_press(s: Mapping[str, ca.SX], grid: int) -> Callable[[Any, Any], tuple[Any, Patch]]:
    """Penetration (m) and its rate (m/s) -> normal load and patch of the tread."""
    K, radius = hertz_stiffness(s)
    C = Coefficients(s["kalker_c11"], s["kalker_c22"], s["kalker_c23"], s["kalker_c33"])

    def press(delta: Any, rate: Any) -> tuple[Any, Patch]:
        delta = ca.fmax(delta, LEAST_DEPTH)
        N = K * delta * ca.sqrt(delta) * ca.fmax(1 + s["contact_damping"] * rate, 0.0)
        axis = ca.sqrt(radius * delta)
        return N, Patch(axis, axis, N, s["friction"], shear_modulus(s), C, grid)

    return press


def flange_press(s: Mapping[str, ca.SX]) -> Callable[[Any, Any], tuple[Any, Patch]]:
    """Penetration and rate -> normal load and patch of the flange; the patch's area is in proportion to the load."""
    C = Coefficients(*(s[f"flange_kalker_c{i}"] for i in (11, 22, 23, 33)))

    def press(p: Any, rate: Any) -> tuple[Any, Patch]:
        p = ca.fmax(p, 0.0)
        N = s["rail_lateral_stiffness"] * p * p / (p + BLEND) * ca.fmax(1 + s["contact_damping"] * rate, 0.0)
        scale = ca.sqrt(N / s["flange_patch_load"] + 1e-12)
        patch = Patch(s["flange_patch_a"] * scale, s["flange_patch_b"] * scale, N, s["friction"], shear_modulus(s), C)
        return N, patch

    return press


def wheel_on_rail(
    wheel: Wheel, running: tuple[ca.SX, ca.SX], corner: tuple[ca.SX, ca.SX], s: Mapping[str, ca.SX], law: str, grid: int
) -> tuple[Touch, Touch]:
    """Tread and flange contact; `running` and `corner`: a point and the unit tangent of the running line and of the line of
    the corner's centre, each near its contact.

    `law` acts on the tread. The flange has Polach's law under every name but "kalker": a flange that presses slides, and
    FASTSIM there would cost as much as on the tread.
    """
    tread = forces_at(wheel, running[1], touch(wheel, *running, 0, tread_profile(s), newton=1), tread_press(s, grid), LAWS[law])
    profile, _ = flange_profile(s)
    contact = touch(wheel, *corner, s["corner_radius"], profile, newton=3)
    return tread, forces_at(wheel, corner[1], contact, flange_press(s), LAWS[law] if law in ("kalker", "linear") else polach)
