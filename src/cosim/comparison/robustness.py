"""Does the verdict of a run survive what nobody has measured? The run is asked again, each time with one thing changed.

    half the macro step             the error of the coupling
    half the internal step          the error of the components' own integration, where they have a parameter `internal_step`
    another form of the model       what a field of engineering registers, such as another creep law
    starts within a tolerance       drawn evenly, with a seed, from the values that the run begins with

A verdict that any of these turns is not decidable. Only the starts are a sample: of these the share that keeps the verdict has
an interval; the other changes are one case each.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..errors import RunError, unknown
from ..master import Progress
from ..network import Network
from ..slaves.signal import Signal
from ..systems import System
from ..systems.quantities import parsed

INTERNAL = "internal_step"
CONFIDENCE = 0.95  # of the interval of a share

Answers = Mapping[str, str]  # question -> its answer in a run, such as "a wheel leaves its rail" -> "no"


@dataclass(frozen=True)
class Change:
    """A run with one thing changed.

    Parameters
    ----------
    kind : {"macro step", "internal step", "form", "start"}
        What is changed.
    words : str
        How, for people: "with half the macro step (0.5 ms)".
    system : System
        What is run.
    step : float
        Macro step, s.
    """

    kind: Literal["macro step", "internal step", "form", "start"]
    words: str
    system: System
    step: float


Heard = tuple[Change, Answers, str]  # a changed run, its answers, and why it has none, or empty


@dataclass(frozen=True)
class Robustness:
    """A verdict and what became of it.

    Parameters
    ----------
    question, answer : str
        What was asked, and the answer of the run as it was given; empty where it gave none.
    same, starts : int
        Starts with the same answer, of how many.
    low, high : float
        Interval of the share of such starts at 95 % (Wilson); 0 and 1 where there were none.
    turned : tuple of str
        In words, each change that gives another answer, or none.
    """

    question: str
    answer: str
    same: int
    starts: int
    low: float
    high: float
    turned: tuple[str, ...]

    @property
    def decidable(self) -> bool:
        """Whether the run has an answer which nothing has turned."""
        return bool(self.answer) and not self.turned


def changes(
    network: Network, step: float, *, within: Mapping[str, str | float], starts: int, seed: int, forms: Mapping[str, System],
) -> list[Change]:  # fmt: skip
    """Every run that is to be asked.

    Parameters
    ----------
    network : Network
        The run as it is given, open.
    step : float
        Its macro step, s.
    within : mapping of str to (str or float)
        `component.variable` and how far its start value may be away to both sides: text with a unit, or in the variable's own.
    starts : int
        How many starts are drawn where `within` names any; each draws all of its variables.
    seed : int
        Of the draws.
    forms : mapping of str to System
        In words ("with the creep law ...") and as a system, what else the model may be.

    Returns
    -------
    list of Change
        Half steps first, then forms, then starts.

    Raises
    ------
    ValueError
        Where a variable cannot be set or a start would be out of its bounds; a tolerance or number of starts that is not
        positive.
    """
    if starts < 1:
        raise ValueError(f"starts must be at least 1, got {starts}")
    system = network.system
    made = [Change("macro step", f"with half the macro step ({step * 5e2:g} ms)", system, step / 2)]
    halved = system
    for name, internal in internal_steps(network).items():
        halved = halved.with_value(f"{name}.{INTERNAL}", internal / 2)
    if halved is not system:
        made.append(Change("internal step", "with half the internal step", halved, step))
    made += [Change("form", words, form, step) for words, form in forms.items()]
    centres = {target: _spread(network, target, given) for target, given in within.items()}
    random = np.random.default_rng(seed)
    for _ in range(starts if centres else 0):
        moved, words = system, []
        for target, (centre, tolerance, unit) in centres.items():
            value = float(centre + tolerance * random.uniform(-1.0, 1.0))
            moved = moved.with_value(target, value)
            words.append(f"{target} = {value:.6g} {unit}".rstrip())
        made.append(Change("start", "from " + ", ".join(words), moved, step))
    return made


def asked_again(
    given: Answers,
    questions: Sequence[str],
    runs: Sequence[Change],
    ask: Callable[[Change], Answers],
    progress: Progress | None = None,
) -> list[Robustness]:
    """Ask all runs, and say of each question whether its answer survives.

    Parameters
    ----------
    given : mapping of str to str
        The answers of the run as it was given.
    questions : sequence of str
        What is asked; a run may leave one without an answer.
    runs : sequence of Change
        Those of changes().
    ask : callable
        Does a run and gives its answers. Where it raises a RunError, that run has none, and the error is the reason.
    progress : callable, optional
        Told the number of runs that are done, and of all.

    Returns
    -------
    list of Robustness
        In the order of `questions`.
    """
    heard: list[Heard] = []
    for k, change in enumerate(runs):
        try:
            heard.append((change, ask(change), ""))
        except RunError as error:
            heard.append((change, {}, str(error)))
        if progress is not None:
            progress(k + 1, len(runs))
    return judged(given, questions, heard)


def judged(given: Answers, questions: Sequence[str], heard: Sequence[Heard]) -> list[Robustness]:
    """Say of each question whether its answer survives.

    Parameters
    ----------
    given : mapping of str to str
        The answers of the run as it was given.
    questions : sequence of str
        What was asked.
    heard : sequence of (Change, mapping, str)
        Of each changed run its answers, and why there are none, or empty.

    Returns
    -------
    list of Robustness
        In the order of `questions`.
    """
    return [_judged(question, given.get(question, ""), heard) for question in questions]


def internal_steps(network: Network) -> dict[str, float]:
    """The internal step of every component that has one, in the unit of its parameter `internal_step`.

    Parameters
    ----------
    network : Network
        Open.

    Returns
    -------
    dict of str to float
        Component -> the step it begins with.
    """
    return {
        name: _centre(values, settable[INTERNAL])
        for name, values, settable in _parts(network)
        if INTERNAL in settable and settable[INTERNAL].start is not None
    }


def interval(same: int, of: int) -> tuple[float, float]:
    """The interval of a share at 95 %: Wilson, Probable inference, the law of succession, and statistical inference (1927).

    Parameters
    ----------
    same, of : int
        How many of how many.

    Returns
    -------
    low, high : float
        Between 0 and 1, and these where nothing was counted.
    """
    from scipy.stats import binomtest

    if not of:
        return 0.0, 1.0
    found = binomtest(same, of).proportion_ci(CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)


def _judged(question: str, answer: str, heard: Sequence[Heard]) -> Robustness:
    turned: list[str] = []
    other: list[str] = []
    drawn = 0
    for change, answers, failure in heard:
        drawn += change.kind == "start"
        if answers.get(question, "") == answer:
            continue
        words = f"{answers.get(question) or 'no answer'} {change.words}" + (f" ({failure})" if failure else "")
        (other if change.kind == "start" else turned).append(words)
    if other:
        turned.append(f"{len(other)} of {drawn} starts, such as {other[0]}")
    low, high = interval(drawn - len(other), drawn)
    return Robustness(question, answer, drawn - len(other), drawn, low, high, tuple(turned))


def _parts(network: Network) -> list[tuple[str, Mapping[str, object], Mapping[str, Signal]]]:
    """Of each component its name, the values it is given, and what may be given a value."""
    return [(s.name, v, s.description.settable) for s, v in zip(network.slaves, network.values, strict=True)]


def _centre(values: Mapping[str, object], signal: Signal) -> float:
    """The value that the run begins with, in the signal's unit."""
    value = values.get(signal.name, signal.start)
    if signal.shape or signal.type != "real" or not isinstance(value, int | float):
        raise ValueError("must be a real scalar with a start value")
    return float(value)


