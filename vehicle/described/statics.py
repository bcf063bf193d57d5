"""What springs and wheels carry at rest on straight level track, as formulas of the parameters.

The springs are laid unloaded under bodies without weight, as their places have them; then the weight comes on. With z_i and
theta_i the settling and the pitch of body i, and e = z_lower - theta_lower (x - x_lower) - (z_upper - theta_upper (x - x_upper))
the stretch of springs at x, n of them of stiffness k_z, l_x ahead and behind,

    sum over springs  n k_z e de + n k_z l_x^2 (theta_lower - theta_upper) (dtheta_lower - dtheta_upper)  =  - sum m_i g dz_i

A wheelset does not settle. The forces found are preloads: the vehicle is then at rest in the places that the file gives.
Where two springs share a load, their stiffness decides, as in a workshop that shims nothing. Springs lie in pairs to the left
and to the right, so nothing rolls.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from .description import Description
from .draws import Draws

__all__ = ["Statics", "at_rest", "not_carried"]

HELD = 1e-9  # least eigenvalue of the scaled stiffness: below it nothing carries a body


@dataclass(frozen=True)
class Statics:
    """Preloads (N upwards on the lower body, N m about y) by name of springs, and the load of one wheel (N) by wheelset."""

    preloads: Mapping[str, tuple[Any, Any]]
    wheel_loads: Mapping[str, Any]


@dataclass(frozen=True)
class _Laid:
    """Springs with a stiffness: n k_z, n k_z l_x^2, and (de, dtheta) as rows over the unknowns."""

    k: Any
    k_turn: Any
    stretch: ca.SX
    turn: ca.SX


def _equations(
    s: Mapping[str, ca.SX], d: Description, draws: Draws
) -> tuple[list[tuple[str, str]], dict[str, _Laid], ca.SX, ca.SX]:
    """Unknowns as ("z" or "theta", body), springs, stiffness matrix and loads."""
    names = [body.name for body in d.free]
    unknowns = [("z", name) for name in names]
    unknowns += [("theta", name) for name in (*names, *(w.name for w in d.wheelsets.values() if w.pitches))]
    row = {unknown: i for i, unknown in enumerate(unknowns)}
    n = len(unknowns)
    x_of = {name: d.common_mass(s, name)[1] for name in names} | {w.name: w.x.of(s) for w in d.wheelsets.values()}
    K, f, laid = ca.SX(n, n), ca.SX.zeros(n), {}
    for name, springs in d.springs.items():
        if springs.stiffness.z.is_zero:
            continue
        e, turn = ca.SX(1, n), ca.SX(1, n)
        for body, sign in ((springs.lower, 1), (d.host(springs.upper), -1)):
            if ("z", body) in row:
                e[0, row["z", body]] = sign
            if ("theta", body) in row:
                arm = draws.clean(springs.at.x.of(s) - x_of[body])
                if not arm.is_zero():
                    e[0, row["theta", body]] = -sign * arm
                turn[0, row["theta", body]] = sign
        k = springs.count * springs.stiffness.z.of(s)
        laid[name] = _Laid(k, k * springs.half_x.of(s) ** 2, e, turn)
        K += k * (e.T @ e)
        if not springs.half_x.is_zero:
            K += laid[name].k_turn * (turn.T @ turn)
    for name in names:
        f[row["z", name]] -= d.common_mass(s, name)[0] * s["gravity"]
    for i, (_, name) in enumerate(unknowns):
        if name in d.wheelsets and not K.has_nz(i, i):
            K[i, i] = 1  # a pitch that springs at the axle do not hold, and no weight turns
    return unknowns, laid, K, f


def at_rest(s: Mapping[str, ca.SX], d: Description, draws: Draws) -> Statics:
    """Solve for the preloads; `s` are the symbols by name."""
    _, laid, K, f = _equations(s, d, draws)
    q = ca.ldl_solve(f, *ca.ldl(K)) if f.numel() else f
    preloads = {}
    for name, one in laid.items():
        tilt = 0 if d.springs[name].half_x.is_zero else draws.clean(-one.k_turn * (one.turn @ q))
        preloads[name] = (-one.k * (one.stretch @ q), tilt)
    loads = {}
    for name, wheelset in d.wheelsets.items():
        carried = sum((-preloads[one][0] for one in preloads if d.springs[one].lower == name), ca.SX(0))
        carried = carried + sum((preloads[one][0] for one in preloads if d.springs[one].upper == name), ca.SX(0))
        loads[name] = (carried + wheelset.load.of(s) + wheelset.mass.of(s) * s["gravity"]) / 2
    return Statics(preloads, loads)


def not_carried(d: Description) -> str | None:
    """The body that no spring carries, if there is one: the statics would have no solution."""
    unknowns, _, K, _ = _equations({name: ca.SX(value) for name, value in d.starts().items()}, d, Draws(d.starts()))
    matrix = np.array(ca.DM(K)) if unknowns else np.eye(1)
    diagonal = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(diagonal, diagonal))
    return None if values[0] > HELD else unknowns[int(np.abs(vectors[:, 0]).argmax())][1]
