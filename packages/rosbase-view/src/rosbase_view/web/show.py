"""Show a source in browsers."""

import contextlib
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

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def check(options: Options) -> None:
    """Check the token.

    Raises:
        ConfigurationError: It is too short, or has other characters than an address takes.
    """
    if options.token is not None:
        checked_token(options.token, "--token")


def run(source: Source, options: Options) -> int:
    """Serve the page until Ctrl-C or SIGTERM; return the exit status.

    Raises:
        ConfigurationError: The port is in use, or this machine does not have the address.
    """
    token = options.token or new_token()
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
