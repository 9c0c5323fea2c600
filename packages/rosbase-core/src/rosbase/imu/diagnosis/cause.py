"""The cause of a refusal, in words."""

from attrs import frozen

from rosbase.text.printable import printable

__all__ = ["Cause", "shown"]

_LONGEST = 40


@frozen
class Cause:
    """What a frame is, and what to do about it."""

    text: str
    """Half a line; what it quotes from the frame is escaped and cut."""
    is_harmless: bool = False
    """Whether a device that works says such things, as when it starts."""


def shown(text: str) -> str:
    """Return outside text as it may stand in a log: quoted, escaped and cut."""
    return f"'{printable(text, _LONGEST)}'"
