"""Ctrl-C, SIGTERM and SIGHUP as a request: the first asks, the second forces."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["stop_on_signals"]

# Windows has no SIGHUP.
_HANGUP = getattr(signal, "SIGHUP", None)
_SIGNALS = [signal.SIGINT, signal.SIGTERM] + ([_HANGUP] if _HANGUP is not None else [])


@contextmanager
def stop_on_signals(request_stop: Callable[[], object]) -> Iterator[None]:
    """Has SIGINT, SIGTERM and SIGHUP call `request_stop`, as long as the context lasts.

    A SIGHUP that is ignored, as under nohup, stays ignored. `request_stop` must be quick and
    take no locks, for it runs in the signal handler. A second signal ends the process at once,
    with the status that a shell gives to that signal. Outside of the main thread, where Python
    delivers no signals, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked = False

    def handle(signum: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            os._exit(128 + signum)
        asked = True
        request_stop()

    before = {
        number: signal.signal(number, handle)
        for number in _SIGNALS
        if number != _HANGUP or signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
