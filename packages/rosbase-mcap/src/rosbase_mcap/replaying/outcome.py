"""The result of a replay."""

from attrs import frozen

from rosbase_mcap.replaying.difference import Difference

__all__ = ["Outcome"]


@frozen
class Outcome:
    """The result of a replay."""

    difference: Difference | None
    """Where the program begins to differ from its recording; None if it does not."""
    cut_short: str
    """Why the recording could not be replayed to its end, in one line; empty if it was."""
    sha256: str
    """Digest of all that the program has published."""
    messages: int
    """Number of messages, with the lines of the log."""
    duration_ns: int
    """Time of the program that has passed, in nanoseconds."""
