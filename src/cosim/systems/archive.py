"""Files from elsewhere, which are not trusted: XML without entities, zip archives whose members stay inside.

A file inside an archive is written `ARCHIVE#MEMBER`, such as "plant.ssp#resources/motor.fmu"; archives may be nested.

This is the one door: whoever opens an FMU, an SSP or a checkpoint (run, info, check, pack, plot, resume) does it here. What is
refused is what no tool writes and what harms: members that land outside, links and devices, members laid over one another,
archives that unpack to more than the limits below.
"""

import io
import shutil
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath

from lxml import etree

LARGEST = 4 << 30  # bytes that one archive may unpack to
LARGEST_XML = 128 << 20  # bytes of one document
MOST_MEMBERS = 100_000  # of one archive
RATIO, FREE = 200, 64 << 20  # a member that unpacks to more than FREE bytes must not shrink to less than 1 / RATIO of them
DEEPEST = 64  # folders within one another, in a member's name
LONGEST = 1024  # characters of a member's name
NESTED = 4  # archives within one another
LARGEST_HELD = 1 << 30  # bytes of a member that is read into memory
DAMAGED = (
    zipfile.BadZipFile,
    RuntimeError,
    NotImplementedError,
    EOFError,
    zlib.error,
)  # members: torn, encrypted, unknown method


def xml(data: bytes, where: str) -> etree._Element:
    """The root element of an XML document; ValueError, which begins with `where`, unless it is plain and well-formed."""
    if len(data) > LARGEST_XML:
        raise ValueError(f"{where} must be at most {LARGEST_XML >> 20} MiB of XML, is {len(data) / 2**20:.0f} MiB")
    parser = etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False, remove_comments=True)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(f"{where} must be well-formed XML: {' '.join((error.msg or 'it is empty').split())}") from None
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
        return held(archive, member, outer)


def held(archive: zipfile.ZipFile, member: str, location: str) -> bytes:
    """The bytes of a member of the open archive at `location`; ValueError if it is not there, damaged or too large to hold."""
    try:
        size = archive.getinfo(member).file_size
        if size > LARGEST_HELD:
            raise ValueError(f"archive {location!r}: member {member!r} must have at most {LARGEST_HELD >> 30} GiB, says {size} B")
        return archive.read(member)
    except KeyError:
        raise ValueError(f"archive {location!r} must hold {member!r}") from None
    except DAMAGED as error:
        raise ValueError(f"archive {location!r}: member {member!r} cannot be unpacked: {error}") from None


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
    if inside and location.count("#") > NESTED:
        raise ValueError(f"archive {location!r} must lie in at most {NESTED} others, lies in {location.count('#')}")
    try:
        archive = zipfile.ZipFile(io.BytesIO(read(location)) if inside else location)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, EOFError, ValueError, struct.error) as error:
        raise ValueError(f"{location!r} must be a zip archive: {error}") from None
    try:
        _check(archive.infolist(), location)
    except BaseException:
        archive.close()
        raise
    return archive


def _check(members: Sequence[zipfile.ZipInfo], location: str) -> None:
    """Refuse an archive beyond the limits; linear in the number of members."""
    if len(members) > MOST_MEMBERS:
        raise ValueError(f"archive {location!r} must hold at most {MOST_MEMBERS} members, holds {len(members)}")
    for member in members:
        check_member(member, location)
    total = sum(member.file_size for member in members)
    if total > LARGEST:
        raise ValueError(f"archive {location!r} must unpack to at most {LARGEST >> 30} GiB, says {total / 2**30:.1f} GiB")
    end, before = 0, ""
    for member in sorted(members, key=lambda m: m.header_offset):
        if member.header_offset < end:
            raise ValueError(f"archive {location!r}: member {member.filename!r} must not lie over {before!r}")
        end, before = member.header_offset + member.compress_size, member.filename


def check_member(member: zipfile.ZipInfo, location: str) -> None:
    """Refuse a member that would land outside, whatever system unpacks it, one that is no file, and one that bursts."""
    where, name = f"archive {location!r}: member {member.orig_filename[:200]!r}", member.filename.replace("\\", "/")
    inside = not PurePosixPath(name).is_absolute() and ".." not in name.split("/")
    if not (inside and not PureWindowsPath(name).drive and "\0" not in member.orig_filename):
        raise ValueError(f"{where} must lie inside the archive")
    if len(name) > LONGEST or name.count("/") > DEEPEST:
        raise ValueError(
            f"{where} must have a name of at most {LONGEST} characters and {DEEPEST} folders, has {len(name)}, {name.count('/')}"
        )
    kind = stat.S_IFMT(member.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        what = "a symbolic link" if kind == stat.S_IFLNK else "a device or the like"
        raise ValueError(f"{where} must be a file, is {what}")
    if member.flag_bits & 0x1:
        raise ValueError(f"{where} must not be encrypted")
    if member.file_size > FREE and member.file_size > RATIO * member.compress_size:
        raise ValueError(
            f"{where} must not unpack to more than {RATIO} times its size, says {member.file_size / 2**20:.0f} MiB "
            f"from {member.compress_size / 2**20:.2f} MiB"
        )


def unpack(archive: zipfile.ZipFile, folder: Path, wanted: Iterable[str]) -> None:
    """Write the members whose names begin with one of `wanted` into `folder`; damaged ones are a ValueError."""
    beginnings = tuple(wanted)
    for member in archive.infolist():
        if not member.filename.startswith(beginnings) or member.is_dir():
            continue
        target = folder / member.filename
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(member) as source, target.open("wb") as sink:
                shutil.copyfileobj(source, sink)
        except (*DAMAGED, FileExistsError, NotADirectoryError, IsADirectoryError) as error:  # or a file where a folder is
            raise ValueError(f"archive {archive.filename!r}: member {member.filename!r} cannot be unpacked: {error}") from None
        mode = (member.external_attr >> 16) & 0o777
        if mode & 0o100:
            target.chmod(0o755)
