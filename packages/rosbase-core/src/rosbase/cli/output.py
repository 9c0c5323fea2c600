"""Writes lines to a stream that may be slow, closed or gone, and never waits for it."""

import os
import select
import sys
from collections import deque
from typing import TextIO

__all__ = ["Output", "own_stdio"]

# Lines that wait for a slow reader; the oldest are dropped beyond that.
_WAITING_LINES = 10_000

# A pipe that says it is ready takes this much without waiting (POSIX: PIPE_BUF is 512 or more,
# and 4,096 on Linux).
_PIECE_BYTES = 512 if sys.platform == "darwin" else 4_096


class Output:
    """What is written to a stream, as far as the stream takes it.

    The main loop must not stand still because nobody reads a pipe: what cannot be written
    now is kept, up to a limit, and written by the next `flush`.
    """

    def __init__(self, stream: TextIO) -> None:
        stream.flush()
        self.is_terminal = stream.isatty()
        self._fd = stream.fileno()
        self._poll = select.poll()
        self._poll.register(self._fd, select.POLLOUT)
        self._waiting: deque[bytes] = deque()
        self.dropped = 0
        """Pieces of text that nobody took in time."""
        self.is_gone = False
        """Whether there is nobody left to read it."""
        self.error = ""
        """Why nothing more can be written, if the reason is not just that nobody reads."""

    def write(self, text: str) -> None:
        """Writes the text, now or later."""
        if len(self._waiting) >= _WAITING_LINES:
            self._waiting.popleft()
            self.dropped += 1
        self._waiting.append(text.encode())
        self.flush(0.0)

    def flush(self, timeout_s: float) -> None:
        """Writes what waits; gives up when the stream takes nothing for so long."""
        while not self.is_gone:
            ready = self._poll.poll(timeout_s * 1000.0)
            if any(event & (select.POLLERR | select.POLLNVAL) for _, event in ready):
                self.is_gone = True
            if not ready or not self._waiting:
                return
            self._write_piece()

    def _write_piece(self) -> None:
        data = self._waiting.popleft()
        try:
            written = os.write(self._fd, data[:_PIECE_BYTES])
        except BrokenPipeError:
            self.is_gone = True
        except BlockingIOError:
            self._waiting.appendleft(data)
        except OSError as error:
            self.is_gone = True
            self.error = error.strerror or str(error)
        else:
            if written < len(data):
                self._waiting.appendleft(data[written:])


def own_stdio() -> None:
    """Gives a process that was started without stdout or stderr an end that takes everything."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  # for good
