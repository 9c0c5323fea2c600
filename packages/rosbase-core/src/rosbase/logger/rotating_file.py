"""A log file with rotation.

Its lines are those of the console. Several programs may write one file: each line is one write at
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
        self._pid = os.getpid()

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

    def shouldRollover(self, record: logging.LogRecord) -> bool:  # noqa: N802 - of logging
        """Return whether the file is full. First follow a file that was moved."""
        if self._is_moved() or self._pid != os.getpid():
            self._reopen()
        return bool(super().shouldRollover(record))

    def doRollover(self) -> None:  # noqa: N802 - of logging
        """Begin a new file, unless another process does so at this moment."""
        with self._turn() as is_ours:
            if not is_ours:
                return
            if self._is_moved():
                self._reopen()
            else:
                super().doRollover()

    def _open(self) -> TextIOWrapper:
        path = Path(self.baseFilename)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file():
            # Opening a pipe may wait for ever.
            raise OSError("it is not a file")
        self._pid = os.getpid()
        return super()._open()

    def _is_moved(self) -> bool:
        """Return whether the path leads to another file than the open one, or to none."""
        if self.stream is None:
            return False
        try:
            there, ours = os.stat(self.baseFilename), os.fstat(self.stream.fileno())
        except OSError:
            return True
        return (there.st_dev, there.st_ino) != (ours.st_dev, ours.st_ino)

    def _reopen(self) -> None:
        stream, self.stream = self.stream, None
        if stream is not None:
            stream.close()
        self.stream = self._open()

    @contextmanager
    def _turn(self) -> Iterator[bool]:
        """Lock the file that is open now, if nobody else has; yield whether that is so."""
        # The lock belongs to what was opened, so a copy keeps it while `logging` closes the stream.
        if self.stream is None:
            self.stream = self._open()
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
