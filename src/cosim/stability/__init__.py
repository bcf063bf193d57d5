"""Stability of a system as a whole, from the monolith: roots over parameters, cost of a release, exact gradients."""

from gyro_cosim.stability.at_rest import AtRest
from gyro_cosim.stability.optimisation import Optimum, optimum
from gyro_cosim.stability.release import Release
from gyro_cosim.stability.root_paths import best, decay_rates, measured_root, roots, travel

__all__ = ["AtRest", "Optimum", "Release", "best", "decay_rates", "measured_root", "optimum", "roots", "travel"]
