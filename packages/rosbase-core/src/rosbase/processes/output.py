"""What a child writes, as lines for the log. Bytes in, texts out; bounded whatever comes."""

import re
from collections.abc import Iterator

from rosbase.text.printable import log_line

__all__ = ["OutputLines"]

_NS_PER_S = 1_000_000_000
_COLOUR = re.compile(r"\x1b\[[0-9;:]*m")


class OutputLines:
    """Cuts output into lines, and keeps the log readable.

    A line that is too long is cut, and one that is too many in a second is left out; both are
    said. Colours are left out, and whatever else cannot be printed, such as what clears a screen,
    moves the cursor or sets a title, is shown as escapes; so are bytes that are not UTF-8.
    """

    __slots__ = (
        "_cut_bytes",
        "_left_out",
        "_lines_left",
        "_max_bytes",
        "_partial",
        "_per_s",
        "_until",
    )

    def __init__(self, max_line_bytes: int = 4096, max_lines_per_s: int = 500) -> None:
        """Starts empty, with the limits in bytes to a line and lines to a second."""
        self._max_bytes = max_line_bytes
        self._per_s = max_lines_per_s
        self._partial = b""
        self._cut_bytes = 0
        self._lines_left = max_lines_per_s
        self._left_out = 0
        self._until = 0

    def feed(self, data: bytes, now_ns: int) -> Iterator[str]:
        """Takes what was read at `now_ns` (monotonic) and gives the lines to log, in order."""
        if now_ns >= self._until:
            yield from self._begin_second(now_ns)
        begin = 0
        while (end := data.find(b"\n", begin)) >= 0:
            if not self._lines_left:
                # Counting is fast enough for a flood; cutting it up is not.
                self._left_out += data.count(b"\n", begin)
                begin = data.rfind(b"\n") + 1
                self._partial, self._cut_bytes = b"", 0
                break
            yield from self._line(data[begin:end])
            begin = end + 1
        self._keep(data[begin:])

    def finish(self) -> Iterator[str]:
        """The line that was begun, and what was left out, when the output has ended."""
        if self._partial:
            self._lines_left = max(1, self._lines_left)
            yield from self._line(b"")
        yield from self._begin_second(0)

    def _begin_second(self, now_ns: int) -> Iterator[str]:
        self._until = now_ns + _NS_PER_S
        self._lines_left = self._per_s
        if self._left_out:
            yield f"... {self._left_out} more lines"
            self._left_out = 0

    def _line(self, end: bytes) -> Iterator[str]:
        self._keep(end)
        text = _plain(self._partial.rstrip(b"\r").decode("utf-8", "backslashreplace"))
        if self._cut_bytes:
            text += f" ... {self._cut_bytes} more bytes"
        self._partial, self._cut_bytes = b"", 0
        self._lines_left -= 1
        if text:
            yield text

    def _keep(self, piece: bytes) -> None:
        room = self._max_bytes - len(self._partial)
        self._partial += piece[:room]
        self._cut_bytes += max(0, len(piece) - room)


def _plain(line: str) -> str:
    return log_line(_COLOUR.sub("", line))
