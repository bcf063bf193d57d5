"""Statistics of a study: how sure a share is, and whether a correlation is more than chance."""

from dataclasses import dataclass

import numpy as np

SURE = 0.95  # confidence of intervals, and against a correlation by chance anywhere in a column


@dataclass(frozen=True)
class Share:
    """`count` of `judged`, and the interval (low, high) of the share behind it."""

    count: int
    judged: int
    low: float
    high: float

    @property
    def text(self) -> str:
        """For people."""
        if not self.judged:
            return "in no draw could be judged"
        return f"in {self.count} of {self.judged} draws ({100 * self.low:.0f}..{100 * self.high:.0f} %)"


def wilson(count: int, judged: int, confidence: float = SURE) -> Share:
    """The share with its score interval: Wilson, Probable inference, the law of succession, and statistical inference (1927).

    It is never empty, at 0 and at all either, and stays within 0 and 1.
    """
    from scipy.stats import norm

    if not 0 <= count <= judged:
        raise ValueError(f"the count must lie in 0..{judged}, got {count}")
    if not judged:
        return Share(0, 0, 0.0, 1.0)
    z, p = float(norm.ppf((1 + confidence) / 2)), count / judged
    centre = (p + z * z / (2 * judged)) / (1 + z * z / judged)
    half = z / (1 + z * z / judged) * np.sqrt(p * (1 - p) / judged + z * z / (4 * judged * judged))
    return Share(count, judged, max(0.0, float(centre - half)), min(1.0, float(centre + half)))


@dataclass(frozen=True)
class Influence:
    """Spearman's rank correlation `rho` of a parameter with a margin, and the probability `p` of one as large by chance.

    partial : the same with what the other parameters explain taken from both; nan where there are too few draws for it.
    p is that of the weaker of the two, and counts that several parameters were tried: any of them could have shown it
    (Bonferroni). In a sample two parameters are a little correlated, so one alone can look strong by leaning on another.
    """

    target: str
    rho: float
    partial: float
    p: float

    @property
    def counts(self) -> bool:
        """Whether it is more than chance."""
        return self.p < 1.0 - SURE


def influences(parameters: dict[str, np.ndarray], margin: np.ndarray) -> tuple[Influence, ...]:
    """Of each parameter, shape (n,), on a margin or a truth of 1 or 0, shape (n,), which may be infinite; the strongest first.

    Rows where the margin is nan are left out. Where it does not vary, or fewer than four rows are left, there are none.
    """
    from scipy.stats import rankdata

    judged = ~np.isnan(margin)
    n, k = int(judged.sum()), len(parameters)
    if n < 4 or np.unique(margin[judged]).size < 2:
        return ()
    ranks = np.array([rankdata(column[judged]) for column in (*parameters.values(), margin)])
    R = np.corrcoef(ranks)
    rho, p = R[:k, k], _by_chance(R[:k, k], n - 2)
    partial = np.full(k, np.nan)
    if n > k + 3 and np.linalg.cond(R) < 1e10:
        P = np.linalg.inv(R)
        partial = -P[:k, k] / np.sqrt(np.diag(P)[:k] * P[k, k])
        p = np.maximum(p, _by_chance(partial, n - k - 1))
    strengths = [
        Influence(*row) for row in zip(parameters, rho.tolist(), partial.tolist(), np.minimum(1.0, k * p).tolist(), strict=True)
    ]
    return tuple(sorted(strengths, key=lambda influence: -abs(influence.rho)))


def _by_chance(correlation: np.ndarray, freedom: int) -> np.ndarray:
    """Probability of a correlation at least as large where there is none, by Student's t with `freedom` degrees of freedom."""
    from scipy.stats import t

    size = np.minimum(np.abs(correlation), 1.0 - 1e-15)
    return np.asarray(2 * t.sf(size * np.sqrt(freedom / (1.0 - size * size)), freedom))
