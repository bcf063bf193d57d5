"""What the errors of all macro steps come to: the error of a run with adaptive steps, which its tolerance does not tell.

The tolerance of adaptive steps bounds the error of each step by itself. The run is therefore done once more on another grid made
of its own communication points, with every two steps in one; with order p the error at a point is then

    y - y_exact = (y_2h - y) / (2^p - 1) + higher orders    (Richardson on a grid of varying steps).

That costs half of what the run's own steps cost. Where steps twice as long go wrong, or say that the error is large, it is done
with every step halved instead: y - y_exact = (y - y_h/2) 2^p / (2^p - 1).
"""

from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from ..master import Options, Progress, Run, run
from ..master.adaptive import fixed_step
from ..master.recording import Recording
from ..network import Network
from .certificate import LARGE, OutputError, halved, output_errors

AGAIN = "by doing the run again with"


@dataclass(frozen=True)
class GlobalError:
    """The estimated error of a run with adaptive steps, over the whole run.

    Parameters
    ----------
    errors
        One for each output; empty where there is no estimate.
    how
        By what it was estimated, or why it could not be.
    """

    errors: tuple[OutputError, ...]
    how: str

    @property
    def worst(self) -> OutputError | None:
        """The output with the largest error relative to its size; None where there is no estimate."""
        return max(self.errors, key=lambda e: e.largest / e.size if e.size > 0.0 else 0.0, default=None)


def global_error(network: Network, result: Run, stop: float, *, progress: Progress | None = None) -> GlobalError:
    """Estimate the error of a run over its whole length, by doing it again in other steps.

    Parameters
    ----------
    network
        The network of the run, still open.
    result
        A run that kept every row.
    stop
        The end of the run, s.
    progress
        Called with the time reached and the end of the further run, s.

    Returns
    -------
    GlobalError
        Without errors where they cannot be estimated.
    """
    size = np.abs(result.trajectory.values).max(axis=0)
    t, values, p = result.trajectory.t, result.trajectory.values, result.algorithm.order
    if t.size != result.steps + 1 or t[-1] != stop:
        return GlobalError((), "it needs every communication point of a whole run")
    if t.size >= 5 and not network.driving:  # a scenario counts at points of the run, which two steps in one would leave out
        coarse = t[::2] if t.size % 2 else np.append(t[::2], t[-1])
        again = _again(network, result, coarse, progress)
        if isinstance(again, np.ndarray):
            error = (again - values[np.searchsorted(t, coarse)]) / (2**p - 1)
            if _share(error, size) <= LARGE or fixed_step(network)[0]:  # no step inside can be halved
                return GlobalError(output_errors(result.trajectory, error, size), f"{AGAIN} every two steps in one")
    again = _again(network, result, halved(t), progress)
    if isinstance(again, str):
        return GlobalError((), f"with every step halved {again}")
    error = (values - again[::2]) * 2**p / (2**p - 1)
    return GlobalError(output_errors(result.trajectory, error, size), f"{AGAIN} every step halved")


def _again(network: Network, result: Run, points: np.ndarray, progress: Progress | None) -> np.ndarray | str:
    """The outputs of the run done again at these points, shape (n, n_Y), or why it did not reach its end."""
    options = Options(record=Recording(select=result.trajectory.names), points=points)
    try:
        again = run(
            network, result.algorithm, result.step, float(points[-1]), start=result.start, options=options, progress=progress
        )
    except RunError as error:
        return str(error)
    return again.trajectory.values if again.status == "done" else f"the run ends before its time: {again.ended_by}"


def _share(error: np.ndarray, size: np.ndarray) -> float:
    """The largest error as a share of its output's size; infinite where one is no number."""
    share = float((np.abs(error).max(axis=0) / np.where(size > 0.0, size, 1.0)).max(initial=0.0))
    return share if share == share else float("inf")
