"""viser's server behind a token, on a port of our own.

viser opens its port itself, tries the next thousand if it is taken, and asks nobody who they are.
It has no option for any of that, but it makes its listener by one call, `websockets.serve`. While
our server is made, that call is ours: it listens on the socket that we have bound, and refuses
requests without the token. If viser ever makes its listener in another way, there is no server.
"""

import contextlib
import http
import io
import logging
import socket
from collections.abc import Callable, Iterator
from typing import Any

import viser
from websockets.asyncio import server as listener
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from rosbase import ConfigurationError
from rosbase_view.web.address import inner_path

__all__ = ["GuardedServer", "bind"]

_REFUSAL = b"Open the address that rosbase view has printed: it ends in a token.\n"

OnRequest = Callable[[Any, Request], Response | None]


def bind(host: str, port: int) -> socket.socket:
    """Return a socket that listens.

    Args:
        host: An address or a name of this machine.
        port: The port; 0 for one that is free.

    Raises:
        ConfigurationError: The port is in use, or this machine does not have the address.
    """
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(address[:2], family=family)
    except OSError as error:
        # Without create_server's addition, which repeats the address.
        reason = (error.strerror or str(error)).partition(" (while")[0]
        raise ConfigurationError(f"cannot listen on {host} port {port}: {reason}") from None


class GuardedServer(viser.ViserServer):
    """A server whose page and messages only those see who know the token."""

    def __init__(self, listening: socket.socket, token: str, label: str) -> None:
        """Serve on a socket that listens. The server closes it.

        Args:
            listening: The socket, as from `bind`.
            token: What the path of each request must start with.
            label: Title of the panel.
        """
        with _guarded(listening, token) as used, _silent():
            super().__init__(host="127.0.0.1", port=0, label=label, verbose=False)
        if not used:
            # A server without the guard.
            self.stop()
            raise ConfigurationError(f"viser {viser.__version__} is not supported")
        # Makes the scene public on a server of viser's authors; any browser may ask for it.
        self.gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Return None: what a robot does is never put on another's server."""
        return None

    def stop(self) -> None:
        """Close all connections, and end the threads."""
        with _silent():
            super().stop()


@contextlib.contextmanager
def _guarded(listening: socket.socket, token: str) -> Iterator[list[bool]]:
    """Make viser's listener ours, once; the list says afterwards whether that was used."""
    serve, used = listener.serve, []

    def guarded_serve(
        handler: Any, _host: str, _port: int, *, process_request: OnRequest, **options: Any
    ) -> Any:
        used.append(True)
        answer = _guard(process_request, token)
        return serve(handler, sock=listening, process_request=answer, logger=_log(), **options)

    listener.serve = guarded_serve  # type: ignore[misc,assignment]  # as described above
    try:
        yield used
    finally:
        listener.serve = serve  # type: ignore[misc]  # as above


def _guard(answer: OnRequest, token: str) -> OnRequest:
    """Return a function that refuses requests without the token, and passes on the others."""

    def guarded(connection: Any, request: Request) -> Response | None:
        path = inner_path(request.path, token)
        if path is None:
            headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(_REFUSAL))})
            return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", headers, _REFUSAL)
        response = answer(connection, Request(path, request.headers))
        if response is not None:
            # The token is part of the address, which no other page may learn.
            response.headers["Referrer-Policy"] = "no-referrer"
        return response

    return guarded


def _log() -> logging.Logger:
    """Return the log of the connections, without a traceback for each that is no request."""
    log = logging.getLogger("rosbase_view.web")
    log.addFilter(_is_worth_telling)
    return log


def _is_worth_telling(record: logging.LogRecord) -> bool:
    return record.getMessage() != "opening handshake failed"


def _silent() -> contextlib.AbstractContextManager[Any]:
    """Keep what viser prints at the start and at the end off the terminal."""
    return contextlib.redirect_stdout(io.StringIO())
