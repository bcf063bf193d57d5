"""Iterated coupling: repeat the macro step until the inputs agree with the outputs they led to.

Let z be the coupled outputs at the end of the step, as assumed for the input polynomials (of degree k, through z and the k
points before), and G(z) those that the slaves then reach. Sought is the fixed point z = G(z), where the inputs are
interpolated on all sides: order k + 1, and stable where one pass is not.

- "aitken": z + w (G(z) - z), with Aitken's w from the last two residuals.
- "newton": z + (I - J)^-1 (G(z) - z) with the interface Jacobian J = dG/dz. It starts from the components' own derivatives
  where they give them (directional derivatives of an FMU: the macro step is then done on the linearisations), else from
  differences, and is improved by Broyden's update in every iteration and kept from step to step.
Source: Kuettler and Wall, Fixed-point fluid-structure interaction solvers with dynamic relaxation (2008), for Aitken's w;
Sicklinger et al., Interface Jacobian-based co-simulation (2014).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..errors import ConvergenceError
from ..network import Network
from ..network.linearised import linearised
from .base import Algorithm, Used, discard_all, go_back, require_restore, save_all, step_all
from .history import History


@dataclass(frozen=True)
class Iterated(Algorithm):
    """Macro steps repeated to agreement. Order degree + 1.

    solver : "aitken" or "newton", see above.
    tolerance : largest change of a coupled output, relative to the largest size it has had, that counts as agreement.
    max_iterations : ConvergenceError if more are needed.
    """

    solver: Literal["aitken", "newton"] = "aitken"
    tolerance: float = 1e-10
    max_iterations: int = 50

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.solver not in ("aitken", "newton"):
            raise ValueError(f"solver must be aitken or newton, got {self.solver!r}")
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance must be positive, got {self.tolerance!r}")

    @property
    def name(self) -> str:
        return "iterated" if self.solver == "aitken" else "newton"

    def check(self, network: Network) -> None:
        require_restore(network, f"algorithm {self.name!r}")

    def advance(self, network: Network, history: History, h: float) -> tuple[np.ndarray, Used]:
        t, coupled = history.t[0], network.coupled
        guess = history.polynomial(min(self.degree, len(history.Y) - 1))
        Y = guess[0] + h * (guess[1] + h * guess[2] / 2)
        degree = min(self.degree, len(history.Y))
        size = np.max(np.abs([y[coupled] for y in history.Y] + [Y[coupled]]), axis=0, initial=0.0)
        network.largest = np.maximum(network.largest, size)
        states = save_all(network)
        update = _Aitken() if self.solver == "aitken" else _Newton(network, history, h, degree, states)
        try:
            for iteration in range(self.max_iterations):
                if iteration:
                    go_back(network, states)
                z = Y[coupled]
                used = step_all(network, history.through(h, Y, degree), t, h)
                reached = network.outputs(Y.copy(), t + h)
                history.iterations += 1
                residual = reached[coupled] - z
                if not np.any(np.abs(residual) > self.tolerance * np.maximum(network.largest, np.abs(reached[coupled]))):
                    return reached, used
                Y = reached
                Y[coupled] = z + update(z, residual)
        finally:
            discard_all(network, states)
        worst = network.names[coupled[int(np.argmax(np.abs(residual)))]]
        raise ConvergenceError(
            f"iteration of the macro step at t = {t:.9g} s over {h:g} s must converge within {self.max_iterations} iterations; "
            f"{worst} still changes by {np.abs(residual).max():.3g}"
        )


class _Aitken:
    """Relaxation whose factor follows from the last two residuals."""

    def __init__(self) -> None:
        self._factor, self._last = 1.0, np.empty(0)

    def __call__(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        if self._last.size:
            change = residual - self._last
            size = float(change @ change)
            if size > 0.0:
                self._factor *= -float(self._last @ change) / size
        self._last = residual
        return self._factor * residual


class _Newton:
    """Newton's method with a Jacobian that Broyden's update improves; history keeps it for the next macro step."""

    def __init__(self, network: Network, history: History, h: float, degree: int, states: list[object]) -> None:
        self._history = history
        if history.jacobian is None:
            linear = linearised(network)
            on = network if linear is None else linear.network
            history.jacobian = self._by_differences(on, history, h, degree, states if linear is None else None)
        self._last_z, self._last = np.empty(0), np.empty(0)

    def __call__(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        J = self._history.jacobian
        assert J is not None
        if self._last.size:  # G changed by dz + d(residual); make J explain it
            dz = z - self._last_z
            size = float(dz @ dz)
            if size > 0.0:
                J = J + np.outer(dz + residual - self._last - J @ dz, dz) / size
                self._history.jacobian = J
        self._last_z, self._last = z, residual
        return np.linalg.lstsq(np.eye(z.size) - J, residual)[0]

    @staticmethod
    def _by_differences(network: Network, history: History, h: float, degree: int, states: list[object] | None) -> np.ndarray:
        """dG/dz by repeating the macro step once for every coupled output, on the slaves or on their linearisations.

        states : where the slaves are to go back to; None for linearisations, which stand at zero.
        """
        coupled, t, base = network.coupled, history.t[0], history.Y[0]
        start = save_all(network) if states is None else states
        points = History(t, np.zeros_like(base) if states is None else base, history.held)
        if states is not None:
            points.t, points.Y = history.t, history.Y
        else:
            points.t, points.Y = list(history.t), [np.zeros_like(base) for _ in history.Y]

        def reached(Y: np.ndarray) -> np.ndarray:
            step_all(network, points.through(h, Y, degree), t, h)
            result = network.outputs(Y.copy(), t + h)[coupled]
            go_back(network, start)
            return result

        origin = points.Y[0]
        still, J = reached(origin), np.zeros((coupled.size, coupled.size))
        for column, k in enumerate(coupled):
            moved = origin.copy()
            moved[k] += 1.0 if states is None else 1e-6 * max(1.0, network.largest[column])
            J[:, column] = (reached(moved) - still) / (moved[k] - origin[k])
        return J
