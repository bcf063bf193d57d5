"""cosim run --robust: the verdicts of a run, asked again with one thing changed each time (comparison/robustness.py)."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..coupling import Algorithm
from ..master import Options, Run, open_network, simulate
from ..master.recording import Recording
from ..network import Network
from ..systems import System
from .assessments import Assessed, Deciding, Measuring, assessed, fields
from .common import finite, progress
from .settings import assignment

if TYPE_CHECKING:
    from ..comparison.error_bars import ErrorBar
    from ..comparison.robustness import Change, Robustness
    from ..master.side_by_side import SideBySide

STARTS = (
    39  # the fewest whose smallest and largest value hold for 95 % of further starts; if none turns, above 91 % keep a verdict
)
Sizes = Mapping[str, tuple[float, str]]  # what was measured -> value and unit


@dataclass(frozen=True)
class Asked:
    """What became of the verdicts and the figures of a run.

    Parameters
    ----------
    verdicts : tuple of Robustness
        One for each question.
    sizes : mapping of str to (float, str)
        Of the run as it was given.
    bars : mapping of str to ErrorBar
        Of each of them, from the starts; empty where none were drawn.
    """

    verdicts: "tuple[Robustness, ...]"
    sizes: Sizes
    bars: "Mapping[str, ErrorBar]"

    @property
    def decidable(self) -> bool:
        """Whether every verdict is."""
        return all(one.decidable for one in self.verdicts)


@dataclass(frozen=True)
class Conditions:
    """How every run is done that is asked again; times in s."""

    algorithm: Algorithm
    start: float
    stop: float
    in_process: bool = False
    isolate: bool = False
    substeps: Mapping[str, int] | None = None
    every: int = 1

    @property
    def in_lanes(self) -> bool:
        """Whether the runs may go side by side in the lanes of the processor."""
        return self.start == 0.0 and not (self.in_process or self.isolate or self.substeps)


@dataclass(frozen=True)
class Again:
    """What is asked again, and of which runs.

    Parameters
    ----------
    questions : tuple of str
        At least one.
    runs : tuple of Change
        Each with one thing changed.
    starts : str
        Which starts are drawn, in words; empty where none are.
    """

    questions: tuple[str, ...]
    runs: "tuple[Change, ...]"
    starts: str

    def ask(self, run: Run, found: Sequence[Assessed], conditions: Conditions) -> Asked:
        """Do the runs, everything else as in `run`: as many at once as the processor has lanes, where that pays."""
        from ..comparison.robustness import judged
        from ..sweeps.crew import REPORT, Crew

        rows: dict[str, list[Any]] = {}
        waiting = deque(str(k) for k in range(len(self.runs)))
        crew = Crew(_Asking(self.runs, conditions), {}, None if conditions.in_lanes else 1, len(self.runs))
        try:
            with progress("asking again") as show:
                while waiting or crew.busy:
                    while waiting and crew.free > 0:
                        crew.begin(waiting.popleft(), {})
                    rows |= {row[0]: row for row in crew.rows(REPORT)}
                    show(len(rows), len(self.runs))
        finally:
            crew.close()
        heard = [(change, *rows[str(k)][1:]) for k, change in enumerate(self.runs)]
        sizes = sized(found)
        drawn = [measured for change, _, measured, _ in heard if change.kind == "start"]
        answers = judged(answered(run, found), self.questions, [(change, said, why) for change, said, _, why in heard])
        return Asked(tuple(answers), sizes, bars(sizes, drawn))

    def document(self, asked: Asked) -> dict[str, Any]:
        """As JSON holds it."""
        return {
            "runs": len(self.runs),
            "starts": self.starts or None,
            "verdicts": [
                {
                    "question": one.question,
                    "answer": one.answer or None,
                    "decidable": one.decidable,
                    "same": one.same,
                    "of": one.starts,
                    "share_low": one.low,
                    "share_high": one.high,
                    "turned": list(one.turned),
                }
                for one in asked.verdicts
            ],
            "error_bars": [
                {"of": name, "unit": asked.sizes[name][1], "value": finite(asked.sizes[name][0]), "low": finite(bar.low),
                 "high": finite(bar.high), "share": bar.share, "starts": bar.starts}
                for name, bar in asked.bars.items()
            ],
        }  # fmt: skip

    def words(self, asked: Asked) -> list[str]:
        """In words: what was changed, then each verdict, then the error bars."""
        changed = [run.words for run in self.runs if run.kind != "start"]
        lines = [
            "",
            f"asked again in {len(self.runs)} runs: {'; '.join([*changed, self.starts or 'no other starts (--within)'])}",
        ]
        for one in asked.verdicts:
            share = f"{one.same} of {one.starts} starts agree ({100 * one.low:.0f}..{100 * one.high:.0f} %)" if one.starts else ""
            if one.decidable:
                lines.append(f"{one.question}? {one.answer}, in all of them" + (f"; {share}" if share else ""))
            else:
                reason = "; ".join(one.turned) if one.answer else "this run gives no answer"
                given = f"{one.answer} in this run, " if one.answer else ""
                lines.append(f"{one.question}? not decidable: {given}{reason}" + (f"; {share}" if share and one.answer else ""))
        for name, bar in asked.bars.items():
            value, unit = asked.sizes[name]
            unit = "" if unit == "1" else f" {unit}"
            within = f"{bar.low:.3g}..{bar.high:.3g}{unit}"
            lines.append(f"{name} {value:.3g}{unit}; a further start lies in {within} with {100 * bar.share:.0f} %")
        return lines


@dataclass(frozen=True)
class _Asking:
    """The runs as a task of a crew (sweeps/crew.py)."""

    runs: "Sequence[Change]"
    conditions: Conditions

    def open(self, files: Mapping[str, str], lanes: "SideBySide") -> "_Asker":
        del files
        return _Asker(self.runs, self.conditions, lanes)

    def lost(self, key: str, point: Mapping[str, Any], error: str) -> list[Any]:
        raise AssertionError("a crew in this process loses no run")

    def seconds(self, point: Mapping[str, Any], row: list[Any]) -> float:
        raise AssertionError("nobody asks how long a run took")


class _Asker:
    """Does such runs in one thread. A row is the number of the run, its answers, its sizes, and why there are none."""

    def __init__(self, runs: "Sequence[Change]", conditions: Conditions, lanes: "SideBySide") -> None:
        self._runs, self._how, self._lanes = runs, conditions, lanes
        self._open: dict[tuple[str, ...], Network] = {}

    def row(self, key: str, point: Mapping[str, Any]) -> list[Any]:
        from ..errors import RunError

        del point
        try:
            run = self._run(self._runs[int(key)])
        except RunError as error:
            return [key, {}, {}, str(error)]
        found = assessed(run.trajectory)
        return [key, answered(run, found), sized(found), ""]

    def close(self) -> None:
        for network in self._open.values():
            network.close()

    def _run(self, change: "Change") -> Run:
        how, options = self._how, Options(record=Recording((), self._how.every, None))
        if not how.in_lanes:
            return simulate(
                change.system, algorithm=how.algorithm, step=change.step, start=how.start, stop=how.stop,
                in_process=how.in_process, isolate=how.isolate, substeps=how.substeps, options=options,
            )  # fmt: skip
        sources = tuple(component.source for component in change.system.components)
        if sources not in self._open:
            self._open[sources] = open_network(change.system)
        network = Network(change.system, self._open[sources].slaves)
        return self._lanes.run(network, how.algorithm, change.step, how.stop, options)[0]


def prepared(network: Network, step: float, within: Sequence[str], starts: int, seed: int) -> Again:
    """What there is to ask of a run, before anything runs; ValueError where the system has no verdict.

    Parameters
    ----------
    network : Network
        The run, open.
    step : float
        Its macro step, s.
    within : sequence of str
        As after --within; besides, the fields say which starts they draw, where this is empty.
    starts, seed : int
        How many are drawn, and their seed.
    """
    questions = questions_of(network.system, network.names)
    if not questions:
        raise ValueError(
            f"--robust needs a verdict, system {network.system.name!r} has none: no stop condition, and no field decides anything"
        )
    runs, words = varied(network, step, within, starts, seed)
    return Again(tuple(questions), runs, words)


def questions_of(system: System, names: Sequence[str]) -> list[str]:
    """What a run of the system decides that records these signals."""
    made = [_stopped(stop.says) for stop in system.stop_when]
    return made + [question for field in fields() if isinstance(field, Deciding) for question in field.questions(names)]


def varied(
    network: Network, step: float, within: Sequence[str], starts: int, seed: int
) -> "tuple[tuple[Change, ...], str]":  # fmt: skip
    """Every run that is asked again, and in words which starts are drawn; parameters as of prepared()."""
    from ..comparison.robustness import changes, described

    deciding = [field for field in fields() if isinstance(field, Deciding)]
    spread: dict[str, str] = dict(assignment(text, "--within must be COMPONENT.VARIABLE=TOL") for text in within)
    if not spread:
        known = {f"{slave.name}.{name}" for slave in network.slaves for name in slave.description.settable}
        spread = {name: tol for field in deciding for name, tol in field.starts(network.names).items() if name in known}
    forms = {words: form for field in deciding for words, form in field.forms(network.system).items()}
    runs = changes(network, step, within=spread, starts=starts, seed=seed, forms=forms)
    return tuple(runs), described(spread, starts, seed)


def answered(run: Run, found: Sequence[Assessed]) -> dict[str, str]:
    """The answers of a run, by question."""
    made = {}
    for stop in run.system.stop_when:
        made[_stopped(stop.says)] = "yes" if run.ended_by.startswith(f"{stop.says} at t = ") else "no"
    for one in found:
        if isinstance(one.field, Deciding):
            for finding in one.findings:
                made |= one.field.answers(finding)
    return made


def sized(found: Sequence[Assessed]) -> dict[str, tuple[float, str]]:
    """The figures of a run that get error bars, with their units."""
    made: dict[str, tuple[float, str]] = {}
    for one in found:
        if isinstance(one.field, Measuring):
            for finding in one.findings:
                made |= one.field.measures(finding)
    return made


def bars(sizes: Sizes, drawn: "Sequence[Sizes]") -> "dict[str, ErrorBar]":
    """The error bar of each figure; a start whose run has it not may have any."""
    from ..comparison.error_bars import error_bar

    nan = (float("nan"), "")
    return {name: error_bar([measured.get(name, nan)[0] for measured in drawn]) for name in sizes if drawn}


def _stopped(says: str) -> str:
    return f"stops: {says}"
