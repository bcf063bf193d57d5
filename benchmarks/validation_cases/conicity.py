"""Equivalent conicity: cases with a closed form, and the reference profiles of EN 15302."""

from math import pi, sqrt
from pathlib import Path

import numpy as np

from gyro_cosim.vehicle.profiles import Profile, equivalent_conicity, read

from .table import Line, Quantity, Table

__all__ = ["closed_forms", "en_15302"]

RADIUS, BASE = 0.46, 1.5  # m
EDGE = Profile(np.array([-0.001, 0.0, 0.001]), np.array([-0.01, 0.0, -0.01]))  # a rail that touches at one place only


def closed_forms() -> Table:
    """A cone; a tread that is flat within 1 mm of the middle; dr = 2 (g y + k y^3)."""
    y = np.linspace(-0.02, 0.02, 16001)
    cone, flat, cubic = 0.1, 1e-3, 2000.0
    straight = Profile(y, cone * y)
    gap = Profile(y, cone * np.sign(y) * np.maximum(np.abs(y) - flat, 0.0))
    hollow = Profile(y, cone * y + cubic * y**3)
    lines = [Line("cone of 0.1", ((equivalent_conicity(straight, EDGE, RADIUS, BASE), cone),))]
    for amplitude in (2e-3, 3e-3, 6e-3):
        k = sqrt(2 * cone / (BASE * RADIUS))
        wavelength = 2 * pi / k + 4 * flat / (k * (amplitude - flat))
        theirs = (pi / wavelength) ** 2 * 2 * BASE * RADIUS
        lines.append(
            Line(
                f"no difference within 1 mm, {1e3 * amplitude:g} mm",
                ((equivalent_conicity(gap, EDGE, RADIUS, BASE, amplitude), theirs),),
            )
        )
        # y'' = -a y - c y^3 has the period 4 K(m) / sqrt(a + c A^2), m = c A^2 / (2 (a + c A^2))
        from scipy.special import ellipk

        a, c = 2 * cone / (BASE * RADIUS), 2 * cubic / (BASE * RADIUS)
        stiff = a + c * amplitude**2
        wavelength = 4 * ellipk(c * amplitude**2 / (2 * stiff)) / sqrt(stiff)
        theirs = (pi / wavelength) ** 2 * 2 * BASE * RADIUS
        lines.append(
            Line(
                f"cubic difference, {1e3 * amplitude:g} mm",
                ((equivalent_conicity(hollow, EDGE, RADIUS, BASE, amplitude), theirs),),
            )
        )
    source = (
        "the wavelength of y'' = -dr / (e r0) in closed form: a cone, straight runs between half waves, Jacobi's elliptic "
        "functions"
    )
    return Table(source, (Quantity("", ".5f", 1e-3, relative=True),), tuple(lines))


AMPLITUDES = (2, 3, 4, 5, 6)  # mm
# case: left wheel, right wheel where it is unlike ("-": smaller by 2 mm in diameter), reference results over the amplitudes
CASES = {
    "E1": ("A", "", (0.155, 0.188, 0.216, 0.254, 0.303)), "E2": ("B", "", (0.025, 0.058, 0.241, 0.283, 0.302)),
    "E3": ("H", "", (0.025, 0.245, 0.319, 0.306, 0.284)), "E4": ("I", "", (0.293, 0.489, 0.485, 0.475, 0.447)),
    "E5": ("A", "A-", (0.272, 0.261, 0.269, 0.307, 0.395)), "E6": ("B", "B-", (0.376, 0.278, 0.227, 0.295, 0.409)),
    "E7": ("H", "H-", (0.381, 0.270, 0.217, 0.275, 0.421)), "E8": ("I", "I-", (0.418, 0.449, 0.479, 0.458, 0.497)),
    "E9": ("A", "B", (0.104, 0.132, 0.225, 0.271, 0.307)),
}  # fmt: skip


def en_15302(folder: Path) -> Table:
    """Wheels A, B, H, I on rail A, combinations E1 to E9; allowed is what the standard allows, 0.05 or half the value.

    y = 0 of the rail's points stands under the tape line.
    """
    wheels = {name: read(folder / f"RUIC519{name}.dat", kind="wheel", unit="mm", smoothing=0.0) for name in "ABHI"}
    rail = read(folder / "SUIC519A.dat", kind="rail", unit="mm", smoothing=0.0)
    lines = []
    for case, (left, other, theirs) in CASES.items():
        right = wheels[other[0]] if other else None
        if right is not None and other.endswith("-"):
            right = Profile(right.y, right.z + 1e-3)
        ours = [equivalent_conicity(wheels[left], rail, RADIUS, BASE, 1e-3 * A, right_wheel=right) for A in AMPLITUDES]
        pairs = tuple(zip(ours, theirs, strict=True))
        what = f"{case}: {left}, {other[0] if other else left}{', 1 mm smaller' if other.endswith('-') else ''}"
        lines.append(Line(what, pairs, tuple(min(0.05, value / 2) for value in theirs)))
    quantities = tuple(Quantity(f"{A} mm", ".3f", 0.05) for A in AMPLITUDES)
    source = (
        "EN 15302, reference results; points and results as published at "
        "[criogenox/A_WRCC](https://github.com/criogenox/A_WRCC-Wheel-Rail-Contact-Characterization) (commit c668f80, "
        "folder `data`) and "
        "[B_ECC](https://github.com/criogenox/B_ECC-Equivalent-Conicity-Calculation) (commit 6e33d43)"
    )
    return Table(source, quantities, tuple(lines), compact=True)
