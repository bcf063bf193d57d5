"""Probes of numbers: derivatives, dependencies, sensitivities and slopes, as described against as found."""

from collections.abc import Iterator

import numpy as np

from .description import attribute
from .examined import Examined
from .findings import Say
from .instance import real_scalars


def derivatives(fmu: Examined, say: Say) -> None:
    """Model Exchange: the i-th state and derivative of the functions are the ones that the description names."""
    if fmu.model.modelExchange is None:
        return
    rows = [u.variable for u in fmu.model.derivatives]
    if not rows or any(v.derivative is None or v.name not in fmu.names or v.derivative.name not in fmu.names for v in rows):
        return
    states = [v.derivative.name for v in rows]
    with fmu.instance("me") as it:
        it.initialize()
        x = it.continuous_states(len(rows))
        for i, name in enumerate(states):
            moved = x.copy()
            moved[i] += 0.01 * fmu.nominal[name]
            it.set_continuous_states(moved)
            got = it.get(states)
            if got[i] != moved[i]:
                actual = [repr(n) for n, value in zip(states, got, strict=True) if value == moved[i]] or ["none of the states"]
                say(f"derivative {rows[i].name!r} is described as that of {name!r}, but state {i + 1} is {actual[0]}")
            rates = it.state_derivatives(len(rows))
            if not np.array_equal(rates, it.get([v.name for v in rows]), equal_nan=True):
                say("the state derivatives must be the variables that ModelStructure lists, in its order")
                return


def dependencies(fmu: Examined, say: Say) -> None:
    """Where an unknown changes with a variable, the description must say so: at the start, and in the running model."""
    missing: dict[str, dict[str, None]] = {}
    for unknown, name in (*_at_start(fmu), *_while_running(fmu)):
        missing.setdefault(unknown, {})[name] = None
    for unknown, names in missing.items():
        say(f"{unknown!r} must list {', '.join(map(repr, names))} among its dependencies: it changes with it")


def _at_start(fmu: Examined) -> Iterator[tuple[str, str]]:
    """(unknown, variable) of initial unknowns that change with a variable which no list of theirs names."""
    running = {u.variable.name: u.dependencies for u in (*fmu.model.outputs, *fmu.model.derivatives)}
    known = [v.name for v in fmu.settable if v.variability in ("continuous", "fixed", "tunable")]
    stated = {u.variable.name: {d.name for d in u.dependencies} for u in fmu.model.initialUnknowns if u.dependencies is not None}
    stated = {n: d | {x.name for x in running.get(n) or ()} for n, d in stated.items() if n in fmu.names}
    if fmu.kind == "se" or not stated or not known:
        return
    with fmu.instance() as it:
        it.initialize(stay=True)
        for seed in range(2):
            rng = np.random.default_rng(seed)
            base = {n: _inside(fmu, n, fmu.start[n] + 0.05 * seed * fmu.nominal[n] * rng.standard_normal()) for n in known}
            it.set(base)
            y = it.get(list(stated))
            for name in known:
                it.set({name: _inside(fmu, name, base[name] + 1e-3 * (abs(base[name]) or fmu.nominal[name]))})
                changed = it.get(list(stated))
                it.set({name: base[name]})
                yield from _moved(stated, name, y, changed)


def _while_running(fmu: Examined) -> Iterator[tuple[str, str]]:
    """The same in continuous-time mode, with inputs and continuous states; needs Model Exchange."""
    if fmu.model.modelExchange is None:
        return
    rows = (*fmu.model.outputs, *fmu.model.derivatives)
    stated = {u.variable.name: {d.name for d in u.dependencies} for u in rows if u.dependencies is not None}
    stated = {n: d for n, d in stated.items() if n in fmu.names}
    states = [u.variable.derivative.name for u in fmu.model.derivatives if u.variable.derivative is not None]
    if not stated or len(states) != len(fmu.model.derivatives):
        return
    with fmu.instance("me") as it:
        it.initialize()
        rng = np.random.default_rng(11)
        x = it.continuous_states(len(states)) if states else np.zeros(0)
        x += 0.01 * rng.standard_normal(x.size) * [fmu.nominal.get(n, 1.0) for n in states]
        base = {n: fmu.start[n] + 0.01 * fmu.nominal[n] * rng.standard_normal() for n in fmu.inputs}
        it.set(base)
        if states:
            it.set_continuous_states(x)
        y = it.get(list(stated))
        for i, name in enumerate(states):
            moved = x.copy()
            moved[i] += 1e-3 * max(abs(x[i]), fmu.nominal.get(name, 1.0))
            it.set_continuous_states(moved)
            changed = it.get(list(stated))
            it.set_continuous_states(x)
            yield from _moved(stated, name, y, changed)
        for name in fmu.inputs:
            it.set({name: base[name] + 1e-3 * max(abs(base[name]), fmu.nominal[name])})
            changed = it.get(list(stated))
            it.set({name: base[name]})
            yield from _moved(stated, name, y, changed)


