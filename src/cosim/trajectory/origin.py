"""Where results come from: the command that made them, the versions it was run with, and hashes of what it read.

.parquet and .mf4 files carry this inside. Other programs' readers know no place for it in .csv and .mat files, so there it lies
beside the results, as `FILE.origin.json`.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

MARK = "gyro_cosim_origin"  # key and version of the format
VERSION = 1


@dataclass(frozen=True)
class Origin:
    """Where results come from. It holds no time of day: the same command makes the same file.

    Parameters
    ----------
    command : tuple of str
        Arguments of `cosim`.
    folder : str
        Where the command ran, as seen from the folder of the results.
    versions : mapping of str to str
        Of packages, of Python, and the machine.
    hashes : mapping of str to str
        Of files that were read, and of components, in hexadecimal; what a file is called, as the command ran.
    units : mapping of str to str
        Of signals, for files that have no place for them.
    """

    command: tuple[str, ...]
    folder: str = "."
    versions: Mapping[str, str] = field(default_factory=dict)
    hashes: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    def document(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {MARK: VERSION, **asdict(self), "command": list(self.command)}

    def text(self) -> str:
        """As files hold it."""
        return json.dumps(self.document(), ensure_ascii=False, indent=1) + "\n"


def beside(file: Path) -> Path:
    """The file that tells the origin of results that cannot hold it."""
    return file.with_name(f"{file.name}.origin.json")


def parsed(text: str, where: str) -> Origin:
    """The origin in a text; ValueError begins with `where`."""
    try:
        told = json.loads(text)
        if told[MARK] != VERSION:
            raise ValueError(f"its format must be {VERSION}, is {told[MARK]!r}")
        texts = [told["folder"], *told["command"], *(x for key in ("versions", "hashes", "units") for x in _flat(told[key]))]
        if not all(isinstance(x, str) for x in texts):
            raise ValueError("it must hold texts")
        return Origin(tuple(told["command"]), told["folder"], told["versions"], told["hashes"], told["units"])
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise ValueError(f"{where} must tell where results come from as cosim run writes it: {error}") from None


def _flat(told: Mapping[str, Any]) -> list[Any]:
    return [*told, *told.values()]
