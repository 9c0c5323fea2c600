"""The terminal: a line that lives where there is one, plain lines where there is none."""

import logging
import shutil
import sys

from rosbase.cli.output import Output
from rosbase.text.printable import indented, log_line

__all__ = ["LiveLine", "log_to_stderr"]

_CLEAR = "\r\x1b[K"
_TERMINAL_PERIOD_S = 0.2
_PLAIN_PERIOD_S = 1.0


class LiveLine:
    """One line that is written over again on a terminal, and line after line elsewhere."""

    def __init__(self, output: Output) -> None:
        self._output = output
        self._is_shown = False

    @property
    def period_s(self) -> float:
        """How often it is worth showing."""
        return _TERMINAL_PERIOD_S if self._output.is_terminal else _PLAIN_PERIOD_S

    def show(self, text: str) -> None:
        """Shows the text in place of the one before."""
        if self._output.is_terminal:
            width = shutil.get_terminal_size().columns - 1
            self._output.write(f"{_CLEAR}{log_line(text)[:width]}")
            self._is_shown = True
        else:
            self._output.write(f"{log_line(text)}\n")

    def end(self) -> None:
        """Leaves the last text standing, and goes on below it."""
        if self._is_shown:
            self._output.write("\n")
            self._is_shown = False


class _Formatter(logging.Formatter):
    """Writes records in the shape of ROS 2: a line each, and tracebacks indented below it."""

    def __init__(self, begin: str) -> None:
        super().__init__()
        self._begin = begin

    def format(self, record: logging.LogRecord) -> str:
        name = record.name.removeprefix("rosbase.")
        line = log_line(f"[{record.levelname}] [{name}]: {record.getMessage()}")
        trace = self.formatException(record.exc_info) if record.exc_info else record.exc_text
        below = [indented(text) for text in (trace, record.stack_info) if text]
        return self._begin + "\n".join([line, *below])


class _OutputHandler(logging.Handler):
    """Hands log records to an output, which never waits, not even for a stopped terminal."""

    def __init__(self, output: Output) -> None:
        super().__init__()
        self._output = output

    def emit(self, record: logging.LogRecord) -> None:
        self._output.write(f"{self.format(record)}\n")


def log_to_stderr() -> Output:
    """Has rosbase's log records written to stderr, in the shape of ROS 2; gives the output."""
    output = Output(sys.stderr)
    handler = _OutputHandler(output)
    handler.setFormatter(_Formatter(_CLEAR if output.is_terminal else ""))
    logger = logging.getLogger("rosbase")
    logger.handlers[:] = [handler]
    logger.setLevel(logging.INFO)
    logger.propagate = False
    return output
