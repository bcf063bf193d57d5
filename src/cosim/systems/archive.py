"""Files from elsewhere, which are not trusted: XML without entities, zip archives whose members stay inside.

A file inside an archive is written `ARCHIVE#MEMBER`, such as "plant.ssp#resources/motor.fmu"; archives may be nested.
"""

import io
import shutil
import stat
import zipfile
from collections.abc import Iterable
from pathlib import Path, PurePosixPath, PureWindowsPath

from lxml import etree

LARGEST = 4 << 30  # bytes that one archive may unpack to


def xml(data: bytes, where: str) -> etree._Element:
    """The root element of an XML document; ValueError, which begins with `where`, unless it is plain and well-formed."""
    parser = etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False, remove_comments=True)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(f"{where} must be well-formed XML: {error.msg or 'it is empty'}") from None
    if root.getroottree().docinfo.internalDTD is not None:
        raise ValueError(f"{where} must have no document type declaration (it could expand entities)")
    return root


def read(location: str) -> bytes:
    """The bytes of a file, `FILE` or `ARCHIVE#MEMBER`; ValueError names what is not there."""
    outer, mark, member = location.rpartition("#")
    if not mark or Path(location).is_file():
        try:
            return Path(location).read_bytes()
        except OSError as error:
            raise ValueError(f"file {location!r} cannot be read: {error.strerror or error}") from None
    with opened(outer) as archive:
        try:
            return archive.read(member)
        except KeyError:
            raise ValueError(f"archive {outer!r} must hold {member!r}") from None


def exists(location: str) -> bool:
    """Whether there is such a file, `FILE` or `ARCHIVE#MEMBER`."""
    outer, mark, member = location.rpartition("#")
    if not mark or Path(location).is_file():
        return Path(location).is_file()
    with opened(outer) as archive:
        return member in archive.namelist()


def opened(location: str) -> zipfile.ZipFile:
    """The zip archive at `location`, every member of which has been found to lie inside."""
    inside = "#" in location and not Path(location).is_file()
    if not inside and not Path(location).is_file():
        raise ValueError(f"archive {location!r} must exist")
    try:
        archive = zipfile.ZipFile(io.BytesIO(read(location)) if inside else location)
    except (zipfile.BadZipFile, OSError) as error:
        raise ValueError(f"{location!r} must be a zip archive: {error}") from None
    try:
        for member in archive.infolist():
            check_member(member, location)
        total = sum(member.file_size for member in archive.infolist())
        if total > LARGEST:
            raise ValueError(f"archive {location!r} must unpack to at most {LARGEST >> 30} GiB, says {total / 2**30:.1f} GiB")
    except BaseException:
        archive.close()
        raise
    return archive


def check_member(member: zipfile.ZipInfo, location: str) -> None:
    """Refuse a member that would land outside, whatever system unpacks it, and one that is a link."""
    name = member.filename.replace("\\", "/")
    inside = not PurePosixPath(name).is_absolute() and ".." not in name.split("/")
    if not (inside and not PureWindowsPath(name).drive and "\0" not in member.orig_filename):
        raise ValueError(f"archive {location!r}: member {member.orig_filename!r} must lie inside the archive")
    if stat.S_ISLNK(member.external_attr >> 16):
        raise ValueError(f"archive {location!r}: member {member.filename!r} must be a file, is a symbolic link")


def unpack(archive: zipfile.ZipFile, folder: Path, wanted: Iterable[str]) -> None:
    """Write the members whose names begin with one of `wanted` into `folder`; damaged ones are a ValueError."""
    beginnings = tuple(wanted)
    for member in archive.infolist():
        if not member.filename.startswith(beginnings) or member.is_dir():
            continue
        target = folder / member.filename
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            with archive.open(member) as source, target.open("wb") as sink:
                shutil.copyfileobj(source, sink)
        except (zipfile.BadZipFile, RuntimeError, NotImplementedError) as error:  # damaged, encrypted, unknown method
            raise ValueError(f"archive {archive.filename!r}: member {member.filename!r} cannot be unpacked: {error}") from None
        mode = (member.external_attr >> 16) & 0o777
        if mode & 0o100:
            target.chmod(0o755)
