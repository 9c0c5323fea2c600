"""The terminal: a line that lives where there is one, plain lines where there is none."""

import logging
import shutil
import sys

from rosbase.cli.output import Output

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
            self._output.write(f"{_CLEAR}{text[:width]}")
            self._is_shown = True
        else:
            self._output.write(f"{text}\n")

    def end(self) -> None:
        """Leaves the last text standing, and goes on below it."""
        if self._is_shown:
            self._output.write("\n")
            self._is_shown = False


class _Formatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        record.name = record.name.removeprefix("rosbase.")
        return super().format(record)


def log_to_stderr() -> None:
    """Has rosbase's log records written to stderr, in the shape of ROS 2."""
    handler = logging.StreamHandler(sys.stderr)
    clear = _CLEAR if sys.stderr.isatty() else ""
    handler.setFormatter(_Formatter(f"{clear}[%(levelname)s] [%(name)s]: %(message)s"))
    logger = logging.getLogger("rosbase")
    logger.handlers[:] = [handler]
    logger.setLevel(logging.INFO)
    logger.propagate = False
    # A log that nobody can read any more must not add complaints of its own.
    logging.raiseExceptions = False
