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
    monotonic_ns = backend.clock.monotonic_ns
    rate = Rate(frequency_hz, monotonic_ns())
    while not stopping():
        backend.spin_until(rate.deadline_ns, stopping)
        if stopping():
            return
        start_ns = monotonic_ns()
        tick()
        end_ns = monotonic_ns()
        stats.record(start_ns, end_ns, rate.advance(end_ns))
