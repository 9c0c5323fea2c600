import threading
from collections.abc import Iterator
from functools import partial

import pytest

from rosbase.backend import BackendOptions
from rosbase.clock import SystemClock
from rosbase.local import Bus, LocalBackend
from support.clocks import ManualClock


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def backend(clock: ManualClock) -> Iterator[LocalBackend]:
    backend = LocalBackend(BackendOptions("robot", clock=clock), Bus())
    yield backend
    backend.close()


def never() -> bool:
    return False


def test_timers_keep_absolute_deadlines(backend: LocalBackend, clock: ManualClock) -> None:
    calls: list[float] = []
    backend.create_timer(0.25, lambda: calls.append(clock.elapsed_ns / 1e9))
    backend.spin_until(1_000_000_000, never)
    assert calls == [0.25, 0.5, 0.75]


def test_missed_periods_are_skipped_not_caught_up(
    backend: LocalBackend, clock: ManualClock
) -> None:
    calls: list[float] = []

    def slow() -> None:
        calls.append(clock.elapsed_ns / 1e9)
        clock.advance(0.35)

    backend.create_timer(0.1, slow)
    backend.spin_until(1_000_000_000, never)
    # Late ones run at once, and the next deadline is on the grid again.
    assert calls == pytest.approx([0.1, 0.45, 0.8])


def test_cancel_and_reset(backend: LocalBackend, clock: ManualClock) -> None:
    calls: list[int] = []
    timer = backend.create_timer(0.1, lambda: calls.append(clock.elapsed_ns))
    timer.cancel()
    assert timer.is_canceled()
    backend.spin_until(300_000_000, never)
    assert calls == []
    timer.reset()
    timer.reset()
    backend.spin_until(450_000_000, never)
    assert calls == [400_000_000]


def test_a_timer_may_destroy_itself(backend: LocalBackend) -> None:
    calls: list[int] = []

    def once() -> None:
        calls.append(1)
        backend.destroy_timer(timer)

    timer = backend.create_timer(0.1, once)
    backend.spin_until(1_000_000_000, never)
    assert calls == [1]


def test_a_timer_set_from_another_thread_wakes_the_spinner() -> None:
    backend = LocalBackend(BackendOptions("robot", clock=SystemClock()), Bus())
    fired: list[int] = []
    asleep = threading.Event()

    def add() -> None:
        asleep.wait()
        backend.create_timer(0.001, lambda: fired.append(1))

    thread = threading.Thread(target=add)
    thread.start()
    backend.call_soon(asleep.set)
    deadline_ns = backend.clock.monotonic_ns() + 30 * 10**9
    backend.spin_until(deadline_ns, lambda: bool(fired))
    assert backend.clock.monotonic_ns() < deadline_ns
    thread.join()
    backend.close()


@pytest.mark.parametrize("period_s", [0.0, -1.0, float("nan"), float("inf")])
def test_a_period_must_be_positive_and_finite(backend: LocalBackend, period_s: float) -> None:
    with pytest.raises(ValueError, match="period"):
        backend.create_timer(period_s, print)


def test_what_is_ready_is_handled_even_behind_the_deadline(backend: LocalBackend) -> None:
    calls: list[int] = []
    for number in range(3):
        backend.call_soon(partial(calls.append, number))
    backend.spin_until(-1, never)
    assert calls == [0, 1, 2]


def test_a_callback_that_calls_itself_soon_does_not_hold_up_the_deadline(
    backend: LocalBackend, clock: ManualClock
) -> None:
    def again() -> None:
        clock.advance(0.01)
        backend.call_soon(again)

    backend.call_soon(again)
    backend.spin_until(100_000_000, never)
    assert clock.elapsed_ns <= 110_000_000


def test_stopping_ends_the_spin(backend: LocalBackend) -> None:
    stops: list[int] = []
    backend.call_soon(lambda: stops.append(1))
    backend.spin_until(10**15, lambda: bool(stops))
    assert stops == [1]
