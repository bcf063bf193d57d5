"""What the page of a run shows, as one JSON document."""

import hashlib
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from ..master import Run
from ..systems import System, catalogue
from ..trajectory import Trajectory
from . import module, scenes, signals


@dataclass(frozen=True)
class Told:
    """What is known of a run besides its results.

    Attributes
    ----------
    command : str
        What repeats it.
    lines : sequence of str
        What fields of engineering have found in it, in words.
    certificate : sequence of str
        The estimate of its coupling error, in words; empty where none was asked for.
    prefer : sequence of str
        Signals that are drawn first.
    record_every : int
        Macro steps between recorded rows.
    notes : sequence of str
        What a reader must know before he believes the numbers.
    texts : sequence of (str, sequence of str)
        More of what came out, in words: a title and lines.
    others : mapping of str to Trajectory
        Runs that lie over this one, by what they are called.
    called : str
        What this one is called beside them.
    variants : sequence of str, optional
        Of the component that people exchange in the system, those that the page's menu offers; None for all that fit.
    progress : callable, optional
        Called with (done, total) while variants are compiled.
    """

    command: str = ""
    lines: Sequence[str] = ()
    certificate: Sequence[str] = ()
    record_every: int = 1
    prefer: Sequence[str] = ()
    notes: Sequence[str] = ()
    texts: Sequence[tuple[str, Sequence[str]]] = ()
    others: Mapping[str, Trajectory] = field(default_factory=dict)
    called: str = ""
    variants: Sequence[str] | None = ()
    progress: Callable[[int, int], Any] | None = None


def document(run: Run, told: Told) -> dict[str, Any]:
    """The page's document of one run. A system that cannot run in a page is shown all the same, with the reason."""
    system, trajectory = run.system, run.trajectory
    made, reason, values = None, "", {}
    try:
        _runs_in_a_page(run)
        bare = module.compiled(system, run.algorithm, run.step)
        values = module.given(system)
        made = bare.with_values(values)
    except (ValueError, RuntimeError) as error:
        reason = str(error)
    scene = scenes.scene_of(system, trajectory.names, {} if made is None else made.values())
    return {
        "title": system.name,
        "description": system.description,
        "system": graph(system),
        "run": {
            "algorithm": run.algorithm.name,
            "degree": run.algorithm.degree,
            "step": run.step,
            "steps": run.steps,
            "start": run.start,
            "stop": float(trajectory.t[-1]) if len(trajectory) else run.start,
            "status": run.status,
            "ended_by": run.ended_by,
            "record_every": told.record_every,
            "loop_s": run.timing.loop_s,
        },
        "command": told.command,
        "versions": {"gyro-cosim": metadata.version("gyro-cosim"), "Python": platform.python_version()},
        "hashes": hashes(system),
        "verdicts": list(told.lines),
        "certificate": list(told.certificate),
        "texts": [{"title": title, "lines": list(lines)} for title, lines in told.texts],
        "others": [{"name": name, "signals": signals.document(run)} for name, run in told.others.items()],
        "called": told.called,
        "notes": [*told.notes, *([run.coupling_warning] if run.coupling_warning else [])],
        "bonds": [
            {"name": b.name, "residual": b.residual, "exchanged": b.exchanged, "share": b.share, "peak": b.peak_power}
            for b in run.energy
        ],
        "prefer": [*(scene or {}).get("prefer", ()), *told.prefer],
        "signals": signals.document(trajectory),
        "module": None if made is None else made.document(),
        "variants": [] if made is None else variants(run, told, values),
        "why_not": reason,
        "check": None if made is None else check(run, told.record_every),
        "scene": scene,
    }


def variants(run: Run, told: Told, values: Mapping[str, float]) -> list[dict[str, Any]]:
    """The modules of the page's menu, by name; those that cannot be compiled for a page are left out."""
    wanted = module.exchangeable(run.system) if told.variants is None else told.variants
    found = []
    for done, (name, made) in enumerate(module.exchanged(run.system, run.algorithm, run.step, wanted), start=1):
        if made is not None:
            found.append({"name": name, "module": made.with_values(values).folded()})
        if told.progress is not None:
            told.progress(done, len(wanted))
    return found


def recorded(runs: Mapping[str, Trajectory], told: Told) -> dict[str, Any]:
    """The page's document of runs of which only the signals are known."""
    (title, first), *others = runs.items()
    return {
        "title": title,
        "description": "",
        "system": None,
        "run": {"start": float(first.t[0]) if len(first) else None, "stop": float(first.t[-1]) if len(first) else None},
        "command": told.command,
        "versions": {"gyro-cosim": metadata.version("gyro-cosim"), "Python": platform.python_version()},
        "hashes": {},
        "verdicts": list(told.lines),
        "certificate": [],
        "notes": list(told.notes),
        "bonds": [],
        "prefer": list(told.prefer),
        "signals": signals.document(first),
        "others": [{"name": name, "signals": signals.document(run)} for name, run in others],
        "module": None,
        "variants": [],
        "why_not": "the file of results holds its signals alone; cosim run --report puts the system itself into the page",
        "check": None,
        "scene": None,
    }


def _runs_in_a_page(run: Run) -> None:
    """ValueError where the page's inner loop would not be that of the run."""
    if run.rejections or run.iterations:
        raise ValueError(
            "a run with an adaptive step or with iterations needs the whole package; the page's inner loop has neither"
        )


def graph(system: System) -> dict[str, Any]:
    """Components and what is exchanged between them."""
    return {
        "components": [{"name": c.name, "source": c.source} for c in system.components],
        "exchanged": list(system.addressed(system.exchange.component)) if system.exchange is not None else [],
        "connections": [{"start": list(c.start), "end": list(c.end)} for c in system.connections],
    }


def hashes(system: System) -> dict[str, str]:
    """SHA-256 of every component's FMU; those that run elsewhere have none."""
    found = {}
    for component in system.components:
        if component.source.startswith(("process:", "tcp://")):
            continue
        file = Path(component.source) if component.source.endswith(".fmu") else catalogue.fmu(component.source)
        if file.is_file():
            found[component.name] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found


def check(run: Run, record_every: int) -> dict[str, Any]:
    """What a run in the page is compared with: on which macro steps, and the fingerprint of the outputs there.

    The last row belongs to it, wherever it falls.
    """
    rows = np.arange(len(run.trajectory))
    stride = max(1, -(-rows.size // signals.CHECKED))
    chosen = np.unique(np.append(rows[::stride], rows[-1:]))
    return {
        "every": stride * record_every,
        "names": list(run.trajectory.names),
        "rows": int(chosen.size),
        "fingerprint": signals.fingerprint(run.trajectory.values[chosen]),
    }
