"""What wires slaves: whose output feeds which input, in which unit, in which order, and what depends on itself.

network         the slaves of a system, opened and wired
wiring          connections, arrays, connectors, start values
joining         types, units, transformations: whether an output fits an input
inputs          the inputs of a slave from all outputs
texts           strings and binaries
projection      inputs of too high a degree
driving         what open inputs follow: time series
scripted        what a scenario changes: parameters, open inputs, connections
bonds           pairs of connections whose product is a power
evaluation      how outputs are made consistent at a communication point
loops           algebraic loops: where they are, and their solution
linearised      slaves replaced by their exact linearisation
"""

from .network import Network
from .projection import projected

__all__ = ["Network", "projected"]
