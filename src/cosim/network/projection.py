"""Input polynomials that a slave cannot follow as they are."""

import numpy as np


def projected(U: np.ndarray, h: float, degree: int) -> np.ndarray:
    """The least-squares projection over [0, h] of an input polynomial U, shape (3, n_u), on a lower degree.

    A slave that follows constant inputs then sees the mean, one that follows linear ones the best line: constant keeps
    order 2, linear order 3, where cutting the polynomial off would lose one.
    """
    if degree >= 2 or not U[degree + 1 :].any():
        return U
    value, slope = U[0] - U[2] * (h * h / 12), U[1] + U[2] * (h / 2)  # s^2 / 2 is on [0, h] nearest to h s / 2 - h^2 / 12
    if degree == 0:
        value, slope = value + slope * (h / 2), np.zeros_like(slope)
    return np.array([value, slope, np.zeros_like(slope)])
