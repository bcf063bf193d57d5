"""Stability of a system as a whole, from the monolith: roots over parameters, cost of a release, exact gradients."""

from .at_rest import AtRest
from .constrained import Design, Limit, constrained_optimum, pareto_front
from .optimisation import Optimum, optimum
from .release import Release
from .root_paths import best, decay_rates, measured_root, roots, travel

__all__ = [
    "AtRest", "Design", "Limit", "Optimum", "Release", "best", "constrained_optimum", "decay_rates", "measured_root", "optimum",
    "pareto_front", "roots", "travel",
]  # fmt: skip
