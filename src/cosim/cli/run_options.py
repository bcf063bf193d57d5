"""What some options of `cosim run` ask for, checked."""

from ..hil.realtime import Pacer
from .settings import assignment


def pacer_of(step: float, steps: int, overrun: str, priority: int, adaptive: float | None) -> Pacer:
    """What --realtime, --overrun and --priority ask for."""
    if adaptive is not None:
        raise ValueError("--realtime needs an even macro step, not --adaptive")
    return Pacer(step, steps=steps, overrun=overrun, priority=priority)  # type: ignore[arg-type]


def one_of(option: str, given: str | None, known: tuple[str, ...]) -> None:
    """Refuse a misspelt value, whether the option has an effect or not."""
    if given is not None and given not in known:
        raise ValueError(f"{option} must be one of {', '.join(known)}, got {given!r}")


def substeps_of(given: list[str] | None) -> dict[str, int]:
    rule, numbers = "--substeps must be COMPONENT=N", {}
    for text in given or ():
        name, number = assignment(text, rule)
        if not number.isdecimal():
            raise ValueError(f"{rule}, got {text!r}")
        numbers[name] = int(number)
    return numbers
