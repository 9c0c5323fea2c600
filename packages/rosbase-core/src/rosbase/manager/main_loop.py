"""The fixed-rate loop: ticks at absolute deadlines, messages in between, on one thread."""

from collections.abc import Callable

from rosbase.backend import Backend
from rosbase.rate import LoopStats, Rate

__all__ = ["run_main_loop"]


def run_main_loop(
    backend: Backend,
    frequency_hz: float,
    tick: Callable[[], object],
    stopping: Callable[[], object],
    stats: LoopStats,
    look_after: Callable[[], object],
) -> None:
    """Runs ticks until `stopping`; whatever a tick or a callback raises ends the loop.

    `look_after` is called between ticks, at least once a second if there are ticks; it
    digests the notes of `stats`.
    """
    monotonic_ns, spin_until, notes = backend.clock.monotonic_ns, backend.spin_until, stats.notes
    rate = Rate(frequency_hz, monotonic_ns())
    deadline_ns, period_ns = rate.deadline_ns, rate.whole_period_ns
    many_notes = min(LoopStats.MANY_NOTES, 2 * max(1, int(frequency_hz / 2)))
    while True:
        spin_until(deadline_ns, stopping)
        if stopping():
            return
        start_ns = monotonic_ns()
        tick()
        end_ns = monotonic_ns()
        # Spread out here, not called: after a sleep the processor is cold, and a call costs a
        # microsecond or more. What is written is what `rate` and `stats` would do.
        notes.append(start_ns)
        notes.append(end_ns)
        if period_ns and end_ns - deadline_ns < 2 * period_ns:
            deadline_ns += period_ns
        else:
            rate.deadline_ns = deadline_ns
            deadline_ns = rate.advance(end_ns)
            stats.overruns = rate.skipped
        if len(notes) >= many_notes:
            look_after()
