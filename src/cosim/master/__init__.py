"""The master: it runs a system over macro steps, records it, and says what the coupling cost.

simulation      a run from beginning to end
results         what it was, and how it shows itself
stepping        macro step after macro step
ways            one step by the algorithm, many by the inner loop, steps that adapt
state           what changes on the way, as one value
time_grid       the communication points
adaptive        macro steps that adapt
progress        how far long work has come
energy          what the coupling adds on each power bond
recording       which results are kept, and where
checkpoint      a run that is killed goes on
"""

from .progress import Progress, stage
from .simulation import Options, Run, Status, Timing, macro_steps, open_network, run, simulate

__all__ = ["Options", "Progress", "Run", "Status", "Timing", "macro_steps", "open_network", "run", "simulate", "stage"]
