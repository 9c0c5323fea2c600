"""A child's output as lines for the log. Bytes in, texts out; always bounded."""

import re
from collections.abc import Iterator

from rosbase.processes.budget import LineBudget
from rosbase.text.printable import log_line

__all__ = ["OutputLines"]

_BEGUN_NS = 1_000_000_000
_LAST_WORDS_BYTES = 8192
_COLOUR = re.compile(r"\x1b\[[0-9;:]*m")
# Movements of the cursor, titles of windows and the like, as ECMA-48 and xterm have them.
_FOR_A_SCREEN = re.compile(
    r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[()][0-2A-Z]|[=>78cDEHMNOZ])"
)


class OutputLines:
    """Splits output into lines, and keeps the log readable.

    A carriage return ends a line too. An incomplete line is shown after a second, since it may
    never be continued. A line that is too long is cut, and lines beyond the limit per second
    are left out; the log says both. The last of the left-out lines are kept, for a child that
    crashes. Colours are removed. Other control characters, such as those that clear a screen,
    move the cursor or set a title, are shown as escapes. So are bytes that are not UTF-8.
    """

    __slots__ = (
        "_after_return",
        "_begun_ns",
        "_budget",
        "_cut_bytes",
        "_for_a_screen",
        "_max_bytes",
        "_partial",
        "_tail",
    )

    def __init__(
        self,
        max_line_bytes: int = 4096,
        max_lines_per_s: int = 500,
        *,
        for_a_screen: bool = False,
    ) -> None:
        """Start without output.

        Args:
            max_line_bytes: Maximum bytes of a line.
            max_lines_per_s: Maximum lines per second.
            for_a_screen: Whether the child thinks that it writes to a terminal. Then screen
                control is removed, like colours.
        """
        self._max_bytes = max_line_bytes
        self._budget = LineBudget(max_lines_per_s)
        self._for_a_screen = for_a_screen
        self._partial = b""
        self._begun_ns = 0
        self._cut_bytes = 0
        self._after_return = False
        self._tail = b""

    @property
    def due_ns(self) -> int | None:
        """Time at which `tick` has lines if no output comes before, on the monotonic clock."""
        budget = self._budget
        if self._partial:
            begun_ns = self._begun_ns + _BEGUN_NS
            return begun_ns if budget.left else max(begun_ns, budget.until_ns)
        return budget.until_ns if budget.left_out else None

    def feed(self, data: bytes, now_ns: int) -> Iterator[str]:
        """Take output read at `now_ns` (monotonic); return the lines to log, in order."""
        yield from self._renew(now_ns)
        data = self._with_plain_ends(data)
        begin = 0
        while (end := data.find(b"\n", begin)) >= 0:
            if not self._budget.left:
                begin = self._leave_out(data, begin)
                break
            yield from self._line(data[begin:end])
            begin = end + 1
        if not self._partial:
            self._begun_ns = now_ns
        self._keep(data[begin:])

    def tick(self, now_ns: int) -> Iterator[str]:
        """Return lines that have waited long enough: an incomplete line, a count of others."""
        yield from self._renew(now_ns)
        if self._partial and self._budget.left and now_ns >= self._begun_ns + _BEGUN_NS:
            yield from self._line(b"")

    def finish(self, *, last_words: bool = False) -> Iterator[str]:
        """Return the incomplete line, and the left-out lines, when the output has ended.

        Args:
            last_words: Whether to return the last of the left-out lines as well.
        """
        kept = self._tail.splitlines() if last_words else []
        if len(self._tail) >= _LAST_WORDS_BYTES:
            # Its beginning is missing.
            del kept[:1]
        self._budget.left_out = max(0, self._budget.left_out - len(kept))
        yield from filter(None, [self._budget.settle()])
        begun, self._partial = self._partial, b""
        cut_bytes, self._cut_bytes = self._cut_bytes, 0
        for line in kept:
            yield from self._line(line)
        self._cut_bytes = cut_bytes
        yield from self._line(begun)

    def _renew(self, now_ns: int) -> Iterator[str]:
        yield from filter(None, [self._budget.renew(now_ns)])

    def _with_plain_ends(self, data: bytes) -> bytes:
        r"""Convert all line ends to `\n`, also where `\r\n` came in two parts."""
        if self._after_return and data[:1] == b"\n":
            data = data[1:]
            self._after_return = False
        if data:
            self._after_return = data[-1:] == b"\r"
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return data

    def _leave_out(self, data: bytes, begin: int) -> int:
        """Count the lines from there on; return where the last one ends."""
        # Counting is fast enough for a flood; cutting it up is not.
        end = data.rfind(b"\n") + 1
        self._budget.left_out += data.count(b"\n", begin)
        self._tail = (self._tail + self._partial + data[begin:end])[-_LAST_WORDS_BYTES:]
        self._partial, self._cut_bytes = b"", 0
        return end

    def _line(self, end: bytes) -> Iterator[str]:
        self._keep(end)
        text = self._plain(self._partial.decode("utf-8", "backslashreplace"))
        if self._cut_bytes:
            text += f" ... {self._cut_bytes} more bytes"
        self._partial, self._cut_bytes = b"", 0
        self._budget.left -= 1
        self._tail = b""
        if text:
            yield text

    def _keep(self, piece: bytes) -> None:
        room = self._max_bytes - len(self._partial)
        self._partial += piece[:room]
        self._cut_bytes += max(0, len(piece) - room)

    def _plain(self, line: str) -> str:
        if "\x1b" in line:
            line = (_FOR_A_SCREEN if self._for_a_screen else _COLOUR).sub("", line)
        return log_line(line)
