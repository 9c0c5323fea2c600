"""A framer for lines."""

from rosbase.framing.events import Frame, FrameError, FrameEvent

__all__ = ["DEFAULT_MAX_LINE_BYTES", "LineFramer"]

DEFAULT_MAX_LINE_BYTES = 65_536
"""Default maximum length of a line; longer ones are refused. Known IMUs stay under 500 bytes."""

# What may surround a line without belonging to it: a break on the line reads as NUL.
_PADDING = b"\x00 \t"


class LineFramer:
    """Splits bytes into lines.

    CR, LF and CR LF all end a line. Blanks, tabs and NUL bytes around a line are not part of
    it, and a line of only those is ignored. A line longer than the limit is one `overlong`
    error, and framing goes on after its end.
    """

    __slots__ = ("_discarding", "_max_line_bytes", "_partial", "_stamp_ns", "pending_bytes")

    def __init__(self, max_line_bytes: int = DEFAULT_MAX_LINE_BYTES) -> None:
        """Start without data.

        Raises:
            ValueError: The limit is less than 1 byte.
        """
        if max_line_bytes < 1:
            raise ValueError(f"max_line_bytes must be at least 1, not {max_line_bytes}")
        self._max_line_bytes = max_line_bytes
        self._partial = bytearray()
        self._stamp_ns = 0
        self._discarding = False
        self.pending_bytes = 0
        """Number of bytes since the last end of a line, kept or not."""

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        """Take bytes read at `stamp_ns`; return the lines that they complete, in order."""
        *whole, rest = data.replace(b"\r", b"\n").split(b"\n")
        events: list[FrameEvent] = []
        for piece in whole:
            if self._partial or self._discarding:
                self._end_begun_line(piece, events)
            else:
                self._add(piece, stamp_ns, events)
        self.pending_bytes = len(rest) if whole else self.pending_bytes + len(rest)
        if rest:
            self._begin_or_continue(rest, stamp_ns, events)
        return events

    def reset(self) -> None:
        """Forget an incomplete line."""
        self._partial.clear()
        self._discarding = False
        self.pending_bytes = 0

    def _end_begun_line(self, piece: bytes, events: list[FrameEvent]) -> None:
        if not self._discarding:
            self._partial += piece
            self._add(bytes(self._partial), self._stamp_ns, events)
        self.reset()

    def _add(self, line: bytes, stamp_ns: int, events: list[FrameEvent]) -> None:
        line = line.lstrip(_PADDING)
        if len(line) > self._max_line_bytes:
            events.append(FrameError("overlong", stamp_ns))
        elif line := line.rstrip(_PADDING):
            events.append(Frame(line, stamp_ns))

    def _begin_or_continue(self, rest: bytes, stamp_ns: int, events: list[FrameEvent]) -> None:
        if self._discarding:
            return
        if not self._partial:
            # A break on the line a minute ago is not the first byte of this frame.
            rest = rest.lstrip(_PADDING)
            self._stamp_ns = stamp_ns
        self._partial += rest
        if len(self._partial) > self._max_line_bytes:
            events.append(FrameError("overlong", self._stamp_ns))
            self._partial.clear()
            self._discarding = True
