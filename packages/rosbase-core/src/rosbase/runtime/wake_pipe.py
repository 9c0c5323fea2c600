"""A pipe that wakes a thread from any wait in the kernel."""

import os
import threading

__all__ = ["WakePipe"]


class WakePipe:
    """A pipe that one thread polls; any thread may write to it, even after it was closed."""

    def __init__(self) -> None:
        """Open the pipe.

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
        """Return the descriptor to poll for input."""
        return self._read_fd

    def wake(self) -> None:
        """Wake the polling thread, now or at its next poll."""
        with self._lock:
            if not self._is_closed:
                try:
                    os.write(self._write_fd, b"x")
                except BlockingIOError:
                    # It is being woken already.
                    pass

    def drain(self) -> None:
        """Read the wake-ups, so that it can be polled again."""
        try:
            os.read(self._read_fd, 64)
        except BlockingIOError:
            pass

    def close(self) -> None:
        """Close the pipe. Idempotent."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                os.close(self._read_fd)
                os.close(self._write_fd)

    def abandon(self) -> None:
        """Close the pipe in a forked child, where a thread that is gone may hold its lock."""
        self._lock = threading.Lock()
        self.close()
