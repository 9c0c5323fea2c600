"""viser's listener, on our socket and behind the token.

viser opens its port itself, tries the next thousand if it is taken, and asks nobody who they are.
It has no option for any of that, but it makes its listener by one call, `websockets.serve`. While
viser's server is made, that call is ours.
"""

import contextlib
import http
import logging
import secrets
import socket
from collections.abc import Callable, Iterator
from typing import Any
from weakref import WeakSet

from websockets.asyncio import server as listener
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from rosbase_view.web.address import inner_path
from rosbase_view.web.watch import ALIVE, with_watch

__all__ = ["Guard"]

# For browsers that do not answer, such as one on a suspended machine.
_CLOSE_S = 1.0
_REFUSAL = b"Open the address that rosbase view has printed: it ends in a token.\n"

OnRequest = Callable[[Any, Request], Response | None]


class Guard:
    """Refuses requests without the token, before viser sees them."""

    def __init__(self, listening: socket.socket, token: str) -> None:
        """Guard a socket that listens, by what the path of each request must start with."""
        self.is_used = False
        """Whether viser has made its listener by our call."""
        self._listening, self._token = listening, token
        # Another one after each start, by which a page finds out.
        self._word = secrets.token_hex(8).encode()
        self._answer: OnRequest = _answer_nothing
        self._connections: WeakSet[Any] = WeakSet()

    @contextlib.contextmanager
    def in_place(self) -> Iterator[None]:
        """Take the place of `websockets.serve`, until the server is made."""
        self._serve = listener.serve
        listener.serve = self._guarded_serve  # type: ignore[misc,assignment]  # as described above
        try:
            yield
        finally:
            listener.serve = self._serve  # type: ignore[misc]  # as above

    def abort(self) -> None:
        """Cut all connections. Called on viser's thread.

        To close one politely, the browser must read first what it was sent.
        """
        for connection in list(self._connections):
            connection.transport.abort()

    def _guarded_serve(
        self, handler: Any, _host: str, _port: int, *, process_request: OnRequest, **options: Any
    ) -> Any:
        self.is_used = True
        self._answer = process_request
        return self._serve(
            handler,
            sock=self._listening,
            process_request=self._check,
            logger=_log(),
            close_timeout=_CLOSE_S,
            **options,
        )

    def _check(self, connection: Any, request: Request) -> Response | None:
        path = inner_path(request.path, self._token)
        if path is None:
            return _text(http.HTTPStatus.FORBIDDEN, _REFUSAL)
        if path == ALIVE:
            return _text(http.HTTPStatus.OK, self._word)
        self._connections.add(connection)
        response = self._answer(connection, Request(path, request.headers))
        if response is not None:
            response = with_watch(response)
            # The token is part of the address, which no other page may learn.
            response.headers["Referrer-Policy"] = "no-referrer"
        return response


def _text(status: http.HTTPStatus, body: bytes) -> Response:
    headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))})
    return Response(status, status.phrase, headers, body)


def _answer_nothing(_: Any, request: Request) -> Response | None:
    return Response(http.HTTPStatus.NOT_FOUND, "Not Found", Headers(), b"")


def _log() -> logging.Logger:
    """Return the log of the connections, without a traceback for each that is no request."""
    log = logging.getLogger("rosbase_view.web")
    log.addFilter(_is_worth_telling)
    return log


def _is_worth_telling(record: logging.LogRecord) -> bool:
    return record.getMessage() != "opening handshake failed"
