"""The full vehicle as the subject of a study over its open parameters: claims C6 to C10.

Each draw runs the ledger's cases from its first start: off and on, 50 m/s straight, 5 and 8 m/s in the curve. One start is
enough here: what chaos decides is spread over the draws. Each is run with both kinds of wheels, Table 2's and those almost
without spin inertia, so that the two differ in nothing else. What is measured and judged is gyro_cosim.paper.measures.

Runs are as long as in the ledger, but for two savings: at 5 m/s 50 m of track behind the curve, where no claim looks farther;
and a straight run that hunts, steadily, half-way through is left there, since it will not settle in the other half.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ... import master
from ...master.side_by_side import SideBySide
from ...network import Network
from ...sweeps.axes import Point
from ...systems import System
from ...trajectory import Trajectory
from .. import cases, measures
from ..cases import ALGORITHM, FAST, RECORD, SETS, SLOW, SPINS, STRAIGHT, Extent
from ..measures import Margins, Measures, Y
from .draws import NAMED, plain, sources_of
from .open_parameters import Open, every_open_parameter, values_of

SPEEDS = (STRAIGHT, SLOW, FAST)
DRAWN = Extent(behind_slow=measures.END, starts=("0mm",))
UNITS = {"y": "m", "psi": "rad", "force": "N", "swing": "m", "steady": "rad", "after": "m", "reach": "m", "t": "s"}
HUNTS = 1e-3  # m; half-way through a straight run this much, and not halved since a quarter, is hunting that will not settle


@dataclass(frozen=True)
class VehicleSubject:
    """See gyro_cosim.paper.sensitivity.draws.Subject. `fixed`: the vehicle's values that are not drawn."""

    systems: Mapping[int, System]
    parameters: tuple[Open, ...]
    wheels: Mapping[str, Mapping[str, float]]
    named: Mapping[str, tuple[str, Mapping[str, float]]]
    fixed: Mapping[str, float]
    extent: Extent
    name: str = "vehicle"

    @property
    def sources(self) -> tuple[str, ...]:
        """Of the FMUs."""
        return tuple(sorted({part.source for part in self.systems[SLOW].components}))

    @cached_property
    def measures(self) -> dict[str, str]:
        """Column -> unit."""
        return {_column(v, g, key): UNITS.get(key, "1") for v in SPEEDS for g in SPINS for key in _measured(_nothing(), v)}

    @cached_property
    def claims(self) -> dict[str, tuple[str, ...]]:
        """Claim -> its parts."""
        return {claim: tuple(margins) for claim, margins in _margins(lambda v, g: _measured(_nothing(), v)).items()}

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> "VehicleBench":
        """See Subject."""
        return VehicleBench(self, files, lanes)

    def described(self) -> dict[str, Any]:
        """See Subject."""
        code = sources_of(*(Path(module) for module in (__file__, cases.__file__, measures.__file__)))
        return {"extent": plain(self.extent), "code": code, "stop": self.extent.straight}


def subject(extent: Extent = DRAWN) -> VehicleSubject:
    """The vehicle with the ranges of its tables and of its gyro units'; the sets A and B are named points."""
    tables = {name: values_of(cases.base(name, SLOW)) for name in SETS}
    table, other = tables.values()
    parameters = every_open_parameter(cases.base("A", SLOW))
    targets = {parameter.target for parameter in parameters}
    spin = {t: value for t, value in other.items() if value != table[t] and t not in targets}  # how B's wheels differ
    return VehicleSubject(
        systems={speed: cases.base("A", speed) for speed in SPEEDS},
        parameters=parameters,
        wheels={SETS["A"]: {}, SETS["B"]: spin},
        named={f"set {name}": (SETS[name], {t: tables[name][t] for t in sorted(targets)}) for name in SETS},
        fixed={t.partition(".")[2]: value for t, value in table.items() if t.startswith("vehicle.")},
        extent=extent,
    )


