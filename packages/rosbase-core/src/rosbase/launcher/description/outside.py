"""Texts for the operating system: what it can take, and where `~` is."""

from pathlib import Path

from rosbase.errors import ConfigurationError
from rosbase.text.printable import printable

__all__ = ["at_home", "objection_to"]

# MAX_ARG_STRLEN of Linux, less some room for the rest of a script: execve(2).
_MOST_BYTES = 120_000


def objection_to(text: str) -> str:
    """Return why no program can be given a text, as in `has a NUL character`; empty if it can."""
    if "\0" in text:
        return "has a NUL character"
    try:
        length = len(text.encode())
    except UnicodeEncodeError:
        return "has half of a surrogate pair, which is no character"
    return f"has more than {_MOST_BYTES} bytes" if length > _MOST_BYTES else ""


def at_home(text: str) -> Path:
    """Return a path in which `~` and `~user` at the beginning stand for a home.

    Raises:
        ConfigurationError: There is no such user.
    """
    try:
        return Path(text).expanduser()
    except RuntimeError:
        user = printable(text.partition("/")[0])
        raise ConfigurationError(f"there is no home folder {user}") from None
