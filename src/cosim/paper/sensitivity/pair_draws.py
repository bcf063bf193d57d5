"""The wheel pair as the subject of a study over its open parameters: claims C1 to C4. See gyro_cosim.paper.pair_measures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ... import master
from ...master.side_by_side import SideBySide
from ...network import Network
from ...ssp import system as named_system
from ...sweeps.axes import Point
from ...systems import System
from ...trajectory import Trajectory
from .. import pair_measures
from ..measures import Margins
from ..pair_measures import ALGORITHM, NAMES, SPAN, STEP, TURNING, Observed, settling_time
from .draws import NAMED, sources_of
from .open_parameters import Open, every_open_parameter, values_of

WHEELS = "Table 1"  # there is one kind
FINENESS = 200  # of the root loci; the ledger's are twice as fine, to be drawn


@dataclass(frozen=True)
class PairSubject:
    """See gyro_cosim.paper.sensitivity.draws.Subject."""

    system: System
    parameters: tuple[Open, ...]
    named: Mapping[str, tuple[str, Mapping[str, float]]]
    wheels: Mapping[str, Mapping[str, float]]
    name: str = "wheel-pair"

    @property
    def sources(self) -> tuple[str, ...]:
        """Of the FMUs."""
        return tuple(part.source for part in self.system.components)

    @cached_property
    def measures(self) -> dict[str, str]:
        """Column -> unit."""
        return {column: "s" if "settled" in column else "1/s" for column in _measured(_nothing())}

    @cached_property
    def claims(self) -> dict[str, tuple[str, ...]]:
        """Claim -> its parts."""
        return {claim: tuple(margins) for claim, margins in pair_measures.margins(_nothing()).items()}

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> "PairBench":
        """See Subject; steps as short as the wheel pair's gain nothing from lanes."""
        del lanes
        return PairBench(self, files)

    def described(self) -> dict[str, Any]:
        """See Subject."""
        return {"code": sources_of(Path(__file__), Path(pair_measures.__file__)), "stop": SPAN}


def subject() -> PairSubject:
    """The wheel pair with the ranges of its tables; its defaults are a named point."""
    pair = named_system("wheel-pair")
    parameters = every_open_parameter(pair)
    values = values_of(pair)
    return PairSubject(pair, parameters, {"defaults": (WHEELS, {p.target: values[p.target] for p in parameters})}, {WHEELS: {}})


class PairBench:
    """The wheel pair's FMUs, open in this process; roots come from the components themselves."""

    def __init__(self, what: PairSubject, files: Mapping[str, str]) -> None:
        self._system, self._files = what.system, files
        self._network: Network | None = None

    def measure(self, point: Point, into: dict[str, float]) -> dict[str, Margins]:
        """See gyro_cosim.paper.sensitivity.draws.Bench."""
        plan = self._system
        for target, value in point.items():
            if target not in NAMED:
                plan = plan.with_value(target, value)
        seen = pair_measures.observe(plan, self._simulated, fineness=FINENESS)
        into.update(_measured(seen))
        return pair_measures.margins(seen)

    def close(self) -> None:
        """Close the FMUs."""
        if self._network is not None:
            self._network.close()

    def _simulated(self, plan: System) -> Trajectory:
        plan = replace(plan, components=tuple(replace(part, source=self._files[part.source]) for part in plan.components))
        if self._network is None:
            self._network = master.open_network(plan)
        network = Network(plan, self._network.slaves)
        return master.run(network, ALGORITHM, STEP, SPAN, options=master.Options(compiled=True)).trajectory


def _measured(seen: Observed) -> dict[str, float]:
    """Largest real parts (1/s) and settling times (s)."""
    values = {"over speed: largest real part": float(seen.over_speed.real.max()),
             "over spin: largest real part": float(seen.over_spin[1:].real.max())}  # fmt: skip
    settled = {f"{rpm} rpm: {NAMES[n]} settled": settling_time(tr, n) for rpm, tr in seen.turning.items() for n in NAMES}
    return values | settled


def _nothing() -> Observed:
    """A pair at rest: it tells the names of what is measured."""
    roots, t = np.ones((2, 6), dtype=complex), np.linspace(0.0, SPAN, 6)
    still = Trajectory(t, tuple(NAMES), ("1",) * len(NAMES), np.ones((t.size, len(NAMES))))
    return Observed(t, roots, t, roots, 0.0, still, dict.fromkeys(TURNING, still))
