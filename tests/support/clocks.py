"""A clock that a test turns by hand."""

import threading
from collections.abc import Callable

from rosbase.messages import Time


class ManualClock:
    """Stands still, until a wait that nobody ends moves it to the end of the wait."""

    def __init__(self, now_ns: int = 1_700_000_000_000_000_000) -> None:
        self.date_ns = now_ns
        self.elapsed_ns = 0

    def now(self) -> Time:
        return Time.from_nanoseconds(self.now_ns())

    def now_ns(self) -> int:
        return self.date_ns + self.elapsed_ns

    def monotonic_ns(self) -> int:
        return self.elapsed_ns

    def advance(self, seconds: float) -> None:
        self.elapsed_ns += round(seconds * 1e9)

    def sleep(self, seconds: float) -> None:
        self.advance(seconds)

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        def wait(timeout_s: float) -> bool:
            if wakeup.acquire(blocking=False):
                return True
            self.advance(timeout_s)
            return False

        return wait
