"""A gyro unit as a hardware-in-the-loop rig sees it: any variant behind sensors, transport and a yaw table. SI units.

    frame's rates -> rate sensor -> transport -> yaw table -> gyro unit -> moment sensor -> transport -> moments on the frame

Sensor (rate, moment; every axis):  f' = 2 pi b (u - f),  m = q round((f + bias + sigma n) / q)          (1)
    every period the newest m is held; where a sample is lost the one before it stays.
Transport: what was recorded a delay d ago. The record has one entry a tick (T); a held signal is delayed by whole ticks and, for
    the rest r T, mixed as (1 - r) newer + r older, which has the true mean over the tick; an unsampled signal is interpolated.
Yaw table:  w' = clip(2 pi b_t (clip(r, +- w_max) - w), +- a_max)                                         (2)
    a rig turns about one axis: roll and pitch come through ideally, or not at all (`table_tilts`).

Every effect has its own parameter and 0 turns it off, alone or with others (without a bandwidth the acceleration limit follows
within about a tick). With all off the rates reach the gyro unit, and its moments the frame, without passing anything: bit for
bit the bare gyro unit. A sampled signal stands, at a communication point, as it was before that instant's sample: reading it
costs one tick, as with an A/D converter.

A period that is no multiple of the tick is kept in the mean, a tick early or late; one below the tick is the tick.
Noise and drop-outs come from noise.py: seeded, the same in process and in the FMU.
Source: our own choice of effects. The moments that a rig returns are no longer passive: `cosim compare` measures by how much.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, output, state

from .mount import CONNECTOR
from .noise import Stream
from .nonlinear import nonlinear_full, nonlinear_small
from .rig_parameters import RIG_FULL, RIG_SMALL
from .transport import Transport

__all__ = ["AXES", "LONGEST_DELAY", "TICK", "WAYS", "behind_rig", "full", "small"]

AXES = ("yaw", "roll", "pitch")
WAYS = ("rate", "moment")
TICK = 1e-3  # s
LONGEST_DELAY = 0.025  # s, each way

EQUATIONS = """\
rates -> rate sensor -> transport -> yaw table -> gyro unit -> moment sensor -> transport -> moments
sensor:  f' = 2 pi b (u - f),   m = q round((f + bias + sigma n) / q), held for a period, or longer where samples are lost     (1)
table:   w' = clip(2 pi b_t (clip(r, +-w_max) - w), +-a_max)                                                             (2)
the gyro unit inside:
"""

Symbols = dict[str, ca.SX]


@dataclass(frozen=True)
class _Way:
    """The channels of one way: "rate" or "moment"."""

    name: str
    transport: Transport

    def states(self) -> tuple[Variable, ...]:
        """Per axis: the sensor's lag, its noise of this tick, and the record; for all axes together whether the tick is lost."""
        rows: list[Variable] = [
            state(f"{self.name}_lost", "1", f"1 where this tick's {self.name} sample is lost", discrete=True, source="rig")
        ]
        unit = {v.name: v.unit for v in CONNECTOR}[f"yaw_{self.name}"]
        for axis in AXES:
            signal = f"{axis}_{self.name}"
            rows += [
                state(f"{signal}_filtered", unit, f"{signal} behind the sensor's lag", source="rig"),
                state(f"{signal}_noise_now", "1", f"noise of the {signal} sensor over its standard deviation", discrete=True,
                      source="rig"),
                *self.transport.states(signal, unit),
            ]  # fmt: skip
        return tuple(rows)

    def lag(self, s: Symbols, present: Sequence[ca.SX]) -> dict[str, ca.SX]:
        """Derivatives of the sensors' lags under the present true signals."""
        b = s[f"{self.name}_bandwidth"]
        return {f"{a}_{self.name}_filtered": ca.if_else(b > 0, 2 * pi * b * (u - s[f"{a}_{self.name}_filtered"]), 0)
                for a, u in zip(AXES, present, strict=True)}  # fmt: skip

    def measured(self, s: Symbols, present: Sequence[ca.SX]) -> list[ca.SX]:
        """(1): what the sensors say now, per axis."""
        b, q = s[f"{self.name}_bandwidth"], s[f"{self.name}_quantisation"]
        result = []
        for axis, u in zip(AXES, present, strict=True):
            signal = f"{axis}_{self.name}"
            f = ca.if_else(b > 0, s[f"{signal}_filtered"], u)
            m = f + s[f"{self.name}_bias"] + s[f"{self.name}_noise"] * s[f"{signal}_noise_now"]
            step = ca.if_else(q > 0, q, 1)
            result.append(ca.if_else(q > 0, step * ca.floor(m / step + 0.5), m))
        return result

    def received(self, s: Symbols, present: Sequence[ca.SX]) -> list[ca.SX]:
        """What arrives at the other end now, per axis."""
        return [
            self.transport.received(
                s, f"{axis}_{self.name}", m, delay=s[f"{self.name}_delay"],
                sampled=s[f"{self.name}_sampling_period"] > 0, lost=s[f"{self.name}_lost"], phase=s["phase"],
            )
            for axis, m in zip(AXES, self.measured(s, present), strict=True)
        ]  # fmt: skip

    def draw(self, s: Symbols) -> Symbols:
        """Noise and loss of the tick that begins."""
        numbers = Stream(s["seed"], WAYS.index(self.name), s["tick"])
        drawn = {f"{axis}_{self.name}_noise_now": numbers.normal() for axis in AXES}
        return drawn | {f"{self.name}_lost": ca.if_else(numbers.uniform() < s["dropout_rate"], 1, 0)}

    def record(self, s: Symbols, present: Sequence[ca.SX]) -> Symbols:
        """The records after the tick's sample, with noise and loss of this tick already in `s`."""
        period, n = s[f"{self.name}_sampling_period"], s["tick"]
        T = ca.if_else(period > self.transport.tick, period, self.transport.tick)

        def count(k: ca.SX) -> ca.SX:
            return ca.floor(k * self.transport.tick / T + 1e-6)  # 1e-6: 3 ticks of 1 ms are 3 ms, whatever their rounding

        keep = ca.if_else(ca.logic_or(s[f"{self.name}_lost"] > 0, count(n) <= count(n - 1)), 1, 0)
        changed: Symbols = {}
        whole = self.transport.whole(s[f"{self.name}_delay"])
        for axis, m in zip(AXES, self.measured(s, present), strict=True):
            changed |= self.transport.record(s, f"{axis}_{self.name}", m, keep, whole)
        return changed


