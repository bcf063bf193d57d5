"""Lorenz's equations in two components: chaos, whose error after some time no macro step makes small.

flow:  x' = 10 (y - x),   y' = x (28 - z) - y       in z, out x, y
heat:  z' = x y - 8/3 z                             in x, y, out z
"""

from gyro_cosim import Connection, System, SystemComponent
from gyro_cosim.component import Component, build, input_, state

HERE = __file__


def flow() -> Component:
    """The turning fluid."""
    return build(
        name="lorenz", variant="flow", description="x and y", equations="", internal_step=1e-3,
        variables=[input_("z", "1", "temperature", start=1.0), state("x", "1", "rate of turning", start=1.0, is_output=True),
                   state("y", "1", "temperature difference", start=1.0, is_output=True)],
        model=lambda s: ({"x": 10 * (s["y"] - s["x"]), "y": s["x"] * (28 - s["z"]) - s["y"]}, {}),
    )  # fmt: skip


def heat() -> Component:
    """What the fluid carries."""
    return build(
        name="lorenz", variant="heat", description="z", equations="", internal_step=1e-3,
        variables=[input_("x", "1", "rate of turning"), input_("y", "1", "temperature difference"),
                   state("z", "1", "temperature", start=1.0, is_output=True)],
        model=lambda s: ({"z": s["x"] * s["y"] - 8 / 3 * s["z"]}, {}),
    )  # fmt: skip


def lorenz() -> System:
    """Both, coupled."""
    return System(
        "lorenz",
        (SystemComponent("flow", f"{HERE}:flow"), SystemComponent("heat", f"{HERE}:heat")),
        (
            Connection(("flow", "x"), ("heat", "x")),
            Connection(("flow", "y"), ("heat", "y")),
            Connection(("heat", "z"), ("flow", "z")),
        ),
    )
