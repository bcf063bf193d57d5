"""The inner loop for FMUs under Jacobi, NEPCE and Gauss-Seidel: from function pointers to recorded values.

`march` is the definition, which Python can run as it stands; kernel.c repeats it for a compiler, operation by operation.
It repeats coupling/explicit.py and coupling/history.py in the same way, so all three give the same bits; a test holds them to
it.
"""

import sys
from time import perf_counter
from typing import Any, NamedTuple

from .ctypes_calls import (
    DEGREE,
    DO_STEP,
    DU_ORDERS,
    DU_REFS,
    FEEDS_THROUGH,
    FINISH,
    FIRST,
    GET_REAL,
    INSTANCE,
    N_U,
    N_Y,
    NO_SET_STATE,
    SET_DERIVATIVES,
    SET_REAL,
    TOLD,
    U_REFS,
    VERSION,
    Y_REFS,
    Y_START,
    derivatives_call,
    finish_call,
    move_values,
    step3_call,
    step_call,
)  # fmt: skip

LARGEST = sys.float_info.max


class Plan(NamedTuple):
    """What the loop does, the same for every step; made by FastLoop. Arrays are int64 or float64.

    Parameters
    ----------
    slaves : shape (n_slaves, len(COLUMNS))
        Addresses and sizes, see ctypes_calls.COLUMNS.
    source, scale, offset, fresh : shape (n_u,), of the connected inputs of all slaves, slave by slave
        Place in Y of the source, conversion, and whether the source has stepped already (Gauss-Seidel).
    sequence, exchange : shape (n_slaves,)
        Order of stepping and of evaluation.
    stops, above : shape (n_stops,)
        Places in Y, and the values above which they end the march, with that step done.
    bond_inputs : shape (2 n_bonds, 3)
        Places of value, slope and curvature of each input of a power bond, in u, du and du.
    pointers : shape (3,)
        Addresses of u, du and Y.
    degree : int
        Of the input polynomials.
    sequential : bool
        Gauss-Seidel instead of Jacobi.
    missed : float
        NEPCE: what extrapolation misses in the mean of a step, in differences of order degree + 1; 0 for the others.
    """

    slaves: Any
    source: Any
    scale: Any
    offset: Any
    fresh: Any
    sequence: Any
    exchange: Any
    stops: Any
    above: Any
    bond_inputs: Any
    pointers: Any
    degree: int
    sequential: bool
    missed: float


class Data(NamedTuple):
    """What the loop reads and writes on the way.

    Parameters
    ----------
    Y, t, h : shapes (rows, n_Y), (rows,), (rows,)
        Outputs, times and steps; Y holds at least `degree` points before the row that a march begins with.
    used : shape (rows, 2 n_bonds, 3)
        For each step, value, slope and curvature of the inputs of the power bonds that it followed.
    u, du, kept : shapes (n_u + 1,), (2 n_u + 1,), (n_u + 1,)
        Connected inputs of all slaves; their derivatives, per slave all first ones, then all second ones; scratch, as u.
    orders : shape (n_slaves,), int64
        Highest derivative sent so far.
    told, reached : shapes (n_slaves, 16), uint8, and (n_slaves, 2)
        Of FMI 3.0: answers of doStep, as bytes and as numbers.
    due : shape (n_slaves,)
        Of FMI 3.0: when each slave's next event is due, s.
    spent : shape (n_slaves,)
        Time in steps per slave, s.
    failure : shape (3,), int64
        Slave, call (place in CALLS) and status of the call that stopped a march.
    """

    Y: Any
    t: Any
    h: Any
    used: Any
    u: Any
    du: Any
    kept: Any
    orders: Any
    told: Any
    reached: Any
    due: Any
    spent: Any
    failure: Any


