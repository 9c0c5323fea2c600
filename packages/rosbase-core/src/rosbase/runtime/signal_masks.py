"""Masks that decide which threads and processes receive SIGINT, SIGTERM and SIGHUP."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["STOP_SIGNALS", "background_thread", "hold_signals"]

# Windows has neither SIGHUP nor masks.
STOP_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Signals that ask a program to stop."""
_HAS_MASKS = hasattr(signal, "pthread_sigmask")


def background_thread(target: Callable[[], object], name: str) -> threading.Thread:
    """Return a daemon thread, not started, that does not receive SIGINT, SIGTERM and SIGHUP.

    Python handles signals on the main thread. If the system delivers one to another thread, a
    `sleep` of the main thread goes on, and the handler runs only after it. Processes that the
    thread starts inherit the mask; rosbase's child processes reset it.

    Args:
        target: Function that the thread runs.
        name: Name of the thread.
    """

    def run() -> None:
        if _HAS_MASKS:
            signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
        target()

    return threading.Thread(target=run, name=name, daemon=True)


@contextmanager
def hold_signals() -> Iterator[None]:
    """Hold back these signals in this thread, and in processes that it starts meanwhile."""
    if not _HAS_MASKS:
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
