"""Loops of a fixed rate, each a process of its own, and the table of what they cost."""

import statistics
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from attrs import frozen

from benchmarks.rig.turns import ratio
from rosbase import BaseHandlers, BaseManager

BY_HAND = Path(__file__).parent.parent / "by_hand"
SECONDS = 3
# DDS takes some 30 ms of CPU for a start.
WARM_UP_S = 1


class Handlers(BaseHandlers):
    """Notes when it is called, and prints as `by_hand/bare_loop.py` does."""

    def __init__(
        self, manager: Any = None, *args: Any, warm_up: int = 0, ticks: int = 0, **kwargs: Any
    ) -> None:
        super().__init__(manager, *args, **kwargs)
        self.starts: list[int] = []
        self.warm_up, self.all = warm_up, warm_up + ticks

    def handle(self) -> None:
        self.starts.append(time.monotonic_ns())
        if len(self.starts) == self.warm_up:
            self.before_ns = time.process_time_ns()
        if len(self.starts) == self.all:
            print(time.process_time_ns() - self.before_ns, *self.starts[self.warm_up :])
            self.manager.request_stop()


def run_manager(backend: str, timing: Any, rate_hz: str, warm_up: str, ticks: str) -> None:
    """What the loops by hand do in their own files."""
    BaseManager(
        "loop",
        handlers_class=Handlers,
        node_freq_hz=float(rate_hz),
        backend=backend,
        timing=timing,
        warm_up=int(warm_up),
        ticks=int(ticks),
    ).start_main_loop_timer()


def manager_row(backend: str, timing: str) -> list[str]:
    """The command of a row that is a manager."""
    return [sys.executable, __file__, backend, timing]


def row_by_hand(name: str) -> list[str]:
    """The command of a row that is a file in `by_hand`."""
    return [sys.executable, str(BY_HAND / name)]


@frozen
class Turn:
    """What one turn of one row measured."""

    cpu_us: float
    """CPU of the process for each tick; all threads, the system's part included."""
    p50_us: float
    """Of the error of the period."""
    p99_us: float
    lost: int
    """Periods without a tick. A machine that stalls for two periods leaves one, whoever loops."""


def measure(command: Sequence[str], rate_hz: int) -> Turn:
    """One turn."""
    numbers = (rate_hz, rate_hz * WARM_UP_S, rate_hz * SECONDS)
    out = subprocess.run(
        [*command, *map(str, numbers)], capture_output=True, text=True, check=True
    ).stdout
    return read_turn(out, rate_hz)


def read_turn(out: str, rate_hz: int) -> Turn:
    """What a loop has printed."""
    # By far the longest line: HORUS writes some of its own.
    cpu_ns, *starts = map(int, max(out.splitlines(), key=len).split())
    period_ns = 1_000_000_000 // rate_hz
    errors = sorted(abs(b - a - period_ns) / 1000 for a, b in pairwise(starts))
    lost = sum(max(0, (b - a + period_ns // 2) // period_ns - 1) for a, b in pairwise(starts))
    caught_up = sum(b - a < period_ns // 2 for a, b in pairwise(starts))
    return Turn(
        cpu_us=cpu_ns / 1000 / (len(starts) - 1),
        p50_us=errors[len(errors) // 2],
        p99_us=errors[len(errors) * 99 // 100],
        lost=max(0, lost - caught_up),
    )


def print_table(title: str, rows: Mapping[str, Sequence[Turn]], to: str) -> None:
    """Prints medians, and ratios to the row `to`."""
    head = (
        f"{'us CPU/tick':>14}{'of it':>8}{'us p50 error':>14}{'of it':>8}{'us p99':>10}{'lost':>6}"
    )
    print(f"\n{title}; ratios to {to}\n{'':24}{head}")
    for name, turns in rows.items():
        cells = ""
        for figure in ("cpu_us", "p50_us"):
            figures = {row: [getattr(t, figure) for t in its] for row, its in rows.items()}
            median = statistics.median(figures[name])
            cells += f"{median:14.1f}{ratio(figures, name, to):8.2f}"
        p99, lost = (statistics.median(getattr(t, f) for t in turns) for f in ("p99_us", "lost"))
        print(f"{name:24}{cells}{p99:10.0f}{lost:6.0f}")


if __name__ == "__main__":
    run_manager(*sys.argv[1:])