def _moved(stated: dict[str, set[str]], name: str, y: np.ndarray, changed: np.ndarray) -> Iterator[tuple[str, str]]:
    for unknown, a, b in zip(stated, y, changed, strict=True):
        if a != b and name not in stated[unknown] and name != unknown and np.isfinite(a) and np.isfinite(b):
            yield unknown, name


def _inside(fmu: Examined, name: str, value: float) -> float:
    v = next(v for v in fmu.settable if v.name == name)
    low, high = attribute(v, "min"), attribute(v, "max")
    return float(np.clip(value, -np.inf if low is None else low, np.inf if high is None else high))


def sensitivities(fmu: Examined, say: Say) -> None:
    """Directional derivatives against central differences, adjoint ones against directional ones; in initialization mode."""
    able = fmu.can("providesDirectionalDerivative", "providesDirectionalDerivatives")
    rows = [u for u in (*fmu.model.outputs, *fmu.model.derivatives) if u.variable.name in fmu.names]
    rows = [u for u in rows if u.dependencies is not None and u.variable.initial not in ("exact", "approx")]
    names = {v.name for v in fmu.settable}
    known = sorted({d.name for u in rows for d in u.dependencies if d.name in names})
    unknown = [u.variable.name for u in rows]
    if fmu.kind == "se" or not able or not known or not unknown:
        return
    with fmu.instance() as it:
        it.initialize(stay=True)
        rng = np.random.default_rng(7)
        base = {n: _inside(fmu, n, fmu.start[n] + 0.02 * fmu.nominal[n] * rng.standard_normal()) for n in known}
        it.set(base)
        exact = np.column_stack([it.directional(unknown, [n], [1.0]) for n in known])
        both = []
        for relative in (1e-4, 1e-6):
            columns = []
            for n in known:
                d = relative * max(abs(base[n]), fmu.nominal[n])
                it.set({n: base[n] + d})
                high = it.get(unknown)
                it.set({n: base[n] - d})
                low = it.get(unknown)
                it.set({n: base[n]})
                columns.append((high - low) / (2 * d))
            both.append(np.column_stack(columns))
        size = np.maximum(np.abs(both[0]), np.abs(exact)) + 1e-4 * np.abs(exact).max(initial=1e-12)
        error = np.minimum(*(np.abs(exact - numeric) / size for numeric in both))
        for i, j in zip(*np.nonzero(error > 1e-2), strict=True):
            pair = f"directional derivative of {unknown[i]!r} by {known[j]!r}"
            say(f"{pair} must be {both[0][i, j]:.6g} as differences say, is {exact[i, j]:.6g}")
        if fmu.can("providesAdjointDerivatives"):
            for i, name in enumerate(unknown):
                row = it.adjoint([name], known, [1.0])
                if not np.allclose(row, exact[i], rtol=1e-6, atol=1e-9 * np.abs(exact[i]).max(initial=0.0)):
                    say(f"adjoint derivatives of {name!r} must equal its directional ones")


def slope(fmu: Examined, say: Say) -> None:
    """Co-Simulation: over a short step each state moves as its derivative says.

    An FMU whose own steps are longer stands still over a short one, so that one of the usual length has to tell.
    """
    pairs = [(v.derivative.name, v.name) for v in real_scalars(fmu.model) if v.derivative is not None]
    pairs = [p for p in pairs if p[0] in fmu.names]
    if fmu.kind != "cs" or not pairs or not fmu.can("canHandleVariableCommunicationStepSize"):
        return
    for h in (fmu.h * 1e-3, fmu.h):
        with fmu.instance("cs") as it:
            it.initialize({n: fmu.start[n] + 0.1 * fmu.nominal[n] for n in fmu.inputs})
            t = it.start
            for _ in range(3):  # past a sampled part's first action
                it.step(t, h)
                t += h
            x0, rate0 = it.get([s for s, _ in pairs]), it.get([d for _, d in pairs])
            it.step(t, h)
            x1, rate1 = it.get([s for s, _ in pairs]), it.get([d for _, d in pairs])
        if np.any(x1 != x0):
            break
    for (state, rate), a, b, r0, r1 in zip(pairs, x0, x1, rate0, rate1, strict=True):
        error = abs((b - a) / h - (r0 + r1) / 2)
        if error > 0.05 * max(abs(r0), abs(r1)) + abs(r1 - r0) + 1e-12 * max(abs(a), abs(b)) / h + 1e-9 * fmu.nominal[state]:
            say(f"state {state!r} moves by {(b - a) / h:.6g} per second where its derivative {rate!r} is {r1:.6g}", "warning")
