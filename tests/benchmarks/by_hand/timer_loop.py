"""A fixed rate as one gets it from rclpy: a timer, and `rclpy.spin`. Prints its ticks.

It takes the rate in hertz, how many ticks to run first, and how many then to measure; prints the
CPU in nanoseconds that those took, and when each began on the monotonic clock.
"""

import sys
import time

import rclpy
from rclpy.node import Node


class TimerLoop(Node):  # type: ignore[misc]  # rclpy is Any
    """Notes when it is called."""

    def __init__(self, rate_hz: float, warm_up: int, ticks: int) -> None:
        super().__init__("loop")
        self.starts: list[int] = []
        self.warm_up, self.all = warm_up, warm_up + ticks
        self.create_timer(1.0 / rate_hz, self.tick)

    def tick(self) -> None:
        self.starts.append(time.monotonic_ns())
        if len(self.starts) == self.warm_up:
            self.before_ns = time.process_time_ns()
        if len(self.starts) == self.all:
            print(time.process_time_ns() - self.before_ns, *self.starts[self.warm_up :])
            raise SystemExit


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(TimerLoop(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])))
