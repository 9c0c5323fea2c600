"""`rosbase view --foxglove`: serve until the user ends it."""

import select
import signal

from rosbase import SystemClock, WakePipe
from rosbase_view.foxglove.live_bridge import LiveBridge
from rosbase_view.foxglove.server import Address

__all__ = ["serve"]


def serve(name: str | None, address: Address) -> None:
    """Serve programs until SIGINT or SIGTERM.

    Args:
        name: A program, or the pid of its process, with its child processes; None for all.
        address: Where to listen.

    Raises:
        ConfigurationError: The port is in use.
        ControlError: No program has the name, or several have.
    """
    with _End() as end:
        bridge = LiveBridge(name, SystemClock(), end.fail)
        try:
            port = bridge.start(address)
            url = f"ws://{address.host}:{port}"
            what = "all programs" if name is None else name
            print(f"{what} at {url}, for Foxglove, Lichtblick and PlotJuggler", flush=True)
            end.wait()
        finally:
            bridge.close()


class _End:
    """The end: by a signal, or by a thread that has failed."""

    def __enter__(self) -> "_End":
        self._wake = WakePipe()
        self._failure: Exception | None = None
        self._before = {
            number: signal.signal(number, self._take) for number in (signal.SIGINT, signal.SIGTERM)
        }
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._wake.close()

    def _take(self, number: int, _frame: object) -> None:
        # Another one ends the process at once, whatever does not end.
        signal.signal(number, signal.SIG_DFL)
        self._wake.wake()

    def fail(self, error: Exception) -> None:
        """End with an error. Any thread may do so."""
        self._failure = error
        self._wake.wake()

    def wait(self) -> None:
        """Wait for it.

        Raises:
            Exception: A thread has failed with it.
        """
        poll = select.poll()
        poll.register(self._wake, select.POLLIN)
        poll.poll()
        if self._failure is not None:
            raise self._failure
