"""Small components with known answers, for tests of the master: half a two-mass oscillator each, a nonlinear pair.

    left:   m1 x1'' = -k1 x1 - d1 x1' + F                 in F, out x1, x1'
    right:  m2 x2'' = -k2 x2 - d2 x2' - F,  F = kc (x2 - x1) + dc (x2' - x1')      in x1, x1', out F

F depends directly on the right component's inputs, so this pair also exercises direct feedthrough.
"""

import casadi as ca

from gyro_cosim import Connection, PowerBond, System, SystemComponent
from gyro_cosim.component import Component, build, input_, output, parameter, state

HERE = __file__


def left() -> Component:
    """The mass on the left, with a spring and a damper to the wall; `cubic` makes the spring harden."""
    return build(
        name="oscillator", variant="left", description="left mass", equations="", internal_step=1e-3,
        variables=[
            input_("force", "N", "force of the coupling spring"),
            state("position", "m", "position", start=1.0, is_output=True),
            state("velocity", "m/s", "velocity", is_output=True),
            parameter("stiffness", 40.0, "N/m", "wall spring", source="test"),
            parameter("cubic", 0.0, "N/m3", "hardening", source="test"),
        ],
        model=lambda s: (
            {
                "position": s["velocity"],
                "velocity": -s["stiffness"] * s["position"] - s["cubic"] * s["position"] ** 3 - 0.4 * s["velocity"] + s["force"],
            },
            {},
        ),
    )  # fmt: skip


def right() -> Component:
    """The mass on the right with the coupling spring."""

    def model(s: dict[str, ca.SX]) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
        force = 30.0 * (s["x2"] - s["position"]) + 0.6 * (s["v2"] - s["velocity"])
        return {"x2": s["v2"], "v2": (-60.0 * s["x2"] - 0.5 * s["v2"] - force) / 1.5}, {"force": force}

    return build(
        name="oscillator", variant="right", description="right mass", equations="", internal_step=1e-3,
        variables=[
            input_("position", "m", "position of the left mass"),
            input_("velocity", "m/s", "velocity of the left mass"),
            state("x2", "m", "position"),
            state("v2", "m/s", "velocity"),
            output("force", "N", "force on the left mass"),
        ],
        model=model,
    )  # fmt: skip


def pair(*, cubic: float = 0.0) -> System:
    """The coupled oscillator; with `cubic` a nonlinear one."""
    return System(
        "two-mass",
        (SystemComponent("left", f"{HERE}:left", {"cubic": cubic}), SystemComponent("right", f"{HERE}:right")),
        (
            Connection(("left", "position"), ("right", "position")),
            Connection(("left", "velocity"), ("right", "velocity")),
            Connection(("right", "force"), ("left", "force")),
        ),
        bonds=(PowerBond(("left", "velocity"), ("right", "force")),),
    )


def fails(at: float = 0.55, unit: str = "s", variant: str = "fails") -> Component:
    """A clock whose output, called one in `unit`, is NaN from t = `at` (s) on."""
    return build(
        name="oscillator", variant=variant, description="a clock that breaks", equations="", internal_step=1e-3,
        variables=[state("clock", "s", "time"), output("reading", unit, "what it shows"),
                   parameter("breaks_at", at, "s", "when it breaks", source="test")],
        model=lambda s: ({"clock": 1}, {"reading": s["clock"] + 1e-12 * ca.sqrt(s["breaks_at"] - s["clock"])}),
    )  # fmt: skip


def failing_force() -> Component:
    """As `fails`, for the left mass."""
    return fails(unit="N", variant="failing_force")


def failing_position() -> Component:
    """As `fails`, for the right mass."""
    return fails(unit="m", variant="failing_position")


def crossed(direct: float = 1.0) -> Component:
    """Passes its input straight on; two of them in a ring are an algebraic loop."""
    return build(
        name="oscillator", variant="crossed", description="a gain", equations="", internal_step=1e-3,
        variables=[input_("u", "1", "in"), output("y", "1", "out"), parameter("gain", direct, "1", "gain", source="test"),
                   parameter("bias", 0.0, "1", "what is added", source="test")],
        model=lambda s: ({}, {"y": s["gain"] * s["u"] + s["bias"]}),
    )  # fmt: skip


def inverse() -> Component:
    """1 / u + v."""
    return build(
        name="oscillator", variant="inverse", description="one over u", equations="", internal_step=1e-3,
        variables=[input_("u", "s", "in", start=1.0), input_("v", "Hz", "what is added"), output("y", "Hz", "out")],
        model=lambda s: ({}, {"y": 1 / s["u"] + s["v"]}),
    )  # fmt: skip


def counter() -> Component:
    """Counts every 10 ms in its sampled part, and integrates the count."""
    return build(
        name="oscillator", variant="counter", description="counts", equations="", internal_step=1e-3, sample_period=0.01,
        variables=[state("count", "1", "how often", discrete=True, is_output=True),
                   state("total", "s", "its integral", is_output=True)],
        model=lambda s: ({"total": s["count"]}, {}), sample=lambda s: {"count": s["count"] + 1},
    )  # fmt: skip


def spring() -> Component:
    """A spring and a damper that integrate the velocity they are given."""
    return build(
        name="oscillator", variant="spring", description="spring", equations="", internal_step=1e-3,
        variables=[input_("velocity", "m/s", "of the mass"), state("x", "m", "length", start=1.0, is_output=True),
                   output("force", "N", "on the mass")],
        model=lambda s: ({"x": s["velocity"]}, {"force": -s["x"] - 0.02 * s["velocity"]}),
    )  # fmt: skip


def mass() -> Component:
    """A mass of 1 kg, which integrates its velocity as well."""
    return build(
        name="oscillator", variant="mass", description="mass", equations="", internal_step=1e-3,
        variables=[input_("force", "N", "of the spring"), state("x", "m", "position", start=1.0, is_output=True),
                   state("velocity", "m/s", "velocity", is_output=True)],
        model=lambda s: ({"x": s["velocity"], "velocity": s["force"]}, {}),
    )  # fmt: skip


def held_twice() -> System:
    """Both sides integrate the velocity that they exchange: Kyllingstad, arXiv:2512.13845, with light damping."""
    return System(
        "held-twice",
        (SystemComponent("spring", f"{HERE}:spring"), SystemComponent("mass", f"{HERE}:mass")),
        (Connection(("mass", "velocity"), ("spring", "velocity")), Connection(("spring", "force"), ("mass", "force"))),
        bonds=(PowerBond(("mass", "velocity"), ("spring", "force")),),
    )
