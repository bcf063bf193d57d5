"""An FMU unpacked and loaded once, for all slaves of a network that run the same file."""

import ctypes
from functools import cached_property
from typing import Any

from ...systems import archive, catalogue
from ..description import SlaveDescription
from ..scratch import ScratchFolder
from . import sources
from .description import MEMBER, Description, read
from .library import Library, library_file
from .log import Log
from .signals import described

LOGGER_2 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class Callbacks2(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER_2), ("allocate", ctypes.c_void_p), ("free", ctypes.c_void_p), ("step_finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    )  # fmt: skip


class OpenedFmu:
    """The FMU at `location` in a temporary folder, which goes when the last slave has released it.

    logs : log of each slave that listens, by the number that it gives its FMU as environment.
    """

    def __init__(self, location: str, implementation: str = "") -> None:
        self.location, self.users = location, 0
        self.model: Description = read(location, implementation)
        self.logs: dict[int, Log] = {}
        self._scratch = ScratchFolder()
        self.folder = self._scratch.path
        self._formatted: Any = None
        self._kept: list[Any] = []
        try:
            with archive.opened(location) as members:
                archive.unpack(members, self.folder, ("binaries/", "resources/", MEMBER))
                identifier = self.model.interfaces[self.model.interface]["modelIdentifier"]
                binary = library_file(self.folder, self.model.version, identifier)
                if not binary.is_file():
                    archive.unpack(members, self.folder, (f"{sources.FOLDER}/",))
                    sources.compile_into(self.folder, self.model, binary, f"FMU {location!r}")
            self.library = Library(self.folder, self.model.version, identifier, f"FMU {location!r}")
        except BaseException:
            self._scratch.remove()
            raise

    @cached_property
    def description(self) -> SlaveDescription:
        """The FMU as a slave, the same for every one of them."""
        return described(self.model)

    @property
    def shareable(self) -> bool:
        """Whether a second slave may run on the same copy."""
        return not self.model.can("canBeInstantiatedOnlyOncePerProcess")

    def take(self) -> "OpenedFmu":
        """For a slave that will release it."""
        self.users += 1
        return self

    def release(self) -> None:
        """A slave needs it no longer."""
        self.users -= 1
        if self.users == 0:
            self.library.close()
            self._scratch.remove()

    def logger_2(self) -> Any:
        """The address of an FMI 2.0 logger that formats messages and hands them to the slave that listens."""
        if self._formatted is None:
            logger = LOGGER_2(self._on_message)
            callbacks = Callbacks2(logger)
            self.library.format_messages(callbacks, self.folder)
            self._kept = [logger, callbacks]
            self._formatted = ctypes.cast(callbacks.logger, ctypes.c_void_p).value
        return LOGGER_2(self._formatted)

    def _on_message(self, environment: int | None, instance: bytes, status: int, category: bytes, message: bytes) -> None:
        every = list(self.logs.values())
        named = [log for log in every if log.name.encode() == instance]  # FMI 1.0 says nothing else
        for log in [self.logs[environment or 0]] if (environment or 0) in self.logs else named or every:
            log.add(status, category, message)


class FmuCache:
    """The FMUs that a network has opened; one for each file, but for those that refuse a second instance."""

    def __init__(self) -> None:
        self._opened: dict[tuple[str, str], OpenedFmu] = {}
        self._locations: dict[str, str] = {}

    def location(self, source: str) -> str:
        """Where the FMU of a source is, built if need be."""
        if source not in self._locations:
            self._locations[source] = source if source.endswith(".fmu") else str(catalogue.fmu(source))
        return self._locations[source]

    def occupied(self, location: str, implementation: str = "") -> bool:
        """Whether the FMU at `location` is open and refuses a second instance in this process."""
        opened = self._opened.get((location, implementation))
        return opened is not None and opened.users > 0 and not opened.shareable

    def take(self, location: str, implementation: str = "") -> OpenedFmu:
        """The FMU at `location`, run as `implementation` says, for a slave that will release it."""
        opened = self._opened.get((location, implementation))
        if opened is None or opened.users == 0 or not opened.shareable:
            opened = self._opened[location, implementation] = OpenedFmu(location, implementation)
        return opened.take()
