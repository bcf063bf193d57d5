"""How right is a result? An estimate of the coupling error of every output, the observed order, and the stability margin.

Error: the run is repeated with the macro step halved and halved again. With y_h the run in question and order p,

    y_h - y = (y_h - y_{h/2}) 2^p / (2^p - 1) + higher orders    (Richardson),

p being the algorithm's order where the observed one agrees with it within 0.5, else the observed one.

Stability: with every component linearised where the run ended, a macro step of the very same algorithm is a linear map of the
components' states and the remembered outputs. Its spectral radius is compared with that of the exact solution over a step;
the largest stable step is the largest for which it does not exceed the larger of 1 and the exact one.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..coupling import Algorithm, History, Memory
from ..errors import ConvergenceError
from ..master import Run, run
from ..network import Network
from ..network.linearised import Linearised, linearised

HALVINGS = 2
MARGIN = 1e-9  # by how much a spectral radius may exceed its bound before a step counts as unstable


@dataclass(frozen=True)
class OutputError:
    """Estimated coupling error of one output: largest over the run, and at its end, in its own unit; and its largest size."""

    name: str
    unit: str
    largest: float
    end: float
    size: float


@dataclass(frozen=True)
class Stability:
    """radius : spectral radius of the macro-step map at the run's step. exact : that of the solution without coupling error.

    largest_step (s) : largest stable macro step; infinite if none up to 1000 times the run's is unstable.
    """

    radius: float
    exact: float
    largest_step: float

    def is_stable(self) -> bool:
        """Whether the coupling adds no instability at the run's step."""
        return self.radius <= max(1.0, self.exact) + MARGIN


@dataclass(frozen=True)
class Certificate:
    """errors : per output. observed_order : NaN where the differences are at rounding. stability : None where a component
    does not give its derivatives."""

    errors: tuple[OutputError, ...]
    observed_order: float
    stability: Stability | None

    @property
    def worst(self) -> OutputError:
        """The output with the largest error relative to its size."""
        return max(self.errors, key=lambda e: e.largest / e.size if e.size > 0.0 else 0.0)


def certify(network: Network, result: Run, stop: float, *, progress: Callable[[float, float], None] | None = None) -> Certificate:
    """Certify a run of `network` with even steps that kept every row. Runs it again, with two and four times the steps."""
    step, algorithm = result.step, result.algorithm
    stability = margin(network, algorithm, step)  # where the run ended, before the network starts anew
    runs, start = [result.trajectory], result.start
    for halving in range(1, HALVINGS + 1):
        again = run(network, algorithm, step / 2**halving, stop, start=start, progress=progress).trajectory
        runs.append(again)
    t = runs[0].t
    # A last step that is shorter need not be twice or four times a shorter one's: match rows by time.
    values = [r.values[np.searchsorted(r.t, t - 1e-9 * step)] for r in runs]
    size = np.abs(values[0]).max(axis=0)
    differences = [values[k] - values[k + 1] for k in range(HALVINGS)]
    shown = np.where(size > 0.0, size, 1.0)
    sizes = [float((np.abs(d).max(axis=0) / shown).max()) for d in differences]
    order = float(np.log2(sizes[0] / sizes[1])) if sizes[1] > 1e-13 else float("nan")
    p = order if abs(order - algorithm.order) > 0.5 and 0.2 < order < 6.0 else float(algorithm.order)
    error = differences[0] * 2**p / (2**p - 1)
    errors = tuple(
        OutputError(name, unit, float(np.abs(error[:, k]).max()), float(error[-1, k]), float(size[k]))
        for k, (name, unit) in enumerate(zip(runs[0].names, runs[0].units, strict=True))
    )
    return Certificate(errors, order, stability)


def margin(network: Network, algorithm: Algorithm, step: float) -> Stability | None:
    """The stability of the coupling with every component linearised where it stands."""
    linear = linearised(network)
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
    """Of the map (states, remembered coupled outputs) -> the same one macro step of h (s) later."""
    eigenvalues = np.linalg.eigvals(step_map(linear, algorithm, h))
    return float(np.abs(eigenvalues).max(initial=0.0))


def step_map(linear: Linearised, algorithm: Algorithm, h: float) -> np.ndarray:
    """The matrix of a macro step of h (s): found by doing the step, with the algorithm itself, from every unit vector.

    The vector: states of all slaves, then the coupled outputs one, two, ... steps ago, as many as the algorithm looks back.
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
