"""The fixed-rate loop: ticks at absolute deadlines, messages in between, on one thread."""

from collections.abc import Callable

from rosbase.backend import Backend
from rosbase.rate import LoopStats, Rate

__all__ = ["run_main_loop"]


def run_main_loop(
    backend: Backend,
    frequency_hz: float,
    tick: Callable[[], object],
    stopping: Callable[[], bool],
    stats: LoopStats,
) -> None:
    """Runs ticks until `stopping`; whatever a tick or a callback raises ends the loop."""
    monotonic_ns, spin_until, notes = backend.clock.monotonic_ns, backend.spin_until, stats.notes
    rate = Rate(frequency_hz, monotonic_ns())
    deadline_ns = rate.deadline_ns
    while True:
        spin_until(deadline_ns, stopping)
        if stopping():
            return
        start_ns = monotonic_ns()
        tick()
        end_ns = monotonic_ns()
        deadline_ns = rate.advance(end_ns)
        # Counting is spread out here, not called: after a sleep the processor is cold, and
        # every call costs a microsecond or more.
        stats.overruns = rate.skipped
        notes.append(start_ns)
        notes.append(end_ns)
        if len(notes) >= LoopStats.MANY_NOTES:
            stats.digest()
