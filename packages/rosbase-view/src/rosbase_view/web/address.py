"""Address of the page, and which requests may see it. Pure.

viser checks nothing: everybody who reaches its port sees all and presses every button. This
includes each page of the web that a browser of this machine has open, because a script may
connect to any port of 127.0.0.1. So the path of the page starts with a secret token, and a
request without it is refused. viser's client connects to the path that it was loaded from.
"""

import hmac
import re
import secrets
from ipaddress import ip_address

from rosbase import ConfigurationError

__all__ = ["LEAST_TOKEN", "checked_token", "inner_path", "new_token", "page_url"]

LEAST_TOKEN = 16
"""Characters that a token needs at least."""

_BYTES = 16
_TOKEN = re.compile(rf"[A-Za-z0-9_-]{{{LEAST_TOKEN},128}}")


def new_token() -> str:
    """Return a token that nobody can guess, of 22 characters."""
    return secrets.token_urlsafe(_BYTES)


def checked_token(text: str, name: str) -> str:
    """Return a token that the user has chosen.

    Args:
        text: The token.
        name: Where it comes from, for the error.

    Raises:
        ConfigurationError: It is too short, or has characters that have a meaning in an address.
    """
    if _TOKEN.fullmatch(text) is None:
        raise ConfigurationError(
            f"{name} needs {LEAST_TOKEN} to 128 characters, of letters, digits, '-' and '_'"
        )
    return text


def inner_path(path: str, token: str) -> str | None:
    """Return the path behind the token; None if the token is missing or wrong.

    Args:
        path: Target of the request, as the browser has sent it.
        token: The token of this view.
    """
    given, slash, rest = path.removeprefix("/").partition("?")[0].partition("/")
    # Takes the same time wherever they differ.
    if not hmac.compare_digest(given.encode(errors="replace"), token.encode()):
        return None
    return f"{slash or '/'}{rest}"


def page_url(host: str, port: int, token: str, name: str) -> str:
    """Return the address of the page for a user.

    Args:
        host: The address that the view listens on.
        port: Its port.
        token: The token.
        name: Name of this machine, for a view that listens on all its addresses.
    """
    try:
        address = ip_address(host)
    except ValueError:
        shown = host
    else:
        shown = f"[{host}]" if address.version == 6 else host
        shown = name if address.is_unspecified else shown
    return f"http://{shown}:{port}/{token}/"
