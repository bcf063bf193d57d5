"""Axes of a sweep: what is varied and how, as text says it and as values.

    LOW:HIGH:N         N values from LOW to HIGH, evenly spaced; LOW:HIGH:N:log spaced evenly in the logarithm
    A,B,C              a list
    A                  one value, no axis
    LOW:HIGH           a range to draw samples from; LOW:HIGH:log evenly in the logarithm

Numbers may have units ("10rpm:200rpm:5"). Listed axes make a grid; ranges are sampled together by a Latin hypercube.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

Value = float | str
Point = dict[str, Value]  # axis -> value, one run


@dataclass(frozen=True)
class Listed:
    """An axis with its values.

    Parameters
    ----------
    target
        What the axis sets: `component.parameter`, a component, or a choice such as `step`.
    values
        All different, in the target's unit.
    """

    target: str
    values: tuple[Value, ...]

    def __post_init__(self) -> None:
        if not self.values:
            raise ValueError(f"axis {self.target!r} must have at least one value, has none")
        for value in self.values:
            if self.values.count(value) > 1:
                raise ValueError(f"axis {self.target!r}: values must differ, got {value!r} twice")


@dataclass(frozen=True)
class Ranged:
    """An axis that is sampled.

    Parameters
    ----------
    target
        What the axis sets, as `component.parameter`.
    low, high
        The ends of the range, in the target's unit.
    log
        Whether samples are spread evenly in the logarithm.
    """

    target: str
    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        _check_range(self.target, self.low, self.high, self.log)


Axis = Listed | Ranged


def parse(target: str, text: str, number: Callable[[str], Value]) -> Axis:
    """The axis that a text describes; see the module's docstring.

    Parameters
    ----------
    target
        What the axis sets.
    text
        A list, LOW:HIGH:N or LOW:HIGH, with :log at the end of the latter two where wanted.
    number
        Turns a value's text into the value, in the unit of the target.

    Returns
    -------
    Axis

    Raises
    ------
    ValueError
        Where the text describes none.
    """
    if ":" not in text:
        return Listed(target, tuple(number(word.strip()) for word in text.split(",")))
    *words, last = (word.strip() for word in text.split(":"))
    log = last == "log"
    words = words if log else [*words, last]
    if len(words) not in (2, 3) or "," in text:
        raise ValueError(
            f"axis {target!r} must be LOW:HIGH:N, LOW:HIGH (each with :log at the end if you like) or A,B,C, got {text!r}"
        )
    low, high = (number(word) for word in words[:2])
    if isinstance(low, str) or isinstance(high, str):
        raise ValueError(f"axis {target!r} has text values, which must be listed as A,B,C, got {text!r}")
    if len(words) == 2:
        return Ranged(target, low, high, log)
    _check_range(target, low, high, log)
    if not words[2].isdecimal() or int(words[2]) < 2:
        raise ValueError(f"axis {target!r}: N in LOW:HIGH:N must be a whole number of at least 2, got {words[2]!r}")
    spaced = (np.geomspace if log else np.linspace)(low, high, int(words[2]))
    return Listed(target, tuple(spaced.tolist()))


def _check_range(target: str, low: float, high: float, log: bool) -> None:
    if not low < high:
        raise ValueError(f"axis {target!r}: the range must not be empty, got {low:g} to {high:g}")
    if log and low <= 0.0:
        raise ValueError(f"axis {target!r}: a logarithmic range must begin above 0, got {low:g}")


def points(axes: Sequence[Axis], samples: int | None = None, seed: int = 0) -> list[Point]:
    """Every run's values: the grid of the listed axes, each point with all samples from the ranges.

    Parameters
    ----------
    axes
        All different.
    samples
        How many points a Latin hypercube draws from all ranges together; None without ranges.
    seed
        Of the Latin hypercube; the same seed draws the same points.

    Returns
    -------
    points
        Axis -> value, in the order of the axes.

    Raises
    ------
    ValueError
        Where an axis appears twice, or ranges and samples do not go together.

    References
    ----------
    McKay, Beckman, Conover, A comparison of three methods for selecting values of input variables (1979).
    """
    ranges = [axis for axis in axes if isinstance(axis, Ranged)]
    listed = [axis for axis in axes if isinstance(axis, Listed)]
    targets = [axis.target for axis in axes]
    for target in targets:
        if targets.count(target) > 1:
            raise ValueError(f"axis {target!r} must be given once, got it twice")
    if ranges and samples is None:
        raise ValueError(f"axis {ranges[0].target!r} is a range: say how many values (LOW:HIGH:N), or how many samples (--lhs N)")
    if samples is not None and not ranges:
        raise ValueError("a Latin hypercube must have a range LOW:HIGH to sample, has none")
    if samples is not None and samples < 1:
        raise ValueError(f"the number of samples must be at least 1, got {samples}")
    drawn: list[Point] = [{}]
    if samples is not None:
        from scipy.stats import qmc

        shares = qmc.LatinHypercube(len(ranges), seed=np.random.default_rng(seed)).random(samples)  # `rng` from scipy 1.15 on
        columns = [_scaled(axis, shares[:, j]) for j, axis in enumerate(ranges)]
        drawn = [{axis.target: column[i] for axis, column in zip(ranges, columns, strict=True)} for i in range(samples)]
    grid = [dict(zip((a.target for a in listed), values, strict=True)) for values in product(*(a.values for a in listed))]
    return [{target: (of_grid | of_draw)[target] for target in targets} for of_grid in grid for of_draw in drawn]


def _scaled(axis: Ranged, shares: np.ndarray) -> list[float]:
    if axis.log:
        return list((axis.low * (axis.high / axis.low) ** shares).tolist())
    return list((axis.low + (axis.high - axis.low) * shares).tolist())
