"""A unit at a port: one master after another, each of them kept to the rules, the others told to wait."""

import contextlib
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType

from ..base import Slave
from ..signal import Value
from .admission import Admission
from .protocol import Kind, Link, ProtocolError
from .serving import Limits, serve

__all__ = ["listen"]

BUSY = b"serves another master; one at a time"
WINDOW = 10.0  # s that connections are counted over
NEVER_MIND = 0.2  # s between two looks for whoever else would like to be served, and that the one before may take to be gone


def listen(
    slave: Slave, address: tuple[str, int], *, once: bool = False, ready: Callable[[int], None] | None = None,
    limits: Limits | None = None, admission: Admission | None = None, values: Mapping[str, Value] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Offer the slave at (host, port) to one master after another; `ready` is called with the port that was taken.

    values : that it starts with where a master gives none.
    """
    rules = limits or Limits()
    came: deque[float] = deque(maxlen=rules.rate)
    with socket.create_server(address) as server:
        if ready is not None:
            ready(server.getsockname()[1])
        while True:
            stream, _ = server.accept()
            if len(came) == rules.rate and time.monotonic() - came[0] < WINDOW:
                stream.close()
                continue
            came.append(time.monotonic())
            with contextlib.closing(stream), _others_told(server):
                try:
                    link = (admission or Admission()).admit(stream)
                except (OSError, EOFError, ProtocolError):
                    continue
                with contextlib.closing(link):
                    serve(slave, link, rules, values)
            if once:
                return


@contextlib.contextmanager
def _others_told(server: socket.socket):  # type: ignore[no-untyped-def]
    """While it lasts, whoever else connects is told that the unit is taken."""
    over = threading.Event()

    def tell() -> None:
        while not over.is_set():
            if not select.select([server], [], [], NEVER_MIND)[0] or over.wait(NEVER_MIND):
                continue
            with contextlib.suppress(OSError):
                stream, _ = server.accept()
                with stream:
                    Link(stream).send(Kind.ERROR, 1, BUSY, timeout=NEVER_MIND)
                    stream.shutdown(socket.SHUT_WR)
                    # closed with a question unread, the stream would take the answer with it
                    while not over.is_set() and stream.recv(65536):
                        pass

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()
