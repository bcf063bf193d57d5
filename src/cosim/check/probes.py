"""What to try with the binary. Run as a program inside the child process: probes FOLDER REPORT NAME..."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from cosim.check.description import attribute, number
from cosim.check.subject import Refused, Subject, real_scalars

Say = Callable[[str], None]
STEPS = 10


class Bench:
    """The FMU's description in the form that probes need, and fresh instances of it."""

    def __init__(self, folder: Path) -> None:
        import fmpy

        self.model, self.folder = fmpy.read_model_description(str(folder), validate=False), folder
        self.kind = "cs" if self.model.coSimulation is not None else "me"
        real = real_scalars(self.model)
        self.inputs = [v.name for v in real if v.causality == "input" and v.variability == "continuous"]
        self.outputs = [v.name for v in real if v.causality == "output"]
        self.settable = [
            v for v in real if v.variability != "constant" and (v.initial in ("exact", "approx") or v.causality == "input")
        ]
        self.names = {v.name for v in real}
        self.nominal = {v.name: abs(attribute(v, "nominal") or 1.0) for v in real}
        self.start = {v.name: number(v.start) or 0.0 for v in real}
        experiment = self.model.defaultExperiment
        step = number(experiment.stepSize) if experiment is not None else None
        span = [number(getattr(experiment, n)) for n in ("startTime", "stopTime")] if experiment is not None else [None, None]
        self.h = step or ((span[1] - (span[0] or 0.0)) / 1000 if span[1] else None) or 1e-3

    def instance(self, kind: str | None = None, name: str = "instance") -> Any:
        """A context that frees the instance."""
        return closing(Subject(self.model, self.folder, kind or self.kind, name))

    def run(self, it: Subject, seed: int, first: int = 0, steps: int = STEPS) -> Iterator[np.ndarray]:
        """Macro steps with random held inputs; yields the outputs after each."""
        for i in range(first, first + steps):
            rng = np.random.default_rng([seed, i])
            it.set({n: self.start[n] + 0.01 * self.nominal[n] * rng.standard_normal() for n in self.inputs})
            it.step(it.start + i * self.h, self.h)
            yield it.get(self.outputs)


def instance(bench: Bench, say: Say) -> None:
    """It can be instantiated, initialized, stepped and freed."""
    for kind, interface in (("cs", bench.model.coSimulation), ("me", bench.model.modelExchange)):
        if interface is None:
            continue
        with bench.instance(kind) as it:
            it.initialize()
            if kind == "cs":
                for y in bench.run(it, 0):
                    for name, value in zip(bench.outputs, y, strict=True):
                        if not np.isfinite(value):
                            say(f"output {name!r} must be finite with inputs near their start values, got {value}")
                            return


def start(bench: Bench, say: Say) -> None:
    """Variables that start exactly have their start values."""
    with bench.instance() as it:
        it.initialize(stay=True)
        exact = [v.name for v in real_scalars(bench.model) if v.initial == "exact" and v.start is not None]
        for name, value in zip(exact, it.get(exact), strict=True):
            if value != bench.start[name]:
                say(f"variable {name!r} must start with {bench.start[name]!r} as described, starts with {float(value)!r}")


def derivatives(bench: Bench, say: Say) -> None:
    """Model Exchange: the i-th state and derivative of the functions are the ones that the description names."""
    if bench.model.modelExchange is None:
        return
    rows = [u.variable for u in bench.model.derivatives]
    if not rows or any(v.derivative is None or v.name not in bench.names or v.derivative.name not in bench.names for v in rows):
        return
    states = [v.derivative.name for v in rows]
    with bench.instance("me") as it:
        it.initialize()
        x = it.continuous_states(len(rows))
        for i, name in enumerate(states):
            moved = x.copy()
            moved[i] += 0.01 * bench.nominal[name]
            it.set_continuous_states(moved)
            got = it.get(states)
            if got[i] != moved[i]:
                found = [repr(n) for n, value in zip(states, got, strict=True) if value == moved[i]] or ["none of the states"]
                say(f"derivative {rows[i].name!r} is described as that of {name!r}, but state {i + 1} is {found[0]}")
            rates = it.state_derivatives(len(rows))
            if not np.array_equal(rates, it.get([v.name for v in rows]), equal_nan=True):
                say("the state derivatives must be the variables that ModelStructure lists, in its order")
                return


