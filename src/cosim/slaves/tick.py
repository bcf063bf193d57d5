"""Ticks of clocks on their way from one slave to another, also as JSON."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .signal import Text


@dataclass(frozen=True)
class Tick:
    """Clocks of one slave that tick together at t (s).

    Told by a slave: clocks are outputs of it, y are all its outputs there, texts its text outputs by name.
    Told to a slave: clocks are inputs of it, u and texts the inputs that change with them, by place in u and by name.
    """

    t: float
    clocks: tuple[str, ...]
    y: tuple[float, ...] = ()
    u: tuple[tuple[int, float], ...] = ()
    texts: Mapping[str, Text] = field(default_factory=dict)


def carried_tick(tick: Tick) -> list[Any]:
    """A tick for JSON: bytes as hexadecimal digits in a list of their own."""
    texts = {name: text if isinstance(text, str) else [text.hex()] for name, text in tick.texts.items()}
    return [tick.t, list(tick.clocks), list(tick.y), [list(pair) for pair in tick.u], texts]


def read_tick(told: Any) -> Tick:
    """The tick in what carried_tick() gave; ValueError where there is none."""
    try:
        t, clocks, y, u, texts = told
        return Tick(
            float(t), tuple(map(str, clocks)), tuple(map(float, y)), tuple((int(j), float(value)) for j, value in u),
            {str(name): text if isinstance(text, str) else bytes.fromhex(text[0]) for name, text in texts.items()},
        )  # fmt: skip
    except (TypeError, AttributeError, IndexError, OverflowError) as error:
        raise ValueError(f"no tick: {error}") from None
