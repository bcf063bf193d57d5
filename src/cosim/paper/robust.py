"""Which claims survive another creep law, half the internal step, and other starts? Claims C6 to C10, by sweeps of the FMUs.

Every run of the ledger is done from many starts, drawn evenly within a tenth of a millimetre of the paper's, with each of four
creep laws, and once more with half the vehicle's internal step. A part of a claim is asked of each start by itself. It

    holds               if it does in at least 95 % of the starts, in every one of these five ways
    fails               if it does in at most 5 % of them, in every one
    is not decidable    otherwise

What was stopped goes on when it is asked for again: rows are kept in files, which name all that decides them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..master import Progress, stage
from ..railway.forms import CREEP_LAWS, with_creep_law
from ..sweeps import Measure, Sweep, load, sweep
from ..systems import StopWhen, System, catalogue
from ..trajectory import Trajectory
from . import measures
from .cases import FAST, SETS, SLOW, SPINS, STRAIGHT, Extent, base, seconds
from .ledger import Claim
from .measures import Measures
from .sensitivity.statistics import wilson

SEED, WITHIN = 1, 1e-4  # of the starts; m, to both sides: what does not hunt must not depend on it
SURE = 0.95  # share of the starts
HALVED = "Polach, half the internal step"
WAYS = (*CREEP_LAWS, HALVED)
STRAIGHT_COLUMNS = {"y": "m", "psi": "rad", "climb": "1"}
CURVE_COLUMNS = {"y": "m", "psi": "rad", "force": "N", "filtered": "1", "swing": "m", "steady": "rad", "after": "m", "climb": "1",
                 "reach": "m"}  # fmt: skip
Run = tuple[str, int, str, str]  # way, speed (m/s), gyro "off" or "on", parameter set
Rows = Mapping[Run, Sequence[Measures]]  # one for each start, in their order


@dataclass(frozen=True)
class Part:
    """What became of one part of a claim.

    Parameters
    ----------
    claim, part : str
        Such as "C9" and "B: derails".
    held : mapping of str to int
        Way of WAYS -> from how many of the starts it holds.
    starts : int
        Of how many.
    """

    claim: str
    part: str
    held: Mapping[str, int]
    starts: int

    @property
    def verdict(self) -> str:
        """ "holds", "fails" or "not decidable"."""
        shares = [count / self.starts for count in self.held.values()]
        if min(shares) >= SURE:
            return "holds"
        return "fails" if max(shares) <= 1.0 - SURE else "not decidable"

    @property
    def words(self) -> str:
        """The counts, in words: "Polach 20, FASTSIM 0 of 20"."""
        return ", ".join(f"{way} {count}" for way, count in self.held.items()) + f" of {self.starts}"


def straight_measures(trajectory: Trajectory) -> Measures:
    """Of a run on straight track, for a sweep."""
    return measures.straight(trajectory)


def curve_measures(trajectory: Trajectory) -> Measures:
    """Of a run in the curve, for a sweep."""
    return measures.curve(trajectory)


def survived(folder: Path, starts: int, extent: Extent | None = None, progress: Progress | None = None) -> list[Part]:
    """Do the runs that `folder` does not hold yet, and judge every part of claims C6 to C10.

    Parameters
    ----------
    folder : Path
        Where the rows are kept, `robust-SET-TRACK-WAY.npz`.
    starts : int
        How many for each run and way; the first are the same whatever their number.
    extent : Extent, optional
        How long the runs are.
    progress : callable, optional
        Told how much is done, and how much there is.

    Returns
    -------
    list of Part
        In the order of the claims.

    Raises
    ------
    ValueError
        For fewer than one start, or a file of other runs.
    """
    if starts < 1:
        raise ValueError(f"starts must be at least 1, got {starts}")
    folder.mkdir(parents=True, exist_ok=True)
    sweeps = list(_sweeps(starts, extent or Extent()))
    rows: dict[Run, list[Measures]] = {}
    for k, (name, file, what) in enumerate(sweeps):
        sweep(what, folder / file, extend=True, progress=stage(progress, k / len(sweeps), (k + 1) / len(sweeps)))
        table = load(folder / file)
        assert what.measure is not None
        place = {case: i for i, case in enumerate(what.cases)}
        order = sorted((i for i in range(len(table)) if table["case"][i] in place), key=lambda i: place[str(table["case"][i])])
        for i in order:
            speed, gyro, _ = str(table["case"][i]).split()
            way = {v.partition(":")[2]: law for law, (v, _) in CREEP_LAWS.items()}[str(table["vehicle"][i])]
            key = (HALVED if "half" in file else way, int(speed), gyro, name)
            rows.setdefault(key, []).append({column: float(table[column][i]) for column in what.measure.columns})
    return parts(rows)


def parts(rows: Rows) -> list[Part]:
    """Judge every part of claims C6 to C10, start by start.

    Parameters
    ----------
    rows : mapping
        The measures of every start, by way, speed, gyro and parameter set.

    Returns
    -------
    list of Part
        In the order of the claims.
    """
    found: dict[tuple[str, str], dict[str, list[bool]]] = {}
    for name in dict.fromkeys(key[3] for key in rows):
        for way in dict.fromkeys(key[0] for key in rows):

            def run(speed: int, gyro: str, way: str = way, name: str = name) -> Sequence[Measures]:
                return rows[way, speed, gyro, name]

            for off, on in zip(run(STRAIGHT, "off"), run(STRAIGHT, "on"), strict=True):
                _add(found, "C6", name, way, measures.claim_6(off, on))
            for off, on in zip(run(SLOW, "off"), run(SLOW, "on"), strict=True):
                _add(found, "C7", name, way, measures.claim_7([off], [on]))
                _add(found, "C8", name, way, measures.claim_8([off], [on]))
            for off in run(FAST, "off"):
                _add(found, "C9", name, way, measures.claim_9([off]))
            for on in run(FAST, "on"):
                _add(found, "C10", name, way, measures.claim_10([on]))
    ordered = sorted(found, key=lambda key: int(key[0][1:]))
    return [Part(claim, part, {w: sum(h) for w, h in found[claim, part].items()}, len(next(iter(found[claim, part].values()))))
            for claim, part in ordered]  # fmt: skip


def judged(claim: Claim, found: Sequence[Part]) -> Claim:
    """A claim of the ledger with what became of its parts; one that was not asked again as it was.

    Parameters
    ----------
    claim : Claim
        As its runs from a few starts say it.
    found : sequence of Part
        Of all claims.

    Returns
    -------
    Claim
        Its verdict goes by what was asked again.
    """
    own = [part for part in found if part.claim == claim.id]
    if not own:
        return claim
    words = {"holds": "hold", "fails": "fail", "not decidable": "are not decidable"}
    counts = ", ".join(f"{sum(part.verdict == key for part in own)} {word}" for key, word in words.items())
    return replace(
        claim,
        parts={**claim.parts, **{part.part: part.verdict == "holds" for part in own}},
        undecided={part.part: part.words for part in own if part.verdict == "not decidable"},
        survives=f"{own[0].starts} starts, {len(own[0].held)} ways: of {len(own)} parts {counts}",
    )


def page(found: Sequence[Part]) -> str:
    """The parts as a table of Markdown, for the page on the claims: from how many starts each holds, with Wilson's interval."""
    return f"From how many of {found[0].starts} starts each part holds, and Wilson's interval at 95 %:\n\n{_table(found)}"


