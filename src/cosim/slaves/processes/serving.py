"""The other end: offers a slave to a master over a stream, until that one leaves. See protocol.py for the frames."""

import json
import socket
import struct
import sys
from pathlib import Path
from typing import Any

from ...errors import EndRequest, RunError
from ..base import Slave, restorable
from ..opening import open_slave
from . import child
from .protocol import Kind, Link, ProtocolError, array, document, numbers
from .telling import introduction, number, read_values


def serve(slave: Slave, link: Link) -> None:
    """Answer a master until it says BYE or is gone. The slave stays open."""
    failed, ended = "", b""
    states = restorable(slave)
    snapshots: dict[int, Any] = {}
    count = 0
    while True:
        try:
            kind, sequence, payload = link.receive()
        except (EOFError, OSError, ProtocolError):
            return
        if kind == Kind.BYE:
            return
        answer = b""
        try:
            if kind in (Kind.START, Kind.BEGIN):
                failed, ended = "", b""
                given = document(payload)
                begin = slave.initialize if kind == Kind.START else slave.begin
                begin(read_values(given.get("values")), number(given, "t"), number(given, "stop"))
            elif failed or ended:
                pass
            elif kind == Kind.FINISH:
                slave.finish()
            elif kind == Kind.HELLO:
                answer = json.dumps(introduction(slave)).encode()
            elif kind == Kind.OUTPUT:
                t, *u = array(payload, 1 + len(slave.inputs))
                answer = numbers(slave.output(array(numbers(u), len(slave.inputs)), float(t)))
            elif kind == Kind.STEP:
                whole = array(payload, 2 + 3 * len(slave.inputs))
                slave.step(whole[2:].reshape(3, -1), float(whole[0]), float(whole[1]))
            elif kind == Kind.SAVE and states is not None:
                count += 1
                snapshots[count] = states.save()
                answer = struct.pack("<Q", count)
            elif kind == Kind.RESTORE and states is not None:
                states.restore(snapshots[struct.unpack("<Q", payload)[0]])
            elif kind == Kind.DISCARD and states is not None:
                states.discard(snapshots.pop(struct.unpack("<Q", payload)[0]))
            elif kind in (Kind.SAVE, Kind.RESTORE, Kind.DISCARD):
                failed = f"component {slave.name!r} cannot restore its state"
        except EndRequest as request:
            ended = numbers(request.t)
        except (RunError, ValueError, KeyError, struct.error) as error:
            failed = str(error)
        if kind == Kind.STEP:
            continue
        try:
            told = (Kind.ERROR, failed.encode()) if failed else (Kind.END, ended) if ended else (Kind.OK, answer)
            link.send(told[0], sequence, told[1])
        except OSError:
            return


def listen(slave: Slave, address: tuple[str, int], *, once: bool = False, ready: Any = None) -> None:
    """Offer the slave at (host, port) to one master after another; `ready` is called with the port that was taken."""
    with socket.create_server(address) as server:
        if ready is not None:
            ready(server.getsockname()[1])
        while True:
            stream, _ = server.accept()
            link = Link(stream)
            try:
                serve(slave, link)
            finally:
                link.close()
            if once:
                return


def main(source: str, descriptor: int) -> None:
    """The child of gyro_cosim.slaves.processes.remote: serves on an inherited socket."""
    link = Link(socket.socket(fileno=descriptor))
    try:
        slave = open_slave("unit", source, in_process=True)
    except Exception as error:  # whatever is wrong with the unit, the master shall hear of it
        _, sequence, _ = link.receive()
        link.send(Kind.ERROR, sequence, str(error).encode())
        return
    try:
        serve(slave, link)
    finally:
        slave.close()


if __name__ == "__main__":
    sys.path.append(str(Path.cwd()))  # a package of the user's that stands there, after all others: it takes no name from them
    if child.belongs():
        main(sys.argv[1], int(sys.argv[2]))
