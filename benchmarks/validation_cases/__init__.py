"""What the models are held against: one file a subject, each with functions that return a `Table`.

`TABLES` maps the name of a table to its function. Those in `WITH_FILES` are called with a folder of profile files, which are
public but not ours to hand on.
"""

from collections.abc import Callable
from pathlib import Path

from . import conicity, contact, cooperrider, klingel, manchester, ride
from .table import Line, Quantity, Table

__all__ = ["TABLES", "WITH_FILES", "Line", "Quantity", "Table"]

TABLES: dict[str, Callable[[], Table]] = {
    "contact-left": contact.left_wheel,
    "contact-right": contact.right_wheel,
    "conicity": conicity.closed_forms,
    "klingel": klingel.waves,
    "manchester-rest": manchester.at_rest,
    "manchester-modes": manchester.modes,
    "hopf": cooperrider.hopf,
    "limit-cycles": cooperrider.cycles,
    "ride": ride.on_random_track,
}
WITH_FILES: dict[str, Callable[[Path], Table]] = {
    "contact-files": contact.right_wheel_of_files,
    "en-15302": conicity.en_15302,
}
