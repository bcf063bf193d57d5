"""A macro step of a component: the definition of what the FMU's doStep does.

fmus/c/step.c repeats it, operation by operation, so that both give the same bits.
"""

import numpy as np

from .integration import ErrorControl, Progress, StepError, advance, input_at, pieces
from .methods import METHODS
from .model import Component

__all__ = ["error_control", "macro_step"]


def error_control(component: Component, tolerance: float) -> ErrorControl | None:
    """Choose what decides on internal steps.

    Parameters
    ----------
    component : Component
        Whose method and nominal values count.
    tolerance : float
        Relative error of an internal step; 0 for equal steps.

    Returns
    -------
    ErrorControl or None
        None for tolerance 0.
    """
    if not tolerance > 0.0:
        return None
    nominal = np.array([abs(v.nominal) if v.nominal else 1.0 for v in component.states])
    return ErrorControl(METHODS[component.method].order, tolerance, nominal)


def macro_step(
    component: Component, x: np.ndarray, U: np.ndarray, p: np.ndarray, t: float, h: float, *,
    internal_step: float, tolerance: float = 0.0, progress: Progress | None = None,
) -> tuple[np.ndarray, Progress]:  # fmt: skip
    """Take one macro step.

    Parameters
    ----------
    component : Component
        What moves.
    x : array, shape (n_x,)
        States at t. Left alone.
    U : array, shape (n_u, 3)
        Value, first and second derivative of the inputs at t; with the component's units, per s and per s^2.
    p : array, shape (n_p,)
        Parameters.
    t, h : float
        Start and length of the step (s).
    internal_step : float
        Longest internal step (s); with error control the first length that is tried.
    tolerance : float
        Relative error of an internal step; 0 for equal steps.
    progress : Progress, optional
        What the step before returned. Before the first step of a sampled component
        Progress(first_sample(component.sample_period, t)); None: Progress().

    Returns
    -------
    x : array, shape (n_x,)
        States at t + h.
    progress : Progress
        For the next macro step.

    Raises
    ------
    StepError
        If no finite state is reached, or the tolerance cannot be met.
    """

    def one(x: np.ndarray, tau: float, h: float) -> np.ndarray:
        return np.array(component.step(x, U, p, tau, h)).ravel()

    progress = progress or Progress()
    samples, first = progress.samples, progress.step
    control = error_control(component, tolerance)
    for offset, length, due in pieces(t, h, component.sample_period, samples):
        for _ in range(due):
            assert component.sample is not None
            x = np.array(component.sample(x, input_at(U, offset), p)).ravel()
        if not np.all(np.isfinite(x)):
            raise StepError("the sampled part gives no finite state")
        samples += due
        x, first = advance(one, x, offset, length, internal_step=internal_step, control=control, first=first)
    return x, Progress(samples, first)
