"""The manager's loop on ROS 2 beside a timer of rclpy and a bare loop.

`nox -s bench` runs it and prints a table. Each row is a process of its own. The ratios are
what matters: machines are noisy, so the rows take turns, and the medians of the turns count; of
ratios, those of the turn's own.

- rclpy timer: `create_timer` and `rclpy.spin`
- manager: `BaseManager` on the backend `ros2`, with handlers that do the same
- bare loop: sleep until the next deadline, without ROS
"""

import os
import random
import statistics
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

from attrs import frozen

from rosbase import BaseHandlers, BaseManager

BY_HAND = Path(__file__).with_name("by_hand")
ROWS = {
    "rclpy timer": BY_HAND / "timer_loop.py",
    "manager": Path(__file__),
    "bare loop": BY_HAND / "bare_loop.py",
}
TURNS = 9
RATES_HZ = (200, 1000)
SECONDS = 3
# DDS takes some 30 ms of CPU for a start.
WARM_UP_S = 1


class Handlers(BaseHandlers):
    """Notes when it is called."""

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


def run_manager(rate_hz: float, warm_up: int, ticks: int) -> None:
    """What a row of the other two does in its own file."""
    manager = BaseManager(
        "loop",
        handlers_class=Handlers,
        node_freq_hz=rate_hz,
        backend="ros2",
        warm_up=warm_up,
        ticks=ticks,
    )
    manager.start_main_loop_timer()


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


def measure(name: str, rate_hz: int) -> Turn:
    """One turn."""
    numbers = (rate_hz, rate_hz * WARM_UP_S, rate_hz * SECONDS)
    command = [sys.executable, str(ROWS[name]), *map(str, numbers)]
    out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    cpu_ns, *starts = map(int, out.split())
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


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(random.SystemRandom().randint(1, 100)),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    for rate_hz in RATES_HZ:
        rows: dict[str, list[Turn]] = {name: [] for name in ROWS}
        for number in range(TURNS):
            for name in rows if number % 2 else reversed(rows):
                rows[name].append(measure(name, rate_hz))
        print(
            f"\n{rate_hz} Hz\n{'':12}{'us CPU/tick':>14}{'of timer':>10}"
            f"{'us p50 error':>14}{'of timer':>10}{'us p99':>10}{'lost':>6}"
        )
        for name, turns in rows.items():
            cells = ""
            for figure in ("cpu_us", "p50_us"):
                figures = [getattr(turn, figure) for turn in turns]
                of_timer = statistics.median(
                    mine / getattr(timer, figure)
                    for mine, timer in zip(figures, rows["rclpy timer"], strict=True)
                )
                cells += f"{statistics.median(figures):14.1f}{of_timer:10.2f}"
            p99 = statistics.median(turn.p99_us for turn in turns)
            print(f"{name:12}{cells}{p99:10.0f}{statistics.median(t.lost for t in turns):6.0f}")


if __name__ == "__main__":
    if len(sys.argv) == 4:
        run_manager(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
    else:
        main()
