"""Checks of timers: on the clock of the test if the backend takes one, else in real time."""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from statistics import median

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.backend import Backend
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig
from rosbase.testing.clock import ManualClock
from rosbase.testing.promise import Promise

__all__ = ["TimerChecks"]

_PERIOD_S = 0.02
_NS_PER_S = 1_000_000_000
_HOUR_NS = 3_600 * _NS_PER_S
_MANY = 40
_NO_PERIODS = (0, -1.0, float("nan"), float("inf"))


class _Ticks:
    """Timer with the times of its calls, in periods since its creation."""

    def __init__(
        self, backend: Backend, during: Callable[["_Ticks"], object] = lambda ticks: None
    ) -> None:
        self._clock = backend.executor.clock
        self._during = during
        self._start_ns = self._clock.monotonic_ns()
        self.times: list[float] = []
        self.timer = backend.create_timer(_PERIOD_S, self._tick)

    @property
    def now(self) -> float:
        """Current time, in periods."""
        return (self._clock.monotonic_ns() - self._start_ns) / (_PERIOD_S * _NS_PER_S)

    def shown(self) -> str:
        """Times as text for a message."""
        return f"[{', '.join(f'{time:.2f}' for time in self.times)}] periods"

    def _tick(self) -> None:
        self.times.append(self.now)
        self._during(self)


