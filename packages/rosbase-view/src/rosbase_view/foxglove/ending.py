"""The end of the command: by a signal, or by a thread that has failed."""

import select
import signal

from rosbase import WakePipe

__all__ = ["Ending"]


class Ending:
    """Waits for the end, in a `with` block of the main thread."""

    def __enter__(self) -> "Ending":
        """Take SIGINT and SIGTERM."""
        self._wake = WakePipe()
        self._failure: Exception | None = None
        self._before = {
            number: signal.signal(number, self._take) for number in (signal.SIGINT, signal.SIGTERM)
        }
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the signals to whoever had them."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._wake.close()

    def fail(self, error: Exception) -> None:
        """End with an error. Any thread may do so."""
        self._failure = error
        self._wake.wake()

    def wait(self) -> None:
        """Wait for the end.

        Raises:
            Exception: A thread has failed with it.
        """
        poll = select.poll()
        poll.register(self._wake, select.POLLIN)
        poll.poll()
        if self._failure is not None:
            raise self._failure

    def _take(self, number: int, _frame: object) -> None:
        # Another one ends the process at once, whatever does not end.
        signal.signal(number, signal.SIG_DFL)
        self._wake.wake()
