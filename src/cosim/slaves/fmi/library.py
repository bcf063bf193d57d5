"""An FMU's shared library: found for this machine, loaded, its functions with their types."""

import _ctypes
import ctypes
import importlib.util
import logging
import os
import platform
import shutil
import sys
import threading
from pathlib import Path
from typing import Any

from .surroundings import kept

REFERENCES = ctypes.POINTER(ctypes.c_uint)
POINTER, SIZE = ctypes.c_void_p, ctypes.c_size_t

SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
_log = logging.getLogger(__name__)
STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")


def status_word(status: int) -> str:
    """What FMI calls a status."""
    return STATUS[status] if 0 <= status < len(STATUS) else f"status {ctypes.c_int(status).value}, which FMI does not know"


def folders() -> tuple[str, str]:
    """What FMI 2.0 and FMI 3.0 call this platform in an FMU's binaries."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    old = {"windows": "win", "darwin": "darwin", "linux": "linux"}[system] + "64"
    return (old if machine == "x86_64" or system == "darwin" else f"{machine}-{system}"), f"{machine}-{system}"


def library_file(folder: Path, version: str, identifier: str) -> Path:
    """Where the library for this machine is in an FMU of FMI `version` unpacked in `folder`, if it has one."""
    return folder / "binaries" / folders()[version == "3"] / f"{identifier}{SUFFIX}"


class Library:
    """The library of the FMU unpacked in `folder`; `where` begins every complaint."""

    def __init__(self, folder: Path, version: str, identifier: str, where: str) -> None:
        name, file = folders()[version == "3"], library_file(folder, version, identifier)
        if not file.is_file():
            binaries = folder / "binaries"
            held = sorted(p.name for p in binaries.iterdir() if any(p.iterdir())) if binaries.is_dir() else []
            if name in held:
                held = sorted(f"{name}/{p.name}" for p in file.parent.iterdir())
            raise ValueError(f"{where} must hold a binary for {name}, {identifier}{SUFFIX}; has {', '.join(held) or 'none'}")
        self._threads = _foreign_threads()
        try:
            with kept(where):
                self._library = ctypes.CDLL(str(file), winmode=0x8)  # on Windows: look beside the file for what it needs
        except OSError as error:
            raise ValueError(f"{where}: its binary cannot be loaded: {error}") from None
        self._where = where
        prefixed = version == "1" or hasattr(self._library, f"{identifier}_fmi{version}GetVersion")  # as FMUs of sources may be
        self._begin = f"{identifier}_" if prefixed else ""
        self._functions: dict[tuple[Any, ...], Any] = {}
        self._formatting: ctypes.CDLL | None = None

    def function(self, name: str, *types: Any, result: Any = ctypes.c_uint) -> Any:
        """The function `name`; ValueError if the library lacks it. Its status is above all that FMI knows where it is below 0."""
        known = self._functions.get((name, types, result))
        if known is not None:
            return known
        try:
            function = self._library[self._begin + name]  # an own handle: its argument types are ours to state
        except AttributeError:
            raise ValueError(f"{self._where}: its binary lacks the function {self._begin}{name}") from None
        function.argtypes, function.restype = types, result
        self._functions[name, types, result] = function
        return function

    def address(self, name: str) -> int:
        """Where the function `name` is, for C code."""
        return ctypes.cast(self.function(name), POINTER).value or 0

    def close(self) -> None:
        """Unload it; no function may be called afterwards. One whose threads still run stays: they would run into nothing."""
        if self._library is not None and _foreign_threads() > self._threads:
            _log.warning("%s has left threads running, so its library stays loaded", self._where)
            self._library = None  # type: ignore[assignment]
            self._formatting = None
        for library in (self._library, self._formatting):  # in this order: the first may still log
            if library is not None:
                getattr(_ctypes, "FreeLibrary" if sys.platform == "win32" else "dlclose")(library._handle)
        self._library = self._formatting = None  # type: ignore[assignment]

    def format_messages(self, callbacks: Any, folder: Path) -> None:
        """Put a logger that formats messages in front of that of an FMU's fmi2CallbackFunctions, where there is one."""
        self._formatting = formatting_library(folder)
        if self._formatting is not None:
            self._formatting.addLoggerProxy(ctypes.byref(callbacks))


def _foreign_threads() -> int:
    """How many threads of this process are none of Python's; 0 where that cannot be told."""
    try:
        numbers = {int(entry.name) for entry in os.scandir("/proc/self/task")}
    except OSError:
        return 0
    return len(numbers - {thread.native_id for thread in threading.enumerate()})


def formatting_library(folder: Path) -> ctypes.CDLL | None:
    """FMI 2.0's logger gets printf arguments, which Python cannot read. FMPy ships a few lines of C that format them.

    They keep the logger they serve in a static variable, so every FMU gets a copy of its own, in `folder`. None where FMPy has
    none for this machine; a message then shows its format.
    """
    spec = importlib.util.find_spec("fmpy")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        file = Path(place) / "logging" / folders()[0] / f"logging{SUFFIX}"
        if file.is_file():
            copy = folder / f"logging{SUFFIX}"
            shutil.copyfile(file, copy)
            try:
                library = ctypes.CDLL(str(copy))
                library.addLoggerProxy.argtypes, library.addLoggerProxy.restype = [ctypes.c_void_p], None
            except (OSError, AttributeError):
                return None
            return library
    return None
