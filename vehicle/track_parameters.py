"""Parameters that carry the track: a standard curve, free knots of the alignment, a sinusoidal stretch, harmonics.

They start as straight, level, even track. The standard curve (figs. 7 to 10) and the stretch (fig. 6) are set by hand;
vehicle.track and vehicle.spectra compute the others from segments, tables and spectra.
"""

from gyro_cosim.component import Variable, parameter

from .alignment import COLUMNS
from .irregularity import CHANNELS, PARTS

__all__ = ["CURVE", "parameters_of_track"]

SOURCE = "track data"
OPEN = "not in the paper"

CURVE = (
    parameter("curve_turn", 0.0, "1", "standard curve: 1 turns left, -1 right, 0 leaves the track straight", source=SOURCE,
              min=-1.0, max=1.0),
    parameter("curve_radius", 50.0, "m", "radius of the standard curve; 10 m keeps the bogie frames within 20 deg", symbol="R",
              source="sec. 3.3", min=10.0),
    parameter("curve_start", 20.0, "m", "where the entry transition begins", source=OPEN),
    parameter("transition_length", 10.0, "m", "length of either transition", source=OPEN, assumed=(5.0, 40.0), min=1.0),
    parameter("curve_length", 60.0, "m", "length of the steady curve", source=OPEN, assumed=(20.0, 100.0), min=0.0),
    parameter("curve_cant", 0.0, "m", "cant of the steady curve, of the outer over the inner rail", source=OPEN,
              assumed=(0.0, 0.15), min=-0.2, max=0.2, display_unit="mm"),
)  # fmt: skip
KNOT = {
    "position": ("m", "where the slopes change"),
    "curvature_slope": ("1/m2", "change of the curvature's slope there; a left curve is positive"),
    "cant_slope": ("rad/m", "change of the cant angle's slope there; positive lifts the left rail"),
    "gradient_slope": ("rad/m", "change of the gradient's slope there; positive climbs"),
}


def parameters_of_track(capacity: int, harmonics: int) -> tuple[Variable, ...]:
    """The standard curve, `capacity` free knots, the stretch, and `harmonics` harmonics in each of four channels."""
    knots = CURVE + tuple(
        parameter(f"track_{column}[{i}]", 0.0, KNOT[column][0], f"knot {i}: {KNOT[column][1]}", source=SOURCE)
        for column in COLUMNS
        for i in range(capacity)
    )
    stretch = (
        parameter("stretch_start", 0.0, "m", "where the sinusoidal stretch begins", source=SOURCE),
        parameter("stretch_wavelength", 50.0, "m", "wavelength of the stretch", source="fig. 6", min=0.1),
        parameter("stretch_cycles", 5.0, "1", "wavelengths in the stretch", source="five make a finite stretch", min=0.0),
        *(
            parameter(f"stretch_{c}", 0.0, "m", f"amplitude of the stretch, {c.replace('_', ' ')}", source=SOURCE,
                      display_unit="mm")
            for c in CHANNELS
        ),
    )  # fmt: skip
    if not harmonics:
        return knots + stretch
    return (
        *knots, *stretch,
        parameter("harmonics_length", 100.0, "m", "period of the harmonics", source=SOURCE, min=1.0),
        parameter("harmonics_start", 10.0, "m", "where the harmonics fade in", source=SOURCE),
        parameter("harmonics_fade", 10.0, "m", "length over which they fade in", source=SOURCE, min=0.1),
        *(
            parameter(f"{c}_{part}[{n}]", 0.0, "m", f"{part} amplitude of wave {n + 1} per period, {c.replace('_', ' ')}",
                      source=SOURCE, display_unit="mm")
            for c in CHANNELS for part in PARTS for n in range(harmonics)
        ),
    )  # fmt: skip
