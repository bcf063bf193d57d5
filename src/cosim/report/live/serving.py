"""HTTP on 127.0.0.1 for the viewers of one run. The address holds a token that nobody can guess.

    GET  /TOKEN/         the page. Whoever asks first gets a cookie with which he steers; all others watch.
    GET  /TOKEN/events   what is new, ten times a second, as server-sent events
    POST /TOKEN/do       a wish, as JSON; only with the cookie

Each viewer has a thread, which sends what he has not seen yet and waits for him alone.
"""

import base64
import hmac
import json
import secrets
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socket import socket
from types import TracebackType
from typing import Any

import numpy as np

from .film import Cursor, Film
from .steering import Steering

__all__ = ["Served"]

CONNECTIONS = 24  # at once
VIEWERS = 8  # at once
LONGEST = 2048  # bytes of a wish
SLOW = 10.0  # s that a viewer may take to read or to ask
EVERY = 0.1  # s between two events
LEAVE = 2.0  # s for viewers to hear of the end
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; "
    "img-src data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Served:
    """Serves a run from `with` to its end; afterwards no thread and no port is left.

    Parameters
    ----------
    page : str
        HTML.
    film : Film
        What is shown.
    steering : Steering
        What carries wishes into the run.
    """

    def __init__(self, page: str, film: Film, steering: Steering) -> None:
        self.page, self.film, self.steering = page.encode(), film, steering
        self.token, self.key = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        self.claimed = threading.Lock()  # taken once, by who steers
        self.viewers = threading.BoundedSemaphore(VIEWERS)
        self.ended = threading.Event()
        self._watching = 0
        self._server = _Server(self)
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)

    @property
    def host(self) -> str:
        """As browsers name it."""
        return f"127.0.0.1:{self._server.server_address[1]}"

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{self.host}/{self.token}/"

    def __enter__(self) -> "Served":
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.steering.over()
        self.ended.set()
        self._server.shutdown()
        self._thread.join()
        self._server.finish(LEAVE)


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False  # finish() waits, not for ever
    request_queue_size = 16

    def __init__(self, served: Served) -> None:
        self._room = threading.BoundedSemaphore(CONNECTIONS)
        self._open: set[socket] = set()
        self._closing = threading.Lock()
        super().__init__(("127.0.0.1", 0), _handler(served))

    def process_request(self, request: Any, client_address: Any) -> None:
        """In a thread of its own, where there is room."""
        if not self._room.acquire(blocking=False):
            self.shutdown_request(request)
            return
        with self._closing:
            self._open.add(request)
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """See ThreadingHTTPServer."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            with self._closing:
                self._open.discard(request)
            self._room.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A viewer who is gone is no error."""

    def finish(self, patience: float) -> None:
        """Wait for those who are being served, no longer than so many seconds, and close the port."""
        done = threading.Event()
        for _ in range(int(patience / 0.02)):
            with self._closing:
                if not self._open:
                    break
            done.wait(0.02)
        with self._closing:
            for request in tuple(self._open):
                request.close()
        self.server_close()


