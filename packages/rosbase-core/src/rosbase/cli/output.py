"""Write lines to a stream that may be slow, closed or gone, without waiting for it."""

import os
import select
import sys
import threading
from collections import deque
from typing import TextIO

from rosbase.clock import Clock

__all__ = ["Output", "own_stdio"]

# Texts that wait for a slow reader; the oldest are dropped beyond that.
_WAITING_TEXTS = 10_000

# A pipe that says it is ready takes this much without waiting (POSIX: PIPE_BUF is 512 or more,
# and 4,096 on Linux).
_PIECE_BYTES = 512 if sys.platform == "darwin" else 4_096


class Output:
    """Buffered output to a stream that may be slow.

    The main loop must not stop because nobody reads a pipe. Text that cannot be written now is
    kept, up to a limit, and written by the next `flush`.
    """

    def __init__(self, stream: TextIO) -> None:
        stream.flush()
        self.is_terminal = stream.isatty()
        # None for a stream without a descriptor, as those in which tests catch output.
        self._fd = _unblocking(stream)
        self._stream = stream
        # Log records come from any thread. Nothing is waited for under the lock, but for the
        # time that `drain` is given.
        self._lock = threading.RLock()
        self._poll = select.poll()
        if self._fd is not None:
            self._poll.register(self._fd, select.POLLOUT)
        self._begun = b""
        self._waiting: deque[bytes] = deque()
        self.dropped = 0
        """Number of texts dropped because nobody read them in time."""
        self.is_gone = False
        """Whether the stream has no reader any more."""
        self.error = ""
        """Reason why nothing more can be written, other than a missing reader."""

    @property
    def size(self) -> tuple[int, int]:
        """Columns and lines of the terminal; 80 and 24 if they are not known."""
        try:
            columns, lines = os.get_terminal_size(-1 if self._fd is None else self._fd)
        except OSError:
            return 80, 24
        return columns or 80, lines or 24

    @property
    def encoding(self) -> str:
        """Encoding of the stream, in lower case."""
        return (self._stream.encoding or "").lower()

    def write(self, text: str) -> None:
        """Write the text, now or later."""
        if self._fd is None:
            self._stream.write(text)
            return
        with self._lock:
            if len(self._waiting) >= _WAITING_TEXTS:
                self._waiting.popleft()
                self.dropped += 1
            self._waiting.append(text.encode(errors="replace"))
            self.flush()

    def flush(self) -> None:
        """Write waiting text, as far as the stream takes it at once."""
        with self._lock:
            while self._write_piece(0.0):
                pass

    def drain(self, seconds: float, clock: Clock) -> None:
        """Write waiting text within a time limit; drop the rest."""
        end_ns = clock.monotonic_ns() + int(seconds * 1e9)
        with self._lock:
            while (left_ns := end_ns - clock.monotonic_ns()) > 0:
                if not self._write_piece(left_ns / 1e9):
                    break
            self.dropped += len(self._waiting)
            self._waiting.clear()

    def _write_piece(self, timeout_s: float) -> bool:
        """Write a piece of the waiting text when the stream is ready; return whether it did."""
        if self._fd is None:
            return False
        has_text = bool(self._begun or self._waiting)
        ready = self._poll.poll(timeout_s * 1000.0 if has_text else 0.0)
        if any(event & (select.POLLERR | select.POLLNVAL) for _, event in ready):
            self.is_gone = True
        if self.is_gone or not (ready and has_text):
            return False
        self._begun = self._begun or self._waiting.popleft()
        try:
            written = os.write(self._fd, self._begun[:_PIECE_BYTES])
        except BlockingIOError:
            return False
        except OSError as error:
            self.is_gone = True
            self.error = "" if isinstance(error, BrokenPipeError) else str(error.strerror)
            return False
        self._begun = self._begun[written:]
        return True


def _unblocking(stream: TextIO) -> int | None:
    """Return a descriptor on which writing never waits if `poll` says that it is ready.

    This holds for pipes and sockets. A terminal is ready for a byte, but then the rest of a
    line waits. So it is opened once more, because the shell shares the mode of the original
    descriptor.
    """
    try:
        fd = stream.fileno()
    except OSError:
        return None
    if stream.isatty():
        flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        try:
            return os.open(os.ttyname(fd), flags)
        except OSError:
            # A terminal without a name here, such as one of another container.
            pass
    return fd


def own_stdio() -> None:
    """Give a process started without stdout or stderr a stream that discards everything."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  # for good
