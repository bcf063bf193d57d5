"""An FMU alone as a system, with what its DefaultExperiment says, or a component that a TOML file describes."""

from math import floor, isfinite, log10
from pathlib import PurePath

from ..slaves.fmi.description import Description, load
from ..systems import System, SystemComponent

STEPS = 1000  # of a run whose step nobody states


def of_one_fmu(file: str) -> System:
    """The system of one FMU, named as its file.

    Parameters
    ----------
    file : str
        `FILE` or `ARCHIVE#MEMBER`.

    Returns
    -------
    System
        Its span and step as the FMU's DefaultExperiment says; else one second, and the FMU's fixed internal step or a round
        number of about a thousandth of the span, of which a note tells. A step is no shorter than the fixed internal one.

    Raises
    ------
    ValueError
        No FMU is there, or its numbers make no run.
    """
    description = load(file)
    name = PurePath(file.rpartition("#")[2]).name.removesuffix(".fmu")
    start = _number(description, "startTime")
    start = 0.0 if start is None else start
    stop = _number(description, "stopTime")
    stop = start + 1.0 if stop is None or stop <= start else stop
    step = _number(description, "stepSize")
    notes: tuple[str, ...] = ()
    fixed = description.own_step
    if (step is None or not fixed <= step <= stop - start) and 0.0 < fixed <= stop - start:
        step = fixed
    if step is not None and not 0.0 < step <= stop - start:
        step = None
    if step is None:
        step = _round((stop - start) / STEPS)
        notes = (f"{name} states no step size, which is {step:g} s where nobody gives one (--step)",)
    return System(name, (SystemComponent(name, file),), (), step=step, start=start, stop=stop, notes=notes)


def of_one_described(file: str, package: str) -> System:
    """The system of one component that a TOML file describes, called by its package ("vehicle"): 10 s in steps of 1 ms."""
    return System(PurePath(file).stem, (SystemComponent(package, file),), (), step=1e-3, stop=10.0)


def _number(description: Description, key: str) -> float | None:
    text = description.experiment.get(key)
    if text is None:
        return None
    value = float(text)
    if not isfinite(value):
        raise ValueError(f"FMU {description.file!r}: {key} of its DefaultExperiment must be finite, got {text!r}")
    return value


def _round(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `length`."""
    power = 10.0 ** floor(log10(length))
    return float(next(f"{digit * power:.0e}" for digit in (5, 2, 1) if digit * power <= length * (1 + 1e-9)))