class VehicleBench:
    """The vehicle's FMUs, open in this process."""

    def __init__(self, what: VehicleSubject, files: Mapping[str, str], lanes: SideBySide) -> None:
        self._what, self._lanes = what, lanes
        self._systems = {
            speed: replace(plan, components=tuple(replace(part, source=files[part.source]) for part in plan.components))
            for speed, plan in what.systems.items()
        }
        self._network: Network | None = None

    def measure(self, point: Point, into: dict[str, float]) -> dict[str, Margins]:
        """See gyro_cosim.paper.sensitivity.draws.Bench."""
        values = {t: float(v) for t, v in point.items() if t not in NAMED} | dict(self._what.wheels[str(point["wheels"])])
        of_vehicle = {**self._what.fixed, **{t.partition(".")[2]: v for t, v in values.items() if t.startswith("vehicle.")}}

        def run(speed: int, gyro: str) -> Measures:
            plan = self._systems[speed]
            for target, value in values.items():
                plan = plan.with_value(target, value)
            plan = cases.with_case(plan, speed, gyro, self._what.extent.starts[0])
            stop = cases.seconds(speed, of_vehicle, self._what.extent)
            tr = self._simulated(plan, stop / 2) if speed == STRAIGHT else None
            if tr is None or not (tr.t[-1] < stop / 2 - 1e-9 or hunts(tr)):
                tr = self._simulated(plan, stop)
            measured = _measured(tr, speed)
            into.update({_column(speed, gyro, key): value for key, value in measured.items()})
            return measured

        return _margins(run)

    def close(self) -> None:
        """Close the FMUs."""
        if self._network is not None:
            self._network.close()

    def _simulated(self, plan: System, stop: float) -> Trajectory:
        if self._network is None:
            self._network = master.open_network(plan)
        network = Network(plan, self._network.slaves)
        options = master.Options(record=RECORD, compiled=True)
        return self._lanes.run(network, ALGORITHM, plan.step, stop, options)[0].trajectory


def hunts(tr: Trajectory) -> bool:
    """Whether half a straight run shows already that its second half will not settle: wide, and not halved since its middle.

    To settle, such a run would have to shrink a hundredfold in the second half after less than twofold in a quarter.
    """

    def largest(t: float) -> float:
        return float(np.abs(tr[Y][(tr.t > t - measures.LAST) & (tr.t <= t)]).max())

    end = float(tr.t[-1])
    return largest(end) > max(HUNTS, largest(end / 2) / 2)


def _margins(run: Callable[[int, str], Measures]) -> dict[str, Margins]:
    """Claim -> part -> margin, from what the runs at a speed with the gyro off and on gave."""
    straight, slow, fast = ({gyro: run(speed, gyro) for gyro in SPINS} for speed in SPEEDS)
    return {
        "C6": measures.claim_6(straight["off"], straight["on"]),
        "C7": measures.claim_7([slow["off"]], [slow["on"]]),
        "C8": measures.claim_8([slow["off"]], [slow["on"]]),
        "C9": measures.claim_9([fast["off"]]),
        "C10": measures.claim_10([fast["on"]]),
    }


def _measured(tr: Trajectory, speed: int) -> Measures:
    """What is measured of a run, and when it ended."""
    return (measures.straight(tr) if speed == STRAIGHT else measures.curve(tr)) | {"t": float(tr.t[-1])}


def _column(speed: int, gyro: str, key: str) -> str:
    return f"{speed} m/s {gyro}: {key}"


def _nothing() -> Trajectory:
    """A run in which nothing happens: it tells the names of what is measured."""
    names = (measures.DISTANCE, measures.CURVATURE, measures.Y, measures.PSI, measures.FORCE, measures.COEFFICIENT,
             f"vehicle.{measures.INNER}{measures.CLIMB}")  # fmt: skip
    t = np.linspace(0.0, 1.0, 101)
    return Trajectory(t, names, ("1",) * len(names), np.column_stack([t, *[np.zeros_like(t)] * (len(names) - 1)]))
