"""Show a source in browsers."""

from rosbase import SystemClock
from rosbase_view.options import Options
from rosbase_view.source import Source
from rosbase_view.web.address import checked_token, new_token, page_url
from rosbase_view.web.page import Page
from rosbase_view.web.server import bind

__all__ = ["check", "run"]


def check(options: Options) -> None:
    """Check the token.

    Raises:
        ConfigurationError: It is too short, or has other characters than an address takes.
    """
    if options.token is not None:
        checked_token(options.token, "--token")


def run(source: Source, options: Options) -> int:
    """Serve the page until Ctrl-C; return the exit status.

    Raises:
        ConfigurationError: The port is in use, or this machine does not have the address.
    """
    token = options.token or new_token()
    listening = bind(options.host, options.port)
    # A port of 0 is one that is free.
    port = listening.getsockname()[1]
    page = Page(source, listening, token, SystemClock())
    print(f"rosbase view: open {page_url(options.host, port, token)} (Ctrl-C to end)", flush=True)
    try:
        page.run()
    except KeyboardInterrupt:
        # The way to end it.
        pass
    return 0
