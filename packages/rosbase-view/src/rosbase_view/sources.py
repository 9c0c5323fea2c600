"""Find the source for what the user named."""

from rosbase_view.attached.source import AttachedSource
from rosbase_view.source import Source

__all__ = ["open_source"]


def open_source(name: str | None) -> Source:
    """Return the source of running programs, or of a recording.

    Args:
        name: A program, the pid of its process, or the path of a recording; None for all programs.

    Raises:
        ControlError: No program has that name, or several have.
    """
    source = AttachedSource(name)
    source.check()
    return source
