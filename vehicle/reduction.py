"""The numbers that a wheel pair's slow yaw motion depends on, from the vehicle's parameters.

A free wheel with conicity gamma_0 rolls with the spin creepage phi = sin(atan gamma_0) / r0 at rest already. What a small motion
adds is the slope of the creep law there, not Kalker's coefficients: with gamma_0 = 0.37 and mu = 0.37 friction leaves
56 % of f22.
"""

from collections.abc import Mapping
from math import atan, cos, inf, sin

import casadi as ca

from .contact import hertz_patch
from .creep_laws import Patch, creep_law
from .kalker import Coefficients
from .lrt_parameters import vehicle_parameters
from .wheelset import sprung_wheelset

__all__ = ["reduced_values", "wheelset_values"]


def reduced_values(values: Mapping[str, float], law: str = "polach") -> dict[str, float]:
    """Compute what `gyro_cosim.railway.yaw_stability.wheel_pair` needs, by its names.

    The patch is a circle with the area of the contact by Hertz, as in the vehicle's equations: mean curvature of wheel and crown.

    Parameters
    ----------
    values : mapping of str to float
        Parameters of `vehicle:lrt` that differ from its table; others are left alone.
    law : str
        The creep law of the treads, smooth: "polach", "shen-hedrick-elkins" or "kalker".

    Returns
    -------
    dict of str to float
        `speed` (m/s), `load` (N, of a wheel), `yaw_inertia` (kg m2, of wheel frame, wheels, gimbals and bogie frame),
        `spin_inertia` (kg m2), `rolling_radius`, `contact_half_distance` (m), `conicity` (1), `conicity_gradient` (1/m),
        `f22` (N), `f23` (N m), `f33` (N m2).

    Raises
    ------
    ValueError
        For a law that is not smooth or does not exist.
    """
    if law == "fastsim":
        raise ValueError("law must be smooth to have slopes: polach, shen-hedrick-elkins or kalker, got 'fastsim'")
    s = {v.name: v.start for v in vehicle_parameters()} | dict(values)
    ends = s["bogie_mass"] + s["frame_mass"] + 2 * s["wheel_mass"] + s["outer_gimbal_mass"] + s["inner_gimbal_mass"]
    load = (s["body_mass"] + 2 * ends) * s["gravity"] / 4
    r0, b, slope = s["rolling_radius"], s["contact_half_distance"], atan(s["conicity"])

    N, radius = load / cos(slope), 2 / (1 / r0 + 1 / s["rail_crown_radius"])
    axis = hertz_patch(N, radius, inf, radius, s["youngs_modulus"], s["poisson_ratio"]).a
    C = Coefficients(s["kalker_c11"], s["kalker_c22"], s["kalker_c23"], s["kalker_c33"])
    G = s["youngs_modulus"] / (2 * (1 + s["poisson_ratio"]))
    creepages = ca.SX.sym("creepages", 3)  # xi, eta, phi
    patch = Patch(axis, axis, N, s["friction"], G, C)
    forces = ca.vertcat(*creep_law(law)(creepages[0], creepages[1], creepages[2], patch))
    slopes = -ca.DM(ca.Function("slopes", [creepages], [ca.jacobian(forces, creepages)])([0.0, 0.0, sin(slope) / r0]))
    return {
        "speed": s["speed"],
        "load": load,
        "yaw_inertia": (s["frame_izz"] + 2 * (s["wheel_ixx"] + s["wheel_mass"] * b**2)
                        + s["outer_gimbal_izz"] + s["inner_gimbal_izz"] + s["bogie_izz"]),
        "spin_inertia": s["wheel_spin_inertia"],
        "rolling_radius": r0,
        "contact_half_distance": b,
        "conicity": s["conicity"],
        "conicity_gradient": s["conicity_gradient"],
        "f22": float(slopes[1, 1]),
        "f23": float(slopes[1, 2]),
        "f33": float(slopes[2, 2]),
    }  # fmt: skip


def wheelset_values(values: Mapping[str, float]) -> dict[str, float]:
    """Compute what `gyro_cosim.railway.yaw_impedance.SprungWheelset` needs, by its names.

    Kalker's coefficients at rest: the tread is nearly flat. The patch is that of the vehicle's equations.

    Parameters
    ----------
    values : mapping of str to float
        Parameters of `vehicle:wheelset` that differ from its table.

    Returns
    -------
    dict of str to float
        `mass` (kg), `yaw_inertia` (kg m2), `lateral_stiffness` (N/m), `yaw_stiffness` (N m), `lateral_creep` (N),
        `yaw_creep` (N m2), `steering` (N).
    """
    s = {v.name: v.start for v in sprung_wheelset().parameters} | dict(values)
    r0, b, load = s["rolling_radius"], s["contact_half_distance"], s["axle_load"] / 2
    radius = 2 / (1 / r0 + 1 / s["rail_crown_radius"])
    axis = hertz_patch(load, radius, inf, radius, s["youngs_modulus"], s["poisson_ratio"]).a
    G = s["youngs_modulus"] / (2 * (1 + s["poisson_ratio"]))
    f11, f22 = (G * axis**2 * s[f"kalker_c{i}"] for i in (11, 22))
    return {
        "mass": s["wheelset_mass"],
        "yaw_inertia": s["wheelset_izz"],
        "lateral_stiffness": 2 * s["guide_stiffness_y"],
        "yaw_stiffness": 2 * s["guide_stiffness_x"] * s["guide_half_spacing"] ** 2,
        "lateral_creep": 2 * f22,
        "yaw_creep": 2 * f11 * b**2 + 2 * G * axis**4 * s["kalker_c33"],
        "steering": 2 * f11 * b * s["conicity"] / r0,
    }
