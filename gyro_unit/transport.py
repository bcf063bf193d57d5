"""A transport delay in a component: a record with one entry a tick, and what is read from it. See hil.py for the meaning."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from gyro_cosim.component import Variable, state

__all__ = ["Transport"]


@dataclass(frozen=True)
class Transport:
    """Records for delays of up to a longest one, rounded up to whole ticks.

    For a signal S the record is S_record[0], [1], ...: the entries of this tick and of those before it; S_newer, S_at and
    S_older are the entries around the delay, picked once a tick so that reading costs nothing in between.

    Attributes
    ----------
    tick : float
        Time (s) between two entries.
    longest_wanted : float
        Delay (s) that must be possible; `longest` is it in whole ticks.

    Raises
    ------
    ValueError
        If the tick is not positive or the delay negative.
    """

    tick: float
    longest_wanted: float

    def __post_init__(self) -> None:
        if not self.tick > 0.0:
            raise ValueError(f"`tick` must be positive, got {self.tick:g} s")
        if not self.longest_wanted >= 0.0:
            raise ValueError(f"`longest_delay` must not be negative, got {self.longest_wanted:g} s")

    @property
    def ticks(self) -> int:
        """The longest delay in ticks."""
        return max(1, round(self.longest_wanted / self.tick + 0.4999))

    @property
    def longest(self) -> float:
        """The longest delay in s."""
        return self.ticks * self.tick

    def states(self, signal: str, unit: str) -> list[Variable]:
        """The rows of one signal; the record has an entry more than the longest delay, to interpolate with."""
        rows = [(f"{signal}_record[{k}]", f"recorded {k} ticks ago") for k in range(self.ticks + 2)]
        rows += [(f"{signal}_{pick}", f"{pick} end of the delay") for pick in ("newer", "at", "older")]
        return [state(name, unit, f"{signal} {what}", discrete=True, source="rig") for name, what in rows]

    def record(self, s: dict[str, ca.SX], signal: str, m: ca.SX, keep: ca.SX, whole: Sequence[ca.SX]) -> dict[str, ca.SX]:
        """The record after a tick: `m`, or with `keep` the entry before once more; and the entries around the delay."""
        old = [s[f"{signal}_record[{k}]"] for k in range(self.ticks + 2)]
        new = [ca.if_else(keep, old[0], m), *old[:-1]]
        changed = {f"{signal}_record[{i}]": entry for i, entry in enumerate(new)}
        for pick, offset in (("newer", -1), ("at", 0), ("older", 1)):
            pairs = [(flag, new[k + offset]) for k, flag in enumerate(whole) if 0 <= k + offset < len(new)]
            changed[f"{signal}_{pick}"] = sum((ca.if_else(flag, entry, 0) for flag, entry in pairs), ca.SX(0))
        return changed

    def whole(self, delay: ca.SX) -> list[ca.SX]:
        """For k = 0, 1, ... whether `delay` (s) is k whole ticks and a rest."""
        k = ca.floor(delay / self.tick + 1e-9)
        return [k == i for i in range(self.ticks + 1)]

    def received(
        self, s: dict[str, ca.SX], signal: str, m: ca.SX, *, delay: ca.SX, sampled: ca.SX, lost: ca.SX, phase: ca.SX
    ) -> ca.SX:
        """The signal as it arrives, `m` being what is sent now and `phase` (s) the time since the tick."""
        newer, at, older = (s[f"{signal}_{pick}"] for pick in ("newer", "at", "older"))
        k = ca.floor(delay / self.tick + 1e-9)
        rest = ca.fmax(0, delay / self.tick - k)
        held = at + rest * (older - at)
        r = rest - phase / self.tick  # how much older than the entry `at`, in ticks; negative: newer
        now = ca.if_else(lost > 0, at, m)
        share = ca.if_else(phase > 0, -r * self.tick / ca.fmax(phase, 1e-300), 0)
        towards_newer = ca.if_else(k > 0, at - r * (newer - at), at + share * (now - at))
        continuous = ca.if_else(r >= 0, at + r * (older - at), towards_newer)
        return ca.if_else(sampled, held, ca.if_else(delay > 0, continuous, now))