def _spread(network: Network, target: str, given: str | float) -> tuple[float, float, str]:
    """Centre, tolerance and unit of a start value."""
    owner = network.system.owner(target)
    if not owner:
        raise unknown(f"component of system {network.system.name!r}:", target.partition(".")[0], [s.name for s in network.slaves])
    (values, settable), *_ = [(v, s) for name, v, s in _parts(network) if name == owner]
    variable = target[len(owner) + 1 :]
    if variable not in settable:
        raise unknown(f"parameter of {owner!r}:", variable, settable)
    signal = settable[variable]
    try:
        centre = _centre(values, signal)
        quantity = parsed(given, signal.unit, signal.measure).expressed(signal.measure) if isinstance(given, str) else given
        if not 0.0 < quantity < float("inf"):
            raise ValueError(f"tolerance must be positive and finite, got {given}")
        for end in (centre - quantity, centre + quantity):
            signal.value(end)
    except ValueError as error:
        raise ValueError(f"{target}: {error}") from None
    return centre, float(quantity), signal.unit


def described(within: Mapping[str, str | float], starts: int, seed: int) -> str:
    """Which starts are drawn, in words; empty where none are."""
    spread = ", ".join(f"{target} +- {tolerance}" for target, tolerance in within.items())
    return f"{starts} starts, seed {seed}: {spread}" if spread else ""