def dependencies(bench: Bench, say: Say) -> None:
    """Where an unknown changes with a variable, the description must say so."""
    initial = {u.variable.name: u.dependencies for u in bench.model.initialUnknowns}
    running = {u.variable.name: u.dependencies for u in (*bench.model.outputs, *bench.model.derivatives)}
    known = [v.name for v in bench.settable if v.variability in ("continuous", "fixed", "tunable") and v.name in bench.names]
    stated = {n: d for n, d in initial.items() if d is not None and n in bench.names}
    for name in running:  # what only the running model states holds for inputs at the start as well
        if name not in stated and running[name] is not None and name in bench.names and name in initial:
            stated[name] = running[name]
    if not stated or not known:
        return
    missing: dict[str, list[str]] = {}
    with bench.instance() as it:
        it.initialize(stay=True)
        for seed in range(2):
            rng = np.random.default_rng(seed)
            base = {n: _inside(bench, n, bench.start[n] + 0.05 * seed * bench.nominal[n] * rng.standard_normal()) for n in known}
            it.set(base)
            y = it.get(list(stated))
            for name in known:
                moved = _inside(bench, name, base[name] + 1e-3 * (abs(base[name]) or bench.nominal[name]))
                it.set({name: moved})
                changed = it.get(list(stated))
                it.set({name: base[name]})
                for unknown, a, b in zip(stated, y, changed, strict=True):
                    allowed = {d.name for d in (stated[unknown] or ())} | {d.name for d in (running.get(unknown) or ())}
                    if a != b and name not in allowed and name != unknown and np.isfinite(a) and np.isfinite(b):
                        missing.setdefault(unknown, []).append(name)
    for unknown, names in missing.items():
        say(
            f"{unknown!r} must list {', '.join(repr(n) for n in dict.fromkeys(names))} among its dependencies: it changes with it"
        )


def _inside(bench: Bench, name: str, value: float) -> float:
    v = next(v for v in bench.settable if v.name == name)
    low, high = attribute(v, "min"), attribute(v, "max")
    return float(np.clip(value, -np.inf if low is None else low, np.inf if high is None else high))


def sensitivities(bench: Bench, say: Say) -> None:
    """Directional derivatives against central differences, adjoint ones against directional ones; in initialization mode."""
    interface = bench.model.coSimulation or bench.model.modelExchange
    able = getattr(interface, "providesDirectionalDerivative", False) or getattr(
        interface, "providesDirectionalDerivatives", False
    )
    rows = [u for u in (*bench.model.outputs, *bench.model.derivatives) if u.variable.name in bench.names]
    rows = [u for u in rows if u.dependencies is not None and u.variable.initial not in ("exact", "approx")]
    names = {v.name for v in bench.settable}
    known = sorted({d.name for u in rows for d in u.dependencies if d.name in names})
    unknown = [u.variable.name for u in rows]
    if not able or not known or not unknown:
        return
    with bench.instance() as it:
        it.initialize(stay=True)
        rng = np.random.default_rng(7)
        base = {n: _inside(bench, n, bench.start[n] + 0.02 * bench.nominal[n] * rng.standard_normal()) for n in known}
        it.set(base)
        exact = np.column_stack([it.directional(unknown, [n], [1.0]) for n in known])
        both = []
        for relative in (1e-4, 1e-6):
            columns = []
            for n in known:
                d = relative * max(abs(base[n]), bench.nominal[n])
                it.set({n: base[n] + d})
                high = it.get(unknown)
                it.set({n: base[n] - d})
                low = it.get(unknown)
                it.set({n: base[n]})
                columns.append((high - low) / (2 * d))
            both.append(np.column_stack(columns))
        size = np.maximum(np.abs(both[0]), np.abs(exact)) + 1e-6 * np.abs(exact).max(initial=1e-12)
        error = np.minimum(*(np.abs(exact - numeric) / size for numeric in both))
        for i, j in zip(*np.nonzero(error > 1e-2), strict=True):
            pair = f"directional derivative of {unknown[i]!r} by {known[j]!r}"
            say(f"{pair} must be {both[0][i, j]:.6g} as differences say, is {exact[i, j]:.6g}")
        if getattr(interface, "providesAdjointDerivatives", False):
            for i, name in enumerate(unknown):
                row = it.adjoint([name], known, [1.0])
                if not np.allclose(row, exact[i], rtol=1e-9, atol=1e-12 * np.abs(exact[i]).max(initial=0.0)):
                    say(f"adjoint derivatives of {name!r} must equal its directional ones")


