"""Ctrl-C and SIGTERM as a wish that a command looks at, so that a recording ends in order."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["stop_request"]

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def stop_request() -> Iterator[Callable[[], bool]]:
    """Return a function that tells whether a signal has asked for the stop. On the main thread.

    A second signal does what the first would have done before.
    """
    was_asked = False
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    # One that is ignored, as under nohup, stays so.
    taken = [number for number, handler in before.items() if handler is not signal.SIG_IGN]

    def restore() -> None:
        for number in taken:
            signal.signal(number, before[number])

    def ask(signum: int, frame: object) -> None:
        nonlocal was_asked
        was_asked = True
        restore()

    for number in taken:
        signal.signal(number, ask)
    try:
        yield lambda: was_asked
    finally:
        restore()