def _handler(served: Served) -> Callable[..., BaseHTTPRequestHandler]:
    """A class of handlers that know whom they serve."""

    class Handler(BaseHTTPRequestHandler):
        timeout = SLOW
        server_version, sys_version = "cosim", ""

        def log_message(self, format: str, *args: Any) -> None:
            """Nothing: the terminal belongs to the run."""

        def do_GET(self) -> None:
            if self._wrong(posted=False):
                return
            if self.path == f"/{served.token}/":
                self._page()
            elif self.path == f"/{served.token}/events":
                self._events()
            else:
                self._refuse(404, "there is nothing here")

        def do_POST(self) -> None:
            if self._wrong(posted=True):
                return None
            if self.path != f"/{served.token}/do":
                return self._refuse(404, "there is nothing here")
            if not self._steers():
                return self._refuse(403, "someone else steers this run")
            size = self.headers.get("Content-Length", "")
            if not (size.isascii() and size.isdecimal() and int(size) <= LONGEST):
                return self._refuse(413, f"a wish must be of at most {LONGEST} bytes")
            try:
                wish = json.loads(self.rfile.read(int(size)))
                served.steering.want(wish if isinstance(wish, dict) else {})
            except (ValueError, RecursionError) as error:
                return self._refuse(400, str(error))
            return self._answer(200, "application/json", b"{}")

        def _wrong(self, *, posted: bool) -> bool:
            """Whether the request comes from elsewhere than the page, and has been refused."""
            own = f"http://{served.host}"
            origin, site = self.headers.get("Origin"), self.headers.get("Sec-Fetch-Site", "none")
            place = self.path.split("/")[1] if self.path.startswith("/") else ""
            if self.headers.get_all("Host") != [served.host]:
                self._refuse(403, "the host must be the one of the address")
            elif origin not in ((own,) if posted else (None, own)) or site not in ("same-origin", "none"):
                self._refuse(403, "requests must come from the page")
            elif not hmac.compare_digest(place.encode(), served.token.encode()):
                self._refuse(404, "there is nothing here")
            elif posted and self.headers.get_content_type() != "application/json":
                self._refuse(415, "a wish must be JSON")
            else:
                return False
            return True

        def _steers(self) -> bool:
            cookies = (part.strip().partition("=") for part in self.headers.get("Cookie", "").split(";"))
            return any(name == "steer" and hmac.compare_digest(key.encode(), served.key.encode()) for name, _, key in cookies)

        def _page(self) -> None:
            first = not self._steers() and served.claimed.acquire(blocking=False)
            cookie = f"steer={served.key}; HttpOnly; SameSite=Strict; Path=/{served.token}/"
            self._answer(200, "text/html; charset=utf-8", served.page, {"Set-Cookie": cookie} if first else {})

        def _events(self) -> None:
            if not served.viewers.acquire(blocking=False):
                return self._refuse(503, f"there may be {VIEWERS} viewers, not more")
            try:
                self._head(200, "text/event-stream", {})
                self._stream()
            except OSError:
                pass  # the viewer is gone, or too slow
            finally:
                served.viewers.release()
            return None

        def _stream(self) -> None:
            cursor: Cursor | None = None
            steers = self._steers()
            while True:
                last = served.ended.is_set()
                frame, cursor = served.film.since(cursor)
                told = served.steering.told() | {"steers": steers, "anew": frame.anew, "rows": len(frame.t)}
                if len(frame.t):
                    told |= {"times": _packed(frame.t, "<f8"), "columns": _packed(frame.values.T, "<f4")}
                self.wfile.write(f"data: {json.dumps(told)}\n\n".encode())
                if last:
                    return
                served.ended.wait(EVERY)

        def _refuse(self, code: int, why: str) -> None:
            self._answer(code, "application/json", json.dumps({"error": why}).encode())

        def _answer(self, code: int, kind: str, body: bytes, more: dict[str, str] | None = None) -> None:
            self._head(code, kind, {"Content-Length": str(len(body)), **(more or {})})
            self.wfile.write(body)

        def _head(self, code: int, kind: str, more: dict[str, str]) -> None:
            self.close_connection = True
            self.send_response(code)
            fixed = {
                "Content-Type": kind, "Connection": "close", "Cache-Control": "no-store", "X-Content-Type-Options": "nosniff",
                "Content-Security-Policy": POLICY, "Referrer-Policy": "no-referrer", "Cross-Origin-Opener-Policy": "same-origin",
                "Cross-Origin-Resource-Policy": "same-origin", "X-Frame-Options": "DENY",
            }  # fmt: skip
            for name, value in {**fixed, **more}.items():
                self.send_header(name, value)
            self.end_headers()

    return Handler


def _packed(numbers: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers, dtype=kind).tobytes()).decode()
