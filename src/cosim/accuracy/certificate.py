"""How right is a result? An estimate of the coupling error of every output, the observed order, and the stability margin.

Error: the run is repeated with the macro step halved and halved again. With y_h the run in question and order p,

    y_h - y = (y_h - y_{h/2}) 2^p / (2^p - 1) + higher orders    (Richardson),

p being the algorithm's order where the observed one agrees with it within 0.5, else the observed one. Where the differences
do not shrink with the step (a chaotic run, an unstable coupling) nothing is estimated, and the certificate says why.

A run with adaptive steps is done again on its own grid with every step halved, and halved again; its stability is that of even
steps as long as its longest.

Stability: with every component linearised where the run ended, a macro step of the very same algorithm is a linear map of the
components' states and the remembered outputs. Its spectral radius is compared with that of the exact solution over a step;
the largest stable step is the largest for which it does not exceed the larger of 1 and the exact one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..coupling import Algorithm, History, Memory
from ..errors import ConvergenceError
from ..master import Options, Progress, Run, run
from ..network import Network
from ..network.linearised import Linearised, linearise_network
from ..trajectory import Trajectory

HALVINGS = 2
ROUNDING, NEARLY_ROUNDING = 1e-13, 1e-9  # shares of an output's size; below the second a difference need not shrink any more
LEAST_ORDER = 0.2  # an observed order that is not above it is no convergence
AGREES = 0.5  # the observed order and the algorithm's are the same within this
LARGE = 0.1  # share of an output's size above which a difference must follow the algorithm's order
MARGIN = 1e-9  # by how much a spectral radius may exceed its bound before a step counts as unstable


@dataclass(frozen=True)
class OutputError:
    """Estimated coupling error of one output, in the output's unit.

    Parameters
    ----------
    name, unit
        Of the output.
    largest, end
        The largest size of the error over the run, and the error at its end; NaN where there is no estimate.
    size
        The largest size of the output itself.
    """

    name: str
    unit: str
    largest: float
    end: float
    size: float


@dataclass(frozen=True)
class Stability:
    """The stability of the coupling at one macro step, and the largest step at which it is stable.

    Parameters
    ----------
    radius
        Spectral radius of the map that a macro step is.
    exact
        That of the solution without coupling error.
    largest_step
        The largest stable macro step, s; infinite where none up to 1000 times the run's is unstable.
    """

    radius: float
    exact: float
    largest_step: float

    def is_stable(self) -> bool:
        """Whether the coupling adds no instability at the run's step."""
        return self.radius <= max(1.0, self.exact) + MARGIN


@dataclass(frozen=True)
class Certificate:
    """What is known about the coupling error of a run.

    Parameters
    ----------
    errors
        One for each output; where there is no estimate, `largest` and `end` are NaN and `size` is still known.
    observed_order
        Of accuracy, from the three runs; NaN where the differences are at rounding, or a run did not reach the end.
    stability
        None where a component does not give its derivatives.
    no_estimate
        Why there is no estimate of the errors; empty where there is one.
    """

    errors: tuple[OutputError, ...]
    observed_order: float
    stability: Stability | None
    no_estimate: str = ""

    @property
    def worst(self) -> OutputError | None:
        """The output with the largest error relative to its size; None where there is no estimate."""
        if self.no_estimate:
            return None
        return max(self.errors, key=lambda e: e.largest / e.size if e.size > 0.0 else 0.0)


def certify(network: Network, result: Run, stop: float, *, progress: Progress | None = None) -> Certificate:
    """Certify a run by running it again with two and four times the steps.

    Parameters
    ----------
    network
        The network of the run, still open.
    result
        A run that kept every row; one with adaptive steps is done again at its own communication points and between them.
    stop
        The end of the run, s.
    progress
        Called with the time reached and the end of each further run, s.

    Returns
    -------
    Certificate
        Without an estimate where the results do not converge; `no_estimate` then says why.

    Raises
    ------
    RunError
        Where a component fails over the shorter steps.
    ValueError
        Where a run with adaptive steps has not kept every row.
    """
    step, algorithm, adapted = result.step, result.algorithm, result.adaptive is not None
    if adapted:
        if result.trajectory.t.size != result.steps + 1:
            raise ValueError("the certificate of a run with adaptive steps needs every communication point")
        step = float(np.diff(result.trajectory.t).max())
    stability = margin(network, algorithm, step)  # where the run ended, before the network starts anew
    trajectories, start = [result.trajectory], result.start
    t, coarse = result.trajectory.t, result.trajectory
    size = np.abs(coarse.values).max(axis=0)
    points = t
    for halving in range(1, HALVINGS + 1):
        points = halved(points)
        if adapted:
            finer = run(network, algorithm, result.step, stop, start=start, options=Options(points=points), progress=progress)
        else:
            finer = run(network, algorithm, result.step / 2**halving, stop, start=start, progress=progress)
        if finer.status != "done":  # a stop condition that the run in question just missed
            shorter = f"every macro step cut into {2**halving}" if adapted else f"a macro step of {finer.step:g} s"
            reason = f"with {shorter} the run ends before its time: {finer.ended_by}"
            return Certificate(output_errors(coarse, np.full_like(coarse.values, np.nan), size), float("nan"), stability, reason)
        trajectories.append(finer.trajectory)
    # A last step that is shorter need not be twice or four times a shorter one's: match rows by time.
    early = 1e-9 * float(np.diff(t).min())
    values = [r.values[np.searchsorted(r.t, t - early)] for r in trajectories]
    differences = [values[k] - values[k + 1] for k in range(HALVINGS)]
    shown = np.where(size > 0.0, size, 1.0)
    shares = [float((np.abs(d).max(axis=0) / shown).max()) for d in differences]
    order = _observed_order(shares)
    reason = _divergence(shares, order, algorithm.order)
    if reason:
        return Certificate(output_errors(coarse, np.full_like(coarse.values, np.nan), size), order, stability, reason)
    p = order if abs(order - algorithm.order) > AGREES and LEAST_ORDER < order < 6.0 else float(algorithm.order)
    return Certificate(output_errors(coarse, differences[0] * 2**p / (2**p - 1), size), order, stability)


