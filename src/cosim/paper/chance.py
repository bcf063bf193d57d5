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

    p counts that several parameters were tried: any of them could have shown it (Bonferroni).
    """

    target: str
    rho: float
    p: float

    @property
    def counts(self) -> bool:
        """Whether it is more than chance."""
        return self.p < 1.0 - SURE


def influences(parameters: dict[str, np.ndarray], margin: np.ndarray) -> tuple[Influence, ...]:
    """Of each parameter, shape (n,), on the margin, shape (n,), which may be infinite; the strongest first.

    Rows where the margin is nan are left out. Where it does not vary, or fewer than four rows are left, there are none.
    """
    from scipy.stats import spearmanr

    judged = ~np.isnan(margin)
    if judged.sum() < 4 or np.unique(margin[judged]).size < 2:
        return ()
    found = []
    for target, values in parameters.items():
        result = spearmanr(values[judged], margin[judged])
        found.append(Influence(target, float(result.statistic), min(1.0, float(result.pvalue) * len(parameters))))
    return tuple(sorted(found, key=lambda influence: -abs(influence.rho)))
