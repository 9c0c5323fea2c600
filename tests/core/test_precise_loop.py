"""The loop with `timing="precise"`, on a clock whose sleeps end late, and on the machine's."""

import itertools
import signal
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import BaseHandlers, BaseManager
from rosbase.manager.precise_loop import run_precise_loop
from rosbase.runtime.early_wake import EarlyWake
from rosbase.runtime.executor import Executor
from rosbase.runtime.rate import LoopStats, Rate
from rosbase.testing import ManualClock, virtual_backend
from support.program import running
from support.roles import StopAfter

READING_NS = 50


class SleepyClock(ManualClock):
    """Its waits end late, and each reading takes time, as on a machine."""

    def __init__(self, late_ns: Iterable[int]) -> None:
        super().__init__()
        self._late_ns = itertools.cycle(late_ns)

    def monotonic_ns(self) -> int:
        self.elapsed_ns += READING_NS
        return super().monotonic_ns()

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        wait = super().waiter(wakeup)

        def wait_too_long(timeout_s: float) -> bool:
            was_woken = wait(timeout_s)
            self.elapsed_ns += 0 if was_woken else next(self._late_ns)
            return was_woken

        return wait_too_long


def starts_of(
    clock: SleepyClock, frequency_hz: float, durations_ns: list[int]
) -> tuple[list[int], LoopStats]:
    """When the ticks of these durations began."""
    executor, stats, began_ns = Executor(clock), LoopStats(), []

    def tick() -> None:
        began_ns.append(clock.elapsed_ns)
        clock.elapsed_ns += durations_ns[len(began_ns) - 1]

    def is_over() -> bool:
        return len(began_ns) == len(durations_ns)

    run_precise_loop(executor, frequency_hz, tick, is_over, stats, lambda: None)
    return began_ns, stats


@given(
    st.lists(st.integers(0, 90_000), min_size=1, max_size=5), st.sampled_from([30.0, 200, 333.3])
)
def test_ticks_begin_within_one_reading_of_the_clock_though_sleeps_end_late(
    late_ns: list[int], frequency_hz: float
) -> None:
    began_ns, stats = starts_of(SleepyClock(late_ns), frequency_hz, [0] * 50)
    rate = Rate(frequency_hz, READING_NS)
    for start_ns in began_ns[1:]:
        due_ns = rate.advance(0)
        assert 0 <= start_ns - due_ns <= 2 * READING_NS
    assert (stats.ticks, stats.overruns) == (50, 0)


@given(
    st.lists(st.integers(0, 60_000_000), min_size=1, max_size=40),
    st.sampled_from([10.0, 30.0, 200.0, 333.3, 1000.0]),
)
def test_late_ticks_run_at_once_and_missed_periods_are_skipped(
    durations_ns: list[int], frequency_hz: float
) -> None:
    began_ns, stats = starts_of(SleepyClock([0]), frequency_hz, durations_ns)
    rate, free_ns = Rate(frequency_hz, READING_NS), 0
    for start_ns, duration_ns in zip(began_ns, durations_ns, strict=True):
        # Some readings of the clock lie between what is due and what begins.
        assert 0 <= start_ns - max(free_ns, rate.deadline_ns) <= 20 * READING_NS
        free_ns = start_ns + duration_ns
        rate.advance(free_ns + READING_NS)
    assert stats.overruns == rate.skipped


def test_the_statistics_show_the_start_of_ticks_and_not_the_end_of_sleeps() -> None:
    _, stats = starts_of(SleepyClock([10_000, 80_000]), 200, [1_000_000] * 400)
    assert stats.period.percentile(1) == pytest.approx(5_000_000, rel=1 / 32)
    assert stats.period.maximum == pytest.approx(5_000_000, abs=200)
    assert stats.busy.maximum == pytest.approx(1_000_000, abs=200)


def test_a_sleep_is_ended_as_early_as_nine_of_ten_need_it() -> None:
    early = EarlyWake(5_000_000)
    for number in range(20_000):
        late_ns = 80_000 if number % 20 == 0 else 30_000 + 10_000 * (number % 3)
        early.note(early.margin_ns - late_ns)
    assert 49_000 < early.margin_ns < 60_000


@given(st.integers(1, 10**9), st.lists(st.integers(-(10**9), 10**9)))
def test_the_margin_is_at_most_a_quarter_of_a_millisecond_and_half_of_a_period(
    period_ns: int, left_ns: list[int]
) -> None:
    early = EarlyWake(period_ns)
    for left in [*left_ns, *[-1] * 400]:
        early.note(left)
        assert 0 <= early.margin_ns <= min(250_000, period_ns / 2)


def test_in_virtual_time_the_ticks_are_those_of_normal_timing() -> None:
    def began_ns(timing: Any) -> list[int]:
        clock = ManualClock()
        began: list[int] = []

        class Handlers(StopAfter):
            ticks = 20

            def handle(self) -> None:
                began.append(clock.elapsed_ns)
                super().handle()

        BaseManager(
            handlers_class=Handlers, backend=virtual_backend(clock), timing=timing
        ).start_main_loop_timer()
        return began

    assert began_ns("precise") == began_ns("normal") == [n * 5_000_000 for n in range(20)]


@pytest.mark.parametrize("timing", ["exact", "", None, 1, []])
def test_another_timing_is_an_error(timing: Any) -> None:
    with pytest.raises(ValueError, match=r"^timing is 'normal' or 'precise', not "):
        BaseManager(timing=timing, backend=virtual_backend())


def test_on_the_machine_no_tick_begins_too_early_and_messages_are_handled_in_between() -> None:
    began_ns: list[int] = []
    called: list[int] = []

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            began_ns.append(self.manager.backend.executor.clock.monotonic_ns())
            self.manager.backend.call_soon(lambda: called.append(len(began_ns)))
            if len(began_ns) == 101:
                self.manager.request_stop()

    manager = BaseManager(handlers_class=Handlers, node_freq_hz=500, timing="precise")
    manager.start_main_loop_timer()
    assert called == list(range(1, 101))
    for number, start_ns in enumerate(began_ns):
        assert start_ns - began_ns[0] >= number * 2_000_000 - 1_000_000
    assert (began_ns[-1] - began_ns[0]) >= 100 * 2_000_000 - 1_000_000


PROGRAM = """
from rosbase import BaseHandlers, BaseManager

class Handlers(BaseHandlers):
    def handle(self):
        print("tick", flush=True)

if __name__ == "__main__":
    BaseManager(handlers_class=Handlers, node_freq_hz=0.5, timing="precise").start_main_loop_timer()
    print("ended")
"""


def test_a_signal_ends_it_between_two_ticks(tmp_path: Path) -> None:
    with running(tmp_path, PROGRAM) as program:
        program.read_until("tick")
        program.process.send_signal(signal.SIGTERM)
        assert program.end()[:2] == (0, "ended\n")
