"""What a vehicle from a file looks like as it moves: car bodies, frames, wheels and mounts where the file puts them."""

from collections.abc import Sequence
from typing import Any

from .. import scene
from .between import Link, RollBar, Springs
from .description import Body, Description
from .wheels import sections_of

__all__ = ["scene_of"]

# m: breadth, floor and roof over the rails, how far the body reaches beyond the wheelsets
CAR = {"size_y": 2.3, "floor": 0.45, "roof": 3.2, "beyond": 2.5}
BOGIE = [2.0, 1.6, 0.2]  # m
STUB = 0.12  # m


def scene_of(d: Description, names: Sequence[str]) -> dict[str, Any]:
    """The document for the values of the file.

    Parameters
    ----------
    d : Description
        The vehicle.
    names : sequence of str
        Its signals.
    """
    s = d.starts()
    carried = {springs.lower for springs in d.springs.values() if springs.carries}
    ends = [float(one.x.of(s)) for one in d.wheelsets.values()]
    first = next(iter(d.bodies), None)
    bodies = [
        _body(d, body, names, car=body.name not in carried, span=(min(ends), max(ends)))
        for body in d.bodies.values()
        if body.pivot is None
    ]
    forces = []
    for one in d.wheelsets.values():
        prefix = f"{one.name}_"
        bodies.append(
            scene.frame(
                one.name,
                prefix,
                float(one.x.of(s)),
                names,
                s,
                along=f"{prefix}distance",
                solid=one.solid,
                outside=d.wheels.flange_side > 0,
            )
        )
        forces += scene.wheel_forces(one.name, prefix, names, s)
    mounts = [
        {
            "name": mount.name, "body": d.host(mount.body), "at": [0.0, 0.0, 0.05], "size": 1.15,
            "signals": [f"{mount.name}_{axis}_rate" for axis in ("yaw", "roll", "pitch")],
        }
        for mount in d.mounts.values()
    ]  # fmt: skip
    leading = max(d.wheelsets.values(), key=lambda one: float(one.x.of(s)))
    wanted = [f"{leading.name}_{name}" for name in ("lateral_displacement", "yaw_angle", "guiding_force")]
    return scene.of_vehicle(
        bodies, forces, mounts,
        {"distance": f"{first or leading.name}_distance", "curvature": "curvature", "half_gauge": s["contact_half_distance"]},
        prefer=[name for name in wanted if name in names],
        profiles=sections_of(d),
        joints=[_joint(d, joint) for joint in d.joints if not isinstance(joint, RollBar)],
    )  # fmt: skip


def _joint(d: Description, joint: Springs | Link) -> dict[str, Any]:
    """Where springs and links are: each as a line, springs as short ones along z."""
    s = d.starts()
    if isinstance(joint, Link):
        ends = [[float(value) for value in end.of(s)] for end in (joint.upper_end, joint.lower_end)]
        lines = [ends, [[x, -y, z] for x, y, z in ends]] if joint.mirrored else [ends]
        return {"name": joint.name, "kind": "link", "lines": lines}
    x, y, z = (float(value) for value in joint.at.of(s))
    half_x, half_y = float(joint.half_x.of(s)), float(joint.half_y.of(s))
    places = [(x + a * half_x, y + b * half_y) for a in ((1, -1) if half_x else (0,)) for b in ((1, -1) if half_y else (0,))]
    return {"name": joint.name, "kind": "springs", "lines": [[[u, v, z - STUB], [u, v, z + STUB]] for u, v in places]}


def _body(d: Description, body: Body, names: Sequence[str], *, car: bool, span: tuple[float, float]) -> dict[str, Any]:
    s = d.starts()
    x, _, height = (float(value) for value in body.centre.of(s))
    if car:
        length = span[1] - span[0] + 2 * CAR["beyond"]
        size = [length, CAR["size_y"], CAR["roof"] - CAR["floor"]]
        shape = {"role": "car", "size": size, "at": [(span[0] + span[1]) / 2 - x, 0.0, (CAR["roof"] + CAR["floor"]) / 2 - height]}
    else:
        shape = {"role": "frame", "size": BOGIE, "at": [0.0, 0.0, 0.0]}
    prefix = f"{body.name}_"
    return {
        "name": body.name, "along": f"{prefix}distance", "offset": x, "height": height, **scene.moved(prefix, names),
        "shapes": [shape],
    }  # fmt: skip
