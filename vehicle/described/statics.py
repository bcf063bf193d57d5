"""What springs and wheels carry at rest on straight level track, as formulas of the parameters.

The springs are laid unloaded under bodies without weight, as their places have them; then the weight comes on. With z_i and
theta_i the settling and the pitch of body i, and e = z_lower - theta_lower (x - x_lower) - (z_upper - theta_upper (x - x_upper))
the stretch of springs at x, n of them of stiffness k_z, l_x ahead and behind,

    sum over springs  n k_z e de + n k_z l_x^2 (theta_lower - theta_upper) (dtheta_lower - dtheta_upper)  =  - sum m_i g dz_i

A wheelset does not settle. The forces found are preloads: the vehicle is then at rest in the places that the file gives.
Where two springs share a load, their stiffness decides, as in a workshop that shims nothing. Where a weight, or what carries
one, is off the middle of the track, bodies roll too, phi_i with y in the place of -x and l_y in that of l_x, and the wheels of
an axle carry unlike loads; else nothing rolls.
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
    """Preloads (N upwards on the lower body, N m about x and y) by name of springs; load of left and right wheel by wheelset."""

    preloads: Mapping[str, tuple[Any, Any, Any]]
    wheel_loads: Mapping[str, tuple[Any, Any]]


@dataclass(frozen=True)
class _Laid:
    """Springs with a stiffness: n k_z, n k_z l_y^2 and n k_z l_x^2, and (de, dphi, dtheta) as rows over the unknowns."""

    k: Any
    k_turn: tuple[Any, Any]
    stretch: ca.SX
    turn: tuple[ca.SX, ca.SX]


def _held(d: Description, name: str) -> bool:
    """Whether springs hold the pitch of a wheelset; one group of them over the axle does not, and no weight turns it."""
    over = [springs for springs in d.springs.values() if springs.carries and name in (springs.upper, springs.lower)]
    return len(over) > 1 or any(not springs.half_x.is_zero for springs in over)


def _equations(
    s: Mapping[str, ca.SX], d: Description, draws: Draws
) -> tuple[list[tuple[str, str]], dict[str, _Laid], ca.SX, ca.SX]:
    """Unknowns as ("z", "phi" or "theta", body), springs, stiffness matrix and loads."""
    names = [body.name for body in d.free]
    unknowns = [("z", name) for name in names]
    unknowns += [("theta", name) for name in (*names, *(w.name for w in d.wheelsets.values() if w.pitches and _held(d, w.name)))]
    unknowns += [("phi", name) for name in names if d.lopsided]
    row = {unknown: i for i, unknown in enumerate(unknowns)}
    n = len(unknowns)
    places = {name: d.common_mass(s, name)[1:3] for name in names} | {w.name: (w.x.of(s), 0) for w in d.wheelsets.values()}
    K, f, laid = ca.SX(n, n), ca.SX.zeros(n), {}
    for name, springs in d.springs.items():
        if not springs.carries:
            continue
        e, turn = ca.SX(1, n), {"phi": ca.SX(1, n), "theta": ca.SX(1, n)}
        for body, sign in ((springs.lower, 1), (d.host(springs.upper), -1)):
            if ("z", body) in row:
                e[0, row["z", body]] = sign
            x, y = places[body]
            for angle, arm in (("theta", x - springs.at.x.of(s)), ("phi", springs.at.y.of(s) - y)):
                if (angle, body) not in row:
                    continue
                turn[angle][0, row[angle, body]] = sign
                if not draws.is_zero(ca.SX(arm)):
                    e[0, row[angle, body]] = sign * arm
        k = springs.count * springs.carrying(s)
        k_turn = (k * springs.half_y.of(s) ** 2, k * springs.half_x.of(s) ** 2)
        laid[name] = _Laid(k, k_turn, e, (turn["phi"], turn["theta"]))
        K += k * (e.T @ e)
        for half, k_i, angle in ((springs.half_y, k_turn[0], "phi"), (springs.half_x, k_turn[1], "theta")):
            if not half.is_zero:
                K += k_i * (turn[angle].T @ turn[angle])
    for name in names:
        f[row["z", name]] -= d.common_mass(s, name)[0] * s["gravity"]
    return unknowns, laid, K, f


def at_rest(s: Mapping[str, ca.SX], d: Description, draws: Draws) -> Statics:
    """Solve for the preloads; `s` are the symbols by name."""
    _, laid, K, f = _equations(s, d, draws)
    q = ca.ldl_solve(f, *ca.ldl(K)) if f.numel() else f
    preloads = {}
    for name, one in laid.items():
        halves = (d.springs[name].half_y, d.springs[name].half_x)
        tilts = [0 if half.is_zero or not turn.nnz() else draws.clean(-k * (turn @ q))
                 for half, k, turn in zip(halves, one.k_turn, one.turn, strict=True)]  # fmt: skip
        preloads[name] = (-one.k * (one.stretch @ q), tilts[0], tilts[1])
    loads = {}
    for name, wheelset in d.wheelsets.items():
        carried, heeling = ca.SX(0), ca.SX(0)
        for of, (force, heel, _) in preloads.items():
            springs = d.springs[of]
            sign = (springs.upper == name) - (springs.lower == name)
            if sign:
                carried = carried + sign * force
                heeling = heeling + sign * (force * springs.at.y.of(s) + heel)
        whole = (carried + wheelset.load.of(s) + wheelset.mass.of(s) * s["gravity"]) / 2
        lever = heeling / (2 * s["contact_half_distance"]) if d.lopsided else 0
        loads[name] = (whole + lever, whole - lever)
    return Statics(preloads, loads)


def not_carried(d: Description) -> str | None:
    """The body that no spring carries, if there is one: the statics would have no solution."""
    unknowns, _, K, _ = _equations({name: ca.SX(value) for name, value in d.starts().items()}, d, Draws(d.starts()))
    matrix = np.array(ca.DM(K)) if unknowns else np.eye(1)
    diagonal = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(diagonal, diagonal))
    return None if values[0] > HELD else unknowns[int(np.abs(vectors[:, 0]).argmax())][1]
