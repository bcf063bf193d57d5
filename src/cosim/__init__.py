"""The master: it couples components through their signals, and knows none of them by name.

from gyro_cosim import Jacobi, simulate, system

run = simulate(system("wheel-pair"), algorithm=Jacobi(1), step=1e-3, stop=60.0)
print(run.trajectory["vehicle.yaw_angle"][-1], run.energy_residual)
"""

from .coupling import Algorithm, GaussSeidel, Iterated, Jacobi
from .errors import ConvergenceError, RunError, SlaveError, WiringError
from .master import Run, simulate
from .ssp import system
from .systems import Connection, PowerBond, System, SystemComponent
from .trajectory import Trajectory

__all__ = [
    "Algorithm",
    "Connection",
    "ConvergenceError",
    "GaussSeidel",
    "Iterated",
    "Jacobi",
    "PowerBond",
    "Run",
    "RunError",
    "SlaveError",
    "System",
    "SystemComponent",
    "Trajectory",
    "WiringError",
    "simulate",
    "system",
]