def slope(bench: Bench, say: Say) -> None:
    """Co-Simulation: over a short step each state moves as its derivative says."""
    pairs = [(v.derivative.name, v.name) for v in real_scalars(bench.model) if v.derivative is not None]
    pairs = [p for p in pairs if p[0] in bench.names]
    if bench.model.coSimulation is None or not pairs or not bench.model.coSimulation.canHandleVariableCommunicationStepSize:
        return
    with bench.instance("cs") as it:
        it.initialize({n: bench.start[n] + 0.1 * bench.nominal[n] for n in bench.inputs})
        h, t = bench.h * 1e-3, it.start
        for _ in range(3):  # past a sampled part's first action
            it.step(t, h)
            t += h
        x0, rate0 = it.get([s for s, _ in pairs]), it.get([d for _, d in pairs])
        it.step(t, h)
        x1, rate1 = it.get([s for s, _ in pairs]), it.get([d for _, d in pairs])
    for (state, rate), a, b, r0, r1 in zip(pairs, x0, x1, rate0, rate1, strict=True):
        error = abs((b - a) / h - (r0 + r1) / 2)
        if error > 0.05 * max(abs(r0), abs(r1)) + abs(r1 - r0) + 1e-12 * max(abs(a), abs(b)) / h + 1e-9 * bench.nominal[state]:
            say(f"state {state!r} moves by {(b - a) / h:.6g} per second where its derivative {rate!r} is {r1:.6g}")


def states(bench: Bench, say: Say) -> None:
    """A restored state, also one from bytes, repeats the run bit for bit."""
    interface = bench.model.coSimulation
    if interface is None or not interface.canGetAndSetFMUstate:
        return
    with bench.instance() as it:
        it.initialize()
        for _ in bench.run(it, 1, 0, 3):
            pass
        state = it.save()
        y = it.get(bench.outputs)
        expected = list(bench.run(it, 1, 3))
        it.restore(state)
        if not np.array_equal(it.get(bench.outputs), y, equal_nan=True):
            say("after restoring a state the outputs must be those of the moment it was saved")
        if not np.array_equal(list(bench.run(it, 1, 3)), expected, equal_nan=True):
            say("after restoring a state the same steps must give the same bits")
        if interface.canSerializeFMUstate:
            data = it.serialized(state)
            again = it.deserialized(data)
            it.restore(again)
            if not np.array_equal(list(bench.run(it, 1, 3)), expected, equal_nan=True):
                say("after restoring a state from bytes the same steps must give the same bits")
            if it.serialized(again) != data:
                say("a state read from bytes must give the same bytes again")
            it.discard(again)
        it.discard(state)


def instances(bench: Bench, say: Say) -> None:
    """Two instances in one process do not touch each other."""
    interface = bench.model.coSimulation
    if interface is None or interface.canBeInstantiatedOnlyOncePerProcess:
        return
    with bench.instance() as it:
        alone = list(bench.run(it.initialize(), 2))
    with bench.instance() as it, bench.instance(name="other") as other:
        it.initialize()
        other.initialize()
        together = [y for y, _ in zip(bench.run(it, 2), bench.run(other, 3), strict=True)]
    if not np.array_equal(alone, together, equal_nan=True):
        say("an instance beside another one must give what it gives alone")


def reset(bench: Bench, say: Say) -> None:
    """After a reset a run is what it was at first."""
    if bench.model.coSimulation is None:
        return
    with bench.instance() as it:
        first = list(bench.run(it.initialize({}), 4))
        it.reset()
        if not np.array_equal(list(bench.run(it.initialize({}), 4)), first, equal_nan=True):
            say("after a reset the same steps must give the same bits")


def bounds(bench: Bench, say: Say) -> None:
    """With each start value at its declared min or max, one at a time, initialization works and a step gives finite outputs."""
    for v in bench.settable:
        for side in ("min", "max"):
            value = attribute(v, side)
            if value is None or abs(value) > 1e300:
                continue
            try:
                with bench.instance() as it:
                    it.initialize({v.name: value})
                    if it.kind == "cs":
                        it.step(it.start, bench.h)
                    y = it.get(bench.outputs)
            except Refused as error:
                say(f"{v.name!r} at its {side} {value:g}: {error}")
                continue
            bad = [n for n, y_i in zip(bench.outputs, y, strict=True) if not np.isfinite(y_i)]
            if bad:
                say(f"{v.name!r} at its {side} {value:g}: output {bad[0]!r} is not finite")


def main(folder: str, report: str, names: list[str]) -> None:
    """Run the probes; one JSON line for each begin and each fault, written at once so that a crash leaves them."""
    with Path(report).open("a", encoding="utf-8", buffering=1) as out:

        def tell(*row: str) -> None:
            out.write(json.dumps(row) + "\n")

        bench = Bench(Path(folder))
        for name in names:
            tell("begin", name)
            try:
                globals()[name](bench, lambda message, name=name: tell("fault", name, message))
            except Refused as error:
                tell("fault", name, str(error))
        tell("end")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
