"""What a vehicle file says, as values: bodies, wheelsets, what is between them, mounts, drive. Read by `reading`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from gyro_cosim.component import Variable

from ..pairing import Conical
from ..track_files import Line, Record, Speeds
from .between import Link, RollBar, Springs
from .measured import Measured
from .sections import Vector
from .values import Value

__all__ = ["Body", "Course", "Description", "Drive", "Force", "Joint", "Mount", "Pivot", "Torque", "Wheelset"]

Joint = Springs | Link | RollBar


@dataclass(frozen=True)
class Pivot:
    """How a frame hangs in a body: it turns about that body's vertical axis through its own centre, and does nothing else.

    Attributes
    ----------
    host : str
        The body.
    damping, inertance : Value
        Of a yaw damper (N m s/rad) and a rotational inerter (kg m2) between the two.
    """

    host: str
    damping: Value
    inertance: Value


@dataclass(frozen=True)
class Body:
    """A rigid body: mass (kg), inertias about its centre (kg m2), where that is at rest (m), and its pivot if it has one."""

    name: str
    meaning: str
    mass: Value
    inertia: Vector
    centre: Vector
    pivot: Pivot | None = None


@dataclass(frozen=True)
class Wheelset:
    """A body with a pair of wheels; its centre is on the axle.

    Attributes
    ----------
    name, meaning : str
        What it is called.
    mass : Value
        Of everything that moves with it, kg.
    inertia : Vector
        Of the same about the axle's middle, kg m2; about y without the wheels' spin.
    x : Value
        Where it stands at rest, m.
    spin_inertia : Value
        Of one wheel about the axle, or of half a solid axle, kg m2.
    solid, pitches : bool
        Whether both wheels turn together; whether the frame or the axle boxes may pitch.
    load : Value
        What presses on the axle besides what the file holds, N.
    """

    name: str
    meaning: str
    mass: Value
    inertia: Vector
    x: Value
    spin_inertia: Value
    solid: bool
    pitches: bool
    load: Value


@dataclass(frozen=True)
class Mount:
    """Where a gyro unit rides: three moments come in, the body's three absolute rates go out.

    carries : by axis the parameter of the file that holds what of the unit's inertia turns with the body.
    """

    name: str
    body: str
    carries: Mapping[str, str]


@dataclass(frozen=True)
class Force:
    """A force on a body: where it acts at rest (m), and the start values of its inputs by axis (N)."""

    name: str
    meaning: str
    body: str
    at: Vector
    starts: Mapping[str, float]


@dataclass(frozen=True)
class Torque:
    """Torques on the wheels of a wheelset: what they are braced against ("": the wheel frame), their start value (N m)."""

    name: str
    meaning: str
    wheelset: str
    against: str
    start: float
    solid: bool

    @property
    def inputs(self) -> tuple[str, ...]:
        """One for a solid axle, else left and right."""
        return (f"{self.name}_torque",) if self.solid else (f"{self.name}_left_torque", f"{self.name}_right_torque")


@dataclass(frozen=True)
class Drive:
    """What holds the speed.

    Attributes
    ----------
    wheelsets : tuple of str
        Those that share the force.
    gain, on : Value
        Force per lack of speed (N s/m), and whether it is on.
    traction_limit, braking_limit : Value, optional
        The most that it pulls and brakes with (N).
    """

    wheelsets: tuple[str, ...]
    gain: Value
    on: Value
    traction_limit: Value | None = None
    braking_limit: Value | None = None


@dataclass(frozen=True)
class Course:
    """What of the track comes from files.

    Attributes
    ----------
    line : Line, optional
        Curvature, cant and gradient.
    record : Record, optional
        Irregularity.
    speeds : Speeds, optional
        What the drive holds in place of the set speed.
    """

    line: Line | None = None
    record: Record | None = None
    speeds: Speeds | None = None


@dataclass(frozen=True)
class Description:
    """A vehicle.

    Attributes
    ----------
    name, text : str
        Of the component: its variant, and one line on it.
    parameters : tuple of Variable
        Every row but those of the track.
    bodies, wheelsets, springs, links, roll_bars, mounts, forces, torques : dict by name
        The parts.
    drive : Drive
        What holds the speed.
    wheels : Conical or Measured
        Wheels and rails.
    law : str
        Creep law of the treads, a key of `vehicle.creep_laws.LAWS`.
    grid : int
        FASTSIM's strips and cells.
    knots, harmonics : int
        Room for the track's data.
    course : Course
        What of the track comes from files.
    internal_step : float
        Longest step (s).
    """

    name: str
    text: str
    parameters: tuple[Variable, ...]
    bodies: Mapping[str, Body]
    wheelsets: Mapping[str, Wheelset]
    springs: Mapping[str, Springs]
    links: Mapping[str, Link]
    roll_bars: Mapping[str, RollBar]
    mounts: Mapping[str, Mount]
    forces: Mapping[str, Force]
    torques: Mapping[str, Torque]
    drive: Drive
    wheels: Conical | Measured
    law: str
    grid: int
    knots: int
    harmonics: int
    course: Course
    internal_step: float

    def pivoted(self, host: str) -> tuple[Body, ...]:
        """The frames on pivots of a body."""
        return tuple(body for body in self.bodies.values() if body.pivot is not None and body.pivot.host == host)

    @property
    def free(self) -> tuple[Body, ...]:
        """The bodies with six degrees of freedom, the wheelsets left out."""
        return tuple(body for body in self.bodies.values() if body.pivot is None)

    @property
    def joints(self) -> tuple[Joint, ...]:
        """All that joins two bodies."""
        return (*self.springs.values(), *self.links.values(), *self.roll_bars.values())

    @property
    def lopsided(self) -> bool:
        """Whether a weight, or what carries one, is off the middle of the track."""
        carry = (springs.at.y for springs in self.springs.values() if springs.carries)
        return not all(y.is_zero for y in (*carry, *(body.centre.y for body in self.free)))

    def host(self, name: str) -> str:
        """The body that moves `name`: itself, or the one on whose pivot it turns."""
        body = self.bodies.get(name)
        return body.pivot.host if body is not None and body.pivot is not None else name

    def symbols(self) -> dict[str, ca.SX]:
        """A symbol for every parameter, by name."""
        return {row.name: ca.SX.sym(row.name) for row in self.parameters}

    def starts(self) -> dict[str, float]:
        """The parameters' start values."""
        return {row.name: row.start for row in self.parameters}

    def common_mass(self, s: Mapping[str, Any], name: str) -> tuple[Any, Any, Any, Any]:
        """(mass, x, y, height) of a body and the frames on its pivots, of their common centre at rest."""
        body, frames = self.bodies[name], self.pivoted(name)
        m = body.mass.of(s)
        x, y, z = body.centre.of(s)
        if not frames:
            return m, x, y, z
        of_frame, height = frames[0].mass.of(s), frames[0].centre.z.of(s)  # two, alike and opposite: `rules` sees to it
        total = m + 2 * of_frame
        return total, x, y, (m * z + 2 * of_frame * height) / total
