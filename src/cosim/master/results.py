"""What a run was: its results, its energies, its times, and how it shows itself in a console or a notebook."""

import base64
import html
import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from .. import figures
from ..coupling import Algorithm
from ..systems import System, catalogue
from ..trajectory import Trajectory
from .adaptive import Adaptive
from .energy import BondEnergy, untrustworthy
from .script import Happened

__all__ = ["Run", "Status", "Timing"]

ROWS = 8  # of the table
PANELS = 3  # of the plot

Status = Literal["done", "ended", "interrupted", "failed"]


@dataclass(frozen=True)
class Timing:
    """Seconds: opening and starting the slaves, the loop over macro steps, and in it each component's steps."""

    setup_s: float
    loop_s: float
    do_step_s: dict[str, float]

    @property
    def master_s(self) -> float:
        """What the loop spent outside the components' steps."""
        return self.loop_s - sum(self.do_step_s.values())


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """What a run did.

    Attributes
    ----------
    system, algorithm : System, Algorithm
        What was run, and how.
    step : float
        Macro step, s; the first one where it adapts.
    steps : int
        Macro steps completed.
    trajectory : Trajectory
        The results.
    energy : tuple of BondEnergy
        What each power bond carried, and what the coupling added to it.
    timing : Timing
        Where the time went.
    status : {"done", "ended", "interrupted", "failed"}
        "ended" by a stop condition of the system or at a component's request; "interrupted" by the user.
    iterations : int
        Passes over macro steps where the algorithm iterates, in all.
    rejections : int
        Macro steps that were taken back to be done shorter.
    ended_by : str
        Why it is "ended".
    start : float
        When it began, s.
    events : mapping of str to int
        How many each component that tells of them has had; FMUs of FMI 3.0 with event mode do, others do not.
    warnings : mapping of str to (int, str)
        Of each component that has given warnings, how many, and the text of the first.
    happened : tuple of Happened
        What a scenario has done.
    without_kernel : str
        Why the inner loop ran as Python runs it although it was worth compiling; empty where it did not.
    adaptive : Adaptive, optional
        How the macro steps adapted, where they did; its `meaning` says what its tolerance holds.
    notes : tuple of str
        What a reader should be told: what a file says and was not followed, what was given and not used, what a component
        cannot do and how the run did without.
    """

    system: System
    algorithm: Algorithm
    step: float
    steps: int
    trajectory: Trajectory
    energy: tuple[BondEnergy, ...]
    timing: Timing
    status: Status
    iterations: int = 0
    rejections: int = 0
    ended_by: str = ""
    start: float = 0.0
    events: Mapping[str, int] = field(default_factory=dict)
    warnings: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    without_kernel: str = ""
    adaptive: Adaptive | None = None
    notes: tuple[str, ...] = ()
    happened: tuple[Happened, ...] = ()

    def __repr__(self) -> str:
        return "\n".join(lines(self))

    def show(self, **options: Any) -> Any:
        """The run as a page that runs it again, for a notebook: see gyro_cosim.report.notebook.Shown for the options.

        Raises
        ------
        RuntimeError
            The page's script is not there and cannot be built.
        """
        (view,) = catalogue.entries("views")
        return view.load()(self, **options)

    def _repr_html_(self) -> str:
        return page(self)

    @property
    def coupling_warning(self) -> str:
        """Why the result should not be trusted, in words; empty where nothing speaks against it."""
        bond = untrustworthy(self.energy)
        if bond is None:
            return ""
        if self.system.scenario is not None and self.system.scenario.has_faults:
            return ""  # a fault makes energy, and is meant to
        return (
            f"the coupling itself made or lost {bond.share:.2g} of the energy on {bond.name}: do not trust this result before "
            "you have it with a smaller macro step or a higher input degree (a certificate tells the largest stable step)"
        )

    @property
    def energy_residual(self) -> float:
        """Energy (J) that the coupling added over all power bonds."""
        return sum(bond.residual for bond in self.energy)


def lines(run: Run) -> tuple[str, str, str, str, str]:
    """What ran, how, between which components, what is kept, and what the coupling made."""
    trajectory, energy = run.trajectory, run.energy
    names = [f"{c.name} ({c.source.rpartition('/')[2]})" for c in run.system.components]
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    end = f"t = {trajectory.t[-1]:g} s" if len(trajectory) else "its start"
    why = f" ({run.ended_by})" if run.ended_by else ""
    exchanged = sum(bond.exchanged for bond in energy)
    coupling = (
        f"{run.energy_residual:.3g} J of {exchanged:.3g} J exchanged over {len(energy)} power bonds"
        if energy
        else "no power bond"
    )
    return (
        f"Run of {run.system.name!r}: {run.status} at {end}{why}",
        f"  {run.algorithm.name}, degree {run.algorithm.degree}, {run.steps} macro steps of {run.step:g} s",
        f"  components: {', '.join(names[:4])}{more}",
        f"  results: {len(trajectory)} points of {len(trajectory.names)} signals",
        f"  coupling energy: {coupling}{'; DO NOT TRUST THIS RESULT' if run.coupling_warning else ''}",
    )


def page(run: Run) -> str:
    """The same for a notebook: names are escaped, the plot is a picture in the text."""
    head, *rest = lines(run)
    trajectory = run.trajectory
    chosen: list[str] = []
    if len(trajectory):  # places and angles first
        chosen = figures.worth_drawing(trajectory, ROWS, lambda name: trajectory.unit(name) not in ("m", "rad"))
    rows = "".join(
        f"<tr><td style='text-align:left'>{html.escape(name)}</td><td>{trajectory[name][-1]:.6g}</td>"
        f"<td style='text-align:left'>{html.escape(trajectory.unit(name))}</td></tr>"
        for name in chosen
    )
    table = f"<table><thead><tr><th>at the end</th><th>value</th><th>unit</th></tr></thead><tbody>{rows}</tbody></table>"
    words = "<br>".join(html.escape(line.strip()) for line in rest)
    return f"<div><b>{html.escape(head)}</b><br>{words}{table if rows else ''}{_picture(run, chosen[:PANELS])}</div>"


def _picture(run: Run, names: list[str]) -> str:
    """The signals over time as an <img>; empty where there is nothing to draw."""
    if not names or len(run.trajectory) < 2:
        return ""
    data = io.BytesIO()
    figures.time_histories(run.trajectory, names).savefig(data, format="png", dpi=80)
    text = html.escape(f"{', '.join(names)} over time", quote=True)
    return f"<img alt='{text}' src='data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}'>"
