"""The energy meter's arithmetic on one step after another, as Python runs it and numba compiles it."""

from typing import Any


def accumulate(
    past: Any, Y: Any, signals: Any, h: Any, before: float, used: Any, scale: Any, offset: Any, factor: Any, residual: Any,
    exchanged: Any, peak: Any,
) -> None:  # fmt: skip
    """As EnergyMeter.add, step by step, for a compiler: adds to residual, exchanged and peak of every bond."""
    n = past.shape[0]
    for b in range(factor.shape[0]):
        motion, effort = signals[2 * b], signals[2 * b + 1]
        c_w, c_M, o_w, o_M = 1 / scale[2 * b], 1 / scale[2 * b + 1], offset[2 * b], offset[2 * b + 1]
        w1, M1 = past[n - 1, 2 * b], past[n - 1, 2 * b + 1]  # one, two, three points before the newest
        w2, M2 = past[n - min(n, 2), 2 * b], past[n - min(n, 2), 2 * b + 1]
        w3, M3 = past[0, 2 * b], past[0, 2 * b + 1]
        last, sum_residual, sum_exchanged, highest = before, residual[b], exchanged[b], peak[b]
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
            start = u_M * c_M * w1 - M1 * (u_w * c_w)
            middle = (u_M + half * (s_M + half * q_M)) * c_M * w_half - M_half * ((u_w + half * (s_w + half * q_w)) * c_w)
            end = (u_M + step * (s_M + step * q_M)) * c_M * w - M * ((u_w + step * (s_w + step * q_w)) * c_w)
            sum_residual += step / 6 * factor[b] * (start + 4 * middle + end)
            sum_exchanged += step / 6 * abs(factor[b]) * (abs(M1 * w1) + 4 * abs(M_half * w_half) + abs(M * w))
            highest = max(highest, abs(start * factor[b]), abs(middle * factor[b]), abs(end * factor[b]))
            w1, w2, w3, M1, M2, M3, last = w, w1, w2, M, M1, M2, step
        residual[b], exchanged[b], peak[b] = sum_residual, sum_exchanged, highest
