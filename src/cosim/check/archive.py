"""The FMU as a file: a zip archive that is whole, with its description, binaries and sources where they belong."""

import struct
import zipfile
from pathlib import Path, PurePosixPath
from typing import Any

Findings = list[tuple[str, str]]  # (rule, message)

SUFFIX = {"linux": ".so", "win": ".dll", "windows": ".dll", "darwin": ".dylib"}
ELF_MACHINE = {62: "x86_64", 3: "x86", 183: "aarch64", 40: "aarch32"}
PE_MACHINE = {0x8664: "x86_64", 0x14C: "x86", 0xAA64: "aarch64"}
FMI2_ARCHITECTURE = {"linux64": "x86_64", "win64": "x86_64", "linux32": "x86", "win32": "x86"}


def faults(path: Path) -> Findings:
    """What is wrong with the archive itself; rule "archive" where nothing else can be looked at."""
    findings: Findings = []
    try:
        with zipfile.ZipFile(path) as archive:
            bad = archive.testzip()
            members = archive.infolist()
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, EOFError, ValueError, struct.error) as error:
        return [("archive", f"the file must be a readable zip archive: {error}")]
    if bad is not None:
        return [("archive", f"member {bad!r} must agree with its checksum")]
    names = [m.filename for m in members]
    if "modelDescription.xml" not in names:
        findings.append(("archive", "modelDescription.xml must lie at the top of the archive"))
    for name in names:
        if name.startswith("/") or ".." in PurePosixPath(name).parts or ":" in name:
            findings.append(("archive", f"member {name!r} must lie inside the archive"))
        if names.count(name) > 1:
            findings.append(("file", f"member {name!r} must be there once, is {names.count(name)} times"))
    for member in members:
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            findings.append(("file", f"member {member.filename!r} must be stored or deflated"))
        if "\\" in member.orig_filename:
            findings.append(("file", f"member {member.orig_filename!r} must use '/' between folders"))
    return list(dict.fromkeys(findings))


def binary_faults(path: Path, model: Any) -> Findings:
    """Binaries under the name and of the machine that their folder says; sources that the description lists."""
    findings: Findings = []
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        identifiers = {i.modelIdentifier for i in (model.coSimulation, model.modelExchange) if i is not None}
        folders = sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and n.count("/") >= 2})
        for folder in folders:
            system = folder.rsplit("-", 1)[-1] if "-" in folder else folder.rstrip("0123456789")
            suffix = SUFFIX.get(system)
            if suffix is None:
                continue
            for identifier in sorted(identifiers):
                name = f"binaries/{folder}/{identifier}{suffix}"
                if name not in names:
                    findings.append(("binary", f"{name!r} must be there, as modelIdentifier and folder say"))
                    continue
                machine = _machine(archive.read(name))
                wanted = FMI2_ARCHITECTURE.get(folder, folder.split("-")[0] if "-" in folder else None)
                if machine is None:
                    findings.append(("binary", f"{name!r} must be a shared library for {folder}"))
                elif wanted is not None and wanted not in machine:
                    findings.append(("binary", f"{name!r} must be for {wanted}, is for {' and '.join(sorted(machine))}"))
        if not folders and not any(n.startswith("sources/") and n.endswith(".c") for n in names):
            findings.append(("binary", "the FMU must hold binaries or C sources, has neither"))
    for configuration in model.buildConfigurations or ():
        for sources in configuration.sourceFileSets:
            for file in sources.sourceFiles:
                if f"sources/{file}" not in names:
                    findings.append(("sources", f"source file {file!r} must be in the folder sources"))
    return findings


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
