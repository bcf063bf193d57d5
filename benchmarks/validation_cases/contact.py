"""Manchester contact benchmark, case A-2.2: where a loaded S1002 wheelset touches 60E1 rails at 1 : 40.

The wheelset is shifted to the right by 0 to 10 mm and yawed by 2.4 mrad a millimetre, 10 kN a wheel.
"""

from dataclasses import replace
from pathlib import Path

from gyro_cosim.vehicle import contact_points
from gyro_cosim.vehicle.profiles import Profile, rail_60e1, read, s1002

from .table import Line, Quantity, Table

__all__ = ["left_wheel", "right_wheel", "right_wheel_of_files"]

SOURCE = (
    "the open code [CONTACT](https://github.com/eve70a/CONTACT) (commit d431cdb, "
    "`examples/mbench_a22_left.ref_out` and `mbench_a22_right.ref_out`)"
)
PLACED = {"rolling_radius": 0.46, "gauge": 1.435, "inner_distance": 1.36}
INCLINATION = 1 / 40
YAW = 2.4  # mrad for each mm of shift
FILES = ("MBench_S1002_v3.prw", "MBench_UIC60_v3.prr")  # of CONTACT's folder `examples`; the rail's has its inclination

# shift (mm): |y| of the contact from the middle of the track (mm), contact angle (mrad); both as CONTACT prints them
LEFT = {
    0.0: (751.8726, 29.0), 0.5: (754.2092, 21.1), 1.0: (755.2440, 17.6), 2.0: (756.5056, 13.4), 3.0: (757.2358, 11.0),
    4.0: (757.6645, 9.6), 5.0: (757.8958, 8.8), 6.0: (758.0210, 8.4), 7.0: (758.6092, 6.4), 8.0: (758.2223, 7.7),
    9.0: (757.6922, 9.5), 10.0: (757.0975, 11.5),
}  # fmt: skip
RIGHT = {
    0.0: (751.8726, 29.0), 0.5: (744.5026, 56.8), 1.0: (741.9908, 69.6), 2.0: (740.9147, 80.6), 3.0: (739.9698, 92.3),
    4.0: (738.7381, 107.8), 5.0: (727.0855, 290.5), 6.0: (725.1371, 417.6), 7.0: (719.0445, 1063.4), 8.0: (719.8316, 950.1),
    9.0: (720.4903, 867.6), 10.0: (721.0880, 799.2),
}  # fmt: skip
PLACE, ANGLE = Quantity("place, mm", ".2f", 0.1), Quantity("angle, mrad", ".1f", 1.0)


def _line(shift: float, theirs: tuple[float, float], right: bool, wheel: Profile, rail: Profile, inclination: float) -> Line:
    found = contact_points(
        wheel, rail, **PLACED, inclination=inclination, lateral=-1e-3 * shift, yaw=-1e-3 * YAW * shift, axle_load=2e4
    )
    # of two contacts the one nearer to theirs
    contact = min(found.right if right else found.left, key=lambda c: abs(abs(1e3 * c.track_lateral) - theirs[0]))
    pairs = ((abs(1e3 * contact.track_lateral), theirs[0]), (1e3 * contact.contact_angle, theirs[1]))
    return Line(f"{shift:g} mm, {YAW * shift:g} mrad", pairs)


def left_wheel() -> Table:
    """The wheel on the tread, by the standards' formulas."""
    wheel, rail = s1002(), rail_60e1()
    lines = tuple(_line(shift, theirs, False, wheel, rail, INCLINATION) for shift, theirs in LEFT.items())
    return Table(SOURCE, (PLACE, ANGLE), lines)


def right_wheel() -> Table:
    """The wheel that climbs, by the standards' formulas; the benchmark's rail departs from them by up to 0.05 mm."""
    wheel, rail = s1002(), rail_60e1()
    lines = tuple(_line(shift, theirs, True, wheel, rail, INCLINATION) for shift, theirs in RIGHT.items())
    return Table(SOURCE, (Quantity(PLACE.name, PLACE.form, 0.6), Quantity(ANGLE.name, ANGLE.form, 9.0)), lines)


def right_wheel_of_files(folder: Path) -> Table:
    """The same with the benchmark's own profiles."""
    wheel, rail = (read(folder / name, smoothing=0.0) for name in FILES)
    lines = [_line(shift, theirs, True, wheel, rail, 0.0) for shift, theirs in RIGHT.items()]
    lines = [replace(line, within=(0.6, 9.0)) if line.what.startswith("5 mm") else line for line in lines]  # two patches or one
    return Table(
        f"{SOURCE}; profiles {FILES[0]} and {FILES[1]} of the same folder",
        (PLACE, Quantity(ANGLE.name, ANGLE.form, 1.3)),
        tuple(lines),
    )