class _Rig:
    """The gyro unit inside and what stands around it, as functions of the symbols."""

    def __init__(self, plant: Component, transport: Transport) -> None:
        self.plant = plant
        self.rate, self.moment = (_Way(name, transport) for name in WAYS)

    def _plant(self, s: Symbols, function: ca.Function, rates: dict[str, ca.SX]) -> dict[str, ca.SX]:
        """The plant's rhs or output under the rates that the table imposes, by name."""
        x, p = (ca.vertcat(ca.SX(0, 1), *(s[v.name] for v in rows)) for rows in (self.plant.states, self.plant.parameters))
        u = ca.vertcat(*(rates[v.name] for v in self.plant.inputs))
        rows = self.plant.states if function is self.plant.rhs else self.plant.outputs
        values = function(x, u, p)
        return {v.name: values[i] for i, v in enumerate(rows)}

    def table(self, s: Symbols) -> tuple[dict[str, ca.SX], ca.SX]:
        """(2): the rates that the gyro unit feels, and the derivative of the table's own rate."""
        yaw, roll, pitch = self.rate.received(s, [s[f"{axis}_rate"] for axis in AXES])
        w_max, b, a_max = s["table_rate_limit"], s["table_bandwidth"], s["table_acceleration_limit"]
        r = ca.if_else(w_max > 0, ca.fmax(-w_max, ca.fmin(w_max, yaw)), yaw)
        moving = ca.logic_or(b > 0, a_max > 0)
        wanted = ca.if_else(b > 0, 2 * pi * b, 1 / self.rate.transport.tick) * (r - s["table_rate"])
        rate_dot = ca.if_else(a_max > 0, ca.fmax(-a_max, ca.fmin(a_max, wanted)), wanted)
        tilts = s["table_tilts"]
        rates = {
            "yaw_rate": ca.if_else(moving, s["table_rate"], r),
            "roll_rate": ca.if_else(tilts >= 1, roll, tilts * roll),
            "pitch_rate": ca.if_else(tilts >= 1, pitch, tilts * pitch),
        }
        return rates, ca.if_else(moving, rate_dot, 0)

    def motion(self, s: Symbols) -> tuple[dict[str, Any], dict[str, Any]]:
        """State derivatives and outputs."""
        rates, table_dot = self.table(s)
        outputs = self._plant(s, self.plant.output, rates)
        moments = [outputs[f"{axis}_moment"] for axis in AXES]
        derivatives = self._plant(s, self.plant.rhs, rates) | {"table_rate": table_dot, "phase": 1}
        derivatives |= self.rate.lag(s, [s[f"{axis}_rate"] for axis in AXES]) | self.moment.lag(s, moments)
        received = dict(zip((f"{axis}_moment" for axis in AXES), self.moment.received(s, moments), strict=True))
        return derivatives, outputs | received | {"unit_yaw_rate": rates["yaw_rate"], "unit_yaw_moment": moments[0]}

    def sample(self, s: Symbols) -> dict[str, Any]:
        """A tick: draw, record the rates, and with what then reaches the gyro unit the moments."""
        changed: Symbols = {"phase": ca.SX(0)} | self.rate.draw(s) | self.moment.draw(s)
        changed |= self.rate.record(s | changed, [s[f"{axis}_rate"] for axis in AXES])
        after = s | changed
        rates, _ = self.table(after)
        outputs = self._plant(s, self.plant.output, rates)
        changed |= self.moment.record(after, [outputs[f"{axis}_moment"] for axis in AXES])
        return changed | {"tick": s["tick"] + 1}


