"""Calls of a service on ROS 2: our client and our service, beside those of rclpy.

`nox -s bench -- ros2_services` runs it and prints a table for calls at a fixed rate, and one for
calls one after the other. Client and service are two processes. The rows take turns, and the
medians of the turns count; of ratios, those of the turn's own.

- rclpy: `client.call` beside a thread that spins; the service under `rclpy.spin`
- rosbase: `client.call` in `handle()`, so the CPU is that of the tick too; the service in a node
"""

import os
import random
import statistics
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from attrs import frozen

from benchmarks.rig.turns import ratio, take_turns

HERE = Path(__file__).parent
ROWS = {"rclpy": HERE / "by_hand/service_ends.py", "rosbase": HERE / "rig/service_ends.py"}
TURNS = 7
RATE_HZ = 200
CALLS = {RATE_HZ: 800, 0: 3000}
WARM_UP = 100
PATIENCE_S = 60.0


@frozen
class Turn:
    """What one turn of one row measured."""

    client_us: float
    """CPU of the client's process for each call; all threads, the system's part included."""
    service_us: float
    """CPU of the service's process."""
    p50_us: float
    """From the call to its answer."""
    p99_us: float


def measure(rate_hz: int, row: str) -> Turn:
    """One turn."""
    # Those of the turn before may not be gone yet.
    os.environ["ROS_DOMAIN_ID"] = str(random.SystemRandom().randint(1, 100))
    numbers = [str(number) for number in (rate_hz, WARM_UP, CALLS[rate_hz])]
    command = [sys.executable, str(ROWS[row])]
    with subprocess.Popen(
        [*command, "service", *numbers], stdout=subprocess.PIPE, text=True
    ) as service:
        try:
            client = subprocess.run(
                [*command, "client", *numbers],
                stdout=subprocess.PIPE,
                text=True,
                check=True,
                timeout=PATIENCE_S,
            )
            assert service.stdout is not None
            service_ns = int(service.stdout.readline())
        finally:
            service.kill()
    client_ns, *lasted_ns = map(int, client.stdout.split())
    lasted_ns.sort()
    return Turn(
        client_us=client_ns / 1000 / len(lasted_ns),
        service_us=service_ns / 1000 / len(lasted_ns),
        p50_us=lasted_ns[len(lasted_ns) // 2] / 1000,
        p99_us=lasted_ns[len(lasted_ns) * 99 // 100] / 1000,
    )


def print_table(title: str, rows: Mapping[str, Sequence[Turn]]) -> None:
    """Prints medians, and ratios to rclpy."""
    print(f"\n{title}; ratios to rclpy")
    heads = {"client_us": "us CPU client", "service_us": "us CPU service", "p50_us": "us p50"}
    print(f"{'':12}" + "".join(f"{head:>16}{'of it':>8}" for head in heads.values()), "   us p99")
    for name, turns in rows.items():
        cells = ""
        for figure in heads:
            figures = {row: [getattr(t, figure) for t in its] for row, its in rows.items()}
            cells += f"{statistics.median(figures[name]):16.0f}{ratio(figures, name, 'rclpy'):8.2f}"
        print(f"{name:12}{cells}{statistics.median(t.p99_us for t in turns):10.0f}")


def main() -> None:
    """Prints the tables."""
    os.environ |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    for rate_hz in CALLS:
        title = f"{rate_hz} calls a second" if rate_hz else "one call after the other"
        print_table(title, take_turns(partial(measure, rate_hz), ROWS, TURNS))


if __name__ == "__main__":
    main()
