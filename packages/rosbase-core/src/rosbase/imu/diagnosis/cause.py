"""The cause of a refusal, in words."""

from attrs import frozen

from rosbase.text.printable import printable

__all__ = ["Cause", "shown"]

_LONGEST = 40


@frozen
class Cause:
    """Contents of a frame, and advice."""

    text: str
    """Description in half a line; quotes from the frame are escaped and cut."""
    is_harmless: bool = False
    """Whether a working device prints such things, as when it starts."""


def shown(text: str) -> str:
    """Return outside text fit for a log: quoted, escaped and cut."""
    return f"'{printable(text, _LONGEST)}'"