def behind_rig(plant: Component, *, variant: str = "hil", rig: Sequence[Variable] = RIG_SMALL, tick: float = TICK,
        longest_delay: float = LONGEST_DELAY) -> Component:  # fmt: skip
    """Put a gyro unit behind a test rig.

    Parameters
    ----------
    plant : Component
        The gyro unit on the rig, with the connector of the mount.
    variant : str
        What the result is called.
    rig : sequence of Variable
        Parameters of the rig, such as RIG_SMALL or RIG_FULL of `gyro_unit.rig_parameters`.
    tick : float
        Time (s) between the entries of the rig's records: sampling, noise and drop-outs go by it.
    longest_delay : float
        What the records hold each way (s); each tick of it costs six states.

    Returns
    -------
    Component
        A component with the plant's connector and variables, and the rig's.

    Raises
    ------
    ValueError
        If the plant lacks the connector or has a sampled part of its own, or tick or delay are out of range.
    """
    known = {v.name: v.causality for v in plant.variables}
    for row in CONNECTOR:
        if known.get(row.name) != row.causality:
            raise ValueError(f"plant {plant.spec!r} must have the {row.causality} {row.name!r} of the gyro mount")
    if plant.sample is not None:
        raise ValueError(f"plant {plant.spec!r} must have no sampled part of its own")
    transport = Transport(tick, longest_delay)
    machine = _Rig(plant, transport)
    table = [replace(v, max=transport.longest) if v.name.endswith("_delay") else v for v in rig]
    rows = (
        *plant.variables,
        output("unit_yaw_rate", "rad/s", "yaw rate that the gyro unit on the table feels", nominal=1.0),
        output("unit_yaw_moment", "N.m", "yaw moment of the gyro unit on the table, true and now", nominal=0.01),
        state("tick", "1", "ticks done", discrete=True, source="rig"),
        state("phase", "s", "time since the last tick", source="rig"),
        state("table_rate", "rad/s", "rate of the yaw table", source="rig"),
        *machine.rate.states(),
        *machine.moment.states(),
        *table,
    )
    return build(
        scene=plant.scene, name=plant.name, variant=variant, description=f"Test rig around: {plant.description}",
        equations=EQUATIONS + plant.equations, variables=rows, model=machine.motion, sample=machine.sample, sample_period=tick,
        internal_step=min(plant.internal_step, tick), method=plant.method, bonds=plant.bonds,
    )  # fmt: skip


def small() -> Component:
    """Make the nonlinear gyro unit with Table 1's numbers on a table-top rig.

    Returns
    -------
    Component
        The component `gyro_unit:hil`.
    """
    return behind_rig(nonlinear_small())


def full() -> Component:
    """Make the nonlinear gyro unit with Table 2's numbers on a full-size rig.

    Returns
    -------
    Component
        The component `gyro_unit:hil_full`.
    """
    return behind_rig(nonlinear_full(), variant="hil_full", rig=RIG_FULL)
