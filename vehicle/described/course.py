"""The part of [track] in a vehicle file that comes from tables: line, irregularity or a random one, speed over the distance."""

from pathlib import Path

from .. import track_files
from ..spectra import LEVELS, random_record
from ..track_files import Record
from .description import Course
from .sections import Section

__all__ = ["course_of"]

FADE = "10 m"  # where a file names none
EVEN = 5.0  # m
LONGEST = 1e5  # m of a random record


def course_of(track: Section, folder: Path, foremost: float) -> Course:
    """Take the keys `line`, `irregularity`, `random`, `fade` and `speed`.

    Parameters
    ----------
    track : Section
        The table.
    folder : Path
        Where its files are looked for.
    foremost : float
        Where the first wheelset stands (m); up to EVEN ahead of it the track is even.
    """
    places = {}
    for key in ("line", "irregularity", "speed"):
        if track.has(key):
            places[key] = folder / track.text(key)
            if not places[key].is_file():
                raise track.error(key, "must be a file beside this one that there is", track.text(key))
    if "irregularity" in places and track.has("random"):
        raise track.error("random", "must be left out where irregularity names a file")
    record = None
    if "irregularity" in places or track.has("random"):
        fade = track.measured("fade", track.text("fade", FADE), "m")[0]
        if not 0.0 <= fade <= 1e3:
            raise track.error("fade", "must be from 0 to 1000 m", track.text("fade", FADE))
    try:
        line = track_files.line(places["line"], track.book.rows["contact_half_distance"].start) if "line" in places else None
        if "irregularity" in places:
            record = track_files.record(places["irregularity"], fade, foremost + EVEN)
        speeds = track_files.speeds(places["speed"]) if "speed" in places else None
    except ValueError as error:
        raise ValueError(f"{track.book.file}: track: {error}") from None
    if track.has("random"):
        record = _random(track, fade, foremost + EVEN)
    return Course(line, record, speeds)


def _random(track: Section, fade: float, start: float) -> Record:
    one = track.table("random", ("level", "seed", "length", "step"))
    level = one.text("level", among=LEVELS)
    seed = one.count("seed", 1, 2**31 - 1)
    length = one.measured("length", one.text("length"), "m")[0]
    step = one.measured("step", one.text("step", "0.25 m"), "m")[0]
    if not 0.0 < step <= 10.0:
        raise one.error("step", "must be more than 0 and at most 10 m", one.text("step"))
    if not 8 * step <= length <= LONGEST:
        raise one.error("length", f"must be from 8 steps to {LONGEST:g} m", one.text("length"))
    return track_files.faded(*random_record(level, seed, length, step), fade, start)
