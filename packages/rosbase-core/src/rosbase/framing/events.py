"""What a framer is, and what comes out of one."""

from typing import NamedTuple, Protocol, TypeAlias

__all__ = ["Frame", "FrameError", "FrameEvent", "Framer"]


class Frame(NamedTuple):
    """One whole frame, without its delimiters."""

    data: bytes
    stamp_ns: int
    """When the first bytes of the frame were read."""


class FrameError(NamedTuple):
    """Bytes that cannot become a frame. They are gone; the stream goes on."""

    reason: str
    """One word, for counting, such as `overlong`."""
    stamp_ns: int
    """When the first bytes of what was lost were read."""


FrameEvent: TypeAlias = Frame | FrameError
"""What a framer gives."""


class Framer(Protocol):
    """Bytes in, frames out. No I/O, bounded memory, the same frames for every chunking.

    A framer may have an attribute `pending_bytes`: how many bytes it was fed since the last end of
    a frame. With it, a reader can say why a device that sends gives no frames.
    """

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        """Takes what was read at `stamp_ns` and gives what it completes, in order."""
        ...

    def reset(self) -> None:
        """Forgets a begun frame: what is read next does not continue it."""
        ...
