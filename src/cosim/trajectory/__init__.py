"""The result of a run: time, names, units and values, the files they are kept in, and where they come from."""

from .csv_files import csv_header, csv_rows, read_csv
from .files import FORMATS, check_format, read_results, read_with_origin, tell_origin
from .origin import Origin
from .signals import Trajectory, matching

__all__ = [
    "FORMATS",
    "Origin",
    "Trajectory",
    "check_format",
    "csv_header",
    "csv_rows",
    "matching",
    "read_csv",
    "read_results",
    "read_with_origin",
    "tell_origin",
]
