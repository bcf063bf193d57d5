"""cosim run --live: the page of the run while it goes on, and what was changed in it, kept so that the run can be repeated."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from gyro_cosim.component.whole_files import write_whole

from ..hil.realtime import Pacer
from ..master.visiting import Visitor, changeable
from ..network import Network
from ..systems import Event, Scenario, System
from ..systems.scenario import written
from ..trajectory import matching
from .common import console
from .given import arguments, repeated
from .provenance import hash_of_file
from .results import Files

__all__ = ["Seen", "seen_live"]


@dataclass(frozen=True)
class Seen:
    """A run that may be seen live.

    Attributes
    ----------
    visitor : Visitor, optional
        What the run calls; None where it is not seen.
    events : sequence of Event
        What has been changed so far.
    home : Path
        The folder in which the command began; an FMU may change the current one.
    """

    visitor: Visitor | None = None
    events: Sequence[Event] = ()
    home: Path = Path()

    def kept(self, plan: System, files: Files, reached: float, *, ended: bool) -> tuple[Files, list[Path]]:
        """Write what was changed as a scenario; the files whose origin is the command that repeats the run, and what was written.

        Parameters
        ----------
        plan : System
            What ran.
        files : Files
            Where the results go.
        reached : float
            How far the run came, s. ended : before its time, by a viewer or Ctrl-C.
        """
        if not self.events:
            return files, []
        before = () if plan.scenario is None else plan.scenario.events
        folder = files.outputs[0].parent if files.outputs else Path()
        file = _unused(self.home, folder / f"{plan.name}-live.toml")
        write_whole(self.home / file, written(Scenario((*before, *self.events))))
        command = (*_without("--live", 0, _without("--scenario", 1, arguments())), "--scenario", str(file))
        if ended:
            command = (*_without("--stop", 1, command), "--stop", repr(reached))
        return files.made_by(command, {str(file): hash_of_file(str(self.home / file))}), [file]


def _unused(home: Path, file: Path) -> Path:
    """The file, or one with a number where it is there already; as seen from `home`."""
    k, free = 1, file
    while (home / free).exists():
        k += 1
        free = file.with_stem(f"{file.stem}-{k}")
    return free


def _without(option: str, words: int, command: Sequence[str]) -> tuple[str, ...]:
    """The command without an option and so many words behind it."""
    kept, left = [], 0
    for word in command:
        if left:
            left -= 1
        elif word == option:
            left = words
        elif not word.startswith(f"{option}="):
            kept.append(word)
    return tuple(kept)


@contextmanager
def seen_live(
    active: bool, network: Network, *, step: float, start: float, stop: float, select: Sequence[str], every: int,
    pacer: Pacer | None, steers: bool,
) -> Iterator[Seen]:  # fmt: skip
    """While it lasts, the run of the network has a page on this machine, where `active`.

    Parameters
    ----------
    active : bool
        Whether it is wished.
    network : Network
        What is about to run.
    step, start, stop : float
        Of the run, s.
    select, every
        What is recorded, as Recording says it.
    pacer : Pacer, optional
        What paces the run.
    steers : bool
        Whether parameters may be changed: only if a scenario can say the same afterwards.
    """
    if not active:
        yield Seen()
        return
    from ..report.bundling import bundle
    from ..report.live import Served, Steering, first_page
    from ..report.live.film import Film
    from ..report.writing import page
    from ..systems import catalogue

    chosen = {name for pattern in select for name in matching(pattern, network.names)}
    names = [name for name in network.names if not select or name in chosen]
    offered = changeable(network) if steers else {}
    document = first_page(network, names, offered, start=start, stop=stop, command=repeated(), prefer=(), paced=pacer is not None)
    text = page(document, bundle(catalogue.cache_folder()))
    home = Path.cwd()
    film = Film(len(names), every)
    steering = Steering(film, offered, step=step, waits=pacer is None, on_pause=None if pacer is None else pacer.postpone)
    with Served(text, film, steering) as served:
        waits = "" if pacer is not None else "; the run begins there"
        console().print(f"live at {served.address}{waits} (who opens it first steers, others watch)", soft_wrap=True)
        yield Seen(steering, steering.events, home)
