"""Modes of a system at rest, named in a way that no unit of measure changes; where the largest growth changes its sign.

Which state "moves most" in a mode depends on units: a vector's elements are metres, radians, m/s and rad/s side by side. With
A v = s v and w A = s w the participation of state k,

    p_k = w_k v_k / (w v),    sum p_k = 1,

is how much of the root comes from the state's own rate (ds/dA_kk). Another unit multiplies v_k and divides w_k: p_k stays.

References
----------
Perez-Arriaga, Verghese, Schweppe: Selective modal analysis, IEEE Trans. Power App. Syst. 101 (1982) 3117-3125.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .at_rest import AtRest

__all__ = ["Mode", "crossings", "modes_at"]

CLOSE = 1e-9  # of the range: how exactly a crossing is found


@dataclass(frozen=True)
class Mode:
    """A real root or a pair of them.

    Attributes
    ----------
    root
        In 1/s; imaginary part not negative.
    participation
        |p_k| of each state, shape (n,).
    moves
        The state that takes part most; of equals, as a place and its velocity in an undamped oscillation, the first.
    shape
        The right vector, of any size, shape (n,).
    """

    root: complex
    participation: np.ndarray
    moves: str
    shape: np.ndarray

    @property
    def frequency(self) -> float:
        """In Hz, of the damped oscillation."""
        return self.root.imag / (2 * np.pi)

    @property
    def damping(self) -> float:
        """Damping ratio, 1 for a root that decays without oscillating, negative for one that grows."""
        return float(-self.root.real / abs(self.root)) if self.root else 0.0


def modes_at(rest: AtRest, q: Sequence[float] | np.ndarray) -> list[Mode]:
    """One mode for each real root and each pair at parameters q, shape (n_q,), in order of falling growth."""
    from scipy.linalg import eig

    values, left, right = eig(rest.matrix(q), left=True, right=True)
    products = left.conj() * right
    # where roots coincide w v may vanish: the largest product is then as good a name
    shares = np.abs(products) / np.maximum(np.abs(products.sum(axis=0)), 1e-300)
    listed = []
    for k in np.lexsort((values.imag, -values.real)):
        if values[k].imag >= 0.0:
            share = shares[:, k]
            first = int(np.flatnonzero(share >= share.max() * (1 - 1e-6))[0])
            listed.append(Mode(complex(values[k]), share, rest.states[first].partition(" - ")[0], right[:, k]))
    return listed


def crossings(rest: AtRest, values: np.ndarray) -> list[tuple[float, Mode]]:
    """Where the largest growth changes its sign over the one parameter of `rest`, by bisection, and the mode that does.

    Parameters
    ----------
    rest
        With one free parameter.
    values
        Of it, in SI, rising or falling, shape (m,); two changes between neighbours are not seen.

    Returns
    -------
    list of (value, Mode)
    """
    from scipy.optimize import brentq

    growth = [rest.growth((value,)) for value in values]
    places = []
    for a, b, g, h in zip(values, values[1:], growth, growth[1:], strict=False):
        if (g > 0.0) != (h > 0.0):
            place = float(brentq(lambda v: rest.growth((v,)), a, b, xtol=CLOSE * abs(b - a)))
            places.append((place, modes_at(rest, (place,))[0]))
    return places
