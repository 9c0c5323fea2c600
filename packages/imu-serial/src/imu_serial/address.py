"""Addresses in `device_path`: a file, or a port at the other end of a network. Pure."""

import re
from urllib.parse import SplitResult, urlsplit

from attrs import frozen

from rosbase import ParameterError, printable

__all__ = ["Address", "parse_address"]

_URL = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://")
_FORMS = "socket://host:port and rfc2217://host:port"


@frozen
class Address:
    """A port that is reached over TCP."""

    scheme: str
    """`socket` for raw bytes, `rfc2217` for raw bytes and the settings of the port."""
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}"


def parse_address(text: str) -> Address | None:
    """Return the address in a `device_path`; None if it is a path.

    Raises:
        ParameterError: It is a URL that cannot be used.
    """
    found = _URL.match(text)
    if found is None:
        return None
    scheme = found[1].lower()
    if scheme not in ("socket", "rfc2217"):
        raise ParameterError(f"device_path {printable(text)}: {_advice_on(scheme)}")
    if not text.isprintable() or " " in text:
        raise _malformed(text)
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise _malformed(text) from None
    if not host or not port or _has_more(parts):
        raise _malformed(text)
    return Address(scheme, host, port)


def _advice_on(scheme: str) -> str:
    if scheme in ("tcp", "telnet", "raw"):
        return "for bytes over TCP write socket://host:port"
    if scheme in ("file", "serial", "tty"):
        return "write the path alone, such as /dev/ttyUSB0; the rate is the parameter baudrate"
    return f"{scheme}:// is not supported; {_FORMS} are"


def _has_more(parts: SplitResult) -> bool:
    return bool(parts.path.strip("/") or parts.query or parts.fragment or "@" in parts.netloc)


def _malformed(text: str) -> ParameterError:
    return ParameterError(
        f"device_path {printable(text)} is not host and port: write it like socket://192.168.1.20:7000"
    )
