"""Which internal step does the vehicle need? Errors of the classical Runge-Kutta method against an 8 times finer one.

Vehicle and two gyro units joined, from rest through the entry of a 50 m curve into flange contact, parameter sets A and B.
Each line: the largest difference of the front pair's lateral displacement to the reference, in micrometres, with the steps as
given and with steps cut where the vehicle requires it. Takes some minutes.
Run: PYTHONPATH=tests/support python benchmarks/vehicle_step.py
"""

import numpy as np
from joined import Joined

from gyro_cosim.gyro_unit.nonlinear import nonlinear_full
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.parameter_sets import parameter_set

STEPS = (1e-3, 0.5e-3, 0.25e-3)
REFERENCE = 0.5e-3 / 8
DISTANCE, GRID = 24.0, 0.02  # m, s

vehicle, gyro = lrt_set_a(), nonlinear_full()
plain = Joined(vehicle, {"front": gyro, "rear": gyro}, cut=False)
cut = Joined(vehicle, {"front": gyro, "rear": gyro})
print("internal step, ms        " + "".join(f"{1e3 * h:>14g}" for h in STEPS) + "   longest stable")
for name in ("A", "B"):
    chosen = parameter_set(name)
    for speed in (3.0, 5.0, 8.0):
        values = chosen.vehicle | {f"unit.{n}": v for n, v in chosen.gyro.items()}
        values |= {"speed": speed, "curve_turn": 1.0, "curve_start": 2.0, "transition_length": 5.0}
        p = plain.p(values)
        stop = DISTANCE / speed
        reference = plain.run(stop, p, h=REFERENCE, every=round(GRID / REFERENCE))
        y, flange = (
            reference["front_lateral_displacement"],
            max(reference[f"front_{side}_flange_force"].max() for side in ("left", "right")),
        )
        longest = float(vehicle.longest_step(vehicle.start_state, vehicle.start_input, p[: len(vehicle.parameters)]))
        for label, system in (("as given", plain), ("cut", cut)):
            errors = [
                np.abs(system.run(stop, p, h=h, every=round(GRID / h))["front_lateral_displacement"] - y).max() for h in STEPS
            ]
            line = f"set {name}, {speed:g} m/s, {label:<9}" + "".join(f"{1e6 * e:>11.2e} um" for e in errors)
            print(f"{line}   {1e3 * longest / 0.86:.2f} ms, flange {flange / 1e3:.1f} kN")
