"""The lines at the bottom of a terminal that are written over again, below the log."""

import threading
from collections.abc import Sequence

from rosbase.cli.output import Output

__all__ = ["Screen"]

_TERMINAL_PERIOD_S = 0.2
_PLAIN_PERIOD_S = 1.0


class Screen:
    """Shows some lines in place of those before; elsewhere than on a terminal, line after line.

    Log records that go to the same terminal are written with `above`, from any thread: they take
    the place of the lines, which follow again below.
    """

    def __init__(self, output: Output) -> None:
        """Show nothing yet."""
        self._output = output
        self._lock = threading.RLock()
        self._lines: Sequence[str] = ()

    @property
    def is_terminal(self) -> bool:
        """Whether lines can be written over."""
        return self._output.is_terminal

    @property
    def encoding(self) -> str:
        """The encoding of the terminal."""
        return self._output.encoding

    @property
    def period_s(self) -> float:
        """How often it is worth showing something."""
        return _TERMINAL_PERIOD_S if self.is_terminal else _PLAIN_PERIOD_S

    @property
    def size(self) -> tuple[int, int]:
        """Columns and lines of the terminal, less the column in which some begin a new line."""
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
        """Write whole lines to an output of the same terminal, above those that are shown."""
        with self._lock:
            if not (self._lines and output.is_terminal):
                output.write(text)
                return
            output.write(self._erase() + text + "\n".join(self._lines))

    def end(self) -> None:
        """Leave the last lines standing, and go on below them."""
        with self._lock:
            if self._lines:
                self._output.write("\n")
                self._lines = ()

    def _erase(self) -> str:
        """Return what takes the cursor to the first of the lines, and clears them."""
        if not self._lines:
            return ""
        up = len(self._lines) - 1
        return "\r" + (f"\x1b[{up}A" if up else "") + "\x1b[J"
