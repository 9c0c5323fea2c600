"""Signals while the launcher runs: the first stops everything in order, the second at once."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from rosbase.clock import Clock
from rosbase.runtime.signal_masks import STOP_SIGNALS
from rosbase.runtime.stopping.wishes import Wishes

__all__ = ["stop_wishes"]


@contextmanager
def stop_wishes(on_wish: Callable[[int], object], clock: Clock) -> Iterator[None]:
    """Call a function for SIGINT, SIGTERM and SIGHUP, as long as the context lasts.

    Signals within a second are one wish. A signal that is ignored, as SIGHUP under nohup, stays
    ignored. Outside of the main thread, where Python delivers no signals, nothing changes.

    Args:
        on_wish: Called in the signal handler with the number of wishes so far.
        clock: The clock.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    wishes = Wishes()

    def handle(signum: int, frame: FrameType | None) -> None:
        if wishes.add(clock.monotonic_ns()):
            on_wish(wishes.count)

    numbers = [n for n in STOP_SIGNALS if signal.getsignal(n) is not signal.SIG_IGN]
    before: dict[int, Any] = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            # None: a handler that Python did not install, and cannot put back.
            if handler is not None:
                signal.signal(number, handler)
