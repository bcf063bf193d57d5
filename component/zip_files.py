"""Zip files that depend on nothing but their members: FMUs and packed systems are written in this one place."""

import io
import zipfile
from collections.abc import Collection, Mapping
from pathlib import Path

from .whole_files import whole_file

__all__ = ["write_zip"]

_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip file can hold
_UNIX = 3


def write_zip(path: Path, members: Mapping[str, bytes], *, executable: str = "", stored: Collection[str] = ()) -> Path:
    """Write a zip file, complete or not at all: the same members give the same bytes.

    Parameters
    ----------
    path : Path
        The file, in a folder that exists. A file of that name is replaced at once, when the new one is complete.
    members : mapping of str to bytes
        Content by path inside the file, in the order of the file.
    executable : str
        Start of the paths of members that get the permission to be executed, such as "binaries/"; empty for none.
    stored : collection of str
        Endings of members that are stored without compression, such as ".fmu", which is compressed already.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OSError
        If the file cannot be written. Nothing is left beside it.
    """
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for name, content in members.items():
            info = zipfile.ZipInfo(name, date_time=_DATE)
            info.compress_type = zipfile.ZIP_STORED if name.endswith(tuple(stored)) else zipfile.ZIP_DEFLATED
            info.create_system = _UNIX
            info.external_attr = (0o755 if executable and name.startswith(executable) else 0o644) << 16
            archive.writestr(info, content)
    with whole_file(path) as beside:
        beside.write_bytes(data.getvalue())
    return path
