"""What a slave in another process is asked and told beyond numbers: texts, ticks of clocks, parameters on the way. Both ends."""

import json
import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..base import Clocked, Slave, Texting, Tunable, clocked, texting, tunable
from ..signal import Text, Value
from ..tick import Tick, carried_tick, read_tick
from .protocol import Kind, ProtocolError, array, document, numbers
from .telling import carried_values, number, read_values

__all__ = ["MESSAGES", "Messaging", "answered"]

MOST_TICKS = 100_000  # in one message


class Messaging(Clocked, Texting, Tunable):
    """The end that asks."""

    @abstractmethod
    def _ask(self, kind: Kind, payload: bytes = b"", t: float = 0.0) -> bytes:
        """The answer to a request at t (s)."""

    @abstractmethod
    def _malformed(self, what: str, how: str, t: float = 0.0) -> Exception:
        """What is raised where the answer to `what` breaks a rule."""

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        self._ask(Kind.TUNE, json.dumps({"values": carried_values(values), "t": t}).encode(), t)

    def texts(self, t: float) -> tuple[Text, ...]:
        try:
            told = read_values(document(self._ask(Kind.TEXTS, json.dumps({"t": t}).encode(), t)))
        except ProtocolError as error:
            raise self._malformed("texts", str(error), t) from None
        texts = {name: text for name, text in told.items() if isinstance(text, str | bytes)}
        names = [s.name for s in self.description.text_outputs]
        if list(texts) != names:
            raise self._malformed("texts", f"{', '.join(texts) or 'nothing'} is not {', '.join(names)}", t)
        return tuple(texts.values())

    def give_texts(self, texts: Mapping[str, Text], t: float) -> bool:
        content = self._ask(Kind.GIVE_TEXTS, json.dumps({"values": carried_values(texts), "t": t}).encode(), t)
        try:
            return bool(array(content, 1)[0])
        except ProtocolError as error:
            raise self._malformed("give_texts", str(error), t) from None

    def expect(self, ticks: Sequence[Tick]) -> None:
        self._ask(Kind.EXPECT, json.dumps({"ticks": [carried_tick(tick) for tick in ticks]}).encode())

    def take_ticks(self) -> Sequence[Tick]:
        content = self._ask(Kind.TAKE_TICKS)
        try:
            ticks = _ticks(document(content))
        except ValueError as error:
            raise self._malformed("take_ticks", str(error)) from None
        d = self.description
        texts, clocks = {s.name for s in d.text_outputs}, set(d.clock_outputs)
        if any(len(tick.y) != len(d.outputs) or set(tick.texts) != texts for tick in ticks):
            raise self._malformed("take_ticks", f"a tick must have {len(d.outputs)} outputs and {len(texts)} texts")
        if strange := {name for tick in ticks for name in tick.clocks} - clocks:
            raise self._malformed("take_ticks", f"{min(strange)!r} is no output clock")
        return ticks


def answered(slave: Slave, kind: Kind, payload: bytes) -> bytes:
    """The end that answers: what a request, one of MESSAGES, is answered with.

    Raises
    ------
    ValueError
        Where the slave does not have what the request is about. Nothing that was asked is believed.
    """
    return _ANSWERS[kind](slave, document(payload) if payload else {})


def _tune(slave: Slave, given: dict[str, Any]) -> bytes:
    able, values = tunable(slave), read_values(given.get("values"))
    for name in values:
        if able is None or name not in slave.description.tunable:
            raise ValueError(f"{name!r} must be a parameter that may change on the way")
    if able is not None and values:
        able.tune(slave.description.start_values(slave.name, values), number(given, "t"))
    return b""


def _texts(slave: Slave, given: dict[str, Any]) -> bytes:
    able, names = texting(slave), (signal.name for signal in slave.description.text_outputs)
    texts = () if able is None else able.texts(number(given, "t"))
    return json.dumps(carried_values(dict(zip(names, texts, strict=True)))).encode()


def _give_texts(slave: Slave, given: dict[str, Any]) -> bytes:
    able, texts = texting(slave), read_values(given.get("values"))
    told = _believed(slave, texts)
    return numbers(able is not None and able.give_texts(told, number(given, "t")))


def _expect(slave: Slave, given: dict[str, Any]) -> bytes:
    able, ticks, d = clocked(slave), _ticks(given), slave.description
    for tick in ticks:
        if strange := set(tick.clocks) - set(d.clock_inputs):
            raise ValueError(f"{min(strange)!r} must be an input clock")
        if not all(0 <= place < len(d.inputs) for place, _ in tick.u):
            raise ValueError(f"a tick must tell of inputs 0 to {len(d.inputs) - 1}")
        _believed(slave, tick.texts)
    if able is not None and ticks:
        able.expect(ticks)
    return b""


def _take_ticks(slave: Slave, given: dict[str, Any]) -> bytes:
    able = clocked(slave)
    return json.dumps({"ticks": [] if able is None else [carried_tick(tick) for tick in able.take_ticks()]}).encode()


_ANSWERS: dict[Kind, Callable[[Slave, dict[str, Any]], bytes]] = {
    Kind.TUNE: _tune, Kind.TEXTS: _texts, Kind.GIVE_TEXTS: _give_texts, Kind.EXPECT: _expect, Kind.TAKE_TICKS: _take_ticks,
}  # fmt: skip
MESSAGES = frozenset(_ANSWERS)


def _ticks(told: Mapping[str, Any]) -> list[Tick]:
    """The ticks of a message; ValueError where there are none, or too many, or not of finite numbers."""
    listed = told.get("ticks")
    if not isinstance(listed, list) or len(listed) > MOST_TICKS:
        raise ValueError(f"ticks must be a list of at most {MOST_TICKS}")
    ticks = [read_tick(one) for one in listed]
    for tick in ticks:
        if not all(map(math.isfinite, (tick.t, *tick.y, *(value for _, value in tick.u)))):
            raise ValueError("a tick must have finite numbers")
    return ticks


def _believed(slave: Slave, texts: Mapping[str, Any]) -> dict[str, Text]:
    """Text inputs by name, each of its own type."""
    types = {s.name: bytes if s.type == "binary" else str for s in slave.description.text_inputs}
    for name, text in texts.items():
        if name not in types or not isinstance(text, types[name]):
            raise ValueError(f"{name!r} must be a text input, and {getattr(types.get(name), '__name__', 'no')} its value")
    return dict(texts)
