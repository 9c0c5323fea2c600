"""What is wrong with timers."""

import math
import threading
from collections.abc import Callable

from rosbase.contracts.backend import Timer
from rosbase.errors import BackendError
from rosbase.local import LocalBackend
from support.backend_mutants.changed import Changed, breaks


class ChangedTimer:
    """A timer of the core, to be changed in one thing."""

    def __init__(self, inner: Timer) -> None:
        self.inner = inner

    def cancel(self) -> None:
        self.inner.cancel()

    def reset(self) -> None:
        self.inner.reset()

    def is_canceled(self) -> bool:
        return self.inner.is_canceled()


@breaks("timers-keep-to-their-deadlines")
class CountsFromTheCallBefore(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        def call() -> None:
            callback()
            timer.reset()

        timer = super().create_timer(period_s, call)
        return timer


@breaks("missed-calls-are-skipped")
class CatchesUp(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        calls, start_ns = 0, self.clock.monotonic_ns()

        def call() -> None:
            nonlocal calls
            while calls < (self.clock.monotonic_ns() - start_ns) // int(period_s * 1e9):
                calls += 1
                callback()

        return super().create_timer(period_s, call)


@breaks("timers-wait-one-period")
class CannotWait(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        self.call_soon(callback)
        return super().create_timer(period_s, callback)


@breaks("cancelled-timers-rest")
class CannotCancel(LocalBackend):
    class Restless(ChangedTimer):
        def cancel(self) -> None:
            pass

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return self.Restless(super().create_timer(period_s, callback))


@breaks("cancelled-timers-rest")
class SaysNotThatItRests(LocalBackend):
    class Silent(ChangedTimer):
        def is_canceled(self) -> bool:
            return False

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return self.Silent(super().create_timer(period_s, callback))


@breaks("reset-begins-a-new-period")
class ResetsOnlyWhatRests(LocalBackend):
    class Stubborn(ChangedTimer):
        def reset(self) -> None:
            if self.is_canceled():
                super().reset()

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return self.Stubborn(super().create_timer(period_s, callback))


@breaks("destroyed-timers-stay-so")
class CancelsWhatItShouldDestroy(LocalBackend):
    def destroy_timer(self, timer: Timer) -> None:
        timer.cancel()


@breaks("timers-tell-their-time")
class TellsTheDate(LocalBackend):
    def timer_now_ns(self) -> int:
        return self.clock.now_ns()


@breaks("timers-tell-their-time")
class TellsItInMicroseconds(LocalBackend):
    def timer_now_ns(self) -> int:
        return super().timer_now_ns() // 1000


@breaks("timers-tell-their-time")
class TellsItOnOneThread(Changed):
    def timer_now_ns(self) -> int:
        if threading.current_thread() is not self.thread:
            raise RuntimeError("the time is for the thread that spins")
        return super().timer_now_ns()


@breaks("wrong-periods-are-errors")
class TakesAnyPeriod(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        is_one = math.isfinite(period_s) and period_s > 0
        return super().create_timer(period_s if is_one else 1.0, callback)


@breaks("wrong-periods-are-errors")
class HasAnErrorOfItsOwn(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        try:
            return super().create_timer(period_s, callback)
        except ValueError as error:
            raise BackendError(str(error)) from None


@breaks("timers-keep-their-period")
class IsATenthSlow(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return super().create_timer(period_s * 1.1, callback)


@breaks("timers-keep-their-period")
class IsThriceAsSlow(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return super().create_timer(period_s * 3, callback)


@breaks("timers-keep-their-period")
class CallsTwice(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        return super().create_timer(period_s, lambda: (callback(), callback()))
