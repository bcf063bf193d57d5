"""Hunting: where Cooperrider's bogie becomes unstable, and limit cycles by continuation against runs in time.

Cooperrider's bogie (1972) is two wheelsets of linear conicity in a frame with lateral, yaw and roll motion, under a car body
that moves straight on: seven degrees of freedom, creep forces by Vermeulen and Johnson, flanges as springs beyond a clearance.
Data are those of Kaas-Petersen 1986, as later papers hand them on; G pi a b is the value that Hassard 1999 found consistent.
"""

from functools import cache

import casadi as ca
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from gyro_cosim.stability import AtRest
from gyro_cosim.stability.limit_cycles import Branch, branch
from gyro_cosim.stability.modes import crossings
from gyro_cosim.systems import System, SystemComponent, catalogue

from .table import Line, Quantity, Table

__all__ = ["Bogie", "bogie_cycles", "cycles", "hopf"]

WHEELSET, FRAME = (1022.0, 678.0), (2918.0, 6780.0, 6780.0)  # kg, kg m2: yaw, and roll of the frame
K1, K2, K3, K4, K5, K6 = 1.823e6, 3.646e6, 3.646e6, 182.3e3, 333.3e3, 2.710e6  # N/m; K6 N m
D1, D2 = 20e3, 29.2e3  # N s/m
HALF_GAUGE, HALF_BASE = 0.716, 1.074  # m
H1, H2, ARM1, ARM2 = 0.0762, 0.6584, 0.620, 0.680  # m
CONICITY, RADIUS = 0.05, 0.4572  # 1, m
PHI, PSI, LIMIT, STRENGTH = 0.54219, 0.60252, 10e3, 6.563e6  # 1, 1, N, N: G pi a b
FLANGE, CLEARANCE = 14.6e6, 9.1e-3  # N/m, m
PUBLISHED = 68.66  # m/s, Hassard 1999 in the collection of examples of bifurcation.de
MM = 1e3


class Bogie:
    """z' = f(z, v): lateral and yaw of both wheelsets; lateral, yaw and roll of the frame; and their rates."""

    def __init__(self) -> None:
        z, v = ca.SX.sym("z", 14), ca.SX.sym("v")
        q, p = z[:7], z[7:]
        pull = [2 * K1 * (q[2 * i] - q[4] - side * HALF_BASE * q[5] - H1 * q[6]) for i, side in ((0, 1), (1, -1))]
        turn = [2 * K2 * ARM1**2 * (q[2 * i + 1] - q[5]) for i in (0, 1)]
        swing = 2 * D2 * (p[4] - H2 * p[6]) + 2 * K4 * (q[4] - H2 * q[6])
        roll = 2 * D1 * ARM2**2 * p[6] + (2 * K5 * ARM2**2 + 4 * K3 * ARM1**2) * q[6]
        rates = []
        for i in (0, 1):
            y, psi, dy, dpsi = q[2 * i], q[2 * i + 1], p[2 * i], p[2 * i + 1]
            across, along = dy / v - psi, HALF_GAUGE * dpsi / v + CONICITY * y / RADIUS
            size = ca.sqrt((across / PHI) ** 2 + (along / PSI) ** 2 + 1e-24)
            u = STRENGTH / LIMIT * size
            force = LIMIT * ca.if_else(u < 3, u - u**2 / 3 + u**3 / 27, 1) / size
            flange = FLANGE * (ca.fmax(y - CLEARANCE, 0) - ca.fmax(-y - CLEARANCE, 0))
            rates += [-(pull[i] + 2 * force * across / PHI + flange) / WHEELSET[0],
                      -(turn[i] + 2 * HALF_GAUGE * force * along / PSI) / WHEELSET[1]]  # fmt: skip
        rates += [(pull[0] + pull[1] - swing) / FRAME[0],
                  (HALF_BASE * (pull[0] - pull[1]) + turn[0] + turn[1] - K6 * q[5]) / FRAME[1],
                  (H1 * (pull[0] + pull[1]) + H2 * swing - roll) / FRAME[2]]  # fmt: skip
        f = ca.vertcat(p, *rates)
        self._f, self._slopes, self._by_v = (
            ca.Function(name, [z, v], [ca.densify(made)])
            for name, made in (("f", f), ("slopes", ca.jacobian(f, z)), ("by_v", ca.jacobian(f, v)))
        )

    def rates(self, z: np.ndarray, v: float) -> np.ndarray:
        """f of many z."""
        return np.array(self._f(z.T, v)).T

    def slopes(self, z: np.ndarray, v: float) -> np.ndarray:
        """df/dz."""
        return np.array(self._slopes(z.T, v)).reshape(14, len(z), 14).transpose(1, 0, 2)

    def by_parameter(self, z: np.ndarray, v: float) -> np.ndarray:
        """df/dv."""
        return np.array(self._by_v(z.T, v)).T

    def hopf(self) -> tuple[float, complex, np.ndarray]:
        """Speed, root and mode at which rest becomes unstable; the mode has 1 mm of the front wheelset."""

        def at(v: float) -> np.ndarray:
            return np.asarray(self.slopes(np.zeros((1, 14)), v)[0])

        v = brentq(lambda v: np.linalg.eigvals(at(v)).real.max(), 60.0, 75.0)
        values, vectors = np.linalg.eig(at(v))
        k = int(np.argmax(np.where(values.imag > 0, values.real, -np.inf)))
        return float(v), 1j * values[k].imag, vectors[:, k] / abs(vectors[0, k]) / MM


