"""What a railway engineer asks of a run: safety against derailment, ride comfort, their filters and figures.

Only the command line, the paper and the studies use this: the master is general.
"""
