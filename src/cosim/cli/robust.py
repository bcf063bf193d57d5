"""cosim run --robust: the verdicts of a run, asked again with one thing changed each time (comparison/robustness.py)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..coupling import Algorithm
from ..master import Options, Run, simulate
from ..master.recording import Recording
from ..network import Network
from .assessments import Assessed, Deciding, assessed, fields
from .common import progress
from .settings import assignment

if TYPE_CHECKING:
    from ..comparison.robustness import Change, Robustness

STARTS = 20  # none of 20 turned: the share that keeps the verdict is above 84 %


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

    def ask(
        self, run: Run, found: Sequence[Assessed], algorithm: Algorithm, start: float, stop: float,
        in_process: bool, isolate: bool, substeps: Mapping[str, int], every: int,
    ) -> "list[Robustness]":  # fmt: skip
        """Do the runs, everything else as in `run`; times in s."""
        from ..comparison.robustness import asked_again

        def answers(change: "Change") -> dict[str, str]:
            other = simulate(
                change.system, algorithm=algorithm, step=change.step, start=start, stop=stop, in_process=in_process,
                isolate=isolate, substeps=substeps, options=Options(record=Recording((), every, None)),
            )  # fmt: skip
            return answered(other, assessed(other.trajectory))

        with progress("asking again") as show:
            return asked_again(answered(run, found), self.questions, self.runs, answers, show)

    def document(self, asked: "Sequence[Robustness]") -> dict[str, Any]:
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
                for one in asked
            ],
        }

    def words(self, asked: "Sequence[Robustness]") -> list[str]:
        """In words: what was changed, then each verdict."""
        changed = [run.words for run in self.runs if run.kind != "start"]
        lines = [
            "",
            f"asked again in {len(self.runs)} runs: {'; '.join([*changed, self.starts or 'no other starts (--within)'])}",
        ]
        for one in asked:
            share = f"{one.same} of {one.starts} starts agree ({100 * one.low:.0f}..{100 * one.high:.0f} %)" if one.starts else ""
            if one.decidable:
                lines.append(f"{one.question}? {one.answer}, in all of them" + (f"; {share}" if share else ""))
            else:
                reason = "; ".join(one.turned) if one.answer else "this run gives no answer"
                given = f"{one.answer} in this run, " if one.answer else ""
                lines.append(f"{one.question}? not decidable: {given}{reason}" + (f"; {share}" if share and one.answer else ""))
        return lines


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
    from ..comparison.robustness import changes, described

    system, deciding = network.system, [field for field in fields() if isinstance(field, Deciding)]
    questions = [_stopped(stop.says) for stop in system.stop_when]
    questions += [question for field in deciding for question in field.questions(network.names)]
    if not questions:
        raise ValueError(
            f"--robust needs a verdict, system {system.name!r} has none: no stop condition, and no field decides anything"
        )
    spread: dict[str, str] = dict(assignment(text, "--within must be COMPONENT.VARIABLE=TOL") for text in within)
    if not spread:
        known = {f"{slave.name}.{name}" for slave in network.slaves for name in slave.description.settable}
        spread = {name: tol for field in deciding for name, tol in field.starts(network.names).items() if name in known}
    forms = {words: form for field in deciding for words, form in field.forms(system).items()}
    runs = changes(network, step, within=spread, starts=starts, seed=seed, forms=forms)
    return Again(tuple(questions), tuple(runs), described(spread, starts, seed))


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


def _stopped(says: str) -> str:
    return f"stops: {says}"
