"""The reader as one writes it by hand: read a line, `json.loads`, fill a message, publish.

It takes the way to read, `naive` or `careful`, and the path of the port.
"""

import json
import sys
import threading
from typing import Any

import rclpy
import serial
from rclpy.node import Node
from sensor_msgs.msg import Imu


class Reader(Node):  # type: ignore[misc]  # rclpy is Any
    """Publishes each line of a serial port."""

    def __init__(self, way: str, path: str) -> None:
        super().__init__("reader")
        self.publisher: Any = self.create_publisher(Imu, "imu/data", 10_000)
        self.port = serial.Serial(path, 115_200, timeout=5)
        threading.Thread(target=getattr(self, f"read_{way}"), daemon=True).start()

    def read_naive(self) -> None:
        while True:
            self.publish(self.port.readline())

    def read_careful(self) -> None:
        rest = b""
        while True:
            *lines, rest = (rest + self.port.read(max(1, self.port.in_waiting))).split(b"\n")
            for line in lines:
                self.publish(line)

    def publish(self, line: bytes) -> None:
        data = json.loads(line)
        message = Imu()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "imu_link"
        for quantity in ("orientation", "angular_velocity", "linear_acceleration"):
            for axis, value in data[quantity].items():
                setattr(getattr(message, quantity), axis, value)
        self.publisher.publish(message)


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Reader(sys.argv[1], sys.argv[2]))
