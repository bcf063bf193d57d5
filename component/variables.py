"""One row of a component's table of variables."""

import math
import re
from dataclasses import dataclass
from typing import Literal

from .units import compatible, unit

__all__ = ["BALANCE", "Causality", "Variability", "Variable", "input_", "output", "parameter", "state"]

Causality = Literal["parameter", "input", "output", "local"]
Variability = Literal["fixed", "tunable", "discrete", "continuous"]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\[\d+\])?")

# Outputs of a component that reports its energy: what it stores (J), turns into heat (W) and, where it has a motor, is fed (W).
BALANCE = ("stored_energy", "dissipated_power", "motor_power")


@dataclass(frozen=True, kw_only=True)
class Variable:
    """A named scalar signal, state or parameter. Made by `parameter`, `input_`, `output` and `state`.

    Attributes
    ----------
    name : str
        A C identifier, perhaps with an index: "yaw_rate", "record[3]".
    causality, variability : str
        As FMI defines them.
    unit : str
        An SI unit as FMI writes it, such as "N.m.s/rad"; "1" for a pure number. All numbers below are in it.
    start : float
        The value at the start.
    meaning : str
        What it is, in a few words.
    symbol : str
        What the source calls it; inside physics the code does too.
    source : str
        Where a parameter's value comes from, such as "Table 1"; empty for signals.
    assumed : tuple of two floats, optional
        Range of a value that is not given in the source; None where the source states the value.
    min, max, nominal : float, optional
        Bounds, and the size that is usual.
    display_unit : str, optional
        The unit in which people like to read it.
    is_state : bool
        Whether the variable is an element of x. A state may be an output as well.

    Raises
    ------
    ValueError
        If no FMU could carry the row. The message names row, rule and value.
    """

    name: str
    causality: Causality
    variability: Variability
    unit: str
    start: float
    meaning: str
    symbol: str = ""
    source: str = ""
    assumed: tuple[float, float] | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    display_unit: str | None = None
    is_state: bool = False

    def __post_init__(self) -> None:
        """Refuse a row that no FMU could carry, naming the row, the rule and the value."""
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"variable name must be a C identifier, perhaps with [index], got {self.name!r}")
        if not self.unit:
            raise ValueError(f"variable {self.name!r} must have a unit ('1' for a pure number), got none")
        try:
            factor = unit(self.unit).factor
        except ValueError as error:
            raise ValueError(f"variable {self.name!r}: {error}") from None
        if factor != 1.0:
            raise ValueError(f"variable {self.name!r} must be in an SI unit, got {self.unit!r}")
        if self.display_unit is not None and not compatible(self.display_unit, self.unit):
            raise ValueError(f"variable {self.name!r}: display unit {self.display_unit!r} does not fit {self.unit!r}")
        if not self.meaning:
            raise ValueError(f"variable {self.name!r} must have a meaning, got none")
        for rule, value in (("start", self.start), ("min", self.min), ("max", self.max), ("nominal", self.nominal)):
            if value is not None and not math.isfinite(value):
                raise ValueError(f"variable {self.name!r}: {rule} must be finite, got {value!r}")
        for low, high, rule in (
            (self.min, self.start, "start must be at least min"),
            (self.start, self.max, "start must be at most max"),
            (self.min, self.max, "min must be at most max"),
        ):
            if low is not None and high is not None and low > high:
                raise ValueError(f"variable {self.name!r}: {rule}, got {low!r} > {high!r}")
        if self.assumed is not None and not self.assumed[0] <= self.start <= self.assumed[1]:
            raise ValueError(f"variable {self.name!r}: start must lie in its assumed range {self.assumed}, got {self.start!r}")

    def check(self, value: float) -> float:
        """Refuse a value that the variable must not have.

        Parameters
        ----------
        value : float
            In the variable's unit.

        Returns
        -------
        float
            `value`.

        Raises
        ------
        ValueError
            If it is not finite or not within min and max. The message names variable, rule and value.
        """
        if not math.isfinite(value):
            raise ValueError(f"{self.name} must be finite, got {value!r}")
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.min is not None and value < self.min:
            raise ValueError(f"{self.name} must be at least {self.min:g}{unit}, got {value:g}")
        if self.max is not None and value > self.max:
            raise ValueError(f"{self.name} must be at most {self.max:g}{unit}, got {value:g}")
        return value


def parameter(
    name: str,
    start: float,
    unit: str,
    meaning: str,
    *,
    symbol: str = "",
    source: str,
    assumed: tuple[float, float] | None = None,
    min: float | None = None,
    max: float | None = None,
    nominal: float | None = None,
    display_unit: str | None = None,
    tunable: bool = True,
) -> Variable:
    """Make a parameter: an element of p. Each states where its value comes from.

    Parameters
    ----------
    name, start, unit, meaning, symbol, source, assumed, min, max, nominal, display_unit
        As in `Variable`.
    tunable : bool
        Whether it may change between macro steps; else it is fixed at the start.

    Returns
    -------
    Variable
        The row. ValueError as `Variable`.
    """
    return Variable(
        name=name, causality="parameter", variability="tunable" if tunable else "fixed", unit=unit, start=start,
        meaning=meaning, symbol=symbol, source=source, assumed=assumed, min=min, max=max, nominal=nominal,
        display_unit=display_unit,
    )  # fmt: skip


def input_(name: str, unit: str, meaning: str, *, symbol: str = "", start: float = 0.0, nominal: float | None = None) -> Variable:
    """Make a continuous input: an element of u.

    Parameters
    ----------
    name, unit, meaning, symbol, start, nominal
        As in `Variable`.

    Returns
    -------
    Variable
        The row. ValueError as `Variable`.
    """
    return Variable(
        name=name, causality="input", variability="continuous", unit=unit, start=start, meaning=meaning,
        symbol=symbol, nominal=nominal,
    )  # fmt: skip


def output(name: str, unit: str, meaning: str, *, symbol: str = "", nominal: float | None = None) -> Variable:
    """Make an output that the model computes, its start value too: an element of y.

    Parameters
    ----------
    name, unit, meaning, symbol, nominal
        As in `Variable`.

    Returns
    -------
    Variable
        The row. ValueError as `Variable`.
    """
    return Variable(
        name=name, causality="output", variability="continuous", unit=unit, start=0.0, meaning=meaning,
        symbol=symbol, nominal=nominal,
    )  # fmt: skip


def state(
    name: str,
    unit: str,
    meaning: str,
    *,
    symbol: str = "",
    start: float = 0.0,
    source: str = "",
    assumed: tuple[float, float] | None = None,
    is_output: bool = False,
    discrete: bool = False,
    min: float | None = None,
    max: float | None = None,
    nominal: float | None = None,
    display_unit: str | None = None,
) -> Variable:
    """Make a state: an element of x.

    Parameters
    ----------
    name, unit, meaning, symbol, start, source, assumed, min, max, nominal, display_unit
        As in `Variable`.
    is_output : bool
        Whether it is an element of y as well.
    discrete : bool
        Whether only samples change it.

    Returns
    -------
    Variable
        The row. ValueError as `Variable`.
    """
    return Variable(
        name=name, causality="output" if is_output else "local", variability="discrete" if discrete else "continuous",
        unit=unit, start=start, meaning=meaning, symbol=symbol, source=source, assumed=assumed, min=min, max=max,
        nominal=nominal, display_unit=display_unit, is_state=True,
    )  # fmt: skip
