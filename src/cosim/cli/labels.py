"""What runs in files are called in a figure: by what tells their commands apart, else by their files' names."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ..trajectory import Origin
from .reproduce import deciding

LONGEST = 60  # characters of a label
KEPT_THE_SAME = ("--record-every", "--select", "--in-process", "--input")  # decide what is kept, or are no words for a legend


def labelled(files: Sequence[Path], origins: Sequence[Origin | None]) -> tuple[str, list[str]]:
    """What several runs have in common, for a title, and a label for each, all different.

    files, origins : of the runs, one each; an origin is None where a file does not tell it.
    """
    commands = [list(_phrases(origin.command)) if origin is not None else [] for origin in origins]
    common = [phrase for phrase in commands[0] if all(phrase in command for command in commands)]
    own = [", ".join(phrase for phrase in command if phrase not in common) for command in commands]
    told = bool(common) and all(own) and max(map(len, own)) <= LONGEST
    if len(files) > 1 and told and len(set(own)) == len(own):
        return ", ".join(common), own
    stems = [file.stem for file in files]
    unlike = len(set(stems)) == len(stems)
    return "" if len(files) > 1 else files[0].name, stems if unlike else [str(file) for file in files]


def _phrases(command: Sequence[str]) -> Iterator[str]:
    """The parts of a `cosim run` that decide on its results, in words: the system, "gyro off", "vehicle.speed=8"."""
    words = list(deciding(command[1:]))
    while words:
        option, equals, value = words.pop(0).partition("=")
        if not option.startswith("--"):
            yield option + equals + value
            continue
        if not equals and words and not words[0].startswith("--"):
            value = words.pop(0)
        if option not in KEPT_THE_SAME:
            yield value if option == "--set" else f"{option.removeprefix('--')} {value}".strip()
