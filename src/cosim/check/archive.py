"""The FMU as a file: a zip archive that is whole, with its description, binaries and sources where they belong."""

import struct
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

from ..systems import archive as door
from .findings import Finding, Findings

INTERFACES = ("coSimulation", "modelExchange", "scheduledExecution")  # as FMPy calls them
SUFFIX = {"linux": ".so", "win": ".dll", "windows": ".dll", "darwin": ".dylib"}
ELF_MACHINE = {62: "x86_64", 3: "x86", 183: "aarch64", 40: "aarch32"}
PE_MACHINE = {0x8664: "x86_64", 0x14C: "x86", 0xAA64: "aarch64"}
FMI2_ARCHITECTURE = {"linux64": "x86_64", "win64": "x86_64", "linux32": "x86", "win32": "x86"}


def examined(path: Path) -> Findings:
    """What is wrong with the archive itself; rule "archive" where nothing else can be looked at."""
    try:
        with door.opened(str(path)) as archive:
            members = archive.infolist()
            bad = archive.testzip()
    except ValueError as error:
        return [Finding("archive", str(error))]
    except door.DAMAGED as error:
        return [Finding("archive", f"the members must be readable: {error}")]
    if bad is not None:
        return [Finding("archive", f"member {bad!r} must agree with its checksum")]
    if not any(m.filename == "modelDescription.xml" for m in members):
        return [Finding("archive", "modelDescription.xml must lie at the top of the archive")]
    found: Findings = []
    for name, times in Counter(m.filename for m in members if not m.is_dir()).items():
        if times > 1:
            found.append(Finding("file", f"member {name!r} should be there once, is {times} times: which one counts?", "warning"))
    for member in members:
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            found.append(Finding("file", f"member {member.filename!r} must be stored or deflated"))
        if "\\" in member.orig_filename:
            found.append(Finding("file", f"member {member.orig_filename!r} must use '/' between folders"))
    return found


def binaries(path: Path, model: Any) -> Findings:
    """Binaries under the name and of the machine that their folder says; sources that the description lists."""
    findings: Findings = []
    with door.opened(str(path)) as archive:
        names = set(archive.namelist())
        interfaces = (getattr(model, n, None) for n in INTERFACES)
        identifiers = {i.modelIdentifier for i in interfaces if i is not None}
        folders = sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and n.count("/") >= 2 and n[-1] != "/"})
        for folder in folders:
            system = folder.rsplit("-", 1)[-1] if "-" in folder else folder.rstrip("0123456789")
            suffix = SUFFIX.get(system)
            if suffix is None:
                continue
            for identifier in sorted(identifiers):
                name = f"binaries/{folder}/{identifier}{suffix}"
                if name not in names:
                    findings.append(Finding("binary", f"{name!r} must be there, as modelIdentifier and folder say"))
                    continue
                machine = _machine(_head(archive, name))
                wanted = FMI2_ARCHITECTURE.get(folder, folder.split("-")[0] if "-" in folder else None)
                if machine is None:
                    findings.append(Finding("binary", f"{name!r} must be a shared library for {folder}"))
                elif wanted is not None and wanted not in machine:
                    findings.append(Finding("binary", f"{name!r} must be for {wanted}, is for {' and '.join(sorted(machine))}"))
        if not folders and not any(n.startswith("sources/") and not n.endswith("/") for n in names):
            findings.append(Finding("binary", "the FMU must hold binaries or sources, has neither"))
    listed = [f for c in model.buildConfigurations or () for group in c.sourceFileSets for f in group.sourceFiles]
    missing = [file for file in dict.fromkeys(listed) if f"sources/{file}" not in names]
    if missing:
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        findings.append(Finding("sources", f"source file {missing[0]!r} must be in the folder sources{more}"))
    return findings


def _head(archive: zipfile.ZipFile, name: str) -> bytes:
    """The beginning of a member, where a library says what it is."""
    with archive.open(name) as member:
        return member.read(1 << 20)


def _machine(data: bytes) -> set[str] | None:
    """The processors a library is for; None if it is no library of a known format."""
    if data[:4] == b"\x7fELF" and len(data) > 20:
        return {ELF_MACHINE.get(struct.unpack_from("<H", data, 18)[0], "another machine")}
    if data[:2] == b"MZ" and len(data) > 0x40:
        at = struct.unpack_from("<I", data, 0x3C)[0]
        if data[at : at + 4] == b"PE\0\0" and len(data) > at + 6:
            return {PE_MACHINE.get(struct.unpack_from("<H", data, at + 4)[0], "another machine")}
        return None
    processors = {0x01000007: "x86_64", 0x0100000C: "aarch64"}
    if data[:4] == b"\xcf\xfa\xed\xfe":
        return {processors.get(struct.unpack_from("<I", data, 4)[0], "another machine")}
    if data[:4] == b"\xca\xfe\xba\xbe" and len(data) > 8:
        count = min(struct.unpack_from(">I", data, 4)[0], 8)
        if len(data) >= 8 + 20 * count:
            return {processors.get(struct.unpack_from(">I", data, 8 + 20 * i)[0], "another machine") for i in range(count)}
    return None
