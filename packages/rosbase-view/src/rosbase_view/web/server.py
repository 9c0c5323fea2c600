"""viser's server on a port of our own, for those who know the token."""

import contextlib
import io
import socket
from typing import Any

import viser

from rosbase import ConfigurationError
from rosbase_view.web.guard import Guard

__all__ = ["GuardedServer", "bind"]


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

        Raises:
            ConfigurationError: This version of viser makes its listener in another way.
        """
        self._guard = Guard(listening, token)
        with self._guard.in_place(), _silent():
            super().__init__(host="127.0.0.1", port=0, label=label, verbose=False)
        if not self._guard.is_used:
            # A server without the guard.
            self.stop()
            raise ConfigurationError(f"viser {viser.__version__} is not supported")
        # It makes the scene public on a server of viser's authors.
        self.gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Return None, also to a browser that asks for it without the button."""
        return None

    def stop(self) -> None:
        """Close all connections, and end the threads."""
        with contextlib.suppress(RuntimeError):
            # The loop of a server that was stopped is closed.
            self.get_event_loop().call_soon_threadsafe(self._guard.abort)
        with _silent():
            super().stop()


def _silent() -> contextlib.AbstractContextManager[Any]:
    """Keep what viser prints at the start and at the end off the terminal."""
    return contextlib.redirect_stdout(io.StringIO())
