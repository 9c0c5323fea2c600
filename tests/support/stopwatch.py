"""Measure how long something takes, without the time for which the machine stood still."""

import threading
import time
from types import TracebackType

_TICK_S = 0.01
# Less than this is the ordinary business of a busy machine, which the limits of tests allow for.
_STALL_S = 0.1


class Stopwatch:
    """Time that passes for a test. Use it as a context manager.

    A machine that stalls for a second, as virtual ones do, stalls a thread of the test too, which
    waits for a moment again and again.
    """

    def __init__(self) -> None:
        self._begun_s = time.monotonic()
        self._stalled_s = 0.0
        self._has_ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="stopwatch")

    def __enter__(self) -> "Stopwatch":
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._has_ended.set()
        self._thread.join()

    @property
    def took_s(self) -> float:
        """Time since the start, without stalls."""
        return time.monotonic() - self._begun_s - self._stalled_s

    def _watch(self) -> None:
        before_s = time.monotonic()
        while not self._has_ended.wait(_TICK_S):
            now_s = time.monotonic()
            if now_s - before_s > _STALL_S:
                self._stalled_s += now_s - before_s - _TICK_S
            before_s = now_s
