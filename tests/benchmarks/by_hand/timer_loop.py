"""A fixed rate as one gets it from rclpy: a timer, and `rclpy.spin`. Prints its ticks.

It takes the rate in hertz and how many ticks to run; prints the CPU in nanoseconds that they took,
and when each began on the monotonic clock.
"""

import sys
import time

import rclpy
from rclpy.node import Node


class TimerLoop(Node):  # type: ignore[misc]
    """Notes when it is called."""

    def __init__(self, rate_hz: float, ticks: int) -> None:
        super().__init__("loop")
        self.starts: list[int] = []
        self.ticks = ticks
        self.create_timer(1.0 / rate_hz, self.tick)

    def tick(self) -> None:
        self.starts.append(time.monotonic_ns())
        if len(self.starts) == 1:
            self.before_ns = time.process_time_ns()
        if len(self.starts) == self.ticks:
            print(time.process_time_ns() - self.before_ns, *self.starts)
            raise SystemExit


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(TimerLoop(float(sys.argv[1]), int(sys.argv[2])))
