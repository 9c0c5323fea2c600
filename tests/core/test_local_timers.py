from collections import deque
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from rosbase.contracts.backend import BackendOptions, Timer
from rosbase.local import Bus, LocalBackend
from rosbase.testing import ManualClock


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


def test_a_timer_that_is_always_late_does_not_starve_messages(
    backend: LocalBackend, clock: ManualClock
) -> None:
    calls: list[int] = []
    backend.create_timer(0.010, lambda: clock.advance(0.012))
    for number in range(5):
        backend.call_soon(partial(calls.append, number))
    backend.spin_until(200_000_000, never)
    assert calls == [0, 1, 2, 3, 4]


def test_a_flood_of_calls_does_not_starve_a_timer(
    backend: LocalBackend, clock: ManualClock
) -> None:
    fired: list[int] = []

    def again() -> None:
        clock.advance(0.001)
        backend.call_soon(again)

    backend.create_timer(0.010, lambda: fired.append(clock.elapsed_ns))
    backend.call_soon(again)
    backend.spin_until(105_000_000, never)
    assert len(fired) == 10


class TrapClock(ManualClock):
    """Does something at the n-th time that it is read by an executor that is not asleep yet."""

    def __init__(self) -> None:
        super().__init__()
        self.backend = LocalBackend(BackendOptions("robot", clock=self), Bus())
        self.reads_left = 0
        self.spring: Callable[[], object] | None = None

    def monotonic_ns(self) -> int:
        if self.spring is not None and not self.backend.executor._sleeping:
            self.reads_left -= 1
            if self.reads_left < 0:
                spring, self.spring = self.spring, None
                spring()
        return super().monotonic_ns()


def test_a_timer_set_while_the_spinner_falls_asleep_is_not_slept_over() -> None:
    clock = TrapClock()
    backend = clock.backend
    backend.create_timer(1000.0, print)
    late_ns: list[int] = []

    def set_timer() -> None:
        due_ns = clock.elapsed_ns + 20_000_000
        own: list[Timer] = []

        def fired() -> None:
            late_ns.append(clock.elapsed_ns - due_ns)
            backend.destroy_timer(own[0])

        own.append(backend.create_timer(0.02, fired))

    for reads in range(8):
        clock.reads_left, clock.spring = reads, set_timer
        backend.spin_until(clock.elapsed_ns + 100_000_000, never)
    assert len(late_ns) >= 4
    assert max(late_ns) == 0
    backend.close()


def test_a_call_made_while_the_spinner_falls_asleep_is_not_slept_over(
    backend: LocalBackend, clock: ManualClock
) -> None:
    executor = backend.executor
    late_ns: list[int] = []

    class Trap(deque[Callable[[], object]]):
        """Somebody calls right after it was found empty for the n-th time."""

        looks_left = 0

        def __bool__(self) -> bool:
            found = len(self) > 0
            self.looks_left -= 1
            if self.looks_left == -1 and not executor._sleeping:
                due_ns = clock.elapsed_ns
                executor.call_soon(lambda: late_ns.append(clock.elapsed_ns - due_ns))
            return found

    executor.ready = trap = Trap()
    for looks in range(6):
        trap.looks_left = looks
        backend.spin_until(clock.elapsed_ns + 100_000_000, never)
    assert late_ns
    assert max(late_ns) == 0


def test_a_watchdog_reset_by_every_message_does_not_grow(backend: LocalBackend) -> None:
    watchdog = backend.create_timer(60.0, print)
    for _ in range(10_000):
        watchdog.reset()
    assert len(backend.executor.timers) <= 65


@pytest.mark.parametrize("others", [0, 3])
def test_stopping_ends_the_spin_at_once(
    backend: LocalBackend, clock: ManualClock, others: int
) -> None:
    stops: list[int] = []
    for number in range(others):
        backend.call_soon(partial(stops.append, number))
    backend.call_soon(lambda: stops.append(9))
    backend.spin_until(10**15, lambda: 9 in stops)
    assert stops == [*range(others), 9]
    backend.spin_until(10**15, lambda: True)
    assert clock.elapsed_ns == 0