def march(plan: Plan, data: Data, row: int, rows: int, timed_every: int) -> int:
    """Macro steps from row `row` of Y to row + rows; returns how many were done.

    timed_every : one step in so many is timed, none where it is 0.
    An output that is not finite stops the march, too, before it reaches another slave; one that reaches none does not.
    """
    S, source, scale, offset, fresh = plan.slaves, plan.source, plan.scale, plan.offset, plan.fresh
    sequence, exchange, stops, above = plan.sequence, plan.exchange, plan.stops, plan.above
    bond_inputs, pointers, degree, sequential, missed = plan.bond_inputs, plan.pointers, plan.degree, plan.sequential, plan.missed
    Y, t, h, bond_used, u, du, kept, orders = data.Y, data.t, data.h, data.used, data.u, data.du, data.kept, data.orders
    told, reached, due, spent, failure = data.told, data.reached, data.due, data.spent, data.failure
    n_Y = Y.shape[1]
    for k in range(rows):
        r = row + k
        step, t0 = h[r + 1], t[r]
        s1 = t[r - 1] - t0 if degree > 0 else 0.0
        s2 = t[r - 2] - t0 if degree > 1 else 0.0
        timed = timed_every > 0 and k % timed_every == 0
        for i in sequence:
            version, n_u, u0 = S[i, VERSION], S[i, N_U], S[i, FIRST]
            if degree == 0:
                for q in range(u0, u0 + n_u):
                    y0 = Y[r + fresh[q], source[q]]
                    if not abs(y0) <= LARGEST:
                        return k
                    if missed > 0.0:
                        y0 = y0 + missed * (y0 - Y[r - 1, source[q]])
                    u[q] = y0 * scale[q] + offset[q]
            else:
                for j in range(n_u):
                    q = u0 + j
                    c = source[q]
                    y0 = Y[r, c]
                    value, slope, curvature = y0, 0.0, 0.0
                    if not abs(y0) <= LARGEST:
                        return k
                    if fresh[q] > 0:
                        yn = Y[r + 1, c]
                        if not abs(yn) <= LARGEST:
                            return k
                        a = (y0 - yn) / (0.0 - step)
                        value, slope = yn - a * step, a
                        if degree > 1:
                            b = ((Y[r - 1, c] - y0) / (s1 - 0.0) - a) / (s1 - step)
                            value = yn - a * step + b * (step * 0.0)
                            slope = a - b * (step + 0.0)
                            curvature = 2.0 * b
                    else:
                        a = (Y[r - 1, c] - y0) / s1
                        slope = a
                        if degree > 1:
                            b = ((Y[r - 2, c] - Y[r - 1, c]) / (s2 - s1) - a) / s2
                            slope = a - b * s1
                            curvature = 2.0 * b
                    if missed > 0.0:
                        first, second = y0 - Y[r - 1, c], Y[r - 1, c] - Y[r - 2, c]
                        difference = first - second
                        if degree > 1:
                            difference = difference - (second - (Y[r - 2, c] - Y[r - 3, c]))
                        value = value + missed * difference
                    value, slope, curvature = value * scale[q] + offset[q], slope * scale[q], curvature * scale[q]
                    if S[i, DEGREE] < 2:
                        value -= curvature * (step * step / 12)
                        slope += curvature * (step / 2)
                        curvature = 0.0
                        if S[i, DEGREE] == 0:
                            value += slope * (step / 2)
                            slope = 0.0
                    u[q], du[2 * u0 + j], du[2 * u0 + n_u + j] = value, slope, curvature
                    if S[i, DEGREE] > 0 and orders[i] < 2:
                        if curvature != 0.0:
                            orders[i] = 2
                        elif slope != 0.0 and orders[i] < 1:
                            orders[i] = 1
            if n_u > 0:
                status = move_values(version, S[i, SET_REAL], S[i, INSTANCE], S[i, U_REFS], n_u, pointers[0] + 8 * u0)
                if status > 1:
                    failure[0], failure[1], failure[2] = i, 1, status
                    return k
                if orders[i] > 0:
                    status = derivatives_call(
                        S[i, SET_DERIVATIVES],
                        S[i, INSTANCE],
                        S[i, DU_REFS],
                        orders[i] * n_u,
                        S[i, DU_ORDERS],
                        pointers[1] + 16 * u0,
                    )
                    if status > 1:
                        failure[0], failure[1], failure[2] = i, 2, status
                        return k
            if timed:
                began = perf_counter()
            if version == 2:
                status = step_call(S[i, DO_STEP], S[i, INSTANCE], t0, step, S[i, NO_SET_STATE])
            elif due[i] <= t0 + 1.000001 * step:  # not far behind the step: whoever finishes it looks closer
                status = finish_call(S[i, FINISH], t0, step, 0)
            else:
                told[i, 0], told[i, 1], told[i, 2], reached[i, 1] = 0, 0, 0, t0 + step
                at = S[i, TOLD]
                status = step3_call(S[i, DO_STEP], S[i, INSTANCE], t0, step, S[i, NO_SET_STATE], at, at + 1, at + 2, at + 8)
                short = abs(reached[i, 1] - (t0 + step)) > 1e-9 * (step + abs(t0))
                if status <= 1 and (short or told[i, 0] + told[i, 1] + told[i, 2] > 0):
                    status = finish_call(S[i, FINISH], t0, step, 1)
            if timed:
                spent[i] += timed_every * (perf_counter() - began)
            if status > 1:
                failure[0], failure[1], failure[2] = i, 3, status
                return k
            if sequential:
                if S[i, FEEDS_THROUGH] > 0:
                    for j in range(n_u):
                        q = u0 + j
                        kept[q] = u[q]  # the value at the start, put back below for the record
                        u[q] = u[q] + step * (du[2 * u0 + j] + step * du[2 * u0 + n_u + j] / 2)
                    status = move_values(version, S[i, SET_REAL], S[i, INSTANCE], S[i, U_REFS], n_u, pointers[0] + 8 * u0)
                    for q in range(u0, u0 + n_u):
                        u[q] = kept[q]
                    if status > 1:
                        failure[0], failure[1], failure[2] = i, 1, status
                        return k
                at = pointers[2] + 8 * ((r + 1) * n_Y + S[i, Y_START])
                status = move_values(version, S[i, GET_REAL], S[i, INSTANCE], S[i, Y_REFS], S[i, N_Y], at)
                if status > 1:
                    failure[0], failure[1], failure[2] = i, 4, status
                    return k
        for q in range(bond_inputs.shape[0]):
            bond_used[k, q, 0] = u[bond_inputs[q, 0]]
            if degree > 0:
                bond_used[k, q, 1] = du[bond_inputs[q, 1]]
                bond_used[k, q, 2] = du[bond_inputs[q, 2]]
        for i in exchange:
            version = S[i, VERSION]
            if S[i, FEEDS_THROUGH] > 0:
                u0 = S[i, FIRST]
                for q in range(u0, u0 + S[i, N_U]):
                    y1 = Y[r + 1, source[q]]
                    if not abs(y1) <= LARGEST:
                        return k
                    u[q] = y1 * scale[q] + offset[q]
                status = move_values(version, S[i, SET_REAL], S[i, INSTANCE], S[i, U_REFS], S[i, N_U], pointers[0] + 8 * u0)
                if status > 1:
                    failure[0], failure[1], failure[2] = i, 1, status
                    return k
            if S[i, FEEDS_THROUGH] > 0 or not sequential:
                at = pointers[2] + 8 * ((r + 1) * n_Y + S[i, Y_START])
                status = move_values(version, S[i, GET_REAL], S[i, INSTANCE], S[i, Y_REFS], S[i, N_Y], at)
                if status > 1:
                    failure[0], failure[1], failure[2] = i, 4, status
                    return k
        for q in range(stops.shape[0]):
            if Y[r + 1, stops[q]] > above[q]:
                return k + 1
    return rows
