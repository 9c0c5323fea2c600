"""What the utilities cost: nanoseconds of a call, beside the same thing by hand.

`nox -s bench -- utils` runs it and prints a table. The cheapest of many turns counts, but for the
rows of a loop that sleeps between its calls, as a robot's does: there the median counts, because
the processor is cold after each sleep.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np

from rosbase import RosbaseLogger
from rosbase.utils import (
    CircularBuffer,
    VectorLPFilter,
    profile_latency,
    quat_rotate_inverse,
    quat_to_rpy,
)

TURNS, CALLS = 15, 10_000
SLEEPS, SLEEP_S = 600, 0.003
ROW = np.arange(45.0)
QUAT, VECTOR = (0.7, 0.1, -0.2, 0.6), (0.0, 0.0, -1.0)


class Measured:
    """A method that does nothing, with and without the decorator."""

    logger = RosbaseLogger("bench")

    @profile_latency(1e6, 1e6, log_interval_s=1e6)
    def profiled(self) -> None: ...

    @profile_latency(1e6, 1e6, log_interval_s=1e6, check_capture_latency=True)
    def profiled_with_age(self) -> None: ...

    def plain(self) -> None: ...


def history_by_hand() -> Callable[[], object]:
    """The usual history: shift all rows of the array at each step."""
    history = np.zeros((10, len(ROW)))

    def append() -> None:
        history[:-1] = history[1:].copy()
        history[-1] = ROW

    return append


def rotation_by_hand() -> object:
    """The usual formula, with arrays."""
    w, imaginary = QUAT[0], np.array(QUAT[1:])
    vector = np.array(VECTOR)
    a = vector * (2.0 * w * w - 1.0)
    b = np.cross(imaginary, vector) * w * 2.0
    c = imaginary * np.dot(imaginary, vector) * 2.0
    return a - b + c


def best_ns(call: Callable[[], object]) -> float:
    best = float("inf")
    for _ in range(TURNS):
        begun = time.process_time_ns()
        for _ in range(CALLS):
            call()
        best = min(best, (time.process_time_ns() - begun) / CALLS)
    return best


def cold_ns(call: Callable[[], object]) -> float:
    """The median cost of a call that follows a sleep."""
    costs = []
    for _ in range(SLEEPS):
        time.sleep(SLEEP_S)
        begun = time.perf_counter_ns()
        call()
        costs.append(time.perf_counter_ns() - begun)
    return statistics.median(costs)


def main() -> None:
    measured, buffer, smooth = Measured(), CircularBuffer(10), VectorLPFilter(0.005, 10.0, 45)
    array_quat, array_vector = np.array(QUAT), np.array(VECTOR)
    rows: dict[str, Callable[[], object]] = {
        "a plain method": measured.plain,
        "profile_latency": measured.profiled,
        "profile_latency, age of the stamp": measured.profiled_with_age,
        "CircularBuffer(10).append, 45 numbers": lambda: buffer.append(ROW),
        "  and .buffer": lambda: buffer.buffer,
        "  by hand": history_by_hand(),
        "VectorLPFilter.update, 45 numbers": lambda: smooth.update(ROW),
        "quat_rotate_inverse, tuples": lambda: quat_rotate_inverse(QUAT, VECTOR),
        "quat_rotate_inverse, arrays": lambda: quat_rotate_inverse(array_quat, array_vector),
        "  by hand, arrays ": rotation_by_hand,
        "quat_to_rpy, tuples": lambda: quat_to_rpy(QUAT),
    }
    for name, call in rows.items():
        print(f"{name:40}{best_ns(call):9.0f} ns")
    for name in ("a plain method", "profile_latency"):
        print(f"{'after a sleep: ' + name:40}{cold_ns(rows[name]):9.0f} ns")


if __name__ == "__main__":
    main()
