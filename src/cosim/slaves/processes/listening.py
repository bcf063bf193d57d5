"""A unit at a port: one master after another, each of them kept to the rules, the others told to wait."""

import contextlib
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable

from ..base import Slave
from .admission import Admission
from .protocol import Kind, Link, ProtocolError
from .serving import Limits, serve

__all__ = ["listen"]

BUSY = b"serves another master; one at a time"
RATE, WINDOW = 20, 10.0  # connections that are looked at in so many seconds; more are closed at once
NEVER_MIND = 0.2  # s between two looks for whoever else would like to be served


def listen(
    slave: Slave, address: tuple[str, int], *, once: bool = False, ready: Callable[[int], None] | None = None,
    limits: Limits | None = None, admission: Admission | None = None,
) -> None:  # fmt: skip
    """Offer the slave at (host, port) to one master after another; `ready` is called with the port that was taken."""
    came: deque[float] = deque(maxlen=RATE)
    with socket.create_server(address) as server:
        if ready is not None:
            ready(server.getsockname()[1])
        while True:
            stream, _ = server.accept()
            if len(came) == RATE and time.monotonic() - came[0] < WINDOW:
                stream.close()
                continue
            came.append(time.monotonic())
            with contextlib.closing(stream), _others_told(server):
                try:
                    link = (admission or Admission()).admit(stream)
                except (OSError, EOFError, ProtocolError):
                    continue
                with contextlib.closing(link):
                    serve(slave, link, limits or Limits())
            if once:
                return


@contextlib.contextmanager
def _others_told(server: socket.socket):  # type: ignore[no-untyped-def]
    """While it lasts, whoever else connects is told that the unit is taken."""
    over = threading.Event()

    def tell() -> None:
        while not over.is_set():
            if not select.select([server], [], [], NEVER_MIND)[0] or over.is_set():
                continue
            with contextlib.suppress(OSError):
                stream, _ = server.accept()
                with stream:
                    Link(stream).send(Kind.ERROR, 1, BUSY, timeout=NEVER_MIND)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()
