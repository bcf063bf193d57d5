"""The paper's 1/10-scale wheel pair with independently rotating wheels of negative tread conicity (NTCIRW).

    m_t y'' = -(2 k_22 / v) y' + 2 k_22 psi - 2 P gamma_1 y              (1)
    (I_zw + I_yg) psi'' = -2 P gamma_0 b psi + M                         (2)

y lateral displacement (m), psi yaw angle (rad), m_t = m_w + m_g. M (N m) is the moment of the gyro unit on the pair,
positive towards +psi: the term I_xg Omega eta' of the paper's equation (2), which here comes through the interface. The
yaw inertia I_yg of the gyro unit rides on the pair, so that no acceleration has to cross the interface.

A wheel that rolls with the attack angle psi and drifts with y' has the lateral creepage y'/v - psi; there is no
longitudinal creep force, since the wheels turn freely. So y follows psi, and psi does not depend on y.
Source: paper, eqs. (1)-(2), Table 1. Valid for small angles; the wheels' spin inertia is left out, as in the paper.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Bond, Component, build, input_, output, state

from . import scene
from .parameters import WHEEL_PAIR

__all__ = ["small_wheel_pair"]

EQUATIONS = """\
(m_w + m_g) y'' = -(2 k_22 / v) y' + 2 k_22 psi - 2 P gamma_1 y     (1)
(I_zw + I_yg) psi'' = -2 P gamma_0 b psi + M                        (2)"""

SIGNALS = (
    input_("yaw_moment", "N.m", "moment of the gyro unit on the wheel pair, positive towards +psi", symbol="M", nominal=0.01),
    state(
        "lateral_displacement", "m", "lateral displacement of the wheel pair", symbol="y_w", start=0.001,
        source="sec. 2.4", is_output=True, nominal=0.01, display_unit="mm",
    ),
    state("lateral_velocity", "m/s", "lateral velocity of the wheel pair", symbol="y_w'", source="sec. 2.4", nominal=0.1),
    state(
        "yaw_angle", "rad", "yaw angle of the wheel pair", symbol="psi_w", start=0.314, source="sec. 2.4",
        is_output=True, nominal=0.1,
    ),
    state("yaw_rate", "rad/s", "yaw rate of the wheel pair, absolute", symbol="psi_w'", source="sec. 2.4", is_output=True,
          nominal=1.0),
    output("wheel_speed", "rad/s", "spin of a centred wheel, v / r_0", nominal=100.0),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the paper's symbols."""
    v, P, b = s["speed"], s["wheel_load"], s["contact_half_distance"]
    m_t = s["wheelset_mass"] + s["gyro_mass"]
    I_zw, I_yg = s["yaw_inertia"], s["payload_yaw_inertia"]
    k22, gamma0, gamma1 = s["lateral_creep_coefficient"], s["conicity"], s["conicity_gradient"]
    y, y_dot, psi, psi_dot = s["lateral_displacement"], s["lateral_velocity"], s["yaw_angle"], s["yaw_rate"]

    y_ddot = (-(2 * k22 / v) * y_dot + 2 * k22 * psi - 2 * P * gamma1 * y) / m_t  # (1)
    psi_ddot = (-2 * P * gamma0 * b * psi + s["yaw_moment"]) / (I_zw + I_yg)  # (2)
    return (
        {"lateral_displacement": y_dot, "lateral_velocity": y_ddot, "yaw_angle": psi_dot, "yaw_rate": psi_ddot},
        {"wheel_speed": v / s["rolling_radius"]},
    )


def small_wheel_pair() -> Component:
    """Make the wheel pair, started as for the paper's figures 3 and 4.

    Returns
    -------
    Component
        The component `vehicle:wheel_pair`; its connector is "mount".

    Notes
    -----
    Its stiffest root is -2 k_22 / (v m_t): at 1 ms the Runge-Kutta step is stable above v = 0.042 m/s, so the speed's lower bound
    of 0.1 m/s leaves a factor of two.
    """
    return build(
        name="vehicle", variant="wheel_pair", description="NTCIRW wheel pair, 1/10 scale, lateral and yaw motion",
        equations=EQUATIONS, variables=(*SIGNALS, *WHEEL_PAIR), model=_motion, internal_step=1e-3,
        bonds=(Bond("mount", "yaw", motion="yaw_rate", effort="yaw_moment"),), scene=_scene(),
    )  # fmt: skip


def _scene() -> dict[str, Any]:
    """What it looks like on straight track; the wheels turn as they would without creep."""
    names, values = [v.name for v in SIGNALS], {v.name: v.start for v in WHEEL_PAIR}
    pair = scene.frame("wheel pair", "", 0.0, names, values, along={"parameter": "speed"}, solid=False)
    for wheel in pair["parts"]:
        wheel["rate"] = "wheel_speed"
    mount = {"name": "mount", "body": "wheel pair", "at": [0.0, 0.0, 0.004], "size": 0.076, "signals": ["yaw_rate"]}
    track = {"distance": {"parameter": "speed"}, "half_gauge": values["contact_half_distance"]}
    return scene.of_vehicle([pair], [], [mount], track, prefer=["lateral_displacement", "yaw_angle"])
