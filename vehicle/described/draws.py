"""Which formulas of parameters are 0, or the same, for all values: asked of a few random ones, not of algebra.

What is 0 for any parameters is left out of the equations, so that a vehicle from a file costs no more than one written by hand.
"""

from collections.abc import Mapping

import casadi as ca
import numpy as np

__all__ = ["Draws"]

SAME = 1e-12


class Draws:
    """Random values of the parameters, some tens of per cent about where they start."""

    def __init__(self, starts: Mapping[str, float]) -> None:
        self.starts = starts
        rng = np.random.default_rng(5)
        self.factors = {name: rng.uniform(0.8, 1.3, 3) for name in starts}

    def values(self, expression: ca.SX) -> np.ndarray:
        """The expression at three draws, shape (3, numel)."""
        symbols = ca.symvar(ca.SX(expression))
        f = ca.Function("f", symbols, [ca.SX(expression)])
        rows = []
        for k in range(3):
            at = [(self.starts[s.name()] or 1.0) * self.factors[s.name()][k] for s in symbols]
            rows.append(np.array(f.call([ca.DM(value) for value in at])[0]).ravel())
        return np.array(rows)

    def is_zero(self, expression: ca.SX, size: float = 1.0) -> bool:
        """Whether it is 0 at every draw, beside numbers of about `size`."""
        return bool(np.all(np.abs(self.values(expression)) < SAME * size))

    def clean(self, expression: ca.SX) -> ca.SX:
        """The expression, or a 0 that the equations can leave out."""
        return ca.SX(0) if self.is_zero(expression) else ca.SX(expression)

    def same(self, one: ca.SX, other: ca.SX) -> bool:
        """Whether both have the same value at every draw."""
        a, b = self.values(one), self.values(other)
        return bool(np.all(np.abs(a - b) <= SAME * np.abs(a)))
