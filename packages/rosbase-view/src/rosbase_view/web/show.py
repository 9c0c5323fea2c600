"""Show a source in browsers."""

import contextlib
import os
import signal
import socket
from collections.abc import Iterator

from rosbase import SystemClock
from rosbase_view.options import Options
from rosbase_view.source import Source
from rosbase_view.web.address import checked_token, new_token, page_url
from rosbase_view.web.page import Page
from rosbase_view.web.server import bind

__all__ = ["check", "run"]

_VARIABLE = "ROSBASE_VIEW_TOKEN"
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def check(_: Options) -> None:
    """Check the token of the user, if there is one.

    Raises:
        ConfigurationError: It is too short, or has other characters than an address takes.
    """
    _token()


def run(source: Source, options: Options) -> int:
    """Serve the page until Ctrl-C or SIGTERM; return the exit status.

    Raises:
        ConfigurationError: The port is in use, or this machine does not have the address.
    """
    token = _token() or new_token()
    listening = bind(options.host, options.port)
    # A port of 0 is one that is free.
    port = listening.getsockname()[1]
    page = Page(source, listening, token, SystemClock())
    try:
        with _interruptible():
            url = page_url(options.host, port, token, socket.gethostname())
            print(f"rosbase view: open {url} (Ctrl-C to end)", flush=True)
            page.run()
    except KeyboardInterrupt:
        # The way to end it.
        pass
    return 0


def _token() -> str:
    """Return the token of the user, who wants the same address each time; empty if there is none.

    It is no argument: other users see those in the list of processes.
    """
    token = os.environ.get(_VARIABLE, "")
    return checked_token(token, _VARIABLE) if token else ""


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt for Ctrl-C, which ends other commands at once, and for SIGTERM."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
