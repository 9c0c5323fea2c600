"""The fixed-rate loop of a program that is recorded: each tick is an entry."""

from collections.abc import Callable

from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.recorded_executor import RecordedExecutor
from rosbase.runtime.early_wake import EarlyWake
from rosbase.runtime.executor import Executor, GuestCall
from rosbase.runtime.rate import LoopStats, Rate

__all__ = ["run_recorded_loop"]

_NS_PER_S = 1e9
# As in `run_main_loop`.
_NAP_NS = 10_000_000


def run_recorded_loop(
    executor: Executor,
    frequency_hz: float,
    tick: Callable[[], object],
    stopping: Callable[[], object],
    stats: LoopStats,
    look_after: Callable[[], object],
    *,
    is_precise: bool,
) -> None:
    """Run ticks as `run_main_loop` does, or as `run_precise_loop`, and note each.

    Its own readings of the clock are not the program's, so they are not noted. While it sleeps,
    the turn is free.
    """
    assert isinstance(executor, RecordedExecutor)
    recorder = executor.recorder
    monotonic_ns, start_ns = recorder.clock.machine.monotonic_ns, recorder.clock.start_ns
    ready, timers, notes = executor.ready, executor.timers, stats.notes
    begin, begin_tick, end_tick = recorder.trace.begin, int(Kind.TICK), int(Kind.TICK_END)
    rate = Rate(frequency_hz, monotonic_ns())
    deadline_ns = rate.deadline_ns
    recorder.note_period(Numbered.LOOP, 0, round(_NS_PER_S / frequency_hz))
    early = EarlyWake(_NS_PER_S / float(frequency_hz)) if is_precise else None
    ticks_between = range(max(1, min(LoopStats.MANY_TICKS, int(frequency_hz / 2))))
    # No other thread, and no signal handler, has called during a nap.
    is_alone = not is_precise
    while not stopping():
        for _ in ticks_between:
            recorder.bring_in()
            left_ns = deadline_ns - monotonic_ns()
            may_nap = is_alone and left_ns < _NAP_NS
            if may_nap and not ready and not (timers and timers[0][0] < deadline_ns):
                if left_ns > 0:
                    recorder.nap(left_ns / _NS_PER_S)
                if ready:
                    # One call from outside the program does not count.
                    is_alone = len(ready) == 1 and type(ready[0]) is GuestCall
                    executor.spin_until(deadline_ns, stopping)
            else:
                margin_ns = early.margin_ns if early is not None else 0
                executor.spin_until(deadline_ns - margin_ns, stopping)
            if stopping():
                return
            now_ns = monotonic_ns()
            if early is not None:
                early.note(deadline_ns - now_ns)
                while now_ns < deadline_ns:
                    now_ns = monotonic_ns()
            notes.append(now_ns)
            begin(begin_tick, now_ns - start_ns, stats.overruns, len(ready))
            tick()
            end_ns = monotonic_ns()
            notes.append(end_ns)
            deadline_ns = rate.advance(end_ns)
            stats.overruns = rate.skipped
            begin(end_tick, end_ns - start_ns, rate.skipped)
        recorder.enter_now(Kind.LOOK)
        look_after()
