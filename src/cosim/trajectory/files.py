"""The files of results: one writer and one reader a format, chosen by the ending; a file is whole, or not there."""

from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from gyro_cosim.component.whole_files import whole_file

from .csv_files import read_csv, write_csv
from .mat_files import read_mat, write_mat
from .mdf_files import read_mdf, write_mdf
from .origin import Origin, beside, parsed
from .parquet_files import read_parquet, write_parquet
from .signals import Trajectory

FORMATS = (".csv", ".mat", ".parquet", ".mf4")
NEEDS = {".parquet": ("pyarrow", "parquet"), ".mf4": ("asammdf", "mdf")}  # package, and the extra that brings it


def check_format(file: Path) -> None:
    """Refuse a file name whose ending says no format that can be written."""
    if file.suffix not in FORMATS:
        raise ValueError(f"output file must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}, got {str(file)!r}")
    package, extra = NEEDS.get(file.suffix, ("", ""))
    if package and find_spec(package) is None:
        raise ValueError(f"{str(file)!r} needs the package {package}: python -m pip install 'gyro-cosim[{extra}]'")


def save(trajectory: Trajectory, file: Path, origin: Origin | None = None) -> None:
    """See Trajectory.save."""
    check_format(file)
    if file.suffix == ".csv":
        _whole(file, lambda place: write_csv(trajectory, place), beside(file))
    elif file.suffix == ".mat":
        _whole(file, lambda place: write_mat(trajectory, place), beside(file))
    elif file.suffix == ".parquet":
        _whole(file, lambda place: write_parquet(trajectory, place, origin))
    else:
        _whole(file, lambda place: write_mdf(trajectory, place, origin))
    if file.suffix in (".csv", ".mat"):
        tell_origin(file, trajectory, origin)


def tell_origin(file: Path, trajectory: Trajectory, origin: Origin | None) -> None:
    """Write the origin of results beside their file; where there is none to tell, that of older results goes."""
    if origin is None:
        beside(file).unlink(missing_ok=True)
        return
    units = dict(zip(trajectory.names, trajectory.units, strict=True))
    text = replace(origin, units=units).text()
    _whole(beside(file), lambda place: place.write_text(text, encoding="utf-8"))


def _whole(file: Path, write: Callable[[Path], object], outdated: Path | None = None) -> None:
    """Write a file under another name, and give it its own once it is on the disk; `outdated`, which tells of the older, goes."""
    with whole_file(file, outdated) as place:
        write(place)


def read_results(file: str | Path) -> Trajectory:
    """The trajectory in a file of results.

    Parameters
    ----------
    file : str or Path
        A .csv, .mat, .parquet or .mf4 file that a run wrote; the last three may be another program's.

    Returns
    -------
    Trajectory
        Units of a .csv are those that its `FILE.origin.json` tells, and empty without one.

    Raises
    ------
    ValueError
        Another ending, or a file that holds no such results.
    """
    return read_with_origin(file)[0]


def read_with_origin(file: str | Path) -> tuple[Trajectory, Origin | None]:
    """The trajectory in a file of results, and where it comes from, if that is known; see read_results()."""
    file = Path(file)
    check_format(file)
    try:
        told, where = "", f"{str(file)!r}"
        if file.suffix == ".parquet":
            trajectory, told = read_parquet(file)
        elif file.suffix == ".mf4":
            trajectory, told = read_mdf(file)
        else:
            trajectory = read_csv(file) if file.suffix == ".csv" else read_mat(file)
    except Exception as error:  # the readers of four formats fail in ways of their own
        if isinstance(error, OSError) and error.errno is not None:
            raise OSError(error.errno, error.strerror or str(error), str(file)) from None
        said = " ".join(str(error).split())[:200]
        raise ValueError(f"{str(file)!r} must be a {file.suffix} that holds results over time: {said}") from None
    if file.suffix in (".csv", ".mat") and beside(file).is_file():
        where = f"{str(beside(file))!r}"
        told = beside(file).read_text(encoding="utf-8", errors="replace")
    origin = parsed(told, where) if told else None
    if origin is not None and file.suffix == ".csv":
        trajectory = replace(trajectory, units=tuple(origin.units.get(name, "") for name in trajectory.names))
    return trajectory, origin
