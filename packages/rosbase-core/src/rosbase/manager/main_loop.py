"""The fixed-rate loop: ticks at absolute deadlines, messages in between, on one thread."""

from collections.abc import Callable

from rosbase.runtime.executor import Executor, GuestCall
from rosbase.runtime.rate import LoopStats, Rate

__all__ = ["run_main_loop"]

# A sleep that nobody can end costs a tenth less than one that others can. So short ones are
# of that kind until another thread calls; its first call may come this much late.
_NAP_NS = 10_000_000
_ALWAYS = 1 << 62


def run_main_loop(
    executor: Executor,
    frequency_hz: float,
    tick: Callable[[], object],
    stopping: Callable[[], object],
    stats: LoopStats,
    look_after: Callable[[], object],
) -> None:
    """Run ticks until `stopping`; an exception of a tick or a callback ends the loop.

    `look_after` is called between ticks, at least once a second if there are ticks; it digests
    the notes of `stats`. Code that makes `stopping` true must also call `call_soon`.
    """
    # The usual tick of a simple program takes as few steps as can be, spread out here instead
    # of called: after a sleep the processor is cold and slow, and a call costs microseconds.
    monotonic_ns, nap, nap_ns = executor.clock.monotonic_ns, executor.clock.sleep, _NAP_NS
    ready, timers, notes = executor.ready, executor.timers, stats.notes
    rate = Rate(frequency_hz, monotonic_ns())
    deadline_ns, period_ns = rate.deadline_ns, rate.whole_period_ns
    # What `rate` would do is done here while no tick is a whole period late.
    late_ns = -period_ns if period_ns else _ALWAYS
    ticks_between = range(max(1, min(LoopStats.MANY_TICKS, int(frequency_hz / 2))))
    # No other thread, and no signal handler, has called during a nap.
    is_alone = True
    while not stopping():
        left_ns = deadline_ns - monotonic_ns()
        for _ in ticks_between:
            if (
                left_ns < nap_ns
                and is_alone
                and not ready
                and not (timers and timers[0][0] < deadline_ns)
            ):
                if left_ns > 0:
                    nap(left_ns / 1e9)
                if ready:
                    # One call from outside the program, such as for its state, does not count.
                    is_alone = len(ready) == 1 and type(ready[0]) is GuestCall
                    executor.spin_until(deadline_ns, stopping)
                    if stopping():
                        return
            else:
                executor.spin_until(deadline_ns, stopping)
                if stopping():
                    return
            # Noted before the tick, so that others can tell how long it has taken so far.
            notes.append(monotonic_ns())
            tick()
            end_ns = monotonic_ns()
            notes.append(end_ns)
            deadline_ns += period_ns
            left_ns = deadline_ns - end_ns
            if left_ns <= late_ns:
                rate.deadline_ns = deadline_ns - period_ns
                deadline_ns = rate.advance(end_ns)
                left_ns = deadline_ns - end_ns
                stats.overruns = rate.skipped
        look_after()
