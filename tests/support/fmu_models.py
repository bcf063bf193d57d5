"""Small components that the exporter's tests need beside the project's own: each has one feature the others lack."""

from collections.abc import Callable
from functools import partial
from pkgutil import resolve_name
from typing import Any, cast

import casadi as ca
import numpy as np

from gyro_cosim.component import Component, build, input_, output, parameter, state
from gyro_cosim.component.do_step import macro_step
from gyro_cosim.component.integration import Progress, first_sample, input_at
from gyro_cosim.component.tables import surface, table
from gyro_cosim.slaves.machine_code import MachineCode


def plain(**changes: object) -> Component:
    """A damped pendulum with feedthrough: y = angle + u, drive u; smooth and nonlinear."""
    options = {
        "name": "pendulum", "variant": "plain", "description": "Damped pendulum", "equations": "phi'' = -k sin(phi) - d phi' + u",
        "internal_step": 2e-3,
        "variables": [
            state("phi", "rad", "angle", start=0.5, is_output=True), state("omega", "rad/s", "rate", nominal=2.0),
            input_("u", "rad/s2", "drive"), output("y", "rad", "angle plus drive"),
            parameter("k", 9.0, "1/s2", "stiffness", source="test", min=0.0, max=1e6),
            parameter("d", 0.3, "1/s", "damping", source="test"),
        ],
        "model": lambda s: (
            {"phi": s["omega"], "omega": -s["k"] * ca.sin(s["phi"]) - s["d"] * s["omega"] + s["u"]},
            {"y": s["phi"] + s["u"]},
        ),
    } | changes  # fmt: skip
    return build(**options)  # type: ignore[arg-type]


def stiff(method: str) -> Component:
    """Two time scales 1 and 1e-5 s, nonlinear, integrated with internal steps a thousand times the fast one."""
    return build(
        name="stiff", variant=method, description="Two time scales", equations="", internal_step=1e-2, method=method,
        variables=[
            state("slow", "1", "slow", start=1.0, is_output=True), state("fast", "1", "fast", start=0.0, is_output=True),
            input_("u", "1", "drive"), parameter("rate", 1e5, "1/s", "fast rate", source="test"),
        ],
        model=lambda s: (
            {"slow": -s["slow"] * s["fast"] + s["u"], "fast": s["rate"] * (ca.cos(s["slow"]) - s["fast"])}, {},
        ),
    )  # fmt: skip


def sampled() -> Component:
    """A plant with a sampled integrating controller: the actuator holds between instants 7 ms apart."""
    return build(
        name="sampled", variant="pi", description="Sampled controller", equations="", internal_step=1e-3, sample_period=7e-3,
        variables=[
            state("level", "m", "level", is_output=True), state("valve", "1", "valve", discrete=True, is_output=True),
            state("integral", "1", "controller's sum", discrete=True), input_("wish", "m", "wanted level"),
            parameter("gain", 0.8, "1/m", "gain", source="test"),
        ],
        model=lambda s: ({"level": 5 * s["valve"] - 2 * s["level"]}, {}),
        sample=lambda s: {
            "integral": s["integral"] + 0.1 * s["gain"] * (s["wish"] - s["level"]),
            "valve": s["integral"] + s["gain"] * (s["wish"] - s["level"]),
        },
    )  # fmt: skip


def gain() -> Component:
    """No state: y = 3 u."""
    return build(
        name="gain", variant="three", description="Gain", equations="y = 3 u", internal_step=0.1,
        variables=[input_("u", "1", "in"), output("y", "1", "out")], model=lambda s: ({}, {"y": 3 * s["u"]}),
    )  # fmt: skip


def autonomous(method: str = "rk4", internal_step: float = 1e-2) -> Component:
    """No input and no parameter: growth without bound at t = 1."""
    return build(
        name="growth", variant=method, description="x' = x^2", equations="x' = x^2", internal_step=internal_step, method=method,
        variables=[state("x", "1", "size", start=1.0, is_output=True)], model=lambda s: ({"x": s["x"] ** 2}, {}),
    )  # fmt: skip


