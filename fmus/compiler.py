"""From C to shared libraries: the host's compiler, or Zig's from PyPI, which compiles for the other platforms too."""

import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from . import web

__all__ = [
    "FLAGS", "PLATFORMS", "CompilerError", "Platform", "chosen", "compile_libraries", "foreign_library", "host", "host_compiler",
    "host_library", "universal",
]  # fmt: skip

# No fused operations: the same bits everywhere; a square root is an instruction, not a call that may set errno.
FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden")

PATIENCE = 1800.0  # s, for one file; our own largest takes a minute


class CompilerError(RuntimeError):
    """The compiler is missing or refuses the code."""


@dataclass(frozen=True)
class Platform:
    """A platform that FMUs can be compiled for.

    Attributes
    ----------
    name, folder : str
        What FMI 3.0 and FMI 2.0 call it.
    target : str
        What Zig calls it.
    suffix : str
        Ending of its shared libraries.
    """

    name: str
    folder: str
    target: str
    suffix: str


PLATFORMS = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17", ".so"),
        Platform("aarch64-linux", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
        Platform("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
        Platform("x86_64-darwin", "darwin64", "x86_64-macos.11.0", ".dylib"),
        Platform("aarch64-darwin", "darwin64", "aarch64-macos.11.0", ".dylib"),
    )
}
WEB = Platform("wasm32", "wasm32", "wasm32-wasi", ".wasm")  # by name only: no importer of FMUs runs it, the report's page does


def host() -> Platform:
    """The platform this runs on; ValueError if no FMU can be made for it."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    name = f"{machine}-{platform.system().lower()}"
    if name not in PLATFORMS:
        raise ValueError(f"platform must be one of {', '.join(PLATFORMS)}, this machine is {name!r}")
    return PLATFORMS[name]


def chosen(names: Sequence[str]) -> dict[Platform, bool]:
    """The platforms that `names` mean, each with whether the host's own compiler may be used: only for "host"."""
    if isinstance(names, str):
        raise ValueError(f"platforms must be a sequence of names, got {names!r}")
    platforms: dict[Platform, bool] = {}
    for name in names:
        if name == "host":
            platforms[host()] = True
        elif name == "all":
            platforms |= {p: False for p in PLATFORMS.values() if p not in platforms}
        elif name in PLATFORMS or name == WEB.name:
            platforms.setdefault(PLATFORMS.get(name, WEB), False)
        else:
            raise ValueError(f"platform must be 'host', 'all' or one of {', '.join(PLATFORMS)}, got {name!r}")
    if not platforms:
        raise ValueError("platforms must name at least one, got none")
    return platforms


def host_compiler() -> list[str] | None:
    """The command of the host's C compiler: $CC, cc, gcc or clang; None where there is none, and on Windows."""
    if sys.platform == "win32":
        return None
    wanted = os.environ.get("CC", "").split()
    for command in (wanted, ["cc"], ["gcc"], ["clang"]):
        if command and shutil.which(command[0]):
            return command
    return None


def compile_libraries(
    folder: Path, sources: Mapping[str, str], name: str, targets: Mapping[Platform, bool], *,
    libraries: Sequence[str] = ("m",), options: Sequence[str] = (),
) -> dict[Platform, bytes]:  # fmt: skip
    """Compile a shared library for each platform. Paths are relative, so it does not depend on where it was made.

    Parameters
    ----------
    folder : Path
        Holds the C files and all they include. Objects and libraries are written into it.
    sources : mapping of str to str
        Optimization by C file, such as {"fmu.c": "-O3"}.
    name : str
        Name of the library, without ending.
    targets : mapping of Platform to bool
        Whether the host's own compiler may be used for a platform; else it is Zig's.
    libraries : sequence of str
        Of the system, which Linux links where others have them at hand: "m" for mathematics, "dl" for loading libraries.
    options : sequence of str
        More options for compiling.

    Returns
    -------
    dict of Platform to bytes
        The libraries.

    Raises
    ------
    CompilerError
        If the compiler is missing or refuses the code.
    """
    given = {target: web.sources(folder, sources) if target == WEB else sources for target in targets}
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        commands = {target: _command(target, allowed) for target, allowed in targets.items()}
        objects = {
            (target, source): pool.submit(_object, folder, commands[target], source, [level, *options], target)
            for target in targets
            for source, level in given[target].items()
        }
        done = {target: [objects[target, source].result() for source in given[target]] for target in targets}
        linked = {
            target: pool.submit(_link, folder, commands[target], done[target], name, target, libraries) for target in targets
        }
        return {target: job.result() for target, job in linked.items()}


