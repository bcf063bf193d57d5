"""The signals of a vehicle from a file: names are PART_SIGNAL, as `vehicle:lrt` has them.

Every state is zero at rest at the set speed on straight level track, so that the vehicle starts without a transient.
"""

from gyro_cosim.component import Bond, Variable, input_, output, state

from ..lrt_signals import body_rows
from ..wheel_report import REPORT
from .between import RollBar
from .description import Description, Force, Torque, Wheelset
from .moving import spins

__all__ = ["bonds", "signals"]

AXES = ("yaw", "roll", "pitch")


def signals(d: Description) -> tuple[Variable, ...]:
    """All signals of a vehicle."""
    rows: list[Variable] = []
    for mount in d.mounts.values():
        rows += [input_(f"{mount.name}_{axis}_moment", "N.m", f"{axis} moment of the gyro unit on {mount.body}", nominal=100.0)
                 for axis in AXES]  # fmt: skip
    for force in d.forces.values():
        rows += _applied(force)
    for torque in d.torques.values():
        rows += _applied(torque)
    for body in d.bodies.values():
        if body.pivot is None:
            rows += body_rows(body.name, body.meaning, is_output=True)
        else:
            rows += [
                state(f"{body.name}_angle", "rad", f"{body.meaning}: yaw against {body.pivot.host}", symbol="theta_b",
                      nominal=0.01, is_output=True, source="rest"),
                state(f"{body.name}_rate", "rad/s", f"{body.meaning}: absolute rate about the pivot", nominal=0.1, source="rest"),
            ]  # fmt: skip
    for one in d.wheelsets.values():
        rows += _wheelset(one)
    for joint in d.joints:
        if not isinstance(joint, RollBar):
            rows += [state(name, "m", f"{joint.name}: stretch of what holds a damper", symbol="q", nominal=1e-3, source="rest")
                     for name in joint.series_states]  # fmt: skip
    for one in d.wheelsets.values():
        for side in ("left", "right"):
            wheel = f"{one.name}_{side}"
            rows += [output(f"{wheel}_{name}", unit, f"{wheel.replace('_', ' ')} wheel: {meaning}", symbol=symbol,
                            nominal=nominal) for name, unit, meaning, symbol, nominal in REPORT]  # fmt: skip
    rows += [
        output("curvature", "1/m", "curvature of the track under the car body", symbol="kappa", nominal=0.01),
        output(
            "cant_angle",
            "rad",
            "cant of the track under the car body, positive with the left rail high",
            symbol="alpha",
            nominal=0.1,
        ),
        output("drive_power", "W", "power of the drive", nominal=1e3),
        output("dissipated_power", "W", "heat of dampers and creep", nominal=1e3),
        output("derailed", "1", "1 when a flange has passed the top of the rail, else 0"),
    ]
    return (*rows, *_mounts(d, {row.name for row in rows}))


def _applied(one: Force | Torque) -> list[Variable]:
    """What comes in from outside."""
    if isinstance(one, Force):
        ways = {"x": "forward", "y": "to the left", "z": "upwards"}
        return [input_(f"{one.name}_force_{axis}", "N", f"{one.meaning}: force on {one.body} {ways[axis]}", start=start,
                       nominal=1e4) for axis, start in one.starts.items()]  # fmt: skip
    return [input_(name, "N.m", f"{one.meaning}: {name.removesuffix('_torque').replace('_', ' ')}, drives forward if positive",
                   start=one.start, nominal=1e3) for name in one.inputs]  # fmt: skip


def _wheelset(one: Wheelset) -> list[Variable]:
    rows = list(body_rows(one.name, one.meaning, is_output=True))
    if not one.pitches:
        rows = [row for row in rows if not row.name.endswith(("pitch_angle", "pitch_rate"))]
    for side in spins(one):
        rows.append(state(f"{one.name}_{side}_spin_deviation", "rad/s", f"{one.name} {side}: absolute spin less that of pure "
                          "rolling", symbol="W", nominal=1.0, source="rest"))  # fmt: skip
    rows += [
        output(f"{one.name}_{side}_spin", "rad/s", f"{one.name} {side} wheel: absolute spin about the axle", symbol="W",
               nominal=10.0)
        for side in ("left", "right")
    ]  # fmt: skip
    rows.append(output(f"{one.name}_guiding_force", "N", f"{one.meaning}: lateral force of the rails on it, to the left",
                       symbol="sum Y", nominal=1e4))  # fmt: skip
    return rows


def _mounts(d: Description, there: set[str]) -> list[Variable]:
    """What a unit feels, by the mount's name: an output where no state is called so."""
    names = {"yaw": "psi'", "roll": "phi'", "pitch": "theta'"}
    missing = [(mount, axis) for mount in d.mounts for axis in AXES if f"{mount}_{axis}_rate" not in there]
    return [
        output(
            f"{mount}_{axis}_rate",
            "rad/s",
            f"{mount}: absolute {axis} rate of {d.mounts[mount].body}",
            symbol=names[axis],
            nominal=0.1,
        )
        for mount, axis in missing
    ]


def bonds(d: Description) -> tuple[Bond, ...]:
    """The power bonds of the mounts."""
    about = {"yaw": "z", "roll": "x", "pitch": "y"}
    return tuple(
        Bond(mount.name, axis, f"{mount.name}_{axis}_rate", f"{mount.name}_{axis}_moment", mount.carries.get(about[axis], ""))
        for mount in d.mounts.values() for axis in AXES
    )  # fmt: skip