def _table(found: Sequence[Part]) -> str:
    ways = list(found[0].held)
    head = ["claim", "part", "verdict", *ways]
    lines = [head, ["---"] * len(head)]
    for one in found:
        cells = []
        for way in ways:
            share = wilson(one.held[way], one.starts)
            cells.append(f"{share.count} ({100 * share.low:.0f}..{100 * share.high:.0f} %)")
        lines.append([one.claim, one.part, one.verdict, *cells])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _add(found: dict[tuple[str, str], dict[str, list[bool]]], claim: str, name: str, way: str, margins: measures.Margins) -> None:
    for part, holds in measures.holds(margins).items():
        found.setdefault((claim, f"{name}: {part}"), {}).setdefault(way, []).append(holds)


def _sweeps(starts: int, extent: Extent) -> Iterator[tuple[str, str, Sweep]]:
    """Parameter set, file and sweep of each track with all laws, and with half the internal step."""
    places = np.random.default_rng(SEED).uniform(-WITHIN, WITHIN, starts).tolist()
    for name in SETS:
        for straight in (True, False):
            plan, stop = _plan(name, straight, extent)
            speeds = (STRAIGHT,) if straight else (SLOW, FAST)
            cases = {
                f"{v} {gyro} {k}": {"vehicle.speed": float(v), "gyro.rotor_speed": spin, "vehicle.front_lateral_displacement": y}
                for k, y in enumerate(places) for v in speeds for gyro, spin in SPINS.items()
            }  # fmt: skip
            measure = Measure(straight_measures, STRAIGHT_COLUMNS) if straight else Measure(curve_measures, CURVE_COLUMNS)
            every = tuple(source.partition(":")[2] for source, _ in CREEP_LAWS.values())
            step = catalogue.component(CREEP_LAWS["Polach"][0]).internal_step
            halved = plan.with_value("vehicle.internal_step", step / 2)
            for way, chosen, laws in (("laws", plan, every), ("half", halved, every[:1])):
                what = Sweep(chosen, variants={"vehicle": laws}, cases=cases, stop=stop, signals=("vehicle.body_distance",),
                             measure=measure)  # fmt: skip
                yield name, f"robust-{name}-{'straight' if straight else 'curve'}-{way}.npz", what


def _plan(name: str, straight: bool, extent: Extent) -> tuple[System, float]:
    """The system of a set with all of its numbers set, and the end of its runs (s)."""
    own = base(name, STRAIGHT if straight else SLOW)
    start = {v.name: v.start for v in catalogue.component(own.components[0].source).parameters}
    plan = with_creep_law(own, own.components[0].name, "FASTSIM")
    if straight:
        return plan, extent.straight
    stop = seconds(SLOW, start, extent)
    end = StopWhen(("vehicle", "body_distance"), stop * SLOW, "end of the track")
    return replace(plan, stop_when=(*plan.stop_when, end)), stop + 1.0
