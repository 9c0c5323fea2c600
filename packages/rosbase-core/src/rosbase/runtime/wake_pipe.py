"""A pipe that wakes a thread wherever it waits in the kernel."""

import os
import threading

__all__ = ["WakePipe"]


class WakePipe:
    """One thread polls it; any thread writes to it, also when it has been closed."""

    def __init__(self) -> None:
        """Opens it.

        Raises:
            OSError: There are no more descriptors.
        """
        self._read_fd, self._write_fd = os.pipe()
        os.set_blocking(self._read_fd, False)
        os.set_blocking(self._write_fd, False)
        # Guards the descriptors, whose numbers others get when they are closed.
        self._lock = threading.Lock()
        self._is_closed = False

    def fileno(self) -> int:
        """What is to be polled for input."""
        return self._read_fd

    def wake(self) -> None:
        """Wakes whoever polls it, now or next."""
        with self._lock:
            if not self._is_closed:
                try:
                    os.write(self._write_fd, b"x")
                except BlockingIOError:
                    # It is being woken already.
                    pass

    def drain(self) -> None:
        """Takes what has woken it, so that it can be waited for again."""
        try:
            os.read(self._read_fd, 64)
        except BlockingIOError:
            pass

    def close(self) -> None:
        """Closes it. Idempotent."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                os.close(self._read_fd)
                os.close(self._write_fd)
