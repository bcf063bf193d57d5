"""What a run does with its slaves, from its algorithm, its steps and its options: what they are told before it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..coupling import Algorithm
from ..coupling.base import can_restore
from ..coupling.iterated import Repeated
from ..network import Network
from ..slaves.usage import Usage, promise
from .time_grid import TimeGrid

if TYPE_CHECKING:
    from .stepping import Options


def told(network: Network, algorithm: Algorithm, grid: TimeGrid, options: Options) -> tuple[str, ...]:
    """Tell every slave how the run will use it, before it begins; what they cannot do and how the run does without, a line each.

    ValueError where the run cannot do without.
    """
    usage = usage_of(network, algorithm, grid, options)
    lines: dict[str, None] = {}
    for slave, values, parts in zip(network.slaves, network.values, network.substeps, strict=True):
        lines |= dict.fromkeys(promise(slave, replace(usage, step=usage.step / parts), values, grid.start, grid.stop))
    return tuple(lines)


def usage_of(network: Network, algorithm: Algorithm, grid: TimeGrid, options: Options) -> Usage:
    """How a run uses its slaves. Where it writes checkpoints its stop time is not final: it may go on from them."""
    uneven = ""
    if options.adaptive is not None:
        uneven = "an adaptive macro step has none"
    elif grid.last != grid.step:
        uneven = f"a run over {grid.stop - grid.start:g} s ends with a shorter one than {grid.step:g} s"
    goes_back, can_do_without = "", False
    if options.adaptive is not None:
        goes_back = "an adaptive macro step"
    elif isinstance(algorithm, Repeated):
        goes_back = f"algorithm {algorithm.name!r}"
    elif options.checkpoint is not None:
        goes_back = "a checkpoint"
    elif algorithm.degree > 0 and can_restore(network):
        goes_back, can_do_without = "the first step", True
    return Usage(
        degree=algorithm.degree,
        uneven=uneven,
        goes_back=goes_back,
        can_do_without=can_do_without,
        tolerance=network.system.tolerance,
        step=0.0 if options.adaptive is not None else grid.step,
        ends=options.checkpoint is None,
    )
