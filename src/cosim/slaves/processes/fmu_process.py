"""The program in an isolated FMU's process: it opens the FMU and does what isolated.py asks."""

import sys
from multiprocessing.connection import Connection
from typing import Any

from ...errors import EndRequest, OutputError, SlaveError
from ..fmi.log import shown
from ..opening import open_fmu
from . import child


def serve(connection: Connection) -> None:
    """The child: open one FMU and do what is asked until `close` or the parent is gone."""
    slave: Any = None
    snapshots: dict[int, Any] = {}
    messages: list[tuple[int, str, str]] = []
    count = 0

    def heard(*message: Any) -> None:
        """What the FMU says goes to the parent with the next answer, and into the file, should there be none."""
        messages.append(message)
        print(shown(message), flush=True)

    while True:
        try:
            what, arguments = connection.recv()
        except (EOFError, OSError):
            break
        if what == "close":
            break
        answer: Any = None
        kind = "done"
        try:
            if what == "open":
                slave = open_fmu(*arguments)
                slave.log.listen(heard)
                answer = slave.description
            elif what == "save":
                count += 1
                snapshots[count], answer = slave.save(), count
            elif what == "restore":
                slave.restore(snapshots[arguments[0]])
            elif what == "discard":
                slave.discard(snapshots.pop(arguments[0]))
            else:
                answer = getattr(slave, what)(*arguments)
        except SlaveError as error:
            kind = "output" if isinstance(error, OutputError) else "slave"
            answer = (error.t, error.h, error.reason, error.log)
        except EndRequest as request:
            kind, answer = "end", request.t
        except ValueError as error:
            kind, answer = "value", str(error)
        except Exception as error:  # whatever it is, the parent needs one line
            kind, answer = "other", f"{type(error).__name__}: {error}"
        connection.send((kind, answer, None if slave is None else slave.counts.events, messages))
        messages.clear()
    if slave is not None:
        slave.close()


def main() -> None:
    """Arguments: the number of the socket, the parent's process id."""
    if child.belongs():
        serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
