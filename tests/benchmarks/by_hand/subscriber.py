"""A plain subscriber of `imu/data`: notes when each sample arrived, and prints it at the end.

It reads commands from stdin: `count` prints how many samples have arrived; `end` prints a line
for each, with the x of its angular velocity and the monotonic nanoseconds of its arrival.
"""

import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu

ARRIVED: list[tuple[bytes, int]] = []


def arrive(data: bytes) -> None:
    ARRIVED.append((data, time.monotonic_ns()))


def answer() -> None:
    for command in sys.stdin:
        if command == "count\n":
            print(len(ARRIVED), flush=True)
        else:
            break
    for data, arrival_ns in ARRIVED:
        print(deserialize_message(data, Imu).angular_velocity.x, arrival_ns)
    print("end", flush=True)


def main() -> None:
    rclpy.init()
    node: Any = rclpy.create_node("subscriber")
    # Raw, and events: so that the subscriber is not what is measured.
    node.create_subscription(Imu, "imu/data", arrive, 100_000, raw=True)
    executor: Any = EventsExecutor()
    executor.add_node(node)
    thread = threading.Thread(target=answer)
    thread.start()
    while thread.is_alive():
        executor.spin_once(timeout_sec=0.1)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
