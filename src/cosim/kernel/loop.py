"""The inner loop for FMUs under Jacobi, NEPCE and Gauss-Seidel: from function pointers to recorded values.

`march` is the definition, which Python can run as it stands; kernel.c repeats it for a compiler, function by function and
operation by operation, and meters the energy of the power bonds on the way, see energy.py.
It repeats coupling/explicit.py and coupling/history.py in the same way, so all three give the same bits; a test holds them to
it.
"""

import sys
from time import perf_counter
from typing import Any, NamedTuple

from . import ctypes_calls as c
from .ctypes_calls import derivatives_call, finish_call, move_values, step3_call, step_call

LARGEST = sys.float_info.max


class Plan(NamedTuple):
    """What the loop does, the same for every step; made by FastLoop. Arrays are int64 or float64.

    Parameters
    ----------
    slaves : shape (n_slaves, len(COLUMNS))
        Addresses and sizes, see ctypes_calls.COLUMNS.
    places : shape (n_asked,)
        Places in Y of the outputs that are asked for, slave by slave, in the order of their references.
    source, scale, offset, fresh : shape (n_u,), of the connected inputs of all slaves, slave by slave
        Place in Y of the source, conversion, and whether the source has stepped already (Gauss-Seidel).
    sequence, exchange : shape (n_slaves,)
        Order of stepping and of evaluation.
    stops, above : shape (n_stops,)
        Places in Y, and the values above which they end the march, with that step done.
    bond_inputs : shape (2 n_bonds, 3)
        Places of value, slope and curvature of each input of a power bond, in u, du and du.
    pointers : shape (4,)
        Addresses of u, du, Y and read.
    degree : int
        Of the input polynomials.
    sequential : bool
        Gauss-Seidel instead of Jacobi.
    missed : float
        NEPCE: what extrapolation misses in the mean of a step, in differences of order degree + 1; 0 for the others.
    """

    slaves: Any
    places: Any
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
    whole : shape (rows,), uint8
        Whether all outputs that are asked for are read into a row, or those alone that are in every step.
    used : shape (rows, 2 n_bonds, 3)
        For each step, value, slope and curvature of the inputs of the power bonds that it followed.
    u, du, kept : shapes (n_u + 1,), (2 n_u + 1,), (n_u + 1,)
        Connected inputs of all slaves; their derivatives, per slave all first ones, then all second ones; scratch, as u.
    read : shape (most n_y + 1,)
        Outputs on the way from a slave to their places.
    orders : shape (n_slaves,), int64
        Highest derivative sent so far.
    told, reached : shapes (n_slaves, 16), uint8, and (n_slaves, 2)
        Of FMI 3.0: answers of doStep, as bytes and as numbers.
    due : shape (n_slaves,)
        Of FMI 3.0: when each slave's next event is due, s.
    spent : shape (n_slaves,)
        Time in steps per slave, s.
    failure : shape (5,), int64
        Slave, call (place in CALLS) and status of the call that stopped a march; then, for whom it never comes back to, the
        macro steps that it has done and the slave that it is at.
    """

    Y: Any
    t: Any
    h: Any
    whole: Any
    used: Any
    u: Any
    du: Any
    kept: Any
    read: Any
    orders: Any
    told: Any
    reached: Any
    due: Any
    spent: Any
    failure: Any


def extrapolate(plan: Plan, data: Data, i: int, r: int, step: float, s1: float, s2: float) -> None:
    """The inputs of slave i over the step after row r. No derivative is -0.0: it would not be the same as none."""
    Y, source, fresh, u, du, orders = data.Y, plan.source, plan.fresh, data.u, data.du, data.orders
    u0, n_u, follows = plan.slaves[i, c.FIRST], plan.slaves[i, c.N_U], plan.slaves[i, c.DEGREE]
    for j in range(n_u):
        q = u0 + j
        at, scale, offset = source[q], plan.scale[q], plan.offset[q]
        if plan.degree == 0:
            value = Y[r + fresh[q], at]
            if plan.missed > 0.0:
                value = value + plan.missed * (value - Y[r - 1, at])
            u[q] = value * scale + offset
            continue
        y0 = Y[r, at]
        value, curvature = y0, 0.0
        if fresh[q] > 0:
            yn = Y[r + 1, at]
            a = (y0 - yn) / (0.0 - step)
            value, slope = yn - a * step, a
            if plan.degree > 1:
                b = ((Y[r - 1, at] - y0) / (s1 - 0.0) - a) / (s1 - step)
                value = yn - a * step + b * (step * 0.0)
                slope = a - b * (step + 0.0)
                curvature = 2.0 * b
        else:
            a = (Y[r - 1, at] - y0) / s1
            slope = a
            if plan.degree > 1:
                b = ((Y[r - 2, at] - Y[r - 1, at]) / (s2 - s1) - a) / s2
                slope = a - b * s1
                curvature = 2.0 * b
        if plan.missed > 0.0:
            first, second = y0 - Y[r - 1, at], Y[r - 1, at] - Y[r - 2, at]
            difference = first - second
            if plan.degree > 1:
                difference = difference - (second - (Y[r - 2, at] - Y[r - 3, at]))
            value = value + plan.missed * difference
        value, slope, curvature = value * scale + offset, slope * scale + 0.0, curvature * scale + 0.0
        if follows < 2:
            value -= curvature * (step * step / 12)
            slope += curvature * (step / 2)
            curvature = 0.0
            if follows == 0:
                value += slope * (step / 2)
                slope = 0.0
        u[q], du[2 * u0 + j], du[2 * u0 + n_u + j] = value, slope, curvature
        if follows > 0 and orders[i] < 2:
            if curvature != 0.0:
                orders[i] = 2
            elif slope != 0.0 and orders[i] < 1:
                orders[i] = 1


def failed(data: Data, i: int, call: int, status: int) -> bool:
    """Whether a call of slave i has failed; if so, that is noted."""
    if status > 1:
        data.failure[0], data.failure[1], data.failure[2] = i, call, status
    return status > 1


def give_inputs(plan: Plan, data: Data, i: int) -> bool:
    """Set the connected inputs of slave i to what u holds. False where it fails, here and in all that follow."""
    of = plan.slaves[i]
    at = plan.pointers[0] + 8 * of[c.FIRST]
    return not failed(data, i, 1, move_values(of[c.VERSION], of[c.SET_REAL], of[c.INSTANCE], of[c.U_REFS], of[c.N_U], at))


def send(plan: Plan, data: Data, i: int) -> bool:
    """Give slave i its inputs, with their derivatives once one of them has differed from zero."""
    of = plan.slaves[i]
    if of[c.N_U] == 0:
        return True
    if not give_inputs(plan, data, i):
        return False
    if data.orders[i] == 0:
        return True
    n, at = data.orders[i] * of[c.N_U], plan.pointers[1] + 16 * of[c.FIRST]
    status = derivatives_call(of[c.SET_DERIVATIVES], of[c.INSTANCE], of[c.DU_REFS], n, of[c.DU_ORDERS], at)
    return not failed(data, i, 2, status)


def advance(plan: Plan, data: Data, i: int, t: float, h: float) -> bool:
    """Step slave i from t over h (s)."""
    of, told, reached = plan.slaves[i], data.told[i], data.reached[i]
    if of[c.VERSION] == 2:
        status = step_call(of[c.DO_STEP], of[c.INSTANCE], t, h, of[c.NO_SET_STATE])
    elif data.due[i] <= t + 1.000001 * h:  # not far behind the step: whoever finishes it looks closer
        status = finish_call(of[c.FINISH], t, h, 0)
    else:
        told[0], told[1], told[2], reached[1] = 0, 0, 0, t + h
        at = of[c.TOLD]
        status = step3_call(of[c.DO_STEP], of[c.INSTANCE], t, h, of[c.NO_SET_STATE], at, at + 1, at + 2, at + 8)
        shortened = abs(reached[1] - (t + h)) > 1e-9 * (h + abs(t))
        if status <= 1 and (shortened or told[0] + told[1] + told[2] > 0):
            status = finish_call(of[c.FINISH], t, h, 1)
    return not failed(data, i, 3, status)


def receive(plan: Plan, data: Data, i: int, r: int, whole: bool) -> bool:
    """Read outputs of slave i into row r, all that are asked for or those of every step; they must be finite."""
    of, row = plan.slaves[i], data.Y[r]
    n = of[c.N_Y] if whole else of[c.N_POLLED]
    if n == 0:
        return True
    at = plan.pointers[3]
    if failed(data, i, 4, move_values(of[c.VERSION], of[c.GET_REAL], of[c.INSTANCE], of[c.Y_REFS], n, at)):
        return False
    good = True
    for j in range(n):
        row[plan.places[of[c.Y_FIRST] + j]] = data.read[j]
        good = good and abs(data.read[j]) <= LARGEST
    return good


def receive_stepped(plan: Plan, data: Data, i: int, r: int, h: float, whole: bool) -> bool:
    """Gauss-Seidel: read outputs of slave i, which has stepped over h (s), for those that step after it."""
    of, u, du, kept = plan.slaves[i], data.u, data.du, data.kept
    if of[c.FEEDS if whole else c.FEEDS_POLLED] == 0:
        return receive(plan, data, i, r, whole)
    u0, n_u = of[c.FIRST], of[c.N_U]  # inputs as at the end of the step; those at its start are put back for the record
    for j in range(n_u):
        q = u0 + j
        kept[q] = u[q]
        u[q] = u[q] + h * (du[2 * u0 + j] + h * du[2 * u0 + n_u + j] / 2)
    good = give_inputs(plan, data, i)
    u[u0 : u0 + n_u] = kept[u0 : u0 + n_u]
    return good and receive(plan, data, i, r, whole)


def exchange(plan: Plan, data: Data, r: int, whole: bool, again: bool) -> bool:
    """Make row r consistent with the inputs that it causes. again: whether slaves that need no new inputs are read, too."""
    Y, u = data.Y, data.u
    for i in plan.exchange:
        of = plan.slaves[i]
        feeds = of[c.FEEDS if whole else c.FEEDS_POLLED] > 0
        if feeds:
            for q in range(of[c.FIRST], of[c.FIRST] + of[c.N_U]):
                u[q] = Y[r, plan.source[q]] * plan.scale[q] + plan.offset[q]
            if not give_inputs(plan, data, i):
                return False
        if (feeds or again) and not receive(plan, data, i, r, whole):
            return False
    return True


def march(plan: Plan, data: Data, row: int, rows: int, timed_every: int) -> int:
    """Macro steps from row `row` of Y to row + rows; returns how many were done.

    timed_every : one step in so many is timed, none where it is 0.
    An output that is read and not finite stops the march, too, before it reaches another slave. The row that a stop condition
    ends the march with is whole.
    """
    t, u, du, used = data.t, data.u, data.du, data.used
    for k in range(rows):
        r, data.failure[3] = row + k, k
        h, whole = data.h[r + 1], data.whole[r + 1] > 0
        s1 = t[r - 1] - t[r] if plan.degree > 0 else 0.0
        s2 = t[r - 2] - t[r] if plan.degree > 1 else 0.0
        timed = timed_every > 0 and k % timed_every == 0
        for i in plan.sequence:
            data.failure[4] = i
            extrapolate(plan, data, i, r, h, s1, s2)
            if not send(plan, data, i):
                return k
            began = perf_counter() if timed else 0.0
            good = advance(plan, data, i, t[r], h)
            if timed:
                data.spent[i] += timed_every * (perf_counter() - began)
            if not good or (plan.sequential and not receive_stepped(plan, data, i, r + 1, h, whole)):
                return k
        for q, (value, slope, curvature) in enumerate(plan.bond_inputs):
            used[k, q, 0] = u[value]
            if plan.degree > 0:
                used[k, q, 1], used[k, q, 2] = du[slope], du[curvature]
        if not exchange(plan, data, r + 1, whole, not plan.sequential):
            return k
        if any(data.Y[r + 1, place] > above for place, above in zip(plan.stops, plan.above, strict=True)):
            return k + 1 if whole or exchange(plan, data, r + 1, True, True) else k
    return rows
