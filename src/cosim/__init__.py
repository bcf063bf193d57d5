"""FMI co-simulation of a railway vehicle with a gyroscopic damper, and a co-simulation master for anyone's FMUs.

    from gyro_cosim import Jacobi, simulate, system

    run = simulate(system("wheel-pair"), algorithm=Jacobi(1), step=1e-3, stop=60.0)
    print(run)
    print(run.trajectory["vehicle.yaw_angle"][-1], run.energy_residual)

The names below are the public interface; what a wing offers besides stands in its own `__all__`. Everything is loaded when it
is first asked for. The log is Python's: `logging.getLogger("gyro_cosim")`, quiet unless a handler is set.
"""

import logging
from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .accuracy.certificate import certify
    from .accuracy.convergence import converge
    from .comparison.candidates import compare
    from .coupling import Algorithm, GaussSeidel, Iterated, Jacobi, Nepce, Newton
    from .errors import ConvergenceError, EndRequest, RunError, SlaveError, WiringError
    from .master import Options, Run, open_network, run, simulate
    from .master.adaptive import Adaptive
    from .master.checkpoint import Checkpoint, Resume
    from .master.recording import Recording
    from .ssp import system
    from .sweeps import Sweep, load, sweep
    from .systems import Connection, Conversion, Event, InputSeries, PowerBond, Scenario, StopWhen, System, SystemComponent
    from .trajectory import Trajectory, read_csv, read_results

    __version__: str

__all__ = [
    "Adaptive",
    "Algorithm",
    "Checkpoint",
    "Connection",
    "ConvergenceError",
    "Conversion",
    "EndRequest",
    "Event",
    "GaussSeidel",
    "InputSeries",
    "Iterated",
    "Jacobi",
    "Nepce",
    "Newton",
    "Options",
    "PowerBond",
    "Recording",
    "Resume",
    "Run",
    "RunError",
    "Scenario",
    "SlaveError",
    "StopWhen",
    "Sweep",
    "System",
    "SystemComponent",
    "Trajectory",
    "WiringError",
    "__version__",
    "certify",
    "compare",
    "converge",
    "load",
    "open_network",
    "read_csv",
    "read_results",
    "run",
    "simulate",
    "sweep",
    "system",
]  # fmt: skip

_WHERE = {
    "accuracy.certificate": ("certify",),
    "accuracy.convergence": ("converge",),
    "comparison.candidates": ("compare",),
    "coupling": ("Algorithm", "GaussSeidel", "Iterated", "Jacobi", "Nepce", "Newton"),
    "errors": ("ConvergenceError", "EndRequest", "RunError", "SlaveError", "WiringError"),
    "master": ("Options", "Run", "open_network", "run", "simulate"),
    "master.adaptive": ("Adaptive",),
    "master.checkpoint": ("Checkpoint", "Resume"),
    "master.recording": ("Recording",),
    "ssp": ("system",),
    "sweeps": ("Sweep", "load", "sweep"),
    "systems": (
        "Connection",
        "Conversion",
        "Event",
        "InputSeries",
        "PowerBond",
        "Scenario",
        "StopWhen",
        "System",
        "SystemComponent",
    ),
    "trajectory": ("Trajectory", "read_csv", "read_results"),
}
_MODULES = {name: module for module, names in _WHERE.items() for name in names}
_RENAMED = {"Part": "SystemComponent", "Hop": "Conversion"}  # to 0.2.0; goes with 0.3.0

logging.getLogger("gyro_cosim").addHandler(logging.NullHandler())


def __getattr__(name: str) -> Any:
    """Load what is asked for."""
    if name == "__version__":
        return metadata.version("gyro-cosim")
    if name in _RENAMED:
        raise AttributeError(f"gyro_cosim.{name} is called gyro_cosim.{_RENAMED[name]} since 0.2.0")
    if name not in _MODULES:
        raise AttributeError(f"module 'gyro_cosim' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
