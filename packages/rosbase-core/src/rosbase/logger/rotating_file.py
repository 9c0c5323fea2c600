"""A log file with rotation.

It has the lines of the console. Several programs may write one file: each line is one write at
its end, one program at a time rotates, and the others go on in the new file.
"""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from logging.handlers import RotatingFileHandler
from pathlib import Path

from rosbase.logger.formatter import RosFormatter
from rosbase.text.printable import one_line, printable

if sys.platform != "win32":
    import fcntl

__all__ = ["LogFile"]


class LogFile(RotatingFileHandler):
    """Appends records to a file. It opens the file at the first record.

    A file that cannot be written is no error of the program: `take_fault` says so once.
    """

    def __init__(self, path: str, max_bytes: int, count: int) -> None:
        """Take the path, and when to begin a new file.

        Args:
            path: Absolute path of the file; its folder is created if there is none.
            max_bytes: Size from which a new file is begun; 0 for never.
            count: Number of old files that are kept, as `<path>.1` and so on.
        """
        super().__init__(
            path,
            maxBytes=max_bytes,
            backupCount=count,
            encoding="utf-8",
            errors="backslashreplace",
            delay=True,
        )
        self.setFormatter(RosFormatter())
        self._fault = ""
        self._has_failed = False
        self._opened = (0, 0, 0)
        """Process that opened the file, and what identifies the file."""

    def take_fault(self) -> str:
        """Return why the file cannot be written, in one line, the first time only; else nothing."""
        if not self._fault:
            return ""
        with self._locked():
            fault, self._fault = self._fault, ""
        return fault

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - of logging
        """Keep the first error for `take_fault`. `logging` calls it in the `except` of `emit`."""
        if not self._has_failed:
            self._has_failed = True
            error = sys.exc_info()[1]
            why = one_line(getattr(error, "strerror", None) or str(error))
            self._fault = f"the log file {printable(self.baseFilename)} cannot be written: {why}"

    def emit(self, record: logging.LogRecord) -> None:
        """Append a record, in a new file if this one is full. `logging` calls it."""
        # The handler of `logging` formats each record twice, and asks the system more often.
        try:
            line = self.format(record) + self.terminator
            self._stream_with_room(self._bytes_of(line)).write(line)
            self.flush()
        except Exception:
            self.handleError(record)

    def doRollover(self) -> None:  # noqa: N802 - of logging
        """Begin a new file, unless another process does so at this moment."""
        with self._turn() as is_ours:
            if not is_ours:
                return
            if self._status() is None:
                self._reopen()
            else:
                super().doRollover()

    def _open(self) -> TextIOWrapper:
        path = Path(self.baseFilename)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file():
            # Opening a pipe may wait for ever.
            raise OSError("it is not a file")
        stream = super()._open()
        self._opened = (os.getpid(), *_identity(os.fstat(stream.fileno())))
        return stream

    def _stream_with_room(self, size: int) -> TextIOWrapper:
        """Return the file that is at the path now, or a new one if that one is full."""
        found = self._status() or self._reopen()
        if self.maxBytes and found.st_size and found.st_size + size > self.maxBytes:
            self.doRollover()
        if self.stream is None:
            self.stream = self._open()
        return self.stream

    def _bytes_of(self, line: str) -> int:
        return len(line) if line.isascii() else len(line.encode("utf-8", "backslashreplace"))

    def _status(self) -> os.stat_result | None:
        """Return the status of the file; None if it is not open in this process, or was moved."""
        if self.stream is None:
            return None
        try:
            found = os.stat(self.baseFilename)
        except OSError:
            return None
        return found if (os.getpid(), *_identity(found)) == self._opened else None

    def _reopen(self) -> os.stat_result:
        stream, self.stream = self.stream, None
        if stream is not None:
            stream.close()
        self.stream = self._open()
        return os.fstat(self.stream.fileno())

    @contextmanager
    def _turn(self) -> Iterator[bool]:
        """Lock the file that is open now, if nobody else has; yield whether that is so."""
        # The lock belongs to what was opened, so a copy keeps it while `logging` closes the stream.
        assert self.stream is not None
        copy = os.dup(self.stream.fileno())
        try:
            try:
                fcntl.flock(copy, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                yield False
            else:
                yield True
        finally:
            os.close(copy)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        self.acquire()
        try:
            yield
        finally:
            self.release()


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino
