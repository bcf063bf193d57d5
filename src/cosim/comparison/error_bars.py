"""Error bars of what a run measures, from runs that differ in their start: between which values does a further start lie?

Of n values drawn independently from one law, whatever that law is, a further one lies between the k-th smallest and the k-th
largest with the probability

    1 - 2 k / (n + 1)                                                           (1)

or more, where values are equal: every place among the n + 1 is as likely as any other. No law is assumed, so this holds for runs
that hunt, whose figures have two humps and long tails. With 39 values the smallest and the largest are the bar at 95 %; with
fewer they hold for less, and the bar says for how much.

Source: Wilks, Determination of sample sizes for setting tolerance limits, Ann. Math. Statist. 12 (1941).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

__all__ = ["SURE", "ErrorBar", "error_bar"]

SURE = 0.95  # share of further starts that a bar holds for


@dataclass(frozen=True)
class ErrorBar:
    """Between which values a further start lies.

    Parameters
    ----------
    low, high : float
        In the unit of the values; infinite where the values are.
    share : float
        Of further starts that lie between, at least, in the mean over all that might have been drawn.
    starts : int
        How many values it was made of.
    """

    low: float
    high: float
    share: float
    starts: int


def error_bar(values: Sequence[float], share: float = SURE) -> ErrorBar:
    """The bar of some values.

    Parameters
    ----------
    values : sequence of float
        One for each start, drawn independently; a NaN, of a run that has no such value, counts to both ends: it may be anything.
    share : float
        Of further starts that are to lie in it.

    Returns
    -------
    ErrorBar
        With the largest k of (1) that keeps `share`, or k = 1 and what it keeps where there are too few values for that.

    Raises
    ------
    ValueError
        Without values, or a share that is not between 0 and 1.
    """
    if not len(values):
        raise ValueError("an error bar needs at least one value, got none")
    if not 0.0 < share < 1.0:
        raise ValueError(f"share must lie between 0 and 1, got {share:g}")
    given = np.asarray(values, dtype=float)
    n, unknown = given.size, np.isnan(given)
    k = max(1, int((n + 1) * (1.0 - share) / 2.0 + 1e-9))
    low, high = np.sort(np.where(unknown, -np.inf, given)), np.sort(np.where(unknown, np.inf, given))
    return ErrorBar(float(low[k - 1]), float(high[n - k]), max(0.0, 1.0 - 2.0 * k / (n + 1)), n)
