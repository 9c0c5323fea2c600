"""The messages that a program has published, which two runs of it must have in common. Pure."""

import hashlib
import struct
from collections.abc import Collection
from typing import NamedTuple

from rosbase_mcap.log_channel import LOG_TOPIC

__all__ = ["MASK", "Digest", "Output"]

MASK = (1 << 32) - 1
"""A message in a file has this much of the number of its entry, as its sequence number."""
_PREFIX = struct.Struct("<III")


class Output(NamedTuple):
    """A message that came from within a program."""

    number: int
    """Number of the entry in which it came, of which `MASK` is known."""
    topic: str
    """Full name of its topic."""
    log_ns: int
    """When it was published, in nanoseconds since 1970."""
    data: bytes
    """The message as CDR."""


class Digest:
    """The SHA-256 of all outputs, so that two runs are compared by one number.

    The log does not count: tracebacks and lines of the program's source are in it, and differ
    between versions of Python. Nor do dates count: a replay reads them from the recording.
    """

    def __init__(self, leave_out: Collection[str] = (LOG_TOPIC,)) -> None:
        """Begin.

        Args:
            leave_out: Topics that do not count.
        """
        self._hash = hashlib.sha256()
        self._leave_out = frozenset(leave_out)
        # Empty for those that do not count.
        self._names: dict[str, bytes] = {}

    def add(self, number: int, topic: str, data: bytes) -> None:
        """Add an output. They count in their order."""
        name = self._names.get(topic)
        if name is None:
            name = self._names[topic] = b"" if topic in self._leave_out else topic.encode()
        if name:
            prefix = _PREFIX.pack(number & MASK, len(name), len(data))
            self._hash.update(b"".join((prefix, name, data)))

    @property
    def hexdigest(self) -> str:
        """The digest of the outputs so far, in hexadecimal."""
        return self._hash.hexdigest()
