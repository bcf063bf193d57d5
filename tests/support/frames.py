"""What gyro units are driven by in tests: a free frame to carry one, and prescribed rates."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gyro_cosim import Connection, System, SystemComponent
from gyro_cosim.component import Bond, Component, build, input_, parameter, state
from gyro_cosim.slaves import Slave, open_slave

HERE = str(Path(__file__))
AXES = ("yaw", "roll", "pitch")
YAW_INERTIA = 6.13e-3  # kg.m2


def free_frame() -> Component:
    """A body that turns about z: I_z psi'' = M + M_ext."""
    return build(
        name="frame", variant="free", description="Free frame", equations="I_z psi'' = M + M_ext",
        variables=(
            input_("yaw_moment", "N.m", "moment of the gyro unit"),
            state("yaw_rate", "rad/s", "yaw rate", is_output=True, source="test"),
            parameter("yaw_inertia", YAW_INERTIA, "kg.m2", "yaw inertia", source="test"),
            parameter("external_moment", 0.0, "N.m", "constant yaw moment from outside", source="test"),
        ),
        model=lambda s: ({"yaw_rate": (s["yaw_moment"] + s["external_moment"]) / s["yaw_inertia"]}, {}),
        internal_step=1e-3, bonds=(Bond("mount", "yaw", motion="yaw_rate", effort="yaw_moment"),),
    )  # fmt: skip


def framed(unit: str) -> System:
    """The gyro unit on the free frame."""
    wires = (("frame", "gyro", "yaw_rate"), ("gyro", "frame", "yaw_moment"))
    return System(
        "framed", (SystemComponent("frame", f"{HERE}:free_frame"), SystemComponent("gyro", unit)),
        tuple(Connection((a, signal), (b, signal)) for a, b, signal in wires),
    )  # fmt: skip


Rate = Callable[[float], tuple[float, float, float]]


def driven(
    source: str, rates: dict[str, Rate], *, stop: float, step: float = 1e-3, in_process: bool = True, **values: float
) -> dict[str, np.ndarray]:
    """The outputs of a unit at 0, step, ... under `rates`: axis -> function of t giving value, first and second derivative."""
    slave: Slave = open_slave("gyro", source, in_process=in_process)
    n = round(stop / step)
    try:
        slave.initialize(slave.description.start_values(slave.name, values), 0.0, stop)
        axes = [s.name.removesuffix("_rate") for s in slave.inputs]
        still: Rate = lambda t: (0.0, 0.0, 0.0)  # noqa: E731

        def at(t: float) -> np.ndarray:
            return np.array([rates.get(axis, still)(t) for axis in axes]).T

        rows = [slave.output(at(0.0)[0], 0.0)]
        for k in range(n):
            slave.step(at(k * step), k * step, step)
            rows.append(slave.output(at((k + 1) * step)[0], (k + 1) * step))
        names = [s.name for s in slave.outputs]
    finally:
        slave.close()
    return dict(zip(names, np.array(rows).T, strict=True)) | {"time": np.arange(n + 1) * step}


def sine(amplitude: float, omega: float, phase: float = 0.0) -> Rate:
    """amplitude sin(omega t + phase) with its derivatives."""

    def at(t: float) -> tuple[float, float, float]:
        s, c = np.sin(omega * t + phase), np.cos(omega * t + phase)
        return amplitude * s, amplitude * omega * c, -amplitude * omega**2 * s

    return at


def ramp(slope: float) -> Rate:
    """slope t."""
    return lambda t: (slope * t, slope, 0.0)
