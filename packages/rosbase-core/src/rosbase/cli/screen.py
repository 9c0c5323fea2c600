"""Lines at the bottom of a terminal that are overwritten in place, below the log."""

import threading
from collections.abc import Sequence

from rosbase.cli.output import Output

__all__ = ["Screen"]

_TERMINAL_PERIOD_S = 0.2
_PLAIN_PERIOD_S = 1.0


class Screen:
    """Shows lines in place of the previous ones; outside a terminal, line after line.

    Write log records for the same terminal with `above`, from any thread. They take the place
    of the lines, which follow again below.
    """

    def __init__(self, output: Output) -> None:
        """Start without lines."""
        self._output = output
        self._lock = threading.RLock()
        self._lines: Sequence[str] = ()

    @property
    def is_terminal(self) -> bool:
        """Whether lines can be overwritten."""
        return self._output.is_terminal

    @property
    def encoding(self) -> str:
        """The encoding of the terminal."""
        return self._output.encoding

    @property
    def period_s(self) -> float:
        """Seconds between updates."""
        return _TERMINAL_PERIOD_S if self.is_terminal else _PLAIN_PERIOD_S

    @property
    def size(self) -> tuple[int, int]:
        """Columns and lines of the terminal, less one column, because the last one may wrap."""
        columns, lines = self._output.size
        return columns - 1, lines

    def show(self, lines: Sequence[str]) -> None:
        """Show these lines, none of them wider than the terminal."""
        with self._lock:
            if self.is_terminal:
                self._output.write(self._erase() + "\n".join(lines))
                self._lines = lines
            else:
                self._output.write("".join(f"{line}\n" for line in lines))

    def above(self, output: Output, text: str) -> None:
        """Write whole lines to an output of the same terminal, above the shown ones."""
        with self._lock:
            if not (self._lines and output.is_terminal):
                output.write(text)
                return
            output.write(self._erase() + text + "\n".join(self._lines))

    def end(self) -> None:
        """Leave the last lines standing, and continue below them."""
        with self._lock:
            if self._lines:
                self._output.write("\n")
                self._lines = ()

    def _erase(self) -> str:
        """Return the sequence that moves the cursor to the first of the lines, and clears them."""
        if not self._lines:
            return ""
        up = len(self._lines) - 1
        return "\r" + (f"\x1b[{up}A" if up else "") + "\x1b[J"
