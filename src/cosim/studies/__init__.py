"""Studies of a system as a whole, from the monolith: roots over parameters, cost of a release, exact gradients."""

from gyro_cosim.studies.optimum import Optimum, optimum
from gyro_cosim.studies.paths import best, decay_rates, roots, travel
from gyro_cosim.studies.release import Release
from gyro_cosim.studies.rest import AtRest
from gyro_cosim.studies.signals import measured_root

__all__ = ["AtRest", "Optimum", "Release", "best", "decay_rates", "measured_root", "optimum", "roots", "travel"]
