"""The plan of a sweep: which runs there are, what identifies each, and what is kept of it. It runs nothing.

A run is identified by a hash of all that decides its result: contents of the FMUs, wiring, values, algorithm, degree, step and
length. Files keep rows by that key, so a sweep that is stopped and started again repeats nothing.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

from ..coupling import Algorithm, algorithm
from ..master import macro_steps
from ..systems import System, archive, catalogue
from ..systems.riding import held_with
from .axes import Axis, Listed, Point, Value, parse, points
from .measure import Measure
from .query import MEASURES, SystemQuery

CHOICES = ("algorithm", "degree", "step")  # axes that are no variable of a component; a component's name is its variant
CASE = "case"  # the axis of named sets of values
FIXED = ("status", "error", "ended_by", "steps", "t_end", "wall_s", "energy_residual", "energy_exchanged")
TEXT = ("run", "status", "error", "ended_by")
UNITS = {"energy_residual": "J", "energy_exchanged": "J", "t_end": "s", "wall_s": "s", "step": "s"}


@dataclass(frozen=True)
class SweepContext:
    """What all runs of a sweep share; small, so that it goes to every worker.

    Parameters
    ----------
    system
        The sources of its components are keys of FMU files, as are the values of `variants`.
    variants
        Component (or what addresses several) -> variant -> component -> key of its FMU.
    defaults, stop
        The values of those CHOICES that are no axis, and the end of every run (s).
    signals, measure
        Whose measures are kept, and the user's own or None.
    cases
        Case -> `component.parameter` -> value.
    riding
        Variant of each target -> component -> parameter -> value: what of the units' inertia its carrier holds.
    """

    system: System
    variants: Mapping[str, Mapping[str, Mapping[str, str]]]
    defaults: Mapping[str, Value]
    stop: float
    signals: tuple[str, ...]
    cases: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    measure: Measure | None = None
    riding: Mapping[tuple[str, ...], Mapping[str, Mapping[str, float]]] = field(default_factory=dict)

    @property
    def measured(self) -> tuple[str, ...]:
        """The columns of what is measured of a run: of its signals, then by the user's measure."""
        extra = tuple(self.measure.columns) if self.measure is not None else ()
        return (*(f"{signal}.{measure}" for signal in self.signals for measure in MEASURES), *extra)

    def system_at(self, point: Point, files: Mapping[str, str]) -> System:
        """The system of one run, with the FMUs where this machine has them (gyro_cosim.systems.archive writes locations so)."""
        system = self.system
        values = self.cases[str(point[CASE])] if self.cases else {}
        for target, value in (*values.items(), *point.items()):
            if target not in CHOICES and target not in self.variants and target != CASE:
                system = system.with_value(target, value)
        chosen = {n: key for t, of in self.variants.items() for n, key in of[str(point[t])].items()}
        held = self.held_at(point)
        parts = tuple(
            replace(p, source=files[chosen.get(p.name, p.source)], bound={**p.bound, **held.get(p.name, {})})
            for p in system.components
        )
        return replace(system, components=parts)

    def held_at(self, point: Point) -> Mapping[str, Mapping[str, float]]:
        """What the carriers of one run's units hold of their inertia: component -> parameter -> value (kg m2)."""
        return self.riding.get(tuple(str(point[target]) for target in self.variants), {})

    def algorithm_at(self, point: Point) -> Algorithm:
        """The coupling algorithm of one run."""
        chosen = {**self.defaults, **point}
        return algorithm(str(chosen["algorithm"]), int(chosen["degree"]))

    def step_at(self, point: Point) -> float:
        """The macro step of one run, s."""
        return float({**self.defaults, **point}["step"])


