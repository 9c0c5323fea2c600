"""A service, and a client that calls it, as one gets them from rclpy.

It takes `service` or `client`, the rate of the calls in hertz (0 for one after the other), how many
to make first, and how many then to measure. It prints what `CountedCalls` says.
"""

import os
import sys
import threading
import time
from typing import Any

import rclpy
from std_srvs.srv import SetBool

from benchmarks.rig.counted_calls import CountedCalls


def serve(node: Any, counted: CountedCalls) -> None:
    """Answers until it is ended."""

    def answer(request: Any, response: Any) -> Any:
        counted.count()
        response.success = request.data
        return response

    node.create_service(SetBool, "flip", answer)
    rclpy.spin(node)


def call(node: Any, counted: CountedCalls, rate_hz: float) -> None:
    """Calls while another thread spins.

    Not with `spin_until_future_complete`, as the tutorial of ROS does: each use of it makes the
    next one on the same executor slower, by some 20 us (rclpy 7.1).
    """
    client = node.create_client(SetBool, "flip")
    client.wait_for_service()
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()

    def call_once() -> None:
        assert client.call(SetBool.Request(data=True)).success

    period_s = 1 / rate_hz if rate_hz else 0.0
    deadline_s = time.monotonic()
    while not counted.are_done:
        deadline_s += period_s
        time.sleep(max(0.0, deadline_s - time.monotonic()))
        counted.make(call_once)
    # Without waiting for the thread.
    os._exit(0)


if __name__ == "__main__":
    end, rate, warm_up, calls = sys.argv[1:]
    rclpy.init()
    made, numbers = rclpy.create_node(end), CountedCalls(int(warm_up), int(calls))
    if end == "service":
        serve(made, numbers)
    else:
        call(made, numbers, float(rate))
