"""End a run in virtual time that does not end by itself, with a reason."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from rosbase.runtime.stopping.interrupt import Defer, Interrupt, is_user_code

__all__ = ["limit_real_time"]


@contextmanager
def limit_real_time(clock: object, defer: Defer) -> Iterator[None]:
    """Raise TimeoutError if a run takes longer in real time than its clock allows.

    A run in virtual time hangs if its program sleeps in real time, if callbacks feed each
    other, or if nothing stops it. Outside of the main thread there is no limit.

    Args:
        clock: Its `real_limit_s` is the limit in seconds; without one, or with None, there is
            none.
        defer: Queues a call for the spinning thread, from a signal handler.
    """
    limit_s: float | None = getattr(clock, "real_limit_s", None)
    if limit_s is None or threading.current_thread() is not threading.main_thread():
        yield
        return

    def make_error(frame: FrameType | None) -> TimeoutError:
        where = _where(frame)
        return TimeoutError(
            f"after {limit_s:g} s of real time this run in virtual time has not ended: {where}; "
            "a run that needs longer takes ManualClock(real_limit_s=...)"
        )

    interrupt = Interrupt(make_error, defer)
    interrupt.arm(limit_s, repeats=True)
    try:
        yield
    finally:
        interrupt.disarm()


def _where(frame: FrameType | None) -> str:
    while frame is not None and not is_user_code(frame, innermost=True):
        frame = frame.f_back
    if frame is None:
        return "nobody stops it"
    code = frame.f_code
    return f"{code.co_qualname} is running ({code.co_filename}:{frame.f_lineno})"