@cache
def bogie_cycles() -> tuple[Bogie, Branch]:
    """Cycles of the bogie up to 90 m/s."""
    bogie = Bogie()
    return bogie, branch(bogie, bogie.hopf(), (50.0, 90.0), intervals=40)


def hopf() -> Table:
    """Of Cooperrider's bogie."""
    line = Line("rest of the bogie becomes unstable, m/s", ((Bogie().hopf()[0], PUBLISHED),))
    return Table("Hassard 1999 (bifurcation.de), to the digits printed", (Quantity("", ".2f", 0.05),), (line,))


def cycles() -> Table:
    """Stable cycles on the branch nearest to some speeds: amplitude of a wheelset, frequency; begun elsewhere, run in time."""
    bogie, found = bogie_cycles()
    lines = []
    for wanted in (70.0, 80.0):
        cycle = min((c for c in found.cycles if c.is_stable), key=lambda c: abs(c.v - wanted))
        run = solve_ivp(lambda _, z, v=cycle.v: bogie.rates(z[None], v)[0], (0.0, 12.0), [0.012, *13 * [0.0]], "LSODA",
                        t_eval=np.linspace(10.0, 12.0, 4001), rtol=1e-8, atol=1e-10)  # fmt: skip
        lines.append(_line(f"Cooperrider's bogie at {cycle.v:.1f} m/s", cycle.amplitudes()[0], cycle.frequency, run.t, run.y[0]))
    system = System("wheelset", (SystemComponent("vehicle", "vehicle:wheelset"),), ())
    rest = AtRest(system, ("vehicle.speed",), ("vehicle.*distance",))
    ((v, mode),) = crossings(rest, np.linspace(10.0, 60.0, 6))
    along = branch(rest.flow(), (v, 1j * mode.root.imag, mode.shape / abs(mode.shape[0]) / MM), (10.0, 60.0), scale=2.0 / v)
    for wanted in (30.0, 50.0):
        cycle = min(along.cycles, key=lambda c: abs(c.v - wanted))
        t, y = _wheelset(cycle.v)
        lines.append(_line(f"`vehicle:wheelset` at {cycle.v:.1f} m/s", cycle.amplitudes()[0], cycle.frequency, t, y))
    return Table("the same equations in time, from another start", (Quantity("amplitude, mm", ".3f", 5e-3, relative=True),
                                                                   Quantity("frequency, Hz", ".4f", 2e-3, relative=True)),
                 tuple(lines))  # fmt: skip


def _line(case: str, amplitude: float, frequency: float, t: np.ndarray, y: np.ndarray) -> Line:
    up = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    crossing = t[up] - y[up] * (t[up + 1] - t[up]) / (y[up + 1] - y[up])
    run = MM * float(y.max() - y.min()) / 2, float((len(crossing) - 1) / (crossing[-1] - crossing[0]))
    return Line(case, ((MM * float(amplitude), run[0]), (frequency, run[1])))


def _wheelset(v: float) -> tuple[np.ndarray, np.ndarray]:
    """Lateral displacement over the last of 8 s, by the component's own steps from 1 mm on."""
    c = catalogue.component("vehicle:wheelset")
    p, u, h = c.start_parameters.copy(), np.zeros((len(c.inputs), 3)), 1e-3
    p[[q.name for q in c.parameters].index("speed")] = v
    row = [q.name for q in c.states].index("lateral_displacement")
    x, places = c.start_state.copy(), []
    x[row] = 1e-3
    for _ in range(8000):
        x = np.array(c.step(x, u, p, 0.0, h)).ravel()
        places.append(x[row])
    return h * np.arange(6001, 8001), np.array(places[6000:])