def host_library(folder: Path, source: str, name: str) -> bytes:
    """A shared library of one C file in `folder` for this machine. CompilerError if there is no compiler or it fails."""
    return compile_libraries(folder, {source: "-O2"}, name, {host(): True})[host()]


def foreign_library(folder: Path, sources: Mapping[str, Sequence[str]], name: str, headers: Sequence[Path]) -> bytes:
    """A shared library for this machine of C files that somebody else has written, so not held to our own rules.

    Parameters
    ----------
    folder : Path
        Holds the files and all they include; objects and the library are written into it.
    sources : mapping of str to sequence of str
        Options for the preprocessor by C file, relative to `folder`.
    name : str
        Name of the library, without ending.
    headers : sequence of Path
        Where else headers are looked for, after the folder of the file that includes them, its options and `folder`.

    Raises
    ------
    CompilerError
        If the compiler is missing, refuses the code, or takes longer than PATIENCE for one file.
    """
    target = host()
    common = ["-std=gnu99", "-O2", "-w", "-ffp-contract=off", "-I.", *(f"-I{place}" for place in headers)]
    common += ["-Werror=implicit-function-declaration"]  # a call of what is nowhere is told now, not when it is made
    command = _command(target, True)

    def compiled(source: str) -> str:
        return _object(folder, command, source, [*sources[source], *common], target, flags=())

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return _link(folder, command, list(pool.map(compiled, sources)), name, target, ("m",))


def _command(target: Platform, host_allowed: bool) -> list[str]:
    """Compiler and the options that both compiling and linking need."""
    of_host = host_compiler() if host_allowed else None
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target.target, "-g0"]
    return of_host or (zig + web.headers() if target == WEB else zig)


def _object(
    folder: Path, command: Sequence[str], source: str, options: Sequence[str], target: Platform, flags: Sequence[str] = FLAGS
) -> str:
    file = f"{source}-{target.name}.o"
    position = [] if target.suffix == ".dll" else ["-fPIC"]
    _run([*command, *options, *flags, *position, "-c", "-o", file, source], folder, target.name)
    return file


def _link(
    folder: Path, command: Sequence[str], objects: Sequence[str], name: str, target: Platform, libraries: Sequence[str]
) -> bytes:
    file = f"{name}-{target.name}{target.suffix}"
    options = ["-shared", "-O3"]  # -O3: without it Zig links a debug library
    if target == WEB:
        options = ["-O2", "-s", "-Wl,--no-entry", "-Wl,--export-dynamic"]
    if target.suffix == ".dylib":
        options += [f"-Wl,-install_name,@rpath/{name}{target.suffix}"]
    if "ziglang" in command or target.suffix == ".so":
        options += ["-s"]
    if "ziglang" not in command and target.suffix == ".so":
        options += ["-Wl,--build-id=none"]
    of_system = [f"-l{library}" for library in libraries] if target.suffix == ".so" else []
    _run([*command, *options, "-o", file, *objects, *of_system], folder, target.name)
    return (folder / file).read_bytes()


def _run(command: Sequence[str], folder: Path, what: str) -> None:
    environment: Mapping[str, str] = {**os.environ, "SOURCE_DATE_EPOCH": "0", "ZERO_AR_DATE": "1", "LC_ALL": "C"}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
            check=False, timeout=PATIENCE,
        )  # fmt: skip
    except OSError as error:
        raise CompilerError(f"the C compiler for {what} cannot be run: {error}") from error
    except subprocess.TimeoutExpired:
        raise CompilerError(f"the C compiler for {what} must be done within {PATIENCE:g} s, it is not") from None
    if done.returncode != 0:
        lines = (
            [line for line in done.stderr.splitlines() if "error" in line.lower()] or done.stderr.splitlines() or ["no message"]
        )
        raise CompilerError(f"the C compiler for {what} failed ({Path(command[0]).name}): {lines[0].strip()}")


def universal(x86_64: bytes, aarch64: bytes) -> bytes:
    """One macOS library for both processors: a fat header, then the two libraries at 16 KiB boundaries."""
    align = 14
    head, offset, libraries = [0xCAFEBABE, 2], 1 << align, b""
    for cpu, subtype, library in ((0x01000007, 3, x86_64), (0x0100000C, 0, aarch64)):
        head += [cpu, subtype, offset, len(library), align]
        padded = library + b"\0" * (-len(library) % (1 << align))
        libraries, offset = libraries + padded, offset + len(padded)
    header = b"".join(word.to_bytes(4, "big") for word in head)
    return header + b"\0" * ((1 << align) - len(header)) + libraries
