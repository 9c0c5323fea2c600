"""Errors of recordings."""

from rosbase import RecordingError

__all__ = ["McapError", "NotMcapError"]


class McapError(RecordingError):
    """A file that breaks the rules of MCAP, or a recording that is impossible."""


class NotMcapError(McapError):
    """A file that does not begin as an MCAP file does."""
