"""Signals and threads: a signal that wakes another thread does not wake the main thread."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["hold_signals", "leave_signals_to_the_main_thread"]

# Windows has neither SIGHUP nor masks.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_STOPS = frozenset(getattr(signal, name) for name in _NAMES if hasattr(signal, name))
_HAS_MASKS = hasattr(signal, "pthread_sigmask")


def leave_signals_to_the_main_thread() -> None:
    """Block SIGINT, SIGTERM and SIGHUP in this thread, unless it is the main thread.

    Python handles signals on the main thread. If the system delivers one to another thread, a
    `sleep` of the main thread goes on, and the handler runs only after it. Processes that this
    thread starts inherit the mask; the guardian of a child resets it.
    """
    if _HAS_MASKS and threading.current_thread() is not threading.main_thread():
        signal.pthread_sigmask(signal.SIG_BLOCK, _STOPS)


@contextmanager
def hold_signals() -> Iterator[None]:
    """Hold back these signals in this thread, and in processes that it starts meanwhile."""
    if not _HAS_MASKS:
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _STOPS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
