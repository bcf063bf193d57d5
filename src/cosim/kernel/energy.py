"""The energy meter's arithmetic on one step after another, as Python runs it and kernel.c repeats it.

master/energy.py does the same on whole arrays, operation by operation, so both give the same bits; a test holds them to it.
"""

from typing import Any, NamedTuple


class Bonds(NamedTuple):
    """The power bonds of a network, n of them; float64 and int64.

    Parameters
    ----------
    signals : shape (2 n,)
        Places in Y of motion and effort of each bond in turn.
    inverse, offset : shape (2 n,)
        From the inputs that the slaves follow to the units of the signals: (input - offset) inverse.
    factor : shape (n,)
        From the product of the signals' units to W.
    """

    signals: Any
    inverse: Any
    offset: Any
    factor: Any


class Sums(NamedTuple):
    """Residual and exchanged energy (J) and peak residual power (W) so far, shape (n,) each; added to in place."""

    residual: Any
    exchanged: Any
    peak: Any


def accumulate(bonds: Bonds, past: Any, Y: Any, h: Any, before: float, used: Any, sums: Sums) -> None:
    """Add n steps of h, shape (n,), that reached Y, shape (n, n_Y), to the sums of every bond.

    past : shape (1 to 3, 2 n_bonds), the signals at the points before, oldest first. before : the step before, s.
    used : shape (n, 2 n_bonds, 3), the inputs that each step followed.
    """
    n = past.shape[0]
    for b in range(bonds.factor.shape[0]):
        motion, effort, factor = bonds.signals[2 * b], bonds.signals[2 * b + 1], bonds.factor[b]
        c_w, c_M, o_w, o_M = bonds.inverse[2 * b], bonds.inverse[2 * b + 1], bonds.offset[2 * b], bonds.offset[2 * b + 1]
        w1, M1 = past[n - 1, 2 * b], past[n - 1, 2 * b + 1]  # one, two, three points before the newest
        w2, M2 = past[n - min(n, 2), 2 * b], past[n - min(n, 2), 2 * b + 1]
        w3, M3 = past[0, 2 * b], past[0, 2 * b + 1]
        last, sum_residual, sum_exchanged, highest = before, sums.residual[b], sums.exchanged[b], sums.peak[b]
        for k in range(h.shape[0]):
            w, M, step = Y[k, motion], Y[k, effort], h[k]
            uneven = abs(step - last) > 1e-9 * step
            if n + k >= 3 and not uneven:
                w_half, M_half = (5 * w + 15 * w1 - 5 * w2 + w3) / 16, (5 * M + 15 * M1 - 5 * M2 + M3) / 16
            elif n + k == 2 and not uneven:
                w_half, M_half = (3 * w + 6 * w1 - w2) / 8, (3 * M + 6 * M1 - M2) / 8
            else:
                w_half, M_half = (w + w1) / 2, (M + M1) / 2
            u_w, u_M, half = used[k, 2 * b, 0] - o_w, used[k, 2 * b + 1, 0] - o_M, step / 2
            s_w, s_M, q_w, q_M = used[k, 2 * b, 1], used[k, 2 * b + 1, 1], used[k, 2 * b, 2] / 2, used[k, 2 * b + 1, 2] / 2
            start = (u_M * c_M * w1 - M1 * (u_w * c_w)) * factor
            middle = (
                (u_M + half * (s_M + half * q_M)) * c_M * w_half - M_half * ((u_w + half * (s_w + half * q_w)) * c_w)
            ) * factor
            end = ((u_M + step * (s_M + step * q_M)) * c_M * w - M * ((u_w + step * (s_w + step * q_w)) * c_w)) * factor
            sum_residual += step / 6 * (start + 4 * middle + end)
            sum_exchanged += step / 6 * (abs(M1 * w1 * factor) + 4 * abs(M_half * w_half * factor) + abs(M * w * factor))
            highest = max(highest, abs(start), abs(middle), abs(end))
            w1, w2, w3, M1, M2, M3, last = w, w1, w2, M, M1, M2, step
        sums.residual[b], sums.exchanged[b], sums.peak[b] = sum_residual, sum_exchanged, highest
