"""The master: it runs a system over macro steps, records it, and says what the coupling cost.

simulation      a run from beginning to end, and what it was
stepping        macro step after macro step
adaptive        macro steps that adapt
progress        how far long work has come
energy          what the coupling adds on each power bond
recording       which results are kept, and where
checkpoint      a run that is killed goes on
"""

from .progress import Progress, stage
from .simulation import Options, Run, Status, Timing, macro_steps, open_network, run, simulate

__all__ = ["Options", "Progress", "Run", "Status", "Timing", "macro_steps", "open_network", "run", "simulate", "stage"]