def halved(t: np.ndarray) -> np.ndarray:
    """The points with one in the middle of every two, shape (2 n - 1,) of shape (n,)."""
    points = np.empty(2 * t.size - 1)
    points[::2], points[1::2] = t, (t[:-1] + t[1:]) / 2
    return points


def output_errors(trajectory: Trajectory, error: np.ndarray, size: np.ndarray) -> tuple[OutputError, ...]:
    """From the errors at every row, shape (n, n_y), and the outputs' sizes, shape (n_y,)."""
    return tuple(
        OutputError(name, unit, float(np.abs(error[:, k]).max()), float(error[-1, k]), float(size[k]))
        for k, (name, unit) in enumerate(zip(trajectory.names, trajectory.units, strict=True))
    )


def _observed_order(shares: Sequence[float]) -> float:
    """From the largest differences, as shares of the outputs' sizes; NaN where they are at rounding."""
    if shares[1] <= ROUNDING or (max(shares) < NEARLY_ROUNDING and shares[1] > shares[0] / 2**LEAST_ORDER):
        return float("nan")
    return float(np.log2(shares[0] / shares[1])) if shares[0] > 0.0 else -np.inf


def _divergence(shares: Sequence[float], order: float, stated: int) -> str:
    """Why no error can be estimated from these differences; empty where one can."""
    if order <= LEAST_ORDER:
        return (
            f"the results do not converge: halving the macro step changes an output by {shares[0]:.3g} of its size, "
            f"halving it again by {shares[1]:.3g}"
        )
    if abs(order - stated) > AGREES and shares[1] > LARGE:
        return (
            f"the macro step is too coarse: the observed order {order:.2f} is not the algorithm's {stated}, "
            f"and half the step still changes an output by {shares[1]:.3g} of its size"
        )
    return ""


def margin(network: Network, algorithm: Algorithm, step: float) -> Stability | None:
    """The stability of the coupling with every component linearised where it stands.

    Parameters
    ----------
    network
        Initialised; its slaves are not moved.
    algorithm
        Whose macro step is examined.
    step
        The macro step, s.

    Returns
    -------
    Stability or None
        None where a component does not give its derivatives.
    """
    linear = linearise_network(network)
    if linear is None:
        return None
    growth = float(np.linalg.eigvals(linear.joined()).real.max(initial=-np.inf)) if linear.size else -np.inf

    def stable(h: float) -> bool:
        try:
            return spectral_radius(linear, algorithm, h) <= max(1.0, float(np.exp(growth * h))) * (1 + MARGIN)
        except ConvergenceError:  # a step over which an iterated algorithm finds no agreement is of no use either
            return False

    radius, exact = spectral_radius(linear, algorithm, step), float(np.exp(growth * step))
    low = step
    while not stable(low) and low > step / 1024:
        low /= 2
    high = low
    while stable(high):
        low, high = high, high * 1.25
        if high > 1000 * step:
            return Stability(radius, exact, float("inf"))
    for _ in range(20):
        middle = (low + high) / 2
        low, high = (middle, high) if stable(middle) else (low, middle)
    return Stability(radius, exact, low)


def spectral_radius(linear: Linearised, algorithm: Algorithm, h: float) -> float:
    """The spectral radius of `step_map`: above 1 the coupled system grows."""
    eigenvalues = np.linalg.eigvals(step_map(linear, algorithm, h))
    return float(np.abs(eigenvalues).max(initial=0.0))


def step_map(linear: Linearised, algorithm: Algorithm, h: float) -> np.ndarray:
    """The matrix of a macro step of h (s): found by doing the step, with the algorithm itself, from every unit vector.

    Returns
    -------
    matrix
        Shape (n, n). The vector that it maps holds the states of all slaves, then the coupled outputs one, two, ... steps ago,
        as many as the algorithm looks back.
    """
    network, n = linear.network, linear.size
    coupled, past = network.coupled, algorithm.looks_back
    size = n + past * coupled.size
    matrix = np.zeros((size, size))
    memory: Memory = {}  # of the columns before: it holds how large signals are, without which zero is never reached
    for column in range(size):
        vector = np.zeros(size)
        vector[column] = 1.0
        linear.put(vector[:n])
        Y = network.outputs(np.zeros(len(network.names)), 0.0)
        points = np.zeros((1 + past, Y.size))  # newest first
        points[0], points[1:, coupled] = Y, vector[n:].reshape(past, coupled.size)
        history = History(tuple(-k * h for k in range(1 + past)), tuple(points), network.held)
        now = Y[coupled].copy()
        memory = algorithm.advance(network, history, h, memory).memory
        matrix[:n, column] = linear.states()
        if past:
            matrix[n : n + coupled.size, column] = now
            matrix[n + coupled.size :, column] = vector[n : size - coupled.size]
    return matrix
