"""What a time history says about the root behind it."""

import numpy as np


def measured_root(t: np.ndarray, y: np.ndarray) -> complex:
    """The root s (1/s) of y = Re(a e^{s t}), of either sign of growth, by Prony's method; imaginary part not negative.

    t : evenly spaced (s), shape (n,), over some periods. y : shape (n,), one oscillation alone, without offset.
    With z = e^{s m h} y(k + 2m) = 2 Re(z) y(k + m) - |z|^2 y(k), solved for both numbers over all k by
    least squares; m is half the time between two changes of sign, so that the three values differ as much as they can.
    """
    if not (t.ndim == 1 and t.shape == y.shape and np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0.0)):
        raise ValueError(f"`t` must be evenly spaced and as long as `y`, got shapes {t.shape} and {y.shape}")
    changes = np.flatnonzero(np.diff(np.signbit(y)))
    if changes.size < 3:
        raise ValueError(f"`y` must change its sign at least three times, it does {changes.size} times")
    m = max(1, round(float(np.diff(changes).mean()) / 2))
    rows = np.column_stack([y[m:-m], y[: -2 * m]])
    (sum_, product), *_ = np.linalg.lstsq(rows, y[2 * m :], rcond=None)
    z = np.roots([1.0, -sum_, -product])[0]
    s = np.log(z.astype(complex)) / (m * (t[1] - t[0]))
    return complex(s.real, abs(s.imag))