def tabled() -> Component:
    """Tables of one variable and of two, with and without search: a body that rolls over hills through winds."""
    x = np.linspace(0.0, 3.0, 13)
    hills = table(x, np.column_stack([np.sin(2 * x), np.cos(3 * x)]), name="distance")
    drag = table([0.0, 0.2, 0.7, 1.0, 3.0], [0.0, 0.1, 0.5, 0.6, 4.0], kind="monotone", ends="straight", name="speed")
    wind = surface(x[::2], [-2.0, 0.0, 1.0, 4.0], np.random.default_rng(4).standard_normal((7, 4)))
    return build(
        name="tabled", variant="hills", description="A body on hills", equations="s'' = hill(s) - drag(s') + wind(s, u)",
        internal_step=2e-3,
        variables=[
            state("s", "m", "distance", start=0.4, is_output=True), state("v", "m/s", "speed", start=0.5),
            input_("u", "m/s", "weather"), output("height", "m", "of the hill"), parameter("d", 0.3, "1", "drag", source="test"),
        ],
        model=lambda s: (
            {"s": s["v"], "v": hills(s["s"])[0] - s["d"] * drag(s["v"]) + wind(s["s"], s["u"])},
            {"height": hills(s["s"])[1]},
        ),
    )  # fmt: skip


COMPONENTS: dict[str, Callable[[], Component]] = {
    "gyro_unit:nonlinear": resolve_name("gyro_cosim.gyro_unit.nonlinear:nonlinear_small"),
    "vehicle:wheel_pair": resolve_name("gyro_cosim.vehicle.wheel_pair:small_wheel_pair"),
    "plain": plain, "rosenbrock": lambda: stiff("rosenbrock"), "radau": lambda: stiff("radau"),
    "sampled": sampled, "gain": gain, "autonomous": autonomous, "implicit growth": lambda: autonomous("radau", 1e-3),
    "tabled": tabled,
}  # fmt: skip


class Compiled:
    """A component whose functions are machine code, as far as macro_step looks at it."""

    def __init__(self, c: Component) -> None:
        self._c, self._code = c, MachineCode(c)
        self.sample_period, self.method, self.states = c.sample_period, c.method, c.states
        self.sample = None if c.sample is None else partial(self._call, "sample", len(c.states))

    def _call(self, name: str, size: int, *arguments: Any) -> np.ndarray:
        given, result = [np.array(np.transpose(a), dtype=float) for a in arguments], np.zeros(size)
        P = np.zeros(self._code.prepared)
        self._code.bound("prepare", [given[2]], P)()
        given[2] = P
        self._code.bound(name, [np.ascontiguousarray(a) for a in given], result)()
        return result

    def step(self, *arguments: Any) -> np.ndarray:
        return self._call("step", len(self.states), *arguments)

    def output(self, *arguments: Any) -> np.ndarray:
        return self._call("output", len(self._c.outputs), *arguments)


def in_process(
    c: Component, steps: list[tuple[float, float, np.ndarray]], *, internal_step: float | None = None, tolerance: float = 0.0,
    parameters: np.ndarray | None = None, state: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """Outputs after each (t, h, U), shape (len(steps), n_y): stepped by the definition, with the functions as machine code."""
    x, p = c.start_state if state is None else state, c.start_parameters if parameters is None else parameters
    progress, rows = Progress(first_sample(c.sample_period, steps[0][0])), []
    code = Compiled(c)
    for t, h, U in steps:
        x, progress = macro_step(
            cast("Component", code),
            x,
            U,
            p,
            t,
            h,
            internal_step=internal_step or c.internal_step,
            tolerance=tolerance,
            progress=progress,
        )
        rows.append(code.output(x, input_at(U, h), p))
    return np.array(rows)


def random_steps(c: Component, h: float, n: int, *, seed: int = 0, size: float = 1.0) -> list[tuple[float, float, np.ndarray]]:
    """n macro steps of uneven length about h with random input polynomials of degree 2."""
    rng = np.random.default_rng(seed)
    t, steps = 0.0, []
    for _ in range(n):
        length = h * (0.5 + rng.random())
        steps.append((t, length, size * rng.standard_normal((len(c.inputs), 3)) * [1.0, 0.5 / h, 0.5 / h**2]))
        t += length
    return steps