class TimerChecks(BackendRig):
    """Checks of timers: absolute deadlines, skipped calls."""

    def test_timers_keep_to_their_deadlines(self) -> None:
        promised, backend = promise("timers-keep-to-their-deadlines"), self._open_timed()

        def work(ticks: _Ticks) -> None:
            # Every third call is so long that the next comes half a period late.
            if len(ticks.times) % 3 == 1:
                backend.executor.clock.sleep(1.5 * _PERIOD_S)

        ticks = _Ticks(backend, work)
        self._await_ticks(promised, backend, ticks, 12)
        # The next call follows a late call after half a period, or more by accident. If
        # deadlines counted from the previous call, it would never be less than a whole period.
        shortest = min(b - a for a, b in pairwise(ticks.times))
        promised.require(
            shortest < 0.8, f"with calls that take 1.5 periods it was called at {ticks.shown()}"
        )

    def test_timers_keep_their_period(self) -> None:
        promised, backend = promise("timers-keep-their-period"), self._open_timed()
        ticks = _Ticks(backend)
        self._await_ticks(promised, backend, ticks, _MANY)
        # The median, because a busy machine is late now and then.
        gap = median(later - earlier for earlier, later in pairwise(ticks.times))
        late = median((time + 0.1) % 1.0 - 0.1 for time in ticks.times)
        promised.require(
            0.5 < gap < 1.5 and late < 0.3,
            f"{gap:.2f} periods passed between calls, and they were {late:.2f} late",
        )

    def test_missed_calls_are_skipped(self) -> None:
        promised, backend = promise("missed-calls-are-skipped"), self._open_timed()

        def stall(ticks: _Ticks) -> None:
            if len(ticks.times) == 1:
                backend.executor.clock.sleep(5.3 * _PERIOD_S)

        ticks = _Ticks(backend, stall)
        self._await_ticks(promised, backend, ticks, 8)
        after = ticks.times[1]
        burst = [time for time in ticks.times[1:] if time < after + 1.0]
        promised.require(
            len(burst) <= 3, f"with a first call that takes 5.3 periods: {ticks.shown()}"
        )

    def test_timers_wait_one_period(self) -> None:
        promised, backend = promise("timers-wait-one-period"), self._open_timed()
        ticks = _Ticks(backend)
        self._await_ticks(promised, backend, ticks, 1)
        promised.require(ticks.times[0] >= 1.0, f"the first call was at {ticks.shown()}")

    def test_cancelled_timers_rest(self) -> None:
        promised, backend = promise("cancelled-timers-rest"), self._open_timed()
        ticks = _Ticks(backend, lambda ticks: ticks.timer.cancel())
        promised.require(not ticks.timer.is_canceled(), "is_canceled() is true of a new timer")
        self._await_ticks(promised, backend, ticks, 1)
        self._let_pass(promised, backend)
        promised.require(len(ticks.times) == 1, f"cancelled at its first call: {ticks.shown()}")
        promised.require(ticks.timer.is_canceled(), "is_canceled() is false after cancel")
        ticks.timer.reset()
        promised.require(not ticks.timer.is_canceled(), "is_canceled() is true after reset")
        self._await_ticks(promised, backend, ticks, 2)

    def test_reset_begins_a_new_period(self) -> None:
        promised, backend = promise("reset-begins-a-new-period"), self._open_timed()
        clock, ticks = backend.executor.clock, _Ticks(backend)
        clock.sleep(0.7 * _PERIOD_S)
        since = ticks.now
        ticks.timer.reset()
        self._await_ticks(promised, backend, ticks, 1)
        promised.require(
            ticks.times[0] >= since + 1.0, f"reset at {since:.2f}, it was called at {ticks.shown()}"
        )

    def test_destroyed_timers_stay_so(self) -> None:
        promised, backend = promise("destroyed-timers-stay-so"), self._open_timed()
        own = _Ticks(backend, lambda ticks: backend.destroy_timer(ticks.timer))
        other = _Ticks(backend)
        backend.destroy_timer(other.timer)
        other.timer.reset()
        self._let_pass(promised, backend)
        promised.require(not other.times, f"destroyed, then reset: {other.shown()}")
        promised.require(len(own.times) == 1, f"destroyed by its own call: {own.shown()}")
        promised.require(other.timer.is_canceled(), "is_canceled() is false of a destroyed timer")

    def test_timers_tell_their_time(self) -> None:
        promised, backend = promise("timers-tell-their-time"), self._open_timed()
        self.on_thread(promised, backend.timer_now_ns, "timer_now_ns, on another thread,")
        told: list[float] = []

        def read(ticks: _Ticks) -> None:
            told.append(backend.timer_now_ns() / (_PERIOD_S * _NS_PER_S))
            if isinstance(backend.executor.clock, ManualClock):
                backend.executor.clock.date_ns -= _HOUR_NS

        ticks = _Ticks(backend, read)
        self._await_ticks(promised, backend, ticks, _MANY)
        steps = [later - earlier for earlier, later in pairwise(told)]
        gaps = [later - earlier for earlier, later in pairwise(ticks.times)]
        # The median, because a busy machine may pause between two readings.
        error = median(abs(step - gap) for step, gap in zip(steps, gaps, strict=True))
        promised.require(
            error < 0.1 and min(steps) >= 0.0,
            f"{median(gaps):.2f} periods passed between calls, and timer_now_ns advanced by"
            f" {min(steps):.2f} to {max(steps):.2f} periods",
        )

    def test_wrong_periods_are_errors(self) -> None:
        promised, backend = promise("wrong-periods-are-errors"), self._open_timed()
        for wrong in _NO_PERIODS:
            self.refuses(
                promised,
                ValueError,
                partial(backend.create_timer, wrong, print),
                f"a timer with a period of {wrong}",
            )

    def _open_timed(self) -> Backend:
        """Open a backend in virtual time, if it takes a clock."""
        clock: Clock = ManualClock() if self.capabilities.takes_a_clock else SystemClock()
        return self.open(clock)

    def _await_ticks(self, promised: Promise, backend: Backend, ticks: _Ticks, number: int) -> None:
        self.wait(
            promised,
            lambda: len(ticks.times) >= number,
            lambda: f"of {number} calls these came: {ticks.shown()}",
            backend,
        )

    def _let_pass(self, promised: Promise, backend: Backend) -> None:
        """Spin for some periods."""
        self._await_ticks(promised, backend, _Ticks(backend), 4)
