"""The master: it runs a system over macro steps, records it, and says what the coupling cost.

simulation      a run from beginning to end, and what it was
stepping        macro step after macro step
adaptive        macro steps that adapt
energy          what the coupling adds on each power bond
recording       which results are kept, and where
checkpoint      a run that is killed goes on
"""

from .simulation import Options, Run, Status, Timing, macro_steps, open_network, run, simulate

__all__ = ["Options", "Run", "Status", "Timing", "macro_steps", "open_network", "run", "simulate"]
