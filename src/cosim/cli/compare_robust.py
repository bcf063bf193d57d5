"""cosim compare --robust: what the runs decide and whether variants keep the tolerances, asked again with one thing changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..comparison.candidates import Candidate, Comparison, compare
from ..master import open_network
from ..systems import System
from .assessments import assessed
from .common import progress
from .robust import Again, Asked, answered, questions_of, varied

if TYPE_CHECKING:
    from ..comparison.robustness import Change

VERDICTS = {True: "yes", False: "no", None: "cannot be decided"}


@dataclass(frozen=True)
class ComparedAgain:
    """A comparison that is asked again.

    Parameters
    ----------
    again : Again
        Questions and runs.
    texts : tuple of str
        The variants as they were given.
    component : str
        What is exchanged.
    values : tuple of (str, value)
        What is set on it.
    settings : mapping
        Everything else that compare() is told.
    """

    again: Again
    texts: tuple[str, ...]
    component: str
    values: tuple[tuple[str, str | float], ...]
    settings: Mapping[str, Any]

    def ask(self, result: Comparison) -> Asked:
        """Compare once more with each change."""
        from ..comparison.robustness import asked_again

        names = [candidate.label for candidate in result.candidates]
        halved = [self._with_half_the_internal_step(*pair) for pair in zip(self.texts, result.candidates, strict=True)]

        def answers(change: "Change") -> dict[str, str]:
            made = compare(
                change.system, halved if change.kind == "internal step" else self.texts, component=self.component,
                values=self.values, step=change.step, responses=False, **self.settings,
            )  # fmt: skip
            return _answers(made, names)

        with progress("comparing again") as show:
            verdicts = asked_again(_answers(result, names), self.again.questions, self.again.runs, answers, show)
        return Asked(tuple(verdicts), {}, {})

    def _with_half_the_internal_step(self, text: str, candidate: Candidate) -> str:
        """The variant with half of its own internal step, or as it is where it has none."""
        from ..comparison.robustness import INTERNAL, internal_steps

        assert candidate.run is not None
        with open_network(candidate.run.system, in_process=bool(self.settings["in_process"])) as network:
            steps = internal_steps(network)
        own = {steps[name] for name in candidate.run.system.addressed(self.component) if name in steps}
        return f"{text},{INTERNAL}={own.pop() / 2!r}" if len(own) == 1 else text


def prepared(
    plan: System, component: str | None, texts: Sequence[str], values: Sequence[tuple[str, str | float]], step: float,
    within: Sequence[str], starts: int, seed: int, settings: Mapping[str, Any],
) -> ComparedAgain:  # fmt: skip
    """What there is to ask, before anything runs.

    Parameters
    ----------
    plan, component, texts, values, settings
        As compare() takes them.
    step : float
        Macro step, s.
    within, starts, seed
        As of `cosim run --robust`.
    """
    from ..comparison.variants import labels

    for text in texts:
        if text.partition(",")[0].endswith((".ssd", ".ssp")):
            raise ValueError(f"--robust needs variants of a component, since a whole system has its own starts, got {text!r}")
    chosen = plan.exchanged(component)
    exchanged = plan.addressed(chosen)
    rest = plan
    for target, value in values:
        if plan.owner(target) not in exchanged and target.partition(".")[0] != chosen:
            rest = rest.with_value(target, value)
    own = tuple(pair for pair in values if plan.owner(pair[0]) in exchanged or pair[0].partition(".")[0] == chosen)
    with open_network(rest, in_process=bool(settings["in_process"])) as network:
        runs, words = varied(network, step, within, starts, seed)
        decided = questions_of(rest, network.names)
    names = labels(texts)
    questions = [_keeps(name, names[0]) for name in names[1:]]
    questions += [f"{name}, {question}" for name in names for question in decided]
    return ComparedAgain(Again(tuple(questions), runs, words), tuple(texts), chosen, own, settings)


def _keeps(name: str, reference: str) -> str:
    return f"{name} keeps the tolerances against {reference}"


def _answers(result: Comparison, names: Sequence[str]) -> dict[str, str]:
    """Of every candidate whether it keeps the tolerances, and what its run decides; a run that failed decides nothing."""
    made: dict[str, str] = {}
    for k, (candidate, name) in enumerate(zip(result.candidates, names, strict=True)):
        if k and not candidate.failure:
            made[_keeps(name, names[0])] = VERDICTS[candidate.verdict]
        if candidate.run is not None and not candidate.failure:
            found = answered(candidate.run, assessed(candidate.run.trajectory))
            made |= {f"{name}, {question}": answer for question, answer in found.items()}
    return made
