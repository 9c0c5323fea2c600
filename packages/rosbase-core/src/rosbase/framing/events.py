"""The interface of a framer, and its events."""

from typing import NamedTuple, Protocol, TypeAlias

__all__ = ["Frame", "FrameError", "FrameEvent", "Framer"]


class Frame(NamedTuple):
    """One whole frame, without its delimiters."""

    data: bytes
    stamp_ns: int
    """Time at which the first bytes of the frame were read."""


class FrameError(NamedTuple):
    """Bytes that cannot become a frame. They are lost; the stream goes on."""

    reason: str
    """One word, for counting, such as `overlong`."""
    stamp_ns: int
    """Time at which the first lost bytes were read."""


FrameEvent: TypeAlias = Frame | FrameError
"""Event that a framer returns."""


class Framer(Protocol):
    """Bytes in, frames out. No I/O, bounded memory, the same frames for every chunking.

    A framer may have an attribute `pending_bytes`: the number of bytes fed since the last end
    of a frame. With it, a reader can explain why a sending device gives no frames.
    """

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        """Take the data read at `stamp_ns`; return the events that it completes, in order."""
        ...

    def reset(self) -> None:
        """Forget an incomplete frame: the next data does not continue it."""
        ...