@dataclass(frozen=True)
class Plan:
    """A sweep, ready to run.

    Parameters
    ----------
    context
        What its runs share.
    axes
        In the order of the columns.
    runs
        Key -> values of the axes.
    files
        Key of an FMU -> its location.
    units
        Column -> unit, where it has one.
    definition
        What the file says of the sweep, as JSON; equal for equal sweeps.
    """

    context: SweepContext
    axes: tuple[Axis, ...]
    runs: Mapping[str, Point]
    files: Mapping[str, str]
    units: Mapping[str, str]
    definition: Mapping[str, Any]

    @property
    def columns(self) -> tuple[str, ...]:
        """Of a row: its key, the axes, what became of the run, and the measures of the signals."""
        return ("run", *(axis.target for axis in self.axes), *FIXED, *self.context.measured)

    @property
    def text_columns(self) -> tuple[str, ...]:
        """Those whose values are text."""
        named = (a.target for a in self.axes if isinstance(a, Listed) and any(isinstance(v, str) for v in a.values))
        return (*TEXT, *named)


@dataclass(frozen=True)
class Sweep:
    """What a sweep does, in the words of the command line.

    Parameters
    ----------
    system
        Of which all runs are.
    values
        `component.parameter` -> one value, or an axis as gyro_cosim.sweeps.axes describes it.
    variants
        Component -> its variants, such as {"gyro": ("linear", "nonlinear")}.
    algorithms, degrees, steps
        Coupling algorithms, degrees of extrapolation and macro steps (s), one or several each.
    stop
        End of every run, s; the system's where None.
    samples, seed
        Of the Latin hypercube over the ranges among `values`.
    signals
        Shell patterns; empty for all outputs.
    cases
        Name -> values that are set together, `component.parameter` -> value: an axis `case` of the names.
    measure
        Numbers of the user's from each run's trajectory.
    """

    system: System
    values: Mapping[str, str] = field(default_factory=dict)
    variants: Mapping[str, Sequence[str]] = field(default_factory=dict)
    algorithms: Sequence[str] = ("jacobi",)
    degrees: Sequence[int] = (1,)
    steps: Sequence[float] = ()
    stop: float | None = None
    samples: int | None = None
    seed: int = 0
    signals: Sequence[str] = ()
    cases: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    measure: Measure | None = None

    def plan(self) -> Plan:
        """Check it all against the components themselves, and list the runs; ValueError for wrong use."""
        stop = self.system.stop if self.stop is None else self.stop
        steps = self.steps or (self.system.step,)
        for h in steps:
            macro_steps(h, stop, self.system.start)
        for name in self.algorithms:
            for degree in self.degrees:
                algorithm(name, degree)
        with SystemQuery(self.system, self.variants) as components:
            axes = [parse(target, text, partial(components.value, target)) for target, text in self.values.items()]
            for axis in axes:
                for value in axis.values if isinstance(axis, Listed) else ():
                    components.value(axis.target, value)
            _check_cases(self.cases, set(self.values), self.variants)
            cases = {name: {t: components.value(t, v) for t, v in values.items()} for name, values in self.cases.items()}
            signals, units = components.signals(self.signals), dict(components.units)
        for target in {target for values in cases.values() for target in values}:
            del units[target]  # no column
        listed: dict[str, tuple[Value, ...]] = {t: tuple(v) for t, v in self.variants.items()}
        if cases:
            listed[CASE] = tuple(cases)
        choices: dict[str, tuple[Value, ...]] = {
            "algorithm": tuple(self.algorithms),
            "degree": tuple(map(float, self.degrees)),
            "step": tuple(steps),
        }
        fixed = {a.target: a.values[0] for a in axes if isinstance(a, Listed) and len(a.values) == 1}
        kept: list[Axis] = [Listed(t, v) for t, v in (listed | choices).items() if t in listed or len(v) > 1]
        kept += [axis for axis in axes if axis.target not in fixed]
        system = self.system
        for target, value in fixed.items():
            system = system.with_value(target, value)
        context, files = _context(system, self.variants, {c: v[0] for c, v in choices.items() if len(v) == 1}, stop, signals)
        context = replace(context, cases=cases, measure=self.measure, riding=held_with(system, self.variants))
        if not kept:
            raise ValueError("a sweep must have an axis, has none: say --set COMPONENT.PARAMETER=LOW:HIGH:N")
        base = {
            "parts": {p.name: [p.source, {**p.bound, **p.values}] for p in context.system.components},
            "connections": [asdict(connection) for connection in system.connections],
            "bonds": [asdict(bond) for bond in system.bonds],
            "defaults": dict(context.defaults),
            "stop": stop,
            "stop_when": [asdict(condition) for condition in system.stop_when],
            "signals": list(signals),
        }
        if system.start:
            base["start"] = system.start
        if system.tolerance is not None:
            base["tolerance"] = system.tolerance
        base |= _driven(system)
        if self.measure is not None:
            base["measure"] = self.measure.identity
            units |= {column: unit for column, unit in self.measure.columns.items() if unit}
        common, runs = _hash(base), {}
        for point in points(kept, self.samples, self.seed):
            meant = {**context.variants, CASE: cases}
            contents = {t: meant[t][str(value)] if t in meant else value for t, value in point.items()}
            runs[_hash([common, contents, *filter(None, [context.held_at(point)])])] = point
        definition = {
            "system": system.name,
            **base,
            "variants": context.variants,
            **({"cases": cases} if cases else {}),
            "axes": [_described(axis) for axis in kept],
            "samples": self.samples,
            "seed": self.seed if self.samples is not None else None,
        }
        return Plan(context, tuple(kept), runs, files, UNITS | units, definition)


