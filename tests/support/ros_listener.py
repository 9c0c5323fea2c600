"""A plain rclpy subscriber of Imu messages, a process of its own that knows nothing of rosbase.

It takes the topic and the depth, and prints each message as a line of JSON.
"""

import json
import sys
from typing import Any

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import Imu


def _numbers(vector: Any) -> list[float]:
    return [getattr(vector, axis) for axis in ("x", "y", "z", "w") if hasattr(vector, axis)]


def _print(message: Any) -> None:
    line = {
        "stamp": [message.header.stamp.sec, message.header.stamp.nanosec],
        "frame_id": message.header.frame_id,
        "orientation": _numbers(message.orientation),
        "angular_velocity": _numbers(message.angular_velocity),
        "linear_acceleration": _numbers(message.linear_acceleration),
        "orientation_covariance": message.orientation_covariance.tolist(),
    }
    print(json.dumps(line), flush=True)


def main() -> None:
    """Listens until it is killed."""
    rclpy.init()
    node: Any = Node("listener")
    node.create_subscription(Imu, sys.argv[1], _print, int(sys.argv[2]))
    rclpy.spin(node)


if __name__ == "__main__":
    main()
