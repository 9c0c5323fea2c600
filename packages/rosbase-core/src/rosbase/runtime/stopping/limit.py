"""End a run in virtual time that does not end by itself, with a reason."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from rosbase.runtime.stopping.interrupt import Defer, Interrupt, is_user_code

__all__ = ["limit_real_time"]


class _RealTimeOver(BaseException):
    """The limit is reached. User code that catches `Exception` does not catch this."""


@contextmanager
def limit_real_time(clock: object, defer: Defer) -> Iterator[None]:
    """Raise TimeoutError if a run takes longer in real time than its clock allows.

    A run in virtual time hangs if its program sleeps in real time, if callbacks feed each
    other, or if nothing stops it. The run then fails, even if the program catches what ends
    the blocking code. Outside of the main thread there is no limit.

    Args:
        clock: Its `real_limit_s` is the limit in seconds; without one, or with None, there is
            none.
        defer: Queues a call for the spinning thread, from a signal handler.

    Raises:
        TimeoutError: The limit was reached; it says where the run was.
    """
    limit_s: float | None = getattr(clock, "real_limit_s", None)
    if limit_s is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    # Each time the program is interrupted; the first one says where it hung.
    reasons: list[str] = []

    def make_error(frame: FrameType | None) -> _RealTimeOver:
        reasons.append(
            f"after {limit_s:g} s of real time this run in virtual time has not ended: "
            f"{_where(frame)}; a run that needs longer takes ManualClock(real_limit_s=...)"
        )
        return _RealTimeOver(reasons[0])

    interrupt = Interrupt(make_error, defer)
    interrupt.arm(limit_s, repeats=True)
    try:
        yield
    except BaseException as error:
        interrupt.disarm()
        # Ctrl-C ends the test runner.
        if not reasons or isinstance(error, KeyboardInterrupt):
            raise
        cause = None if isinstance(error, _RealTimeOver) else error
        raise TimeoutError(reasons[0]).with_traceback(error.__traceback__) from cause
    finally:
        interrupt.disarm()
    if reasons:
        raise TimeoutError(reasons[0])


def _where(frame: FrameType | None) -> str:
    while frame is not None and not is_user_code(frame, innermost=True):
        frame = frame.f_back
    if frame is None:
        return "nobody stops it"
    code = frame.f_code
    # With the name of the class, from Python 3.11 on.
    name = getattr(code, "co_qualname", code.co_name)
    return f"{name} is running ({code.co_filename}:{frame.f_lineno})"