def _driven(system: System) -> dict[str, Any]:
    """What decides on a run besides parts, wiring and values, as far as there is any."""
    told: dict[str, Any] = {}
    ways = {p.name: p.implementation for p in system.components if p.implementation}
    series = [[s.target, s.unit, hashlib.sha256(s.t.tobytes() + s.values.tobytes()).hexdigest()[:20]] for s in system.inputs]
    for name, what in (("implementations", ways), ("inputs", series)):
        if what:
            told[name] = what
    if system.scenario is not None:
        told["scenario"] = [asdict(event) for event in system.scenario.events]
    return told


def _context(
    system: System, variants: Mapping[str, Sequence[str]], defaults: Mapping[str, Value], stop: float, signals: tuple[str, ...]
) -> tuple[SweepContext, dict[str, str]]:
    """What the runs share, and their FMUs: content hash -> location."""
    files: dict[str, str] = {}

    def key(source: str) -> str:
        location = os.path.abspath(source if source.endswith(".fmu") else catalogue.fmu(source))  # noqa: PTH100 (may hold "#")
        digest = hashlib.sha256(archive.read(location)).hexdigest()[:20]
        files.setdefault(digest, location)
        return digest

    keyed = {
        target: {
            name: {
                p.name: key(p.source) for p in system.with_source(target, name).components if p.name in system.addressed(target)
            }
            for name in names
        }
        for target, names in variants.items()
    }
    varied = {name for of in keyed.values() for parts in of.values() for name in parts}
    parts = tuple(replace(p, source="" if p.name in varied else key(p.source)) for p in system.components)
    return SweepContext(replace(system, components=parts), keyed, defaults, stop, signals), files


def _check_cases(cases: Mapping[str, Mapping[str, Any]], axes: set[str], variants: Mapping[str, Sequence[str]]) -> None:
    """Refuse cases beside a component called so, and values that an axis would overrule."""
    if cases and CASE in variants:
        raise ValueError(f"a sweep with cases cannot vary a component called {CASE!r}")
    for name, values in cases.items():
        for target in values:
            if target in axes:
                raise ValueError(f"{target!r} must be an axis or be set by case {name!r}, got both")


def _described(axis: Axis) -> list[Any]:
    if isinstance(axis, Listed):
        return [axis.target, list(axis.values)]
    return [axis.target, {"low": axis.low, "high": axis.high, "log": axis.log}]


def _hash(what: Any) -> str:
    return hashlib.sha256(json.dumps(what, sort_keys=True, default=str).encode()).hexdigest()[:16]
